"""Tests in which the rudder swings while the hull is towed: what they tell, and slips about them.

The forces of the rudder are written out here term by term, apart from the package's regressors.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest
import small_campaign
from small_campaign import NOISE, RHO, L

import pmmkit as pk
from pmmkit.base import CampaignError, DataError
from pmmkit.cli import main
from pmmkit.intake import examine
from scripts.studies import kcs_shallow

SPEED, PERIOD = 1.0, 10.0
TRUTH = {"Xdd": -1e-3, "Yd": -3e-3, "Yddd": 2e-3, "Yvdd": 4e-3, "Nd": 1.4e-3, "Nddd": -0.9e-3}
MIDDLE = math.radians(2.0)
"""Angle about which a rudder swings that is not amidships."""


def record(
    *,
    drift: float = 0.0,
    amplitude: float = 35.0,
    middle: float = 0.0,
    lag: float = 0.0,
    measured: bool = True,
    port: bool = False,
    t: np.ndarray | None = None,
    seed: int = 1,
    noise: float = 1.0,
) -> dict[str, np.ndarray]:
    """Columns of a test: hull as in static drift, the rudder `lag` seconds behind its order."""
    t = np.arange(0.0, 6 * PERIOD, 0.05) if t is None else t
    beta, omega = math.radians(drift), 2 * math.pi / PERIOD
    # A steering gear of first order: late, and not all the way.
    reach = 1.0 / math.hypot(1.0, omega * lag)
    angle = omega * t - math.atan(omega * lag)
    delta = middle + reach * math.radians(amplitude) * np.sin(angle)
    still = np.zeros_like(t)
    u, v = SPEED * math.cos(beta) + still, -SPEED * math.sin(beta) + still
    found = small_campaign.forces(u, v, still, still, still, still)
    pressure = 0.5 * RHO * L**2 * SPEED**2
    side = TRUTH["Yd"] * delta + TRUTH["Yddd"] * delta**3 + TRUTH["Yvdd"] * v / SPEED * delta**2
    turn = TRUTH["Nd"] * delta + TRUTH["Nddd"] * delta**3
    found["X"] = found["X"] + pressure * TRUTH["Xdd"] * delta**2
    found["Y"] = found["Y"] + pressure * side
    found["N"] = found["N"] + pressure * L * turn
    generator = np.random.default_rng(seed)
    shown = {x: f + noise * NOISE[x] * generator.normal(size=len(t)) for x, f in found.items()}
    rudder = {"delta_deg": np.degrees(-delta if port else delta)} if measured else {}
    return {"t": t, **shown, **rudder}


def write(path: Path, columns: dict[str, np.ndarray]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    table = np.stack(list(columns.values()), axis=1)
    np.savetxt(path, table, fmt="%.8g", delimiter=",", header=",".join(columns), comments="")


def entry(name: str, keys: str, test: str = "harmonic_rudder") -> str:
    return (
        f'\n[[runs]]\nid = "{name}"\ntest = "{test}"\nfile = "runs/{name}.csv"\n'
        f"speed = {SPEED}\n{keys}\n"
    )


SWUNG = f"period = {PERIOD}\nrudder_amplitude_deg = 35.0"


def programme(folder: Path, drifts: Iterable[float] = (-8.0, 0.0, 8.0), **how) -> Path:
    """Static drift, sway and yaw tests of the small campaign, and rudders that swing."""
    small_campaign.write_campaign(folder)
    text = []
    for number, drift in enumerate(drifts):
        name = f"HR_{number}"
        write(folder / "runs" / f"{name}.csv", record(drift=drift, seed=number, **how))
        text.append(entry(name, f"{SWUNG}\ndrift_deg = {drift}"))
    file = folder / "campaign.toml"
    file.write_text(file.read_text(encoding="utf-8") + "".join(text), encoding="utf-8")
    return folder


def alone(folder: Path, keys: str, columns: dict[str, np.ndarray], test: str) -> Path:
    """A campaign of one test."""
    write(folder / "runs" / "one.csv", columns)
    text = small_campaign.HEAD + entry("one", keys, test)
    (folder / "campaign.toml").write_text(text, encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def swung(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return programme(tmp_path_factory.mktemp("swung"), lag=0.6)


def reduced(folder: Path) -> pk.DerivativeTable:
    return pk.reduce_campaign(pk.open_campaign(folder)).table


def told(folder: Path) -> list[tuple[str, str]]:
    """Severity and words of the check of settings against columns."""
    found = examine(pk.open_campaign(folder))
    return [(item.severity, item.message) for item in found if item.check == "set and measured"]


def agrees(table: pk.DerivativeTable, names: Iterable[str] = TRUTH) -> None:
    """All within four standard uncertainties, which are small beside the values."""
    value = dict(zip(table.names, table.value[0], strict=True))
    std = dict(zip(table.names, table.std[0], strict=True))
    for name in names:
        assert std[name] < 0.15 * abs(TRUTH[name]), name
        assert value[name] == pytest.approx(TRUTH[name], abs=4 * std[name]), name


def test_the_measured_rudder_counts_with_the_lag_of_its_gear(swung: Path) -> None:
    agrees(reduced(swung))


def test_without_a_column_the_rudder_goes_as_stated(tmp_path: Path) -> None:
    agrees(reduced(programme(tmp_path, measured=False)))


@pytest.mark.parametrize(("side", "degrees"), [("starboard", 37.0), ("port", -37.0)])
def test_the_phase_is_that_of_the_rudder(side: str, degrees: float, tmp_path: Path) -> None:
    keys = f"{SWUNG}\nphase_deg = 90.0\nrudder_deg = 2.0"
    file = alone(tmp_path, keys, record(measured=False), "harmonic_rudder") / "campaign.toml"
    head = f'kind = "captive"\nrudder_positive = "{side}"'
    file.write_text(file.read_text().replace('kind = "captive"', head), encoding="utf-8")
    motion = pk.open_campaign(tmp_path)["one"].nominal_motion([0.0, PERIOD / 2])
    assert math.degrees(motion.delta[0]) == pytest.approx(degrees)
    assert math.degrees(motion.delta[1]) == pytest.approx(-33.0 * math.copysign(1.0, degrees))


def test_a_lag_that_nobody_measured_is_in_the_derivatives(tmp_path: Path) -> None:
    table = reduced(programme(tmp_path, measured=False, lag=2.0, drifts=(0.0,)))
    # Of the swing cos² of the lag goes with the order: 1/(1 + (2 s times ω)²) is 0.39.
    assert table.value[0, table.index("Nd")] < 0.5 * TRUTH["Nd"]


def test_a_rudder_counted_to_port_and_about_another_angle(tmp_path: Path) -> None:
    folder = programme(tmp_path, lag=0.3, middle=MIDDLE, port=True)
    file = folder / "campaign.toml"
    head = 'kind = "captive"\nrudder_positive = "port"'
    file.write_text(file.read_text().replace('kind = "captive"', head), encoding="utf-8")
    agrees(reduced(folder))


def test_a_rudder_that_turns_the_hull_to_the_other_side_is_told(tmp_path: Path) -> None:
    campaign = pk.open_campaign(programme(tmp_path, port=True))
    found = [item for item in examine(campaign) if item.check == "signs"]
    assert [item.severity for item in found] == ["error", "error"]
    assert all('rudder_positive = "port"' in item.remedy for item in found)
    assert all(item.runs == ("HR_0", "HR_1", "HR_2") for item in found)
    reduction = pk.reduce_campaign(campaign, check=False)
    assert any("rudder" in fault for fault in reduction.verdict.faults)


def test_samples_that_are_not_even(tmp_path: Path) -> None:
    steps = np.random.default_rng(3).uniform(0.02, 0.09, 1100)
    agrees(reduced(programme(tmp_path, lag=0.6, t=np.cumsum(steps))))


def test_amplitude_decides_which_terms_are_asked_for(swung: Path) -> None:
    captive = pk.open_campaign(swung)
    assert {run.settings.rudder for run in captive} == {0.0}
    assert {"Yd", "Yddd", "Yvdd", "Xdd"} <= set(pk.reduce_campaign(captive).table.names)
    without = captive.with_(runs=tuple(x for x in captive.runs if x.test != "harmonic_rudder"))
    assert "Yd" not in pk.reduce_campaign(without).table.names


def test_the_harmonics_of_each_test_tell_it_too(swung: Path) -> None:
    agrees(pk.reduce_campaign(pk.open_campaign(swung), method="harmonics").table)


def test_forces_of_the_rudder_are_odd_and_even_harmonics(swung: Path) -> None:
    run = next(x for x in pk.reduce_campaign(pk.open_campaign(swung)).runs if x.run.id == "HR_1")
    side = dict(zip(run.labels, run.measured["Y"], strict=True))
    ahead = dict(zip(run.labels, run.measured["X"], strict=True))
    assert side["S1"] < 0 < ahead["C2"]
    assert abs(side["C1"]) < 0.05 * abs(side["S1"])


@pytest.mark.parametrize("port", [False, True])
def test_a_table_of_harmonics(port: bool, tmp_path: Path) -> None:
    rows = []
    for drift in (-8.0, -4.0, 0.0, 4.0, 8.0):
        one = record(drift=drift, t=np.arange(0.0, PERIOD, 0.01), noise=0.0)
        # Harmonics go with the rudder as it is counted.
        theta = 2 * math.pi * one["t"] / PERIOD + (math.pi if port else 0.0)
        row = {"drift_deg": drift}
        for channel in "XYN":
            row[f"{channel}_mean"] = one[channel].mean()
            for order in (1, 2, 3):
                row[f"{channel}_cos{order}"] = 2 * np.mean(one[channel] * np.cos(order * theta))
                row[f"{channel}_sin{order}"] = 2 * np.mean(one[channel] * np.sin(order * theta))
        rows.append(row)
    write(tmp_path / "harmonics.csv", {x: np.array([row[x] for row in rows]) for x in rows[0]})
    side = 'kind = "captive"\nrudder_positive = "port"' if port else 'kind = "captive"'
    text = small_campaign.HEAD.replace('kind = "captive"', side) + (
        f'[[tables]]\nid = "HR_{{row}}"\ntest = "harmonic_rudder"\nfile = "harmonics.csv"\n'
        f"speed = {SPEED}\n{SWUNG}\n"
    )
    (tmp_path / "campaign.toml").write_text(text, encoding="utf-8")
    table = reduced(tmp_path)
    for name in ("Xdd", "Yd", "Yddd", "Yvdd", "Nd", "Nddd"):
        assert table.value[0, table.index(name)] == pytest.approx(TRUTH[name], rel=0.01), name


def test_rows_of_one_cycle_tell_the_amplitude(tmp_path: Path) -> None:
    one = record(drift=4.0, t=np.arange(24) * PERIOD / 24, noise=0.0)
    write(tmp_path / "cycle.csv", {x: one[x] for x in ("X", "Y", "N", "delta_deg")})
    text = small_campaign.HEAD + (
        '[[tables]]\nid = "HR"\ntest = "harmonic_rudder"\nfile = "cycle.csv"\n'
        f'samples = "cycle"\nspeed = {SPEED}\nperiod = {PERIOD}\ndrift_deg = 4.0\n'
        'columns = { delta_deg = "delta_deg" }\n'
    )
    (tmp_path / "campaign.toml").write_text(text, encoding="utf-8")
    run = pk.open_campaign(tmp_path)["HR"]
    assert math.degrees(run.settings.rudder_amplitude) == pytest.approx(35.0, abs=0.01)


def test_check_report_and_diagnose_run_through(swung: Path, tmp_path: Path) -> None:
    assert told(swung) == []
    assert main(["check", str(swung)]) == 0
    assert main(["report", str(swung), "-o", str(tmp_path / "report.html")]) == 0
    assert main(["diagnose", "cubic", str(swung), "--out", str(tmp_path / "found")]) == 0
    assert main(["export", str(swung), "--to", "csv", "-o", str(tmp_path / "again")]) == 0
    again = pk.open_campaign(tmp_path / "again")["HR_2"]
    assert math.degrees(again.settings.largest_rudder) == pytest.approx(35.0)


@pytest.mark.parametrize("test", ["drift_rudder", "static_rudder", "static_drift"])
def test_a_rudder_that_swings_in_a_steady_test_is_an_error(test: str, tmp_path: Path) -> None:
    alone(tmp_path, "drift_deg = 4.0\nrudder_deg = 10.0", record(drift=4.0), test)
    severity, words = told(tmp_path)[0]
    assert severity == "error"
    assert "swings in 1 steady runs: in one by 35" in words


def test_play_and_a_rudder_put_over_and_back_are_no_swing(tmp_path: Path) -> None:
    columns = record(amplitude=2.0, middle=math.radians(10.0))
    assert told(alone(tmp_path, "rudder_deg = 10.0", columns, "static_rudder")) == []
    t = columns["t"]
    columns["delta_deg"] = np.where((t > 10.0) & (t < 50.0), 10.0, 0.0)
    assert told(alone(tmp_path, "rudder_deg = 10.0", columns, "static_rudder")) == []


def test_an_amplitude_that_was_not_made_is_told(tmp_path: Path) -> None:
    stated = f"period = {PERIOD}\nrudder_amplitude_deg = 30.0"
    ((severity, words),) = told(alone(tmp_path, stated, record(), "harmonic_rudder"))
    assert severity == "warning"
    assert "30" in words
    assert "35" in words


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        (f"period = {PERIOD}", "the amplitude of the rudder, rudder_amplitude_deg"),
        ("rudder_amplitude_deg = 35.0", "the period"),
        (f"period = {PERIOD}\nrudder_amplitude_deg = -5.0", "rudder_amplitude_deg"),
    ],
)
def test_what_is_missing_or_impossible_is_named(keys: str, words: str, tmp_path: Path) -> None:
    alone(tmp_path, keys, record(), "harmonic_rudder")
    with pytest.raises(CampaignError, match=words):
        pk.open_campaign(tmp_path)


def test_a_record_shorter_than_a_period_is_refused(tmp_path: Path) -> None:
    columns = record(t=np.arange(0.0, 0.7 * PERIOD, 0.05))
    campaign = pk.open_campaign(alone(tmp_path, SWUNG, columns, "harmonic_rudder"))
    with pytest.raises(DataError, match=r"period|cycle"):
        pk.reduce_campaign(campaign)


def test_one_value_of_the_rudder_is_not_its_swing(tmp_path: Path) -> None:
    run = pk.open_campaign(alone(tmp_path, SWUNG, record(), "harmonic_rudder"))["one"]
    t = run.data["t"].values
    motion = run.measured_motion(run.data.drop_vars("delta").assign(delta=0.0), t)
    assert np.degrees(motion.delta.max()) == pytest.approx(35.0, abs=0.01)
    assert not motion.vdot.any()


@pytest.mark.parametrize("name", ["run_7", "DR_beta4", "HR_delta35"])
def test_a_draft_knows_a_rudder_that_swings(name: str, tmp_path: Path) -> None:
    columns = record(drift=4.0, lag=0.6, middle=MIDDLE)
    beta = np.full_like(columns["t"], math.radians(4.0))
    columns |= {"u": SPEED * np.cos(beta), "v": -SPEED * np.sin(beta)}
    write(tmp_path / f"{name}.csv", columns)
    assert main(["new-campaign", str(tmp_path)]) == 0
    draft = tomllib.loads((tmp_path / "campaign.toml").read_text(encoding="utf-8"))
    run = {**draft.get("defaults", {}), **draft.get("defaults", {}).get("harmonic_rudder", {})}
    run |= draft["runs"][0]
    assert run["test"] == "harmonic_rudder"
    assert run["period"] == pytest.approx(PERIOD, rel=1e-3)
    reach = 35.0 / math.hypot(1.0, 0.6 * 2 * math.pi / PERIOD)
    assert run["rudder_amplitude_deg"] == pytest.approx(reach, abs=2.5)
    assert run["drift_deg"] == pytest.approx(4.0, abs=0.05)
    assert run["speed"] == pytest.approx(SPEED, abs=1e-3)


@pytest.mark.slow
def test_swinging_and_steady_rudders_of_the_kcs_agree(shared_data: Path, tmp_path: Path) -> None:
    """Flanders Hydraulics, 2.0 draughts of water: 7 tests against 138, other noise and no common
    rudder angle. Between them lie 2.5 standard deviations at most."""
    book = shared_data / kcs_shallow.BOOK
    if not book.exists():
        pytest.skip("without the workbook of Flanders Hydraulics")
    file = kcs_shallow.harmonic(kcs_shallow.campaign(book, "C0101A01", tmp_path))
    found = kcs_shallow.of_the_rudder(pk.open_campaign(file), "abkowitz3")
    for name, (value, std) in found["swinging"].items():
        other, its = found["steady"][name]
        assert value == pytest.approx(other, abs=3 * math.hypot(std, its)), name
        assert std < 0.1 * abs(value), name
