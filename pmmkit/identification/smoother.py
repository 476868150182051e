"""Smoothed motion, accelerations, and the forces that a model does not have."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Final

import numpy as np

from pmmkit.base import DataError, SimulationError
from pmmkit.identification.as_tested import without
from pmmkit.identification.binding import FORCES, Binding, driven
from pmmkit.identification.filters import GATE, with_forces
from pmmkit.identification.forces import ForceRecord
from pmmkit.identification.passes import Pass, Process, passed, room, seen, smoothed, state_steps
from pmmkit.identification.record import FreeRecord, sensors_of
from pmmkit.inference import Innovations
from pmmkit.models import Model
from pmmkit.numerics import Array

MEMORY: Final = 1.0
"""Time over which an unknown force hangs together, in ship lengths over the speed."""
SIZES: Final = (3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3)
"""Sizes of the unknown forces that are tried, over ½ρLdU² and ½ρL²dU²."""
LARGER: Final = (1.0, 3.0)
"""The same, where the motion is lost with all of those."""
ROOM: Final = 2e9
"""Bytes that a smoother may take."""

LINE: Final = 0.5
"""Length of the lines by which a sensor alone is smoothed, in ship lengths over the speed."""
DISAGREE: Final = 0.02
"""Share of measurements that a smoother leaves out from which its sensors disagree. Of records of a
virtual tank it left out none in wind, with any effect of the ship and with a late clock, and 7 to
40 % in a current, with a log 3 % off, a heading 1° off and an antenna .1 L off."""


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

    @classmethod
    def of(
        cls,
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
            Standard deviation of the unknown forces over ½ρLdU² (moments over ½ρL²dU²), U that of
            the approach; by default the one of greatest likelihood.
        memory : float
            Time over which they hang together, in ship lengths over the speed of the approach.
        gate : float
            Residuals beyond so many standard deviations are not taken in.
        extrapolate : bool
            Allow a speed outside the range of the model's values.

        Raises
        ------
        DataError
            If the record is too long for the memory of the machine.
        SimulationError
            If the motion is lost.

        Notes
        -----
        Extended Kalman filter forward, Rauch, Tung and Striebel (1965) backward. Each unknown force
        is an Ornstein-Uhlenbeck process. Where the measurements say nothing (a gap), the residual
        goes to zero and its standard deviation to `size`.
        """
        ready = driven(model)
        names = FORCES if model.rolls else FORCES[:3]
        known = sensors_of([record], sensors or {})
        binding = Binding.of(
            ready, names, record.speed, conditions=record.conditions, extrapolate=extrapolate
        )
        states = binding.states
        n, rows = len(states) + len(names), len(record)
        needed = 8.0 * rows * (room(len(states), len(names)) + n * n)
        if needed > ROOM:
            raise DataError(
                f"Record {record.name!r} of {rows} instants needs "
                f"{1e-9 * needed:.1f} GB: cut it, or take every second instant."
            )
        functions = binding.functions
        unit = record.force_units(model)
        pace = record.speed / ready.ship.L
        first, measured = (
            record.first_state(states, known, ready.ship.L),
            seen(record, states, known),
        )
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
                longest=Binding.STEP / pace,
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

    @classmethod
    def references(
        cls,
        model: Model,
        records: Sequence[FreeRecord],
        *,
        sensors: Mapping[str, float] | None = None,
        extrapolate: bool = False,
    ) -> tuple[Smoothed, ...]:
        """Smoothed records that predictions start from and are compared with, one for all models.

        Parameters
        ----------
        model : Model
            Any model of the ship: unknown forces are given room enough (0.1 of ½ρLdU²) that the
            smoothed motion is that of the sensors.
        records : sequence of FreeRecord
            Records that were held out.
        sensors : mapping of str to float, optional
            As for `of`.
        extrapolate : bool
            Allow a speed outside the range of the model's values.

        Returns
        -------
        tuple of Smoothed
            Where sensors disagree (positions drift from where a log and a compass lead) each
            channel shows what its own sensor does.
        """
        found = [
            cls.of(model, record, sensors=sensors, size=0.1, extrapolate=extrapolate)
            for record in records
        ]
        return tuple(
            _each_by_itself(item, model, sensors or {}) if item.disagrees else item
            for item in found
        )

    @classmethod
    def corrected(
        cls,
        model: Model,
        references: Sequence[Smoothed],
        found: Mapping[str, float],
        *,
        sensors: Mapping[str, float] | None = None,
        extrapolate: bool = False,
    ) -> Sequence[Smoothed]:
        """References of records without what they are off by; themselves where nothing is.

        Parameters
        ----------
        model, sensors, extrapolate
            As for `references`.
        references : sequence of Smoothed
            Of the records as measured.
        found : mapping of str to float
            As for `as_tested.without`.
        """
        if not any(found.values()):
            return references
        records = [without(item.record, found) for item in references]
        return cls.references(model, records, sensors=sensors, extrapolate=extrapolate)

    @property
    def disagrees(self) -> bool:
        """Whether some sensors of the record say another motion than the others."""
        count = sum(int(np.isfinite(x).sum()) for x in self.record.measured.values())
        return self.gated > DISAGREE * count

    def implied_forces(self, model: Model, *, memory: float = MEMORY) -> ForceRecord:
        """The forces that a record implies, for regression: mass times smoothed acceleration.

        Parameters
        ----------
        model : Model
            Its ship has the mass.
        memory : float
            As for `of`: errors hang together over twice that time.

        Returns
        -------
        ForceRecord
            Its standard deviations are those of the residual forces.
        """
        record = self.record
        pace = record.speed / model.ship.L
        motion = {name: x for name, x in self.motion.items() if name not in ("x", "y")}
        motion |= {"delta": record.delta, "n": record.turns}
        if record.wind_speed is not None and record.wind_direction is not None:
            motion |= {"wind_speed": record.wind_speed, "wind_direction": record.wind_direction}
        if record.wave_height is not None and record.wave_direction is not None:
            motion |= {"wave_height": record.wave_height, "wave_direction": record.wave_direction}
        if not model.rolls and record.roll is not None and record.roll_rate is not None:
            motion |= {"phi": record.roll, "p": record.roll_rate}
            if record.roll_acceleration is not None:
                motion |= {"pdot": record.roll_acceleration}
        forces = model.ship.rigid_body_forces(motion)
        step = float(np.median(np.diff(record.t)))
        return ForceRecord(
            name=record.name,
            motion=MappingProxyType(motion),
            forces=MappingProxyType({name: forces[name] for name in self.residual}),
            std=MappingProxyType(dict(self.residual_std)),
            speed=record.speed,
            conditions=record.conditions,
            correlated=max(round(2.0 * memory / pace / step), 1),
        )


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


def _each_by_itself(item: Smoothed, model: Model, sensors: Mapping[str, float]) -> Smoothed:
    """A record that shows in each channel what its own sensor does.

    One motion cannot be that of all sensors: smoothed together some of them are left out, and a
    model that fails there would look right.
    """
    noise = sensors_of([item.record], sensors)
    length = LINE * model.ship.L / item.record.speed
    motion, std, covariance = dict(item.motion), dict(item.motion_std), item.covariance.copy()
    for place, name in enumerate(item.motion_std):
        if name not in item.record.measured:
            continue
        left, share = local_lines(item.t, item.record.measured[name] - motion[name], length)
        motion[name] = motion[name] + left
        own = noise[name] ** 2 * share
        std[name] = np.sqrt(std[name] ** 2 + own)
        covariance[:, place, place] += own
    return replace(
        item,
        motion=MappingProxyType(motion),
        motion_std=MappingProxyType(std),
        covariance=covariance,
    )


def local_lines(t: Array, values: Array, length: float) -> tuple[Array, Array]:
    """Values of straight lines through those nearby, and their variance over that of a value.

    Examples
    --------
    >>> t = np.arange(0.0, 10.0, 0.1)
    >>> lines, share = local_lines(t, 2.0 * t, 1.0)
    >>> bool(np.allclose(lines, 2.0 * t)), round(1.0 / share[50])
    (True, 11)
    """
    there = np.isfinite(values)
    if there.sum() < 2:
        return np.zeros(len(t)), np.zeros(len(t))
    at, x = t[there] - t[0], values[there]
    low = np.searchsorted(at, at - 0.5 * length - 1e-9)
    high = np.searchsorted(at, at + 0.5 * length + 1e-9)
    # A line needs two values, wherever its neighbours are.
    low = np.minimum(low, np.maximum(np.arange(len(at)) - 1, 0))
    high = np.maximum(high, np.minimum(np.arange(len(at)) + 2, len(at)))

    def sums(of: Array) -> Array:
        whole = np.concatenate([[0.0], np.cumsum(of)])
        found: Array = whole[high] - whole[low]
        return found

    count = sums(np.ones(len(at)))
    t_mean, x_mean = sums(at) / count, sums(x) / count
    spread = sums(at**2) / count - t_mean**2
    away = at - t_mean
    slope = (sums(at * x) / count - t_mean * x_mean) / spread
    share = (1.0 + away**2 / spread) / count
    return np.interp(t - t[0], at, x_mean + slope * away), np.interp(t - t[0], at, share)
