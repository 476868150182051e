"""What the checks of captive tests ask a fault for: how it would look, in words and values."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Literal, Protocol

CHANNELS = ("X", "Y", "N")


class Tested(Protocol):
    """A kind of test, as far as it decides what can be asked; see `TestKind`."""

    @property
    def oscillates(self) -> bool:
        """Whether the model, or its rudder, is swung."""

    @property
    def surges(self) -> bool:
        """Whether the surge motion oscillates by itself."""

    @property
    def yaws(self) -> bool:
        """Whether the heading oscillates."""

    @property
    def drifts(self) -> bool:
        """Whether the test is one with a drift angle."""

    @property
    def circles(self) -> bool:
        """Whether the model is held in a steady turn."""

    @property
    def pure(self) -> str:
        """The velocity that oscillates, where it is alone and no angle is held; else empty."""


def any_test(kind: Tested) -> bool:
    """Every kind of test."""
    del kind
    return True


def oscillating(kind: Tested) -> bool:
    """Tests in which something is swung."""
    return kind.oscillates


def nothing(value: float) -> Mapping[str, float]:
    """No parameter at all."""
    del value
    return {}


@dataclass(frozen=True, kw_only=True)
class Suspect:
    """A form of a fault that the checks ask a run for, or all runs together.

    Parameters
    ----------
    name : str
        What it is called.
    says : callable
        From a value to what is wrong, in words that follow "if".
    remedy : str
        What the user can do about it.
    at : callable
        From a value to the parameters of the fault; those that are not named are zero.
    grid : tuple of float
        Values that are tried.
    continuous : bool
        Whether values between them have a meaning.
    applies : callable
        Whether it can be asked of a kind of test.
    scope : {"both", "one", "all"}
        Whether it is asked of one run, of all, or of both.
    slip : bool
        Whether it is a slip of the hand, to be mended before anything is fitted.
    by_size : bool
        Whether of all runs it shows in the size of derivatives alone, which tells it at one speed
        as well as at many.
    unknown : str
        Parameter whose size nobody tries: it is drawn from a normal distribution about zero, and
        the fault acts in proportion to it. Needed where the fault adds a force that is none of the
        water's; else empty.
    spread : callable
        From a value to the standard deviation of that size.
    each_run : bool
        Whether each run and channel draws that size anew.
    channels : tuple of str
        Channels that it changes.
    """

    name: str
    says: Callable[[float], str]
    remedy: str
    at: Callable[[float], Mapping[str, float]] = nothing
    grid: tuple[float, ...] = (1.0,)
    continuous: bool = False
    applies: Callable[[Tested], bool] = field(default=any_test)
    scope: Literal["both", "one", "all"] = "both"
    slip: bool = False
    by_size: bool = False
    unknown: str = ""
    spread: Callable[[float], float] = field(default=abs)
    each_run: bool = False
    channels: tuple[str, ...] = CHANNELS


def both_signs(sizes: tuple[float, ...]) -> tuple[float, ...]:
    """Sizes to either side of zero, in order.

    Examples
    --------
    >>> both_signs((1.0, 2.0))
    (-2.0, -1.0, 1.0, 2.0)
    """
    return (*(-x for x in sizes[::-1]), *sizes)


def larger_or_smaller(factor: float) -> str:
    """A factor in words.

    Examples
    --------
    >>> larger_or_smaller(1.05)
    '5.0 % larger'
    """
    return f"{abs(100 * (factor - 1)):.1f} % {'larger' if factor > 1 else 'smaller'}"


def late_or_early(seconds: float) -> str:
    """The sign of a delay in words."""
    return "late" if seconds > 0 else "early"
