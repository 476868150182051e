"""Zeros of the gauges over the day."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.numerics import Array
from pmmkit.plotting import REFERENCE, canvas, colour, marker, styled, widened
from pmmkit.presentation import WIDE, figure_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_NAMED: Final = 30
"""Runs up to which each is named below the figure."""


def zeros_over_the_day(
    names: Sequence[str],
    value: Mapping[str, Array],
    std: Mapping[str, Array],
    units: Mapping[str, str],
) -> Figure:
    """What each gauge shows at rest, run by run, a panel a gauge."""
    place = np.arange(len(names))
    with styled():
        figure = canvas(1.35 * len(value) + 1.0)
        axes = figure.subplots(len(value), 1, squeeze=False, sharex=True)[:, 0]
        for number, (axis, (channel, zeros)) in enumerate(zip(axes, value.items(), strict=True)):
            axis.axhline(float(np.nanmean(zeros)), color=REFERENCE, lw=0.9, ls="--")
            axis.errorbar(
                place,
                zeros,
                yerr=WIDE * std[channel],
                ls="-",
                lw=0.7,
                marker=marker(number),
                ms=4,
                color=colour(number),
            )
            widened(axis)
            axis.set_title(f"{channel} at rest [{units[channel]}]")
        few = len(names) <= _NAMED
        axes[-1].set_xlabel("" if few else "runs in the order of the day")
        if few:
            axes[-1].set_xticks(place, [figure_text(name) for name in names], rotation=90)
    return figure
