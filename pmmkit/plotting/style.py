"""How figures look: one palette of colours and marks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from pmmkit.plotting.axes import Axes


ORDERED: Final = ("#0b2a6b", "#00a78d", "#f8a439", "#902f58", "#966852")
"""Colours for ordered sets (Froude numbers): told apart by hue and by lightness, whatever the
reader's colour vision, and on paper without colour."""
MARKERS: Final = ("o", "s", "^", "D", "v", "P", "X")
DASHES: Final = ("-", "--", "-.", ":")
HATCHES: Final = ("", "///", "...", "\\\\\\")
FEW: Final = 12
"""Orders of a manoeuvre up to which a line is drawn at each."""
REFERENCE: Final = "#777777"
LIMIT: Final = "#b3261e"


def colour(number: int) -> str:
    """Colour of a set by its `number`."""
    return ORDERED[number % len(ORDERED)]


def marker(number: int) -> str:
    """Marker of a set by its `number`, so that colour is never the only difference."""
    return MARKERS[number % len(MARKERS)]


def dash(number: int, *, rounds: bool = False) -> str:
    """Dash of a line by its `number`; with `rounds` another one for each round of the colours."""
    return DASHES[(number // len(ORDERED) if rounds else number) % len(DASHES)]


def hatch(number: int, *, rounds: bool = False) -> str:
    """Hatch of bars by their `number`; with `rounds` another one for each round of the colours."""
    return HATCHES[(number // len(ORDERED) if rounds else number) % len(HATCHES)]


ROUNDING: Final = 1e-12
"""Height of an axis, in whatever unit, below which it shows what arithmetic leaves of zero: a ship
that stops on a straight course turns by 1e-19 degrees."""
FLAT: Final = 0.055
"""What such an axis shows to either side: as of a line that is zero."""


def widened(axis: Axes, share: float = 1e-4) -> None:
    """Widen ordinates that hold next to nothing but one value, so that ticks stay short, and that
    hold the rounding of zero alone.

    Parameters
    ----------
    axis : Axes
        After everything was drawn on it.
    share : float
        Least height of the axis over the value in its middle.
    """
    low, high = axis.limits("y")
    middle = (low + high) / 2
    if abs(high - low) < share * abs(middle):
        axis.set_ylim(middle - 0.1 * abs(middle), middle + 0.1 * abs(middle))
    elif abs(high - low) < ROUNDING:
        axis.set_ylim(-FLAT, FLAT)
