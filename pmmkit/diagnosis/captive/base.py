"""The base model of a diagnosis: derivatives fitted to all runs at once, and what they predict."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import accumulate, pairwise
from types import MappingProxyType
from typing import Final

import numpy as np

from pmmkit.campaigns import Run
from pmmkit.conventions import Convention, Ship, Water
from pmmkit.effects import BY_SPEED, Regressors, State
from pmmkit.numerics import Array
from pmmkit.reduction import View

# Several runs one after another, so that their samples are looked at together.


SAMPLES: Final = 2048
"""Samples that are looked at together: many more of them leave the processor's cache."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ViewSequence:
    """Views one after another."""

    views: tuple[View, ...]

    @cached_property
    def _edges(self) -> list[int]:
        return list(accumulate((len(view.motion.u) for view in self.views), initial=0))

    @property
    def size(self) -> int:
        """Number of samples."""
        return self._edges[-1]

    @property
    def samples(self) -> list[slice]:
        """Those of each view."""
        return [slice(begin, end) for begin, end in pairwise(self._edges)]

    def each(self, values: Sequence[float]) -> Array:
        """A number of each view at its samples (n,)."""
        return np.repeat(values, np.diff(self._edges))

    def means(self, history: Array) -> Array:
        """Mean of a history (n,) in each view."""
        found: Array = np.add.reduceat(history, self._edges[:-1]) / np.diff(self._edges)
        return found

    def history(self, name: str) -> Array:
        """One of the histories of the motion (n,)."""
        return np.concatenate([getattr(view.motion, name) for view in self.views])


def stretches(views: Sequence[View]) -> Iterator[ViewSequence]:
    """Views in their order, as many in one stretch as have `SAMPLES` samples together."""
    held: list[View] = []
    count = 0
    for view in views:
        if held and count + len(view.motion.u) > SAMPLES:
            yield ViewSequence(views=tuple(held))
            held, count = [], 0
        held.append(view)
        count += len(view.motion.u)
    if held:
        yield ViewSequence(views=tuple(held))


MOTION: Final[Mapping[str, Callable[[ViewSequence], Array]]] = MappingProxyType(
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


Forces = dict[str, Array]
"""Histories (n,) or (n, q), or their harmonics, by channel."""
Acting = Callable[[Sequence[View], "CaptiveBase"], Sequence[Mapping[str, Array]]]
"""Harmonics (m, q) of an effect in each view, by channel, at a value of its nonlinear parameter."""
LARGE: Final = (0.3, 0.8)
"""Sway over speed, and yaw rate r', from which terms of high order are looked for."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CaptiveBase:
    """Derivatives with their meaning and values.

    `convention`: what the derivatives mean. `reference`: speed [m/s] at which F =
    (U/reference)² - 1 is zero. `added`: derivatives of effects that act beside them, those with
    the mark of the speed times F. `beside`: effects that are no derivatives, each with what a
    unit of its coefficients does in views, and these coefficients (q,). A fault of the motion
    changes the force of all of them.
    """

    names: Mapping[str, tuple[str, ...]]
    values: Mapping[str, float]
    ship: Ship
    water: Water
    convention: Convention
    reference: float
    added: Mapping[str, float] = field(default_factory=dict)
    beside: tuple[tuple[Acting, Array], ...] = ()

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

    def forces(self, motion: State, speed: float) -> Forces:
        """Predicted forces of the water along a motion [N, N m], of what are derivatives."""
        acting = self._acting(speed)
        columns = self.columns([*acting], motion, speed) * [*acting.values()]
        edges = [0, *accumulate(sum(x[0] == channel for x in acting) for channel in self.names)]
        return {
            channel: columns[:, begin:end].sum(axis=1)
            for channel, (begin, end) in zip(self.names, pairwise(edges), strict=True)
        }

    def _acting(self, speed: float) -> dict[str, float]:
        """All derivatives at a speed, channel by channel."""
        acting: dict[str, float] = {}
        for channel, names in self.names.items():
            acting |= {name: self.values[name] for name in names}
            for marked, value in self.added.items():
                if marked[0] == channel:
                    name = marked.removesuffix(BY_SPEED)
                    share = value if name == marked else value * self.law(speed)
                    acting[name] = acting.get(name, 0.0) + share
        return acting

    def expected(self, view: View) -> Forces:
        """All harmonics of the forces that are predicted in a view."""
        return dict(view.expected) or self.predicted(view)

    def predicted(self, view: View) -> Forces:
        """The same, whatever another base expected there."""
        return self.along(view, view.motion, view.speed)

    def design(self, names: Sequence[str], views: Sequence[View]) -> Array:
        """Harmonics of what derivatives multiply in views, one below the other (n, len(names))."""
        parts = [np.zeros((0, len(names)))]
        for stretch in stretches(views):
            columns = self.columns(
                names,
                State.joined([view.motion for view in stretch.views]),
                stretch.each([view.speed for view in stretch.views]),
            )
            parts += [
                view.project(columns[samples])
                for view, samples in zip(stretch.views, stretch.samples, strict=True)
            ]
        return np.concatenate(parts)

    def along(self, view: View, motion: State, speed: float) -> Forces:
        """All harmonics of the forces that are predicted if the model went otherwise in a view."""
        found = {name: view.harmonics(x) for name, x in self.forces(motion, speed).items()}
        if not self.beside:
            return found
        run = view.run
        if speed != view.speed:
            run = replace(run, settings=replace(run.settings, speed=speed))
        whole = view.projection if view.every is None else view.every
        moved = replace(view, run=run, motion=motion, projection=whole, every=None, kept=None)
        bare = replace(self, beside=())
        for along, sizes in self.beside:
            for name, columns in along([moved], bare)[0].items():
                found[name] = found[name] + columns @ sizes
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

    def law(self, speed: float) -> float:
        """F = (U/reference)² - 1, in which the literature writes the dependence on speed."""
        return (speed / self.reference) ** 2 - 1.0
