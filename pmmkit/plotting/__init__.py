"""Axes from arrays: nothing of runs, models or tables."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.plotting.bands import band_histories
    from pmmkit.plotting.derivatives import influence_map, over_froude
    from pmmkit.plotting.history import TrackLike
    from pmmkit.plotting.marks import beyond, dimension, guide, open_mark
    from pmmkit.plotting.style import (
        INK,
        LIMIT,
        ORDERED,
        REFERENCE,
        WIDTH,
        canvas,
        colour,
        dash,
        document,
        figure_files,
        hatch,
        in_powers,
        legend_below,
        marker,
        save,
        styled,
        svg,
        symbol,
        widened,
    )
    from pmmkit.plotting.time_series import Drawn, manoeuvre, steady_turns, zigzag
    from pmmkit.plotting.turns import trajectory, turn_histories

__all__ = [
    "INK",
    "LIMIT",
    "ORDERED",
    "REFERENCE",
    "WIDTH",
    "Drawn",
    "TrackLike",
    "band_histories",
    "beyond",
    "canvas",
    "colour",
    "dash",
    "dimension",
    "document",
    "figure_files",
    "guide",
    "hatch",
    "in_powers",
    "influence_map",
    "legend_below",
    "manoeuvre",
    "marker",
    "open_mark",
    "over_froude",
    "save",
    "steady_turns",
    "styled",
    "svg",
    "symbol",
    "trajectory",
    "turn_histories",
    "widened",
    "zigzag",
]

lazy(__name__)
