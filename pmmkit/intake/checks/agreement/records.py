"""The runs of a group as the faults of the catalogue see them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from pmmkit.conventions import Ship, Water
from pmmkit.effects import State
from pmmkit.intake.checks.agreement.rows import CHANNELS, PHASES, RunGroup
from pmmkit.numerics import Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Records:
    """All runs of a group; `effects.seen.Observed` says what each word is.

    Forces are histories by channel, (n, 32) with values of the parameters [N, N m], and without
    them what each parameter multiplies, (n, 32, p), over ½ρL²U² of the run [-, m].

    `histories (n, 32, 3, p)`: what each parameter multiplies along the motion, as
    `Group.histories` gives it.
    """

    group: RunGroup
    histories: Array
    value: Array | None = None

    @property
    def ship(self) -> Ship:
        """The model that was tested."""
        return self.group.campaign.ship

    @property
    def water(self) -> Water:
        """The water of the tank."""
        return self.group.campaign.water

    @property
    def motion(self) -> State:
        """Motion of midship at 32 phases of each run."""
        return self.group.motion

    @cached_property
    def heading(self) -> Array:
        """Heading in the tank [rad]."""
        return self.group.heading.ravel()

    @cached_property
    def drift(self) -> Array:
        """Heading about which the model is swung [rad]."""
        return _each([item.run.settings.drift for item in self.group.summaries])

    @cached_property
    def t(self) -> Array:
        """Time within a cycle [s]; 0 in a steady run."""
        period = np.divide(2 * np.pi, self.omega, where=self.omega > 0, out=0.0 * self.omega)
        return period * np.tile(np.arange(PHASES) / PHASES, len(self.group.summaries))

    @cached_property
    def speed(self) -> Array:
        """Speed of the carriage [m/s]."""
        return _each([item.run.settings.speed for item in self.group.summaries])

    @cached_property
    def omega(self) -> Array:
        """Angular frequency of the oscillation [rad/s]; 0 for a steady run."""
        return _each(self.group.omega)

    @cached_property
    def sways(self) -> Array:
        """Whether the rig oscillates the model across the tank."""
        return _each([item.run.kind_of_test.sways for item in self.group.summaries])

    @cached_property
    def yaws(self) -> Array:
        """Whether the rig oscillates the heading."""
        return _each([item.run.kind_of_test.yaws for item in self.group.summaries])

    @property
    def day(self) -> float:
        """No run is held against another hour of the day here."""
        return 0.0

    @cached_property
    def forces(self) -> Mapping[str, Array]:
        """The forces along the motion, by channel."""
        return self._by_channel(self.histories)

    def along(self, motion: State, *, speed: float | Array | None = None) -> Mapping[str, Array]:
        """The forces if the model, or its carriage, went otherwise."""
        return self._by_channel(self.group.histories(motion, speed=speed))

    def project(self, history: Array) -> Array:
        """A history as a force: of no parameter, so that only forces with values know it."""
        if self.value is None:
            raise ValueError(
                "A fault that adds a force of its own is asked with an unknown size: see "
                "Suspect.unknown."
            )
        return history.reshape(-1, PHASES)

    def shaped(self, force: Array, shape: Callable[[Array], Array]) -> Array:
        """A force of which each instant is changed by itself."""
        return shape(force)

    def times(self, force: Array, history: Array) -> Array:
        """A force times a history."""
        return np.asarray(force * history.reshape(-1, PHASES, *(1,) * (force.ndim - 2)))

    def filtered(
        self, factor: Callable[[Array, Array], NDArray[np.complex128]], *channels: str
    ) -> dict[str, Array]:
        """Forces with each harmonic times a factor."""
        gain = factor(np.arange(PHASES // 2 + 1.0)[None, :], self.group.omega[:, None])
        found = {}
        for name in channels or CHANNELS:
            force = self.forces[name]
            shape = gain.reshape(*gain.shape, *(1,) * (force.ndim - 2))
            spectrum = np.fft.rfft(force, axis=1) * shape
            found[name] = np.fft.irfft(spectrum, PHASES, axis=1)
        return found

    def as_histories(
        self, forces: Mapping[str, Array], others: Array, touched: NDArray[np.bool_]
    ) -> Array:
        """Forces of some channels and runs over the units of the group, the rest as in others."""
        out = others.copy()
        for k, name in enumerate(CHANNELS):
            if name in forces:
                shown = _over(forces[name], self._unit(k, forces[name].ndim))
                if touched.all():
                    out[:, :, k] = shown
                else:
                    out[touched, :, k] = shown[touched]
        return out

    def _by_channel(self, histories: Array) -> Mapping[str, Array]:
        shown = histories if self.value is None else histories @ self.value
        return MappingProxyType(
            {
                name: _times(shown[:, :, k], self._unit(k, shown.ndim - 1))
                for k, name in enumerate(CHANNELS)
            }
        )

    def _unit(self, channel: int, dimensions: int) -> float | Array:
        """Unit of a channel over the one in which the group has it, in each run."""
        if self.value is None:
            return self.ship.L if CHANNELS[channel] == "N" else 1.0
        return self.group.units[:, channel].reshape(-1, *(1,) * (dimensions - 1))


def _times(force: Array, unit: float | Array) -> Array:
    return force if isinstance(unit, float) and unit == 1.0 else force * unit


def _over(force: Array, unit: float | Array) -> Array:
    return force if isinstance(unit, float) and unit == 1.0 else force / unit


def _each(of_runs: object) -> Array:
    """What is told of runs, of each of their 32 phases."""
    return np.repeat(np.asarray(of_runs), PHASES)
