"""Runs that could be made, as they are ranked: captive tests and manoeuvres answer the same."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final, Protocol

import numpy as np

from pmmkit.diagnosis.planning.ground import Ground
from pmmkit.diagnosis.planning.information import Reduced
from pmmkit.diagnosis.planning.options import Option
from pmmkit.diagnosis.planning.separation import Likely, UsualEffects, likely, usual
from pmmkit.numerics import Array

TWICE: Final = 2
"""Runs that are asked for at a speed at which none is made."""


class Offer(Protocol):
    """What could be made beside what is made, and what it would tell of effects."""

    @property
    def options(self) -> Mapping[str, Option]:
        """Runs that could be made, by name."""

    @property
    def names(self) -> tuple[str, ...]:
        """Effects that take part."""

    def check(self, name: str) -> str:
        """What settles an effect at the bench or on the rig; empty if nothing does."""

    def least(self, option: Option, /) -> int:
        """How often a run is to be made at least."""

    def likely(self, names: Sequence[str]) -> tuple[Likely, ...]:
        """A set of effects as what is made leaves it likely."""

    def added(self, run: str, times: int) -> Array:
        """Rows of unit covariance (m, k) that a run adds, in the columns of what is likely."""

    def signals(self, run: str | None = None, times: int = 1) -> Array:
        """Squared signal over noise of each effect (e,) at its usual size, after a run."""

    def separations(self, run: str | None = None, times: int = 1) -> Array:
        """The part of it that no size of another effect explains (e, e), after a run."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CaptiveOffer:
    """Captive tests, by what those that are made tell.

    `ground`: runs made and runs that could be made. `reduced`: what the runs made tell.
    """

    ground: Ground
    reduced: Reduced

    @property
    def options(self) -> Mapping[str, Option]:
        """Runs that could be made, by name."""
        return self.ground.options

    @cached_property
    def usual(self) -> UsualEffects:
        """Effects at their usual sizes."""
        return usual(self.ground.rows)

    @property
    def names(self) -> tuple[str, ...]:
        """Effects that take part."""
        return self.usual.names

    def check(self, name: str) -> str:
        """What settles an effect at the bench or on the rig."""
        return self.ground.candidates[name].check

    def least(self, option: Option, /) -> int:
        """Twice at a new speed: one run would decide alone there, and may be wrong."""
        return TWICE if self.ground.is_new_speed(option.settings.speed) else 1

    def likely(self, names: Sequence[str]) -> tuple[Likely, ...]:
        """A set of effects as the runs made leave it likely."""
        return likely(self.reduced, names)

    def added(self, run: str, times: int) -> Array:
        """What a run adds, the base refitted."""
        return self.reduced.added(run, times)

    def signals(self, run: str | None = None, times: int = 1) -> Array:
        """Squared signal over noise of each effect after a run."""
        before = self.usual.signals(self.reduced.normal.information)
        if run is None:
            return before
        more: Array = np.sum((self.added(run, times) @ self.usual.sizes) ** 2, axis=0)
        return before + more

    def separations(self, run: str | None = None, times: int = 1) -> Array:
        """The part of it that no size of another explains, after a run."""
        gram = self.reduced.normal.information
        if run is not None:
            columns = self.added(run, times)
            gram = gram + columns.T @ columns
        return self.usual.separations(gram)
