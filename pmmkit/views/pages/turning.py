"""How a ship sails with a model: a manoeuvre, its numbers with bands, and the IMO's verdict."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import PmmkitError
from pmmkit.conventions import METRICS, Metric
from pmmkit.imo import imo_turning
from pmmkit.models import Model
from pmmkit.simulation import Bands, Track, simulate, spiral_curve
from pmmkit.validation import ManoeuvreComparison
from pmmkit.views.pages.numbers import short

SHIPS: Final = 40
"""Ships behind a band: the central 95 % of forty is told to about a tenth of its width."""
POINTS: Final = 300
"""Samples of a track that are drawn."""
LENGTHS: Final = ("advance_L", "transfer_L", "tactical_diameter_L", "steady_diameter_L")
"""Measures of a turn that stand beside its path."""


def sailed_page(
    model: Model,
    manoeuvre: str,
    *,
    speed: float,
    band: bool = False,
    rivals: Sequence[tuple[Model, float, tuple[str, ...]]] = (),
    **settings: Any,
) -> dict[str, Any]:
    """A manoeuvre as the page draws it.

    speed [m/s]. rivals: ships that the tests accept, each with its odds against the most probable
    one, and what the base lacks if this is the ship.
    """
    if manoeuvre == "spiral":
        return spiral_page(model, speed=speed)
    track = simulate(model, manoeuvre, speed=speed, compiled=False, forces=True, **settings)
    page = track_page(track)
    if band and (rivals or model.covariance is not None):
        among = [(rival, odds) for rival, odds, _ in rivals]
        how = {"speed": speed, "n": SHIPS, **settings}
        try:
            found = Bands.of(model, manoeuvre, among=among, **how)
            page["band"] = {**_band(found), "rivals": [list(effects) for _, _, effects in rivals]}
            page["verdicts"] = [_settled(item, found) for item in page["verdicts"]]
        except PmmkitError as error:
            page["notes"] = [*page["notes"], str(error)]
    return page


def trials_page(
    manoeuvres: Sequence[ManoeuvreComparison], length: float
) -> dict[str, list[dict[str, Any]]]:
    """Measured turns and zigzags, to be drawn beside simulated ones.

    Parameters
    ----------
    manoeuvres : sequence of ManoeuvreComparison
        From a comparison with free-running records.
    length : float
        Of the ship that is sailed [m]: times are brought to it by Froude's law.

    Returns
    -------
    dict
        By manoeuvre its runs: ``run``, ``Fn``, ``rudder`` [deg]; from the order on ``t`` [s], ``x``
        and ``y`` [ship lengths], ``psi``, ``delta`` [deg]; ``metrics`` by name, those in metres
        left out.
    """
    found: dict[str, list[dict[str, Any]]] = {}
    for item in manoeuvres:
        trial = item.trial
        after = np.flatnonzero(trial.t >= 0.0)
        kept = after[_evenly(len(after))]
        found.setdefault(trial.manoeuvre, []).append(
            {
                "run": trial.run,
                "Fn": short(item.track.Fn),
                "rudder": short(trial.rudder_deg),
                "t": short(trial.t[kept] * math.sqrt(length / trial.L)),
                "x": short(trial.x[kept] / trial.L),
                "y": short(trial.y[kept] / trial.L),
                "psi": short(np.degrees(trial.psi[kept])),
                "delta": short(np.degrees(trial.delta[kept])),
                "metrics": {
                    name: short(value)
                    for name, value in trial.metrics.items()
                    if Metric.of(name).unit_of(name) in ("L", "deg", "-") and math.isfinite(value)
                },
            }
        )
    return found


def _evenly(count: int) -> NDArray[np.intp]:
    """Places of the samples that are drawn. A path is smooth: evenly spaced samples draw it, where
    extremes alone would cut its corners."""
    return np.unique(np.linspace(0, max(count - 1, 0), POINTS).round().astype(int))


def track_page(track: Track) -> dict[str, Any]:
    """A track as the page draws it; arguments and keys as for `sailed_page`."""
    kept = _evenly(len(track.t))
    judged = imo_turning(track) if track.manoeuvre == "turning" else []
    names = METRICS.told("turn", track.metrics) if judged else list(track.metrics)
    return {
        "manoeuvre": track.manoeuvre,
        "Fn": short(track.Fn),
        "L": short(track.L),
        "approach": short(track.speed),
        "t": short(track.t[kept]),
        "x": short(track.x[kept] / track.L),
        "y": short(track.y[kept] / track.L),
        "psi": short(np.degrees(track.psi[kept])),
        "delta": short(np.degrees(track.delta[kept])),
        "r": short(np.degrees(track.r[kept])),
        "speed": short(np.hypot(track.u, track.v * np.cos(track.phi))[kept]),
        "forces": [
            {
                "effect": effect,
                **{key: short(row[kept]) for key, row in zip("XYN", own, strict=True)},
            }
            for effect, own in track.forces.items()
        ],
        "metrics": [
            {
                "name": name,
                "title": Metric.of(name).title,
                "unit": Metric.of(name).unit_of(name),
                "value": short(track.metrics[name]),
            }
            for name in names
            if math.isfinite(track.metrics[name])
        ],
        "verdicts": [
            {
                "criterion": item.criterion,
                "metric": item.metric,
                "limit": item.limit,
                "value": short(item.value),
                "unit": item.unit,
                "passed": item.passed,
            }
            for item in judged
        ],
        "notes": [*track.notes, *track.standing.remarks],
        "unsettled": list(track.standing.unsettled),
    }


def _settled(verdict: dict[str, Any], found: Bands) -> dict[str, Any]:
    """A verdict, neither met nor failed where the limit lies inside the band of its number."""
    low, high = found.measures[verdict["metric"]]
    return verdict | {"passed": None} if low <= verdict["limit"] < high else verdict


def _band(found: Bands) -> dict[str, Any]:
    L = found.track.L
    return {
        "ships": found.ships,
        "inner": short(found.inner / L),
        "outer": short(found.outer / L),
        "measures": {name: short(np.array(ends)) for name, ends in found.measures.items()},
    }


def spiral_page(model: Model, *, speed: float) -> dict[str, Any]:
    """The steady yaw rate over the rudder angle: ``rudder`` [deg], ``rate`` [deg/s], ``stable``."""
    curve = spiral_curve(model, speed=speed)
    return {
        "rudder": short(curve.rudder_deg),
        "rate": short(curve.yaw_rate_deg_s),
        "stable": [bool(x) for x in curve.stable],
        "width": short(curve.loop_width_deg),
        "height": short(curve.loop_height_deg_s),
    }
