"""Smoothed motion, accelerations, and the forces that a model does not have."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

import numpy as np

from pmmkit.base import DataError, SimulationError
from pmmkit.conventions import Convention
from pmmkit.identification.binding import FORCES, bound, driven
from pmmkit.identification.filters import GATE, STEP, first_state, with_forces
from pmmkit.identification.forces import ForceRecord
from pmmkit.identification.passes import Pass, Process, passed, room, seen, smoothed, state_steps
from pmmkit.identification.record import FreeRecord, sensors_of
from pmmkit.inference import Innovations
from pmmkit.models import Model
from pmmkit.numerics import Array
from pmmkit.simulation import ESTIMATING, compiled, rigid_body

MEMORY: Final = 1.0
"""Time over which an unknown force hangs together, in ship lengths over the speed."""
SIZES: Final = (3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3)
"""Sizes of the unknown forces that are tried, over ½ρLdU² and ½ρL²dU²."""
LARGER: Final = (1.0, 3.0)
"""The same, where the motion is lost with all of those."""
ROOM: Final = 2e9
"""Bytes that a smoother may take."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Smoothed:
    """A record as a model and its sensors together explain it.

    Parameters
    ----------
    name : str
        Of the record.
    t : array (n,)
        Instants [s].
    motion : mapping of str to array (n,)
        x, y [m], psi, u, v, r (p, phi) through the water, and udot, vdot, rdot (pdot).
    motion_std : mapping of str to array (n,)
        Standard deviations of the states.
    residual : mapping of str to array (n,)
        Forces that the model lacks: X, Y [N], N, K [N m].
    residual_std : mapping of str to array (n,)
        Their standard deviations.
    covariance : array (n, s, s)
        Of states and residual forces together.
    size : float
        Standard deviation that the unknown forces were given, over ½ρLdU² (½ρL²dU²).
    log_likelihood : float
        Of the record.
    gated : int
        Measurements that were not taken in.
    record : FreeRecord
        What was smoothed.
    """

    name: str
    t: Array
    motion: Mapping[str, Array]
    motion_std: Mapping[str, Array]
    residual: Mapping[str, Array]
    residual_std: Mapping[str, Array]
    covariance: Array
    size: float
    log_likelihood: float
    gated: int
    record: FreeRecord


def smooth(
    model: Model,
    record: FreeRecord,
    *,
    sensors: Mapping[str, float] | None = None,
    size: float | None = None,
    memory: float = MEMORY,
    gate: float = GATE,
    extrapolate: bool = False,
) -> Smoothed:
    """Kalman smoother with the model in it and unknown forces as states.

    Parameters
    ----------
    model : Model
        Complete.
    record : FreeRecord
        Any of its channels may be missing; positions and heading alone are enough.
    sensors : mapping of str to float, optional
        Standard deviations of channels; those not named are told from the record.
    size : float, optional
        Standard deviation of the unknown forces over ½ρLdU² (moments over ½ρL²dU²), U that of the
        approach; by default the one of greatest likelihood.
    memory : float
        Time over which they hang together, in ship lengths over the speed of the approach.
    gate : float
        Residuals beyond so many standard deviations are not taken in.
    extrapolate : bool
        Allow a speed outside the range of the model's values.

    Returns
    -------
    Smoothed

    Raises
    ------
    DataError
        If the record is too long for the memory of the machine.
    SimulationError
        If the motion is lost.

    Notes
    -----
    Extended Kalman filter forward, Rauch, Tung and Striebel (1965) backward. Each unknown force is
    an Ornstein-Uhlenbeck process. Where the measurements say nothing (a gap), the residual goes to
    zero and its standard deviation to `size`.
    """
    ready = driven(model)
    names = FORCES if model.rolls else FORCES[:3]
    known = sensors_of([record], sensors or {})
    binding = bound(
        ready, names, record.speed, conditions=record.conditions, extrapolate=extrapolate
    )
    states = binding.structure.states
    n, rows = len(states) + len(names), len(record)
    needed = 8.0 * rows * (room(len(states), len(names)) + n * n)
    if needed > ROOM:
        raise DataError(
            f"Record {record.name!r} of {rows} instants needs "
            f"{1e-9 * needed:.1f} GB: cut it, or take every second instant."
        )
    functions = compiled(binding.structure, ESTIMATING)
    unit = units(ready, record.speed)
    pace = record.speed / ready.ship.L
    first, measured = first_state(record, states, known, ready.ship.L), seen(record, states, known)
    fading = np.full(len(names), pace / memory)

    def forward(share: float, *, store: bool) -> Pass:
        spread = np.array([share * unit[name[-1]] for name in names])
        z, P, diffusion = with_forces(*first, spread, fading)
        steps = np.concatenate([state_steps(states, record.speed, ready.ship.L), 1e-3 * spread])
        moving = Process(
            diffusion=diffusion,
            fading=fading,
            frozen=np.zeros(len(names)),
            steps=steps,
            longest=STEP / pace,
        )
        return passed(functions, binding, measured, moving, z, P, gate=gate, store=store)

    if size is None:
        size = _likeliest(forward)
    found = forward(size, store=True)
    means, covariance = smoothed(functions, found)
    return _told(
        record,
        states,
        names,
        means,
        covariance,
        size,
        found.innovations,
        _rates(functions, binding.base, record, means, len(states), len(names)),
    )


def units(model: Model, speed: float) -> dict[str, float]:
    """½ρLdU² and ½ρL²dU² by channel [N, N m]."""
    ship, water = model.ship, model.water
    return {
        channel: Convention(system="prime-d").force_unit(channel, ship=ship, water=water, U=speed)
        for channel in ("X", "Y", "N", "K")
    }


def _likeliest(forward: Callable[..., Pass]) -> float:
    """Size of the unknown forces of greatest likelihood; larger ones where all lose the motion."""

    def likelihood(share: float) -> float:
        try:
            return forward(share, store=False).innovations.log_likelihood()
        except SimulationError:
            return -math.inf

    for sizes in (SIZES, LARGER):
        found = {share: likelihood(share) for share in sizes}
        best = max(found, key=lambda share: found[share])
        if found[best] > -math.inf:
            return best
    return best


def _rates(  # type: ignore[no-untyped-def]
    functions, base: Array, record: FreeRecord, means: Array, size: int, forces: int
) -> Array:
    k = base.copy()
    functions.complete(k)
    more = np.zeros((len(record), 4))
    more[:, :forces] = means[:, size:]
    out = np.empty((len(record), size))
    functions.along(np.ascontiguousarray(means[:, :size]), record.inputs, more, k, out)
    return out


def _told(
    record: FreeRecord,
    states: Sequence[str],
    names: Sequence[str],
    means: Array,
    covariance: Array,
    size: float,
    innovations: Innovations,
    rates: Array,
) -> Smoothed:
    std = np.sqrt(np.maximum(np.einsum("tii->ti", covariance), 0.0))
    motion = {name: means[:, i] for i, name in enumerate(states)}
    motion |= {
        f"{name}dot": rates[:, list(states).index(name)]
        for name in ("u", "v", "r", "p")
        if name in states
    }
    first = len(states)
    return Smoothed(
        name=record.name,
        t=record.t,
        motion=MappingProxyType(motion),
        motion_std=MappingProxyType({name: std[:, i] for i, name in enumerate(states)}),
        residual=MappingProxyType({name[-1]: means[:, first + i] for i, name in enumerate(names)}),
        residual_std=MappingProxyType(
            {name[-1]: std[:, first + i] for i, name in enumerate(names)}
        ),
        covariance=covariance,
        size=size,
        log_likelihood=innovations.log_likelihood(),
        gated=int(np.sum(innovations.gated)),
        record=record,
    )


def implied_forces(model: Model, smoothed: Smoothed, *, memory: float = MEMORY) -> ForceRecord:
    """The forces that a record implies, for regression: mass times smoothed acceleration.

    Parameters
    ----------
    model : Model
        Its ship has the mass.
    smoothed : Smoothed
        From `smooth`.
    memory : float
        As for `smooth`: errors hang together over twice that time.

    Returns
    -------
    ForceRecord
        Its standard deviations are those of the residual forces.
    """
    record = smoothed.record
    pace = record.speed / model.ship.L
    motion = {name: x for name, x in smoothed.motion.items() if name not in ("x", "y")}
    motion |= {"delta": record.delta, "n": record.turns}
    if record.wind_speed is not None and record.wind_direction is not None:
        motion |= {"wind_speed": record.wind_speed, "wind_direction": record.wind_direction}
    if record.wave_height is not None and record.wave_direction is not None:
        motion |= {"wave_height": record.wave_height, "wave_direction": record.wave_direction}
    if not model.rolls and record.roll is not None and record.roll_rate is not None:
        motion |= {"phi": record.roll, "p": record.roll_rate}
        if record.roll_acceleration is not None:
            motion |= {"pdot": record.roll_acceleration}
    forces = rigid_body(model.ship, motion)
    step = float(np.median(np.diff(record.t)))
    return ForceRecord(
        name=record.name,
        motion=MappingProxyType(motion),
        forces=MappingProxyType({name: forces[name] for name in smoothed.residual}),
        std=MappingProxyType(dict(smoothed.residual_std)),
        speed=record.speed,
        conditions=record.conditions,
        correlated=max(round(2.0 * memory / pace / step), 1),
    )
