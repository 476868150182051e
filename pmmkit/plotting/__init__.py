"""Figures from arrays: nothing of runs, models or tables."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.plotting.animation import animate
    from pmmkit.plotting.axes import WIDTH, Axes
    from pmmkit.plotting.bands import TrackLike, band_histories
    from pmmkit.plotting.figure import Figure
    from pmmkit.plotting.marks import INK, RED_BLUE, Shades
    from pmmkit.plotting.style import LIMIT, REFERENCE, colour, dash, hatch, marker, widened
    from pmmkit.plotting.time_series import Drawn, manoeuvre, steady_turns
    from pmmkit.plotting.turns import beyond, dimension, open_mark, trajectory

__all__ = [
    "INK",
    "LIMIT",
    "RED_BLUE",
    "REFERENCE",
    "WIDTH",
    "Axes",
    "Drawn",
    "Figure",
    "Shades",
    "TrackLike",
    "animate",
    "band_histories",
    "beyond",
    "colour",
    "dash",
    "dimension",
    "hatch",
    "manoeuvre",
    "marker",
    "open_mark",
    "steady_turns",
    "trajectory",
    "widened",
]

lazy(__name__)
