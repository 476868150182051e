"""Derivative tables: over Froude number and depth, beside a source, and how values go together."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from pmmkit.base import TableError
from pmmkit.conventions import CHANNELS, Convention, parse_derivative
from pmmkit.models import DerivativeTable, alike, compare
from pmmkit.numerics import Array
from pmmkit.plotting import (
    INK,
    RED_BLUE,
    REFERENCE,
    Axes,
    Figure,
    Shades,
    beyond,
    colour,
    hatch,
    marker,
)
from pmmkit.presentation import counted, figure_text
from pmmkit.reduction import Growth

# Derivatives of several laboratories as bars side by side.


_LEAST: Final = 4
"""Places of a panel, so that the bars of a single derivative are no wider than others."""
_BESIDE: Final = 3
"""Froude numbers beside each other."""
_ROOM: Final = 0.8
"""Share of a derivative's place that its bars fill."""


def derivative_bars(tables: Mapping[str, DerivativeTable]) -> Figure:
    """The derivatives of two tables or more as bars beside each other, with 95 % intervals.

    Parameters
    ----------
    tables : mapping of str to DerivativeTable
        By the name of the laboratory, the measurement first; the others are brought to its
        convention and Froude numbers.

    Returns
    -------
    Figure
        A column a Froude number, at most three beside each other, and a row a channel and order:
        derivatives of first order and accelerations, then those of higher order. One
        Froude number has a row a channel, with those of higher order on the right. What stands in
        one row of several Froude numbers has one scale.

    Raises
    ------
    TableError
        If there are fewer than two tables, or no derivative in common.

    Examples
    --------
    >>> from pmmkit.conventions import Ship, Water
    >>> from pmmkit.models import from_values
    >>> ship = Ship(name="m", L=4.0, B=1.0, d=0.25, volume=0.5, mass=500.0, Izz=500.0)
    >>> D, S = (from_values({"Yv": x, "Yvvv": 9 * x}, ship=ship, water=Water()) for x in (-.2, -.3))
    >>> [axis.xticks.labels for axis in derivative_bars({"tank": D, "CFD": S}).shown]
    [("$Y'_{v}$",), ("$Y'_{vvv}$",)]
    """
    if len(tables) < 2:
        raise TableError("Bars side by side need the tables of at least two sources.")
    (label, first), *rest = tables.items()
    others = {name: alike(first, table) for name, table in rest}
    shown = [name for name in first.names if all(name in table for table in others.values())]
    groups = [
        [
            [name for name in shown if name[0] == channel and _first_order(name) == low]
            for low in (True, False)
        ]
        for channel in CHANNELS
        if any(name[0] == channel for name in shown)
    ]
    if not groups:
        raise TableError("The tables have no derivative in common.")
    panels = _panels(groups, len(first.Fn))
    rows, columns = (1 + max(place[axis] for place in panels) for axis in (0, 1))
    figure = Figure(height=1.9 * rows + 1.1)
    axes = figure.subplots(
        rows, columns, squeeze=False, sharey="row" if len(first.Fn) > 1 else False
    )
    for place, axis in np.ndenumerate(axes):
        if place not in panels:
            axis.remove()
            continue
        names, row = panels[place]
        for number, (source, table) in enumerate({label: first, **others}.items()):
            own = 0 if table.pooled else row
            _bars(axis, names, table, own, number, len(tables), figure_text(source))
        axis.axhline(0.0, color=REFERENCE, lw=0.8)
        axis.set_xticks(
            np.arange(len(names)), [f"${first.convention.latex(name)}$" for name in names]
        )
        axis.set_xlim(-0.6, max(len(names), _LEAST) - 0.4)
        axis.without_grid("x")
        line, column = place
        if (line, column - 1) not in panels:
            axis.set_ylabel(f"$10^3\\times$ {names[0][0]} [-]")
        if not first.pooled and panels.get((line - 1, column), ([], -1))[1] != row:
            axis.set_title(f"Fn {first.Fn[row]:.3f}")
    figure.legend_below(figure.shown)
    return figure


def _panels(
    groups: Sequence[Sequence[Sequence[str]]], speeds: int
) -> dict[tuple[int, ...], tuple[Sequence[str], int]]:
    """Names and Froude number (its row in the tables) of each panel, by its row and column.

    Examples
    --------
    >>> _panels([[["Yv"], ["Yvvv"]]], 1)
    {(0, 0): (['Yv'], 0), (0, 1): (['Yvvv'], 0)}
    >>> sorted(_panels([[["Yv"], []]], 4))
    [(0, 0), (0, 1), (0, 2), (1, 0)]
    """
    if speeds == 1:
        return {
            (line, column): (names, 0)
            for line, pair in enumerate(groups)
            for column, names in enumerate(pair)
            if names
        }
    lines = [names for pair in groups for names in pair if names]
    return {
        (row // _BESIDE * len(lines) + line, row % _BESIDE): (names, row)
        for row in range(speeds)
        for line, names in enumerate(lines)
    }


def _first_order(name: str) -> bool:
    """Whether a derivative is one of first order, or of an acceleration.

    Examples
    --------
    >>> [_first_order(name) for name in ("Yv", "Nrdot", "Xuu", "Yv|v|", "Ydelta")]
    [True, True, False, False, True]
    """
    state = name[1:]
    return state.endswith("dot") or len(state) == 1 or state == "delta"


def _bars(
    axis: Axes,
    names: Sequence[str],
    table: DerivativeTable,
    row: int,
    number: int,
    count: int,
    label: str,
) -> None:
    columns = [table.index(name) for name in names]
    low, high = (1e3 * ends[row, columns] for ends in table.interval())
    value = 1e3 * table.value[row, columns]
    width = _ROOM / count
    axis.bar(
        np.arange(len(names)) + (number - (count - 1) / 2) * width,
        value,
        width,
        yerr=np.nan_to_num(np.abs([value - low, high - value])),
        color=colour(number),
        hatch=hatch(number) if number else "",
        label=label,
    )


# Which derivatives a programme of tests tells apart: their correlation.


_TOLD: Final = 0.5
"""Correlation from which on the number stands in its cell."""
_CELL: Final = 0.27
"""Side of a cell [inch]."""
_SHADES: Final = Shades(levels=(-1.0, 1.0), colours=RED_BLUE, smooth=True)


def correlated(table: DerivativeTable, Fn: float | None = None) -> tuple[list[str], Array]:
    """Correlation of the derivatives at one Froude number, by channel: X, Y, N, K.

    Examples
    --------
    >>> from pmmkit.conventions import Ship, Water
    >>> from pmmkit.models import from_values
    >>> ship = Ship(name="m", L=4.0, B=1.0, d=.25, volume=.5, mass=500., Izz=500.)
    >>> table = from_values({"Nv": -.004, "Yv": -.01}, std={"Nv": 1e-4, "Yv": 1e-4},
    ...                     ship=ship, water=Water())
    >>> correlated(table)
    (['Yv', 'Nv'], array([[1., 0.],
           [0., 1.]]))
    """
    row = _row(table, Fn)
    order = sorted(range(len(table.names)), key=lambda i: CHANNELS.index(table.names[i][0]))
    kept = [i for i in order if table.std[row, i] > 0]
    if len(kept) < 2:
        raise TableError("Fewer than two derivatives have an uncertainty: nothing is correlated.")
    own = table.covariance[row, kept][:, row, kept]
    std = table.std[row, kept]
    return [table.names[i] for i in kept], np.clip(own / np.outer(std, std), -1.0, 1.0)


def _row(table: DerivativeTable, Fn: float | None) -> int:
    if Fn is None:
        known = (table.std > 0).sum(axis=1)
        best = np.flatnonzero(known == known.max())
        return int(best[len(best) // 2])
    near = np.flatnonzero(np.isclose(table.Fn, Fn, rtol=1e-3, atol=0) | table.pooled)
    if not len(near):
        raise TableError(f"Fn {Fn:g} is no row of the table: {', '.join(map(str, table.Fn))}.")
    return int(near[0])


def correlations(table: DerivativeTable, Fn: float | None = None) -> Figure:
    """The correlation matrix of the derivatives, in blocks of X, Y, N and K."""
    names, matrix = correlated(table, Fn)
    size = len(names)
    figure = Figure(height=_CELL * size + 1.3, width=max(5.0, _CELL * size + 2.0))
    axis = figure.subplots()
    cells = axis.mosaic(matrix, _SHADES, x=-0.5, y=-0.5)
    axis.set_ylim(size - 0.5, -0.5)
    axis.set_aspect_equal("box")
    symbols = [f"${table.convention.latex(name)}$" for name in names]
    axis.set_xticks(range(size), symbols, rotation=90)
    axis.set_yticks(range(size), symbols)
    axis.without_frame()
    for place, (one, other) in enumerate(itertools.pairwise(names)):
        if one[0] != other[0]:
            axis.axhline(place + 0.5, color=INK, lw=1.0)
            axis.axvline(place + 0.5, color=INK, lw=1.0)
    _numbers(axis, matrix)
    figure.colour_key(cells, "correlation [-]; in the cells in hundredths")
    froude = table.Fn[_row(table, Fn)]
    axis.set_title("all speeds" if table.pooled else f"Fn {froude:.3f}")
    return figure


def strongest(names: Sequence[str], matrix: Array, most: int = 3) -> list[str]:
    """The strongest correlations in a sentence.

    matrix (n, n).

    Examples
    --------
    >>> strongest(["Yv", "Yvvv"], np.array([[1.0, -0.93], [-0.93, 1.0]]))
    ['Strongest correlations: Yv and Yvvv -0.93; 1 pair of 1 beyond 0.5.']
    """
    rows, columns = np.triu_indices(len(names), 1)
    values = matrix[rows, columns]
    order = np.argsort(-np.abs(values), kind="stable")[:most]
    told = [f"{names[rows[i]]} and {names[columns[i]]} {values[i]:+.2f}" for i in order.tolist()]
    beyond = counted(int(np.count_nonzero(np.abs(values) >= _TOLD)), "pair")
    return [f"Strongest correlations: {', '.join(told)}; {beyond} of {len(values)} beyond {_TOLD}."]


def _numbers(axis: Axes, matrix: Array) -> None:
    for row, column in np.argwhere(np.abs(matrix) >= _TOLD).tolist():
        if row != column:
            value = matrix[row, column]
            axis.text(
                column,
                row,
                f"{100 * value:+.0f}",
                ha="center",
                va="center",
                fontsize=6.5,
                color="white" if abs(value) > 0.7 else INK,
            )


# How derivatives grow as the bottom comes near.


_PANELS: Final = 4


def growth_over_depth(grown: Sequence[Growth], *, convention: Convention) -> Figure:
    """Factors by which derivatives grow over the depth, measured and by formulas, a panel each.

    Parameters
    ----------
    grown : sequence of Growth
        From the deepest water, where each is 1.
    convention : Convention
        For their symbols.
    """
    names = list(dict.fromkeys(item.name for item in grown))
    rows = math.ceil(len(names) / _PANELS)
    figure = Figure(height=1.9 * rows + 0.9)
    axes = figure.subplots(rows, min(_PANELS, len(names)), squeeze=False)
    panels = axes.ravel().tolist()
    for axis, name in zip(panels, names, strict=False):
        own = sorted((x for x in grown if x.name == name), key=lambda item: item.ratio)
        ratio = np.array([*(item.ratio for item in own), own[0].deepest])
        axis.axhline(1.0, color=REFERENCE, lw=0.8)
        axis.plot(
            ratio,
            [*(item.formula for item in own), 1.0],
            color=REFERENCE,
            ls="--",
            marker="x",
            label="formula",
        )
        axis.errorbar(
            ratio,
            [*(item.factor for item in own), 1.0],
            [*(item.half for item in own), 0.0],
            color=colour(0),
            marker="o",
            lw=1.2,
            capsize=3,
            label="measured, 95 % interval",
        )
        axis.set_title(f"${convention.latex(name)}$")
        axis.margins(x=0.15, y=0.18)
        axis.ticks_at_most(4, side="x")
        axis.ticks_at_most(4, side="y")
    for axis in panels[len(names) :]:
        axis.remove()
    for axis in panels[: len(names)]:
        axis.set_xlabel("h / T [-]")
    panels[0].set_ylabel("over the deepest [-]")
    figure.legend_below(panels[:1])
    return figure


_COLUMNS = 4
_ROW = 0.14
_WIDEST = (-0.5, 2.5)


def derivatives_over_froude(
    table: DerivativeTable,
    *,
    reference: DerivativeTable | Mapping[str, float | Sequence[float]] | None = None,
    reference_name: str = "reference",
    names: Sequence[str] | None = None,
) -> Figure:
    """Every derivative over the Froude number with its 95 % interval, one small panel each."""
    beside = None if reference is None else (reference_name, _beside(table, reference))
    return table.plot(names, beside=beside)


def beside_reference(
    table: DerivativeTable,
    reference: DerivativeTable | Mapping[str, float | Sequence[float]],
    *,
    reference_name: str = "the reference",
    names: Sequence[str] | None = None,
    limits: tuple[float, float] | None = None,
) -> Figure:
    """Each derivative over its value in a source, with its 95 % interval: at 1 they agree.

    Derivatives that the source does not have, or has as zero, are left out. What lies outside
    the limits is drawn as an arrow at the edge with its number.

    Parameters
    ----------
    table : DerivativeTable
        Our values.
    reference : DerivativeTable or mapping
        The source's values, as in `tables.compare`.
    reference_name : str
        Name of the source for the axis.
    names : sequence of str, optional
        Which derivatives; all by default.
    limits : tuple of float, optional
        Ends of the axis; by default as wide as the data, at most from -0.5 to 2.5.

    Returns
    -------
    Figure
        The figure.

    Raises
    ------
    TableError
        If the table and the source have no derivative in common.
    """
    known = {name: value for name, value in _beside(table, reference).items() if np.all(value)}
    shown = [
        name
        for name in (parse_derivative(name).name for name in names or table.names)
        if name in known
    ]
    if not shown:
        raise TableError("The table and the reference have no derivative in common.")
    unknown = np.full(len(table.Fn), np.nan)
    scale = np.stack([known.get(name, unknown) for name in table.names], axis=1)
    ratio, ends = table.value / scale, np.sort(np.array(table.interval()) / scale, axis=0)
    limits = limits or _limits(ends[:, :, [table.index(name) for name in shown]])
    channels = [channel for channel in CHANNELS if any(name[0] == channel for name in shown)]
    counts = [sum(name[0] == channel for name in shown) for channel in channels]
    sets = len(table.Fn)
    figure = Figure(height=_ROW * (1 + 0.5 * sets) * len(shown) + 0.2 * len(channels) + 0.8)
    axes = figure.subplots(
        len(channels), 1, sharex=True, squeeze=False, height_ratios=counts
    ).ravel()
    for axis, channel in zip(axes, channels, strict=True):
        group = [name for name in shown if name[0] == channel]
        columns = [table.index(name) for name in group]
        for row in range(sets):
            place = np.arange(len(group)) + 0.8 / sets * (row - (sets - 1) / 2)
            label = "all speeds" if table.pooled else f"Fn {table.Fn[row]:.3f}"
            _dots(axis, ratio[row, columns], ends[:, row, columns], place, row, label, limits)
        for gap in np.flatnonzero(np.all(np.isnan(ratio[:, columns]), axis=0)):
            axis.text(
                limits[0],
                gap,
                "  not determined by these runs",
                va="center",
                fontsize=8,
                color=REFERENCE,
            )
        axis.axvline(1.0, color=REFERENCE, ls="--", lw=1.2, zorder=1)
        axis.set_yticks(
            np.arange(len(group)), [f"${table.convention.latex(name)}$" for name in group]
        )
        axis.set_ylim(len(group) - 0.4, -0.6)
        axis.set_xlim(limits)
        axis.without_grid("y")
    axes[-1].set_xlabel(f"value over that of {figure_text(reference_name)} [-]")
    figure.legend_below(list(axes))
    return figure


def _beside(
    table: DerivativeTable, reference: DerivativeTable | Mapping[str, float | Sequence[float]]
) -> dict[str, Array]:
    """Values of the reference at the Froude numbers and in the convention of the table."""
    frame = compare(table, reference)
    return {
        str(name): group["reference"].to_numpy(float)
        for name, group in frame.groupby("derivative", sort=False)
    }


def _dots(
    axis: Axes,
    ratio: np.ndarray,
    ends: np.ndarray,
    place: np.ndarray,
    number: int,
    label: str,
    limits: tuple[float, float],
) -> None:
    shade = colour(number)
    axis.hlines(place, ends[0].clip(*limits), ends[1].clip(*limits), color=shade, lw=1.6)
    inside = (ratio >= limits[0]) & (ratio <= limits[1])
    axis.plot(ratio[inside], place[inside], ls="", marker=marker(number), color=shade, label=label)
    beyond(axis, ratio, place, limits, shade)


def _limits(ends: np.ndarray) -> tuple[float, float]:
    """Ends of the axis that hold all intervals and 1, as far as that is readable."""
    known = ends[np.isfinite(ends)]
    low, high = (float(known.min()), float(known.max())) if len(known) else (0.5, 1.5)
    low, high = min(low, 0.9), max(high, 1.1)
    room = 0.04 * (high - low)
    return max(low - room, _WIDEST[0]), min(high + room, _WIDEST[1])
