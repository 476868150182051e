"""What the checks know of a run: a few kilobytes, whatever the length of its record."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from pmmkit.campaigns import Run
from pmmkit.numerics import Array

EMPTY: Final[Array] = np.zeros(0)


@dataclass(frozen=True, kw_only=True)
class Summary:
    """One run in a few numbers, SI and radians.

    Parameters
    ----------
    run : Run
        The run (its samples are not kept).
    means : mapping of str to float
        Mean of each force channel: of the steady window, of the row, or harmonic 0.
    cos, sin : mapping of str to array (4,)
        Harmonics 0 to 3 of forces and motions of an oscillating run, θ = ωt with the motion
        ∝ sin θ: cosines in phase with the velocity, sines with the displacement. ``cos`` at 0 is
        the mean.
    cycles : mapping of str to array (cycles, 7)
        The same cycle by cycle, order C0, C1, S1, C2, S2, C3, S3; only from histories.
    harmonic_noise, cycle_noise : mapping of str to float
        Standard error of a first harmonic of the record (of the mean of a steady one), and of
        one cycle.
    digest : str
        Hash of the force values.
    sketch : array
        A few dozen force values, scaled, by which near copies are found.
    facts : mapping of str to float
        Facts about times, flat stretches and motions, by name.
    """

    run: Run
    means: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    cos: Mapping[str, Array] = field(default_factory=lambda: MappingProxyType({}))
    sin: Mapping[str, Array] = field(default_factory=lambda: MappingProxyType({}))
    cycles: Mapping[str, Array] = field(default_factory=lambda: MappingProxyType({}))
    harmonic_noise: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    cycle_noise: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    digest: str = ""
    sketch: Array = field(default_factory=lambda: EMPTY)
    facts: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))

    def without(self, names: Collection[str]) -> Summary:
        """The run without some force channels, as if they had not been measured."""
        parts: dict[str, Any] = {
            part: {key: x for key, x in getattr(self, part).items() if key not in names}
            for part in ("means", "cos", "sin", "cycles", "harmonic_noise", "cycle_noise")
        }
        return replace(self, **parts)

    def c(self, name: str, order: int) -> float:
        """Harmonic in phase with the velocity; nan where it is not known."""
        return float(self.cos[name][order]) if name in self.cos else math.nan

    def s(self, name: str, order: int) -> float:
        """Harmonic in phase with the displacement; nan where it is not known."""
        return float(self.sin[name][order]) if name in self.sin else math.nan

    def mean(self, name: str) -> float:
        """Mean of a force; nan where it is not known."""
        return float(self.means.get(name, math.nan))

    def level(self, name: str) -> float:
        """Largest harmonic (1 to 3) of a channel in magnitude; 0 where it is not known."""
        if name not in self.cos:
            return 0.0
        return float(np.hypot(self.cos[name][1:], self.sin[name][1:]).max())
