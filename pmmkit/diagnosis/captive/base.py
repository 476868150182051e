"""The base model of a diagnosis: derivatives fitted to all runs at once, and what they predict."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate, pairwise
from types import MappingProxyType
from typing import Final

import numpy as np

from pmmkit.campaigns import Run
from pmmkit.conventions import Convention, Ship, Water
from pmmkit.effects import Regressors, State
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
LARGE: Final = (0.3, 0.8)
"""Sway over speed, and yaw rate r', from which terms of high order are looked for."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CaptiveBase:
    """Derivatives with their meaning and values.

    `convention`: what the derivatives mean. `reference`: speed [m/s] at which F =
    (U/reference)² - 1 is zero.
    """

    names: Mapping[str, tuple[str, ...]]
    values: Mapping[str, float]
    ship: Ship
    water: Water
    convention: Convention
    reference: float

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
        """Predicted forces of the water along a motion [N, N m]."""
        every = [name for names in self.names.values() for name in names]
        columns = self.columns(every, motion, speed) * [self.values[name] for name in every]
        edges = np.cumsum([0, *map(len, self.names.values())]).tolist()
        return {
            channel: columns[:, begin:end].sum(axis=1)
            for channel, (begin, end) in zip(self.names, pairwise(edges), strict=True)
        }

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
        return {name: view.harmonics(x) for name, x in self.forces(motion, speed).items()}

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
