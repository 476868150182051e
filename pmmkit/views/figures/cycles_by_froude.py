"""Forces of one oscillating test at several Froude numbers, on top of each other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pmmkit.inference import std_along
from pmmkit.numerics import Array
from pmmkit.plotting import canvas, colour, dash, legend_below, styled
from pmmkit.presentation import WIDE
from pmmkit.signals import design_matrix

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, kw_only=True, eq=False)
class CycleForces:
    """Non-dimensional forces of a run over the phase of its motion.

    `coefficients (m,)`: harmonics C0, C1, S1, C2, S2 … [-]. `covariance (m, m)`: of them; a
    channel without has no band.
    """

    froude: float
    coefficients: Mapping[str, Array]
    covariance: Mapping[str, Array]


def cycles_by_froude(
    tests: Mapping[str, Sequence[CycleForces]],
    *,
    channels: Sequence[str] = ("X", "Y", "N"),
    stroke: str = "'",
) -> Figure:
    """Forces over a cycle at several Froude numbers: what of them changes with the speed."""
    theta = np.linspace(0.0, 2.0 * np.pi, 241)
    with styled():
        figure = canvas(1.9 * len(channels) + 0.8)
        axes = figure.subplots(len(channels), len(tests), squeeze=False, sharex=True)
        for column, (title, runs) in enumerate(tests.items()):
            for axis, channel in zip(axes[:, column], channels, strict=True):
                for number, run in enumerate(runs):
                    if channel not in run.coefficients:
                        continue
                    known = np.nan_to_num(run.coefficients[channel])
                    basis = design_matrix(theta, (len(known) - 1) // 2)
                    value = 1e3 * basis @ known
                    axis.plot(
                        np.degrees(theta),
                        value,
                        color=colour(number),
                        ls=dash(number),
                        label=f"Fn {run.froude:.3f}",
                    )
                    if channel in run.covariance:
                        V = np.nan_to_num(run.covariance[channel])
                        half = WIDE * 1e3 * std_along(basis, V)
                        axis.fill_between(
                            np.degrees(theta),
                            value - half,
                            value + half,
                            color=colour(number),
                            alpha=0.18,
                            lw=0,
                        )
                if column == 0:
                    axis.set_ylabel(f"$10^3\\,{channel}{stroke}$ [-]")
            axes[0, column].set_title(title)
            axes[-1, column].set_xlabel("phase θ [deg]")
            axes[-1, column].set_xlim(0, 360)
            axes[-1, column].set_xticks([0, 90, 180, 270, 360])
        legend_below(figure, list(axes.ravel()))
    return figure
