"""Derivatives over the Froude number."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from pmmkit.conventions import Convention
from pmmkit.numerics import Array
from pmmkit.plotting import REFERENCE, Axes, Figure, colour
from pmmkit.presentation import figure_text

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

    Fn (k,); value (k, n); beside (k,).
    """
    low, high = interval
    prefix = r"$10^3\,$" if factor == 1e3 else ""
    margin = 0.12 * (Fn[-1] - Fn[0]) or 0.02
    rows = math.ceil(len(names) / _COLUMNS)
    figure = Figure(height=1.45 * rows + 0.7)
    axes = figure.subplots(rows, _COLUMNS, squeeze=False, sharex=True).ravel()
    for column, (axis, name) in enumerate(zip(axes, names, strict=False)):
        own = factor * value[:, column]
        error = [own - factor * low[:, column], factor * high[:, column] - own]
        axis.set_title(prefix + f"${convention.latex(name)}$")
        if np.all(np.isnan(own)):
            _say(axis, "not determined\nby these runs")
            axis.set_yticks([])
            continue
        if beside and name in beside[1]:
            axis.plot(
                [Fn[0] - margin, *Fn, Fn[-1] + margin],
                factor * beside[1][name][[0, *range(len(Fn)), -1]],
                color=REFERENCE,
                ls="--",
                lw=1.2,
                label=figure_text(beside[0]),
            )
        axis.errorbar(
            Fn,
            own,
            np.nan_to_num(error),
            color=colour(0),
            marker="o",
            lw=1.2,
            capsize=3,
            label="this table, 95 % interval",
        )
        axis.set_xlim(Fn[0] - margin, Fn[-1] + margin)
        axis.margins(y=0.18)
        axis.ticks_at_most(4, side="y")
        axis.ticks_at_most(4, side="x")
    for axis in axes[len(names) :]:
        axis.remove()
    _label_lowest(axes, len(names), "Froude number [-]")
    figure.legend_below(list(axes[: len(names)]))
    return figure


def _say(axis: Axes, text: str) -> None:
    axis.text(0.5, 0.5, text, fraction=True, ha="center", va="center", color=REFERENCE, fontsize=9)


def _label_lowest(axes: np.ndarray, used: int, label: str) -> None:
    """Ticks and label under the lowest panel of each column."""
    for column in range(_COLUMNS):
        panels = range(column, used, _COLUMNS)
        if panels:
            axes[panels[-1]].label_below(label)
