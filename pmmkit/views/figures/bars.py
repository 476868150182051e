"""Bars of an error beside the uncertainty that judges it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pmmkit.plotting import canvas, colour, hatch, legend_below, styled
from pmmkit.presentation import figure_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, kw_only=True)
class Bar:
    """An error and its uncertainty.

    `error, doubt`: the comparison error E and the validation uncertainty U_V, both in per cent
    of one force.
    """

    name: str
    error: float
    doubt: float

    @property
    def within(self) -> bool:
        """Whether the error is no larger than its uncertainty: nothing can be said."""
        return self.error <= self.doubt


def errors_and_uncertainties(bars: Mapping[str, Sequence[Bar]]) -> Figure:
    """E as bars and U_V as brackets on them, a panel a channel."""
    names = list(dict.fromkeys(bar.name for own in bars.values() for bar in own))
    with styled():
        figure = canvas(0.24 * len(names) + 1.2)
        axes = figure.subplots(1, len(bars), squeeze=False, sharey=True)[0]
        for axis, (channel, own) in zip(axes, bars.items(), strict=True):
            for within, label in ((False, "E beyond $U_V$"), (True, "E within $U_V$")):
                some = [bar for bar in own if bar.within == within]
                axis.barh(
                    [names.index(bar.name) for bar in some],
                    [bar.error for bar in some],
                    height=0.66,
                    color="#c9cdd3" if within else colour(0),
                    hatch=hatch(1) if within else "",
                    edgecolor="white",
                    lw=0.0,
                    label=label,
                )
            axis.errorbar(
                [bar.doubt for bar in own],
                [names.index(bar.name) for bar in own],
                yerr=0.42,
                ls="",
                color=colour(2),
                elinewidth=2.6,
                label="$U_V$ (k = 2)",
                zorder=4,
            )
            axis.set_title(f"{channel}")
            axis.set_xlabel("part of the rms force [%]")
            axis.set_xlim(left=0.0)
            axis.grid(visible=False, axis="y")
        axes[0].set_yticks(np.arange(len(names)), [figure_text(name) for name in names])
        axes[0].set_ylim(len(names) - 0.4, -0.6)
        legend_below(figure, list(axes))
    return figure
