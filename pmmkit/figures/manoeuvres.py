"""Manoeuvres other than the turning circle: zigzag, spiral, stopping and any path."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.errors import DataError
from pmmkit.figures.turns import trajectory, turn_histories
from pmmkit.metrics import HARD_OVER, limits_in_lengths, unit_of
from pmmkit.plotting import style

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pmmkit.simulation.ensemble import Ensemble
    from pmmkit.simulation.sensitivity import Sensitivities
    from pmmkit.simulation.spiral import SpiralCurve
    from pmmkit.simulation.track import Track

_LIMITS: Final = limits_in_lengths()


def manoeuvre(track: Track) -> Mapping[str, Figure]:
    """The figures that show a manoeuvre, by the name of their file.

    Parameters
    ----------
    track : Track
        Of any manoeuvre.

    Returns
    -------
    mapping of str to Figure
        A turning circle gives ``trajectory`` and ``histories``, a zigzag ``zigzag`` and so on.
    """
    if track.manoeuvre == "turning":
        return {"trajectory": trajectory([track]), "histories": turn_histories([track])}
    if track.manoeuvre == "zigzag":
        return {"zigzag": zigzag([track])}
    if track.manoeuvre == "spiral":
        return {"spiral": spiral(track), "histories": histories(track)}
    return {"path": path(track), "histories": histories(track)}


def zigzag(tracks: Sequence[Track], names: Sequence[str] | None = None) -> Figure:
    """Heading, rudder and yaw rate of zigzags over time.

    Parameters
    ----------
    tracks : sequence of Track
        Simulated or measured.
    names : sequence of str, optional
        Their names in the legend; the names of the models by default.

    Returns
    -------
    Figure
        Heading above (rudder dashed), yaw rate below.

    Raises
    ------
    DataError
        If there is no track.
    """
    if not tracks:
        raise DataError("There is no track to draw.")
    labels = list(names or [track.name for track in tracks])
    with style.styled():
        figure = style.canvas(5.6)
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=[2, 1])
        for number, (name, track) in enumerate(zip(labels, tracks, strict=True)):
            colour = style.colour(number)
            above.plot(track.t, np.degrees(track.psi), color=colour, label=f"{name}, heading")
            above.plot(
                track.t,
                np.degrees(track.delta),
                color=colour,
                ls="--",
                lw=1.0,
                label=f"{name}, rudder",
            )
            below.plot(track.t, np.degrees(track.r), color=colour, label=f"{name}, heading")
        if len(tracks) == 1:
            _overshoots(above, tracks[0])
        above.axhline(0.0, color=style.REFERENCE, lw=0.6)
        above.set_title("heading ψ and rudder δ [deg]")
        below.axhline(0.0, color=style.REFERENCE, lw=0.6)
        below.set_title("yaw rate r [deg/s]")
        below.set_xlabel("time from the first execute [s]")
        style.legend_below(figure, [above])
    return figure


def _overshoots(axis: Axes, track: Track) -> None:
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
        axis.annotate(
            f"{value:.1f}°",
            (track.t[top], side * (switch + value)),
            xytext=(0, 5 * side),
            textcoords="offset points",
            ha="center",
            va="bottom" if side > 0 else "top",
            fontsize=9,
            color=style.REFERENCE,
        )
    axis.margins(y=0.12)


def spiral(track: Track) -> Figure:
    """Yaw rate over rudder angle: both ways through a spiral.

    Parameters
    ----------
    track : Track
        Of a spiral.

    Returns
    -------
    Figure
        An unstable ship shows a loop.
    """
    with style.styled():
        figure = style.canvas(4.2, 5.6)
        axis = figure.subplots()
        for number, (way, text) in enumerate((("first", "first way"), ("back", "way back"))):
            ending = f"_{way}"
            points = sorted(
                (float(name.removeprefix("yaw_rate_deg_s_at_").removesuffix(ending)), value)
                for name, value in track.metrics.items()
                if name.startswith("yaw_rate_deg_s_at_") and name.endswith(ending)
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
    style.legend_below(figure, [axis])


def steady_turns(curve: SpiralCurve) -> Figure:
    """Every steady turn of a ship: yaw rate over the rudder that holds it.

    Parameters
    ----------
    curve : SpiralCurve
        From `spiral_curve`.

    Returns
    -------
    Figure
        Turns that the ship leaves by itself are dashed; the loop of an unstable ship is shaded.
    """
    with style.styled():
        figure = style.canvas(4.2, 5.6)
        axis = figure.subplots()
        near = np.abs(curve.rudder_deg) <= HARD_OVER
        rudder, rate = curve.rudder_deg[near], curve.yaw_rate_deg_s[near]
        for stays, dash, text in ((True, "-", "stays"), (False, "--", "leaves by itself")):
            kept = np.where(curve.stable[near] == stays, rate, np.nan)
            if np.any(np.isfinite(kept)):
                axis.plot(rudder, kept, color=style.colour(0 if stays else 1), ls=dash, label=text)
        if curve.loop_width_deg > 0:
            half = curve.loop_width_deg / 2
            axis.axvspan(
                curve.neutral_deg - half,
                curve.neutral_deg + half,
                color=style.colour(1),
                alpha=0.15,
                lw=0,
                label=f"loop {curve.loop_width_deg:.2f}° wide",
            )
        _rate_over_rudder(figure, axis)
    return figure


def metrics_over(sweep: xr.Dataset, metrics: Sequence[str]) -> Figure:
    """Metrics over whatever a sweep varies, with their intervals where it has them.

    Parameters
    ----------
    sweep : Dataset
        From `sweep` or `froude_sweep`.
    metrics : sequence of str
        Names of metrics.

    Returns
    -------
    Figure
        A panel a metric.
    """
    over = str(next(iter(sweep.dims)))
    values, unit = sweep[over].values, sweep[over].attrs.get("units", "-")
    with style.styled():
        figure = style.canvas(3.2)
        axes = np.atleast_1d(figure.subplots(1, len(metrics)))
        for axis, metric in zip(axes, metrics, strict=True):
            axis.plot(
                values,
                sweep[metric].values,
                color=style.colour(0),
                marker="o",
                ms=4,
                label="as it is",
            )
            if f"{metric}_low" in sweep:
                axis.fill_between(
                    values,
                    sweep[f"{metric}_low"].values,
                    sweep[f"{metric}_high"].values,
                    color=style.colour(0),
                    alpha=0.2,
                    lw=0,
                    label="95 % of the ships",
                )
            if metric in _LIMITS:
                axis.axhline(_LIMITS[metric], color=style.LIMIT, lw=1.2, label="IMO limit")
            axis.set_title(_titled(metric, sweep[metric].attrs.get("units", "-")))
            axis.set_xlabel(
                "Froude number [-]"
                if over == "Fn"
                else f"{over.removesuffix('_deg')} [{unit}]".replace("_", " ")
            )
        style.legend_below(figure, list(axes))
    return figure


def _titled(metric: str, unit: str) -> str:
    """A metric and its unit for people."""
    name = metric.removesuffix("_L").removesuffix("_deg").replace("_deg_s", "").replace("_", " ")
    return f"{name} / L [-]" if metric.endswith("_L") else f"{name} [{unit}]"


def path(track: Track) -> Figure:
    """Path over the water in ship lengths with the places of the orders.

    Parameters
    ----------
    track : Track
        Of any manoeuvre.

    Returns
    -------
    Figure
        With equal axes.
    """
    with style.styled():
        figure = style.canvas(6.0, 6.6)
        axis = figure.subplots()
        axis.plot(track.y / track.L, track.x / track.L, color=style.colour(0), label="midship")
        places = [int(np.searchsorted(track.t, t)) for t in track.orders]
        places = [min(place, len(track) - 1) for place in places]
        axis.plot(
            track.y[places] / track.L,
            track.x[places] / track.L,
            ls="",
            marker="o",
            ms=5,
            color=style.colour(0),
            markerfacecolor="white",
            label="orders",
            zorder=3,
        )
        axis.set_aspect("equal", adjustable="datalim")
        axis.set_xlabel("to starboard, y / L [-]")
        axis.set_ylabel("ahead, x / L [-]")
        style.legend_below(figure, [axis])
    return figure


def histories(track: Track) -> Figure:
    """Speed, heading and rudder, yaw rate, and revolutions over time.

    Parameters
    ----------
    track : Track
        Of any manoeuvre.

    Returns
    -------
    Figure
        A panel a quantity; heel too where the ship rolls.
    """
    panels: list[tuple[str, list[tuple[str, np.ndarray]]]] = [
        ("velocity [m/s]", [("surge u", track.u), ("sway v", track.v)]),
        (
            "angle [deg]",
            [("heading ψ", np.degrees(track.psi)), ("rudder δ", np.degrees(track.delta))],
        ),
        ("yaw rate r [deg/s]", [("yaw rate r", np.degrees(track.r))]),
        ("revolutions n [1/s]", [("revolutions n", track.n)]),
    ]
    if np.any(track.phi):
        panels.append(("heel φ, starboard down [deg]", [("heel φ", np.degrees(track.phi))]))
    with style.styled():
        figure = style.canvas(1.7 * len(panels))
        axes = figure.subplots(len(panels), 1, sharex=True)
        for axis, (title, lines) in zip(axes, panels, strict=True):
            for number, (name, values) in enumerate(lines):
                axis.plot(track.t, values, color=style.colour(number), label=name)
            axis.set_title(title)
            if len(lines) > 1:
                axis.legend(loc="best", fontsize=8)
        axes[-1].set_xlabel("time from the first order [s]")
    return figure


def distributions(ensemble: Ensemble, metrics: Sequence[str]) -> Figure:
    """How the metrics of many ships are distributed, with the nominal ship and near IMO limits.

    Parameters
    ----------
    ensemble : Ensemble
        From `monte_carlo`.
    metrics : sequence of str
        Names of metrics.

    Returns
    -------
    Figure
        A panel a metric, the central 95 % shaded.
    """
    with style.styled():
        figure = style.canvas(3.0)
        axes = np.atleast_1d(figure.subplots(1, len(metrics)))
        for axis, metric in zip(axes, metrics, strict=True):
            values = ensemble.metrics[metric]
            values = values[np.isfinite(values)]
            low, high = ensemble.interval(metric)
            axis.hist(values, bins=60, color=style.colour(0), alpha=0.6, label="ships")
            axis.axvspan(low, high, color=style.colour(0), alpha=0.15, lw=0, label="central 95 %")
            axis.axvline(ensemble.nominal[metric], color=style.REFERENCE, lw=1.4, label="as it is")
            left, right = axis.get_xlim()
            if metric in _LIMITS and abs(_LIMITS[metric] - (left + right) / 2) < right - left:
                axis.axvline(_LIMITS[metric], color=style.LIMIT, lw=1.2, label="IMO limit")
            axis.set_title(_titled(metric, unit_of(metric)))
            axis.set_yticks([])
        axes[0].set_ylabel("number of ships")
        style.legend_below(figure, list(axes))
    return figure


def importance(found: Sensitivities, metric: str, most: int = 12) -> Figure:
    """Which derivatives decide a metric.

    Parameters
    ----------
    found : Sensitivities
        From `sensitivities`.
    metric : str
        Name of a metric.
    most : int
        Number of derivatives shown.

    Returns
    -------
    Figure
        Bars of the share of variance, or of per cent per per cent without a covariance.
    """
    table = found.table(metric).head(most)[::-1]
    shared = "share_of_variance" in table
    column = "share_of_variance" if shared else "per_cent_per_per_cent"
    factor = 100.0 if shared else 1.0
    with style.styled():
        figure = style.canvas(0.6 + 0.28 * len(table), 5.6)
        axis = figure.subplots()
        axis.barh(range(len(table)), factor * table[column], color=style.colour(0))
        axis.set_yticks(range(len(table)), list(table.index))
        axis.axvline(0.0, color=style.REFERENCE, lw=0.6)
        words = metric.removesuffix("_L").replace("_", " ")
        axis.set_xlabel(
            f"share of the variance of the {words} [%]"
            if shared
            else f"change of the {words} per 1 % of the derivative [%]"
        )
    return figure
