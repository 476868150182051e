"""A model beside tests: map of misfit, errors, loops, residuals in time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.channels import CHANNEL_UNITS
from pmmkit.escaping import figure_text
from pmmkit.figures.comparison_free import force_residuals
from pmmkit.figures.errors import errors_beside_uncertainty
from pmmkit.figures.overlays import overlays
from pmmkit.figures.residuals import residuals_over
from pmmkit.figures.workshop import forces_over_phase, static_forces
from pmmkit.numerics import Array
from pmmkit.observations.prepare import places_of
from pmmkit.plotting import style
from pmmkit.signals import design_matrix
from pmmkit.validation.captive import CaptiveRun
from pmmkit.validation.comparison import Comparison
from pmmkit.validation.uncertainty import rms_of

if TYPE_CHECKING:
    from matplotlib.collections import PolyCollection
    from matplotlib.figure import Figure

MEASURED, PREDICTED = style.ORDERED[0], style.ORDERED[2]
FINE: Final = 241
"""Points of a loop."""
THIN: Final = 400
"""Samples shown of one record."""
_PALE: Final = "#cfd6e6"
EXPANDED: Final = "expanded uncertainty"


def comparison_figures(comparison: Comparison) -> dict[str, Figure]:
    """All figures of a comparison by name.

    Parameters
    ----------
    comparison : Comparison
        From `compare`.
    """
    if not comparison.captive:
        found = (
            {
                "sailed": comparison.plot(),
                "force_residuals": force_residuals(comparison.worst_record()),
            }
            if comparison.free
            else {}
        )
        other = "simulated" if comparison.free else "submitted"
        sailed = [(item.trial, item.track) for item in comparison.manoeuvres]
        return found | overlays(sailed, other=other)
    found = {
        "misfit": comparison.plot(),
        "errors": errors_beside_uncertainty(comparison),
        "residuals": residuals_over(comparison),
    }
    dynamic = [run for run in comparison.captive if run.view.run.dynamic]
    if len(dynamic) < len(comparison.captive):
        found["static_forces"] = static_forces(comparison)
    if dynamic:
        worst = worst_of_each_test(dynamic)
        found["over_phase"] = forces_over_phase(comparison, worst)
        found["loops"] = loops(worst)
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
                measured = basis @ run.view.force[channel]
                half = _band(run, channel, basis)
                axis.add_collection(_around(whole, measured, half))
                axis.plot(whole, measured, color=MEASURED, label="measured")
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


def _band(run: CaptiveRun, channel: str, basis: Array) -> Array:
    """Expanded validation uncertainty along the cycle, that of its harmonics added up."""
    found: Array = np.sqrt(basis**2 @ run.uncertainty(channel) ** 2)
    return found


def _around(x: Array, y: Array, half: Array) -> PolyCollection:
    """A band about a closed curve: a quadrangle a step, opaque, since loops cross themselves."""
    from matplotlib.collections import PolyCollection

    low, high = np.stack([x, y - half], axis=1), np.stack([x, y + half], axis=1)
    steps = np.stack([low[:-1], low[1:], high[1:], high[:-1]], axis=1)
    return PolyCollection(
        list(steps), color=_PALE, lw=0.3, zorder=1.5, label=f"{EXPANDED} of the error"
    )


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
    if not kind.swings_hull:
        return np.degrees(motion.delta), "rudder angle δ [deg]"
    return np.degrees(motion.r), "yaw rate r [deg/s]"


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
    own = next(item for item in comparison.captive if item.view.run.id == run)
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
            half = _in_time(own, channel)
            right.axhspan(
                -half, half, color=MEASURED, alpha=0.2, lw=0, label=f"{EXPANDED} of the error"
            )
            right.axhline(0.0, color="#999999", lw=0.8)
        axes[0, 0].set_title(figure_text(run))
        axes[0, 1].set_title("what is left")
        for axis in axes[-1]:
            axis.set_xlabel("time [s]")
        style.legend_below(figure, list(axes.ravel()))
    return figure


def _in_time(run: CaptiveRun, channel: str) -> float:
    """Root mean square in time of the expanded validation uncertainty."""
    return rms_of(run.uncertainty(channel), run.view.labels)
