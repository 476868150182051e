"""Measured forces with what was fitted to them: over the drift angle, and over a cycle."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from pmmkit.effects import Regressors, State
from pmmkit.inference import std_along
from pmmkit.models import DerivativeTable
from pmmkit.numerics import Array
from pmmkit.plotting import Axes, Figure, colour, dash, marker
from pmmkit.presentation import WIDE
from pmmkit.signals import design_matrix

# Forces of one oscillating test at several Froude numbers, on top of each other.


CycleForces = tuple[float, Mapping[str, Array], Mapping[str, Array]]
"""A run: its Froude number, harmonics C0, C1, S1, C2, S2 … [-] of each channel over the phase of
the motion, and their covariances; a channel without has no band."""


def cycles_by_froude(
    tests: Mapping[str, Sequence[CycleForces]],
    *,
    channels: Sequence[str] = ("X", "Y", "N"),
    stroke: str = "'",
) -> Figure:
    """Forces over a cycle at several Froude numbers: what of them changes with the speed."""
    theta = np.linspace(0.0, 2.0 * np.pi, 241)
    figure = Figure(height=1.9 * len(channels) + 0.8)
    axes = figure.subplots(len(channels), len(tests), squeeze=False, sharex=True)
    for column, (title, runs) in enumerate(tests.items()):
        for axis, channel in zip(axes[:, column], channels, strict=True):
            for number, (froude, coefficients, covariance) in enumerate(runs):
                if channel not in coefficients:
                    continue
                known = np.nan_to_num(coefficients[channel])
                basis = design_matrix(theta, (len(known) - 1) // 2)
                value = 1e3 * basis @ known
                axis.plot(
                    np.degrees(theta),
                    value,
                    color=colour(number),
                    ls=dash(number),
                    label=f"Fn {froude:.3f}",
                )
                if channel in covariance:
                    V = np.nan_to_num(covariance[channel])
                    half = WIDE * 1e3 * std_along(basis, V)
                    axis.fill_between(
                        np.degrees(theta),
                        value - half,
                        value + half,
                        color=colour(number),
                        alpha=0.18,
                    )
            if column == 0:
                axis.set_ylabel(f"$10^3\\,{channel}{stroke}$ [-]")
        axes[0, column].set_title(title)
        axes[-1, column].set_xlabel("phase θ [deg]")
        for axis in axes[:, column]:
            axis.set_xlim(0, 360)
            axis.set_xticks([0, 90, 180, 270, 360])
    figure.legend_below(list(axes.ravel()))
    return figure


_ROOMY: Final = 40
"""Points of one Froude number from which on their marks shrink."""
_POINTS: Final = 1500
"""Samples shown of one record; more would only make the file large."""
_WHAT: Final = {
    "X": ("surge force", "N"),
    "Y": ("sway force", "N"),
    "N": ("yaw moment", "N m"),
    "K": ("roll moment", "N m"),
}


@dataclass(frozen=True, kw_only=True, eq=False)
class DriftPoints:
    """Means of the static drift runs of one Froude number.

    `force`: forces of the water on the hull at midship [N, N m]. `std`: their standard
    uncertainties; NaN where not known. `thrust`: thrust of the propeller in these runs [N];
    none where absent.
    """

    froude: float
    drift: Array
    force: Mapping[str, Array]
    std: Mapping[str, Array]
    thrust: Array | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class Cycle:
    """An oscillating run over the phase of its motion.

    `title`: what the run is. `theta`: phase of the samples, displacement ∝ sin θ [rad].
    `samples`: forces as recorded [N, N m]. `coefficients (m,)`: harmonics C0, C1, S1, C2, S2 ….
    """

    title: str
    theta: Array
    samples: Mapping[str, Array]
    coefficients: Mapping[str, Array]


def forces_over_drift(
    points: Sequence[DriftPoints],
    table: DerivativeTable | None = None,
    *,
    channels: Sequence[str] = ("X", "Y", "N"),
) -> Figure:
    """Non-dimensional forces over the drift angle, with the table's curves and intervals."""
    figure = Figure(height=3.5)
    axes = figure.subplots(1, len(channels), squeeze=False)[0]
    for axis, channel in zip(axes, channels, strict=True):
        what, unit = _WHAT[channel]
        factor = 1e3 if table else 1.0
        for number, group in enumerate(points):
            if channel not in group.force:
                continue
            divide = unit_in(table, channel, group.froude) if table else 1.0
            shrunk = min(1.0, math.sqrt(_ROOMY / len(group.drift)))
            scale = factor / divide
            if table:
                _curve(axis, table, channel, group, scale, colour(number))
            known = np.isfinite(group.std[channel]).any()
            axis.errorbar(
                np.degrees(group.drift),
                scale * group.force[channel],
                np.nan_to_num(WIDE * scale * group.std[channel]) if known else None,
                ls="",
                marker=marker(number),
                color=colour(number),
                capsize=2 * shrunk,
                ms=4.5 * shrunk,
                label=f"Fn {group.froude:.3f}",
            )
        stroke = "''" if table and table.convention.system == "bis" else "'"
        axis.set_title(f"{what} $10^3\\,{channel}{stroke}$ [-]" if table else f"{what} [{unit}]")
        axis.set_xlabel("drift angle β [deg]")
    figure.legend_below(list(axes))
    return figure


def unit_in(table: DerivativeTable, channel: str, froude: float) -> float:
    """What a force [N, N m] is divided by in the convention of a table, at a Froude number."""
    ship, water = table.ship, table.water
    return table.convention.force_unit(
        channel, ship=ship, water=water, U=ship.speed(froude, water.g)
    )


def _curve(
    axis: Axes, table: DerivativeTable, channel: str, points: DriftPoints, scale: float, hue: str
) -> None:
    """The table's force over the drift angle with its 95 % band."""
    near = np.flatnonzero(np.isclose(table.Fn, points.froude, rtol=0.01))
    row = 0 if table.pooled else int(near[0]) if len(near) else None
    if row is None:
        return
    room = 0.03 * np.ptp(points.drift)
    drift = np.linspace(points.drift.min() - room, points.drift.max() + room, 81)
    speed = table.ship.speed(points.froude, table.water.g)
    thrust = 0.0 if points.thrust is None else np.interp(drift, points.drift, points.thrust)
    state = State.of(u=speed * np.cos(drift), v=-speed * np.sin(drift), thrust=thrust)
    names = [name for name in table.names if name[0] == channel]
    design = Regressors.at(
        names,
        state,
        ship=table.ship,
        water=table.water,
        convention=table.convention,
        approach_speed=speed,
    ).columns
    acting = np.any(design != 0, axis=0)
    columns = [table.index(name) for name, acts in zip(names, acting, strict=True) if acts]
    design = scale * design[:, acting]
    value = design @ table.value[row, columns]
    covariance = table.covariance[row, columns][:, row, columns]
    half = WIDE * std_along(design, covariance)
    axis.plot(np.degrees(drift), value, color=hue, lw=1.3)
    axis.fill_between(np.degrees(drift), value - half, value + half, color=hue, alpha=0.18)


def over_a_cycle(cycles: Sequence[Cycle], *, channels: Sequence[str] = ("X", "Y", "N")) -> Figure:
    """Recorded forces of oscillating runs over the phase, with their harmonics.

    All cycles that were used lie on top of each other.
    """
    fine = np.linspace(0, 2 * np.pi, 241)
    figure = Figure(height=1.9 * len(channels) + 0.8)
    axes = figure.subplots(len(channels), len(cycles), squeeze=False, sharex=True)
    for column, cycle in enumerate(cycles):
        thin = slice(None, None, max(1, len(cycle.theta) // _POINTS))
        phase = np.degrees(np.mod(cycle.theta[thin], 2 * np.pi))
        for axis, channel in zip(axes[:, column], channels, strict=True):
            what, unit = _WHAT[channel]
            if column == 0:
                axis.set_ylabel(f"{what} {channel} [{unit}]")
            if channel not in cycle.samples:
                continue
            axis.plot(
                phase,
                cycle.samples[channel][thin],
                ls="",
                marker=".",
                ms=2.5,
                color="#b9c4cf",
                label="recorded",
            )
            order = (len(cycle.coefficients[channel]) - 1) // 2
            fit = design_matrix(fine, order) @ np.nan_to_num(cycle.coefficients[channel])
            axis.plot(np.degrees(fine), fit, color=colour(0), label=f"harmonics 0 to {order}")
        axes[0, column].set_title(cycle.title)
        axes[-1, column].set_xlabel("phase θ [deg]")
        for axis in axes[:, column]:
            axis.set_xlim(0, 360)
            axis.set_xticks([0, 90, 180, 270, 360])
    told = "θ = 0 where the displacement passes zero upwards"
    figure.suptitle(told, fontsize=9)
    figure.legend_below(list(axes.ravel()))
    return figure
