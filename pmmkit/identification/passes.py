"""One record through a filter of `pmmkit.inference.estimators`, with a model's equations."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import ModuleType
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import DataError, Progress, SimulationError
from pmmkit.equations import InputField, Status
from pmmkit.identification.binding import Binding
from pmmkit.identification.record import KINDS, FreeRecord
from pmmkit.inference import Innovations
from pmmkit.numerics import Array

WIDEST: Final = 4.0
"""Steps of the integration in an interval beyond which it is cut: over .2 L/U the covariance of an
interval by its slopes alone is off by 1e-5, over 10 L/U by a factor of 3."""
STRAIGHT: Final = (
    InputField.rudder,
    InputField.revolutions,
    InputField.bucket,
    InputField.roll,
    InputField.roll_rate,
    InputField.roll_acceleration,
)
"""Inputs that are straight lines between instants; the others are those of the last one."""
LOST: Final = {
    Status.mass: "Record {}: the filter makes the mass matrix indefinite. Give a narrower prior "
    "for the added masses, or hold them.",
    Status.unbound: "Record {}: the filter loses the motion. Check the signs of rudder and "
    "heading, the start values, and the sensors' standard deviations.",
}


@dataclass(frozen=True, kw_only=True)
class Steps:
    """Says which step of so many is made."""

    most: int
    progress: Progress | None

    def tell(self, number: int, what: str) -> None:
        """Say the number of a step and what is done in it; the last ones may be more."""
        if self.progress is not None:
            self.progress(min(number, self.most), self.most, what)


@dataclass(frozen=True, kw_only=True, eq=False)
class RecordView:
    """A record as filters take it.

    `inputs (n, inputs)`: a row of `InputField` per instant. `measured (n, c)`: naN where
    nothing was. `kinds (c,)`: what each channel is: the place of a state, or an `OverGround`.
    `variances (c,)`: of the sensors' noise.
    """

    name: str
    t: Array
    inputs: Array
    channels: tuple[str, ...]
    measured: Array
    kinds: NDArray[np.int64]
    variances: Array


def seen(record: FreeRecord, states: Sequence[str], sensors: Mapping[str, float]) -> RecordView:
    """A record with the standard deviations of its sensors."""
    channels = tuple(record.measured)
    return RecordView(
        name=record.name,
        t=record.t,
        inputs=record.inputs,
        channels=channels,
        measured=np.stack([record.measured[name] for name in channels], axis=1),
        kinds=np.array([kind_of(name, states) for name in channels], np.int64),
        variances=np.array([sensors[name] ** 2 for name in channels]),
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class Process:
    """How states and values move beyond what the equations say, and how they are linearised.

    `diffusion (s + m,)`: growth of the variances of states and values per second. `fading
    (m,)`: inverse times in which the values forget [1/s]. `frozen (m,)`: 1 where a value is
    linearised about the binding's mean, 0 about its estimate. `steps (s + m,)`: of the
    differences over states and values. `longest`: longest step of the integration [s].
    """

    diffusion: Array
    fading: Array
    frozen: Array
    steps: Array
    longest: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Pass:
    """What a filter made of a record.

    `z, P (s + m,)`: states and values after the last instant, and their covariance. `kept`: of
    the instants that were filtered; `rows (n,)`: those of the record among them.
    """

    z: Array
    P: Array
    means: Array
    variances: Array
    innovations: Innovations
    kept: Array
    rows: NDArray[np.int64]


def room(states: int, values: int) -> int:
    """Numbers that the extended filter keeps of an instant for the smoother."""
    n = states + values
    return 2 * n * n + 2 * n + states * n + values


def passed(
    functions: ModuleType,
    binding: Binding,
    record: RecordView,
    process: Process,
    z: Array,
    P: Array,
    *,
    method: Literal["ekf", "ukf"] = "ekf",
    gate: float = math.inf,
    store: bool = False,
) -> Pass:
    """Run a filter over a record.

    z, P (s + m,).
    """
    record, places = _cut(record, WIDEST * process.longest)
    rows, m, n = len(record.t), len(binding.mean), len(z)
    z, P, means = z.copy(), P.copy(), np.empty((rows, 2 * n))
    residuals, spreads = np.empty(record.measured.shape), np.empty(record.measured.shape)
    kept = np.zeros((rows if store else 0, room(n - m, m)))
    system = (
        record.t,
        record.inputs,
        binding.base,
        binding.starts,
        binding.places,
        binding.slopes,
        process.longest,
        process.steps,
        np.zeros(len(binding.base)),
        np.zeros((6, n - m)),
    )
    begin = (system, record.t, record.measured, record.kinds, record.variances, binding.mean)
    noise = (z, P, process.fading, process.diffusion, gate, means, residuals, spreads)
    if method == "ekf":
        lost = functions.extended(*begin, process.frozen, *noise, kept)
    else:
        lost = functions.unscented(*begin, *noise)
    if lost:
        raise SimulationError(LOST[Status(lost - 1)].format(record.name))
    return Pass(
        z=z,
        P=P,
        means=means[places, :n],
        variances=means[places, n:],
        innovations=Innovations(
            names=record.channels, residuals=residuals[places], variances=spreads[places], gate=gate
        ),
        kept=kept,
        rows=places,
    )


def _cut(record: RecordView, widest: float) -> tuple[RecordView, NDArray[np.int64]]:
    """The record with instants at which nothing is measured in intervals that are too wide [s]."""
    parts = np.maximum(np.ceil(np.diff(record.t) / widest - 1e-9), 1.0).astype(np.int64)
    places = np.concatenate([[0], np.cumsum(parts)])
    every = np.arange(places[-1] + 1)
    if len(every) == len(places):
        return record, places
    inputs = record.inputs[np.searchsorted(places, every, side="right") - 1]
    for column in STRAIGHT:
        inputs[:, column] = np.interp(every, places, record.inputs[:, column])
    measured = np.full((len(every), len(record.channels)), np.nan)
    measured[places] = record.measured
    t = np.interp(every, places, record.t)
    return replace(record, t=t, inputs=inputs, measured=measured), places


def smoothed(functions: ModuleType, found: Pass) -> tuple[Array, Array]:
    """Means (n, s + m) and covariances (n, s + m, s + m) given the whole record."""
    rows, n = len(found.kept), found.means.shape[1]
    means, covariances = np.empty((rows, n)), np.empty((rows, n, n))
    functions.smoothed(found.kept, n, means, covariances)
    if rows == len(found.rows):
        return means, covariances
    return means[found.rows], covariances[found.rows]


def kind_of(name: str, states: Sequence[str]) -> int:
    """Number by which the filters know a channel."""
    if name in KINDS:
        return KINDS[name]
    if name not in states:
        raise DataError(
            f"The model has no state {name}: leave that channel out, or add a part 'roll'."
        )
    return list(states).index(name)


def state_steps(states: Sequence[str], speed: float, L: float) -> Array:
    """Steps of the differences over the states, for a speed [m/s] and a ship length [m]."""
    sizes = {"u": speed, "v": speed, "r": speed / L}
    return np.array([1e-6 * sizes.get(name, 1.0) for name in states])
