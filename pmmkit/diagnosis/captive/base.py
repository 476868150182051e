"""The base model of a diagnosis: derivatives fitted to all runs at once, and what they predict."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import accumulate, pairwise
from types import MappingProxyType
from typing import Final, TypeVar

import numpy as np

from pmmkit.campaigns import Run
from pmmkit.conventions import Convention, Ship, Water
from pmmkit.effects import BY_SPEED, Regressors, State
from pmmkit.numerics import Array
from pmmkit.reduction import RunViews, View

MOTION: Final[Mapping[str, Callable[[RunViews], Array]]] = MappingProxyType(
    {
        "u": lambda s: s.history("u"),
        "v": lambda s: s.history("v"),
        "r": lambda s: s.history("r"),
        "p": lambda s: s.history("p"),
        "phi": lambda s: s.history("phi"),
        "delta": lambda s: s.history("delta"),
        "n": lambda s: s.history("rps"),
        "U": lambda s: np.hypot(s.history("u"), s.history("v")),
        "beta": lambda s: np.arctan2(-s.history("v"), s.history("u")),
        "sinkage": lambda s: s.history("sinkage"),
        "trim": lambda s: s.history("trim"),
    }
)
"""What an effect may ask for of the motion."""


Speed = TypeVar("Speed", float, Array)
"""One speed, or one at each sample [m/s]."""
Forces = dict[str, Array]
"""Histories (n,) or (n, q), or their harmonics, by channel."""
Columns = Callable[[Sequence[View], "CaptiveBase", float], Sequence[Mapping[str, Array]]]
"""Harmonics (m, q) of an effect in each of several views, by channel, for a unit of each of its q
coefficients, at a value of its nonlinear parameter."""
LARGE: Final = (0.3, 0.8)
"""Sway over speed, and yaw rate r', from which terms of high order are looked for."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CaptiveBase:
    """Derivatives with their meaning and values.

    `convention`: what the derivatives mean. `reference`: speed [m/s] at which F =
    (U/reference)² - 1 is zero. `added`: derivatives of effects that act beside them, those with
    the mark of the speed times F. `beside`: effects that are no derivatives, each with what a
    unit of its coefficients does in views, the value of its nonlinear parameter, and these
    coefficients (q,). A fault of the motion
    changes the force of all of them.
    """

    names: Mapping[str, tuple[str, ...]]
    values: Mapping[str, float]
    ship: Ship
    water: Water
    convention: Convention
    reference: float
    added: Mapping[str, float] = field(default_factory=dict)
    beside: tuple[tuple[Columns, float, Array], ...] = ()

    @property
    def stands_alone(self) -> bool:
        """Whether nothing acts beside its derivatives."""
        return not self.added and not self.beside

    def columns(self, names: Sequence[str], motion: State, speed: float | Array) -> Array:
        """What derivatives multiply along a motion [N, N m], (n, len(names))."""
        return Regressors.at(
            names,
            motion,
            ship=self.ship,
            water=self.water,
            convention=self.convention,
            approach_speed=speed,
        ).columns

    def forces(self, motion: State, speed: float | Array) -> Forces:
        """Predicted forces of the water along a motion [N, N m], of what are derivatives."""
        names, values, by_speed = self._acting
        columns = self.columns(names, motion, speed)
        if by_speed.any():
            law = self.law(np.broadcast_to(speed, (len(columns),)))
            columns = columns * (values + law[:, None] * by_speed)
        else:
            columns = columns * values
        edges = [0, *accumulate(sum(x[0] == channel for x in names) for channel in self.names)]
        return {
            channel: columns[:, begin:end].sum(axis=1)
            for channel, (begin, end) in zip(self.names, pairwise(edges), strict=True)
        }

    @cached_property
    def _acting(self) -> tuple[list[str], Array, Array]:
        """All derivatives, channel by channel, with their values, and what they gain with F."""
        acting: dict[str, list[float]] = {}
        for channel, names in self.names.items():
            acting |= {name: [self.values[name], 0.0] for name in names}
            for marked, value in self.added.items():
                if marked[0] == channel:
                    name = marked.removesuffix(BY_SPEED)
                    acting.setdefault(name, [0.0, 0.0])[name != marked] += value
        values, by_speed = np.reshape([*acting.values()], (-1, 2)).T
        return [*acting], values, by_speed

    def expecting(self, views: Sequence[View]) -> list[View]:
        """Views with all harmonics of the forces that are predicted in them."""
        found = []
        for runs in RunViews.stretches(views, self):
            forces = self.along(runs, runs.motion, runs.speed)
            edges = np.cumsum([len(view.whole) for view in runs.views])[:-1]
            own = {name: np.split(x, edges) for name, x in forces.items()}
            found += [
                replace(view, expected={name: x[k] for name, x in own.items()})
                for k, view in enumerate(runs.views)
            ]
        return found

    def design(self, names: Sequence[str], views: Sequence[View]) -> Array:
        """Harmonics of what derivatives multiply in views, one below the other (n, len(names))."""
        parts = [np.zeros((0, len(names)))]
        for runs in RunViews.stretches(views, self):
            columns = self.columns(names, runs.motion, runs.speed)
            parts += [
                view.project(columns[at]) for view, at in zip(runs.views, runs.samples, strict=True)
            ]
        return np.concatenate(parts)

    def along(self, runs: RunViews, motion: State, speed: Array) -> Forces:
        """All harmonics of the forces that are predicted in views, one below the other, if the
        model and its carriage (n,) went so."""
        forces = self.forces(motion, speed)
        whole = np.stack([*forces.values()], axis=1)
        harmonics = [
            view.harmonics(whole[at]) for view, at in zip(runs.views, runs.samples, strict=True)
        ]
        found = dict(zip(forces, np.concatenate(harmonics).T, strict=True))
        if not self.beside:
            return found
        moved = [
            view.moved(motion.at(at), float(speed[at.start]))
            for view, at in zip(runs.views, runs.samples, strict=True)
        ]
        bare = replace(self, beside=())
        edges = np.cumsum([0, *map(len, harmonics)]).tolist()
        for columns_of, value, sizes in self.beside:
            by_view = columns_of(moved, bare, value)
            for own, (begin, end) in zip(by_view, pairwise(edges), strict=True):
                for name, columns in own.items():
                    found[name][begin:end] += columns @ sizes
        return found

    def excited(self, views: Sequence[View]) -> frozenset[str]:
        """What runs hold, in the words of `Effect.EXCITES`."""
        speeds = {round(view.speed, 6) for view in views}
        runs = tuple({view.run.id: view.run for view in views}.values())
        sway = max(float(np.max(np.abs(view.motion.v) / view.motion.speed)) for view in views)
        yaw = max(
            float(np.max(np.abs(view.motion.r) / view.motion.speed)) * self.ship.L for view in views
        )
        return frozenset(
            word
            for word, there in {
                "several speeds": len(speeds) > 1,
                "four speeds": len(speeds) > 3,
                "repeats": any(len(group) > 1 for group in Run.repeats(runs)),
                "roll": any(np.any(view.motion.phi) or np.any(view.motion.p) for view in views),
                "rudder": any(np.any(view.motion.delta) for view in views),
                "large motion": sway > LARGE[0] or yaw > LARGE[1],
                "sinkage": any(np.any(view.motion.sinkage) for view in views),
            }.items()
            if there
        )

    def law(self, speed: Speed) -> Speed:
        """F = (U/reference)² - 1, in which the literature writes the dependence on speed."""
        return (speed / self.reference) ** 2 - 1.0
