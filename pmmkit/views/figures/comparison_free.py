"""A model beside free-running records: track and histories, forces through the smoother."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pmmkit.conventions import CHANNEL_UNITS
from pmmkit.inference import COVERAGE
from pmmkit.plotting import LIMIT, canvas, colour, in_powers, legend_below, styled
from pmmkit.presentation import figure_text
from pmmkit.validation import FreeRun

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MEASURED, SIMULATED = colour(0), colour(2)


def force_residuals(run: FreeRun) -> Figure:
    """Forces that the measured motion implies and those of the model, in time."""
    t = run.t - run.t[0]
    with styled():
        figure = canvas(1.75 * len(run.force) + 0.9)
        axes = figure.subplots(len(run.force), 2, squeeze=False, sharex=True)
        in_powers(axes.flat)
        for (left, right), (channel, force) in zip(axes, run.force.items(), strict=True):
            half = COVERAGE * run.force_std[channel]
            predicted = run.force_predicted[channel]
            left.fill_between(t, force - half, force + half, color=MEASURED, alpha=0.25, lw=0)
            left.plot(t, force, color=MEASURED, lw=0.5, label="from the measured motion")
            left.plot(t, predicted, color=SIMULATED, ls="--", label="model on that motion")
            left.set_ylabel(f"{channel} [{CHANNEL_UNITS[channel]}]")
            right.fill_between(
                t,
                -half,
                half,
                color=MEASURED,
                alpha=0.3,
                zorder=3,
                lw=0,
                label="expanded uncertainty",
            )
            right.plot(t, predicted - force, color=LIMIT, lw=0.5, label="predicted less measured")
        axes[0, 0].set_title(f"{run.run.kind_of_test.title} {figure_text(run.name)}")
        axes[0, 1].set_title("what is left")
        for axis in axes[-1]:
            axis.set_xlabel("time [s]")
        legend_below(figure, list(axes.ravel()))
    return figure
