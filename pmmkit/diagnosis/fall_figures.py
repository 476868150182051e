"""How the errors of what is left out of a fit fall with each step."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from pmmkit.base import DataError
from pmmkit.effects import CATALOGUE
from pmmkit.plotting import LIMIT, WIDTH, Axes, Figure, colour, hatch
from pmmkit.presentation import figure_text

TICK: Final = 10
"""Letters in a line under a bar; one word may be longer."""
LINE: Final = 0.14
"""Height of a line of such words [inch]."""
BAR: Final = 0.65
"""Least width of a bar with its number and its words [inch]: panels that have less go below."""
BESIDE: Final = 0.7
"""Width of an ordinate with its name [inch]."""
NEAR: Final = 0.16
"""Share of an axis that a number over a bar takes: a level in there would cross it."""
LEVEL: Final = "noise alone"


@dataclass(frozen=True, kw_only=True)
class Bars:
    """One error after each step.

    `level`: what noise alone gives of it; NaN if that is not known.
    """

    label: str
    errors: tuple[float, ...]
    level: float = math.nan


@dataclass(frozen=True, kw_only=True)
class Panel:
    """Errors of one scale.

    `bars`: one alone has the steps and its numbers written at the bars; several have a legend.
    `scale`: name of the ordinate, with its unit; empty where it is that of the panel before.
    """

    title: str
    bars: tuple[Bars, ...]
    scale: str = ""


def fall(steps: Sequence[str], panels: Sequence[Panel]) -> Figure:
    """Errors of what is left out after each step, and what noise alone gives of them."""
    if not steps or not panels:
        raise DataError("There is no step to draw.")
    alone = all(len(panel.bars) == 1 for panel in panels)
    most = int(WIDTH / (BAR * len(steps) + BESIDE)) if alone else len(panels)
    rows = math.ceil(len(panels) / max(most, 1))
    columns = math.ceil(len(panels) / rows)
    lines = max(text.count("\n") for text in _ticks(steps))
    figure = Figure(height=rows * (2.8 + LINE * lines) if alone else 4.2)
    grid = figure.subplots(
        rows,
        columns,
        sharey=not all(panel.scale for panel in panels),
        width_ratios=None if alone else [len(panel.bars) for panel in panels],
        squeeze=False,
    )
    axes = grid.ravel()[: len(panels)]
    for left in grid.ravel()[len(panels) :]:
        left.remove()
    for axis, panel in zip(axes, panels, strict=True):
        if len(panel.bars) == 1:
            _waterfall(axis, steps, panel.bars[0])
        else:
            _beside(axis, steps, panel.bars)
        axis.without_grid("x")
        axis.set_title(panel.title)
        if panel.scale:
            axis.set_ylabel(panel.scale)
    if not alone or any(math.isfinite(panel.bars[0].level) for panel in panels):
        figure.legend_below(axes.tolist())
    return figure


def _waterfall(axis: Axes, steps: Sequence[str], own: Bars) -> None:
    """A bar per step with its number over it, and the level as a line."""
    known = math.isfinite(own.level)
    highest = max([x for x in own.errors if math.isfinite(x)] + [own.level] * known, default=0.0)
    axis.bar(
        range(len(steps)),
        own.errors,
        width=0.75,
        color=[colour(number) for number in range(len(steps))],
        label="error",
    )
    for number, value in enumerate(own.errors):
        crossed = known and 0.0 <= own.level - value < NEAR * highest
        axis.text(
            number,
            own.level if crossed else value,
            f"{value:.3g}",
            xytext=(0.0, 1.0),
            ha="center",
            va="bottom",
            fontsize="small",
        )
    if known:
        axis.axhline(own.level, color=LIMIT, lw=1.0, ls="--", label=LEVEL)
    axis.set_ylim(0.0, (1.0 + NEAR) * highest or 1.0)
    axis.set_xlim(-0.7, len(steps) - 0.3)
    axis.set_xticks(range(len(steps)), _ticks(steps))


def _beside(axis: Axes, steps: Sequence[str], bars: Sequence[Bars]) -> None:
    """Bars of the steps beside each other, and the level of each error as a line across them."""
    width = 0.8 / len(steps)
    places = np.arange(len(bars))
    for number, step in enumerate(steps):
        words = figure_text(CATALOGUE.title_of(step))
        axis.bar(
            places + (number - 0.5 * (len(steps) - 1)) * width,
            [own.errors[number] for own in bars],
            width=0.92 * width,
            color=colour(number),
            hatch=hatch(number),
            label=f"+ {words}" if number else words,
        )
    levels = np.array([own.level for own in bars])
    if np.any(np.isfinite(levels)):
        axis.hlines(levels, places - 0.44, places + 0.44, color=LIMIT, lw=1.2, ls="--", label=LEVEL)
    axis.set_xticks(places, [own.label for own in bars])


def _ticks(steps: Sequence[str]) -> list[str]:
    """The steps in short lines."""
    lines = [
        textwrap.wrap(CATALOGUE.title_of(step), TICK, break_long_words=False) for step in steps
    ]
    words = ["\n".join(map(figure_text, own)) for own in lines]
    return [f"+ {word}" if number else word for number, word in enumerate(words)]
