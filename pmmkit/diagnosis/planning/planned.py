"""Runs that are not yet made, seen as the diagnosis sees a measured one."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Final

import numpy as np

from pmmkit.base import UnknownNameError
from pmmkit.campaigns import Counted, Run
from pmmkit.conventions import Convention, parse_derivative
from pmmkit.diagnosis.captive.base import CaptiveBase
from pmmkit.diagnosis.planning.options import Option
from pmmkit.effects import HULL, INERTIA
from pmmkit.models import Model, converted, from_values
from pmmkit.numerics import Array, projector
from pmmkit.reduction import View
from pmmkit.signals import design_matrix

SAMPLES: Final = 32
"""Samples per cycle of a planned history."""
ROWS: Final = 2 * Counted.ORDER + 1


@dataclass(frozen=True, kw_only=True)
class PlannedPiece:
    """What the noise of a piece of a run depends on: its kind, speed, frequency and length."""

    dynamic: bool
    early: bool
    speed: float
    omega: float
    duration: float


NoiseOf = Callable[[PlannedPiece], Mapping[str, Array]]
"""Covariance of the mean or the harmonics of each channel (1, 1) or (11, 11)."""


def stated_noise(
    size: Mapping[str, float], share: float = 0.015, correlation: float = 1.0
) -> NoiseOf:
    """Noise that is stated before any test.

    correlation [s].
    """

    def noise(piece: PlannedPiece) -> Mapping[str, Array]:
        order = Counted.ORDER if piece.dynamic else 0
        n = np.concatenate([[0], np.repeat(np.arange(1, order + 1), 2)]).astype(float)
        spectrum = 2 * correlation / (1 + (n * piece.omega * correlation) ** 2)
        shape = np.where(n > 0, 2.0, 1.0) * spectrum / piece.duration
        return {name: np.diag((share * x) ** 2 * shape) for name, x in size.items()}

    return noise


def measured_noise(views: Sequence[View]) -> NoiseOf:
    """Noise as that of the most alike of measured pieces."""
    known = [(piece_of(view), view) for view in views if view.covariance]

    def distance(piece: PlannedPiece, other: PlannedPiece) -> float:
        found = abs(math.log(other.speed / piece.speed))
        found += 4.0 * (other.dynamic != piece.dynamic) + 0.1 * (other.early != piece.early)
        if piece.dynamic and other.dynamic:
            found += abs(math.log(other.omega / piece.omega))
        return found

    def noise(piece: PlannedPiece) -> Mapping[str, Array]:
        found: dict[str, Array] = {}
        for other, view in sorted(known, key=lambda item: distance(piece, item[0])):
            longer = other.duration / piece.duration if other.duration > 0 else 1.0
            factor = longer * max(1.0, piece.speed / other.speed) ** 4
            for name, covariance in view.covariance.items():
                if name not in found:
                    found[name] = factor * _fitting(covariance, piece.dynamic)
        return found

    return noise


def _fitting(covariance: Array, dynamic: bool) -> Array:
    """A covariance for the mean or for the harmonics, from whichever there is."""
    if not dynamic:
        return covariance[:1, :1]
    if len(covariance) == ROWS:
        return covariance
    if len(covariance) > 1:
        return np.eye(ROWS) * float(np.mean(np.diagonal(covariance)))
    return np.diag(np.where(np.arange(ROWS) > 0, 2.0, 1.0) * covariance[0, 0])


def piece_of(view: View) -> PlannedPiece:
    """What the noise of a measured view depends on."""
    count = len(view.t)
    duration = float(view.t[-1] - view.t[0]) * count / max(count - 1, 1)
    return PlannedPiece(
        dynamic=view.run.dynamic,
        early=view.early,
        speed=view.speed,
        omega=view.omega,
        duration=duration,
    )


def planned_views(
    option: Option, base: CaptiveBase, noise: NoiseOf, *, motion_x: float = 0.0
) -> tuple[View, ...]:
    """A run that is not yet made: forces as the base predicts them, noise as stated.

    motion_x [m].
    """
    run = option.run(0)
    if not run.dynamic:
        middle = np.array([option.record / 2])
        return (_view(run, base, noise, middle, np.ones((1, 1)), option.record, motion_x),)
    period = run.settings.period or math.inf
    pieces = [(1, option.cycles, False)]
    if option.cycles >= 4:
        pieces = [(1, 2, True), (2, option.cycles, False)]
    found = []
    for first, last, early in pieces:
        t = np.arange(SAMPLES * first, SAMPLES * last, dtype=np.float64) * (period / SAMPLES)
        projection = projector(design_matrix(2 * math.pi * t / period, Counted.ORDER))
        duration = (last - first) * period
        view = _view(run, base, noise, t, projection, duration, motion_x, early=early)
        found.append(view)
    return tuple(found)


def _view(
    run: Run,
    base: CaptiveBase,
    noise: NoiseOf,
    t: Array,
    projection: Array,
    duration: float,
    motion_x: float,
    *,
    early: bool = False,
) -> View:
    motion = run.nominal_motion(t).moved_aft(motion_x)
    omega = (run.settings.omega or 0.0) if run.dynamic else 0.0
    covariance = noise(
        PlannedPiece(
            dynamic=run.dynamic,
            early=early,
            speed=run.settings.speed,
            omega=omega,
            duration=duration,
        )
    )
    predicted = base.forces(motion, run.settings.speed)
    turned = -motion.rdot / omega**2 if omega else np.zeros_like(motion.u)
    return View(
        run=run,
        early=early,
        projection=projection,
        motion=motion,
        t=t,
        force={name: projection @ predicted[name] for name in covariance if name in predicted},
        covariance=covariance,
        heading=run.settings.drift + turned,
    )


def base_of(model: Model, speeds: Sequence[float]) -> CaptiveBase:
    """The derivatives of a model as the base of a plan, before any test.

    speeds [m/s].
    """
    given: dict[str, float | Sequence[float]] = {}
    for effect in (HULL, INERTIA):
        if effect in model.parts:
            given |= {name: x for name, x in model.parts[effect].values.items() if _named(name)}
    table = converted(
        from_values(
            given,
            ship=model.ship,
            water=model.water,
            Fn=model.Fn or None,
            convention=model.convention,
        ),
        Convention(),
    )
    row = table.value[len(table.value) // 2]
    values = dict(zip(table.names, row.tolist(), strict=True))
    names = {c: tuple(name for name in values if name[0] == c) for c in ("X", "Y", "N")}
    return CaptiveBase(
        names=names,
        values=MappingProxyType(values),
        ship=model.ship,
        water=model.water,
        convention=Convention(),
        reference=float(np.median(speeds)),
    )


def _named(name: str) -> bool:
    try:
        parse_derivative(name)
    except UnknownNameError:
        return False
    return True


def with_names(base: CaptiveBase, names: Mapping[str, Sequence[str]]) -> CaptiveBase:
    """A base with more derivatives, zero where it has no value."""
    joined = {
        channel: tuple(dict.fromkeys((*base.names.get(channel, ()), *names.get(channel, ()))))
        for channel in dict.fromkeys((*base.names, *names))
    }
    zero = {name: 0.0 for own in joined.values() for name in own}
    return replace(base, names=joined, values=MappingProxyType(zero | dict(base.values)))
