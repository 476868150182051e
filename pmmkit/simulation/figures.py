"""Metrics of manoeuvres: over a sweep, over the Froude number, of many ships, and their causes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.conventions import METRICS, Metric
from pmmkit.numerics import Array
from pmmkit.plotting import LIMIT, REFERENCE, Figure, colour, marker, widened
from pmmkit.presentation import figure_text

if TYPE_CHECKING:
    import xarray as xr

_LIMITS: Final = {
    metric.judged(item): item.limit
    for metric, item in METRICS.criteria
    if metric.length and not callable(item.limit)
}
MOST: Final = 12
"""Values of which it is drawn how much they decide."""
_SEEN: Final = 0.02
"""Share of a metric below which no trial could tell a change."""


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
    figure = Figure(height=3.2)
    axes = np.atleast_1d(figure.subplots(1, len(metrics)))
    for axis, metric in zip(axes, metrics, strict=True):
        axis.plot(values, sweep[metric].values, color=colour(0), marker="o", ms=4, label="as it is")
        if f"{metric}_low" in sweep:
            axis.fill_between(
                values,
                sweep[f"{metric}_low"].values,
                sweep[f"{metric}_high"].values,
                color=colour(0),
                alpha=0.2,
                label="95 % of the ships",
            )
        if metric in _LIMITS:
            axis.axhline(_LIMITS[metric], color=LIMIT, lw=1.2, label="IMO limit")
        widened(axis, share=_SEEN)
        axis.set_title(_titled(metric, sweep[metric].attrs.get("units", "-")))
        axis.set_xlabel(
            "Froude number [-]"
            if over == "Fn"
            else f"{over.removesuffix('_deg')} [{unit}]".replace("_", " ")
        )
    figure.legend_below(list(axes))
    return figure


def measures_over_froude(sweeps: Mapping[str, xr.Dataset]) -> Figure:
    """Measures of the turning circle over the Froude number, with the IMO limits.

    Parameters
    ----------
    sweeps : mapping of str to Dataset
        Sweeps as `froude_sweep` gives them, by their name in the legend; the first is ours, the
        others are drawn to compare with.

    Returns
    -------
    Figure
        A panel a measure.
    """
    figure = Figure(height=3.2)
    lengths = [x for x in map(str, next(iter(sweeps.values()))) if x.endswith(Metric.IN_LENGTHS)]
    axes = figure.subplots(1, len(lengths))
    for axis, measure in zip(axes, lengths, strict=True):
        for number, (name, sweep) in enumerate(sweeps.items()):
            axis.plot(
                sweep["Fn"].values,
                sweep[measure].values,
                ms=4,
                label=figure_text(name),
                color=colour(0) if number == 0 else REFERENCE,
                marker=marker(number),
                ls="-" if number == 0 else "--",
            )
        if measure in _LIMITS:
            axis.axhline(_LIMITS[measure], color=LIMIT, lw=1.2, label="IMO limit")
        axis.set_ylim(0, 1.08 * axis.limits("y")[1])
        axis.set_title(f"{Metric.of(measure).title} / L [-]")
        axis.set_xlabel("Froude number [-]")
    figure.legend_below(list(axes))
    return figure


def distributions(
    ships: Mapping[str, Array],
    nominal: Mapping[str, float],
    intervals: Mapping[str, tuple[float, float]],
    units: Mapping[str, str],
) -> Figure:
    """How the metrics of many ships are distributed, with the nominal ship and near IMO limits."""
    figure = Figure(height=3.0)
    axes = np.atleast_1d(figure.subplots(1, len(ships), sharey=True))
    for axis, (metric, values) in zip(axes, ships.items(), strict=True):
        low, high = intervals[metric]
        own = values[np.isfinite(values)]
        axis.hist(own, bins="auto", color=colour(0), alpha=0.6, label="ships")
        axis.axvspan(low, high, color=colour(0), alpha=0.15, label="central 95 %")
        axis.axvline(nominal[metric], color=REFERENCE, lw=1.4, label="as it is")
        left, right = axis.limits("x")
        if metric in _LIMITS and abs(_LIMITS[metric] - (left + right) / 2) < right - left:
            axis.axvline(_LIMITS[metric], color=LIMIT, lw=1.2, label="IMO limit")
        axis.set_title(_titled(metric, units.get(metric, "-")))
    axes[0].ticks_at_most(side="y", whole=True)
    axes[0].set_ylabel("number of ships")
    figure.legend_below(list(axes))
    return figure


def importance(names: Sequence[str], values: Array, metric: str, *, shares: bool) -> Figure:
    """Which values decide a metric."""
    shown = list(names[:MOST])[::-1]
    lengths = (100.0 if shares else 1.0) * values[:MOST][::-1]
    figure = Figure(height=0.6 + 0.28 * len(shown), width=5.6)
    axis = figure.subplots()
    axis.barh(range(len(shown)), lengths, color=colour(0))
    axis.set_yticks(range(len(shown)), shown)
    axis.axvline(0.0, color=REFERENCE, lw=0.6)
    words = metric.removesuffix("_L").replace("_", " ")
    what = (
        f"share of the variance of the {words} [%]"
        if shares
        else f"change of the {words} per 1 % of each value [%]"
    )
    figure.supxlabel(what)  # as wide as the whole figure
    return figure


def _titled(metric: str, unit: str) -> str:
    """A metric and its unit for people."""
    name = metric.removesuffix("_L").removesuffix("_deg").replace("_deg_s", "").replace("_", " ")
    return f"{name} / L [-]" if metric.endswith("_L") else f"{name} [{unit}]"
