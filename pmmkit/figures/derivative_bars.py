"""Derivatives of several laboratories as bars side by side."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.conventions import CHANNELS
from pmmkit.errors import TableError
from pmmkit.escaping import figure_text
from pmmkit.plotting import style
from pmmkit.tables import DerivativeTable
from pmmkit.tables.compare import alike

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LEAST: Final = 4
"""Places of a panel, so that the bars of a single derivative are no wider than others."""
_ROOM: Final = 0.8
"""Share of a derivative's place that its bars fill."""


def derivative_bars(tables: Mapping[str, DerivativeTable]) -> Figure:
    """The derivatives of two tables or more as bars beside each other, with 95 % intervals.

    Parameters
    ----------
    tables : mapping of str to DerivativeTable
        By the name of the laboratory, the measurement first; the others are brought to its
        convention and Froude numbers, of which the middle one is shown.

    Returns
    -------
    Figure
        A row a channel; on the left derivatives of first order and accelerations, on the right
        those of higher order, each panel with a scale of its own.

    Raises
    ------
    TableError
        If there are fewer than two tables, or no derivative in common.

    Examples
    --------
    >>> from pmmkit.ship import Ship, Water
    >>> from pmmkit.tables import from_values
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
    groups = {
        channel: [
            [name for name in shown if name[0] == channel and _first_order(name) == low]
            for low in (True, False)
        ]
        for channel in CHANNELS
        if any(name[0] == channel for name in shown)
    }
    if not groups:
        raise TableError("The tables have no derivative in common.")
    row = len(first.Fn) // 2
    with style.styled():
        figure = style.canvas(1.9 * len(groups) + 1.1)
        axes = figure.subplots(len(groups), 2, squeeze=False)
        style.in_powers(axes.flat)
        for (channel, pair), line in zip(groups.items(), axes, strict=True):
            for axis, names in zip(line, pair, strict=True):
                if not names:
                    axis.remove()
                    continue
                for number, (source, table) in enumerate({label: first, **others}.items()):
                    place = 0 if table.pooled else row
                    _bars(axis, names, table, place, number, len(tables), figure_text(source))
                axis.axhline(0.0, color=style.REFERENCE, lw=0.8)
                axis.set_xticks(
                    np.arange(len(names)), [style.symbol(name, first.convention) for name in names]
                )
                axis.set_xlim(-0.6, max(len(names), _LEAST) - 0.4)
                axis.grid(visible=False, axis="x")
            line[0 if pair[0] else 1].set_ylabel(f"$10^3\\times$ {channel} [-]")
        if not first.pooled:
            figure.suptitle(f"Fn {first.Fn[row]:.3f}", x=0.01, ha="left", fontsize=9)
        style.legend_below(figure, figure.axes)
    return figure


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
        color=style.colour(number),
        hatch=style.hatch(number) if number else None,
        edgecolor="white",
        linewidth=0.4,
        error_kw={"elinewidth": 0.9, "capsize": 2},
        label=label,
    )
