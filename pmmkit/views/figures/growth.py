"""How derivatives grow as the bottom comes near."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.conventions import Convention
from pmmkit.plotting import REFERENCE, canvas, colour, legend_below, styled
from pmmkit.reduction import Growth

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_COLUMNS: Final = 4


def growth_over_depth(grown: Sequence[Growth], *, convention: Convention) -> Figure:
    """Factors by which derivatives grow over the depth, measured and by formulas, a panel each.

    Parameters
    ----------
    grown : sequence of Growth
        From the deepest water, where each is 1.
    convention : Convention
        For their symbols.
    """
    names = list(dict.fromkeys(item.name for item in grown))
    rows = math.ceil(len(names) / _COLUMNS)
    with styled():
        figure = canvas(1.9 * rows + 0.9)
        axes = figure.subplots(rows, min(_COLUMNS, len(names)), squeeze=False)
        panels = axes.ravel().tolist()
        for axis, name in zip(panels, names, strict=False):
            own = sorted((x for x in grown if x.name == name), key=lambda item: item.ratio)
            ratio = np.array([*(item.ratio for item in own), own[0].deepest])
            axis.axhline(1.0, color=REFERENCE, lw=0.8)
            axis.plot(
                ratio,
                [*(item.formula for item in own), 1.0],
                color=REFERENCE,
                ls="--",
                marker="x",
                label="formula",
            )
            axis.errorbar(
                ratio,
                [*(item.factor for item in own), 1.0],
                [*(item.half for item in own), 0.0],
                color=colour(0),
                marker="o",
                lw=1.2,
                capsize=3,
                label="measured, 95 % interval",
            )
            axis.set_title(f"${convention.latex(name)}$")
            axis.margins(x=0.15, y=0.18)
            axis.locator_params(nbins=4)
        for axis in panels[len(names) :]:
            axis.remove()
        for axis in panels[: len(names)]:
            axis.set_xlabel("h / T [-]")
        panels[0].set_ylabel("over the deepest [-]")
        legend_below(figure, panels[:1])
    return figure
