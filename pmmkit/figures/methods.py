"""The same derivatives by several methods: a forest plot."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.errors import TableError
from pmmkit.numerics import Array
from pmmkit.plotting import style
from pmmkit.plotting.marks import beyond
from pmmkit.tables import DerivativeTable, compare
from pmmkit.tables.compare import Reference

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LIMIT: Final = 4.0
"""Half width of the axis, in half intervals of the first method."""
_ROW: Final = 0.13


def forest(
    tables: Mapping[str, DerivativeTable],
    *,
    reference: Reference | None = None,
    reference_name: str = "published",
) -> Figure:
    """Every derivative by several methods with 95 % intervals, a panel per Froude number.

    Parameters
    ----------
    tables : mapping of str to DerivativeTable
        By the name of the method; the first is what the others are compared with. Its Froude
        numbers and derivatives are shown.
    reference : DerivativeTable or mapping, optional
        Published values, as in `tables.compare`, drawn as crosses.
    reference_name : str
        Their name in the legend.

    Returns
    -------
    Figure
        Difference to the first method over half of its 95 % interval: within the grey band the
        methods agree. What lies outside the axis is an arrow with its number.

    Raises
    ------
    TableError
        If there are fewer than two tables.
    """
    if len(tables) < 2:
        raise TableError("A forest plot needs the tables of at least two methods.")
    (title, first), *others = tables.items()
    half = _half(first)
    shown = [row for row in range(len(first.Fn)) if np.isfinite(half[row]).any()]
    names = [name for name in first.names if np.isfinite(half[:, first.index(name)]).any()]
    published = {} if reference is None else _published(first, reference)
    with style.styled():
        figure = style.canvas(0.9 + _ROW * (1.2 + len(others)) * len(names))
        axes = figure.subplots(1, len(shown), squeeze=False, sharey=True)[0]
        for axis, row in zip(axes, shown, strict=True):
            froude = float(first.Fn[row])
            zero = _column(names, first, first.value, froude)
            scale = _column(names, first, half, froude)
            axis.axvspan(-1.0, 1.0, color="#e6e6e6", lw=0, zorder=0, label=f"{title}, 95 %")
            axis.axvline(0.0, color=style.REFERENCE, lw=1.0, ls="--", zorder=1)
            places = np.arange(len(names), dtype=float)
            for number, (label, table) in enumerate(others):
                shift = _shift(number, len(others) + 1)
                value, low, high = (
                    (_column(names, table, own, froude) - zero) / scale
                    for own in (table.value, *table.interval())
                )
                _bars(axis, value, low, high, places + shift, number, label)
            if published:
                beside = [published[name][row] if name in published else np.nan for name in names]
                shift = _shift(len(others), len(others) + 1)
                _crosses(axis, (np.array(beside) - zero) / scale, places + shift, reference_name)
            axis.set_xlim(-_LIMIT, _LIMIT)
            axis.set_ylim(len(names) - 0.4, -0.6)
            axis.set_yticks(places, [style.symbol(name, first.convention) for name in names])
            axis.grid(visible=False, axis="y")
            axis.set_title("all speeds" if first.pooled else f"Fn {froude:.3f}")
        axes[len(axes) // 2].set_xlabel(
            f"difference to the {title} / half of its 95 % interval [-]"
        )
        style.legend_below(figure, list(axes), columns=3)
    return figure


def _shift(number: int, count: int) -> float:
    """Where one of several marks of a row stands."""
    return 0.76 * ((number + 0.5) / count - 0.5)


def _half(table: DerivativeTable) -> Array:
    """Half of the 95 % intervals; NaN where there are none."""
    low, high = table.interval()
    return np.where(high > low, (high - low) / 2, np.nan)


def _published(table: DerivativeTable, reference: Reference) -> dict[str, Array]:
    frame = compare(table, reference)
    return {
        str(name): group["reference"].to_numpy(float)
        for name, group in frame.groupby("derivative", sort=False)
    }


def _column(names: list[str], table: DerivativeTable, values: Array, froude: float) -> Array:
    """Values of some derivatives at a Froude number; NaN where the table has none."""
    rows = np.flatnonzero(np.isclose(table.Fn, froude, rtol=1e-6, equal_nan=True))
    if not len(rows):
        return np.full(len(names), np.nan)
    return np.array(
        [values[rows[0], table.index(name)] if name in table else np.nan for name in names]
    )


def _bars(
    axis: Axes, value: Array, low: Array, high: Array, places: Array, number: int, label: str
) -> None:
    colour = style.colour(number)
    axis.hlines(places, low.clip(-_LIMIT, _LIMIT), high.clip(-_LIMIT, _LIMIT), color=colour, lw=1.4)
    inside = np.abs(value) <= _LIMIT
    axis.plot(
        value[inside],
        places[inside],
        ls="",
        marker=style.marker(number),
        ms=3.5,
        color=colour,
        label=f"{label}, 95 %",
        zorder=3,
    )
    beyond(axis, value, places, _LIMIT, colour)


def _crosses(axis: Axes, value: Array, places: Array, label: str) -> None:
    inside = np.abs(value) <= _LIMIT
    axis.plot(
        value[inside],
        places[inside],
        ls="",
        marker="x",
        ms=5,
        color=style.INK,
        label=label,
        zorder=4,
    )
    beyond(axis, value, places, _LIMIT, style.INK)
