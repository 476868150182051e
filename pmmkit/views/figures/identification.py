"""Identification: parameters over time, innovations, and a predicted window."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.base import UnknownNameError
from pmmkit.conventions import Convention
from pmmkit.effects import CATALOGUE
from pmmkit.plotting import INK, LIMIT, REFERENCE, Axes, Figure, open_mark
from pmmkit.plotting import colour as colour_style
from pmmkit.presentation import WIDE, figure_text

if TYPE_CHECKING:
    from pmmkit.identification import Filtered, FreeRecord, PredictedWindow
    from pmmkit.inference import Innovations

_COLUMNS: Final = 3
_LAGS: Final = 40
_FARTHEST: Final = 1.5
"""Half height of the axes of a predicted window, over what was measured."""
_AXES: Final = {
    "x": "x",
    "y": "y",
    "psi": "heading ψ",
    "u": "surge u",
    "v": "sway v",
    "r": "yaw rate r",
    "p": "roll rate p",
    "phi": "heel φ",
    "xdot": "dx/dt",
    "ydot": "dy/dt",
    "sog": "speed over ground",
}


def filter_figures(
    found: Filtered, records: Sequence[FreeRecord], convention: Convention | None = None
) -> dict[str, Figure]:
    """What a Kalman filter learned and what it left: ``history`` and ``innovations``.

    Parameters
    ----------
    found : Filtered
        Its result.
    records : sequence of FreeRecord
        Those it was made from, in their order.
    convention : Convention, optional
        Of the derivatives, for their symbols.
    """
    return {
        "history": parameter_histories(found, records, convention),
        "innovations": innovation_figure(found, records),
    }


def parameter_histories(
    found: Filtered,
    records: Sequence[FreeRecord],
    convention: Convention | None = None,
    names: Sequence[str] | None = None,
) -> Figure:
    """Parameters as a filter learns them, with their 95 % band, beside the prior.

    A small panel a parameter, all of them by default; records are drawn one after another, with
    dotted lines where a new one begins.
    """
    shown = list(names or found.names)
    lost = [name for name in shown if name not in found.names]
    if lost:
        raise UnknownNameError(
            f"{', '.join(lost)} was not identified; there are {', '.join(found.names)}."
        )
    t, starts = _one_after_another(records)
    first = next(iter(found.histories.values())).shape[1] - len(found.names)
    histories = np.concatenate([found.histories[item.name] for item in records])[:, first:]
    spreads = np.concatenate([found.spreads[item.name] for item in records])[:, first:]
    rows = math.ceil(len(shown) / _COLUMNS)
    figure = Figure(height=1.6 * rows + 0.7)
    grid = figure.subplots(rows, min(_COLUMNS, len(shown)), squeeze=False, sharex=True)
    axes = grid.ravel()
    for axis, name in zip(axes, shown, strict=False):
        i = found.names.index(name)
        half = WIDE * np.sqrt(np.maximum(spreads[:, i], 0.0))
        mean, wide = found.prior.mean[i], WIDE * found.prior.std[i]
        axis.axhspan(mean - wide, mean + wide, color="#ececec", zorder=0, label="prior, 95 %")
        axis.axhline(mean, color=REFERENCE, lw=1.0, ls="--", zorder=1, label="prior mean")
        axis.fill_between(
            t,
            histories[:, i] - half,
            histories[:, i] + half,
            color=colour_style(0),
            alpha=0.25,
            label="95 % band",
        )
        axis.plot(t, histories[:, i], color=colour_style(0), label=f"{found.method}")
        for start in starts[1:]:
            axis.axvline(start, color="#999999", lw=0.8, ls=":")
        axis.set_title(f"{(convention or Convention()).symbol(name)} [{_unit(name)}]")
        axis.set_xlim(t[0], t[-1])
        axis.ticks_at_most(4, side="y")
    for axis in axes[len(shown) :]:
        axis.remove()
    for column in range(grid.shape[1]):
        lowest = axes[range(column, len(shown), grid.shape[1])[-1]]
        lowest.label_below("time, records joined [s]" if len(records) > 1 else "time [s]")
    figure.legend_below(list(axes[: len(shown)]))
    return figure


def innovation_figure(
    found: Filtered, records: Sequence[FreeRecord], name: str | None = None
) -> Figure:
    """Innovations of one record, normalised, over time, and their autocorrelation.

    A row per channel, of the longest record by default. If the filter is right, 95 of 100 points
    lie between the lines at ±2, and the autocorrelation between those at ±2 over the root of the
    number of samples.
    """
    by_name = {item.name: item for item in records}
    chosen = name or max(by_name, key=lambda key: len(by_name[key]))
    if chosen not in found.innovations or chosen not in by_name:
        raise UnknownNameError(
            f"There is no record {chosen!r}; there are {', '.join(found.innovations)}."
        )
    item, t = found.innovations[chosen], by_name[chosen].t
    figure = Figure(height=1.35 * len(item.names) + 0.9)
    axes = figure.subplots(len(item.names), 2, squeeze=False, sharex="col", width_ratios=(2.2, 1.0))
    for (left, right), channel, values, gated in zip(
        axes, item.names, item.normalised.T, item.gated.T, strict=True
    ):
        _normalised(left, t, values, gated)
        left.set_title(_AXES.get(channel, channel))
        _correlogram(right, item, channel)
    axes[0, 0].set_title(
        f"{figure_text(chosen)}, {found.method}: {_AXES.get(item.names[0], item.names[0])}"
    )
    axes[0, 1].set_title("autocorrelation [-]")
    figure.supylabel("innovation / its standard deviation [-]")
    axes[-1, 0].set_xlabel("time [s]")
    axes[-1, 1].set_xlabel("lag [samples]")
    figure.legend_below(list(axes.ravel()))
    return figure


def _normalised(axis: Axes, t: np.ndarray, values: np.ndarray, gated: np.ndarray) -> None:
    axis.plot(t, values, ls="", marker=".", ms=2.5, color=colour_style(0), label="innovations")
    for side in (-2.0, 2.0):
        axis.axhline(side, color=LIMIT, lw=1.0, ls="--", label="±2")
    top = max(3.2, float(np.nanmax(np.abs(values), initial=0.0)) * 1.08)
    if gated.any():
        axis.plot(
            t[gated],
            np.full(int(gated.sum()), 0.95 * top),
            ls="",
            marker="v",
            ms=4,
            color=LIMIT,
            label="not taken in",
        )
    axis.set_ylim(-top, top)
    axis.ticks_at_most(5, side="y")


def _correlogram(axis: Axes, item: Innovations, channel: str) -> None:
    count = int(np.isfinite(item.normalised[:, item.names.index(channel)]).sum())
    if count < 4:
        return
    correlation, pairs = item.autocorrelation(channel, min(_LAGS, count // 2))
    lags = np.arange(1, len(correlation) + 1)
    axis.vlines(lags[pairs > 0], 0.0, correlation[pairs > 0], color=colour_style(0), lw=1.4)
    axis.axhline(0.0, color=REFERENCE, lw=0.8)
    for side in (-2.0, 2.0):
        axis.axhline(side / math.sqrt(count), color=LIMIT, lw=1.0, ls="--")
    reach = max(0.3, float(np.max(np.abs(correlation))) * 1.15)
    axis.set_ylim(-min(reach, 1.05), min(reach, 1.05))
    axis.ticks_at_most(4, side="y")


def window_figure(found: PredictedWindow) -> Figure:
    """Path and heading of a window of a record, measured and predicted with the measured rudder.

    Parameters
    ----------
    found : PredictedWindow
        From `PredictedWindow.of`.

    Returns
    -------
    Figure
        The path with equal axes; heading and rudder over time.
    """
    t = found.t - found.t[0]
    figure = Figure(height=4.4)
    left, right = figure.subplots(1, 2, width_ratios=(1.0, 1.3))
    left.plot(
        found.measured["y"] / found.L,
        found.measured["x"] / found.L,
        lw=3.5,
        color="#bdbdbd",
        label="measured",
    )
    right.plot(t, np.degrees(found.measured["psi"]), lw=3.5, color="#bdbdbd", label="measured")
    for number, (name, motion) in enumerate(found.predicted.items()):
        colour, dash = (colour_style(number - 1), "-") if number else (REFERENCE, "--")
        left.plot(
            motion["y"] / found.L, motion["x"] / found.L, label=name, lw=1.4, color=colour, ls=dash
        )
        right.plot(t, np.degrees(motion["psi"]), label=name, lw=1.4, color=colour, ls=dash)
    right.plot(t, np.degrees(found.delta), color="#9a9a9a", lw=1.0, ls=":", label="rudder δ")
    x, y = found.measured["y"][0] / found.L, found.measured["x"][0] / found.L
    open_mark(left, x, y, "start", color=INK)
    _kept_in_view(left, right, found)
    left.set_aspect_equal()
    left.set_xlabel("to east, y / L [-]")
    left.set_ylabel("to north, x / L [-]")
    right.set_xlabel("time in the window [s]")
    right.set_ylabel("heading ψ and rudder δ, to starboard [deg]")
    left.set_title(f"{figure_text(found.name)}, from t = {found.t[0]:.0f} s")
    figure.legend_below([left, right], columns=6)
    return figure


def _kept_in_view(path: Axes, angle: Axes, found: PredictedWindow) -> None:
    """Axes about what was measured: a prediction that runs away leaves them, as the title says."""
    reach = _FARTHEST * max(
        1.0, *(float(np.ptp(found.measured[name])) / found.L for name in ("x", "y"))
    )
    middle = [float(np.mean(found.measured[name])) / found.L for name in ("y", "x")]
    heading = np.degrees(found.measured["psi"])
    span = _FARTHEST * max(float(np.ptp(heading)), 30.0)
    away = [
        name
        for name, motion in found.predicted.items()
        if not np.all(np.abs(motion["y"] / found.L - middle[0]) < reach)
        or not np.all(np.abs(motion["x"] / found.L - middle[1]) < reach)
        or not np.all(np.abs(np.degrees(motion["psi"]) - heading.mean()) < span)
    ]
    if away:
        path.set_xlim(middle[0] - reach, middle[0] + reach)
        path.set_ylim(middle[1] - reach, middle[1] + reach)
        angle.set_ylim(heading.mean() - span, heading.mean() + span)
        angle.set_title(f"runs away: {', '.join(away)}")


def _one_after_another(records: Sequence[FreeRecord]) -> tuple[np.ndarray, list[float]]:
    """Instants of joined records [s], and where each begins."""
    parts, starts, end = [], [], 0.0
    for item in records:
        starts.append(end)
        parts.append(item.t - item.t[0] + end)
        end = float(parts[-1][-1])
    return np.concatenate(parts), starts


def _unit(name: str) -> str:
    """Unit of a parameter: derivatives are non-dimensional."""
    effect, _, own = name.partition(".")
    known = CATALOGUE.get(effect)
    parameter = known.parameter(own) if known else None
    if parameter is not None:
        return parameter.unit
    return "m/s" if name.startswith("current_") else "-"
