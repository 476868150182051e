"""Curves over the length of waves."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from pmmkit.numerics import Array
from pmmkit.plotting import INK, LIMIT, canvas, colour, dash, legend_below, styled
from pmmkit.presentation import figure_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_NOTHING: Final = 1e-9


def over_wave_length(
    ratio: Array, panels: Mapping[str, Mapping[str, Array]], *, longest: float = 3.5
) -> Figure:
    """Panels one below the other, over the length of the waves to that of the ship."""
    with styled():
        figure, axes = _one_below_the_other(len(panels), 2.1, 0.9)
        for axis, (label, curves) in zip(axes, panels.items(), strict=True):
            for number, (name, values) in enumerate(curves.items()):
                axis.plot(
                    ratio, values, color=colour(number), ls=dash(number), label=figure_text(name)
                )
            axis.set_ylabel(label)
            if all(np.nanmax(np.abs(values), initial=0.0) < _NOTHING for values in curves.values()):
                axis.set_ylim(0.0, 1.0)
        axes[-1].set_xlabel("wave length / ship length")
        axes[-1].set_xlim(0.0, min(longest, float(np.max(ratio))))
        legend_below(figure, [*axes], 3)
    return figure


def over_time(t: Array, panels: Mapping[str, Array]) -> Figure:
    """Panels one below the other, over time.

    t [s].
    """
    with styled():
        figure, axes = _one_below_the_other(len(panels), 1.7, 0.6)
        for axis, (label, values) in zip(axes, panels.items(), strict=True):
            axis.plot(t, values, color=colour(0), lw=0.8)
            axis.set_ylabel(label)
        axes[-1].set_xlabel("time [s]")
        axes[-1].set_xlim(t[0], t[-1])
    return figure


def beside_measured(panels: Mapping[str, tuple[Array, Array, Array, Array]]) -> Figure:
    """Measured points with twice their standard uncertainty, beside a computed curve.

    panels [rad/s].
    """
    with styled():
        figure, axes = _one_below_the_other(len(panels), 2.1, 0.9)
        for axis, (label, (omega, measured, std, computed)) in zip(
            axes, panels.items(), strict=True
        ):
            axis.errorbar(omega, measured, 2 * std, fmt="o", color=INK, label="measured")
            axis.plot(omega, computed, color=colour(0), label="computed")
            axis.set_ylabel(label)
            axis.set_ylim(bottom=0.0)
        axes[-1].set_xlabel("frequency of encounter [rad/s]")
        legend_below(figure, [axes[0]], 2)
    return figure


def _one_below_the_other(count: int, each: float, more: float) -> tuple[Figure, Any]:
    """A figure of panels of one abscissa, so high each and so much more [in]."""
    figure = canvas(count * each + more)
    return figure, np.atleast_1d(figure.subplots(count, 1, sharex=True))


def polar(heading_deg: Array, curves: Mapping[str, Array], *, limit: float, label: str) -> Figure:
    """Curves around a ship whose bow is up, over where the waves come from; port mirrors
    starboard."""
    order = np.argsort(-heading_deg)
    bearing = np.radians(180.0 - heading_deg[order])
    around = np.concatenate([bearing, 2 * np.pi - bearing[::-1]])
    with styled():
        figure = canvas(6.0)
        axis: Any = figure.add_subplot(projection="polar")
        axis.set_theta_zero_location("N")
        axis.set_theta_direction(-1)
        for number, (name, values) in enumerate(curves.items()):
            axis.plot(
                around,
                np.concatenate([values[order], values[order][::-1]]),
                color=colour(number),
                ls=dash(number),
                label=figure_text(name),
            )
        circle = np.linspace(0.0, 2 * np.pi, 181)
        axis.plot(circle, np.full(181, limit), color=LIMIT, lw=1.0, label="limit")
        axis.set_ylim(bottom=0.0)
        axis.set_title(f"waves from …° off the bow; {label}")
        legend_below(figure, [axis], 3)
    return figure
