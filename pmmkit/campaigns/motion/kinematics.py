"""How the model moved: the measured motion where there is one, the nominal motion for the rest."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike

from pmmkit.base import CampaignError, Problem
from pmmkit.campaigns.motion.nominal import (
    as_times,
    beside_motion,
    check_settings,
    motion_at_phase,
    nominal_motion,
    nominal_phase,
    refuse_free_running,
    require_settings,
)
from pmmkit.campaigns.motion.series import HARMONICS, fit_series
from pmmkit.campaigns.run import Run
from pmmkit.campaigns.test_kinds.kind import TankMotion, ship_axes
from pmmkit.effects import State
from pmmkit.numerics import Array, unwrapped
from pmmkit.signals import FourierBasis

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    "displacement_basis",
    "displacement_phase",
    "measured_motion",
    "motion_at_phase",
    "move_motion",
    "nominal_motion",
]


_RATES: Final = ("udot", "vdot", "rdot", "pdot")
_OSCILLATING: Final = ("u", "v", "r", "p", *_RATES, "x", "y", "psi")
_CARRIAGE: Final = "U_carriage"
_HELD: Final = {
    "phi": "phi",
    "delta": "delta",
    "n": "rps",
    "T": "thrust",
    "sinkage": "sinkage",
    "trim": "trim",
}
_MOTIONS: Final = (*_OSCILLATING, *_HELD, _CARRIAGE)
_CLEAR: Final = 5.0


def measured_motion(
    run: Run,
    data: xr.Dataset,
    times: ArrayLike,
    basis: FourierBasis | None = None,
    *,
    within: slice = slice(None),
) -> State:
    """Motion of the record: what was measured, and the nominal motion for the rest.

    For each of u, v, r the order is: its own channel, what follows from the positions and heading
    ``x, y, psi``, the nominal value (at the phase of the measured motion). Where the carriage's
    speed ``U_carriage`` was recorded it stands for the nominal speed: its mean, and in an
    oscillating test its series where it swings with the motion. Accelerations that were
    not measured follow from the velocity: in an oscillating test through its least-squares Fourier
    series (harmonics 0 to 5 at the frequency of the run, on the actual times), in a static test
    they are zero. In a static test only the mean heading and the mean speeds are taken from
    positions, of a circle only the yaw rate; where the rudder alone swings the hull counts as in a
    static test.

    Parameters
    ----------
    run : Run
        A captive test.
    data : Dataset
        The run's data, or a part of them. Channels ``u, v, r, p, phi, udot, vdot, rdot, pdot,
        delta, n, T, x, y, psi, U_carriage`` are used; scalars hold for all times. A channel that
        is NaN throughout counts as not measured, and so does a single value of what oscillates.
        ``x`` may count from the tank or from the carriage; its trend tells. Harmonics of a motion
        (``v_cos``, ``v_sin``) are summed at the nominal phase.
    times : array (n,)
        Times of the samples [s], even or not.
    basis : FourierBasis, optional
        Of harmonics 0 to 5 or above at these times, where there is one: its phase goes with ωt.
    within : slice
        The samples of the data that lie at these times.

    Returns
    -------
    State
        Referred to the point that the measurements refer to, see `move_motion`.

    Raises
    ------
    CampaignError
        If lengths differ, if a setting is needed and missing, or if the record is shorter than a
        period and has to be differentiated.

    Examples
    --------
    >>> import xarray as xr
    >>> from pmmkit.campaigns.settings import Settings
    >>> run = Run(id="PS", test="pure_sway", kind="history", loader=None,
    ...           settings=Settings(speed=1.5, period=8.0, amplitude=0.2))
    >>> t = np.arange(0.0, 8.0, 0.5)
    >>> data = xr.Dataset({"v": ("t", 0.3 * np.sin(2 * np.pi * t / 8.0))}, coords={"t": t})
    >>> measured_motion(run, data, t).vdot[:2].round(4)
    array([0.2356, 0.2177])
    """
    instants = as_times(run, times)
    refuse_free_running(run)
    channels = _channels(run, data, instants, within=within)
    known = beside_motion(run, nominal_phase(run, instants)) | {
        target: channels[name] for name, target in _HELD.items() if name in channels
    }
    known |= {name: channels[name] for name in ("u", "v", "r", "p", *_RATES) if name in channels}
    if not {"u", "v", "r"} <= set(channels):
        rest = _rest(run, channels, instants, basis)
        for name in {"u", "v", "r"} - set(channels):
            rate = f"{name}dot"
            known[name] = getattr(rest, name)
            known[rate] = channels.get(rate, getattr(rest, rate))
    for source, target in (("phi", "p"), ("u", "udot"), ("v", "vdot"), ("r", "rdot")):
        if source in channels and target not in channels:
            known[target] = _rate(run, instants, channels[source], source, basis)
    if "p" in known and "pdot" not in channels:
        known["pdot"] = _rate(run, instants, np.asarray(known["p"]), "p", basis)
    return State.of(len(instants), **known)


def displacement_phase(
    run: Run, data: xr.Dataset, times: ArrayLike, *, within: slice = slice(None)
) -> Array:
    """Phase θ of the displacement of an oscillating test: the motion is ∝ sin θ.

    The displacement is the heading in yaw tests, the sway displacement in sway tests, the surge
    displacement in surge tests, the angle of a rudder that swings. The phase is that of the
    fundamental of the measured displacement (``psi``; ``y``; ``x``; ``delta``), else of the
    velocity (``r``; ``v``; ``u``, which go with cos θ), else the nominal ωt + phase. It is measured
    where the fundamental stands five standard errors clear of zero. Tables of harmonics have the
    nominal phase.

    Parameters
    ----------
    run : Run
        An oscillating captive test; the settings' period counts.
    data : Dataset
        The run's data, or a part of them.
    times : array (n,)
        Times of the samples [s], even or not.
    within : slice
        Samples by which the phase is told; a ramp of the carriage stays out of them.

    Returns
    -------
    array (n,)
        θ [rad], rising with time, the branch nearest to ωt + phase.

    Raises
    ------
    CampaignError
        If the test does not oscillate, has no period, or the record is shorter than one.
    """
    return displacement_basis(run, data, times, HARMONICS, within=within).phase


def displacement_basis(
    run: Run, data: xr.Dataset, times: ArrayLike, order: int, *, within: slice = slice(None)
) -> FourierBasis:
    """The Fourier basis at the phase of the displacement, see `displacement_phase`."""
    instants = as_times(run, times)
    if not run.dynamic:
        raise CampaignError(f"a {run.test} test has no phase: it does not oscillate.", run=run.id)
    check_settings(run, ("period",))
    told = [item.channel for item in run.kind_of_test.phase_channels]
    return _displacement(run, _channels(run, data, instants, names=told), instants, order, within)


def _displacement(
    run: Run, channels: Mapping[str, Array], times: Array, order: int, within: slice = slice(None)
) -> FourierBasis:
    """The basis at the nominal phase, moved by what the measured displacement is ahead of it."""
    nominal = FourierBasis.at(nominal_phase(run, times), order)
    if run.kind == "harmonics":
        return nominal
    for told in run.kind_of_test.phase_channels:
        if told.channel not in channels:
            continue
        values = channels[told.channel][within]
        series = fit_series(run, times[within], values, told.channel, nominal.within(within))
        cosine, sine = series.fundamental
        if not math.hypot(cosine, sine) > _CLEAR * series.standard_error:
            continue
        lead = math.atan2(-sine, cosine) if told.with_cosine else math.atan2(cosine, sine)
        lead += math.pi if (run.settings.value(told.amplitude) or 0.0) < 0 else 0.0
        return nominal.ahead(math.remainder(lead, 2 * math.pi))
    return nominal


def move_motion(state: State, x: float) -> State:
    """Motion at midship from the motion of a point x forward of midship.

    Parameters
    ----------
    state : State
        Motion of the point.
    x : float
        Where the point is, forward of midship [m].

    Returns
    -------
    State
        v = v(x) - x r and v̇ = v̇(x) - x ṙ; everything else is the same.

    Examples
    --------
    >>> move_motion(State.of(u=1.0, v=0.3, r=0.1), 2.0).v
    array([0.1])
    """
    if x == 0.0:
        return state
    return state.with_(v=state.v - x * state.r, vdot=state.vdot - x * state.rdot)


def _channels(
    run: Run,
    data: xr.Dataset,
    times: Array,
    *,
    names: Sequence[str] = _MOTIONS,
    within: slice = slice(None),
) -> dict[str, Array]:
    """The measured motions, each (n,)."""
    found: dict[str, Array] = {}
    problems = []
    swung = {swing.displacement for swing in run.kind_of_test.swings}
    for name in names:
        if name in data:
            values = np.asarray(data.variables[name].values, float)
            values = values[within] if values.ndim else values
            if values.ndim == 0 and run.dynamic and name in (*_OSCILLATING, *swung):
                continue
            if values.ndim and values.shape != times.shape:
                problems.append(
                    Problem(
                        message=f"{values.shape} values for {times.shape} times.",
                        run=run.id,
                        column=name,
                    )
                )
                continue
            values = np.broadcast_to(values, times.shape)
        elif f"{name}_cos" in data or f"{name}_sin" in data:
            values = _summed(run, data, name, times)
        else:
            continue
        good = np.isfinite(values)
        if good.any():
            found[name] = unwrapped(values) if name == "psi" else values
    if problems:
        raise CampaignError(problems)
    return found


def _summed(run: Run, data: xr.Dataset, name: str, times: Array) -> Array:
    orders = np.asarray(data["harmonic"].values, float)
    angles = np.multiply.outer(nominal_phase(run, times), orders)
    total = np.zeros_like(times)
    for part, function in (("cos", np.cos), ("sin", np.sin)):
        if f"{name}_{part}" in data:
            weights = np.nan_to_num(np.asarray(data[f"{name}_{part}"].values, float))
            total = total + function(angles) @ weights
    return total


def _rest(
    run: Run, channels: Mapping[str, Array], times: Array, basis: FourierBasis | None
) -> State:
    """The motion where no velocity is measured: from positions, else nominal."""
    measured = {"x", "y", "psi"} & set(channels)
    if not run.kind_of_test.swings_hull:
        return _rest_static(run, channels, times)
    check_settings(run, ("period",))
    theta = _displacement(run, channels, times, HARMONICS).phase
    if not measured and _CARRIAGE not in channels:
        return motion_at_phase(run, theta)
    kind = run.kind_of_test
    if kind.places - measured:
        require_settings(run)
    tank = kind.in_tank(run.settings, theta)
    if _CARRIAGE in channels:
        tank = _towed(tank, run, channels[_CARRIAGE], times, basis)
    if "x" in measured:
        series = fit_series(run, times, channels["x"], "x", basis)
        xdot = series.derivative(1) + _carriage(run, channels, series.slope)
        tank = replace(tank, xdot=xdot, xddot=series.derivative(2))
    if "y" in measured:
        series = fit_series(run, times, channels["y"], "y", basis)
        tank = replace(tank, ydot=series.derivative(1), yddot=series.derivative(2))
    if "psi" in measured:
        series = fit_series(run, times, channels["psi"], "psi", basis)
        psi, r, rdot = (series.derivative(order) for order in (0, 1, 2))
        tank = replace(tank, psi=psi, r=r, rdot=rdot)
    return State.of(len(times), **ship_axes(tank))


def _rest_static(run: Run, channels: Mapping[str, Array], times: Array) -> State:
    speed = _towing_speed(run, channels)
    nominal = motion_at_phase(
        run
        if speed == run.settings.speed
        else run.with_(settings=replace(run.settings, speed=speed)),
        np.zeros_like(times),
    )
    slopes = {name: _slope(times, channels[name]) for name in ("x", "y", "psi") if name in channels}
    if run.kind_of_test.circles and "psi" in slopes:
        return nominal.with_(r=np.full_like(times, slopes["psi"]))
    if run.kind_of_test.circles or not slopes:
        return nominal
    ahead = slopes["x"] + _carriage(run, channels, slopes["x"]) if "x" in slopes else speed
    aside = slopes.get("y", 0.0)
    psi = float(np.nanmean(channels["psi"])) if "psi" in channels else run.settings.drift
    return nominal.with_(
        u=np.full_like(times, ahead * math.cos(psi) + aside * math.sin(psi)),
        v=np.full_like(times, -ahead * math.sin(psi) + aside * math.cos(psi)),
    )


def _towing_speed(run: Run, channels: Mapping[str, Array]) -> float:
    """The speed of the carriage: the mean of what was recorded, else as the test was set."""
    if _CARRIAGE not in channels:
        return run.settings.speed
    return float(np.nanmean(channels[_CARRIAGE]))


def _towed(
    tank: TankMotion, run: Run, speed: Array, times: Array, basis: FourierBasis | None
) -> TankMotion:
    """A motion in the tank with the recorded speed of the carriage in place of the one set.

    A swing of the carriage counts where it stands five standard errors clear of zero: surge that
    the carriage itself makes, or a carriage that keeps the hull's speed in yaw. Else its noise
    would be taken for an acceleration.
    """
    mean = float(np.nanmean(speed))
    if np.nanmin(speed) == np.nanmax(speed):
        return replace(tank, xdot=tank.xdot + (mean - run.settings.speed))
    series = fit_series(run, times, speed, _CARRIAGE, basis)
    if not np.any(series.swings > _CLEAR * series.standard_error):
        return replace(tank, xdot=tank.xdot + (mean - run.settings.speed))
    return replace(tank, xdot=series.derivative(0), xddot=series.derivative(1))


def _carriage(run: Run, channels: Mapping[str, Array], slope: float) -> float:
    """What to add to the trend of x: the carriage's speed where x counts from the carriage."""
    speed = _towing_speed(run, channels)
    return speed if abs(slope) < abs(speed) / 2 else 0.0


def _slope(times: Array, values: Array) -> float:
    good = np.isfinite(times) & np.isfinite(values)
    away = times[good] - times[good].mean()
    return float(away @ values[good] / (away @ away)) if np.ptp(away) > 0 else 0.0


def _rate(run: Run, times: Array, values: Array, name: str, basis: FourierBasis | None) -> Array:
    """Time derivative of a measured motion; zero of a hull that is held and of a constant."""
    if not run.kind_of_test.swings_hull or np.nanmin(values) == np.nanmax(values):
        return np.zeros_like(times)
    return fit_series(run, times, values, name, basis).derivative(1)
