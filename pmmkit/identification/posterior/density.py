"""How probable parameters are: the likelihood of a Kalman filter's innovations times a prior."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from types import ModuleType
from typing import Any, Final

import numpy as np

from pmmkit.base import SimulationError
from pmmkit.identification.binding import Binding, driven
from pmmkit.identification.filters import Filtered, process
from pmmkit.identification.passes import (
    Pass,
    Process,
    RecordView,
    passed,
    seen,
    smoothed,
    state_steps,
)
from pmmkit.identification.prior import Prior
from pmmkit.identification.record import FreeRecord, sensors_of
from pmmkit.models import Model
from pmmkit.numerics import Array, root_of

STEP: Final = 0.1
"""Longest step of the integration in ship lengths over the speed of the approach."""
ROUGHNESS: Final = 0.03
"""Mean of the exponential prior of the process noise, in U²/L over the root of L/U."""
DEGREES: Final = 10.0
"""Degrees of freedom of the prior of the sensors' common variance, a scaled inverse χ²."""
PROCESS_NOISE, SENSOR_SCALE = "process_noise", "sensor_scale"
"""What is drawn beside the parameters."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Begun(RecordView):
    """A record with what is known of the states at its first instant."""

    start: Array
    spread: Array
    taken: float = 0.0
    """Measurements that find the start: as many as its states, less what their prior knew."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Density:
    """Posterior density over numbers whose prior is a standard normal, each.

    `prior`: of the parameters; the first numbers, through the root of its covariance.
    `roughness`: process noise; where it is not given, the last number stands for it. `binding`:
    constants over the parameters. `records`: independent of each other. `speed, L`: of the
    approach [m/s], length of the ship [m].
    """

    prior: Prior
    roughness: float | None
    binding: Binding
    functions: ModuleType
    records: tuple[Begun, ...]
    speed: float
    L: float

    def __reduce__(self) -> tuple[Any, ...]:
        """For another process, which compiles the equations or has them."""
        given = {x.name: getattr(self, x.name) for x in fields(self) if x.name != "functions"}
        return _compiled_anew, (given,)

    @property
    def names(self) -> tuple[str, ...]:
        """Of the numbers."""
        return (*self.prior.names, *(() if self.roughness is not None else (PROCESS_NOISE,)))

    @cached_property
    def _root(self) -> Array:
        """Of the prior's covariance."""
        return root_of(self.prior.covariance)

    @cached_property
    def measurements(self) -> int:
        """That are taken in, of all records."""
        return sum(int(np.isfinite(item.measured).sum()) for item in self.records)

    @cached_property
    def freedom(self) -> float:
        """Degrees of freedom of the common variance, given the records."""
        return DEGREES + self.measurements - sum(item.taken for item in self.records)

    def parameters(self, numbers: Array) -> Array:
        """Parameters (…, m) and, where it is drawn, process noise, of numbers (…, d)."""
        from scipy.special import log_ndtr

        m = len(self.prior.names)
        values = self.prior.mean + numbers[..., :m] @ self._root.T
        rough = -ROUGHNESS * log_ndtr(-numbers[..., m:])
        return np.concatenate([values, rough], axis=-1)

    def numbers(self, parameters: Array) -> Array:
        """Numbers (…, d) of parameters; the inverse of `parameters`."""
        from scipy.special import ndtri

        m = len(self.prior.names)
        away = (parameters[..., :m] - self.prior.mean) @ np.linalg.inv(self._root).T
        return np.concatenate([away, -ndtri(np.exp(-parameters[..., m:] / ROUGHNESS))], axis=-1)

    def __call__(self, numbers: Array) -> tuple[float, float, float]:
        """ln of the posterior density, of the likelihood, and the innovations' squares summed.

        Minus infinity where no ship has such a mass, or the motion is lost.
        """
        own = self.parameters(numbers)
        m = len(self.prior.names)
        rough = float(own[m]) if self.roughness is None else self.roughness
        squares, volume = self.innovations(own[:m], rough)
        if not math.isfinite(squares + volume):
            return -math.inf, -math.inf, math.nan
        likelihood = likelihood_of(squares, volume, self.measurements, self.freedom)
        return likelihood - 0.5 * float(numbers @ numbers), likelihood, squares

    def innovations(self, values: Array, roughness: float) -> tuple[float, float]:
        """Squares of all innovations over their variances, summed, and ln of these variances."""
        squares = volume = 0.0
        for item in self.records:
            try:
                found = self.passed(item, values, roughness).innovations
            except SimulationError:
                return math.inf, math.inf
            squares += float(np.nansum(found.squares))
            volume += found.volume
        return squares, volume

    def passed(self, item: Begun, values: Array, roughness: float, *, store: bool = False) -> Pass:
        """One pass of the compiled filter, which has no parameters: its states are the ship's."""
        states = self.binding.states
        moving = Process(
            diffusion=process(states, roughness, self.speed, self.L),
            fading=np.zeros(0),
            frozen=np.zeros(0),
            steps=state_steps(states, self.speed, self.L),
            longest=STEP * self.L / self.speed,
        )
        held, P = self.binding.at(values), np.diag(item.spread)
        return passed(self.functions, held, item, moving, item.start, P, store=store)


def _compiled_anew(given: Mapping[str, Any]) -> Density:
    return Density(functions=given["binding"].functions, **given)


def likelihood_of(squares: float, volume: float, count: int, freedom: float) -> float:
    """ln of how probable measurements are, averaged over the common scale of all variances.

    Notes
    -----
    Multiplying every variance of sensors and process noise by one factor leaves the filter's means
    as they are, and makes the volume of the innovations larger by the factor to the power of their
    number, less the states at the starts: what is known of these before is no matter of the
    sensors, and so wide that the first innovations say nothing of the factor. The factor has a
    scaled inverse χ² of `DEGREES` about 1. Where starts are known, the innovations are a
    multivariate t (Gelman et al. 2013).

    Examples
    --------
    >>> from scipy.stats import t
    >>> told = likelihood_of(1.7**2 / 4.0, np.log(4.0), 1, DEGREES + 1)
    >>> bool(np.isclose(told, t(10, scale=2.0).logpdf(1.7)))
    True
    """
    size = math.lgamma(0.5 * freedom) - math.lgamma(0.5 * DEGREES)
    size -= 0.5 * (freedom - DEGREES) * math.log(0.5 * DEGREES)
    size -= 0.5 * count * math.log(2.0 * math.pi)
    return size - 0.5 * volume - 0.5 * freedom * math.log1p(squares / DEGREES)


def density_of(
    model: Model,
    records: Sequence[FreeRecord],
    prior: Prior,
    about: Filtered,
    *,
    sensors: Mapping[str, float],
    roughness: float | None = None,
    extrapolate: bool = False,
) -> Density:
    """The posterior density of parameters, made ready."""
    ready = driven(model)
    speed, L = records[0].speed, ready.ship.L
    binding = Binding.of(
        ready, prior.names, speed, conditions=records[0].conditions, extrapolate=extrapolate
    )
    states = binding.states
    known = sensors_of(records, sensors)
    begun = []
    for record in records:
        item, unknown = seen(record, states, known), record.with_(measured={})
        gated = about.innovations[record.name].gated
        cleaned = replace(item, measured=np.where(gated, np.nan, item.measured))
        begun.append(
            Begun(
                **vars(cleaned),
                start=record.first_state(states, known, L)[0],
                spread=unknown.first_state(states, known, L)[1],
            )
        )
    made = Density(
        prior=prior,
        roughness=roughness,
        binding=binding,
        functions=binding.functions,
        records=tuple(begun),
        speed=speed,
        L=L,
    )
    return _from_starts(made, about)


def _from_starts(density: Density, about: Filtered) -> Density:
    """The density with the starts that an estimate implies in place of the first measurements."""
    begun = []
    for item in density.records:
        found = density.passed(item, about.values, about.roughness, store=True)
        means, covariances = smoothed(density.functions, found)
        left = np.diagonal(covariances[0]) / item.spread
        begun.append(replace(item, start=means[0], taken=float(np.sum(1.0 - left))))
    return replace(density, records=tuple(begun))
