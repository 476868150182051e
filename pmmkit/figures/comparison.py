"""A model beside captive tests: map of misfit, loops, residuals over each variable and in time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from pmmkit.channels import CHANNEL_UNITS
from pmmkit.conventions import force_unit
from pmmkit.escaping import figure_text
from pmmkit.figures.comparison_free import force_residuals
from pmmkit.numerics import Array
from pmmkit.observations.prepare import places_of
from pmmkit.plotting import style
from pmmkit.signals import design_matrix
from pmmkit.validation.captive import CaptiveRun
from pmmkit.validation.comparison import Comparison

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MEASURED, PREDICTED = style.ORDERED[0], style.ORDERED[2]
FINE: Final = 241
"""Points of a loop."""
THIN: Final = 400
"""Samples shown of one record."""


def comparison_figures(comparison: Comparison) -> dict[str, Figure]:
    """All figures of a comparison by name.

    Parameters
    ----------
    comparison : Comparison
        From `compare`.
    """
    if not comparison.captive:
        return {
            "sailed": comparison.plot(),
            "force_residuals": force_residuals(comparison.worst_record()),
        }
    found = {"misfit": comparison.plot(), "residuals": residuals_over(comparison)}
    dynamic = [run for run in comparison.captive if run.view.run.dynamic]
    if dynamic:
        found["loops"] = loops(worst_of_each_test(dynamic))
    records = [run for run in comparison.captive if run.view.run.kind == "history"]
    records = [run for run in records if run.view.run.dynamic] or records
    if records:
        found["in_time"] = residual_in_time(comparison, _worst(records).view.run.id)
    return found


def worst_of_each_test(runs: Sequence[CaptiveRun]) -> tuple[CaptiveRun, ...]:
    """Of each kind of test the run with the greatest error over its uncertainty."""
    tests = dict.fromkeys(run.view.run.test for run in runs)
    return tuple(_worst([run for run in runs if run.view.run.test == test]) for test in tests)


def _worst(runs: Sequence[CaptiveRun]) -> CaptiveRun:
    def misfit(run: CaptiveRun) -> float:
        return max(
            float(np.sqrt(np.mean((run.error(name) / run.uncertainty(name)) ** 2)))
            for name in run.channels
        )

    return max(runs, key=misfit)


def loops(runs: Sequence[CaptiveRun]) -> Figure:
    """Hysteresis loops: force over velocity in a cycle, measured and predicted.

    Parameters
    ----------
    runs : sequence of CaptiveRun
        Oscillating runs, a column each.

    Returns
    -------
    Figure
        Sway tests over the sway velocity, yaw tests over the yaw rate, surge tests over the surge
        velocity. The measured loop is that of its harmonics.
    """
    channels = list(dict.fromkeys(name for run in runs for name in run.channels))
    with style.styled():
        figure = style.canvas(2.1 * len(channels) + 0.7)
        axes = figure.subplots(len(channels), len(runs), squeeze=False, sharex="col")
        style.in_powers(axes.flat)
        for column, run in enumerate(runs):
            x, what = _velocity(run)
            order = max(int(label[1:]) for label in run.view.labels)
            theta = np.linspace(0.0, 2 * np.pi, FINE)
            basis = design_matrix(theta, order)[:, places_of(run.view.labels)]
            whole = (
                design_matrix(theta, order)
                @ np.linalg.lstsq(_basis_at_samples(run, order), x, rcond=None)[0]
            )
            for axis, channel in zip(axes[:, column], channels, strict=True):
                if column == 0:
                    axis.set_ylabel(f"{channel} [{CHANNEL_UNITS[channel]}]")
                if channel not in run.channels:
                    continue
                axis.plot(whole, basis @ run.view.force[channel], color=MEASURED, label="measured")
                axis.plot(
                    whole,
                    basis @ run.predicted[channel],
                    color=PREDICTED,
                    ls="--",
                    label="predicted",
                )
            axes[0, column].set_title(
                f"{run.view.run.kind_of_test.title}\n{figure_text(run.view.run.id)}"
            )
            axes[-1, column].set_xlabel(what)
        style.legend_below(figure, list(axes.ravel()))
    return figure


def _basis_at_samples(run: CaptiveRun, order: int) -> Array:
    """The basis at the samples, told from the projection that undoes it."""
    if len(run.view.labels) == 2 * order + 1:
        return np.asarray(np.linalg.pinv(run.view.projection), np.float64)
    theta = np.arange(len(run.view.motion.u)) * (2 * np.pi / len(run.view.motion.u))
    return design_matrix(theta, order)


def _velocity(run: CaptiveRun) -> tuple[Array, str]:
    kind, motion = run.view.run.kind_of_test, run.view.motion
    if kind.sways and not kind.yaws:
        return motion.v, "sway velocity v [m/s]"
    if kind.surges:
        return motion.u, "surge velocity u [m/s]"
    return np.degrees(motion.r), "yaw rate r [deg/s]"


def residuals_over(comparison: Comparison) -> Figure:
    """Residual coefficients over what the runs vary: v', r', rudder, heel and Froude number.

    Parameters
    ----------
    comparison : Comparison
        Of captive tests.

    Returns
    -------
    Figure
        A row a channel, a column a variable. Oscillating runs are lines over their cycle, static
        ones points; each stands where its kind of test varies the variable. The residual, predicted
        less measured, is over ½ρL²U² (moments ½ρL³U²), U the carriage speed.
    """
    runs = comparison.captive
    channels = list(dict.fromkeys(name for run in runs for name in run.channels))
    tests = list(dict.fromkeys(run.view.run.test for run in runs))
    variables = _varied(runs, comparison.ship.L)
    with style.styled():
        figure = style.canvas(1.9 * len(channels) + 0.9)
        axes = figure.subplots(
            len(channels), len(variables), squeeze=False, sharex="col", sharey="row"
        )
        for row, channel in enumerate(channels):
            for column, (what, values) in enumerate(variables.items()):
                axis = axes[row, column]
                axis.axhline(0.0, color="#999999", lw=0.8)
                for run, x in zip(runs, values, strict=True):
                    if channel in run.channels and x is not None:
                        _residual(axis, run, channel, x, comparison, tests)
                if column == 0:
                    axis.set_ylabel(f"error in $10^3\\,{channel}'$ [-]")
                if row == len(channels) - 1:
                    axis.set_xlabel(what)
        style.legend_below(figure, list(axes.ravel()))
    return figure


def _varied(runs: Sequence[CaptiveRun], L: float) -> Mapping[str, list[Array | None]]:
    """Histories of the variables that differ; None where a kind of test does not vary them."""
    every = {
        "sway velocity v' [-]": [run.view.motion.v / run.view.motion.speed for run in runs],
        "yaw rate r' [-]": [run.view.motion.r * L / run.view.speed for run in runs],
        "rudder δ [deg]": [np.degrees(run.view.motion.delta) for run in runs],
        "heel φ [deg]": [np.degrees(run.view.motion.phi) for run in runs],
        "Froude number [-]": [np.full_like(run.view.motion.u, run.Fn) for run in runs],
    }
    return {
        name: [
            x if _shown(run, x, runs, values) else None for run, x in zip(runs, values, strict=True)
        ]
        for name, values in every.items()
        if np.ptp(np.concatenate(values)) > 1e-6
    }


def _shown(run: CaptiveRun, x: Array, runs: Sequence[CaptiveRun], values: Sequence[Array]) -> bool:
    """Whether a variable changes within an oscillating run, or between the static runs of a kind;
    the speed need only change between runs."""
    test = run.view.run.test
    alike = [y for other, y in zip(runs, values, strict=True) if other.view.run.test == test]
    if run.view.run.dynamic and not np.all(x == run.Fn):
        return bool(np.ptp(x) > 1e-6)
    return bool(np.ptp(np.concatenate(alike)) > 1e-6)


def _residual(
    axis: Axes,
    run: CaptiveRun,
    channel: str,
    x: Array,
    comparison: Comparison,
    tests: Sequence[str],
) -> None:
    view, ship, water = run.view, comparison.ship, comparison.water
    scale = 1e3 / force_unit(
        channel,
        "prime",
        L=ship.L,
        d=ship.d,
        volume=ship.volume,
        rho=water.rho,
        g=water.g,
        U=view.speed,
    )
    number = tests.index(view.run.test)
    look: dict[str, Any] = {"color": style.colour(number), "label": view.run.kind_of_test.title}
    if not view.run.dynamic:
        axis.plot(
            [float(view.projection[0] @ x)],
            [scale * float(run.error(channel)[0])],
            ls="",
            marker=style.marker(number),
            ms=4,
            **look,
        )
        return
    order = max(int(label[1:]) for label in view.labels)
    theta = np.linspace(0.0, 2 * np.pi, FINE)
    basis = design_matrix(theta, order)
    whole = np.linalg.lstsq(_basis_at_samples(run, order), x, rcond=None)[0]
    axis.plot(
        basis @ whole,
        scale * (basis[:, places_of(run.view.labels)] @ run.error(channel)),
        lw=0.8,
        alpha=0.8,
        **look,
    )


def residual_in_time(comparison: Comparison, run: str) -> Figure:
    """One run in time: measured and predicted forces, and below them what is left.

    Parameters
    ----------
    comparison : Comparison
        Of captive tests with records.
    run : str
        Id of the run.

    Returns
    -------
    Figure
    """
    table = comparison.residuals(run)
    channels = [name[0] for name in table.columns if name.endswith("_error")]
    thin = slice(None, None, max(1, len(table) // THIN))
    t = table["t"].to_numpy()[thin]
    with style.styled():
        figure = style.canvas(1.75 * len(channels) + 0.9)
        axes = figure.subplots(len(channels), 2, squeeze=False, sharex=True)
        style.in_powers(axes.flat)
        for (left, right), channel in zip(axes, channels, strict=True):
            measured = table[f"{channel}_measured"].to_numpy()[thin]
            left.plot(t, measured, color=MEASURED, lw=0.9, label="measured")
            predicted = table[f"{channel}_predicted"].to_numpy()[thin]
            left.plot(t, predicted, color=PREDICTED, ls="--", label="predicted")
            left.set_ylabel(f"{channel} [{CHANNEL_UNITS[channel]}]")
            right.plot(
                t,
                table[f"{channel}_error"].to_numpy()[thin],
                color=style.LIMIT,
                lw=0.9,
                label="predicted less measured",
            )
            right.axhline(0.0, color="#999999", lw=0.8)
        axes[0, 0].set_title(figure_text(run))
        axes[0, 1].set_title("what is left")
        for axis in axes[-1]:
            axis.set_xlabel("time [s]")
        style.legend_below(figure, list(axes.ravel()))
    return figure
