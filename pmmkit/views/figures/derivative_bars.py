"""Derivatives of several laboratories as bars side by side."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.base import TableError
from pmmkit.conventions import CHANNELS
from pmmkit.models import DerivativeTable, alike
from pmmkit.plotting import REFERENCE, canvas, colour, hatch, in_powers, legend_below, styled
from pmmkit.presentation import figure_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

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
    >>> [len(axis.patches) for axis in derivative_bars({"tank": D, "CFD": S}).axes]
    [2, 2]
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
    with styled():
        figure = canvas(1.9 * rows + 1.1)
        axes = figure.subplots(
            rows, columns, squeeze=False, sharey="row" if len(first.Fn) > 1 else False
        )
        in_powers(axes.flat)
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
            axis.grid(visible=False, axis="x")
            line, column = place
            if (line, column - 1) not in panels:
                axis.set_ylabel(f"$10^3\\times$ {names[0][0]} [-]")
            if not first.pooled and panels.get((line - 1, column), ([], -1))[1] != row:
                axis.set_title(f"Fn {first.Fn[row]:.3f}")
        legend_below(figure, figure.axes)
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
        hatch=hatch(number) if number else None,
        edgecolor="white",
        linewidth=0.4,
        error_kw={"elinewidth": 0.9, "capsize": 2},
        label=label,
    )
