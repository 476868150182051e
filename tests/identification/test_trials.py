"""Sea trials: reading of fixes, the current under a turn, measures with their uncertainties."""

from __future__ import annotations

import csv
import json
import math
import re
from dataclasses import dataclass, replace

import numpy as np
import pytest

import pmmkit as pk
from pmmkit import save_campaign
from pmmkit.base import CampaignError, DataError
from pmmkit.campaigns.samples.loading import geographic, local_metres
from pmmkit.cli import main
from pmmkit.identification import evaluate_trials
from pmmkit.identification.trials.circle import fit_circle
from pmmkit.identification.trials.current import Current, mean_current
from pmmkit.identification.trials.orders import rudder_orders
from pmmkit.imo.verdict import reached


def evaluate(run, campaign, *, order=None, current=None):
    given = None if order is None else {run.id: order}
    return evaluate_trials(campaign, runs=[run.id], order=given, current=current)[0]


A, F = 6378137.0, 1 / 298.257223563
ORIGIN = (36.2, -6.4)
SPEED = 7.97
CURRENT = (0.8, 50.0)  # m/s, degrees it flows to, from north
HEADING = 30.0
ANTENNA = (-110.0, 4.0)


def vincenty(north, east, origin=ORIGIN):
    """Latitude and longitude at the end of geodesics: Vincenty's direct formula (1975)."""
    b = A * (1 - F)
    s, azimuth = np.hypot(north, east), np.arctan2(east, north)
    u1 = math.atan((1 - F) * math.tan(math.radians(origin[0])))
    sigma1 = np.arctan2(math.tan(u1), np.cos(azimuth))
    sin_a = math.cos(u1) * np.sin(azimuth)
    cos2_a = 1 - sin_a**2
    uu = cos2_a * (A**2 - b**2) / b**2
    big_a = 1 + uu / 16384 * (4096 + uu * (-768 + uu * (320 - 175 * uu)))
    big_b = uu / 1024 * (256 + uu * (-128 + uu * (74 - 47 * uu)))
    sigma = s / (b * big_a)
    for _ in range(30):
        m = np.cos(2 * sigma1 + sigma)
        sigma = s / (b * big_a) + big_b * np.sin(sigma) * (
            m
            + big_b
            / 4
            * (
                np.cos(sigma) * (2 * m**2 - 1)
                - big_b / 6 * m * (4 * np.sin(sigma) ** 2 - 3) * (4 * m**2 - 3)
            )
        )
    m = np.cos(2 * sigma1 + sigma)
    su, cu, ss, cs, ca = math.sin(u1), math.cos(u1), np.sin(sigma), np.cos(sigma), np.cos(azimuth)
    lat = np.arctan2(su * cs + cu * ss * ca, (1 - F) * np.hypot(sin_a, su * ss - cu * cs * ca))
    lam = np.arctan2(ss * np.sin(azimuth), cu * cs - su * ss * ca)
    c = F / 16 * cos2_a * (4 + F * (4 - 3 * cos2_a))
    turned = lam - (1 - c) * F * sin_a * (sigma + c * ss * (m + c * cs * (2 * m**2 - 1)))
    return np.degrees(lat), origin[1] + np.degrees(turned)


@dataclass(frozen=True)
class Logger:
    """How a run was recorded."""

    seed: int = 0
    slow: float = 1.2
    fast: float = 0.4
    time: float = 60.0
    digits: int = 5
    heading_noise: float = 0.2
    before: float = 120.0
    after: float = 150.0
    antenna: tuple[float, float] = ANTENNA
    wind: tuple[float, float] = (6.0, 300.0)


def recorded(track, logger, *, current=CURRENT, heading=HEADING):
    """Columns of a logger at 1 Hz: what a bridge would have written."""
    rng = np.random.default_rng(logger.seed)
    end = track.t[-1] + (logger.after if track.manoeuvre == "stopping" else 0.0)
    t = np.arange(-math.floor(logger.before), math.floor(end) + 1.0)
    t = t + 0.37  # the order lies between two samples
    t = t[(t > -logger.before) & (t < end)]
    before, inside = t < 0, np.clip(t, 0, track.t[-1])
    ahead = np.where(before, track.speed * t, np.interp(inside, track.t, track.x))
    aside = np.where(before, 0.0, np.interp(inside, track.t, track.y))
    psi = np.where(before, 0.0, np.interp(inside, track.t, track.psi))
    late = np.maximum(t - track.t[-1], 0.0)
    if late.any():
        slowing = (track.u[-1] - track.u[-3]) / (track.t[-1] - track.t[-3])
        way = 0.5 * slowing * late**2
        ahead, aside = ahead + way * np.cos(psi), aside + way * np.sin(psi)
    turn, to = math.radians(heading), math.radians(current[1])
    north = ahead * math.cos(turn) - aside * math.sin(turn) + current[0] * math.cos(to) * t
    east = ahead * math.sin(turn) + aside * math.cos(turn) + current[0] * math.sin(to) * t
    compass = psi + turn
    forward, starboard = logger.antenna
    vn, ve = np.gradient(north, t), np.gradient(east, t)
    north = north + forward * np.cos(compass) - starboard * np.sin(compass)
    east = east + forward * np.sin(compass) + starboard * np.cos(compass)
    keep = math.exp(-1 / logger.time)
    drift = rng.normal(size=(2, len(t)))
    for i in range(1, len(t)):
        drift[:, i] = keep * drift[:, i - 1] + math.sqrt(1 - keep**2) * drift[:, i]
    noise = logger.slow * drift + logger.fast * rng.normal(size=(2, len(t)))
    lat, lon = vincenty(north + noise[0], east + noise[1])
    speed, angle = logger.wind[0], math.radians(logger.wind[1] + 180.0)
    blow_n, blow_e = speed * math.cos(angle) - vn, speed * math.sin(angle) - ve
    off = np.degrees(np.arctan2(-blow_e, -blow_n) - compass)
    measured = np.degrees(compass) + logger.heading_noise * rng.normal(size=len(t))
    return {
        "t": t + 1000.0,
        "lat": lat.round(logger.digits),
        "lon": lon.round(logger.digits),
        "heading": (measured % 360.0).round(1),
        "SOG": (np.hypot(vn, ve) * 3600 / 1852).round(1),
        "COG": (np.degrees(np.arctan2(ve, vn)) % 360.0).round(0),
        "rudder": np.degrees(np.where(before, 0.0, np.interp(inside, track.t, track.delta))).round(
            1
        ),
        "RPM": (60 * np.where(before, track.n[0], np.interp(inside, track.t, track.n))).round(1),
        "wind": np.hypot(blow_n, blow_e).round(1),
        "wind_from": ((off + 180.0) % 360.0 - 180.0).round(0),
    }


COLUMNS = """
[columns]
psi = { name = "heading", unit = "deg" }
sog = { name = "SOG", unit = "kn" }
cog = { name = "COG", unit = "deg" }
delta = { name = "rudder", unit = "deg" }
n = { name = "RPM", unit = "rpm" }
wind_speed = "wind"
wind_direction = { name = "wind_from", unit = "deg" }
"""


def write_rows(path, columns):
    names = list(columns)
    lines = [",".join(names)]
    for row in zip(*columns.values(), strict=True):
        lines.append(",".join("" if x != x else repr(float(x)) for x in row))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def write_campaign(folder, runs, *, ship="kvlcc2", trial="", top="", source=""):
    """A folder with a campaign of such runs: id -> (settings in TOML, columns)."""
    folder.mkdir(parents=True, exist_ok=True)
    text = f'[campaign]\ntitle = "Trial"\nkind = "free-running"\n{top}\n[ship]\nname = "{ship}"\n'
    text += f"[water]\ndepth = 200.0\n{source}\n[trial]\nantenna_x = {ANTENNA[0]}\n"
    text += f"antenna_y = {ANTENNA[1]}\n{trial}\n{COLUMNS}\n"
    for name, (settings, columns) in runs.items():
        write_rows(folder / f"{name}.csv", columns)
        text += f'[[runs]]\nid = "{name}"\nfile = "{name}.csv"\nspeed = {SPEED}\n{settings}\n'
    (folder / "campaign.toml").write_text(text, encoding="utf-8")
    return pk.open_campaign(folder)


TURN = 'test = "turning"\nrudder_deg = 35'


@pytest.fixture(scope="module")
def turn():
    return pk.simulate("kvlcc2", "turning", rudder_deg=35, speed=SPEED, dt=0.5)


@pytest.fixture(scope="module")
def port_turn():
    return pk.simulate("kvlcc2", "turning", rudder_deg=-35, speed=SPEED, dt=0.5)


@pytest.fixture(scope="module")
def stop():
    return pk.simulate("kvlcc2", "stopping", speed=SPEED, dt=0.5)


@pytest.fixture(scope="module")
def zigzag():
    return pk.simulate("kvlcc2", "zigzag", rudder_deg=10, switch_deg=10, speed=SPEED, dt=0.5)


STOP = 'test = "stopping"'
ZIGZAG = 'test = "zigzag"\nrudder_deg = 10\nswitch_deg = 10'
SEEDS = 40


@pytest.fixture(scope="module")
def many(turn, stop, zigzag, tmp_path_factory):
    """The same trial recorded 40 times."""
    folder = tmp_path_factory.mktemp("many")
    found = []
    for seed in range(SEEDS):
        runs = {
            "T": (TURN, recorded(turn, Logger(seed=seed))),
            "S": (STOP, recorded(stop, Logger(seed=1000 + seed), heading=200.0)),
            "Z": (ZIGZAG, recorded(zigzag, Logger(seed=2000 + seed), heading=350.0)),
        }
        found.append(evaluate_trials(write_campaign(folder / str(seed), runs)))
    return found


@pytest.fixture(scope="module")
def folder(turn, port_turn, stop, zigzag, tmp_path_factory):
    path = tmp_path_factory.mktemp("trial") / "trial"
    port = 'test = "turning"\nrudder_deg = -35'
    write_campaign(
        path,
        {
            "T1": (TURN, recorded(turn, Logger())),
            "T2": (port, recorded(port_turn, Logger(seed=1), heading=120.0)),
            "S": (STOP, recorded(stop, Logger(seed=2), heading=200.0)),
            "Z": (ZIGZAG, recorded(zigzag, Logger(seed=3))),
        },
    )
    return path


# Reading


@pytest.mark.parametrize("origin", [(0.0, 10.0), (36.2, -6.4), (-62.0, 179.995), (70.0, -179.99)])
def test_latitudes_become_metres(origin):
    rng = np.random.default_rng(3)
    north, east = rng.uniform(-9000, 9000, (2, 200))
    lat, lon = vincenty(north, east, origin)
    lon = (lon + 180.0) % 360.0 - 180.0
    x, y = local_metres(lat, lon, origin)
    np.testing.assert_allclose(x, north, atol=0.01)
    np.testing.assert_allclose(y, east, atol=0.01)
    back = geographic(x, y, origin)
    np.testing.assert_allclose(back[0], lat, atol=1e-9)
    np.testing.assert_allclose((back[1] - lon + 180.0) % 360.0, 180.0, atol=1e-9)


@pytest.mark.slow
def test_a_run_is_read_in_metres_midship_and_si(turn, tmp_path):
    logger = Logger(slow=0.0, fast=0.0, heading_noise=0.0, digits=9)
    columns = recorded(turn, logger)
    columns["heading"] = columns["heading"] % 360.0
    campaign = write_campaign(tmp_path, {"T": (TURN, columns)})
    data = campaign["T"].data
    t = data["t"].values - 1000.0
    ahead = np.where(t < 0, SPEED * t, np.interp(t, turn.t, turn.x))
    aside = np.where(t < 0, 0.0, np.interp(t, turn.t, turn.y))
    turned, to = math.radians(HEADING), math.radians(CURRENT[1])
    north = ahead * math.cos(turned) - aside * math.sin(turned) + CURRENT[0] * math.cos(to) * t
    east = ahead * math.sin(turned) + aside * math.cos(turned) + CURRENT[0] * math.sin(to) * t
    away_x, away_y = data["x"].values - north, data["y"].values - east
    # The heading is written to 0.1 degrees: 110 m of lever make 0.1 m of it.
    assert np.ptp(away_x) < 0.25
    assert np.ptp(away_y) < 0.25
    assert data["x"].attrs["units"] == "m"
    assert data["psi"].attrs["units"] == "rad"
    assert float(data["sog"][0]) == pytest.approx(8.7, abs=0.1)
    assert float(data["n"][0]) == pytest.approx(turn.n[0], abs=0.01)
    assert float(data["delta"].max()) == pytest.approx(math.radians(35.0), abs=1e-3)
    said = data.attrs["conversions"]
    assert "WGS84" in said
    assert "110 m forward" in said
    pk.save_campaign(campaign, tmp_path / "saved.h5")
    again = pk.load_campaign(tmp_path / "saved.h5")
    np.testing.assert_array_equal(again["T"].data["x"].values, data["x"].values)
    assert again.trial == campaign.trial


@pytest.mark.slow
def test_axes_of_other_channels_leave_the_compass_alone(turn, tmp_path):
    columns = recorded(turn, Logger())
    plain = write_campaign(tmp_path / "a", {"T": (TURN, columns)})["T"].data
    columns = {**columns, "r": np.ones(len(columns["t"]))}
    turned = write_campaign(
        tmp_path / "b", {"T": (TURN, columns)}, source='[axes]\ny = "-y"\nz = "-z"'
    )["T"].data
    np.testing.assert_array_equal(turned["psi"].values, plain["psi"].values)
    np.testing.assert_array_equal(turned["y"].values, plain["y"].values)
    assert float(turned["r"][0]) == -1.0


@pytest.mark.slow
def test_what_is_wrong_with_a_position_is_said(turn, tmp_path):
    columns = recorded(turn, Logger())
    wild = {**columns, "lat": columns["lat"] * 100.0}
    with pytest.raises(CampaignError, match="degrees lie within"):
        _ = write_campaign(tmp_path / "a", {"T": (TURN, wild)})["T"].data
    unnamed = {"Latitude" if name == "lat" else name: x for name, x in columns.items()}
    with pytest.raises(CampaignError, match='lat = "Latitude"'):
        _ = write_campaign(tmp_path / "b", {"T": (TURN, unnamed)})["T"].data
    with pytest.raises(CampaignError, match="no run has the id 'T9'"):
        write_campaign(tmp_path / "c", {"T": (TURN, columns)}, trial="order = { T9 = 3.0 }")
    with pytest.raises(CampaignError, match="antena_x"):
        write_campaign(tmp_path / "d", {"T": (TURN, columns)}, trial="antena_x = 1.0")


@pytest.mark.slow
def test_a_wild_first_fix_is_not_the_origin(turn, tmp_path):
    columns = recorded(turn, Logger())
    columns["lat"][0] = columns["lon"][0] = 0.0
    columns["lat"][500] = columns["lon"][500] = 0.0
    campaign = write_campaign(tmp_path, {"T": (TURN, columns)})
    trial = evaluate(campaign["T"], campaign)
    assert trial.metrics["advance_L"] == pytest.approx(turn.metrics["advance_L"], abs=0.02)
    assert any("jump away" in note for note in trial.notes)


# Uncertainty


def within(values, truth, stds, times=2.0):
    return float(np.mean(np.abs(np.asarray(values) - truth) < times * np.asarray(stds)))


@pytest.mark.slow
@pytest.mark.parametrize("part", ["x", "y"])
def test_the_current_is_found_within_its_uncertainty(many, part):
    current = [trials[0].current for trials in many]
    to = math.radians(CURRENT[1])
    truth = CURRENT[0] * (math.cos(to) if part == "x" else math.sin(to))
    stds = [item.std[part == "y"] for item in current]
    assert within([getattr(item, part) for item in current], truth, stds) >= 0.88
    assert np.mean(stds) < 0.01


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        "advance",
        "transfer",
        "tactical_diameter",
        "steady_diameter",
        "speed_ratio",
        "time_90",
        "time_180",
        "steady_yaw_rate_deg_s",
    ],
)
def test_measures_of_a_turn_lie_within_their_uncertainty(many, turn, name):
    values = [trials[0].metrics[name] for trials in many]
    stds = [trials[0].std[name] for trials in many]
    assert within(values, turn.metrics[name], stds) >= 0.88
    if f"{name}_L" in turn.metrics:
        assert np.mean(stds) < 0.012 * 320.0


@pytest.mark.slow
@pytest.mark.parametrize("name", ["head_reach", "track_reach", "lateral_deviation", "time_to_stop"])
def test_measures_of_a_stop_lie_within_their_uncertainty(many, stop, name):
    values = [trials[1].metrics[name] for trials in many]
    stds = [trials[1].std[name] for trials in many]
    assert within(values, stop.metrics[name], stds) >= 0.85  # 34 of 40: 99 of 100 such tests
    assert np.mean(stds) < 7.0


@pytest.mark.slow
@pytest.mark.parametrize("number", [1, 2, 3])
def test_overshoots_lie_within_their_uncertainty(many, zigzag, number):
    name = f"overshoot_{number}_deg"
    values = [trials[2].metrics[name] for trials in many]
    stds = [trials[2].std[name] for trials in many]
    assert within(values, zigzag.metrics[name], stds) >= 0.88
    assert np.mean(stds) < 0.2


@pytest.mark.slow
def test_executes_and_initial_turning(many, zigzag):
    way = pk.simulate("kvlcc2", "initial_turning", rudder_deg=10, speed=SPEED)
    truth = way.metrics["initial_turning_distance"]
    found = [trials[2] for trials in many]
    values = [item.metrics["initial_turning_distance"] for item in found]
    stds = [item.std["initial_turning_distance"] for item in found]
    assert within(values, truth, stds) >= 0.88
    for name in ("time_execute_2", "time_execute_4", "reach", "period"):
        values = [item.metrics[name] for item in found]
        assert within(values, zigzag.metrics[name], [item.std[name] for item in found]) >= 0.88


@pytest.mark.slow
@pytest.mark.parametrize("place", [0, 1, 2])
def test_approach_wind_and_order(many, place):
    found = [trials[place] for trials in many]
    speeds, stds = [item.speed for item in found], [item.speed_std for item in found]
    assert within(speeds, SPEED, stds) >= 0.88
    assert np.ptp([item.order for item in found]) < 0.5
    assert found[0].order == pytest.approx(1000.0, abs=0.4)
    assert found[0].wind.speed == pytest.approx(6.0, abs=0.1)
    assert found[0].wind.direction_deg == pytest.approx(300.0, abs=1.0)


@pytest.mark.parametrize("ship", ["s175", "kcs", "mariner"])
@pytest.mark.parametrize("degrees", [360, 540])
def test_the_current_under_other_ships(ship, degrees):
    speed = {"s175": 9.0, "kcs": 12.35, "mariner": 7.7}[ship]
    track = pk.simulate(
        ship,
        "turning",
        rudder_deg=35,
        speed=speed,
        dt=1.0,
        current_speed=0.8,
        current_direction_deg=50.0,
    )
    count = int(np.searchsorted(track.psi, math.radians(degrees)))
    rng = np.random.default_rng(5)
    t, x, y, psi = (part[:count] for part in (track.t, track.x, track.y, track.psi))
    noise = 0.8 * rng.normal(size=(2, count))
    circle = fit_circle(t, x + noise[0], y + noise[1], psi, pace=track.L / speed)
    for value, truth, std in (
        (circle.current.x, 0.8 * math.cos(math.radians(50)), circle.current.std[0]),
        (circle.current.y, 0.8 * math.sin(math.radians(50)), circle.current.std[1]),
    ):
        assert abs(value - truth) < 3.5 * std
        assert std < 0.04
    assert circle.noise.fast == pytest.approx(0.8, abs=0.15)


@pytest.mark.slow
def test_without_a_current_none_is_found(turn, tmp_path):
    campaign = write_campaign(
        tmp_path, {"T": (TURN, recorded(turn, Logger(seed=9), current=(0.0, 0.0)))}
    )
    current = evaluate(campaign["T"], campaign).current
    assert abs(current.x) < 3 * current.std[0]
    assert abs(current.y) < 3 * current.std[1]
    known = evaluate(campaign["T"], campaign, current=(0.0, 0.0))
    assert known.current.origin == "as given"
    assert known.metrics["advance_L"] == pytest.approx(turn.metrics["advance_L"], abs=0.02)


# Damage


def rows_left_out(columns, left_out):
    keep = ~np.isin(np.arange(len(columns["t"])), left_out)
    return {name: values[keep] for name, values in columns.items()}


def emptied(columns, rows, names):
    out = {name: np.array(values, float) for name, values in columns.items()}
    for name in names:
        out[name][rows] = np.nan
    return out


def close(trial, turn, within=0.03):
    for name in ("advance_L", "transfer_L", "tactical_diameter_L"):
        assert trial.metrics[name] == pytest.approx(turn.metrics[name], abs=within)


@pytest.mark.slow
def test_gaps_empty_rows_and_repeated_times(turn, tmp_path):
    columns = rows_left_out(recorded(turn, Logger()), range(330, 370))
    columns = emptied(columns, [50, 51, 600], ["lat", "lon"])
    for values in columns.values():
        values[71] = values[70]
    campaign = write_campaign(tmp_path, {"T": (TURN, columns)}, source='[source]\nmissing = "drop"')
    text = (tmp_path / "T.csv").read_text().replace("\n", "\n\n", 3)
    (tmp_path / "T.csv").write_text(text)
    trial = evaluate(campaign["T"], campaign)
    close(trial, turn)
    assert any("1 gap in the record, the longest 41 s" in note for note in trial.notes)
    assert any("repeat a time" in note for note in trial.notes)
    checks = {item.check for item in pk.examine(campaign)}
    assert "time stamps" in checks
    refused = write_campaign(tmp_path / "b", {"T": (TURN, columns)})
    with pytest.raises(CampaignError, match="no value"):
        _ = refused["T"].data


@pytest.mark.slow
def test_a_crossing_within_a_gap_is_told_and_costs_certainty(turn, tmp_path):
    columns = recorded(turn, Logger())
    at = int(120 + turn.metrics["time_90"])
    gap = rows_left_out(columns, range(at - 15, at + 15))
    whole = write_campaign(tmp_path / "a", {"T": (TURN, columns)})
    torn = write_campaign(tmp_path / "b", {"T": (TURN, gap)})
    first, second = (evaluate(item["T"], item) for item in (whole, torn))
    assert any("passes 90° within a gap" in note for note in second.notes)
    assert second.std["advance"] > first.std["advance"]
    for name in ("advance", "transfer"):
        assert abs(second.metrics[name] - turn.metrics[name]) < 3 * second.std[name]


@pytest.mark.slow
def test_a_crossing_in_a_long_gap_lies_where_the_heading_leads(turn, tmp_path):
    """Two minutes, of which 180° are passed in the middle: not just before the end."""
    columns = recorded(turn, Logger())
    at = int(120 + turn.metrics["time_180"])
    torn = write_campaign(tmp_path, {"T": (TURN, rows_left_out(columns, range(at - 60, at + 60)))})
    trial = evaluate(torn["T"], torn)
    assert trial.metrics["time_180"] == pytest.approx(turn.metrics["time_180"], abs=3.0)
    off = abs(trial.metrics["tactical_diameter"] - turn.metrics["tactical_diameter"])
    assert off < 3 * trial.std["tactical_diameter"]


@pytest.mark.slow
def test_jumps_steps_and_averaged_headings(turn, tmp_path):
    columns = recorded(turn, Logger())
    columns["lat"][300] += 2e-3
    columns["lon"][640:643] -= 1e-3
    columns["heading"][410] = (columns["heading"][410] + 179.0) % 360.0
    columns["lat"][800:] += 3e-4
    campaign = write_campaign(tmp_path, {"T": (TURN, columns)})
    trial = evaluate(campaign["T"], campaign)
    close(trial, turn)
    said = " ".join(trial.notes)
    assert re.search("[45] positions that jump away", said)
    assert "1 single headings" in said
    assert "steps by 3" in said
    assert abs(trial.current.speed - CURRENT[0]) < 0.05
    findings = [item for item in pk.examine(campaign) if item.check == "positions"]
    assert {"spikes", "steps"} <= {name for item in findings for name in item.numbers}


@pytest.mark.slow
def test_coarse_digits_are_told_and_count(turn, tmp_path):
    fine, coarse = (
        write_campaign(tmp_path / str(digits), {"T": (TURN, recorded(turn, Logger(digits=digits)))})
        for digits in (6, 4)
    )
    assert any(
        item.check == "positions" and item.severity == "warning" for item in pk.examine(coarse)
    )
    first, second = (evaluate(item["T"], item) for item in (fine, coarse))
    assert second.std["advance"] > first.std["advance"]
    for name in ("advance", "transfer", "tactical_diameter"):
        assert abs(second.metrics[name] - turn.metrics[name]) < 3 * second.std[name]


@pytest.mark.slow
def test_knots_taken_for_metres_are_refused(turn, tmp_path, capsys):
    campaign = write_campaign(tmp_path, {"T": (TURN, recorded(turn, Logger()))})
    toml = tmp_path / "campaign.toml"
    toml.write_text(toml.read_text().replace('"SOG", unit = "kn"', '"SOG", unit = "m/s"'))
    assert main(["trial", str(tmp_path), "--out", str(tmp_path / "o")]) == 1
    assert "knots taken for m/s" in capsys.readouterr().err
    assert campaign["T"].data["sog"].max() < 10


@pytest.mark.slow
def test_half_a_circle_gives_no_current_and_says_so(turn, tmp_path):
    columns = recorded(turn, Logger())
    columns = rows_left_out(columns, range(120 + 400, len(columns["t"])))
    campaign = write_campaign(tmp_path, {"T": (TURN, columns)})
    trial = evaluate(campaign["T"], campaign)
    assert trial.current is None
    said = " ".join(trial.notes)
    assert "the current shows in a full circle" in said
    assert "over ground" in said
    assert "steady_diameter" not in trial.metrics
    assert trial.metrics["time_180"] == pytest.approx(turn.metrics["time_180"], abs=1.0)
    assert abs(trial.metrics["advance_L"] - turn.metrics["advance_L"]) > 0.1
    assert any("current is not known" in text for text in trial.verdicts[0].conditions)
    short = rows_left_out(columns, range(120 + 250, len(columns["t"])))
    campaign = write_campaign(tmp_path / "short", {"T": (TURN, short)})
    trial = evaluate(campaign["T"], campaign)
    assert math.isnan(trial.metrics["tactical_diameter"])
    assert [item.passed for item in trial.verdicts] == [True, None]
    assert any("not by 180°" in note for note in trial.notes)


@pytest.mark.slow
def test_the_turn_ends_where_the_rudder_is_eased(turn, tmp_path):
    columns = recorded(turn, Logger())
    whole = int(120 + np.interp(2 * math.pi, turn.psi, turn.t)) + 15
    columns["rudder"][whole:] = 0.0
    beyond = np.arange(len(columns["t"]) - whole - 20)
    columns["lat"][whole + 20 :] = columns["lat"][whole + 20] + 5e-5 * beyond
    campaign = write_campaign(tmp_path, {"T": (TURN, columns)})
    trial = evaluate(campaign["T"], campaign)
    close(trial, turn)
    assert abs(trial.current.speed - CURRENT[0]) < 4 * trial.current.speed_std


@pytest.mark.slow
def test_a_record_from_the_order_on_needs_its_instant(turn, tmp_path):
    columns = recorded(turn, Logger())
    late = rows_left_out(columns, range(140))
    campaign = write_campaign(tmp_path / "a", {"T": (TURN, late)})
    with pytest.raises(DataError, match="Give it: order under"):
        evaluate(campaign["T"], campaign)
    columns = {name: values for name, values in columns.items() if name != "rudder"}
    toml = "order = { T = 1000.0 }"
    text = COLUMNS.replace('delta = { name = "rudder", unit = "deg" }\n', "")
    campaign = write_campaign(tmp_path / "b", {"T": (TURN, columns)}, trial=toml)
    file = tmp_path / "b" / "campaign.toml"
    file.write_text(file.read_text().replace(COLUMNS, text))
    campaign = pk.open_campaign(tmp_path / "b")
    close(evaluate(campaign["T"], campaign), turn)
    with pytest.raises(DataError, match="outside the record"):
        evaluate(campaign["T"], campaign, order=5000.0)


@pytest.mark.slow
def test_requests_that_cannot_be_met(turn, stop, tmp_path):
    columns = recorded(turn, Logger())
    still = recorded(stop, Logger(), heading=200.0)
    cut = rows_left_out(still, range(400, len(still["t"])))
    no_engine = {name: values for name, values in still.items() if name != "RPM"}
    runs = {"T": (TURN, columns), "S": (STOP, cut)}
    campaign = write_campaign(tmp_path / "a", runs)
    with pytest.raises(DataError, match="T, S"):
        evaluate_trials(campaign, runs=["X"])
    (trial,) = evaluate_trials(campaign, runs=["S"])
    assert math.isnan(trial.metrics["track_reach"])
    assert any("still makes" in note for note in trial.notes)
    assert trial.verdicts[0].passed is None
    assert trial.current.origin == "turning circle T"
    port = {**columns, "rudder": -columns["rudder"]}
    wrong = write_campaign(tmp_path / "b", {"T": (TURN, port)})
    with pytest.raises(DataError, match="rudder_positive"):
        evaluate(wrong["T"], wrong)
    mended = write_campaign(tmp_path / "c", {"T": (TURN, port)}, top='rudder_positive = "port"')
    trial = evaluate(mended["T"], mended)
    assert trial.rudder_deg == pytest.approx(35.0, abs=0.1)
    text = COLUMNS.replace('n = { name = "RPM", unit = "rpm" }\n', "")
    write_campaign(tmp_path / "d", {"S": (STOP, no_engine)})
    file = tmp_path / "d" / "campaign.toml"
    file.write_text(file.read_text().replace(COLUMNS, text))
    campaign = pk.open_campaign(tmp_path / "d")
    with pytest.raises(DataError, match="no revolutions"):
        evaluate(campaign["S"], campaign)
    trial = evaluate(campaign["S"], campaign, order=1000.0, current=(0.514, 0.613))
    assert trial.metrics["track_reach"] == pytest.approx(stop.metrics["track_reach"], abs=20.0)


@pytest.mark.slow
def test_waterjets_are_judged_with_their_largest_angle(turn, tmp_path):
    columns = recorded(turn, Logger())
    columns["waterjet_deg"] = columns.pop("rudder") * 30.0 / 35.0
    write_campaign(tmp_path, {"T": (TURN.replace("35", "30"), columns)})
    file = tmp_path / "campaign.toml"
    file.write_text(file.read_text().replace('delta = { name = "rudder", unit = "deg" }\n', ""))
    campaign = pk.open_campaign(tmp_path)
    trial = evaluate(campaign["T"], campaign)
    assert trial.rudder_deg == pytest.approx(30.0, abs=0.1)
    assert "largest permissible; this is 30.0°" in trial.verdicts[0].conditions[0]


@pytest.mark.parametrize("rate", [2.34, 5.0, 40.0])
def test_the_order_is_where_the_ramp_begins(rate):
    errors, stds = [], []
    for seed in range(30):
        rng = np.random.default_rng(seed)
        begin = 50.0 + rng.uniform()
        t = np.arange(200.0)
        delta = np.clip(rate * (t - begin), 0.0, 35.0) + 0.1 * rng.normal(size=200)
        order = rudder_orders(t, np.radians(delta), math.radians(35.0))[0]
        errors.append(order.t - begin)
        stds.append(order.std)
    assert within(errors, 0.0, stds) >= 0.88


# Limits


def test_the_bulk_carrier_and_the_patrol_vessel_of_the_paper():
    from pmmkit.identification.trials.evaluate import verdicts_of

    for L, advance, diameter, rudder in (
        (170.0, 3.61, 2.99, -35.0),
        (170.0, 3.62, 3.08, 35.0),
        (44.0, 4.05, 4.10, -30.0),
        (44.0, 3.75, 3.24, 30.0),
    ):
        metrics = {"advance_L": advance, "tactical_diameter_L": diameter}
        found = verdicts_of("turning", metrics, {}, L=L, speed=7.7, rudder_deg=rudder)
        limits = [item.limit * L for item in found]
        assert limits == ([765.0, 850.0] if L == 170.0 else [198.0, 220.0])
        assert all(item.passed for item in found)
    (found,) = verdicts_of(
        "stopping",
        {"track_reach_L": 14.2},
        {"track_reach_L": 0.5},
        L=170.0,
        speed=7.25,
        rudder_deg=0.0,
    )
    assert (found.limit, found.passed) == (15.0, True)
    assert found.probability == pytest.approx(0.945, abs=0.001)


IMO = """
[imo]
full_load_draught = 20.8
draught_fore = 20.4
draught_aft = 20.8
sea_state = 5
speed_85 = 8.2
"""


def test_conditions_of_a_trial_as_recorded_and_as_stated(turn, tmp_path):
    run = {"T": (TURN, recorded(turn, Logger(wind=(12.0, 300.0))))}
    campaign = write_campaign(tmp_path, run, source=IMO)
    save_campaign(campaign, tmp_path / "saved.h5")
    campaign = pk.open_campaign(tmp_path / "saved.h5")  # what was stated is kept
    trial = evaluate_trials(campaign)[0]
    told = {item.name: item for item in trial.conditions}
    assert {name: item.met for name, item in told.items()} == {
        "length": True,
        "depth": True,
        "wind": False,
        "sea_state": False,
        "current": True,
        "draught": True,
        "approach": True,
        "rudder": True,
    }
    assert told["depth"].value == pytest.approx(200.0 / 20.6)
    assert told["wind"].shown.startswith("Beaufort 6, 12")
    assert told["approach"].value == pytest.approx(SPEED / 8.2, abs=0.005)
    sentences = " ".join(trial.verdicts[0].conditions)
    assert "calm weather" in sentences
    assert "sea state of at most 4" in sentences
    assert "85 %" not in sentences


def test_the_reversal_of_a_recorded_stop_stands_beside_its_verdict(stop, tmp_path):
    trial = evaluate_trials(write_campaign(tmp_path, {"S": (STOP, recorded(stop, Logger()))}))[0]
    engine = trial.verdicts[0].full_astern
    assert engine.measured
    assert engine.turns == pytest.approx(-0.7, abs=0.01)
    assert engine.reversal_s == pytest.approx(reached(stop.t, stop.n, stop.n[0], -0.7), abs=3.0)
    assert trial.revolutions == pytest.approx(stop.n[0], abs=0.01)
    assert engine.words in str(trial)


@pytest.mark.slow
def test_a_long_turn_tells_the_drift_of_equal_headings_too(tmp_path):
    track = pk.simulate(
        "kvlcc2", "turning", rudder_deg=35, speed=SPEED, dt=0.5, duration=1700.0, compiled=False
    )
    trial = evaluate_trials(write_campaign(tmp_path, {"T": (TURN, recorded(track, Logger()))}))[0]
    assert trial.turned_deg > 720.0
    drift = trial.equal_headings
    assert (drift.x, drift.y) == pytest.approx((trial.current.x, trial.current.y), abs=0.03)
    assert "drift of equal headings" in str(trial)


@pytest.mark.slow
def test_the_command_corrects_to_full_load_and_fills_the_form(folder, tmp_path, capsys):
    out = tmp_path / "o"
    order = ["trial", str(folder), "--run", "T1", "--run", "T2", "--out", str(out), "--json"]
    order += ["--run", "S"]
    assert main([*order, "--as-tried", "kvlcc2", "--full-load", "kvlcc2"]) == 0
    output = capsys.readouterr()
    rows = json.loads(output.out)["full_load"]
    assert {(row["run"], row["criterion"]) for row in rows} == {
        *((run, name) for run in ("T1", "T2") for name in ("advance", "tactical_diameter")),
        ("S", "track_reach"),
    }
    for row in rows:
        assert row["B"] == row["F"]
        assert row["R"] == pytest.approx(row["T"])
        # the stop was recorded with a propeller that is carried on astern from ahead
        assert abs(row["B_over_T_less_1"]) < (0.2 if row["run"] == "S" else 0.01)
    held = json.loads((out / "imo_form.json").read_text(encoding="utf-8"))
    assert held["basis"] == "corrected"
    assert held["verdict"].startswith("3 of 7 criteria met; 4 not judged")
    assert "What the propeller does astern is estimated" in output.err
    assert "R = T F/B" in output.err
    assert main([*order, "--as-tried", "kvlcc2"]) == 2


@pytest.mark.slow
def test_rows_hold_value_uncertainty_and_limit(many):
    rows = {row["measure"]: row for row in many[0][0].rows()}
    assert rows["advance_L"]["limit"] == 4.5
    assert rows["tactical_diameter_L"]["passed"] is True
    assert math.isnan(rows["transfer_L"]["limit"])
    assert rows["advance"]["unit"] == "m"
    assert many[0][2].to_pandas().query("measure == 'overshoot_1_deg'")["limit"].item() == 20.0


# Command


@pytest.mark.slow
def test_the_command_writes_measures_paths_and_figures(folder, tmp_path, capsys):
    out = tmp_path / "o"
    assert main(["trial", str(folder), "--out", str(out), "--json"]) == 0
    output = capsys.readouterr()
    content = json.loads(output.out)
    names = {file.name for file in out.iterdir()}
    assert set(content["files"]) == names
    assert names >= {"trial.csv", "trial.json", "trial_T1.svg", "trial_S.svg", "path_Z.csv"}
    assert "tactical diameter" in output.err
    assert "5 L  met" in output.err
    assert json.loads((out / "trial.json").read_text())["runs"] == content["runs"]
    with (out / "trial.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert {row["run"] for row in rows} == {"T1", "T2", "S", "Z"}
    by_run = {entry["run"]: entry for entry in content["runs"]}
    assert by_run["T2"]["rudder_deg"] == pytest.approx(-35.0, abs=0.1)
    assert by_run["S"]["current"]["origin"] == "turning circles T1, T2"
    assert by_run["S"]["current"]["speed"] == pytest.approx(CURRENT[0], abs=0.02)


@pytest.mark.slow
def test_the_command_for_one_run(folder, tmp_path, capsys):
    out = tmp_path / "o"
    asked = ["trial", str(folder), "--run", "S", "--order", "1000", "--out", str(out)]
    assert main(asked) == 0
    said = capsys.readouterr().out
    assert "track reach" in said
    assert "T1:" not in said
    assert {file.name for file in out.iterdir()} == {
        "trial.csv",
        "trial.json",
        "path_S.csv",
        "trial_S.svg",
        "imo_form.html",
        "imo_form.csv",
        "imo_form.json",
    }


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "status"),
    [
        (["--run", "X"], 1),
        (["--order", "3"], 2),
        (["--current", "1"], 2),
        (["--run", "S", "--order", "99999"], 1),
    ],
)
def test_requests_of_the_command_that_make_no_sense(folder, tmp_path, capsys, arguments, status):
    assert main(["trial", str(folder), *arguments, "--out", str(tmp_path / "o")]) == status
    assert "Traceback" not in capsys.readouterr().err
    assert not (tmp_path / "o").exists()


@pytest.mark.slow
@pytest.mark.parametrize("manoeuvre", ["turn", "zigzag"])
def test_a_trial_is_a_track_with_the_velocities_of_the_ship(manoeuvre, request, tmp_path):
    """Fixes that are off by 0.4 m each second leave 0.28 m/s in differences of neighbours."""
    track = request.getfixturevalue(manoeuvre)
    head = TURN if manoeuvre == "turn" else ZIGZAG
    columns = recorded(track, Logger(digits=8))
    campaign = write_campaign(tmp_path, {"T": (head, columns)})
    trial = evaluate(campaign["T"], campaign, current=mean_velocity(CURRENT))
    assert trial.t[0] < -100.0
    after = trial.ordered
    assert (after.t[0] >= 0.0, len(after.x_ground)) == (True, len(after))
    for name, bound in (("u", 0.05), ("v", 0.05), ("r", 5e-4)):
        off = getattr(after, name) - np.interp(after.t, track.t, getattr(track, name))
        assert math.sqrt(np.mean(off**2)) < bound
    assert np.isnan(after.phi).all()
    assert after.settings["rudder_deg"] == pytest.approx(track.rudder_deg, abs=0.1)


def mean_velocity(current):
    speed, to = current[0], math.radians(current[1])
    return speed * math.cos(to), speed * math.sin(to)


@pytest.mark.slow
def test_reversals_are_headings_without_the_noise_of_a_sample(zigzag, tmp_path):
    """The rudder is laid over at 10°; a compass is off by 0.2° in each sample."""
    found = []
    for seed in range(8):
        columns = recorded(zigzag, Logger(seed=seed))
        campaign = write_campaign(tmp_path / str(seed), {"Z": (ZIGZAG, columns)})
        found.append(evaluate(campaign["Z"], campaign).reversals)
    off = np.array(found) - 10.0
    assert off.shape == (8, 4)
    assert math.sqrt(np.mean(off**2)) < 0.12


@pytest.mark.slow
def test_a_trial_of_another_size_is_the_same_in_ship_lengths(many):
    trial = many[0][0]
    small = trial.resized(0.02 * trial.L, math.sqrt(0.02) * trial.speed)
    for name in ("advance_L", "tactical_diameter_L", "speed_ratio", "steady_drift_deg"):
        assert small.metrics[name] == trial.metrics[name]
        assert small.std[name] == trial.std[name]
    assert small.metrics["advance"] == pytest.approx(0.02 * trial.metrics["advance"])
    assert small.std["time_90"] == pytest.approx(math.sqrt(0.02) * trial.std["time_90"])
    np.testing.assert_allclose(small.r * small.t[-1], trial.r * trial.t[-1], rtol=1e-12)
    back = small.resized(trial.L, trial.speed)
    for name in ("t", "x", "y", "u", "v", "r", "x_ground"):
        np.testing.assert_allclose(getattr(back, name), getattr(trial, name), rtol=1e-12)


@pytest.mark.slow
def test_figures_show_both_paths(many):
    for trial in many[0]:
        figure = trial.plot()
        (axis,) = figure.axes
        assert "IMO at most" in axis.title.text
        labels = {line.label for line in axis.points}
        if trial.manoeuvre != "zigzag":
            assert {"as measured, over ground", "current removed"} <= labels
            assert axis.equal == "datalim"
    alone = replace(many[0][0], current=None)
    assert "current removed" not in {line.label for line in alone.plot().axes[0].points}


def test_a_mean_current_names_its_runs_in_full():
    one = Current(x=1.0, y=0.0, covariance=(0.01, 0.01, 0.0))
    assert mean_current({"TC 1": one, "TC 2": one}).origin == "turning circles TC 1, TC 2"
    assert mean_current({"TC 1": one}).origin == "turning circle TC 1"
