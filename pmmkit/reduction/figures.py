"""Shares of a whole as stacked bars."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.numerics import Array
from pmmkit.plotting import ORDERED, REFERENCE, canvas, colour, hatch, legend_below, styled
from pmmkit.presentation import figure_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

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
    with styled():
        figure = canvas(0.25 * sum(longest) + 0.6 * (len(longest) - 1) + 1.6)
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
                    hatch=hatch(number // len(ORDERED)),
                    edgecolor="white",
                    lw=0.0,
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
            axis.grid(visible=False, axis="y")
        legend_below(figure, axes[: len(count)], columns=3)
    return figure
