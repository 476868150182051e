"""Derivative tables: over the Froude number, and beside the values of a source."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from pmmkit.base import TableError
from pmmkit.conventions import CHANNELS, parse_derivative
from pmmkit.models import DerivativeTable, compare
from pmmkit.numerics import Array
from pmmkit.plotting import REFERENCE, canvas, legend_below, marker, styled
from pmmkit.plotting import colour as colour_style
from pmmkit.presentation import figure_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

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
        A matplotlib figure.

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
    with styled():
        figure = canvas(_ROW * (1 + 0.5 * sets) * len(shown) + 0.2 * len(channels) + 0.8)
        axes = figure.subplots(
            len(channels), 1, sharex=True, squeeze=False, height_ratios=counts
        ).ravel()
        for axis, channel in zip(axes, channels, strict=True):
            group = [name for name in shown if name[0] == channel]
            columns = [table.index(name) for name in group]
            for row in range(sets):
                place = np.arange(len(group)) + 0.22 * (row - (sets - 1) / 2)
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
            axis.grid(visible=False, axis="y")
        axes[-1].set_xlabel(f"value over that of {figure_text(reference_name)} [-]")
        legend_below(figure, list(axes))
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
    colour = colour_style(number)
    axis.hlines(place, ends[0].clip(*limits), ends[1].clip(*limits), color=colour, lw=1.6)
    inside = (ratio >= limits[0]) & (ratio <= limits[1])
    axis.plot(ratio[inside], place[inside], ls="", marker=marker(number), color=colour, label=label)
    for value, height in zip(ratio[~inside], place[~inside], strict=True):
        if np.isnan(value):
            continue
        right = bool(value > limits[1])
        axis.plot(limits[right], height, marker=">" if right else "<", color=colour, clip_on=False)
        axis.annotate(
            f"{value:.3g}",
            (limits[right], height),
            xytext=(-8 if right else 8, 0),
            textcoords="offset points",
            ha="right" if right else "left",
            va="center",
            fontsize=8,
            color=colour,
        )


def _limits(ends: np.ndarray) -> tuple[float, float]:
    """Ends of the axis that hold all intervals and 1, as far as that is readable."""
    known = ends[np.isfinite(ends)]
    low, high = (float(known.min()), float(known.max())) if len(known) else (0.5, 1.5)
    low, high = min(low, 0.9), max(high, 1.1)
    room = 0.04 * (high - low)
    return max(low - room, _WIDEST[0]), min(high + room, _WIDEST[1])
