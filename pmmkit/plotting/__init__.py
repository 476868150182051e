"""Axes from arrays: nothing of runs, models or tables."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.plotting.animation import animate
    from pmmkit.plotting.bands import TrackLike, band_histories
    from pmmkit.plotting.style import (
        INK,
        LIMIT,
        REFERENCE,
        WIDTH,
        canvas,
        colour,
        dash,
        hatch,
        in_powers,
        legend_below,
        marker,
        save,
        styled,
        svg,
        widened,
    )
    from pmmkit.plotting.time_series import Drawn, manoeuvre, steady_turns
    from pmmkit.plotting.turns import beyond, dimension, open_mark, trajectory

__all__ = [
    "INK",
    "LIMIT",
    "REFERENCE",
    "WIDTH",
    "Drawn",
    "TrackLike",
    "animate",
    "band_histories",
    "beyond",
    "canvas",
    "colour",
    "dash",
    "dimension",
    "hatch",
    "in_powers",
    "legend_below",
    "manoeuvre",
    "marker",
    "open_mark",
    "save",
    "steady_turns",
    "styled",
    "svg",
    "trajectory",
    "widened",
]

lazy(__name__)
