"""A captive run as the faults of the catalogue see it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pmmkit.conventions import Ship, Water
from pmmkit.effects import State
from pmmkit.numerics import Array
from pmmkit.reduction.observations.views import View, times_factors


class Expects(Protocol):
    """What predicts the forces of captive runs: a fitted base, or a model in the tank."""

    @property
    def ship(self) -> Ship:
        """The model that was tested."""

    @property
    def water(self) -> Water:
        """The water of the tank."""

    def expected(self, view: View) -> Mapping[str, Array]:
        """All harmonics of the forces that are predicted in a view, by channel [N, N m]."""

    def along(self, view: View, motion: State, speed: float) -> Mapping[str, Array]:
        """The same if the model, or its carriage, went otherwise."""


@dataclass(frozen=True)
class RunView:
    """A view of a run beside a prediction; `effects.seen.Observed` says what each word is.

    Parameters
    ----------
    view : View
        The run as measured.
    base : Expects
        What is expected of it.
    """

    view: View
    base: Expects

    @property
    def ship(self) -> Ship:
        """The model that was tested."""
        return self.base.ship

    @property
    def water(self) -> Water:
        """The water of the tank."""
        return self.base.water

    @property
    def motion(self) -> State:
        """Motion of midship at the samples."""
        return self.view.motion

    @property
    def heading(self) -> Array:
        """Heading in the tank [rad]."""
        return self.view.heading

    @property
    def drift(self) -> float:
        """Heading about which the model is swung [rad]."""
        return self.view.run.settings.drift

    @property
    def t(self) -> Array:
        """Time of the samples [s]."""
        return self.view.t

    @property
    def speed(self) -> float:
        """Speed of the carriage [m/s]."""
        return self.view.speed

    @property
    def omega(self) -> float:
        """Angular frequency of the oscillation [rad/s]; 0 for a steady run."""
        return self.view.omega

    @property
    def sways(self) -> bool:
        """Whether the rig oscillates the model across the tank."""
        return self.view.run.kind_of_test.sways

    @property
    def yaws(self) -> bool:
        """Whether the rig oscillates the heading."""
        return self.view.run.kind_of_test.yaws

    @property
    def day(self) -> float:
        """Where the run stands between the first (0) and the last (1) of the campaign."""
        return self.view.day

    @cached_property
    def _expected(self) -> Mapping[str, Array]:
        return self.base.expected(self.view)

    @cached_property
    def forces(self) -> Mapping[str, Array]:
        """Harmonics of the predicted forces that the forces have [N, N m]."""
        return MappingProxyType({name: self.view.pick(x) for name, x in self._expected.items()})

    def along(self, motion: State, *, speed: float | Array | None = None) -> Mapping[str, Array]:
        """The same if the model, or its carriage, went otherwise."""
        found = self.base.along(self.view, motion, self.speed if speed is None else float(speed))
        return {name: self.view.pick(x) for name, x in found.items()}

    def project(self, history: Array) -> Array:
        """Harmonics of a history."""
        return self.view.project(history)

    def shaped(self, force: Array, shape: Callable[[Array], Array]) -> Array:
        """Harmonics of a force of which each instant is changed by itself."""
        return self.view.project(shape(self._history(force)))

    def times(self, force: Array, history: Array) -> Array:
        """Harmonics of a force times a history."""
        return self.view.project(self._history(force) * history)

    def _history(self, force: Array) -> Array:
        """A force at the samples, from the harmonics that it has."""
        kept = slice(None) if self.view.kept is None else self.view.kept
        return np.asarray(self.view.basis[:, kept] @ force)

    def filtered(
        self, factor: Callable[[Array, Array], NDArray[np.complex128]], *channels: str
    ) -> dict[str, Array]:
        """Harmonics of predicted forces, each times a factor."""
        expected = {name: self._expected[name] for name in channels or self._expected}
        count = max(map(len, expected.values()), default=1)
        factors = factor(np.arange((count - 1) // 2 + 1.0), np.asarray(self.omega))
        return {
            name: self.view.pick(times_factors(harmonics, factors))
            for name, harmonics in expected.items()
        }
