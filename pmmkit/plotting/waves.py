"""Curves over the length of waves."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from pmmkit.escaping import figure_text
from pmmkit.numerics import Array
from pmmkit.plotting import style

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def over_wave_length(
    ratio: Array, panels: Mapping[str, Mapping[str, Array]], *, longest: float = 3.5
) -> Figure:
    """Panels one below the other, over the length of the waves to that of the ship.

    Parameters
    ----------
    ratio : array
        λ/L.
    panels : mapping of str to mapping of str to array
        Label of the ordinate of each panel, and its curves by name.
    longest : float
        λ/L at which the axis ends.

    Returns
    -------
    Figure
    """
    with style.styled():
        figure = style.canvas(2.1 * len(panels) + 0.9)
        axes = np.atleast_1d(figure.subplots(len(panels), 1, sharex=True))
        for axis, (label, curves) in zip(axes, panels.items(), strict=True):
            for number, (name, values) in enumerate(curves.items()):
                axis.plot(
                    ratio,
                    values,
                    color=style.colour(number),
                    ls=style.dash(number),
                    label=figure_text(name),
                )
            axis.set_ylabel(label)
        axes[-1].set_xlabel("wave length / ship length")
        axes[-1].set_xlim(0.0, min(longest, float(np.max(ratio))))
        style.legend_below(figure, [*axes], 3)
    return figure
