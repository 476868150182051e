"""The base model of a diagnosis: derivatives fitted to all runs at once, and what they predict."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from pmmkit.conventions import Convention
from pmmkit.diagnosis.captive.stretch import stretches
from pmmkit.effects.hull import regressors
from pmmkit.effects.state import State
from pmmkit.numerics import Array
from pmmkit.observations.views import View
from pmmkit.ship import Ship, Water

Forces = dict[str, Array]
"""Histories (n,) or (n, q), or their harmonics, by channel."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Base:
    """Derivatives with their meaning and values.

    Parameters
    ----------
    names : mapping of channel to names
        Derivatives.
    values : mapping of str to float
        Fitted values.
    ship, water : Ship, Water
        Of the tests.
    convention : Convention
        What the derivatives mean.
    reference : float
        Speed [m/s] at which F = (U/reference)² - 1 is zero.
    """

    names: Mapping[str, tuple[str, ...]]
    values: Mapping[str, float]
    ship: Ship
    water: Water
    convention: Convention
    reference: float

    def columns(self, names: Sequence[str], motion: State, speed: float | Array) -> Array:
        """What derivatives multiply along a motion [N, N m], (n, len(names))."""
        return regressors(
            names,
            motion,
            ship=self.ship,
            water=self.water,
            convention=self.convention,
            approach_speed=speed,
        )

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

    def law(self, speed: float) -> float:
        """F = (U/reference)² - 1, in which the literature writes the dependence on speed."""
        return (speed / self.reference) ** 2 - 1.0
