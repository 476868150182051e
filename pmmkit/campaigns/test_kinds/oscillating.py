"""Captive tests in which the model or its rudder is swung. With θ = ωt + phase:

===========  ===============================================  =================================
test         path and heading                                 so that
===========  ===============================================  =================================
pure_surge   x = Uc t + a sin θ, heading β                    u = Uc + aω cos θ at β = 0
pure_sway    y = a sin θ, heading β (usually 0)               u = Uc, v = aω cos θ at β = 0
pure_yaw     ψ = ψ0 sin θ, dy/dt = Uc tan ψ                   v = 0, u = Uc/cos ψ
yaw_drift    the path of pure yaw, heading ψ + β              u, v = Uc/cos ψ (cos β, -sin β)
yaw_rudder   pure yaw with the rudder held                    as pure yaw
sway_yaw     y = a sin θ, ψ = -ψ0 cos θ (heading ψ + β)       r = ψ0 ω sin θ
===========  ===============================================  =================================

In ``harmonic_rudder`` the hull is towed as in static drift and δ = δm + δ0 sin θ.

In ``sway_yaw`` the heading lags the sway displacement by a quarter period, so yaw rate and sway
velocity are in quadrature: r ∝ sin θ, and v = -Uc sin ψ + aω cos ψ cos θ, which is ∝ cos θ to
first order.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from pmmkit.campaigns.settings import Settings
from pmmkit.campaigns.test_kinds.kind import (
    RUDDER,
    SURGE,
    SWAY,
    YAW,
    KindFit,
    NominalMotion,
    PhaseChannel,
    ShipMotion,
    TankMotion,
    TestKind,
)
from pmmkit.campaigns.test_kinds.steady import DRIFT_RUDDER, STATIC_DRIFT, STATIC_RUDDER, STRAIGHT
from pmmkit.numerics import Array

YAW_LEAD: Final = -math.pi / 2
"""Lead of the heading over the sway displacement where both are swung [rad]."""
_ORDERS: Final = range(1, 64, 2)
_GRID: Final = 512


@dataclass(frozen=True)
class _Sine:
    """A displacement a sin θ with its rate and acceleration."""

    value: Array
    rate: Array
    acceleration: Array


def _sine(amplitude: float | None, settings: Settings, theta: Array) -> _Sine:
    size, omega = amplitude or 0.0, settings.omega or 0.0
    return _Sine(
        size * np.sin(theta), size * omega * np.cos(theta), -size * omega**2 * np.sin(theta)
    )


def surging(settings: Settings, theta: Array) -> TankMotion:
    """Surge displacement a sin θ at a heading β."""
    surge, zero = _sine(settings.amplitude, settings, theta), np.zeros_like(theta)
    return TankMotion(
        xdot=settings.speed + surge.rate,
        ydot=zero,
        xddot=surge.acceleration,
        yddot=zero,
        psi=zero + settings.drift,
        r=zero,
        rdot=zero,
    )


def swaying(settings: Settings, theta: Array) -> TankMotion:
    """Sway displacement a sin θ at a heading β."""
    sway, zero = _sine(settings.amplitude, settings, theta), np.zeros_like(theta)
    return TankMotion(
        xdot=settings.speed + zero,
        ydot=sway.rate,
        xddot=zero,
        yddot=sway.acceleration,
        psi=zero + settings.drift,
        r=zero,
        rdot=zero,
    )


def yawing(settings: Settings, theta: Array) -> TankMotion:
    """Heading β + ψ0 sin θ along the path whose tangent has the heading ψ0 sin θ."""
    psi, zero = _sine(settings.yaw_amplitude, settings, theta), np.zeros_like(theta)
    return TankMotion(
        xdot=settings.speed + zero,
        ydot=settings.speed * np.tan(psi.value),
        xddot=zero,
        yddot=settings.speed * psi.rate / np.cos(psi.value) ** 2,
        psi=psi.value + settings.drift,
        r=psi.rate,
        rdot=psi.acceleration,
    )


def swaying_and_yawing(settings: Settings, theta: Array) -> TankMotion:
    """Sway displacement a sin θ, the heading a quarter of a period behind."""
    sway, zero = _sine(settings.amplitude, settings, theta), np.zeros_like(theta)
    psi = _sine(settings.yaw_amplitude, settings, theta + YAW_LEAD)
    return TankMotion(
        xdot=settings.speed + zero,
        ydot=sway.rate,
        xddot=zero,
        yddot=sway.acceleration,
        psi=psi.value + settings.drift,
        r=psi.rate,
        rdot=psi.acceleration,
    )


def along_the_path(settings: Settings, theta: Array) -> ShipMotion:
    """The motion of `yawing` in ship axes, v exactly zero without drift."""
    psi = _sine(settings.yaw_amplitude, settings, theta)
    along = settings.speed / np.cos(psi.value)
    gain = along * np.tan(psi.value) * psi.rate
    ahead, aside = math.cos(settings.drift), -math.sin(settings.drift)
    return {
        "u": along * ahead,
        "v": along * aside,
        "r": psi.rate,
        "udot": gain * ahead,
        "vdot": gain * aside,
        "rdot": psi.acceleration,
    }


def surge_place(settings: Settings, theta: Array) -> tuple[Array, Array]:
    """Where the hull is that surges."""
    return _sine(settings.amplitude, settings, theta).value, np.zeros_like(theta)


def sway_place(settings: Settings, theta: Array) -> tuple[Array, Array]:
    """Where the hull is that sways."""
    return np.zeros_like(theta), _sine(settings.amplitude, settings, theta).value


def yaw_place(settings: Settings, theta: Array) -> tuple[Array, Array]:
    """y of dy/dt = Uc tan(ψ0 sin θ), about its mean.

    The tangent is a series of odd sines; each is integrated on its own.
    """
    grid = 2 * math.pi * np.arange(_GRID) / _GRID
    slope = np.tan((settings.yaw_amplitude or 0.0) * np.sin(grid))
    waves = -2.0 * np.fft.rfft(slope).imag / _GRID
    total = np.zeros_like(theta)
    for order in _ORDERS:
        if abs(waves[order]) > 1e-15:
            total = total - waves[order] / order * np.cos(order * theta)
    return np.zeros_like(theta), total * settings.speed / (settings.omega or math.inf)


PATH_OF_YAW: Final = NominalMotion(tank=yawing, ship=along_the_path, place=yaw_place)

PURE_SURGE: Final = TestKind(
    name="pure_surge",
    title="pure surge",
    family="oscillating",
    needs=("period", "amplitude"),
    varies=("u", "udot"),
    swings=(SURGE,),
    motion=NominalMotion(tank=surging, place=surge_place),
    fit=KindFit(factors=("u", "udot", "T")),
    codes=("PU", "PX", "PSU"),
    phrase=r"\b(?:pure ?)?surge\b",
)
PURE_SWAY: Final = TestKind(
    name="pure_sway",
    title="pure sway",
    family="oscillating",
    needs=("period", "amplitude"),
    varies=("v", "vdot"),
    swings=(SWAY,),
    motion=NominalMotion(tank=swaying, place=sway_place),
    fit=KindFit(factors=("u", "v", "vdot", "T")),
    quasi_steady=2.0,
    codes=("PS", "PSW"),
    phrase=r"\b(?:pure ?)?sway\b",
    shares={"amplitude": (0.4, 0.7, 1.0)},
    usual=True,
)
PURE_YAW: Final = TestKind(
    name="pure_yaw",
    title="pure yaw",
    family="oscillating",
    needs=("period", "yaw_amplitude"),
    varies=("u", "r", "udot", "rdot"),
    swings=(YAW,),
    motion=PATH_OF_YAW,
    fit=KindFit(factors=("u", "r", "udot", "rdot", "T")),
    quasi_steady=3.0,
    codes=("PY", "PYW"),
    phrase=r"\b(?:pure ?)?yaw\b",
    shares={"yaw_amplitude": (0.4, 0.7, 1.0)},
    usual=True,
)
YAW_DRIFT: Final = TestKind(
    name="yaw_drift",
    title="yaw with drift",
    family="oscillating",
    needs=("period", "yaw_amplitude", "drift"),
    varies=("u", "v", "r", "udot", "vdot", "rdot"),
    swings=(YAW,),
    motion=PATH_OF_YAW,
    fit=KindFit(factors=("u", "v", "r", "udot", "vdot", "rdot", "T")),
    quasi_steady=3.0,
    codes=("YD", "PYD"),
    phrase=r"\byaw\b.*\bdrift\b|\bdrift\b.*\byaw\b",
    shares={"yaw_amplitude": (0.8,), "drift": (2 / 3,)},
    usual=True,
)
YAW_RUDDER: Final = TestKind(
    name="yaw_rudder",
    title="yaw with rudder",
    family="oscillating",
    needs=("period", "yaw_amplitude", "rudder"),
    varies=("u", "r", "udot", "rdot", "delta"),
    swings=(YAW,),
    motion=PATH_OF_YAW,
    quasi_steady=3.0,
    codes=("YR",),
    phrase=r"\byaw\b.*\brudder\b",
)
SWAY_YAW: Final = TestKind(
    name="sway_yaw",
    title="sway and yaw",
    family="oscillating",
    needs=("period", "amplitude", "yaw_amplitude"),
    varies=("u", "v", "r", "udot", "vdot", "rdot"),
    swings=(SWAY, YAW),
    motion=NominalMotion(tank=swaying_and_yawing, place=sway_place),
    told_by=(
        PhaseChannel(channel="y", with_cosine=False, amplitude="amplitude"),
        PhaseChannel(channel="r", with_cosine=False, amplitude="yaw_amplitude"),
    ),
    codes=("SY",),
    phrase=r"\bsway\b.*\byaw\b",
    shares={"yaw_amplitude": (0.7,)},
)
HARMONIC_RUDDER: Final = TestKind(
    name="harmonic_rudder",
    title="harmonic rudder",
    family="oscillating",
    needs=("period", "rudder_amplitude"),
    takes=("drift", "rudder"),
    varies=("v", "delta"),
    swings=(RUDDER,),
    motion=STRAIGHT,
    fit=KindFit(
        factors=("u", "v", "d", "T"),
        beside=(STATIC_DRIFT.name, STATIC_RUDDER.name, DRIFT_RUDDER.name),
    ),
    codes=("HR",),
    phrase=r"\b(?:harmonic|dynamic|oscillating|swinging) ?rudder\b",
)
KINDS: Final = (PURE_SURGE, PURE_SWAY, PURE_YAW, YAW_DRIFT, YAW_RUDDER, SWAY_YAW, HARMONIC_RUDDER)
