"""Free-running runs of a campaign as records for the estimators."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Final, Literal

import numpy as np

from pmmkit.base import DataError, did_you_mean
from pmmkit.campaigns import Fixes, Run, usable
from pmmkit.identification.local_fits import half_window, true_wind, velocity
from pmmkit.identification.record import FreeRecord, rate_limited
from pmmkit.models import Model
from pmmkit.numerics import Array

# The measured heel as an input: what is left of it and of its rates without the noise.


WIDTHS: Final = (5, 7, 9, 13, 17, 25, 33, 49, 65, 97, 129, 193, 257, 385)
"""Numbers of instants over which cubics are tried."""
ORDER: Final = 3


def measured_roll(t: Array, phi: Array, p: Array | None = None) -> tuple[Array, Array, Array]:
    """Heel and its rates as inputs of a ship that does not roll by itself.

    t [s]; p [rad/s].

    Notes
    -----
    Cubics through a sliding window (Savitzky and Golay 1964). Its width is that of the least
    generalised cross-validation, mean square of the residuals over (1 - w)² with w the weight of
    an instant in its own value (Craven and Wahba 1979): a slow roll is smoothed over longer times
    than a fast one, and a heel without noise over five instants. Instants that are not equally
    spaced are looked at on a grid of as many that are.

    Examples
    --------
    >>> t = np.linspace(0.0, 100.0, 401)
    >>> truth = 0.1 * np.sin(0.3 * t)
    >>> noise = np.random.default_rng(0).normal(size=401)
    >>> roll, rate, gain = measured_roll(t, truth + 0.002 * noise)
    >>> bool(np.std(roll - truth) < 0.001), bool(np.std(rate - 0.03 * np.cos(0.3 * t)) < 0.001)
    (True, True)
    """
    even = np.linspace(t[0], t[-1], len(t))
    at = even if np.allclose(even, t, rtol=0.0, atol=1e-6 * (even[1] - even[0])) else t
    step = even[1] - even[0]
    smooth, rate, gain = _smoothed(np.interp(even, at, phi), step)
    if p is not None:
        rate, gain, _ = _smoothed(np.interp(even, at, p), step)
    return np.interp(at, even, smooth), np.interp(at, even, rate), np.interp(at, even, gain)


def _smoothed(values: Array, step: float) -> tuple[Array, Array, Array]:
    """Values at equal steps [s] without noise, their slopes, and the slopes of these."""
    from scipy.signal import savgol_coeffs, savgol_filter

    widths = [width for width in WIDTHS if width <= len(values)]
    if not widths:
        slope = np.gradient(values, step)
        return values, slope, np.gradient(slope, step)

    def left(width: int) -> float:
        own = savgol_coeffs(width, ORDER)[width // 2]
        away = values - savgol_filter(values, width, ORDER)
        return float(np.mean(away**2) / (1.0 - own) ** 2)

    best = min(widths, key=left)
    return (
        savgol_filter(values, best, ORDER),
        savgol_filter(values, best, ORDER, deriv=1, delta=step),
        savgol_filter(values, best, ORDER, deriv=2, delta=step),
    )


Rudder = Literal["auto", "measured", "ordered"]
FASTER: Final = 3.0
"""A rudder that moves so many times faster than its gear can is an order, not an angle."""


def free_records(
    run: Run,
    model: Model,
    *,
    rudder: Rudder = "auto",
    channels: Sequence[str] | None = None,
    wind: bool = True,
    roll: bool = True,
    shortest: float | None = None,
    depth: float | None = None,
    campaign: str = "",
) -> tuple[FreeRecord, ...]:
    """The usable segments of a free-running run.

    Parameters
    ----------
    run : Run
        With t, x, y, psi, delta and n; velocities, roll and wind where they are measured.
    model : Model
        Says how fast its rudder moves, and whether it rolls.
    rudder : {"auto", "measured", "ordered"}
        Whether the rudder column is the angle, or the order that the steering gear follows at its
        rate; by default an order if it steps faster than the gear can.
    channels : sequence of str, optional
        Measurements to use; by default all there are. Leave out what a check calls wrong.
    wind : bool
        Whether to take over a measured wind.
    roll : bool
        Whether a model that does not roll takes over a measured heel as an input.
    shortest : float, optional
        Segments shorter than this are left out [s]; by default ten ship lengths at the speed of
        the approach, or a third of the record where that is less.
    depth : float, optional
        Depth of the water [m], of the campaign.
    campaign : str
        Title of the tests.

    Returns
    -------
    tuple of FreeRecord
        Repeated positions (a receiver without news) are left out as measurements.

    Raises
    ------
    DataError
        If the run has no rudder or no revolutions, or none for longer than a second, or a channel
        is not there.

    Notes
    -----
    A campaign's wind is relative, at midship. The true wind over ground follows with the heading
    and the velocity over ground, which is that of the positions: columns u and v are through the
    water.
    """
    data = run.data
    run = run.with_(loader=lambda: data)
    t = np.asarray(data["t"].values, float)
    lengths = 10.0 * model.ship.L / max(run.settings.speed, 1e-9)
    found = usable(run, shortest=shortest or min(lengths, float(np.nanmax(t) - np.nanmin(t)) / 3))
    return tuple(
        _record(segment, model, rudder, channels, wind, roll).with_(depth=depth, campaign=campaign)
        for segment in found.segments
    )


def _record(
    run: Run, model: Model, rudder: Rudder, channels: Sequence[str] | None, wind: bool, roll: bool
) -> FreeRecord:
    data = run.data
    columns = {str(name): np.asarray(data[name].values, float) for name in data.data_vars}
    t = np.asarray(data["t"].values, float)
    lost = [name for name in ("delta", "n") if not np.isfinite(columns.get(name, [])).any()]
    if lost:
        raise DataError(
            f"it has no {' and no '.join(lost)}: the forces of rudder and propeller hang on it.",
            run=run.id,
            remedy="Name their columns under [columns] of the campaign file.",
        )
    known = [name for name in FreeRecord.CHANNELS if name in columns]
    if not model.rolls:
        known = [name for name in known if name not in ("p", "phi")]
    if channels is not None:
        absent = [name for name in channels if name not in known]
        if absent:
            raise DataError(
                f"Run {run.id} has no {', '.join(absent)} to measure by"
                f"{did_you_mean(absent[0], known) or '.'} It has {', '.join(known)}."
            )
        known = list(channels)
    measured = {name: columns[name].copy() for name in known}
    if "fresh" in columns:
        stale = columns["fresh"] == 0.0
        for name in ("x", "y"):
            if name in measured:
                measured[name][stale] = np.nan
    delta = _filled(t, columns["delta"], Fixes.GAP)
    rate = math.radians(model.steering.get("rate_deg_s", math.inf))
    if rudder == "ordered" or (rudder == "auto" and _steps(t, delta, rate)):
        delta = rate_limited(t, delta, rate)
    blowing = _true_wind(run, model, t, columns) if wind else None
    driven = None if model.rolls or not roll else _roll(t, columns)
    sea = run.settings
    return FreeRecord(
        name=run.id,
        reckoned=()
        if channels is not None
        else tuple(name for name in measured if Run.RECKONED in data[name].attrs),
        t=t,
        delta=delta,
        turns=_filled(t, columns["n"], Fixes.GAP),
        measured=MappingProxyType(measured),
        speed=run.settings.speed,
        wind_speed=blowing[0] if blowing else None,
        wind_direction=blowing[1] if blowing else None,
        wave_height=None if sea.wave_height is None else np.full(len(t), sea.wave_height),
        wave_direction=None if sea.waves_from is None else np.full(len(t), sea.waves_from),
        wave_period=sea.wave_period,
        roll=driven[0] if driven else None,
        roll_rate=driven[1] if driven else None,
        roll_acceleration=driven[2] if driven else None,
    )


def _roll(t: Array, columns: Mapping[str, Array]) -> tuple[Array, Array, Array] | None:
    """Heel [rad] and its rates [rad/s, rad/s²] without noise, gaps bridged by straight lines."""
    there = {name: np.isfinite(columns[name]) for name in ("phi", "p") if name in columns}
    if np.sum(there.get("phi", 0)) < 2:
        return None
    known = {name: _filled(t, columns[name]) for name, seen in there.items() if seen.any()}
    return measured_roll(t, known["phi"], known.get("p"))


def _filled(t: Array, values: Array, longest: float = math.inf) -> Array:
    """Values with gaps bridged; NaN in those that are longer."""
    there = np.isfinite(values)
    if not there.any():
        return np.zeros(len(t))
    filled: Array = np.interp(t, t[there], values[there])
    edges = np.concatenate([t[:1], t[there], t[-1:]])
    after = np.searchsorted(t[there], t) + 1
    filled[~there & (edges[after] - edges[after - 1] > longest)] = np.nan
    return filled


def _steps(t: Array, delta: Array, rate: float) -> bool:
    """Whether a rudder moves faster than its gear can."""
    moved = np.abs(np.diff(delta)) / np.diff(t)
    return bool(np.max(moved, initial=0.0) > FASTER * rate)


def _true_wind(
    run: Run, model: Model, t: Array, columns: Mapping[str, Array]
) -> tuple[Array, Array] | None:
    """Speed of the true wind over ground [m/s], and where it comes from, from north [rad]."""
    if not {"wind_speed", "wind_direction"} <= set(columns):
        return None
    fresh = columns["fresh"] != 0.0
    half = half_window(t, model.ship.L, max(run.settings.speed, 1e-9))
    north, east = velocity(t[fresh], columns["x"][fresh], columns["y"][fresh], t, half)
    speed, direction = true_wind(
        columns["psi"], columns["wind_speed"], columns["wind_direction"], north, east
    )
    return _filled(t, speed), _filled(t, direction)
