"""Captive runs as workshops draw them: over the condition, over the phase, what is left."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np

from pmmkit.conventions import Convention
from pmmkit.numerics import Array
from pmmkit.plotting import REFERENCE, WIDTH, Axes, Figure, marker
from pmmkit.plotting import colour as colour_style
from pmmkit.presentation import figure_text
from pmmkit.signals import design_matrix
from pmmkit.validation import CaptiveRun, Comparison

# What a model leaves of captive forces, a panel a channel and kind of test.


_BINS: Final = 21
"""Stretches of the abscissa in which oscillating runs are summed up; odd, so that one is at 0."""
SPEED: Final = "Froude number [-]"
_SMALL: Final = 1e-6
_NARROW: Final = 1.75
"""Width of a panel [inch]."""


def residuals_over(comparison: Comparison) -> Figure:
    """Residual coefficients over what each kind of test varies, a colour a Froude number."""
    runs = comparison.captive
    channels = channels_of(runs)
    speeds = sorted({_speed(run) for run in runs})
    tests = list(dict.fromkeys(run.view.run.test for run in runs))
    width = max(WIDTH, _NARROW * len(tests) + 0.8)
    figure = Figure(height=1.9 * len(channels) + 1.1, width=width)
    axes = figure.subplots(len(channels), len(tests), squeeze=False, sharex="col", sharey="row")
    for column, test in enumerate(tests):
        group = [run for run in runs if run.view.run.test == test]
        what, values = abscissa(group, comparison.ship.L)
        for row, channel in enumerate(channels):
            axes[row, column].axhline(0.0, color=REFERENCE, lw=0.8, zorder=1)
            for number, speed in enumerate(speeds):
                own = [
                    (run, x)
                    for run, x in zip(group, values, strict=True)
                    if _speed(run) == speed and channel in run.channels
                ]
                if own:
                    _drawn(axes[row, column], own, channel, comparison, number)
        axes[0, column].set_title(group[0].view.run.kind_of_test.title)
        axes[-1, column].set_xlabel(what)
    for row, channel in enumerate(channels):
        axes[row, 0].set_ylabel(f"error in $10^3\\,{channel}'$ [-]")
    figure.legend_below(list(axes.ravel()))
    return figure


def _speed(run: CaptiveRun) -> float:
    return round(run.Fn, 3)


def abscissa(runs: Sequence[CaptiveRun], L: float) -> tuple[str, list[Array]]:
    """What a kind of test varies, with its unit, and its values at the samples of each run.

    L [m].
    """
    motions = [run.view.motion for run in runs]
    every: Mapping[str, list[Array]] = {
        "yaw rate r' [-]": [x.r * L / run.view.speed for x, run in zip(motions, runs, strict=True)],
        "sway velocity v' [-]": [x.v / x.speed for x in motions],
        "surge velocity u/U [-]": [
            x.u / run.view.speed for x, run in zip(motions, runs, strict=True)
        ],
        "rudder δ [deg]": [np.degrees(x.delta) for x in motions],
        "heel φ [deg]": [np.degrees(x.phi) for x in motions],
        SPEED: [np.full_like(x.u, run.Fn) for x, run in zip(motions, runs, strict=True)],
    }
    kind = runs[0].view.run.kind_of_test
    if kind.surges and not (kind.sways or kind.yaws):
        chosen = "surge velocity u/U [-]"
    else:
        moved = [
            name
            for name, values in every.items()
            if not name.startswith("surge") and np.ptp(np.concatenate(values)) > _SMALL
        ]
        chosen = moved[0] if moved else SPEED
    return chosen, every[chosen]


def _drawn(
    axis: Axes,
    runs: Sequence[tuple[CaptiveRun, Array]],
    channel: str,
    comparison: Comparison,
    number: int,
) -> None:
    """Runs of one kind at one Froude number in one channel."""
    colour, label = colour_style(number), f"Fn {_speed(runs[0][0]):.3f}"
    scales = [prime_scale(run, channel, comparison) for run, _ in runs]
    if not runs[0][0].view.run.dynamic:
        axis.errorbar(
            [float(run.view.projection[0] @ x) for run, x in runs],
            [k * float(run.error(channel)[0]) for k, (run, _) in zip(scales, runs, strict=True)],
            [
                k * float(run.uncertainty(channel)[0])
                for k, (run, _) in zip(scales, runs, strict=True)
            ],
            ls="",
            marker=marker(number),
            ms=4,
            color=colour,
            elinewidth=0.8,
            label=label,
        )
        return
    x = np.concatenate([values for _, values in runs])
    y = np.concatenate(
        [
            k * (_at_samples(run) @ run.error(channel))
            for k, (run, _) in zip(scales, runs, strict=True)
        ]
    )
    middle, low, mean, high = summed_up(x, y)
    axis.fill_between(middle, low, high, color=colour, alpha=0.22)
    axis.plot(
        middle, mean, color=colour, marker=marker(number), ms=3, markevery=4, lw=1.3, label=label
    )


def _at_samples(run: CaptiveRun) -> Array:
    """From the harmonics that a run has to its samples."""
    kept = run.view.kept
    return run.view.basis if kept is None else run.view.basis[:, kept]


def prime_scale(run: CaptiveRun, channel: str, comparison: Comparison) -> float:
    """What makes 10³ times a coefficient of a force: over ½ρL²U², moments ½ρL³U²."""
    ship, water = comparison.ship, comparison.water
    return 1e3 / Convention(system="prime").force_unit(
        channel, ship=ship, water=water, U=run.view.speed
    )


def summed_up(x: Array, y: Array) -> tuple[Array, Array, Array, Array]:
    """Middles of stretches of x, and there the least, the mean and the largest of y.

    Examples
    --------
    >>> x = np.linspace(-1.0, 1.0, 2101)
    >>> middle, low, mean, high = summed_up(x, 2.0 * x)
    >>> bool(np.allclose(mean, 2.0 * middle, atol=1e-2)), len(middle)
    (True, 21)
    """
    edges = np.linspace(x.min(), x.max(), _BINS + 1)
    places = np.clip(np.searchsorted(edges, x, side="right") - 1, 0, _BINS - 1)
    order = np.argsort(places, kind="stable")
    kept, starts = np.unique(places[order], return_index=True)
    parts = np.split(y[order], starts[1:])
    middle = ((edges[:-1] + edges[1:]) / 2)[kept]
    low, mean, high = (np.array([of(part) for part in parts]) for of in (np.min, np.mean, np.max))
    return middle, low, mean, high


_FINE: Final = 121
"""Phases of a cycle."""
_ALL: Final = "each at its speed"
_PANEL: Final = 2.3
"""Least width of a panel [inch]."""
_SLENDER: Final = 0.6


def static_forces(comparison: Comparison) -> Figure:
    """Coefficients of static runs over what they vary, with the uncertainty of the measurement."""
    runs = [run for run in comparison.captive if not run.view.run.dynamic]
    channels = channels_of(runs)
    tests = list(dict.fromkeys(run.view.run.test for run in runs))
    looks: dict[str, int] = {}
    width = max(WIDTH * _SLENDER, _PANEL * len(tests) + 0.8)
    figure = Figure(height=1.9 * len(channels) + 1.1, width=width)
    axes = figure.subplots(len(channels), len(tests), squeeze=False, sharex="col")
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
        lowest.label_below(what)
    for row, channel in enumerate(channels):
        first = next(axis for axis in axes[row] if axis.has_data())
        first.set_ylabel(f"$10^3\\,{channel}'$ [-]")
    for axis in axes.flat:
        if not axis.has_data():
            axis.remove()
    _marks_told(next(axis for axis in axes.flat if axis.has_data()), comparison)
    figure.legend_below(list(axes.ravel()))
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


def channels_of(runs: Sequence[CaptiveRun]) -> list[str]:
    """All channels of some runs, each once."""
    return list(dict.fromkeys(name for run in runs for name in run.channels))


def forces_over_phase(comparison: Comparison, runs: Sequence[CaptiveRun]) -> Figure:
    """Coefficients of oscillating runs over the phase of a cycle, measured and predicted."""
    channels = channels_of(runs)
    theta = np.linspace(0.0, 2 * np.pi, _FINE)
    width = max(WIDTH * _SLENDER, _PANEL * len(runs) + 0.8)
    figure = Figure(height=1.9 * len(channels) + 1.1, width=width)
    axes = figure.subplots(len(channels), len(runs), squeeze=False, sharex=True)
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
        for axis in axes[:, column]:
            axis.set_xlim(0, 360)
            axis.set_xticks([0, 90, 180, 270, 360])
    for row, channel in enumerate(channels):
        axes[row, 0].set_ylabel(f"$10^3\\,{channel}'$ [-]")
    figure.legend_below(list(axes.ravel()))
    return figure


def _cycle(
    axis: Axes, phase: Array, basis: Array, run: CaptiveRun, channel: str, comparison: Comparison
) -> None:
    scale = prime_scale(run, channel, comparison)
    D = scale * (basis @ run.view.force[channel])
    half = scale * np.sqrt(basis**2 @ run.measurement_uncertainty(channel) ** 2)
    colour = colour_style(0)
    axis.fill_between(
        phase, D - half, D + half, color=colour, alpha=0.25, label="$U_D$ about the measured"
    )
    axis.plot(phase, D, color=colour, label="measured")
    axis.plot(
        phase,
        scale * (basis @ run.predicted[channel]),
        color=colour_style(2),
        ls="--",
        label=_predicted(comparison),
    )
