"""Measures of a ship: on the card, and not on it, with the intervals before and after."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from pmmkit.numerics import Array
from pmmkit.plotting import INK, REFERENCE, Figure, beyond, colour

FARTHEST: Final = 150.0
"""How far the axis goes to either side [%]; what lies beyond has an arrow."""
ROW: Final = 0.2
"""Height of a row [inch]."""


def measures(names: Sequence[str], over: Array) -> Figure:
    """Intervals over the value of the ship less one (n, 6), a row a measure; NaN for none.

    Columns: low and high before the card, with the card, and on the card.
    """
    places = np.arange(len(names), dtype=float)
    ends = 100.0 * over.reshape(-1, 3, 2)
    limit = min(FARTHEST, 1.05 * float(np.nanmax(np.abs(ends), initial=10.0)))
    figure = Figure(height=1.1 + ROW * len(names), width=7.2)
    axis = figure.subplots()
    styles = (
        ("before the card", "#d9dce1", 0.8),
        ("with the card", colour(0), 0.45),
        ("on the card", INK, 0.2),
    )
    for number, (label, shade, height) in enumerate(styles):
        low, high = ends[:, number].T
        axis.barh(places, high - low, left=low, height=height, color=shade, label=label)
    axis.axvline(0.0, color=REFERENCE, lw=1.0, ls="--")
    beyond(axis, ends[:, 0, 1], places, (-limit, limit), INK)
    axis.set_yticks(places, names)
    axis.set_ylim(len(names) - 0.4, -0.6)
    axis.set_xlim(-limit, limit)
    axis.without_grid("y")
    axis.set_xlabel("off the ship of the model [%]")
    figure.legend_below([axis], columns=3)
    return figure
