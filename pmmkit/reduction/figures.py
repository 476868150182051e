"""Shares of a whole as stacked bars, what a fit leaves, and what each run does."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Final

import numpy as np

from pmmkit.numerics import Array
from pmmkit.plotting import RED_BLUE, REFERENCE, Figure, Shades, colour, hatch, marker
from pmmkit.presentation import figure_text

TOLD_APART: Final = 9
"""Parts that are drawn each for itself; the rest are one."""
BESIDE: Final = 3
"""Panels in a row."""


def stacked_shares(
    panels: Mapping[str, tuple[Sequence[str], Array]], parts: Sequence[str]
) -> Figure:
    """Shares as horizontal bars, in per cent; negative ones to the left of zero.

    panels (parts, bars).
    """
    labels = [*parts[:TOLD_APART], *(["all others"] if len(parts) > TOLD_APART else [])]
    count = [len(names) for names, _ in panels.values()]
    longest = [max(count[start : start + BESIDE]) for start in range(0, len(count), BESIDE)]
    figure = Figure(height=0.25 * sum(longest) + 0.6 * (len(longest) - 1) + 1.6)
    grid = figure.subplots(
        len(longest), min(BESIDE, len(count)), squeeze=False, height_ratios=longest
    )
    axes = list(grid.flat)
    for axis in axes[len(count) :]:
        axis.remove()
    for place, (axis, (title, (names, shares))) in enumerate(
        zip(axes, panels.items(), strict=False)
    ):
        shown = [*shares[:TOLD_APART], shares[TOLD_APART:].sum(axis=0)][: len(labels)]
        right, left = np.zeros(len(names)), np.zeros(len(names))
        for number, (label, share) in enumerate(zip(labels, shown, strict=True)):
            start = np.where(share >= 0.0, right, left)
            axis.barh(
                np.arange(len(names)),
                100 * share,
                left=100 * start,
                height=0.72,
                color=colour(number) if number < TOLD_APART else REFERENCE,
                hatch=hatch(number, rounds=True),
                label=figure_text(label),
            )
            right = right + np.maximum(share, 0.0)
            left = left + np.minimum(share, 0.0)
        axis.set_yticks(np.arange(len(names)), [figure_text(name) for name in names])
        axis.set_ylim(longest[place // BESIDE] - 0.5, -0.5)
        axis.set_xlim(min(0.0, 100 * float(left.min())), 100 * float(right.max(initial=1.0)))
        axis.set_title(figure_text(title))
        if place + BESIDE >= len(count):
            axis.set_xlabel("share of the variance [%]")
        axis.without_grid("y")
    figure.legend_below(axes[: len(count)], columns=3)
    return figure


def left_by_the_fit(
    channels: Mapping[str, Mapping[str, tuple[Array, Array]]], units: Mapping[str, str]
) -> Figure:
    """What a fit leaves of the measured forces, over what was fitted."""
    kinds = list(dict.fromkeys(kind for groups in channels.values() for kind in groups))
    figure = Figure(height=1.15 * len(kinds) + 0.7)
    axes = figure.subplots(len(kinds), len(channels), squeeze=False, sharex="col", sharey="col")
    for column, (channel, groups) in zip(axes.T, channels.items(), strict=True):
        unit = units[channel]
        for number, (axis, kind) in enumerate(zip(column, kinds, strict=True)):
            axis.axhline(0.0, color=REFERENCE, lw=0.8)
            if kind not in groups:
                continue
            measured, fitted = groups[kind]
            left = measured - fitted
            axis.plot(
                fitted,
                left,
                ls="",
                ms=3.5,
                alpha=0.7,
                markeredgewidth=0.0,
                marker=marker(number),
                color=colour(number),
                label=kind,
            )
            axis.set_title(
                f"rms {np.sqrt(np.nanmean(left**2)):.2g} {unit}", loc="right", fontsize=8.5
            )
        column[0].set_title(f"{channel} [{unit}]")
        column[-1].set_xlabel(f"{channel} fitted [{unit}]")
    for axis, kind in zip(axes[:, 0], kinds, strict=True):
        axis.set_ylabel(kind.replace(" ", "\n", 1), level=True)
    figure.supylabel("measured less fitted")
    return figure


def influence_map(
    share: Array, runs: Sequence[str], names: Sequence[str], odd: Collection[str]
) -> Figure:
    """Runs against derivatives, coloured by how far each run moves each of them.

    share (runs, derivatives): change over half of the 95 % interval, NaN where there is none.
    odd: runs at odds with the others, which are marked.
    """
    figure = Figure(height=0.16 * len(runs) + 1.6)
    axis = figure.subplots()
    shades = Shades(levels=(-2.0, 2.0), colours=RED_BLUE, smooth=True)
    cells = axis.mosaic(share, shades, x=-0.5, y=-0.5)
    axis.set_xlim(-0.5, len(names) - 0.5)
    axis.set_ylim(len(runs) - 0.5, -0.5)
    axis.without_grid()
    axis.set_xticks(range(len(names)), names, rotation=90, fontsize="x-small")
    told = [f"{run}  at odds" if run in odd else run for run in runs]
    axis.set_yticks(range(len(runs)), told, fontsize="x-small")
    for row, column in np.argwhere(np.abs(np.nan_to_num(share)) > 1.0).tolist():
        value = share[row, column]
        axis.text(
            column,
            row,
            f"{value:+.1f}",
            ha="center",
            va="center",
            fontsize="xx-small",
            color="white",
        )
    figure.colour_key(cells, "Change by the run / half of the 95 % interval [-]", beyond=True)
    axis.set_title("What each run does to each derivative")
    return figure
