"""Identified parameters beside what was known before."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final, Protocol

import numpy as np

from pmmkit.base import DataError
from pmmkit.conventions import Convention
from pmmkit.numerics import Array
from pmmkit.plotting import REFERENCE, Axes, Figure, beyond, marker
from pmmkit.plotting import colour as colour_style
from pmmkit.presentation import WIDE, figure_text

if TYPE_CHECKING:
    import xarray as xr

_COLUMNS, _BINS = 4, 20
_FARTHEST: Final = 6.0
"""Distance from the prior, in its standard deviations, up to which values are drawn."""


class FoundParameters(Protocol):
    """What is drawn of the parameters that a method found."""

    @property
    def method(self) -> str:
        """Its name."""

    @property
    def names(self) -> tuple[str, ...]:
        """Parameters."""

    @property
    def unseen(self) -> tuple[str, ...]:
        """Those that the records do not determine."""

    def scaled(self) -> tuple[Array, Array]:
        """Value less prior mean and half of the 95 % interval, over the prior's deviation."""


def parameters(found: Sequence[FoundParameters], convention: Convention) -> Figure:
    """Intervals of 95 % before and after, per parameter and method."""
    if not found:
        raise DataError("There is no result to draw.")
    names = list(dict.fromkeys(name for item in found for name in item.names))
    ends = np.concatenate([np.abs(x) + y for item in found for x, y in (item.scaled(),)])
    limit = min(max([2.4, *ends[np.isfinite(ends)].tolist()]) * 1.05, _FARTHEST)
    figure = Figure(height=0.9 + (0.16 + 0.13 * len(found)) * len(names), width=7.2)
    axis = figure.subplots()
    places = np.arange(len(names), dtype=float)
    axis.barh(
        places, 2 * WIDE, left=-WIDE, height=0.82, color="#e6e6e6", label="prior, 95 %", zorder=0
    )
    axis.axvline(0.0, color=REFERENCE, lw=1.0, ls="--", zorder=1)
    for number, item in enumerate(found):
        shift = 0.66 * ((number + 0.5) / len(found) - 0.5)
        at = np.array([places[names.index(name)] for name in item.names]) + shift
        _intervals(axis, item, at, number, limit)
    axis.set_yticks(places, [convention.symbol(name) for name in names])
    axis.set_ylim(len(names) - 0.4, -0.6)
    axis.set_xlim(-limit, limit)
    axis.without_grid("y")
    axis.set_xlabel("(value - prior mean) / standard deviation of the prior [-]")
    figure.legend_below([axis], columns=3)
    return figure


def marginals(tree: xr.DataTree, convention: Convention | None = None) -> Figure:
    """Distributions of everything drawn from a posterior, a line an ensemble, beside the prior."""
    drawn, before = tree["posterior"].to_dataset(), tree["prior"].to_dataset()
    names = [str(name) for name in drawn.data_vars]
    rows = -(-len(names) // _COLUMNS)
    figure = Figure(height=0.4 + 1.5 * rows)
    axes = figure.subplots(rows, _COLUMNS, squeeze=False).ravel()
    for axis, name in zip(axes, names, strict=False):
        values = drawn[name].to_numpy()
        edges = np.linspace(values.min(), values.max(), _BINS + 1)
        inside = before[name].to_numpy().ravel()
        share = np.histogram(inside, edges)[0] / inside.size / np.diff(edges)
        axis.stairs(share, edges, fill=True, color="#e6e6e6", label="prior")
        for number, own in enumerate(values):
            axis.stairs(
                np.histogram(own, edges, density=True)[0],
                edges,
                lw=1.0,
                color=colour_style(number),
                label=f"ensemble {number + 1}",
            )
        shown = name if convention is None else convention.symbol(name)
        axis.set_title(figure_text(shown.replace("_", " ")) if "_" in name else shown)
        axis.set_yticks([])
        axis.ticks_at_most(4, side="x")
    for axis in axes[len(names) :]:
        axis.remove()
    figure.legend_below([axes[0]], columns=5)
    return figure


def _intervals(
    axis: Axes, item: FoundParameters, at: np.ndarray, number: int, limit: float
) -> None:
    colour = colour_style(number)
    value, half = item.scaled()
    low, high = value - half, value + half
    axis.hlines(at, low.clip(-limit, limit), high.clip(-limit, limit), color=colour, lw=1.6)
    inside = np.abs(value) <= limit
    seen = np.array([name not in item.unseen for name in item.names])
    for kept, face in ((inside & seen, colour), (inside & ~seen, "white")):
        axis.plot(
            value[kept],
            at[kept],
            ls="",
            marker=marker(number),
            color=colour,
            ms=4.5,
            markerfacecolor=face,
            label=f"{item.method}, 95 %" if face == colour else None,
            zorder=3,
        )
    beyond(axis, value, at, (-limit, limit), colour)
