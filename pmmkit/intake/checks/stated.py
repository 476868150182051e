"""What a test was set to, beside the column that measured it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.campaigns import RUN_SETTINGS, RunSetting, Sensor, TestKind
from pmmkit.intake.checks.finding import Check, CheckFinding, figure, share_of
from pmmkit.numerics import Array

if TYPE_CHECKING:
    import xarray as xr

    from pmmkit.campaigns import Campaign, Run
    from pmmkit.intake.checks.finding import Summary

SAME: Final = 0.05
"""Share by which a column may be larger than the settings: a gear with play reads so."""
COHERENT: Final = 0.1
"""What is left beside a factor, over the column, where it is one factor in all runs."""
_PIECES: Final = 20
"""Pieces of a record by which the speed of a place is told."""
ALONG: Final = 0.1
"""Share of the speed from which a place along the tank moves with the carriage, or should."""
FEWEST: Final = 3
"""Settings that differ, without which no factor is told."""
SWUNG: Final = math.radians(3.0)
"""Swing of a rudder that no steering gear makes while it holds an angle [rad]."""
_TURNS: Final = 3
"""Times that a rudder goes from one side to the other, above which it swings: one that is put over
and back goes twice."""
_SLIPS: Final = {
    -1.0: "counted the other way",
    57.2958: "in degrees, and taken for radians",
    1 / 57.2958: "in radians, and taken for degrees",
    60.0: "a minute, and taken for a second",
    1 / 60.0: "a second, and taken for a minute",
}


def set_facts(run: Run, data: xr.Dataset) -> dict[str, float]:
    """Means of the columns that measure what a captive test was set to."""
    row = run.kind == "means"
    kind = run.kind_of_test
    if not kind.captive:
        return {}
    found = {}
    for name in ("delta", "n") + (("psi",) if kind.steady and not kind.circles else ()):
        if name in data and np.all(np.isfinite(data[name].values)):
            values = np.atleast_1d(data[name].values)
            if row or float(np.std(values)) <= 0.02 * abs(float(np.mean(values))):
                found[f"set_{name}"] = float(np.mean(values))
    if not row and "delta" in data and np.all(np.isfinite(data["delta"].values)):
        size, turns = _swing(np.atleast_1d(data["delta"].values))
        found |= {"set_delta swing": size} if turns >= _TURNS or kind.swings_rudder else {}
    placed = {"t", "x"} <= set(data) and "U_carriage" not in data
    if placed and not row and not kind.circles and not kind.surges:
        way = _way(np.asarray(data["t"].values, float), np.asarray(data["x"].values, float))
        # x may count from the carriage: then it hardly moves
        found |= {"set_x over time": way} if abs(way) > ALONG * run.settings.speed else {}
    found |= _brought(kind, data)
    if row and {"u", "v"} <= set(data):
        speed = math.hypot(float(data["u"]), float(data["v"]))
        found |= {"set_hull speed": speed} if math.isfinite(speed) else {}
    return found


def _brought(kind: TestKind, data: xr.Dataset) -> dict[str, float]:
    """The same of settings that kinds of test bring along: means, and amplitudes of swings."""
    found = {}
    for item in RUN_SETTINGS.brought:
        for column in (sensor.column for sensor in item.sensors if sensor.column in data):
            values = np.atleast_1d(data[column].values)
            if item.name in (*kind.needs, *kind.takes) and np.all(np.isfinite(values)):
                size = _swing(values)[0] if item.swings else float(np.mean(values))
                found[f"set_{column}"] = size
    return found


def _swing(values: Array) -> tuple[float, int]:
    """Amplitude of a rudder as of a sine, and how often it goes from one side to the other."""
    low, high = np.quantile(values, (0.05, 0.95))
    side = np.sign(values - (low + high) / 2) * (np.abs(2 * values - low - high) > (high - low) / 2)
    turns = int(np.count_nonzero(np.diff(side[side != 0])))
    return float(high - low) / 2 / math.sin(0.45 * math.pi), turns


def _way(t: Array, x: Array) -> float:
    """Speed of a place, the median over pieces of a record [m/s]: a start and a stop do not count.
    Zero where nothing is known."""
    there = np.isfinite(t) & np.isfinite(x)
    piece = max(int(there.sum()) // _PIECES, 1)
    gone, lasted = (y[there][piece:] - y[there][:-piece] for y in (x, t))
    return float(np.median(gone[lasted > 0] / lasted[lasted > 0])) if np.any(lasted > 0) else 0.0


def examine_set(_campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """Settings that their own columns contradict: by one factor in all runs, or in some runs.

    A rudder that swings in a steady test is an error: its forces would count as those of one angle.
    """
    yield from _swung(summaries)
    # those of angles and revolutions before those of the speed
    ordered = RUN_SETTINGS.ordered("rudder", "rudder_amplitude", "drift", "propeller_rps", "speed")
    for setting, sensor in ((item, sensor) for item in ordered for sensor in item.sensors):
        items = [
            item
            for item in summaries
            if f"set_{sensor.column}" in item.facts
            and item.run.settings.value(setting.name) is not None
        ]
        if items:
            stated = np.array([item.run.settings.value(setting.name) for item in items], float)
            seen = np.array([item.facts[f"set_{sensor.column}"] for item in items])
            factor = _factor(stated, seen)
            if factor is None:
                yield from _apart(setting, sensor, items, stated, seen)
            else:
                yield _slip(setting, sensor, items, factor)


def _swung(summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """Steady tests in which the rudder swings."""
    sizes = {
        item.run.id: item.facts.get("set_delta swing", 0.0)
        for item in summaries
        if item.run.kind_of_test.steady
    }
    off = {name: size for name, size in sizes.items() if size > SWUNG}
    if off:
        worst = max(off, key=lambda name: off[name])
        yield CheckFinding(
            check="set and measured",
            severity="error",
            message=f"The rudder swings in {len(off)} steady runs: in {worst} by "
            f"{figure(math.degrees(off[worst]))}° to either side.",
            runs=tuple(off),
            remedy=f'State test = "{"harmonic_rudder"}" with period and rudder_amplitude_deg.',
            numbers={"swing": off[worst]},
        )


def _factor(stated: Array, seen: Array) -> float | None:
    """The factor between column and settings where it is one and not 1."""
    if len(np.unique(stated[stated != 0].round(6))) < FEWEST:
        return None
    factor, _ = share_of(stated, seen)
    rest = seen - factor * stated
    whole = float(np.sqrt(np.mean(seen**2)))
    if abs(factor - 1.0) <= SAME or float(np.sqrt(np.mean(rest**2))) > COHERENT * whole:
        return None
    return factor


def _slip(
    setting: RunSetting, sensor: Sensor, items: Sequence[Summary], factor: float
) -> CheckFinding:
    nearest = min(_SLIPS, key=lambda value: abs(factor / value - 1.0))
    sure = abs(factor / nearest - 1.0) < SAME
    likely = f": one of them is {_SLIPS[nearest]}" if sure else ""
    return CheckFinding(
        check="set and measured",
        severity="warning",
        message=f"{sensor.column} is {figure(factor)} times {setting.name} in "
        f"{len(items)} runs (1 expected){likely}.",
        runs=tuple(item.run.id for item in items),
        remedy="State units and signs of both under [columns].",
        numbers={"factor": factor},
    )


def _apart(
    setting: RunSetting, sensor: Sensor, items: Sequence[Summary], stated: Array, seen: Array
) -> Iterator[CheckFinding]:
    """Runs in which setting and column differ; a heading may be counted from anywhere."""
    apart = seen - stated
    if sensor.column == "psi":
        apart = np.remainder(apart - np.median(apart) + np.pi, 2 * np.pi) - np.pi
    allowed = sensor.allowed + sensor.share * np.abs(stated)
    off = np.flatnonzero(np.abs(apart) > allowed)
    if not len(off):
        return
    worst = max(map(int, off), key=lambda place: abs(float(apart[place])))
    factor, unit = (180 / math.pi, "°") if setting.angle else (1.0, setting.unit)
    shown = [figure(x[worst] * factor) for x in (stated, stated + apart)]
    yield CheckFinding(
        check="set and measured",
        severity="warning",
        message=f"{setting.name} is not what {sensor.column} says in {len(off)} of "
        f"{len(items)} runs: in {items[worst].run.id} {shown[0]} {unit} is stated, {shown[1]} "
        f"{unit} is measured.",
        runs=tuple(items[int(place)].run.id for place in off),
        remedy=sensor.remedy,
        numbers={"stated": float(stated[worst]), "measured": float(stated[worst] + apart[worst])},
    )


CHECKS = (Check("set and measured", "what a test was set to against its own column", examine_set),)
