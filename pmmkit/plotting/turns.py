"""Paths and turning circles: what happens on them, marks and dimension lines."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from pmmkit.base import DataError
from pmmkit.conventions import Metric
from pmmkit.numerics import Array, turned
from pmmkit.plotting import style
from pmmkit.plotting.axes import Axes
from pmmkit.plotting.bands import PALE, Band
from pmmkit.plotting.figure import Figure
from pmmkit.presentation import figure_text, number

if TYPE_CHECKING:
    from pmmkit.plotting.bands import TrackLike


# Marks and dimension lines that several drawings of paths share.


Place = tuple[float, float]


def open_mark(axis: Axes, x: float | Array, y: float | Array, label: str, **more: Any) -> None:
    """An open mark, or several of one label.

    Parameters
    ----------
    axis : Axes
        Where.
    x, y : float or array
        The places.
    label : str
        In the legend.
    **more
        Other settings of the line, such as ``marker`` and ``zorder``.
    """
    usual: dict[str, Any] = {"marker": "o", "color": style.colour(0), "zorder": 4}
    axis.plot(x, y, ls="", ms=5, markerfacecolor="white", label=label, **(usual | more))


def dimension(
    axis: Axes,
    start: Place,
    end: Place,
    text: str,
    *,
    upright: bool,
    guides: Sequence[tuple[Place, Place]] = (),
) -> None:
    """A dimension line with its text beside it.

    Parameters
    ----------
    axis : Axes
        Where.
    start, end : (float, float)
        Its ends.
    text : str
        What it measures.
    upright : bool
        Whether it goes up, and the text with it.
    guides : sequence of (place, place)
        Thin dotted lines from what is measured to the dimension line.
    """
    for there, here in guides:
        axis.plot([there[0], here[0]], [there[1], here[1]], color="#bbbbbb", lw=0.8, ls=":")
    axis.arrow(start, end, color=style.REFERENCE, both=True)
    axis.text(
        (start[0] + end[0]) / 2,
        (start[1] + end[1]) / 2,
        text,
        xytext=(-5, 0) if upright else (0, 3),
        rotation=90 if upright else 0,
        ha="right" if upright else "center",
        va="center" if upright else "bottom",
        fontsize=9,
        color=style.REFERENCE,
        box=0.85,
        zorder=6,
    )


def path_axes(axis: Axes) -> None:
    """Axes of a path in ship lengths, ahead upwards, both to one scale."""
    axis.set_aspect_equal()
    axis.set_xlabel("to starboard, y / L [-]")
    axis.set_ylabel("ahead, x / L [-]")


def beyond(
    axis: Axes, value: Array, places: Array, limits: tuple[float, float], colour: str
) -> None:
    """Values beyond the ends of an axis, as arrows there with their number.

    Parameters
    ----------
    axis : Axes
        Where.
    value, places : array (n,)
        Values, and where they stand across the axis; those inside and NaN are left out.
    limits : (float, float)
        Ends of the axis.
    colour : str
        Of arrows and numbers.
    """
    for x, y in zip(value, places, strict=True):
        right = bool(x > limits[1])
        if not right and not x < limits[0]:
            continue
        end = limits[right]
        axis.plot(end, y, marker=">" if right else "<", ms=4, color=colour, clip_on=False, zorder=4)
        axis.text(
            end,
            y,
            number(x, 3),
            xytext=(-6 if right else 6, 0),
            ha="right" if right else "left",
            va="center",
            fontsize=7,
            color=colour,
            box=1.0,
            zorder=5,
        )


_HALF: Final = ((-0.5, 0.36), (-0.47, 0.5), (0.2, 0.5), (0.38, 0.3), (0.5, 0.0))
_SLENDER: Final = 0.145
"""Breadth over length of the outlines; they show the heading, not the ship."""
WATERLINE: Final = np.array([*_HALF, *((x, -y) for x, y in _HALF[-2::-1])]) * (1.0, _SLENDER)
"""Outline of a ship of length 1 as (ahead, to starboard) pairs, bow at +0.5."""
_CLEAR: Final = 0.75
"""Distance of the dimension lines from the path [L]: more than half a ship."""
_EVERY: Final = np.pi / 4
"""Heading between two outlines of the ship [rad]."""


def trajectory(
    tracks: Sequence[TrackLike], names: Sequence[str] | None = None, *, band: Band | None = None
) -> Figure:
    """Paths of turning circles in ship lengths, approach upwards, midship at the origin.

    The origin is where the rudder is ordered. A filled mark stands where the heading has changed
    by 90° (advance and transfer), an open one at 180° (tactical diameter). With one track the
    three measures are drawn as well.

    Parameters
    ----------
    tracks : sequence of TrackLike
        The tracks.
    names : sequence of str, optional
        Their names in the legend; Froude number and rudder angle by default.
    band : Bands, optional
        Where ships with other derivatives lie, as `Bands.of` gives it; with one track the
        intervals of the measures stand beside them.

    Returns
    -------
    Figure
        The figure, with both axes to one scale.

    Raises
    ------
    DataError
        If there is no track.
    """
    labels = _labels(tracks, names)
    figure = Figure(height=6.6, width=7.6)
    axis = figure.subplots()
    if band is not None:
        _about(axis, band, tracks[0].L)
    for i, (name, track) in enumerate(zip(labels, tracks, strict=True)):
        _path(axis, track, i, name)
    _marks_told(axis)
    if len(tracks) == 1:
        _measures(axis, tracks[0], band.measures if band else {})
    path_axes(axis)
    figure.legend_below([axis], columns=3)
    return figure


def turn_histories(tracks: Sequence[TrackLike], names: Sequence[str] | None = None) -> Figure:
    """Speed, yaw rate, drift, heading, rudder and revolutions, over the time in ship lengths."""
    labels = _labels(tracks, names)
    figure = Figure(height=5.4)
    axes = figure.subplots(2, 3, sharex=True).ravel()
    for i, (name, track) in enumerate(zip(labels, tracks, strict=True)):
        level = track.v * np.cos(np.nan_to_num(track.phi))
        speed = np.hypot(track.u, level)
        approach, length = track.speed, track.L
        look = {"color": style.colour(i), "ls": style.dash(i), "label": name}
        time = track.t * approach / length
        axes[0].plot(time, speed / approach, **look)
        axes[1].plot(time, track.r * length / approach, **look)
        axes[2].plot(time, np.degrees(np.arctan2(-level, track.u)), **look)
        axes[3].plot(time, np.degrees(track.psi), **look)
        axes[4].plot(time, np.degrees(track.delta), **look)
        axes[5].plot(time, track.n, **look)
    axes[0].set_title("speed over approach speed U / U₀ [-]")
    axes[0].set_ylim(0, 1.05)
    axes[1].set_title("yaw rate r L / U₀ [-]")
    axes[2].set_title("drift angle β midship [deg]")
    axes[3].set_title("heading ψ [deg]")
    axes[4].set_title("rudder δ [deg]")
    axes[5].set_title("revolutions n [1/s]")
    for axis in axes[3:]:
        style.widened(axis)
        axis.set_xlabel("time t U₀ / L [-]")
    figure.legend_below(list(axes))
    return figure


def _labels(tracks: Sequence[TrackLike], names: Sequence[str] | None) -> list[str]:
    if not tracks:
        raise DataError("There is no track to draw.")
    if names:
        return [figure_text(name) for name in names]
    return [f"Fn {item.Fn:.3f}, rudder {item.rudder_deg:+.3g}°" for item in tracks]


def _path(axis: Axes, track: TrackLike, number: int, name: str) -> None:
    length, colour = track.L, style.colour(number)
    ahead, aside, reached = track.x / length, track.y / length, turned(track.psi)
    axis.plot(aside, ahead, color=colour, ls=style.dash(number), label=name)
    stops = np.arange(0.0, min(reached[-1], 2 * np.pi), _EVERY)
    for index in np.searchsorted(reached, stops):
        outline = np.array([aside[index], ahead[index]]) + oriented(WATERLINE, track.psi[index])
        axis.polygons(outline, color=colour, alpha=0.35, zorder=1.8)
    for angle, face in ((np.pi / 2, colour), (np.pi, "white")):
        if angle <= reached[-1]:
            axis.plot(
                np.interp(angle, reached, aside),
                np.interp(angle, reached, ahead),
                marker=style.marker(number),
                ls="",
                ms=6,
                color=colour,
                markerfacecolor=face,
                zorder=4,
            )


def _about(axis: Axes, band: Band, length: float) -> None:
    """The band of the path, a quadrangle between two headings."""
    inner, outer = band.inner[:, ::-1] / length, band.outer[:, ::-1] / length
    steps = np.stack([inner[:-1], inner[1:], outer[1:], outer[:-1]], axis=1)
    axis.polygons(steps, color=PALE, outline=0.3, zorder=1.5, label=f"95 % of {band.ships} ships")


def _marks_told(axis: Axes) -> None:
    """What the marks stand for, in the legend."""
    for face, text in ((style.REFERENCE, "90° of heading"), ("white", "180°")):
        axis.plot(
            [], [], ls="", marker="o", color=style.REFERENCE, markerfacecolor=face, label=text
        )


def oriented(points: Array, heading: float) -> Array:
    """Points of a ship, (ahead, to starboard) pairs, as (to starboard, ahead) of the approach."""
    ahead, aside = points[:, 0], points[:, 1]
    return np.stack(
        [
            ahead * np.sin(heading) + aside * np.cos(heading),
            ahead * np.cos(heading) - aside * np.sin(heading),
        ],
        axis=1,
    )


def _measures(axis: Axes, track: TrackLike, intervals: Mapping[str, tuple[float, float]]) -> None:
    """Advance, transfer and tactical diameter as dimension lines, clear of the ship's outlines."""
    names = ("advance", "transfer", "tactical_diameter")
    found = {name: track.metrics.get(name + Metric.IN_LENGTHS, np.nan) for name in names}
    if not np.isfinite(list(found.values())).all():
        return
    ahead, reached = track.x / track.L, turned(track.psi)
    side = 1.0 if track.psi[-1] >= track.psi[0] else -1.0
    quarter = (side * found["transfer"], found["advance"])
    half = (side * found["tactical_diameter"], float(np.interp(np.pi, reached, ahead)))
    beyond = -_CLEAR * side
    above = float(ahead.max()) + _CLEAR
    below = min(float(ahead.min()), 0.0) - _CLEAR
    lines: tuple[tuple[str, Place, Place, tuple[Place, Place]], ...] = (
        ("advance", (beyond, 0.0), (beyond, quarter[1]), ((0.0, 0.0), quarter)),
        ("transfer", (0.0, above), (quarter[0], above), ((0.0, ahead[0]), quarter)),
        ("tactical_diameter", (0.0, below), (half[0], below), ((0.0, 0.0), half)),
    )
    for name, start, end, (from_start, from_end) in lines:
        low, high = intervals.get(name + Metric.IN_LENGTHS, (np.nan, np.nan))
        around = f" ({low:.2f} to {high:.2f})" if np.isfinite(low) else ""
        text = f"{Metric.in_words(name)} {found[name]:.2f} L{around}"
        upright = name == "advance"
        guides = [(from_start, start), (from_end, end)]
        dimension(
            axis, start, end, text, upright=upright, guides=guides[::-1] if upright else guides
        )
