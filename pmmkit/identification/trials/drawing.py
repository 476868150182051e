"""Figures of sea trials: the path as measured and without the current, with its measures."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final, Protocol

import numpy as np

from pmmkit.base import DataError
from pmmkit.campaigns import TEST_KINDS
from pmmkit.plotting import REFERENCE, Axes, Figure, TrackLike, colour, dimension, open_mark
from pmmkit.presentation import figure_text

if TYPE_CHECKING:
    from pmmkit.identification.trials.current import Current
    from pmmkit.imo import Verdict
    from pmmkit.numerics import Array

_FORE: Final = 1.5
"""Ship lengths of the approach that are shown."""


class _Trial(TrackLike, Protocol):
    """What is drawn of a `Trial`."""

    @property
    def run(self) -> str: ...

    @property
    def manoeuvre(self) -> str: ...

    @property
    def heading_deg(self) -> float: ...

    @property
    def verdicts(self) -> tuple[Verdict, ...]: ...

    @property
    def current(self) -> Current | None: ...

    @property
    def x_ground(self) -> Array: ...

    @property
    def y_ground(self) -> Array: ...


def trial_figure(trial: _Trial) -> Figure:
    """The figure that shows a trial."""
    return trial_zigzag(trial) if TEST_KINDS[trial.manoeuvre].switches else trial_path(trial)


def trial_path(trial: _Trial) -> Figure:
    """Path of midship in ship lengths, as measured and with the current removed.

    The origin is where midship was at the order, the approach goes upwards. Dimension lines are
    drawn on the path without the current; the limits of the IMO stand in the title.
    """
    shown = (trial.t > 0) | (trial.x > -_FORE * trial.L)
    if trial.manoeuvre != "turning":
        shown &= trial.t > -60.0
    if trial.manoeuvre == "stopping" and math.isfinite(trial.metrics["time_to_stop"]):
        shown &= trial.t <= trial.metrics["time_to_stop"]
    if np.count_nonzero(shown) < 2:
        raise DataError("The record holds nothing to draw after the order.")
    figure = Figure(height=7.2, width=7.6)
    axis = figure.subplots()
    removed = trial.current is not None
    if removed:
        axis.plot(
            *_in_lengths(trial, trial.y_ground, trial.x_ground, shown),
            color=REFERENCE,
            ls="--",
            lw=1.1,
            label="as measured, over ground",
        )
    axis.plot(
        *_in_lengths(trial, trial.y, trial.x, shown),
        color=colour(0),
        label="current removed" if removed else "as measured, over ground",
    )
    axis.plot(0.0, 0.0, ls="", marker="o", ms=5, color=colour(0), label="order", zorder=4)
    if trial.manoeuvre == "turning":
        _turn_lines(axis, trial)
    else:
        _stop_lines(axis, trial)
    if trial.current is not None:
        _arrow(axis, trial)
    axis.set_aspect_equal()
    axis.margins(0.08, 0.08)
    axis.set_xlabel("to starboard of the approach, y / L [-]")
    axis.set_ylabel("along the approach, x / L [-]")
    axis.set_title(_title(trial))
    figure.legend_below([axis], columns=3)
    return figure


def trial_zigzag(trial: _Trial) -> Figure:
    """Heading and rudder of a zigzag over time, with the overshoots and their limits."""
    figure = Figure(height=4.4)
    axis = figure.subplots()
    shown = trial.t > -60.0
    heading = np.degrees(trial.psi)
    axis.plot(trial.t[shown], heading[shown], color=colour(0), label="heading ψ")
    axis.plot(
        trial.t[shown],
        np.degrees(trial.delta)[shown],
        color=colour(2),
        ls="--",
        lw=1.1,
        label="rudder δ",
    )
    for number, begin in enumerate(trial.orders[1:], start=1):
        over = trial.metrics.get(f"overshoot_{number}_deg", math.nan)
        if math.isnan(over):
            continue
        end = trial.orders[number + 1] if number + 1 < len(trial.orders) else trial.t[-1]
        inside = np.flatnonzero((trial.t >= begin) & (trial.t <= end))
        top = inside[int(np.argmax(np.abs(heading[inside])))]
        side = float(np.sign(heading[top]))
        axis.text(
            trial.t[top],
            heading[top],
            f"{over:.1f}°",
            xytext=(0, 5 * side),
            ha="center",
            va="bottom" if side > 0 else "top",
            fontsize=9,
            color=REFERENCE,
        )
    axis.axhline(0.0, color=REFERENCE, lw=0.6)
    axis.margins(y=0.14)
    axis.set_xlabel("time from the first execute [s]")
    axis.set_ylabel("heading ψ and rudder δ, to starboard [deg]")
    axis.set_title(_title(trial))
    figure.legend_below([axis])
    return figure


def _in_lengths(
    trial: _Trial, aside: np.ndarray, ahead: np.ndarray, shown: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    return aside[shown] / trial.L, ahead[shown] / trial.L


def _title(trial: _Trial) -> str:
    """What the run is, and each limit beside its value."""
    rudder = "" if trial.manoeuvre == "stopping" else f" {abs(trial.rudder_deg):.0f}°"
    if trial.manoeuvre == "turning":
        rudder += " to starboard" if trial.rudder_deg > 0 else " to port"
    who = figure_text(f"{trial.name}, {trial.run}")
    lines = [f"{who}: {trial.manoeuvre}{rudder}, {trial.speed:.2f} m/s"]
    words = []
    for item in trial.verdicts:
        unit = " L" if item.unit == "L" else "°"
        name = item.criterion.replace("_10_10", "").replace("_20_20", "").replace("_", " ")
        value = f"{item.value:.2f}{unit}" if math.isfinite(item.value) else "not reached"
        words.append(f"{name} {value} (IMO at most {item.limit:.4g}{unit})")
    return "\n".join([*lines, *words])


def _turn_lines(axis: Axes, trial: _Trial) -> None:
    side = math.copysign(1.0, trial.rudder_deg)
    found = {
        name: trial.metrics[f"{name}_L"] for name in ("advance", "transfer", "tactical_diameter")
    }
    if math.isnan(found["advance"]):
        return
    quarter = (side * found["transfer"], found["advance"])
    axis.plot(*quarter, ls="", marker="D", ms=5, color=colour(0), label="90°", zorder=4)
    beyond = -0.35 * side
    dimension(
        axis,
        (beyond, 0.0),
        (beyond, quarter[1]),
        f"advance {found['advance']:.2f} L",
        upright=True,
        guides=[(quarter, (beyond, quarter[1]))],
    )
    dimension(
        axis,
        (0.0, quarter[1] + 0.3),
        (quarter[0], quarter[1] + 0.3),
        f"transfer {found['transfer']:.2f} L",
        upright=False,
        guides=[((at, quarter[1]), (at, quarter[1] + 0.35)) for at in (0.0, quarter[0])],
    )
    if math.isnan(found["tactical_diameter"]):
        return
    level = float(np.interp(trial.metrics["time_180"], trial.t, trial.x)) / trial.L
    half = (side * found["tactical_diameter"], level)
    open_mark(axis, *half, "180°", marker="D")
    dimension(
        axis,
        (0.0, level),
        half,
        f"tactical diameter {found['tactical_diameter']:.2f} L",
        upright=False,
    )


def _stop_lines(axis: Axes, trial: _Trial) -> None:
    head, aside = trial.metrics["head_reach_L"], trial.metrics["lateral_deviation_L"]
    if math.isnan(head):
        return
    open_mark(axis, aside, head, "stopped", marker="D")
    beyond = -0.5 if aside >= 0 else 0.5
    dimension(
        axis,
        (beyond, 0.0),
        (beyond, head),
        f"head reach {head:.2f} L",
        upright=True,
        guides=[((aside, head), (beyond, head))],
    )
    axis.text(
        aside,
        head,
        f"lateral deviation {aside:+.2f} L\ntrack reach {trial.metrics['track_reach_L']:.2f} L",
        xytext=(8, 6),
        fontsize=9,
        color=REFERENCE,
    )


def _arrow(axis: Axes, trial: _Trial) -> None:
    """The direction of the current in the axes of the approach, in a corner."""
    current = trial.current
    if current is None or current.speed <= 0.0:
        return
    to = math.radians(current.direction_deg - trial.heading_deg)
    ahead, aside = 0.06 * math.cos(to), 0.06 * math.sin(to)
    middle = (0.88, 0.92)
    axis.arrow(
        (middle[0] - aside, middle[1] - ahead),
        (middle[0] + aside, middle[1] + ahead),
        color=colour(1),
        lw=1.6,
        fraction=True,
    )
    axis.text(
        middle[0],
        middle[1] - 0.08,
        f"current {current.speed:.2f} m/s",
        fraction=True,
        ha="center",
        va="top",
        fontsize=9,
        color=colour(1),
    )
