"""What a test was set to, against the column that measured it."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from pmmkit.campaigns import Campaign, Run, Settings
from pmmkit.conventions import Ship, Water
from pmmkit.intake import Summary
from pmmkit.intake.checks.scales import examine_speeds
from pmmkit.intake.checks.stated import examine_set, set_facts
from pmmkit.intake.checks.track import motion_facts

DEG = math.pi / 180
HULL = Ship(name="hull", L=4.0, B=0.6, d=0.2, volume=0.3, mass=300.0, Izz=300.0)
EMPTY = Campaign(title="", ship=HULL, water=Water(rho=1000.0), runs=())
RUDDERS = (-35, -20, -10, 0, 10, 20, 35)


def item(name: str, *, test: str = "drift_rudder", facts: dict[str, float], **set_to: float):
    """A row of means with what its columns say."""
    settings = replace(Settings(speed=0.6), **set_to)
    run = Run(id=name, test=test, kind="means", settings=settings, loader=dict)  # type: ignore[arg-type]
    return Summary(run=run, facts=facts)


def rudder(factor: float = 1.0, shift: float = 0.0) -> list[Summary]:
    return [
        item(f"d{x}", rudder=x * DEG, facts={"set_delta": (x * factor + shift) * DEG})
        for x in RUDDERS
    ]


def found(items: list[Summary]):
    return list(examine_set(EMPTY, items))


def test_a_steering_gear_that_reads_one_or_two_per_cent_more_is_no_matter() -> None:
    assert found(rudder(1.015)) == []


@pytest.mark.parametrize(
    ("factor", "words"),
    [
        (57.2958, "in degrees, and taken for radians"),
        (1 / 57.2958, "in radians, and taken for degrees"),
        (-1.0, "counted the other way"),
    ],
)
def test_a_slip_of_unit_or_sign_is_one_factor_in_all_runs(factor: float, words: str) -> None:
    (finding,) = found(rudder(factor))
    assert words in finding.message
    assert finding.numbers["factor"] == pytest.approx(factor)
    assert len(finding.runs) == len(RUDDERS)


def test_revolutions_a_minute_taken_for_those_a_second() -> None:
    items = [item(str(n), propeller_rps=float(n), facts={"set_n": 60.0 * n}) for n in (2, 4, 6)]
    (finding,) = found(items)
    assert "a minute, and taken for a second" in finding.message


def test_a_rudder_that_lags_behind_its_order() -> None:
    """It swings by ±35°: while it moves fast it is 2.5° behind, at its ends it is not."""
    rows = []
    for place in range(24):
        phase = 2 * math.pi * (place + 0.5) / 24
        measured = 35 * DEG * math.sin(phase - 0.072)
        rows.append(
            item(str(place), rudder=35 * DEG * math.sin(phase), facts={"set_delta": measured})
        )
    (finding,) = found(rows)
    assert "rudder is not what delta says" in finding.message
    assert "lags behind its order" in finding.remedy
    assert 6 < len(finding.runs) < 24


def test_a_zero_of_the_rudder_that_is_off() -> None:
    (finding,) = found(rudder(shift=4.0))
    assert len(finding.runs) == len(RUDDERS)


def drifting(*, columns_turned: bool) -> list[Summary]:
    """Twelve runs with rudder at drift; in some tables u and v are those along the tank."""
    return [
        item(
            f"m{angle}_{x}",
            drift=0.0 if columns_turned and angle else angle * DEG,
            rudder=x * DEG,
            facts={"set_psi": angle * DEG},
        )
        for angle in (-12, 0, 0, 0, 12)
        for x in RUDDERS
    ]


def test_a_drift_that_the_heading_contradicts() -> None:
    """The tests at ±12° are listed without their drift."""
    assert found(drifting(columns_turned=False)) == []
    (finding,) = found(drifting(columns_turned=True))
    assert "drift is not what psi says in 14 of 35 runs" in finding.message
    assert {name.partition("_")[0] for name in finding.runs} == {"m-12", "m12"}


def test_a_heading_may_be_counted_from_anywhere() -> None:
    turned = [
        replace(x, facts={"set_psi": x.facts["set_psi"] + 90 * DEG})
        for x in drifting(columns_turned=False)
    ]
    assert found(turned) == []


def test_the_speed_of_a_row_is_that_of_u_and_v() -> None:
    items = [item(str(n), facts={"set_hull speed": 0.6 if n else 0.7}) for n in range(4)]
    (finding,) = found(items)
    assert finding.runs == ("0",)
    assert "0.600 m/s is stated, 0.700 m/s is measured" in finding.message


@pytest.mark.parametrize(("amplitude", "told"), [(2e-4, False), (3e-2, True)])
def test_the_rate_of_a_velocity_that_is_only_rounding_is_not_asked(
    amplitude: float, told: bool
) -> None:
    """Four digits of v are rounding in pure yaw, and a motion in pure sway."""
    phase = 2 * math.pi * np.arange(24) / 24
    omega = 2 * math.pi / 40.0
    v = np.round(amplitude * np.cos(phase), 4)
    data = xr.Dataset(
        {"v": ("t", v), "vdot": ("t", np.round(-amplitude * omega * np.sin(phase), 4))},
        coords={"t": phase / omega},
    )
    settings = Settings(speed=0.6, period=40.0, yaw_amplitude=0.2)
    run = Run(id="G", test="pure_yaw", kind="history", settings=settings, loader=lambda: data)
    facts = motion_facts(run, data, data["t"].values)
    assert ("vdot_slope" in facts) == told


@pytest.mark.parametrize(
    ("factor", "away", "told"),
    [(1.0, 0.0, False), (2.0, 0.0, True), (0.5, 0.0, True), (1.0, 3.0, False), (0.0, 0.0, False)],
    ids=["right", "half the period", "twice the period", "from rest", "on the carriage"],
)
def test_a_place_along_the_tank_tells_the_speed(factor: float, away: float, told: bool) -> None:
    """A cycle without times gets them from its period: with half of it, x goes twice as fast."""
    t = np.linspace(0.0, 50.0, 500)
    x = factor * 0.6 * (np.clip(t, away, 50.0 - away) + 0.02 * np.sin(0.5 * t))
    settings = Settings(speed=0.6, period=12.5, yaw_amplitude=0.1)
    run = Run(id="a", test="pure_yaw", kind="history", settings=settings, loader=dict)  # type: ignore[arg-type]
    data = xr.Dataset({"x": ("time", x), "t": ("time", t)})
    findings = found([Summary(run=run, facts=set_facts(run, data))])
    assert bool(findings) is told
    if told:
        assert "Look at the period" in findings[0].remedy


def at_speeds(*speeds: float):
    items = [item(f"run{n}", facts={}, speed=speed) for n, speed in enumerate(speeds)]
    return list(examine_speeds(EMPTY, items))


@pytest.mark.parametrize("slip", [0.011, 60.0])
def test_one_speed_far_from_all_others_is_told(slip: float) -> None:
    """A Froude number of its own, whose forces are divided by the square of a slip."""
    (finding,) = at_speeds(*[1.0] * 8, *[2.0] * 7, slip)
    assert finding.runs == ("run15",)
    assert finding.message.startswith("The speed of 1 of 16 runs is far from that of the others: ")


@pytest.mark.parametrize(
    "speeds", [(0.5, 1.0, 2.0), [0.0, *[1.0] * 15], [*[0.1] * 4, *[1.0] * 12], [0.25, *[1.0] * 15]]
)
def test_still_water_slow_series_and_dead_slow_are_no_slips(speeds: tuple[float, ...]) -> None:
    assert at_speeds(*speeds) == []
