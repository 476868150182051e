"""Histories of any manoeuvre: over time, over the water, zigzags and spirals."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import DataError
from pmmkit.conventions import METRICS, Criterion
from pmmkit.numerics import Array
from pmmkit.plotting import style
from pmmkit.plotting.axes import Axes
from pmmkit.plotting.figure import Figure
from pmmkit.plotting.marks import INK
from pmmkit.plotting.turns import open_mark, path_axes, trajectory, turn_histories
from pmmkit.presentation import figure_text

if TYPE_CHECKING:
    from pmmkit.plotting.bands import TrackLike


def zigzag(tracks: Sequence[TrackLike], names: Sequence[str] | None = None) -> Figure:
    """Heading, rudder and yaw rate of zigzags over time."""
    if not tracks:
        raise DataError("There is no track to draw.")
    labels = [figure_text(name) for name in names or [track.name for track in tracks]]
    figure = Figure(height=5.6)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=[2, 1])
    for number, (name, track) in enumerate(zip(labels, tracks, strict=True)):
        colour = style.colour(number)
        above.plot(
            track.t,
            np.degrees(track.psi),
            color=colour,
            marker=style.marker(number) if len(tracks) > 1 else "",
            markevery=max(1, len(track) // 20),
            ms=3.5,
            label=f"{name}, heading",
        )
        above.plot(
            track.t, np.degrees(track.delta), color=colour, ls="--", lw=1.0, label=f"{name}, rudder"
        )
        below.plot(track.t, np.degrees(track.r), color=colour, ls=style.dash(number))
        for instant in track.orders:
            above.axvline(
                instant, color=colour, lw=0.8, ls=":", label=f"{name}, rudder ordered", zorder=1
            )
    if len(tracks) == 1:
        _overshoots(above, tracks[0])
    above.axhline(0.0, color=style.REFERENCE, lw=0.6)
    above.set_title("heading ψ and rudder δ [deg]")
    below.axhline(0.0, color=style.REFERENCE, lw=0.6)
    below.set_title("yaw rate r [deg/s]")
    below.set_xlabel("time from the first execute [s]")
    figure.legend_below([above], columns=3)
    return figure


def _overshoots(axis: Axes, track: TrackLike) -> None:
    """The overshoot angles at the extremes of the heading."""
    switch = float(track.settings.get("switch_deg", 10.0))
    heading = np.degrees(track.psi)
    for i, begin in enumerate(track.orders[1:], start=1):
        value = track.metrics.get(f"overshoot_{i}_deg", np.nan)
        if np.isnan(value):
            continue
        end = track.orders[i + 1] if i + 1 < len(track.orders) else track.t[-1]
        inside = np.flatnonzero((track.t >= begin) & (track.t <= end))
        if not len(inside):
            continue
        top = inside[np.argmax(np.abs(heading[inside]))]
        side = np.sign(heading[top])
        axis.text(
            track.t[top],
            side * (switch + value),
            f"{value:.1f}°",
            xytext=(0, 5 * side),
            ha="center",
            va="bottom" if side > 0 else "top",
            fontsize=9,
            color=style.REFERENCE,
        )
    axis.margins(y=0.12)


def spiral(track: TrackLike) -> Figure:
    """Yaw rate over rudder angle: both ways through a spiral."""
    figure = Figure(height=4.2, width=5.6)
    axis = figure.subplots()
    for number, (way, text) in enumerate((("first", "first way"), ("back", "way back"))):
        (rates_at,) = METRICS.named(f"yaw_rate_deg_s_at_{{}}_{way}")
        points = sorted(
            (float(angle), value)
            for name, value in track.metrics.items()
            if (angle := rates_at.count(name))
        )
        angles, rates = zip(*points, strict=True)
        axis.plot(
            angles,
            rates,
            color=style.colour(number),
            marker=style.marker(number),
            ms=4,
            ls="-" if number == 0 else "--",
            label=text,
        )
    _rate_over_rudder(figure, axis)
    return figure


def _rate_over_rudder(figure: Figure, axis: Axes) -> None:
    """Axes of a spiral: both zeros, names with units, the legend below."""
    axis.axhline(0.0, color=style.REFERENCE, lw=0.6)
    axis.axvline(0.0, color=style.REFERENCE, lw=0.6)
    axis.set_xlabel("rudder δ, positive turns to starboard [deg]")
    axis.set_ylabel("steady yaw rate r [deg/s]")
    figure.legend_below([axis])


def steady_turns(
    rudder_deg: Array, yaw_rate_deg_s: Array, stays: NDArray[np.bool_], loop: tuple[float, float]
) -> Figure:
    """Every steady turn of a ship: yaw rate over the rudder that holds it.

    Parameters
    ----------
    rudder_deg, yaw_rate_deg_s : array (m,)
        Along the curve.
    stays : array (m,) of bool
        Whether the ship stays in that turn by itself.
    loop : (float, float)
        Rudder angles of its folds [deg]; equal where there is none.

    Returns
    -------
    Figure
        Turns that the ship leaves by itself are dashed; the loop of an unstable ship is shaded.
    """
    figure = Figure(height=4.2, width=5.6)
    axis = figure.subplots()
    near = np.abs(rudder_deg) <= Criterion.HARD_OVER
    rudder, rate = rudder_deg[near], yaw_rate_deg_s[near]
    for kind, dash, text in ((True, "-", "stays"), (False, "--", "leaves by itself")):
        kept = np.where(stays[near] == kind, rate, np.nan)
        if np.any(np.isfinite(kept)):
            axis.plot(rudder, kept, color=style.colour(0 if kind else 1), ls=dash, label=text)
    if loop[1] > loop[0]:
        axis.axvspan(
            *loop, color=style.colour(1), alpha=0.15, label=f"loop {loop[1] - loop[0]:.2f}° wide"
        )
    _rate_over_rudder(figure, axis)
    return figure


def path(track: TrackLike) -> Figure:
    """Path over the water in ship lengths with the places of the orders."""
    figure = Figure(height=6.0, width=6.6)
    axis = figure.subplots()
    axis.plot(track.y / track.L, track.x / track.L, color=style.colour(0), label="midship")
    places = [int(np.searchsorted(track.t, t)) for t in track.orders]
    places = [min(place, len(track) - 1) for place in places]
    x, y = track.y[places] / track.L, track.x[places] / track.L
    open_mark(axis, x, y, "orders", zorder=3)
    path_axes(axis)
    figure.legend_below([axis])
    return figure


def histories(track: TrackLike) -> Figure:
    """Velocities, heading, rudder, yaw rate and revolutions over time, and when was ordered
    what."""
    panels: list[tuple[str, list[tuple[str, np.ndarray]]]] = [
        ("velocity [m/s]", [("surge u", track.u), ("sway v", track.v)]),
        ("heading ψ [deg]", [("heading ψ", np.degrees(track.psi))]),
        ("rudder δ [deg]", [("rudder δ", np.degrees(track.delta))]),
        ("yaw rate r [deg/s]", [("yaw rate r", np.degrees(track.r))]),
        ("revolutions n [1/s]", [("revolutions n", track.n)]),
    ]
    if np.any(track.phi):
        panels.append(("heel φ, starboard down [deg]", [("heel φ", np.degrees(track.phi))]))
    figure = Figure(height=1.4 * len(panels) + 0.4)
    axes = figure.subplots(len(panels), 1, sharex=True)
    for axis, (title, lines) in zip(axes, panels, strict=True):
        for number, (name, values) in enumerate(lines):
            several = name if len(lines) > 1 else None
            axis.plot(
                track.t, values, color=style.colour(number), ls=style.dash(number), label=several
            )
        for instant in track.orders if len(track.orders) <= style.FEW else ():
            axis.axvline(instant, color=style.REFERENCE, lw=0.8, ls=":", label="order", zorder=1)
        style.widened(axis)
        axis.set_title(title)
    axes[-1].set_xlabel("time from the first order [s]")
    figure.legend_below(list(axes))
    return figure


def forces_over_time(track: TrackLike, called: Callable[[str], str]) -> Figure:
    """X, Y and N of each effect over time, and their sum."""
    figure = Figure(height=6.4)
    axes = figure.subplots(3, 1, sharex=True)
    every = np.stack(list(track.forces.values()))
    for row, (axis, title) in enumerate(zip(axes, ("X", "Y", "N"), strict=True)):
        most = np.abs(every[:, row]).max()
        size, unit = (1e6, "MN") if most >= 1e7 else (1e3, "kN") if most >= 1e4 else (1.0, "N")
        axis.plot(track.t, every[:, row].sum(axis=0) / size, color=INK, lw=0.8, label="sum")
        for number, (name, own) in enumerate(track.forces.items(), 1):
            axis.plot(
                track.t,
                own[row] / size,
                color=style.colour(number),
                ls=style.dash(number),
                label=figure_text(called(name)),
            )
        style.widened(axis)
        axis.set_title(f"{title} [{unit}{' m' if title == 'N' else ''}]")
    axes[-1].set_xlabel("time from the first order [s]")
    figure.legend_below(list(axes))
    return figure


# Which figures show a manoeuvre, by the way in which it is drawn.


Drawn = Literal["turning circle", "zigzag", "spiral", "path"]


def manoeuvre(
    tracks: Sequence[TrackLike],
    drawn: Drawn,
    names: Sequence[str] | None = None,
    called: Callable[[str], str] = str,
) -> dict[str, Figure]:
    """The figures that show a manoeuvre, by the name of their file.

    Parameters
    ----------
    tracks : sequence of TrackLike
        Of the manoeuvre; turning circles and zigzags are drawn together, else there is one. Of a
        single one that keeps its forces they are drawn too.
    drawn : {"turning circle", "zigzag", "spiral", "path"}
        How it is drawn.
    names : sequence of str, optional
        Of several tracks in the legend.
    called : callable, optional
        From the name of an effect to what the legend calls it.
    """
    alone = len(tracks) == 1 and tracks[0].forces
    pushed = {"forces": forces_over_time(tracks[0], called)} if alone else {}
    if drawn == "turning circle":
        turned = trajectory(tracks, names), turn_histories(tracks, names)
        return {"trajectory": turned[0], "histories": turned[1], **pushed}
    if drawn == "zigzag":
        return {"zigzag": zigzag(tracks, names), **pushed}
    (track,) = tracks
    shown = {"spiral": spiral(track)} if drawn == "spiral" else {"path": path(track)}
    return {**shown, "histories": histories(track), **pushed}
