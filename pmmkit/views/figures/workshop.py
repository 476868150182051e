"""Measured and predicted as workshops draw them: over the condition, over the phase, as tracks."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from pmmkit.numerics import Array
from pmmkit.plotting import REFERENCE, WIDTH, canvas, in_powers, legend_below, marker, styled
from pmmkit.plotting import colour as colour_style
from pmmkit.presentation import figure_text
from pmmkit.signals import design_matrix
from pmmkit.validation import CaptiveRun, Comparison
from pmmkit.views.figures.residuals import SPEED, abscissa, prime_scale

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_FINE: Final = 121
"""Phases of a cycle."""
_ALL: Final = "each at its speed"
_PANEL: Final = 2.3
"""Least width of a panel [inch]."""
_SLENDER: Final = 0.6


def static_forces(comparison: Comparison) -> Figure:
    """Coefficients of static runs over what they vary, with the uncertainty of the measurement."""
    runs = [run for run in comparison.captive if not run.view.run.dynamic]
    channels = _channels(runs)
    tests = list(dict.fromkeys(run.view.run.test for run in runs))
    looks: dict[str, int] = {}
    with styled():
        width = max(WIDTH * _SLENDER, _PANEL * len(tests) + 0.8)
        figure = canvas(1.9 * len(channels) + 1.1, width)
        axes = figure.subplots(len(channels), len(tests), squeeze=False, sharex="col")
        in_powers(axes.flat)
        for column, test in enumerate(tests):
            group = [run for run in runs if run.view.run.test == test]
            what, values = _condition(group, comparison)
            series: dict[str, list[tuple[float, CaptiveRun]]] = {}
            for run, x in zip(group, values, strict=True):
                label = _ALL if what == SPEED else f"Fn {run.Fn:.3f}"
                series.setdefault(label, []).append((x, run))
            for label, own in series.items():
                own.sort(key=lambda item: item[0])
                number = looks.setdefault(label, len(looks))
                for axis, channel in zip(axes[:, column], channels, strict=True):
                    some = [(x, run) for x, run in own if channel in run.channels]
                    if some:
                        _points(axis, some, channel, comparison, number, label)
            axes[0, column].set_title(group[0].view.run.kind_of_test.title)
            lowest = [axis for axis in axes[:, column] if axis.has_data()][-1]
            lowest.set_xlabel(what)
            lowest.tick_params(labelbottom=True)
        for row, channel in enumerate(channels):
            first = next(axis for axis in axes[row] if axis.has_data())
            first.set_ylabel(f"$10^3\\,{channel}'$ [-]")
        for axis in axes.flat:
            axis.set_visible(axis.has_data())
        _marks_told(next(axis for axis in axes.flat if axis.has_data()), comparison)
        legend_below(figure, list(axes.ravel()))
    return figure


def _condition(runs: Sequence[CaptiveRun], comparison: Comparison) -> tuple[str, list[float]]:
    """The drift angle where it is varied, else what the kind of test varies."""
    drifts = [math.degrees(run.view.run.settings.drift) for run in runs]
    if len(set(drifts)) > 1:
        return "drift angle β [deg]", drifts
    what, values = abscissa(runs, comparison.ship.L)
    return what, [float(run.view.projection[0] @ x) for run, x in zip(runs, values, strict=True)]


def _points(
    axis: Axes,
    runs: Sequence[tuple[float, CaptiveRun]],
    channel: str,
    comparison: Comparison,
    number: int,
    label: str,
) -> None:
    """Runs of one kind, at one Froude number or each at its own."""
    x = np.array([place for place, _ in runs])
    scale = np.array([prime_scale(run, channel, comparison) for _, run in runs])
    D = scale * [run.view.force[channel][0] for _, run in runs]
    S = scale * [run.predicted[channel][0] for _, run in runs]
    doubt = scale * [run.measurement_uncertainty(channel)[0] for _, run in runs]
    look: dict[str, Any] = {"marker": marker(number), "color": colour_style(number)}
    axis.errorbar(x, D, doubt, ls="", ms=4, elinewidth=0.9, capsize=2, label=label, **look)
    one_condition = len(np.unique(np.round(x, 6))) == len(x)
    line = "--" if one_condition else ""
    axis.plot(x, S, ls=line, lw=1.0, ms=6.5, markerfacecolor="none", **look)


def _marks_told(axis: Axes, comparison: Comparison) -> None:
    """What filled and open marks mean."""
    grey: dict[str, Any] = {"color": REFERENCE, "marker": "o"}
    axis.errorbar([], [], [], ls="", ms=4, capsize=2, label="measured, with $U_D$", **grey)
    predicted = _predicted(comparison)
    axis.plot([], [], ls="--", lw=1.0, ms=6.5, markerfacecolor="none", label=predicted, **grey)


def _predicted(comparison: Comparison) -> str:
    return figure_text(comparison.model)[:40] or "predicted"


def _channels(runs: Sequence[CaptiveRun]) -> list[str]:
    return list(dict.fromkeys(name for run in runs for name in run.channels))


def forces_over_phase(comparison: Comparison, runs: Sequence[CaptiveRun]) -> Figure:
    """Coefficients of oscillating runs over the phase of a cycle, measured and predicted."""
    channels = _channels(runs)
    theta = np.linspace(0.0, 2 * np.pi, _FINE)
    with styled():
        figure = canvas(1.9 * len(channels) + 1.1, max(WIDTH * _SLENDER, _PANEL * len(runs) + 0.8))
        axes = figure.subplots(len(channels), len(runs), squeeze=False, sharex=True)
        in_powers(axes.flat)
        for column, run in enumerate(runs):
            order = max(int(label[1:]) for label in run.view.labels)
            basis = design_matrix(theta, order)[:, run.view.places]
            for axis, channel in zip(axes[:, column], channels, strict=True):
                if channel in run.channels:
                    _cycle(axis, np.degrees(theta), basis, run, channel, comparison)
            title = run.view.run.kind_of_test.title
            lacks = "" if "C0" in run.view.labels else ", without the mean"
            axes[0, column].set_title(f"{title}\n{figure_text(run.view.run.id)}{lacks}")
            axes[-1, column].set_xlabel("phase θ [deg]")
            axes[-1, column].set_xlim(0, 360)
            axes[-1, column].set_xticks([0, 90, 180, 270, 360])
        for row, channel in enumerate(channels):
            axes[row, 0].set_ylabel(f"$10^3\\,{channel}'$ [-]")
        legend_below(figure, list(axes.ravel()))
    return figure


def _cycle(
    axis: Axes, phase: Array, basis: Array, run: CaptiveRun, channel: str, comparison: Comparison
) -> None:
    scale = prime_scale(run, channel, comparison)
    D = scale * (basis @ run.view.force[channel])
    half = scale * np.sqrt(basis**2 @ run.measurement_uncertainty(channel) ** 2)
    colour = colour_style(0)
    axis.fill_between(
        phase, D - half, D + half, color=colour, alpha=0.25, lw=0, label="$U_D$ about the measured"
    )
    axis.plot(phase, D, color=colour, label="measured")
    axis.plot(
        phase,
        scale * (basis @ run.predicted[channel]),
        color=colour_style(2),
        ls="--",
        label=_predicted(comparison),
    )
