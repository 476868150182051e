"""Turning circles: the paths, and what happens on them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.errors import DataError
from pmmkit.escaping import figure_text
from pmmkit.numerics import Array
from pmmkit.plotting import style
from pmmkit.plotting.marks import dimension, guide, path_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pmmkit.plotting.history import History

_DASHES: Final = ("-", "--", "-.", ":")
_HALF: Final = ((-0.5, 0.36), (-0.47, 0.5), (0.2, 0.5), (0.38, 0.3), (0.5, 0.0))
_OUTLINE: Final = np.array([*_HALF, *((x, -y) for x, y in _HALF[-2::-1])])
"""Waterline in lengths and breadths, bow at +0.5."""
_SLENDER: Final = 0.145
"""Breadth over length of the outlines; they show the heading, not the ship."""
_EVERY: Final = np.pi / 4
"""Heading between two outlines of the ship [rad]."""


def trajectory(tracks: Sequence[History], names: Sequence[str] | None = None) -> Figure:
    """Paths of turning circles in ship lengths, approach upwards, midship at the origin.

    The origin is where the rudder is ordered. A filled mark stands where the heading has changed
    by 90° (advance and transfer), an open one at 180° (tactical diameter). With one track the
    three measures are drawn as well.

    Parameters
    ----------
    tracks : sequence of History
        The tracks.
    names : sequence of str, optional
        Their names in the legend; Froude number and rudder angle by default.

    Returns
    -------
    Figure
        A matplotlib figure with equal axes.

    Raises
    ------
    DataError
        If there is no track.
    """
    labels = _labels(tracks, names)
    with style.styled():
        figure = style.canvas(6.6, 7.6)
        axis = figure.subplots()
        for number, (name, track) in enumerate(zip(labels, tracks, strict=True)):
            _path(axis, track, number, name)
        if len(tracks) == 1:
            _measures(axis, tracks[0])
        path_axes(axis)
        style.legend_below(figure, [axis], columns=3)
    return figure


def turn_histories(tracks: Sequence[History], names: Sequence[str] | None = None) -> Figure:
    """Speed, yaw rate and drift angle in the turn, over the time in ship lengths.

    Parameters
    ----------
    tracks : sequence of History
        The tracks.
    names : sequence of str, optional
        Their names in the legend; Froude number and rudder angle by default.

    Returns
    -------
    Figure
        A matplotlib figure, a panel a quantity.

    Raises
    ------
    DataError
        If there is no track.
    """
    labels = _labels(tracks, names)
    with style.styled():
        figure = style.canvas(3.6)
        axes = figure.subplots(1, 3)
        for number, (name, track) in enumerate(zip(labels, tracks, strict=True)):
            speed = np.hypot(track.u, track.v)
            approach, length = track.speed, track.L
            look = {"color": style.colour(number), "ls": _DASHES[number % 4], "label": name}
            time = track.t * approach / length
            axes[0].plot(time, speed / approach, **look)
            axes[1].plot(time, track.r * length / approach, **look)
            axes[2].plot(time, np.degrees(np.arctan2(-track.v, track.u)), **look)
        axes[0].set_title("speed over approach speed U / U₀ [-]")
        axes[0].set_ylim(0, 1.05)
        axes[1].set_title("yaw rate r L / U₀ [-]")
        axes[2].set_title("drift angle β midship [deg]")
        for axis in axes:
            axis.set_xlabel("time t U₀ / L [-]")
        style.legend_below(figure, list(axes))
    return figure


def _labels(tracks: Sequence[History], names: Sequence[str] | None) -> list[str]:
    if not tracks:
        raise DataError("There is no track to draw.")
    if names:
        return [figure_text(name) for name in names]
    return [f"Fn {item.Fn:.3f}, rudder {item.rudder_deg:+.3g}°" for item in tracks]


def _path(axis: Axes, track: History, number: int, name: str) -> None:
    length, colour = track.L, style.colour(number)
    ahead, aside, turned = track.x / length, track.y / length, _turned(track)
    axis.plot(aside, ahead, color=colour, ls=_DASHES[number % 4], label=name)
    stops = np.arange(0.0, min(turned[-1], 2 * np.pi), _EVERY)
    for index in np.searchsorted(turned, stops):
        outline = np.array([aside[index], ahead[index]]) + _outline(track.psi[index])
        axis.fill(*outline.T, facecolor=colour, edgecolor="none", alpha=0.35)
    for angle, face in ((np.pi / 2, colour), (np.pi, "white")):
        index = int(np.searchsorted(turned, angle))
        if index < len(turned):
            axis.plot(
                aside[index],
                ahead[index],
                marker=style.marker(number),
                ls="",
                ms=6,
                markeredgecolor=colour,
                markerfacecolor=face,
                zorder=4,
            )


def _turned(track: History) -> Array:
    """Change of heading in the sense of the turn, never going back [rad]."""
    change = np.unwrap(track.psi) - track.psi[0]
    return np.maximum.accumulate(change * (1.0 if change[-1] >= 0 else -1.0))


def _outline(heading: float) -> Array:
    """Outline of a ship of length 1 as (to starboard, ahead) pairs at a heading."""
    ahead, aside = _OUTLINE[:, 0], _OUTLINE[:, 1] * _SLENDER
    return np.stack(
        [
            ahead * np.sin(heading) + aside * np.cos(heading),
            ahead * np.cos(heading) - aside * np.sin(heading),
        ],
        axis=1,
    )


def _measures(axis: Axes, track: History) -> None:
    """Advance, transfer and tactical diameter as dimension lines."""
    length, turned = track.L, _turned(track)
    quarter, half = np.searchsorted(turned, [np.pi / 2, np.pi])
    if half >= len(turned):
        return
    aside, ahead = track.y / length, track.x / length
    outer = aside[half] * 1.14
    lines = (
        ("advance", (outer, 0.0), (outer, ahead[quarter]), abs(ahead[quarter])),
        ("transfer", (0.0, ahead[quarter]), (aside[quarter], ahead[quarter]), abs(aside[quarter])),
        ("tactical diameter", (0.0, ahead[half]), (aside[half], ahead[half]), abs(aside[half])),
    )
    guide(axis, (aside[quarter], ahead[quarter]), (outer, ahead[quarter]))
    for name, start, end, value in lines:
        text = f"{name} {value:.2f} L"
        dimension(axis, start, end, text, upright=name == "advance")
