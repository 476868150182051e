"""A model beside tests: map of misfit, errors, loops, residuals in time."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from pmmkit.campaigns import TEST_KINDS
from pmmkit.conventions import CHANNEL_UNITS
from pmmkit.identification import Trial
from pmmkit.inference import COVERAGE
from pmmkit.numerics import Array, rms
from pmmkit.plotting import LIMIT, Axes, Figure, colour, hatch, manoeuvre, trajectory
from pmmkit.presentation import figure_text
from pmmkit.signals import design_matrix
from pmmkit.simulation import Track
from pmmkit.validation import CaptiveRun, Comparison, FreeRun
from pmmkit.views.figures.workshop import (
    channels_of,
    forces_over_phase,
    residuals_over,
    static_forces,
)

# Bars of an error beside the uncertainty that judges it.


def errors_and_uncertainties(bars: Mapping[str, Sequence[tuple[str, float, float]]]) -> Figure:
    """E as bars and U_V as brackets on them, a panel a channel.

    bars: by channel names with both, in per cent of one force. Within U_V nothing can be said.
    """
    names = list(dict.fromkeys(name for own in bars.values() for name, _, _ in own))
    figure = Figure(height=0.24 * len(names) + 1.2)
    axes = figure.subplots(1, len(bars), squeeze=False, sharey=True)[0]
    for axis, (channel, own) in zip(axes, bars.items(), strict=True):
        for within, label in ((False, "E beyond $U_V$"), (True, "E within $U_V$")):
            some = [bar for bar in own if (bar[1] <= bar[2]) == within]
            if not some:
                continue
            axis.barh(
                [names.index(name) for name, _, _ in some],
                [error for _, error, _ in some],
                height=0.66,
                color="#c9cdd3" if within else colour(0),
                hatch=hatch(1) if within else "",
                label=label,
            )
        axis.errorbar(
            [doubt for _, _, doubt in own],
            [names.index(name) for name, _, _ in own],
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
        axis.without_grid("y")
    axes[0].set_yticks(np.arange(len(names)), [figure_text(name) for name in names])
    axes[0].set_ylim(len(names) - 0.4, -0.6)
    figure.legend_below(list(axes))
    return figure


# Measured manoeuvres with simulated or submitted ones over them: turning circles, zigzags.


_FIRST: Final = "overshoot_1_deg"

Sailed = tuple[Trial, Track]
"""A manoeuvre as it was measured, and as something or somebody else has it."""


def overlays(sailed: Sequence[Sailed], *, other: str) -> dict[str, Figure]:
    """Turning circles to both sides, and the zigzag whose first overshoot is off most."""
    found: dict[str, Figure] = {}
    turns = _each_side([item for item in sailed if item[0].manoeuvre == "turning"])
    if turns:
        found["turning_circles"] = trajectory(*_tracks(turns, other))
    weaves = [item for item in sailed if TEST_KINDS[item[0].manoeuvre].switches]
    if weaves:
        worst = max(weaves, key=_off)
        tracks, names = _tracks([worst], other)
        found[worst[0].manoeuvre] = manoeuvre(tracks, "zigzag", names)["zigzag"]
    return found


def _each_side(turns: Sequence[Sailed]) -> list[Sailed]:
    """The first turn to each side."""
    sides = {item[0].rudder_deg > 0: item for item in reversed(turns)}
    return [sides[side] for side in (True, False) if side in sides]


def _off(item: Sailed) -> float:
    """By how much the first overshoot is off [deg]."""
    measured, other = (one.metrics.get(_FIRST, math.nan) for one in item)
    return abs(other - measured) if math.isfinite(other - measured) else 0.0


def _tracks(items: Sequence[Sailed], other: str) -> tuple[list[Track], list[str]]:
    tracks: list[Track] = []
    names: list[str] = []
    for trial, track in items:
        tracks += [trial.ordered, track.ordered]
        names += [f"{trial.run}, measured", f"{trial.run}, {other}"]
    return tracks, names


# Comparison error against validation uncertainty, as at SIMMAN, with what may be said of it.


_MOST: Final = 40
"""Runs of which each has a bar; of more, each kind of test has one at each speed."""


def errors_beside_uncertainty(comparison: Comparison) -> Figure:
    """The comparison error E of captive tests beside its validation uncertainty U_V."""
    bars = {
        channel: _bars([run for run in comparison.captive if channel in run.channels], channel)
        for channel in channels_of(comparison.captive)
    }
    return errors_and_uncertainties(bars)


def _bars(runs: Sequence[CaptiveRun], channel: str) -> list[tuple[str, float, float]]:
    size = rms([run.rms(run.view.force[channel]) for run in runs])
    groups: dict[str, list[CaptiveRun]] = {}
    for run in runs:
        kind = run.view.run.kind_of_test.title
        name = run.view.run.id if len(runs) <= _MOST else f"{kind}, Fn {run.Fn:.3f}"
        groups.setdefault(name, []).append(run)
    return [
        (
            name,
            100 * rms([x.rms(x.error(channel)) for x in own]) / size,
            100 * rms([x.rms(x.uncertainty(channel)) for x in own]) / size,
        )
        for name, own in groups.items()
    ]


MEASURED, PREDICTED = colour(0), colour(2)
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
    """Hysteresis loops: force over velocity in a cycle, measured and predicted."""
    channels = channels_of(runs)
    figure = Figure(height=2.1 * len(channels) + 0.7)
    axes = figure.subplots(len(channels), len(runs), squeeze=False, sharex="col")
    for column, run in enumerate(runs):
        x, what = _velocity(run)
        order = max(int(label[1:]) for label in run.view.labels)
        theta = np.linspace(0.0, 2 * np.pi, FINE)
        basis = design_matrix(theta, order)[:, run.view.places]
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
            # That of its harmonics added up.
            half = np.sqrt(basis**2 @ run.uncertainty(channel) ** 2)
            _around(axis, whole, measured, half)
            axis.plot(whole, measured, color=MEASURED, label="measured")
            axis.plot(
                whole, basis @ run.predicted[channel], color=PREDICTED, ls="--", label="predicted"
            )
        axes[0, column].set_title(
            f"{run.view.run.kind_of_test.title}\n{figure_text(run.view.run.id)}"
        )
        axes[-1, column].set_xlabel(what)
    figure.legend_below(list(axes.ravel()))
    return figure


def _around(axis: Axes, x: Array, y: Array, half: Array) -> None:
    """A band about a closed curve: a quadrangle a step, opaque, since loops cross themselves."""
    low, high = np.stack([x, y - half], axis=1), np.stack([x, y + half], axis=1)
    steps = np.stack([low[:-1], low[1:], high[1:], high[:-1]], axis=1)
    axis.polygons(steps, color=_PALE, outline=0.3, zorder=1.5, label=f"{EXPANDED} of the error")


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
    """One run in time: measured and predicted forces, and below them what is left."""
    table = comparison.residuals(run)
    channels = [name[0] for name in table.columns if name.endswith("_error")]
    own = next(item for item in comparison.captive if item.view.run.id == run)
    thin = slice(None, None, max(1, len(table) // THIN))
    t = table["t"].to_numpy()[thin]
    figure = Figure(height=1.75 * len(channels) + 0.9)
    axes = figure.subplots(len(channels), 2, squeeze=False, sharex=True)
    for (left, right), channel in zip(axes, channels, strict=True):
        measured = table[f"{channel}_measured"].to_numpy()[thin]
        left.plot(t, measured, color=MEASURED, lw=0.9, label="measured")
        predicted = table[f"{channel}_predicted"].to_numpy()[thin]
        left.plot(t, predicted, color=PREDICTED, ls="--", label="predicted")
        left.set_ylabel(f"{channel} [{CHANNEL_UNITS[channel]}]")
        right.plot(
            t,
            table[f"{channel}_error"].to_numpy()[thin],
            color=LIMIT,
            lw=0.9,
            label="predicted less measured",
        )
        half = own.rms(own.uncertainty(channel))
        right.axhspan(-half, half, color=MEASURED, alpha=0.2, label=f"{EXPANDED} of the error")
        right.axhline(0.0, color="#999999", lw=0.8)
    axes[0, 0].set_title(figure_text(run))
    axes[0, 1].set_title("what is left")
    for axis in axes[-1]:
        axis.set_xlabel("time [s]")
    figure.legend_below(list(axes.ravel()))
    return figure


# A model beside free-running records: track and histories, forces through the smoother.


def force_residuals(run: FreeRun) -> Figure:
    """Forces that the measured motion implies and those of the model, in time."""
    t = run.t - run.t[0]
    figure = Figure(height=1.75 * len(run.force) + 0.9)
    axes = figure.subplots(len(run.force), 2, squeeze=False, sharex=True)
    for (left, right), (channel, force) in zip(axes, run.force.items(), strict=True):
        half = COVERAGE * run.force_std[channel]
        predicted = run.force_predicted[channel]
        left.fill_between(t, force - half, force + half, color=MEASURED, alpha=0.25)
        left.plot(t, force, color=MEASURED, lw=0.5, label="from the measured motion")
        left.plot(t, predicted, color=PREDICTED, ls="--", label="model on that motion")
        left.set_ylabel(f"{channel} [{CHANNEL_UNITS[channel]}]")
        right.fill_between(
            t, -half, half, color=MEASURED, alpha=0.3, zorder=3, label="expanded uncertainty"
        )
        right.plot(t, predicted - force, color=LIMIT, lw=0.5, label="predicted less measured")
    axes[0, 0].set_title(f"{run.run.kind_of_test.title} {figure_text(run.name)}")
    axes[0, 1].set_title("what is left")
    for axis in axes[-1]:
        axis.set_xlabel("time [s]")
    figure.legend_below(list(axes.ravel()))
    return figure
