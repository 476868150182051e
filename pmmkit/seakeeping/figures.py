"""Curves over the length of waves."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from pmmkit.numerics import Array
from pmmkit.plotting import INK, LIMIT, Axes, Figure, colour, dash
from pmmkit.presentation import figure_text

_NOTHING: Final = 1e-9
_AROUND: Final = np.linspace(0.0, 2 * np.pi, 181)
_GRID: Final = "#e3e3e3"
_NUMBER: Final[Any] = {"ha": "center", "va": "center", "fontsize": 9, "color": "#444444"}


def over_wave_length(
    ratio: Array, panels: Mapping[str, Mapping[str, Array]], *, longest: float = 3.5
) -> Figure:
    """Panels one below the other, over the length of the waves to that of the ship."""
    figure, axes = _one_below_the_other(len(panels), 2.1, 0.9)
    for axis, (label, curves) in zip(axes, panels.items(), strict=True):
        for number, (name, values) in enumerate(curves.items()):
            axis.plot(ratio, values, color=colour(number), ls=dash(number), label=figure_text(name))
        axis.set_ylabel(label)
        if all(np.nanmax(np.abs(values), initial=0.0) < _NOTHING for values in curves.values()):
            axis.set_ylim(0.0, 1.0)
    axes[-1].set_xlabel("wave length / ship length")
    axes[-1].set_xlim(0.0, min(longest, float(np.max(ratio))))
    figure.legend_below([*axes], 3)
    return figure


def over_time(t: Array, panels: Mapping[str, Array]) -> Figure:
    """Panels one below the other, over time.

    t [s].
    """
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
    figure, axes = _one_below_the_other(len(panels), 2.1, 0.9)
    for axis, (label, (omega, measured, std, computed)) in zip(axes, panels.items(), strict=True):
        axis.errorbar(omega, measured, 2 * std, ls="", marker="o", color=INK, label="measured")
        axis.plot(omega, computed, color=colour(0), label="computed")
        axis.set_ylabel(label)
        axis.set_ylim(bottom=0.0)
    axes[-1].set_xlabel("frequency of encounter [rad/s]")
    figure.legend_below([axes[0]], 2)
    return figure


def _one_below_the_other(count: int, each: float, more: float) -> tuple[Figure, Any]:
    """A figure of panels of one abscissa, so high each and so much more [in]."""
    figure = Figure(height=count * each + more)
    return figure, np.atleast_1d(figure.subplots(count, 1, sharex=True))


def polar(heading_deg: Array, curves: Mapping[str, Array], *, limit: float, label: str) -> Figure:
    """Curves around a ship whose bow is up, over where the waves come from; port mirrors
    starboard."""
    order = np.argsort(-heading_deg)
    bearing = np.radians(180.0 - heading_deg[order])
    around = np.concatenate([bearing, 2 * np.pi - bearing[::-1]])
    figure = Figure(height=6.0)
    axis = figure.subplots()
    _rose(axis, 1.05 * float(np.nanmax(np.concatenate([[limit], *curves.values()]))))
    for number, (name, values) in enumerate(curves.items()):
        out = np.concatenate([values[order], values[order][::-1]])
        axis.plot(
            *_placed(out, around), color=colour(number), ls=dash(number), label=figure_text(name)
        )
    axis.plot(*_placed(limit, _AROUND), color=LIMIT, lw=1.0, label="limit")
    axis.set_title(f"waves from …° off the bow; {label}")
    figure.legend_below([axis], 3)
    return figure


def _placed(out: float | Array, bearing: float | Array) -> tuple[Any, Any]:
    """Places so far out at a bearing from the bow, which is up [rad]."""
    return out * np.sin(bearing), out * np.cos(bearing)


def _rose(axis: Axes, end: float) -> None:
    """Circles and spokes out to an `end`, with their numbers."""
    power = math.floor(math.log10(end))
    step = 10.0**power * next(own for own in (0.2, 0.5, 1.0, 2.0) if end < 9 * own * 10.0**power)
    digits = max(-math.floor(math.log10(step)), 0)
    for out in (*np.arange(step, end, step), end):
        hue = "#888888" if out == end else _GRID
        axis.plot(*_placed(out, _AROUND), color=hue, lw=0.8, zorder=1, clip_on=False)
        if out < end:
            axis.text(*_placed(out, np.pi / 8), f"{out:.{digits}f}", **_NUMBER)
    for degrees in range(0, 360, 45):
        aside, ahead = _placed(1.0, np.radians(degrees))
        axis.plot([0.0, end * aside], [0.0, end * ahead], color=_GRID, lw=0.8, zorder=1)
        shift = (15.0 * aside, 10.0 * ahead)
        axis.text(end * aside, end * ahead, f"{degrees}°", xytext=shift, **_NUMBER)
    axis.set_xlim(-end, end)
    axis.set_ylim(-1.1 * end, 1.1 * end)  # with the numbers, below the title
    axis.set_aspect_equal("box")
    axis.set_xticks([])
    axis.set_yticks([])
    axis.without_frame()
