"""What files written for other programs say alike."""

from __future__ import annotations

from typing import Final

from pmmkit.base import Remedy, Way, __version__
from pmmkit.syntax import comment

WHICH_SPEED: Final = Remedy("Say at which speed [m/s], such as {}.", (Way.setting("speed", 8),))
"""Where values depend on the speed and none was given."""


def written_by(sign: str = "%") -> list[str]:
    """Lines of a comment that say which program wrote a file."""
    return comment(f"Written by pmmkit {__version__}.", sign)
