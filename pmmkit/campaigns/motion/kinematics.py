"""How the model moved: the measured motion where there is one, the nominal motion for the rest."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pmmkit.base import CampaignError, Problem
from pmmkit.campaigns.stated_run import StatedRun
from pmmkit.campaigns.test_kinds.kind import TankMotion
from pmmkit.effects import State
from pmmkit.numerics import Array, coefficients, unwrapped
from pmmkit.signals import FourierBasis

if TYPE_CHECKING:
    import xarray as xr


# Fourier series of a measured motion on its actual times.


HARMONICS: Final = 5
"""Highest harmonic of the series through which measured motions are differentiated."""
_WHOLE: Final = 0.95


@dataclass(frozen=True, kw_only=True, eq=False)
class FourierSeries:
    """A trend and a Fourier series: c0 + c1 τ + Σ (a cos nθ + b sin nθ), τ = t - start, θ̇ = ω."""

    omega: float
    start: float
    away: Array
    slope: float
    basis: FourierBasis
    coefficients: Array
    standard_error: float

    @property
    def fundamental(self) -> tuple[float, float]:
        """Cosine and sine amplitude of the first harmonic."""
        return float(self.coefficients[1]), float(self.coefficients[2])

    @property
    def swings(self) -> Array:
        """Amplitudes of the harmonics from the first on."""
        return np.hypot(self.coefficients[1::2], self.coefficients[2::2])

    def derivative(self, order: int) -> Array:
        """The series (order 0) or its first or second time derivative at all samples."""
        rates = self.omega * np.arange(1, self.basis.order + 1)
        turned = (self.coefficients[1::2] - 1j * self.coefficients[2::2]) * (1j * rates) ** order
        weights = np.zeros_like(self.coefficients)
        weights[0] = self.coefficients[0] if order == 0 else 0.0
        weights[1::2], weights[2::2] = turned.real, -turned.imag
        found: Array = weights @ self.basis.rows
        if self.slope and order < 2:
            found += self.slope * (self.away if order == 0 else 1.0)
        return found


def fit_series(
    run: StatedRun, times: Array, values: Array, name: str, basis: FourierBasis | None = None
) -> FourierSeries:
    """Least-squares series of a measured channel at the run's frequency.

    times [s].
    """
    run.require_settings(("period",))
    omega = run.settings.omega or 0.0
    good = np.isfinite(times) & np.isfinite(values)
    count = int(np.count_nonzero(good))
    instants = times[good]
    covered = np.ptp(instants) * count / (count - 1) * omega / (2 * math.pi) if count > 1 else 0.0
    if count and covered >= _WHOLE:
        away = times - instants[0]
        whole = basis or FourierBasis.at(omega * away, HARMONICS)
        trend = away / np.ptp(instants) if name == "x" else None
        for order in range(HARMONICS, 0, -1):
            shared = whole.up_to(order)
            found = _solved(shared, trend, values, good)
            if found is not None:
                return FourierSeries(
                    omega=omega,
                    start=float(instants[0]),
                    away=away,
                    slope=0.0 if trend is None else float(found[0][-1] / np.ptp(instants)),
                    basis=shared,
                    coefficients=found[0][: 2 * order + 1],
                    standard_error=found[1] * math.sqrt(2 / count),
                )
    raise CampaignError(
        f"{count} samples over {covered:.2f} periods are too few for a Fourier series.",
        run=run.id,
        column=name,
        remedy="Give the whole oscillation, or the accelerations as channels.",
    )


def _solved(
    basis: FourierBasis, trend: Array | None, values: Array, good: NDArray[np.bool_]
) -> tuple[Array, float] | None:
    """Coefficients of a series and the scatter about it; None where the samples leave them open."""
    rows = basis.rows if trend is None else np.vstack([basis.rows, trend])
    if not good.all():
        rows, values = rows[:, good], values[good]
    size, count = rows.shape
    if count < size:
        return None
    gram = basis.gram if rows is basis.rows else rows @ rows.T
    if np.linalg.matrix_rank(gram, tol=1e-9 * count) < size:
        return None
    solution = coefficients(rows.T, values[None], gram)[0]
    residual = values - solution @ rows
    return solution, math.sqrt(float(residual @ residual) / max(count - size, 1))


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
    run: StatedRun,
    data: xr.Dataset,
    times: ArrayLike,
    basis: FourierBasis | None = None,
    *,
    within: slice = slice(None),
) -> State:
    """Motion of the record, see `Run.measured_motion`."""
    instants = run.instants(times)
    run.refuse_free_running()
    channels = _channels(run, data, instants, within=within)
    known = run.beside_motion(run.nominal_phase(instants)) | {
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
    run: StatedRun, data: xr.Dataset, times: ArrayLike, *, within: slice = slice(None)
) -> Array:
    """Phase θ (n,) of the displacement of an oscillating test, see `Run.displacement_phase`."""
    return displacement_basis(run, data, times, HARMONICS, within=within).phase


def displacement_basis(
    run: StatedRun, data: xr.Dataset, times: ArrayLike, order: int, *, within: slice = slice(None)
) -> FourierBasis:
    """The Fourier basis at the phase of the displacement, see `displacement_phase`."""
    instants = run.instants(times)
    if not run.dynamic:
        raise CampaignError(f"a {run.test} test has no phase: it does not oscillate.", run=run.id)
    run.require_settings(("period",))
    told = [item.channel for item in run.kind_of_test.phase_channels]
    return _displacement(run, _channels(run, data, instants, names=told), instants, order, within)


def _displacement(
    run: StatedRun,
    channels: Mapping[str, Array],
    times: Array,
    order: int,
    within: slice = slice(None),
) -> FourierBasis:
    """The basis at the nominal phase, moved by what the measured displacement is ahead of it."""
    nominal = FourierBasis.at(run.nominal_phase(times), order)
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


def _channels(
    run: StatedRun,
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


def _summed(run: StatedRun, data: xr.Dataset, name: str, times: Array) -> Array:
    orders = np.asarray(data["harmonic"].values, float)
    angles = np.multiply.outer(run.nominal_phase(times), orders)
    total = np.zeros_like(times)
    for part, function in (("cos", np.cos), ("sin", np.sin)):
        if f"{name}_{part}" in data:
            weights = np.nan_to_num(np.asarray(data[f"{name}_{part}"].values, float))
            total = total + function(angles) @ weights
    return total


def _rest(
    run: StatedRun, channels: Mapping[str, Array], times: Array, basis: FourierBasis | None
) -> State:
    """The motion where no velocity is measured: from positions, else nominal."""
    measured = {"x", "y", "psi"} & set(channels)
    if not run.kind_of_test.swings_hull:
        return _rest_static(run, channels, times)
    run.require_settings(("period",))
    theta = _displacement(run, channels, times, HARMONICS).phase
    if not measured and _CARRIAGE not in channels:
        return run.motion_at_phase(theta)
    kind = run.kind_of_test
    if kind.places - measured:
        run.require_settings()
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
    return State.of(len(times), **tank.in_ship_axes)


def _rest_static(run: StatedRun, channels: Mapping[str, Array], times: Array) -> State:
    speed = _towing_speed(run, channels)
    if speed != run.settings.speed:
        run = run.with_(settings=replace(run.settings, speed=speed))
    nominal = run.motion_at_phase(np.zeros_like(times))
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


def _towing_speed(run: StatedRun, channels: Mapping[str, Array]) -> float:
    """The speed of the carriage: the mean of what was recorded, else as the test was set."""
    if _CARRIAGE not in channels:
        return run.settings.speed
    return float(np.nanmean(channels[_CARRIAGE]))


def _towed(
    tank: TankMotion, run: StatedRun, speed: Array, times: Array, basis: FourierBasis | None
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


def _carriage(run: StatedRun, channels: Mapping[str, Array], slope: float) -> float:
    """What to add to the trend of x: the carriage's speed where x counts from the carriage."""
    speed = _towing_speed(run, channels)
    return speed if abs(slope) < abs(speed) / 2 else 0.0


def _slope(times: Array, values: Array) -> float:
    good = np.isfinite(times) & np.isfinite(values)
    away = times[good] - times[good].mean()
    return float(away @ values[good] / (away @ away)) if np.ptp(away) > 0 else 0.0


def _rate(
    run: StatedRun, times: Array, values: Array, name: str, basis: FourierBasis | None
) -> Array:
    """Time derivative of a measured motion; zero of a hull that is held and of a constant."""
    if not run.kind_of_test.swings_hull or np.nanmin(values) == np.nanmax(values):
        return np.zeros_like(times)
    return fit_series(run, times, values, name, basis).derivative(1)
