"""Which Froude number the derivatives of a manoeuvre are those of, and how far tests reach."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Literal, get_args

import numpy as np

from pmmkit.equations import Prepared, prepare, prepare_following
from pmmkit.models import Model
from pmmkit.numerics import Array
from pmmkit.presentation import Described, Section

if TYPE_CHECKING:
    from pmmkit.equations import DenseHistory

Follow = Literal["approach", "instant"]
"""Derivatives at the Froude number of the approach throughout, or at that of each instant."""
FOLLOWS: Final[tuple[str, ...]] = get_args(Follow)
FINENESS: Final = 0.05
"""Interval at which the speed is looked at, in ship lengths over the approach speed; between two
such instants it is taken as a line."""


@dataclass(frozen=True, kw_only=True, repr=False)
class FroudeRange(Described):
    """How long a manoeuvre was inside the range of Froude numbers that were tested.

    `low, high`: least and greatest Froude number of the model's values. A speed up to 2 %
    beside them counts as inside, as it does for the approach. `slowest, fastest`: least and
    greatest Froude number of the manoeuvre. `below, above`: time beyond either end [s]; the
    values of that end were held. `duration`: of the manoeuvre [s].

    Examples
    --------
    >>> found = FroudeRange(
    ...     low=0.15, high=0.3, slowest=0.1, fastest=0.3, below=30.0, above=0.0, duration=120.0
    ... )
    >>> found.share_below
    0.25
    """

    low: float
    high: float
    slowest: float
    fastest: float
    below: float
    above: float
    duration: float

    @property
    def share_below(self) -> float:
        """Share of the manoeuvre below the range."""
        return self.below / self.duration

    @property
    def share_above(self) -> float:
        """Share of the manoeuvre above the range."""
        return self.above / self.duration

    @property
    def numbers(self) -> dict[str, float]:
        """All of it by name."""
        return {
            "low": self.low,
            "high": self.high,
            "slowest": self.slowest,
            "fastest": self.fastest,
            "below": self.below,
            "above": self.above,
            "share_below": self.share_below,
            "share_above": self.share_above,
        }

    @property
    def words(self) -> str:
        """A sentence for people."""
        outside = [
            f"{where} it {seconds:.3g} s ({100 * share:.0f} %), held at Fn {edge:.3f}"
            for where, seconds, share, edge in (
                ("below", self.below, self.share_below, self.low),
                ("above", self.above, self.share_above, self.high),
            )
            if seconds > 0.0
        ]
        return (
            f"Derivatives of the moment, tested at Fn {self._span}; the manoeuvre has Fn "
            f"{self.slowest:.3f} to {self.fastest:.3f}: {', '.join(outside) or 'all of it inside'}."
        )

    @property
    def _span(self) -> str:
        return f"{self.low:.3f}" + (f" to {self.high:.3f}" if self.high > self.low else "")

    def _headline(self) -> str:
        below, above = 100 * self.share_below, 100 * self.share_above
        return f"Fn {self._span}: {below:.0f} % of {self.duration:.4g} s below, {above:.0f} % above"

    def _sections(self) -> Sequence[Section]:
        return [Section(paragraphs=[self.words])]


def prepared(model: Model, speed: float, fn: str, **settings: Any) -> Prepared:
    """A model ready to be integrated; arguments as for `prepare` and `Follow`."""
    return (prepare_following if fn == "instant" else prepare)(model, speed, **settings)


def froude_range(model: Model, history: DenseHistory) -> FroudeRange | None:
    """How far the tests of a model reach in a manoeuvre; None for one set of values at all
    speeds."""
    if not model.Fn:
        return None
    ready = history.ready
    count = max(round(history.end * ready.speed / ready.L / FINENESS), 1) + 1
    t = np.linspace(0.0, history.end, count)
    channels = history.channels(t)
    froude = np.hypot(channels["u"], channels["v"]) * model.ship.froude(1.0, model.water.g)
    low, high = model.Fn[0], model.Fn[-1]
    return FroudeRange(
        low=low,
        high=high,
        slowest=float(froude.min()),
        fastest=float(froude.max()),
        below=time_below(t, froude, model.held[0]),
        above=time_below(t, -froude, -model.held[1]),
        duration=history.end,
    )


def time_below(t: Array, values: Array, level: float) -> float:
    """How long a broken line lies below a level.

    Examples
    --------
    >>> time_below(np.array([0.0, 1.0, 3.0]), np.array([1.0, -1.0, -1.0]), 0.0)
    2.5
    """
    over = values - level
    first, last = over[:-1], over[1:]
    least, most = np.minimum(first, last), np.maximum(first, last)
    crossing = (least < 0.0) & (most > 0.0)
    share = np.where(crossing, -least / np.where(crossing, most - least, 1.0), least < 0.0)
    return float(np.diff(t) @ share)
