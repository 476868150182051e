"""Diagnosis: evidence of every effect, and what the runs could show."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from pmmkit.effects import CATALOGUE
from pmmkit.plotting import INK, LIMIT, REFERENCE, Figure
from pmmkit.plotting import colour as colour_style
from pmmkit.plotting import hatch as hatch_style
from pmmkit.presentation import figure_text

_MOST: Final = 14
"""Effects in the figure of evidence."""
_CERTAIN: Final = math.log(1000.0)
_KINDS: Final = {
    False: ("ship and water", colour_style(0), hatch_style(0)),
    True: ("measurement", colour_style(2), hatch_style(1)),
}


def evidence(
    sets: Sequence[tuple[str, ...]],
    log_evidence: Sequence[float],
    *,
    named: Sequence[bool],
    faults: Sequence[bool],
) -> Figure:
    """ln evidence of the best effects and sets of them, those that are named marked."""
    shown = sorted(range(len(sets)), key=lambda i: -log_evidence[i])[:_MOST]
    lines = np.array([max(len(sets[i]), 1.6) for i in shown])
    places = np.cumsum(lines) - lines / 2
    figure = Figure(height=1.0 + 0.19 * float(lines.sum()))
    axis = figure.subplots()
    for place, i in zip(places, shown, strict=True):
        label, colour, hatch = _KINDS[faults[i]]
        look: dict[str, Any] = {"color": colour, "hatch": hatch}
        axis.barh(place, log_evidence[i], height=1.0, alpha=1.0 if named[i] else 0.35, **look)
        axis.barh(place, 0.0, label=label, **look)
    axis.axvline(0.0, color=INK, lw=0.8)
    axis.axvline(_CERTAIN, color=LIMIT, lw=1.0, ls="--", label="1000 to 1")
    axis.set_yticks(places, [_words(sets[i]) for i in shown])
    axis.set_ylim(float(lines.sum()), 0.0)
    axis.set_xscale("symlog", linthresh=10.0)
    axis.without_grid("y")
    axis.set_xlabel("ln evidence against no effect [-]   (full colour: named)")
    figure.legend_below([axis])
    return figure


def coverage(names: Sequence[str], hides: Sequence[float], shown: Sequence[bool]) -> Figure:
    """Share of its usual size that each effect could have and hide from these runs."""
    order = sorted(range(len(names)), key=lambda i: hides[i])
    figure = Figure(height=1.0 + 0.22 * len(order))
    axis = figure.subplots()
    for place, i in enumerate(order):
        colour = colour_style(1) if shown[i] else REFERENCE
        axis.barh(
            place,
            min(hides[i], _LARGEST),
            height=0.62,
            color=colour,
            label="these runs can show it" if shown[i] else "they cannot",
        )
        if hides[i] > _LARGEST:
            axis.plot(_LARGEST, place, ls="", marker=">", ms=4, color=INK)
    axis.axvline(1.0, color=INK, lw=0.8)
    axis.set_yticks(range(len(order)), [_words((names[i],)) for i in order])
    axis.set_ylim(len(order) - 0.4, -0.6)
    axis.set_xscale("log")
    axis.without_grid("y")
    axis.set_xlabel("size that could hide, over the usual size [-]; an arrow: larger still")
    figure.legend_below([axis])
    return figure


def homogeneity(rows: Sequence[tuple[str, str, str, float, float]]) -> Figure:
    """Sizes by level of each factor, an axis for each effect.

    Rows: effect, factor, level in words, size over that of all tests, half of its 95 % interval.
    """
    effects = list(dict.fromkeys(row[0] for row in rows))
    levels = list(dict.fromkeys((row[1], row[2]) for row in rows))
    factors = list(dict.fromkeys(factor for factor, _ in levels))
    levels.sort(key=lambda level: factors.index(level[0]))
    gaps = [factors.index(factor) for factor, _ in levels]
    places = dict(zip(levels, (k + 0.6 * gap for k, gap in enumerate(gaps)), strict=True))
    figure = Figure(height=1.1 + 0.22 * (len(levels) + 0.6 * len(factors)))
    axes = figure.subplots(1, max(len(effects), 1), sharey=True, squeeze=False)[0]
    for axis, effect in zip(axes, effects, strict=False):
        for _, factor, words, size, half in (row for row in rows if row[0] == effect):
            shown, reach = min(max(size, -_FAR), 2.0 + _FAR), min(half, 2.0 * _FAR)
            axis.errorbar(
                shown,
                places[factor, words],
                xerr=reach,
                ls="",
                marker="o",
                ms=4,
                color=colour_style(factors.index(factor)),
            )
        axis.axvline(1.0, color=INK, lw=0.8)
        axis.set_xlim(-_FAR, 2.0 + _FAR)
        axis.without_grid("y")
        axis.set_title(_words((effect,)))
        axis.set_xlabel("size here over size of all tests [-]")
    axes[0].set_yticks([places[level] for level in levels], [words for _, words in levels])
    axes[0].set_ylim(max(places.values(), default=0.0) + 0.7, -0.7)
    return figure


_FAR: Final = 0.5
"""How far the axis of sizes goes below 0 and above 2."""
_LARGEST: Final = 30.0


def _words(names: tuple[str, ...]) -> str:
    return ",\n".join(figure_text(CATALOGUE.title_of(name)) for name in names)
