"""Checks of free-running records, and their usable segments, on made-up tracks."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from checks_programme import SHIP, campaign_of, run_of

from pmmkit import Run
from pmmkit.base import CampaignError
from pmmkit.campaigns import Settings, usable
from pmmkit.intake import examine
from pmmkit.intake.checks.track import free_facts

SPEED, STEP = 0.9, 0.1


def said(findings, check: str, text: str = ""):
    return [item for item in findings if item.check == check and text in item.message]


def integrated(values: np.ndarray) -> np.ndarray:
    return np.concatenate(([0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * STEP)))


def columns(test: str = "turning", rate: float = 12.0) -> dict[str, np.ndarray]:
    """A model that answers its rudder with a lag; the rudder moves at so many degrees a second."""
    t = np.arange(0, 240, STEP)
    angle, delta, psi, r = math.radians(20), np.zeros_like(t), np.zeros_like(t), np.zeros_like(t)
    order = 0.0
    for k in range(1, len(t)):
        if t[k] >= 20 and order == 0.0:
            order = angle
        if test == "zigzag" and order * psi[k - 1] >= math.radians(20) * abs(order):
            order = -order
        reach = math.radians(rate) * STEP
        delta[k] = delta[k - 1] + np.clip(order - delta[k - 1], -reach, reach)
        r[k] = r[k - 1] + STEP * (0.20 * delta[k - 1] - r[k - 1]) / 4.0
        psi[k] = psi[k - 1] + STEP * 0.5 * (r[k] + r[k - 1])
    u, v = SPEED - 1.5 * np.abs(r), -0.8 * r
    x = integrated(u * np.cos(psi) - v * np.sin(psi))
    y = integrated(u * np.sin(psi) + v * np.cos(psi))
    n = np.full_like(t, 8.0)
    return {"t": t, "x": x, "y": y, "psi": psi, "u": u, "v": v, "r": r, "delta": delta, "n": n}


def free(values: dict[str, np.ndarray], test: str = "turning", attrs=None, **settings) -> Run:
    t = values["t"]
    data = xr.Dataset(
        {name: ("t", part) for name, part in values.items() if name != "t"}, {"t": t}, attrs
    )
    stated = {"speed": SPEED, "rudder": math.radians(20), **settings}
    if test == "zigzag":
        stated.setdefault("switch", math.radians(20))
    return Run(id="A", test=test, kind="history", settings=Settings(**stated), loader=lambda: data)


def found(run: Run, **changes):
    return examine(campaign_of([run], kind="free-running", **changes))


@pytest.mark.parametrize("test", ["turning", "zigzag"])
def test_clean_records_raise_nothing(test):
    assert [str(item) for item in found(free(columns(test), test))] == []


@pytest.mark.parametrize("test", ["turning", "zigzag"])
def test_clean_records_are_one_segment_without_cuts(test):
    run = free(columns(test), test)
    parts = usable(run)
    assert ([part.id for part in parts.segments], parts.cuts) == (["A"], ())
    assert parts.segments[0].data.sizes == run.data.sizes


def test_noise_of_a_receiver_raises_nothing():
    values = columns()
    noise = np.random.default_rng(1)
    for name, size in (("x", 0.003), ("y", 0.003), ("psi", 0.001)):
        values[name] = values[name] + size * noise.standard_normal(len(values["t"]))
    assert said(found(free(values)), "headings") == []
    assert said(found(free(values)), "standing samples") == []
    assert len(usable(free(values)).segments) == 1


def held(values, start, stop, names=("x", "y")):
    out = dict(values)
    for name in names:
        out[name] = values[name].copy()
        out[name][start:stop] = values[name][start - 1]
    return out


def test_positions_that_stand_and_catch_up_are_no_jumps():
    run = free(held(columns(), 1000, 1008))
    (item,) = said(found(run), "standing samples")
    assert item.numbers["held_time"] == pytest.approx(0.8, abs=0.01)
    assert said(found(run), "velocities", "jumps") == []
    (part,) = usable(run).segments
    assert np.flatnonzero(~part.data["fresh"].values).tolist() == list(range(1000, 1008))


def test_positions_that_stand_long_are_cut_out():
    parts = usable(free(held(columns(), 1000, 1030)))
    assert [part.data.sizes["t"] for part in parts.segments] == [1000, 2400 - 1030]
    assert "stands still for 3.0 s" in parts.cuts[0].reason


def test_a_ship_at_rest_does_not_stand_still_in_this_sense():
    values = columns()
    rest = {name: np.concatenate((np.full(300, part[0]), part)) for name, part in values.items()}
    rest["t"] = STEP * np.arange(len(rest["x"]))
    rest |= {name: np.where(rest["t"] < 30, 0.0, rest[name]) for name in ("u", "v")}
    assert said(found(free(rest)), "standing samples") == []
    assert len(usable(free(rest)).segments) == 1


def test_headings_that_jump():
    values = columns()
    values["psi"] = values["psi"] - math.radians(7) * (values["t"] >= 150)
    (item,) = said(found(free(values)), "headings")
    assert math.degrees(item.numbers["turn_jump"]) == pytest.approx(7, abs=0.1)
    assert "jumps" in item.message
    parts = usable(free(values))
    assert [part.id for part in parts.segments] == ["A/1", "A/2"]
    assert parts.cuts[0].t_stop == pytest.approx(150)


def test_positions_that_jump_without_velocity_columns():
    values = {name: part for name, part in columns().items() if name not in "uv"}
    values["y"] = values["y"] + 0.6 * (values["t"] >= 90)
    (item,) = said(found(free(values)), "velocities", "jumps")
    assert item.numbers["jump"] == pytest.approx(0.6, abs=0.01)


def test_an_integral_of_r_that_falls_short():
    values = columns()
    values["r"] = values["r"] / 1.012
    (item,) = said(found(free(values)), "headings")
    assert item.numbers["share"] == pytest.approx(1 / 1.012, abs=2e-4)
    assert "1.2 to 1.2 %" in item.message
    assert "1.0120" in item.remedy


def test_a_zero_of_r_is_no_gain():
    """Turns to both sides miss by the same in a second, one too much and one too little."""
    zero = math.radians(0.05)
    runs = []
    for name, side in (("port", -1.0), ("starboard", 1.0)):
        values = columns()
        turned = {x: side * values[x] for x in ("y", "psi", "v", "delta")}
        values |= {**turned, "r": side * values["r"] + zero}
        runs.append(free(values, rudder=side * math.radians(20)).with_(id=name))
    (item,) = said(examine(campaign_of(runs, kind="free-running")), "headings")
    assert "is not the change of heading in 2 of 2 records" in item.message
    assert item.numbers["zero_deg_s"] == pytest.approx(0.05, rel=0.02)
    assert "Shift r by -0.05 deg/s" in item.remedy


def digits(values: np.ndarray, count: int) -> np.ndarray:
    """Numbers written with so many digits, as 1.23E+02 has three."""
    return np.array([float(f"{x:.{count - 1}E}") for x in values])


def test_positions_of_three_digits_neither_jump_nor_stand():
    """MARIN's turns of the KVLCC2 have them: 10 m where she is more than 1000 m away."""
    scale = 46.4  # of 4 m model: by Froude's law
    values = columns()
    for name, power in (("t", 0.5), ("x", 1.0), ("y", 1.0), ("u", 0.5), ("v", 0.5), ("r", -0.5)):
        values[name] = values[name] * scale**power
    values |= {name: digits(values[name], 3) for name in ("x", "y")}
    ship = replace(SHIP, L=SHIP.L * scale)
    run = free(values, speed=SPEED * math.sqrt(scale))
    findings = examine(campaign_of([run], kind="free-running", ship=ship))
    (item,) = said(findings, "positions")
    assert "written to 10 m" in item.message
    assert said(findings, "standing samples") == said(findings, "velocities", "jumps") == []
    (segment,) = usable(run).segments
    assert np.all(segment.data["fresh"].values[2000:])
    assert len(segment.data["t"]) == len(values["t"])


def test_a_wrapped_heading_is_no_jump_and_comes_unwrapped():
    values = columns()
    values["psi"] = np.angle(np.exp(1j * values["psi"]))
    assert np.ptp(values["psi"]) > 6
    assert said(found(free(values)), "headings") == []
    (part,) = usable(free(values)).segments
    np.testing.assert_allclose(part.data["psi"], columns()["psi"], atol=1e-9)


def test_a_sample_without_heading_does_not_cost_those_after_it():
    values = columns()
    t = values["t"]
    whole = free_facts(free(values).data, t)
    values["psi"][len(t) // 10] = np.nan
    holed = free_facts(free(values).data, t)
    for name in ("r_slope", "swung"):
        assert holed[name] == pytest.approx(whole[name], rel=1e-3)


def test_velocities_that_are_late_and_turned_with_the_present_heading():
    values = columns("zigzag")
    t, psi, u, v = (values[name] for name in ("t", "psi", "u", "v"))
    ahead = np.interp(t - 0.7, t, u * np.cos(psi) - v * np.sin(psi))
    across = np.interp(t - 0.7, t, u * np.sin(psi) + v * np.cos(psi))
    values["u"] = ahead * np.cos(psi) + across * np.sin(psi)
    values["v"] = -ahead * np.sin(psi) + across * np.cos(psi)
    findings = found(free(values, "zigzag"))
    (item,) = said(findings, "false sway")
    assert item.numbers["time"] == pytest.approx(-0.7, abs=0.12)
    assert said(findings, "velocities", "late")[0].numbers["lag"] == pytest.approx(0.7, abs=0.03)


def test_a_stop_at_the_end():
    values = columns()
    values["n"] = np.where(values["t"] >= 230, 0.0, values["n"])
    (item,) = said(found(free(values)), "stop at the end")
    assert item.numbers["stopped"] == pytest.approx(9.9, abs=0.01)
    (part,) = usable(free(values)).segments
    assert float(part.data["t"][-1]) < 230
    assert len(usable(free(values), cut_stop=False).segments[0].data["t"]) == len(values["t"])
    assert said(found(free(values, "stopping")), "stop at the end") == []
    assert usable(free(values, "stopping")).cuts == ()


def test_a_rudder_column_that_is_the_order():
    (item,) = said(found(free(columns("zigzag", rate=4000), "zigzag")), "rudder order")
    assert math.degrees(item.numbers["order_step"]) == pytest.approx(40, abs=0.1)
    quick = free(columns("zigzag", rate=60), "zigzag")
    assert said(found(quick), "rudder order") == []
    assert said(found(quick, rudder={"rate_deg_s": 15.0}), "rudder order") != []


def test_an_approach_that_is_still_gaining_speed():
    values = columns()
    t = values["t"]
    share = np.where(t < 20, 0.5 + 0.025 * t, 1.0)
    values["u"], values["v"] = values["u"] * share, values["v"] * share
    for name, part in (("x", np.cos), ("y", np.sin)):
        side = -np.sin(values["psi"]) if name == "x" else np.cos(values["psi"])
        values[name] = integrated(values["u"] * part(values["psi"]) + values["v"] * side)
    (item,) = said(found(free(values)), "approach")
    passage = SHIP.L / SPEED
    mean = SPEED * (1 - 0.025 * passage / 2)
    expected = 0.025 * SPEED * SHIP.L / mean**2
    assert item.numbers["growth"] == pytest.approx(expected, rel=0.05)


def test_speed_rudder_and_switch_that_are_not_those_stated():
    zigzag = columns("zigzag")
    (item,) = said(found(free(columns(), speed=0.7)), "settings")
    assert item.numbers["approach"] == pytest.approx(SPEED, rel=0.01)
    (item,) = said(found(free(zigzag, "zigzag", rudder=math.radians(35))), "settings")
    assert (item.severity, "never comes near" in item.message) == ("error", True)
    (item,) = said(found(free(zigzag, "zigzag", switch=math.radians(30))), "settings")
    assert math.degrees(item.numbers["switch"]) == pytest.approx(20, abs=1)


def test_a_speed_that_is_not_stated_is_found_where_the_rudder_is_laid_at_once():
    values = {name: part[180:] for name, part in columns().items()}
    (item,) = said(found(free(values, speed=8.0)), "settings")
    assert item.numbers["approach"] == pytest.approx(SPEED, rel=0.01)


def test_empty_rows_that_were_left_out_are_told():
    note = json.dumps(["327 of 2028 rows without a value left out"])
    (item,) = said(found(free(columns(), attrs={"conversions": note})), "standing samples")
    assert (item.severity, item.numbers["dropped"]) == ("info", 327)


def test_empty_rows_gaps_and_times_that_stand_are_cut_with_reasons():
    values = {name: part.copy() for name, part in columns().items()}
    for part in values.values():
        part[2000:] = np.nan
    values["t"][1000:2000] += 5.0
    values["t"][500] = values["t"][499]
    parts = usable(free(values))
    assert [part.data.sizes["t"] for part in parts.segments] == [999, 1000]
    reasons = " | ".join(cut.reason for cut in parts.cuts)
    assert "400 rows without time" in reasons
    assert "no sample for 5.1 s" in reasons
    assert "time does not go on" in reasons


def test_segments_shorter_than_asked_are_left_out():
    values = columns()
    values["x"] = values["x"] + 0.8 * (values["t"] >= 100) + 0.8 * (values["t"] >= 104)
    parts = usable(free(values))
    assert [part.id for part in parts.segments] == ["A/1", "A/2"]
    assert any("shorter than 5 s" in cut.reason for cut in parts.cuts)
    assert len(usable(free(values), shortest=3.0).segments) == 3


def test_captive_runs_have_no_segments():
    with pytest.raises(CampaignError, match="captive"):
        usable(run_of("SD", "static_drift"))


def test_a_heading_in_whole_degrees_is_no_gain_of_the_yaw_rate():
    """Its rounding adds to the squares of its rates: r of MARIN's turns seemed 4 % too small."""
    slowly = 8.0  # a ship in place of her model
    values = columns()
    values |= {"t": values["t"] * slowly, "r": values["r"] / slowly}
    values["psi"] = np.radians(np.rint(np.degrees(values["psi"])))
    for gain in (1.0, 1.2):
        data = {"psi": ("t", values["psi"]), "r": ("t", gain * values["r"])}
        facts = free_facts(xr.Dataset(data, {"t": values["t"]}), values["t"])
        assert facts["r_slope"] == pytest.approx(gain, rel=0.01)
