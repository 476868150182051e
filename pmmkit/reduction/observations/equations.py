"""The equations that one run gives: harmonics of forces against harmonics of regressors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.campaigns import Campaign, Rig, Run, TypeB
from pmmkit.conventions import Convention, parse_derivative
from pmmkit.effects import Regressors, State
from pmmkit.numerics import Array
from pmmkit.reduction.observations.prepare import PreparedRun, RunResult
from pmmkit.reduction.observations.stated import altered, nominal_path

ASKED: Final = 0.1
"""Share of a recorded regressor that the motion asked for must make; the rest is noise of it."""
LARGEST: Final = {1: 1.0, 2: 0.1, 3: 10.0, 4: 30.0}
"""Largest size of a derivative of one, two, three, four factors in the prime system: beyond that of
the KCS over a bottom at 1.2 draughts (Yv -0.14, Xvr 0.04, Yvvv -7), the largest known."""
COUPLED: Final = 1.0
"""The same of three factors that are not one variable: there Nvvr is -0.4."""
ACCELERATED: Final = 0.1
"""The same of added mass: there Yvdot is -0.02."""
UNBOUNDED: Final = 1e9
"""The same of an offset and of the thrust, which are always felt."""
FELT: Final = 0.02
"""Share of the force below which no laboratory feels anything: its runs repeat to 1 or 2 %."""
IMPOSED = frozenset({"u", "v", "r", "udot", "vdot", "rdot"})
"""What a carriage imposes on a model."""
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
    prepared: PreparedRun,
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
    """
    motion, speed = motion_of_water(prepared, rig, blockage)
    return Rows(
        result=prepared.result,
        force=prepared.water_force(rig),
        design=_design(prepared.projection, names, motion, speed, campaign, convention),
        names=names,
    )


def motion_of_water(prepared: PreparedRun, rig: Rig, blockage: float) -> tuple[State, float]:
    """Motion of midship through the water at the samples, and the approach speed [m/s]."""
    faster = 1.0 + blockage
    motion = prepared.motion_at_midship(rig)
    motion = motion.with_(
        u=motion.u * faster, v=motion.v * (1.0 if prepared.result.run.dynamic else faster)
    )
    return motion, prepared.result.run.settings.speed * faster


def regressors_of(
    names: Mapping[str, Sequence[str]],
    motion: State,
    speed: float,
    campaign: Campaign,
    convention: Convention,
) -> dict[str, Array]:
    """What each derivative multiplies at the samples, channel by channel, arrays (n, p).

    speed [m/s].
    """
    shared = _shared(names, motion, speed, campaign, convention)
    return _by_channel(names, shared.columns)


def _shared(
    names: Mapping[str, Sequence[str]],
    motion: State,
    speed: float,
    campaign: Campaign,
    convention: Convention,
) -> Regressors:
    """What the derivatives of all channels multiply."""
    return Regressors.at(
        [name for listed in names.values() for name in listed],
        motion,
        ship=campaign.ship,
        water=campaign.water,
        convention=convention,
        approach_speed=speed,
    )


def _by_channel(names: Mapping[str, Sequence[str]], columns: Array) -> dict[str, Array]:
    """Columns of the derivatives of all channels, channel by channel."""
    ends = np.cumsum([len(listed) for listed in names.values()], dtype=np.intp)
    return {
        channel: columns[:, end - len(names[channel]) : end]
        for channel, end in zip(names, ends.tolist(), strict=True)
    }


def _design(
    projection: Array,
    names: Mapping[str, Sequence[str]],
    motion: State,
    speed: float,
    campaign: Campaign,
    convention: Convention,
) -> dict[str, Array]:
    """Harmonics of what each derivative multiplies, exact zeros where only rounding is left."""
    shared = _shared(names, motion, speed, campaign, convention)
    harmonics = projection @ shared.products.T
    products = shared.products
    largest = np.maximum(products.max(axis=1, initial=0.0), -products.min(axis=1, initial=0.0))
    known = np.where(np.abs(harmonics) > ROUNDING * largest, harmonics, 0.0)
    return _by_channel(names, shared.of(known))


@dataclass(frozen=True, kw_only=True, eq=False)
class Sensitivity:
    """How the equations of one run change with one source of uncertainty, per standard deviation.

    `force (m,)`: change of the force harmonics. `design (m, p)`: change of the regressors.
    `names`: the derivatives, column by column.
    """

    source: TypeB
    force: Mapping[str, Array]
    design: Mapping[str, Array]
    names: Mapping[str, Sequence[str]]


def residuals(changes: Sequence[Sensitivity], channel: str, values: Mapping[str, float]) -> Array:
    """Changes of ``force - design @ values`` of one run in one channel, array (changes, m)."""
    if not changes:
        return np.zeros((0, 0))
    vector = [values.get(name, 0.0) for name in changes[0].names[channel]]
    design = np.stack([change.design[channel] for change in changes])
    return np.stack([change.force[channel] for change in changes]) - design @ vector


def sensitivity(
    rows: Rows,
    source: TypeB,
    campaign: Campaign,
    rig: Rig,
    names: Mapping[str, Sequence[str]],
    convention: Convention,
) -> Sensitivity:
    """How a run's equations change with one source of uncertainty, as `altered` says.

    Where run or rig are others, by differences on the nominal motion at the same phase.
    """
    result = rows.result
    force = {channel: np.zeros(len(result.labels)) for channel in rows.force}
    design = {channel: np.zeros_like(columns) for channel, columns in rows.design.items()}
    changed = altered(
        source, result.run, rig, labels=result.labels, force=result.measured, rho=campaign.water.rho
    )
    if changed is not None:
        force |= {channel: x for channel, x in changed.force.items() if channel in force}
        if changed.density:
            design = {channel: changed.density * x for channel, x in rows.design.items()}
        other = campaign
        if changed.other_hull:
            ship = replace(campaign.ship, L=source.moved(campaign.ship.L))
            other = campaign.with_(ship=ship)
        if changed.run is not result.run or changed.rig is not rig or other is not campaign:
            before, after = (
                _nominal(
                    run, held, result.labels, whose, names, convention, result.run.settings.phase
                )
                for run, held, whose in (
                    (result.run, rig, campaign),
                    (changed.run, changed.rig, other),
                )
            )
            force = {channel: after[0][channel] - before[0][channel] for channel in force}
            design = {channel: after[1][channel] - before[1][channel] for channel in names}
    return Sensitivity(source=source, force=force, design=design, names=names)


def excited_alone(
    rows: Sequence[Rows], campaign: Campaign, rig: Rig, convention: Convention
) -> tuple[Rows, ...]:
    """The equations of runs without columns that only the noise of the recorded motion makes."""
    told = [
        _nominal(item.result.run, rig, item.result.labels, campaign, item.names, convention)[1]
        if item.result.run.has_nominal
        else item.design
        for item in rows
    ]
    names = {channel: listed for item in rows for channel, listed in item.names.items()}
    idle = {}
    for channel in names:
        having = [place for place, item in enumerate(rows) if channel in item.design]
        recorded = sum(np.nansum(rows[place].design[channel] ** 2, axis=0) for place in having)
        asked = sum(np.nansum(told[place][channel] ** 2, axis=0) for place in having)
        force = sum(float(np.nansum(rows[place].force[channel] ** 2)) for place in having)
        if channel == "X":  # of a ship that propels herself it is all but zero
            thrust = [rows[place].result.extras.get("T", 0.0) for place in having]
            force += float(np.nansum(np.square(thrust)))
        largest = _largest(names[channel], campaign, convention)
        idle[channel] = _imposed(names[channel]) & (asked < ASKED**2 * recorded)
        idle[channel] |= largest**2 * recorded < FELT**2 * force
    return tuple(
        replace(
            item,
            design={
                channel: np.where(idle[channel], 0.0, columns)
                for channel, columns in item.design.items()
            },
        )
        if any(np.any(idle[channel]) for channel in item.design)
        else item
        for item in rows
    )


def _largest(names: Sequence[str], campaign: Campaign, convention: Convention) -> Array:
    """The largest size that a derivative of any hull may have, in the system of a convention."""
    wider = campaign.ship.L / campaign.ship.d if convention.system == "prime-d" else 1.0
    return np.array([wider * _limit(parse_derivative(name).factors) for name in names])


def _limit(factors: Sequence[str]) -> float:
    """The largest size of a derivative with some factors in the prime system."""
    if {"0", "T"} & {*factors}:
        return UNBOUNDED
    if any(factor.endswith("dot") for factor in factors):
        return ACCELERATED
    order = min(len(factors), max(LARGEST))
    return COUPLED if order == 3 and len({x.strip("|") for x in factors}) > 1 else LARGEST[order]


def _imposed(names: Sequence[str]) -> NDArray[np.bool_]:
    """Which derivatives hold imposed motion alone; heel and thrust come as they do."""
    return np.array([parse_derivative(name).variables <= IMPOSED for name in names], dtype=bool)


def _nominal(
    run: Run,
    rig: Rig,
    labels: Sequence[str],
    campaign: Campaign,
    names: Mapping[str, Sequence[str]],
    convention: Convention,
    phase: float | None = None,
) -> tuple[dict[str, Array], dict[str, Array]]:
    """Inertia inside the forces, and regressors, on the nominal motion."""
    motion, _, projection = nominal_path(run, rig, labels, phase)
    inside = rig.inertia_inside(run, motion)
    return (
        {channel: projection @ x for channel, x in inside.items()},
        _design(projection, names, motion, run.settings.speed, campaign, convention),
    )
