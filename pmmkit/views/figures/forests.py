"""The same derivatives by several methods, families of tests or laboratories: a forest plot."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from pmmkit.base import TableError
from pmmkit.models import DerivativeTable, alike, compare
from pmmkit.numerics import Array
from pmmkit.plotting import INK, REFERENCE, Axes, Figure, beyond, dash, marker
from pmmkit.plotting import colour as colour_style

_LIMIT: Final = 4.0
"""Half width of the axis, in half intervals of the first method."""
_ROW: Final = 0.13
"""Height of a mark [inch]."""
_GAP: Final = 1.0
"""Room between two derivatives, in heights of a mark."""
_PALE: Final = "#f4f5f7"
_BAND: Final = "#dadde2"


def forest(
    tables: Mapping[str, DerivativeTable],
    *,
    reference: DerivativeTable | Mapping[str, float | Sequence[float]] | None = None,
    reference_name: str = "published",
) -> Figure:
    """Every derivative from several sources with 95 % intervals, a panel per Froude number."""
    if len(tables) < 2:
        raise TableError("A forest plot needs the tables of at least two methods.")
    (title, first), *rest = tables.items()
    others = {label: _alike(first, table) for label, table in rest}
    half = _half(first)
    shown = _rows(first, half, others)
    published = {} if reference is None else _published(first, reference)
    sources = {name: _sources(name, others, published, reference_name) for name in first.names}
    names = [
        name
        for name in first.names
        if sources[name] and np.isfinite(half[shown, first.index(name)]).any()
    ]
    if not names:
        raise TableError("No derivative has a value and an interval in two of the tables.")
    sizes = np.array([len(sources[name]) + _GAP for name in names])
    tops = np.cumsum(sizes) - sizes
    figure = Figure(height=1.0 + _ROW * float(sizes.sum()))
    axes = figure.subplots(1, len(shown), squeeze=False, sharey=True)[0]
    for axis, row in zip(axes, shown, strict=True):
        froude = float(first.Fn[row])
        zero = _column(names, first, first.value, froude)
        scale = _column(names, first, half, froude)
        axis.axvspan(-1.0, 1.0, color=_BAND, zorder=0.5, label=f"{title}, 95 %")
        axis.axvline(0.0, color=REFERENCE, lw=1.0, ls="--", zorder=1)
        for top, size in zip(tops[1::2], sizes[1::2], strict=True):
            axis.axhspan(top, top + size, color=_PALE, zorder=0)
        for number, (label, table) in enumerate(others.items()):
            value, low, high = (
                (_column(names, table, own, froude) - zero) / scale
                for own in (table.value, *table.interval())
            )
            places = _places(label, names, sources, tops)
            _bars(axis, value, low, high, places, number, label)
        if published:
            beside = [published[name][row] if name in published else np.nan for name in names]
            places = _places(reference_name, names, sources, tops)
            _crosses(axis, (np.array(beside) - zero) / scale, places, reference_name)
        axis.set_xlim(-_LIMIT, _LIMIT)
        axis.set_ylim(float(sizes.sum()), 0.0)
        axis.set_yticks(tops + sizes / 2, [f"${first.convention.latex(name)}$" for name in names])
        axis.without_grid("y")
        axis.set_title("all speeds" if first.pooled else f"Fn {froude:.3f}")
    figure.supxlabel(f"difference to the {title} / half of its 95 % interval [-]")
    figure.legend_below(list(axes), columns=3)
    return figure


def farthest(tables: Mapping[str, DerivativeTable]) -> list[str]:
    """How many values lie outside the interval of the first table, and which is farthest."""
    (title, first), *rest = tables.items()
    half, names = _half(first), list(first.names)
    found: list[tuple[float, str, str, float]] = []
    for label, table in rest:
        other = _alike(first, table)
        for row, froude in enumerate(first.Fn.tolist()):
            own = (_column(names, other, other.value, froude) - first.value[row]) / half[row]
            found += [
                (value, name, label, froude)
                for value, name in zip(own.tolist(), names, strict=True)
                if np.isfinite(value)
            ]
    if not found:
        return []
    outside = sum(abs(value) > 1 for value, *_ in found)
    value, name, label, froude = max(found, key=lambda item: abs(item[0]))
    place = "" if np.isnan(froude) else f" at Fn {froude:.3f}"
    return [
        f"{outside} of {len(found)} values lie outside the 95 % interval of the {title}; the "
        f"farthest is {name} by {label}{place}, {value:+.2g} half intervals away."
    ]


def _rows(first: DerivativeTable, half: Array, others: Mapping[str, DerivativeTable]) -> list[int]:
    """Froude numbers at which two sources have a derivative beside the first; all if none has.

    Where a single one does it may be all that the first rests on, and agrees by construction.
    """
    known = [row for row in range(len(first.Fn)) if np.isfinite(half[row]).any()]
    names = list(first.names)
    several = []
    for row in known:
        froude = float(first.Fn[row])
        there = [
            np.isfinite(_column(names, table, table.value, froude)) for table in others.values()
        ]
        if np.any(np.sum(there, axis=0) > 1):
            several.append(row)
    return several or known


def _alike(first: DerivativeTable, table: DerivativeTable) -> DerivativeTable:
    """A table in the convention and at the Froude numbers of the first."""
    same = table.pooled == first.pooled and set(table.Fn[~np.isnan(table.Fn)]) <= set(first.Fn)
    return table if same and table.convention == first.convention else alike(first, table)


def _sources(
    name: str,
    others: Mapping[str, DerivativeTable],
    published: Mapping[str, Array],
    reference_name: str,
) -> list[str]:
    """Which sources have a derivative, in their order."""
    found = [
        label for label, table in others.items() if name in table and np.isfinite(table[name]).any()
    ]
    return [*found, *([reference_name] if name in published else [])]


def _places(
    label: str, names: Sequence[str], sources: Mapping[str, Sequence[str]], tops: Array
) -> Array:
    """Where the marks of a source stand; NaN for derivatives that it has not."""
    return np.array(
        [
            top + 0.5 * (1.0 + _GAP) + sources[name].index(label)
            if label in sources[name]
            else np.nan
            for name, top in zip(names, tops, strict=True)
        ]
    )


def _half(table: DerivativeTable) -> Array:
    """Half of the 95 % intervals; NaN where there are none."""
    low, high = table.interval()
    return np.where(high > low, (high - low) / 2, np.nan)


def _published(
    table: DerivativeTable, reference: DerivativeTable | Mapping[str, float | Sequence[float]]
) -> dict[str, Array]:
    frame = compare(table, reference)
    return {
        str(name): group["reference"].to_numpy(float)
        for name, group in frame.groupby("derivative", sort=False)
    }


def _column(names: list[str], table: DerivativeTable, values: Array, froude: float) -> Array:
    """Values of some derivatives at a Froude number; NaN where the table has none."""
    near = np.isclose(table.Fn, froude, rtol=1e-6, equal_nan=True)
    rows = np.flatnonzero(near | table.pooled)
    if not len(rows):
        return np.full(len(names), np.nan)
    return np.array(
        [values[rows[0], table.index(name)] if name in table else np.nan for name in names]
    )


def _bars(
    axis: Axes, value: Array, low: Array, high: Array, places: Array, number: int, label: str
) -> None:
    colour = colour_style(number)
    axis.hlines(
        places,
        low.clip(-_LIMIT, _LIMIT),
        high.clip(-_LIMIT, _LIMIT),
        color=colour,
        lw=1.4,
        ls=dash(number, rounds=True),
    )
    inside = np.abs(value) <= _LIMIT
    axis.plot(
        value[inside],
        places[inside],
        ls="",
        marker=marker(number),
        ms=3.5,
        color=colour,
        label=f"{label}, 95 %",
        zorder=3,
    )
    beyond(axis, value, places, (-_LIMIT, _LIMIT), colour)


def _crosses(axis: Axes, value: Array, places: Array, label: str) -> None:
    inside = np.abs(value) <= _LIMIT
    axis.plot(
        value[inside], places[inside], ls="", marker="x", ms=5, color=INK, label=label, zorder=4
    )
    beyond(axis, value, places, (-_LIMIT, _LIMIT), INK)
