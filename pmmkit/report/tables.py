"""The tables of a report."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np

from pmmkit.campaigns.test_kinds.registry import kinds
from pmmkit.conventions import CHANNELS
from pmmkit.numerics import Array
from pmmkit.presentation import Cell, Grid, Group, number, plus_minus
from pmmkit.reduction import Reduction
from pmmkit.report.reference import Reference
from pmmkit.report.words import symbol
from pmmkit.tables import DerivativeTable
from pmmkit.tables.compare import compare

_CHANNEL: Mapping[str, str] = {
    "X": "Surge force X",
    "Y": "Sway force Y",
    "N": "Yaw moment N",
    "K": "Roll moment K",
}


def speeds(table: DerivativeTable) -> list[str]:
    """Names of the rows of a table: its Froude numbers, or all speeds."""
    return ["all speeds"] if table.pooled else [f"Fn {value:.3f}" for value in table.Fn]


def derivatives(table: DerivativeTable, reference: Reference | None) -> Grid:
    """Every derivative with its 95 % interval, a column per Froude number, beside a reference.

    Parameters
    ----------
    table : DerivativeTable
        Our values.
    reference : Reference or None
        Values of a source.
    """
    scale = factor(table)
    low, high = table.interval()
    half = scale * (high - low) / 2
    beside = _reference_column(table, reference, scale)
    groups = []
    for channel in CHANNELS:
        names = [name for name in table.names if name[0] == channel]
        if not names:
            continue
        rows: list[list[Cell]] = []
        for name in names:
            column = table.index(name)
            row: list[Cell] = [symbol(name, table.convention)]
            row += [
                plus_minus(value, width)
                for value, width in zip(
                    scale * table.value[:, column], half[:, column], strict=True
                )
            ]
            if reference is not None:
                row.append(beside.get(name, "–"))
            rows.append(row)
        groups.append(Group(title=_CHANNEL[channel], rows=rows))
    heads = ["", *speeds(table)]
    return Grid(
        head=heads if reference is None else [*heads, reference.name],
        groups=groups,
        caption=f"{_times(scale)}Value ± half of the 95 % interval; – not determined by these "
        f"runs; system {meaning(table)}.",
    )


def factor(table: DerivativeTable) -> float:
    """What the derivatives of a report are multiplied by: 1000 where most are small.

    Parameters
    ----------
    table : DerivativeTable
        The table in question.
    """
    known = np.abs(table.value[np.isfinite(table.value)])
    return 1e3 if len(known) and np.median(known) < 0.03 else 1.0


def _times(scale: float) -> str:
    return "All values times 10³. " if scale == 1e3 else ""


def meaning(table: DerivativeTable) -> str:
    """What the numbers of a table mean, in words."""
    it = table.convention
    unit = {
        "prime": "prime (½ρL²U², ½ρL³U²)",
        "prime-d": "prime-d (½ρLdU², ½ρL²dU²)",
        "bis": "bis (ρg∇, ρg∇L, √(gL))",
    }[it.system]
    speed = "instantaneous speed" if it.U == "instantaneous" else "carriage speed"
    coriolis = (
        "added-mass Coriolis terms inside the derivatives"
        if it.coriolis == "in-derivatives"
        else "added-mass Coriolis terms written separately"
    )
    point = (
        "midship"
        if it.moment_reference_x == it.motion_reference_x == 0
        else f"x = {it.moment_reference_x:g} m (moments), {it.motion_reference_x:g} m (motions)"
    )
    return f"{unit}, {speed}, {coriolis}, referred to {point}"


def _reference_column(
    table: DerivativeTable, reference: Reference | None, scale: float
) -> dict[str, str]:
    """Text of the reference by derivative; a range where it depends on the Froude number."""
    if reference is None:
        return {}
    frame = compare(table, reference.table)
    found = {}
    for name, group in frame.groupby("derivative", sort=False):
        values = scale * group["reference"].to_numpy(float)
        same = np.ptp(values) <= 1e-9 * np.max(np.abs(values))
        found[str(name)] = (
            number(values[0], 5) if same else f"{number(values[0])} … {number(values[-1])}"
        )
    return found


def methods(reduction: Reduction) -> list[Grid]:
    """The same derivatives by each family of tests, a table per Froude number.

    Parameters
    ----------
    reduction : Reduction
        With its families.
    """
    table = reduction.table
    scale = factor(table)
    singles = _single_runs(reduction, scale)
    grids = []
    for row, speed in enumerate(speeds(table)):
        froude = float(table.Fn[row])
        ways = {
            way: {name: _entry(found, name, froude, scale) for name in table.names}
            for way, found in {"all runs together": table, **reduction.families}.items()
        }
        ways["single runs, mean"] = {name: singles.get((row, name), "") for name in table.names}
        ways = {way: texts for way, texts in ways.items() if any(texts.values())}
        names = [name for name in table.names if any(texts[name] for texts in ways.values())]
        if len(ways) < 3:
            continue
        rows = [
            [symbol(name, table.convention), *(texts[name] for texts in ways.values())]
            for name in names
        ]
        caption = f"{speed[:1].upper()}{speed[1:]}. {_times(scale)}"
        grids.append(Grid(head=["", *ways], groups=[Group(rows=rows)], caption=caption))
    return grids


def _place(table: DerivativeTable, froude: float) -> int | None:
    """Row of a Froude number; None where the table has none."""
    if table.pooled or math.isnan(froude):
        return 0 if table.pooled else None
    near = np.flatnonzero(np.isclose(table.Fn, froude, rtol=0.01))
    return int(near[0]) if len(near) else None


def _entry(table: DerivativeTable, name: str, froude: float, scale: float) -> Cell:
    row = _place(table, froude)
    if name not in table or row is None:
        return ""
    low, high = table.interval()
    column = table.index(name)
    half = scale * (high[row, column] - low[row, column]) / 2
    return plus_minus(scale * table.value[row, column], half) or ""


def _single_runs(reduction: Reduction, scale: float) -> dict[tuple[int, str], str]:
    """Mean and range of the single-run values by row and derivative."""
    found: dict[tuple[int, str], list[float]] = {}
    for single in reduction.single_runs.values():
        row = _place(reduction.table, float(single.Fn[0]))
        if row is None:
            continue
        for name, value in zip(single.names, single.value[0].tolist(), strict=True):
            if math.isfinite(value):
                found.setdefault((row, name), []).append(scale * value)
    return {key: _mean_and_range(values) for key, values in found.items()}


def _mean_and_range(values: Sequence[float]) -> str:
    mean = number(float(np.mean(values)))
    if len(values) == 1:
        return mean
    return f"{mean} ({number(min(values), 3)} … {number(max(values), 3)})"


def runs(reduction: Reduction) -> Grid:
    """How many runs of each kind there are, and at which Froude numbers.

    Parameters
    ----------
    reduction : Reduction
        With its runs.
    """
    count = Counter((item.run.test, f"{item.froude:.3f}") for item in reduction.runs)
    rows: list[list[Cell]] = []
    for test in kinds().values():
        speeds = {
            froude: number for (kind, froude), number in sorted(count.items()) if kind == test.name
        }
        if speeds:
            places = ", ".join(f"{froude} ({number})" for froude, number in speeds.items())
            rows.append([test.title, str(sum(speeds.values())), places])
    return Grid(head=["Test", "Runs", "At Fn (runs)"], groups=[Group(rows=rows)], texts=(2,))


def settings(reduction: Reduction) -> Grid:
    """Every run with its settings and what of its record counts.

    Parameters
    ----------
    reduction : Reduction
        With its runs.
    """
    rows: list[list[Cell]] = []
    for item in reduction.runs:
        it = item.run.settings
        motion = [
            f"β {math.degrees(it.drift):+.3g}°" if it.drift else "",
            f"δ {math.degrees(it.rudder):+.3g}°" if it.rudder else "",
            f"heel {math.degrees(it.heel):+.3g}°" if it.heel else "",
            f"a {it.amplitude:.4g} m" if it.amplitude else "",
            f"ψ {math.degrees(it.yaw_amplitude):.3g}°" if it.yaw_amplitude else "",
            f"T {it.period:.4g} s" if it.period else "",
        ]
        rows.append(
            [
                item.run.id,
                item.run.kind_of_test.title,
                f"{item.froude:.3f}",
                ", ".join(part for part in motion if part) or "straight",
                item.window,
            ]
        )
    return Grid(
        head=["Run", "Test", "Fn", "Setting", "What counts"],
        groups=[Group(rows=rows)],
        texts=(1, 3, 4),
    )


def particulars(reduction: Reduction) -> Grid:
    """The model as tested, and the water.

    Parameters
    ----------
    reduction : Reduction
        With its campaign.
    """
    ship, water = reduction.campaign.ship, reduction.campaign.water
    entries: Sequence[tuple[str, float | None, str]] = (
        ("Length between perpendiculars L", ship.L, "m"),
        ("Breadth B", ship.B, "m"),
        ("Draught d", ship.d, "m"),
        ("Displaced volume", ship.volume, "m³"),
        ("Block coefficient", ship.block, "–"),
        ("Mass", ship.mass, "kg"),
        ("Centre of gravity forward of midship", ship.xG, "m"),
        ("Yaw inertia about midship", ship.Izz, "kg m²"),
        ("Density of the water", water.rho, "kg/m³"),
        ("Water depth", water.depth, "m"),
        ("Width of the tank", water.tank_width, "m"),
        ("Depth of the tank", water.tank_depth, "m"),
    )
    rows = [[name, number(value, 6), unit] for name, value, unit in entries if value is not None]
    return Grid(head=[ship.name, "", ""], groups=[Group(rows=rows)], texts=(2,))


def headline(table: DerivativeTable, reference: Reference | None) -> Grid:
    """The linear derivatives of sway and yaw, a row per Froude number.

    Parameters
    ----------
    table : DerivativeTable
        Our values.
    reference : Reference or None
        Values of a source, for one more row.
    """
    names = [name for name in ("Yv", "Yr", "Nv", "Nr", "Yvdot", "Nrdot") if name in table]
    scale = factor(table)
    low, high = table.interval()
    half: Array = scale * (high - low) / 2
    rows: list[list[Cell]] = [
        [
            speed,
            *(plus_minus(scale * table[name][row], half[row, table.index(name)]) for name in names),
        ]
        for row, speed in enumerate(speeds(table))
        if any(math.isfinite(table[name][row]) for name in names)
    ]
    if reference is not None:
        beside = _reference_column(table, reference, scale)
        rows.append([reference.name, *(beside.get(name, "–") for name in names)])
    return Grid(
        head=["", *(symbol(name, table.convention) for name in names)],
        groups=[Group(rows=rows)],
        caption=f"{_times(scale)}Value ± half of the 95 % interval.",
    )
