"""The tables of a report."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Final

import numpy as np

from pmmkit.campaigns import TEST_KINDS, Campaign
from pmmkit.conventions import Convention, Ship, Water, parse_derivative
from pmmkit.intake import name_runs
from pmmkit.models import DerivativeTable, ReferenceTable, compare
from pmmkit.presentation import Grid, Group, Symbol, number, plus_minus
from pmmkit.reduction import Reduction

# Numbers and names as they stand in a report.


_LETTERS: Final = {"phi": "φ", "d": "δ", "|d|": "|δ|"}


def symbol(name: str, convention: Convention) -> Symbol:
    """A derivative as it is typeset.

    Examples
    --------
    >>> print(symbol("Nvvr", Convention()))
    N′vvr
    """
    derivative = parse_derivative(name)
    letters = _LETTERS | ({"v": "β", "|v|": "|β|"} if convention.sway == "beta" else {})
    factors = [
        letters.get(factor[0], factor[0]) + "\N{COMBINING DOT ABOVE}"
        if factor.endswith("dot")
        else letters.get(factor, factor)
        for factor in derivative.factors
    ]
    stroke = "″" if convention.system == "bis" else "′"
    return Symbol(f"{derivative.channel}{stroke}", "".join(factors))


def flattened(content: Mapping[str, Any], path: tuple[str, ...] = ()) -> Iterable[tuple[str, str]]:
    """Nested content as pairs of a dotted name and a text.

    Examples
    --------
    >>> list(flattened({"files": {"a.csv": "5f"}, "cycles": None, "made": ["x", "y"]}))
    [('files: a.csv', '5f'), ('made', 'x'), ('made', 'y')]
    """
    for key, value in content.items():
        here = (*path, str(key))
        if isinstance(value, Mapping):
            yield from flattened(value, here)
        elif isinstance(value, (list, tuple)):
            for item in value:
                if isinstance(item, Mapping):
                    yield from flattened(item, here)
                else:
                    yield ": ".join(here), str(item)
        elif value not in (None, ""):
            yield ": ".join(here), str(value)


def gathered(pairs: Iterable[tuple[str, str]]) -> list[list[str]]:
    """Pairs of a name and a text as rows of a table, without what repeats the row above.

    Examples
    --------
    >>> gathered([("left out: SD_1", "again"), ("left out: SD_2", "again"), ("made", "x")])
    [['left out: SD_1, SD_2', 'again'], ['made', 'x']]
    >>> gathered([("made", "x"), ("made", "y")])
    [['made', 'x'], ['', 'y']]
    """
    found: list[tuple[str, str, list[str]]] = []
    for name, text in pairs:
        above, _, own = name.rpartition(": ")
        if above and found and found[-1][:2] == (above, text):
            found[-1][2].append(own)
        else:
            found.append((above, text, [own]))
    names = [f"{above}: {', '.join(own)}" if above else own[0] for above, _, own in found]
    return [
        ["" if place and name == names[place - 1] else name, text]
        for place, (name, (_, text, _)) in enumerate(zip(names, found, strict=True))
    ]


def reference_values(table: DerivativeTable, reference: ReferenceTable) -> dict[str, str]:
    """Values of a source by derivative; a range where they depend on the Froude number.

    Parameters
    ----------
    table : DerivativeTable
        Ours, whose convention and factor they take.
    reference : ReferenceTable
        Values of a source.
    """
    frame = compare(table, reference.table)
    found = {}
    for name, group in frame.groupby("derivative", sort=False):
        values = table.factor * group["reference"].to_numpy(float)
        same = np.ptp(values) <= 1e-9 * np.max(np.abs(values))
        found[str(name)] = (
            number(values[0], 5) if same else f"{number(values[0])} … {number(values[-1])}"
        )
    return found


def methods(reduction: Reduction, beside: ReferenceTable | None = None) -> list[Grid]:
    """The same derivatives by each method and family of tests, a table per Froude number."""
    (_, basis), *others = reduction.estimates.items()
    table = basis.table
    scale = table.factor
    singles = _single_runs(reduction, scale)
    grids = []
    for row, speed in enumerate(table.speeds):
        froude = float(table.Fn[row])
        ways = {
            way: {name: _entry(found, name, froude, scale) for name in table.names}
            for way, found in {
                "all runs together": table,
                **{estimate.method: estimate.table for _, estimate in others},
                **reduction.families,
            }.items()
        }
        if beside is not None:
            published = _published(table, beside, row)
            ways[beside.name] = {name: published.get(name, "") for name in table.names}
        ways["single runs, mean"] = {name: singles.get((row, name), "") for name in table.names}
        ways = {way: texts for way, texts in ways.items() if any(texts.values())}
        names = [name for name in table.names if any(texts[name] for texts in ways.values())]
        if len(ways) < 3:
            continue
        rows = [
            [symbol(name, table.convention), *(texts[name] for texts in ways.values())]
            for name in names
        ]
        caption = f"{speed[:1].upper()}{speed[1:]}. {table.scaling}"
        grids.append(Grid(head=["", *ways], groups=[Group(rows=rows)], caption=caption))
    return grids


def _published(table: DerivativeTable, beside: ReferenceTable, row: int) -> dict[str, str]:
    """Values of a source at one Froude number of a table."""
    frame = compare(table, beside.table)
    own = frame.groupby("derivative", sort=False)["reference"].nth(row)
    names = frame["derivative"].drop_duplicates()
    return {
        str(name): number(table.factor * float(value))
        for name, value in zip(names, own, strict=True)
    }


def shares(reduction: Reduction) -> list[Grid]:
    """In which part of the bags of runs each term of a library was taken."""
    grids = []
    for estimate in reduction.estimates.values():
        table = estimate.table
        rows = [
            [
                symbol(name, table.convention),
                *("" if math.isnan(x) else f"{100 * x:.0f} %" for x in own.tolist()),
            ]
            for name, own in estimate.shares.items()
        ]
        if rows:
            caption = f"{estimate.method[:1].upper()}{estimate.method[1:]}: part of the bags of "
            grids.append(
                Grid(
                    head=["", *table.speeds],
                    groups=[Group(rows=rows)],
                    caption=f"{caption}runs in which each term was taken.",
                )
            )
    return grids


def _place(table: DerivativeTable, froude: float) -> int | None:
    """Row of a Froude number; None where the table has none."""
    if table.pooled or math.isnan(froude):
        return 0 if table.pooled else None
    near = np.flatnonzero(np.isclose(table.Fn, froude, rtol=0.01))
    return int(near[0]) if len(near) else None


def _entry(table: DerivativeTable, name: str, froude: float, scale: float) -> str | None:
    row = _place(table, froude)
    if name not in table or row is None:
        return ""
    low, high = table.interval()
    column = table.index(name)
    half = scale * (high[row, column] - low[row, column]) / 2
    return plus_minus(scale * table.value[row, column], half)


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
    """How many runs of each kind there are, and at which Froude numbers."""
    count = Counter((item.run.test, f"{item.froude:.3f}") for item in reduction.runs)
    rows: list[list[str | None]] = []
    for test in TEST_KINDS.values():
        speeds = {
            froude: number for (kind, froude), number in sorted(count.items()) if kind == test.name
        }
        if speeds:
            places = ", ".join(f"{froude} ({number})" for froude, number in speeds.items())
            rows.append([test.title, str(sum(speeds.values())), places])
    return Grid(head=["Test", "Runs", "At Fn (runs)"], groups=[Group(rows=rows)], texts=(2,))


def settings(reduction: Reduction) -> Grid:
    """Every run with its settings and what of its record counts."""
    rows: list[list[str | None]] = []
    for item in reduction.runs:
        rows.append(
            [
                item.run.id,
                item.run.kind_of_test.title,
                f"{item.froude:.3f}",
                ", ".join(item.run.settings.words) or "straight",
                item.window,
            ]
        )
    return Grid(
        head=["Run", "Test", "Fn", "Setting", "What counts"],
        groups=[Group(rows=rows)],
        texts=(1, 3, 4),
    )


def left_out(campaign: Campaign) -> list[Grid]:
    """Runs that were left out, by reason; no table where there are none."""
    reasons: dict[str, list[str]] = {}
    for run, reason in campaign.excluded:
        reasons.setdefault(reason, []).append(run.id)
    rows = [[name_runs(ids, 30), reason] for reason, ids in reasons.items()]
    head = ["Runs left out", "Because"]
    return [Grid(head=head, groups=[Group(rows=rows)], texts=(0, 1))] if rows else []


def corrections(campaign: Campaign) -> list[Grid]:
    """What was done to the data because the campaign file says so; no table where nothing was."""
    every = (*campaign.runs, *(run for run, _ in campaign.excluded))
    rows = dict.fromkeys(
        (item.action, name_runs(item.runs), item.reason)
        for run in every
        for item in run.corrections
    )
    head = ["Correction", "Runs", "Reason"]
    group = Group(rows=[list(item) for item in rows])
    return [Grid(head=head, groups=[group], texts=(1, 2))] if rows else []


def particulars_of(ship: Ship, water: Water) -> Sequence[tuple[str, float | None, str, str, str]]:
    """The model as tested and the water, those too that are not known.

    What each is, its value [SI], its unit, and table and key of the campaign file that state it.
    """
    return (
        ("Length between perpendiculars L", ship.L, "m", "ship", "L"),
        ("Breadth B", ship.B, "m", "ship", "B"),
        ("Draught d", ship.d, "m", "ship", "d"),
        ("Displaced volume", ship.volume, "m³", "ship", "volume"),
        ("Block coefficient", ship.block, "–", "ship", "CB"),
        ("Mass", ship.mass, "kg", "ship", "mass"),
        ("Centre of gravity forward of midship", ship.xG, "m", "ship", "xG"),
        ("Centre of gravity below the origin", ship.zG, "m", "ship", "zG"),
        ("Metacentric height GM", ship.GM, "m", "ship", "GM"),
        ("Yaw inertia about midship", ship.Izz, "kg m²", "ship", "Izz"),
        ("Roll inertia", ship.Ixx, "kg m²", "ship", "Ix"),
        ("Density of the water", water.rho, "kg/m³", "water", "rho"),
        ("Kinematic viscosity", water.nu, "m²/s", "water", "nu"),
        ("Water depth", water.depth, "m", "water", "depth"),
        ("Width of the tank", water.tank_width, "m", "water", "tank_width"),
        ("Depth of the tank", water.tank_depth, "m", "water", "tank_depth"),
    )


def particulars(reduction: Reduction) -> Grid:
    """The model as tested, and the water."""
    ship, water = reduction.campaign.ship, reduction.campaign.water
    rows = [
        [what, number(value, 6), unit]
        for what, value, unit, _, _ in particulars_of(ship, water)
        if value is not None
    ]
    return Grid(head=[ship.name, "", ""], groups=[Group(rows=rows)], texts=(2,))
