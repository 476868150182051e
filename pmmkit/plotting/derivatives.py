"""Derivatives over the Froude number."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.conventions import Convention
from pmmkit.numerics import Array
from pmmkit.plotting import style
from pmmkit.presentation import figure_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COLUMNS: Final = 4


def over_froude(
    names: Sequence[str],
    Fn: Array,
    value: Array,
    interval: tuple[Array, Array],
    *,
    convention: Convention,
    factor: float = 1.0,
    beside: tuple[str, Mapping[str, Array]] | None = None,
) -> Figure:
    """Derivatives over the Froude number with their intervals, one small panel each.

    Parameters
    ----------
    names : sequence of str (n,)
        Derivatives.
    Fn : array (k,)
        Froude numbers.
    value : array (k, n)
        Values.
    interval : (array, array)
        Ends of their intervals.
    convention : Convention
        For their symbols.
    factor : float
        What is drawn is the values times 1 or 1000.
    beside : (str, mapping of str to array (k,)), optional
        Values of a source with its name, drawn as lines.
    """
    low, high = interval
    prefix = r"$10^3\,$" if factor == 1e3 else ""
    margin = 0.12 * (Fn[-1] - Fn[0]) or 0.02
    rows = math.ceil(len(names) / _COLUMNS)
    with style.styled():
        figure = style.canvas(1.45 * rows + 0.7)
        axes = figure.subplots(rows, _COLUMNS, squeeze=False, sharex=True).ravel()
        style.in_powers(axes)
        for column, (axis, name) in enumerate(zip(axes, names, strict=False)):
            own = factor * value[:, column]
            error = [own - factor * low[:, column], factor * high[:, column] - own]
            axis.set_title(prefix + style.symbol(name, convention))
            if np.all(np.isnan(own)):
                _say(axis, "not determined\nby these runs")
                axis.set_yticks([])
                continue
            if beside and name in beside[1]:
                axis.plot(
                    [Fn[0] - margin, *Fn, Fn[-1] + margin],
                    factor * beside[1][name][[0, *range(len(Fn)), -1]],
                    color=style.REFERENCE,
                    ls="--",
                    lw=1.2,
                    label=figure_text(beside[0]),
                )
            axis.errorbar(
                Fn,
                own,
                np.nan_to_num(error),
                color=style.ORDERED[0],
                marker="o",
                lw=1.2,
                capsize=3,
                label="this table, 95 % interval",
            )
            axis.set_xlim(Fn[0] - margin, Fn[-1] + margin)
            axis.margins(y=0.18)
            axis.locator_params(axis="y", nbins=4)
            axis.locator_params(axis="x", nbins=4)
        for axis in axes[len(names) :]:
            axis.set_axis_off()
        _label_lowest(axes, len(names), "Froude number [-]")
        style.legend_below(figure, list(axes[: len(names)]))
    return figure


def _say(axis: Axes, text: str) -> None:
    axis.text(
        0.5,
        0.5,
        text,
        transform=axis.transAxes,
        ha="center",
        va="center",
        color=style.REFERENCE,
        fontsize=9,
    )


def _label_lowest(axes: np.ndarray, used: int, label: str) -> None:
    """Ticks and label under the lowest panel of each column."""
    for column in range(_COLUMNS):
        panels = range(column, used, _COLUMNS)
        if panels:
            axes[panels[-1]].tick_params(labelbottom=True)
            axes[panels[-1]].set_xlabel(label)


def influence_map(
    share: Array, runs: Sequence[str], names: Sequence[str], odd: Collection[str]
) -> Figure:
    """Runs against derivatives, coloured by how far each run moves each of them.

    Parameters
    ----------
    share : array (runs, derivatives)
        Change over half of the 95 % interval; NaN where there is none.
    runs, names : sequence of str
        Rows and columns.
    odd : collection of str
        Runs at odds with the others, marked.
    """
    with style.styled():
        figure = style.canvas(0.16 * len(runs) + 1.6)
        axis = figure.subplots()
        picture = axis.imshow(share, cmap="RdBu_r", vmin=-2.0, vmax=2.0, aspect="auto")
        axis.grid(visible=False)
        axis.set_xticks(range(len(names)), names, rotation=90, fontsize="x-small")
        told = [f"{run}  at odds" if run in odd else run for run in runs]
        axis.set_yticks(range(len(runs)), told, fontsize="x-small")
        for row, column in np.argwhere(np.abs(np.nan_to_num(share)) > 1.0).tolist():
            value = share[row, column]
            axis.annotate(
                f"{value:+.1f}",
                (column, row),
                ha="center",
                va="center",
                fontsize="xx-small",
                color="white",
            )
        bar = figure.colorbar(picture, ax=axis, extend="both", shrink=0.5, aspect=30)
        bar.set_label("Change by the run / half of the 95 % interval [-]")
        axis.set_title("What each run does to each derivative")
    return figure
