"""A virtual towing tank with effects hidden in its records, to test what a diagnosis finds.

It shares no formula with the package: the catalogue's forms are written here again by hand, and the
foreign truth puts each effect in at its physical source.
"""

from .hull import BASE
from .sizes import SHIP, SIZES, WATER
from .tank import BEYOND, EFFECTS, INSIDE, OUTSIDE, UNSEEN, hidden_campaign

__all__ = [
    "BASE",
    "BEYOND",
    "EFFECTS",
    "INSIDE",
    "OUTSIDE",
    "SHIP",
    "SIZES",
    "UNSEEN",
    "WATER",
    "hidden_campaign",
]
