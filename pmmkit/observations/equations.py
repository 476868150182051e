"""The equations that one run gives: harmonics of forces against harmonics of regressors."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from pmmkit.campaigns.motion.kinematics import move_motion, nominal_motion
from pmmkit.campaigns.run import Campaign, TypeB
from pmmkit.conventions import Convention
from pmmkit.effects.hull import regressors
from pmmkit.effects.state import State
from pmmkit.numerics import Array, projector
from pmmkit.observations.inertia import Rig, inertia_force
from pmmkit.observations.prepare import GRID, Prepared, RunResult
from pmmkit.signals import design_matrix

SETTINGS: Final = (
    "speed",
    "drift",
    "heel",
    "rudder",
    "propeller_rps",
    "period",
    "amplitude",
    "yaw_amplitude",
    "phase",
    "yaw_rate",
    "radius",
)
RIG: Final = {
    "mass": "mass",
    "Izz": "Izz",
    "xG": "xG",
    "moment_reference_x": "moment_x",
    "motion_reference_x": "motion_x",
}


ROUNDING = 1e-12
"""Harmonics of a regressor below this share of its largest sample are rounding."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Rows:
    """What one run says about the derivatives.

    Parameters
    ----------
    result : RunResult
        The run.
    force : dict of str to array (m,)
        Harmonics of the force of the water at midship [N, N m]; NaN where not known.
    design : dict of str to array (m, p)
        Harmonics of what each derivative of the channel multiplies.
    names : mapping of channel to names
        The derivatives, column by column.
    """

    result: RunResult
    force: Mapping[str, Array]
    design: Mapping[str, Array]
    names: Mapping[str, Sequence[str]]


def rows_of(
    prepared: Prepared,
    campaign: Campaign,
    rig: Rig,
    names: Mapping[str, Sequence[str]],
    convention: Convention,
    *,
    blockage: float = 0.0,
) -> Rows:
    """Project the forces and the regressors of a run onto its harmonics.

    The same linear map acts on both sides, so the equations hold exactly for any record that
    obeys the model, whatever its sampling.

    Parameters
    ----------
    prepared : Prepared
        The run.
    campaign : Campaign
        Ship and water.
    rig : Rig
        Inertia and reference points.
    names : mapping of channel to names
        The derivatives.
    convention : Convention
        Meaning of the derivatives.
    blockage : float
        Share by which the water passes the model faster than the carriage says. It acts on the
        regressors, not on the inertia.
    """
    faster = 1.0 + blockage
    motion = prepared.motion_at_midship(rig)
    motion = motion.with_(
        u=motion.u * faster, v=motion.v * (1.0 if prepared.result.run.dynamic else faster)
    )
    speed = prepared.result.run.settings.speed * faster
    return Rows(
        result=prepared.result,
        force=prepared.water_force(rig),
        design=_design(prepared.projection, names, motion, speed, campaign, convention),
        names=names,
    )


def _design(
    projection: Array,
    names: Mapping[str, Sequence[str]],
    motion: State,
    speed: float,
    campaign: Campaign,
    convention: Convention,
) -> dict[str, Array]:
    """Harmonics of what each derivative multiplies, channel by channel."""
    return {
        channel: _projected(
            projection,
            regressors(
                listed,
                motion,
                ship=campaign.ship,
                water=campaign.water,
                convention=convention,
                approach_speed=speed,
            ),
        )
        for channel, listed in names.items()
    }


def _projected(projection: Array, columns: Array) -> Array:
    """Harmonics of the columns, exact zeros where only rounding is left."""
    harmonics = projection @ columns
    rounding = ROUNDING * np.abs(columns).max(axis=0, initial=0.0)
    return np.where(np.abs(harmonics) > rounding, harmonics, 0.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class Sensitivity:
    """How the equations of one run change with one source of uncertainty, per standard deviation.

    Parameters
    ----------
    source : TypeB
        The source.
    force : dict of str to array (m,)
        Change of the force harmonics.
    design : dict of str to array (m, p)
        Change of the regressors.
    names : mapping of channel to names
        The derivatives, column by column.
    """

    source: TypeB
    force: Mapping[str, Array]
    design: Mapping[str, Array]
    names: Mapping[str, Sequence[str]]

    def residual(self, channel: str, values: Mapping[str, float]) -> Array:
        """Change of ``force - design @ values`` in one channel, array (m,)."""
        vector = [values.get(name, 0.0) for name in self.names[channel]]
        return self.force[channel] - self.design[channel] @ vector


def sensitivity(
    rows: Rows,
    source: TypeB,
    campaign: Campaign,
    rig: Rig,
    names: Mapping[str, Sequence[str]],
    convention: Convention,
) -> Sensitivity:
    """Finite differences of a run's equations with respect to one source of uncertainty.

    Settings act on the nominal motion at the same phase; the gauges act on the channel as
    measured, before moments are moved to midship.

    Parameters
    ----------
    rows : Rows
        The equations.
    source : TypeB
        What is uncertain.
    campaign, rig, names, convention
        As in `rows_of`.
    """
    result = rows.result
    labels = result.labels
    none = {channel: np.zeros(len(labels)) for channel in rows.force}
    flat = {channel: np.zeros_like(design) for channel, design in rows.design.items()}
    if source.name.endswith("_gauge"):
        channel = source.name[0]
        if channel not in result.measured:
            return Sensitivity(source=source, force=none, design=flat, names=names)
        step = _gauge_step(result, channel, source)
        moved = _with_gauge(none, channel, step, rig)
        return Sensitivity(source=source, force=moved, design=flat, names=names)
    if source.name == "rho":
        share = source.std if source.relative else source.std / campaign.water.rho
        return Sensitivity(
            source=source,
            force=none,
            design={channel: share * design for channel, design in rows.design.items()},
            names=names,
        )
    changed = _perturbed(result, source, rig)
    if changed is None:
        return Sensitivity(source=source, force=none, design=flat, names=names)
    projection = _grid_projection(result)
    before = _equations(result, rig, projection, campaign, names, convention)
    after = _equations(*changed, projection, campaign, names, convention)
    return Sensitivity(
        source=source,
        force={channel: after[0][channel] - before[0][channel] for channel in rows.force},
        design={channel: after[1][channel] - before[1][channel] for channel in names},
        names=names,
    )


def _gauge_step(result: RunResult, channel: str, source: TypeB) -> Array:
    if source.relative:
        return source.std * np.nan_to_num(result.measured[channel])
    step = np.zeros(len(result.labels))
    step[0] = source.std
    return step


def _with_gauge(none: Mapping[str, Array], channel: str, step: Array, rig: Rig) -> dict[str, Array]:
    moved = dict(none)
    moved[channel] = step
    if channel == "Y":
        for moment, arm in (("N", rig.moment_x), ("K", -rig.moment_z)):
            if moment in moved:
                moved[moment] = arm * step
    return moved


def _grid_projection(result: RunResult) -> Array:
    if not result.run.dynamic:
        return np.ones((1, 1))
    order = (len(result.labels) - 1) // 2
    return projector(design_matrix(_grid(), order))


def _grid() -> Array:
    return np.arange(GRID, dtype=np.float64) * (2 * math.pi / GRID)


def _nominal(result: RunResult) -> State:
    """Nominal motion on one cycle (one instant for a static run)."""
    run = result.run
    omega = run.settings.omega
    if not result.run.dynamic or omega is None:
        return nominal_motion(run, np.zeros(1))
    return nominal_motion(run, (_grid() - run.settings.phase) / omega)


def _perturbed(result: RunResult, source: TypeB, rig: Rig) -> tuple[RunResult, Rig] | None:
    """The run and the rig with one standard deviation of error; None where it cannot act."""
    if source.name in RIG:
        field = RIG[source.name]
        return result, replace(rig, **{field: _stepped(getattr(rig, field), source)})
    settings = result.run.settings
    value = getattr(settings, source.name) if source.name in SETTINGS else None
    if value is None:
        return None
    change: dict[str, Any] = {source.name: _stepped(value, source)}
    run = result.run.with_(settings=replace(settings, **change))
    return replace(result, run=run), rig


def _stepped(value: float, source: TypeB) -> float:
    return value * (1 + source.std) if source.relative else value + source.std


def _equations(
    result: RunResult,
    rig: Rig,
    projection: Array,
    campaign: Campaign,
    names: Mapping[str, Sequence[str]],
    convention: Convention,
) -> tuple[dict[str, Array], dict[str, Array]]:
    """Force correction and regressors on the nominal motion."""
    midship = move_motion(_nominal(result), rig.motion_x)
    size = len(result.labels)
    force = {channel: np.zeros(size) for channel in result.measured}
    for moment, arm in (("N", rig.moment_x), ("K", -rig.moment_z)):
        if moment in force and "Y" in force:
            force[moment] = arm * np.nan_to_num(result.measured["Y"])
    if result.run.forces == "balance":
        inertia = inertia_force(midship, rig)
        force = {channel: force[channel] + projection @ inertia[channel] for channel in force}
    speed = result.run.settings.speed
    design = _design(projection, names, midship, speed, campaign, convention)
    return force, design
