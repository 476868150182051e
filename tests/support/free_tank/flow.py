"""Forces and flows that both ships have: what is hidden on the hull, wind, lift of a rudder."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from .hidden import Hidden

AIR, GRAVITY = 1.225, 9.81
STRIPS = (np.arange(40) + 0.5) / 40 - 0.5
"""Middles of strips over the length, forward of midship."""
STALL, FALL, LOST = math.radians(20.0), math.radians(8.0), 0.3
"""Lift falls beyond the first angle, over about the second, by this share of its top."""
TAPER = 1.3
"""Drag of a strip at x over L in yaw alone is 1 - TAPER x."""

BANK = 5.0
"""Distance of the bank from the approach [L]."""
AIRY = math.radians(12.0)
"""Angle of attack beyond which a rudder draws air."""

SWELL = 0.8
"""Frequency of the waves [rad/s]."""
_ALONG = np.linspace(-0.5, 0.5, 61)
_ASIDE = 0.0726 * (1.0 - np.abs(2.0 * _ALONG) ** 3)
_RUN, _RISE = np.diff(_ALONG), np.diff(_ASIDE)
WALL = np.stack(
    [np.tile(_ALONG[:-1] + _RUN / 2, 2), np.outer([1, -1], _ASIDE[:-1] + _RISE / 2).ravel()]
)
PIECES = np.tile(np.hypot(_RUN, _RISE), 2)
NORMALS = np.stack([np.tile(-_RISE, 2), np.outer([1, -1], _RUN).ravel()]) / PIECES
"""Middles, lengths and outward normals of the walls at the waterline, over the length."""

GROWTH = (2.3, 0.7, 1.7, 0.7)
"""Of Yv, Yr, Nv and Nr near the bottom, per square of draught over depth: first order of what
Hirano and others (1985) give; added masses stay those of deep water."""


@dataclass(frozen=True)
class Motion:
    """Motion through the water, one value a run: u, v [m/s], r, p [rad/s], ψ, φ [rad]; sway as it
    was about a lag ago, over the speed; place [m], ahead and to starboard of the first heading."""

    u: np.ndarray
    v: np.ndarray
    r: np.ndarray
    psi: np.ndarray
    phi: np.ndarray
    p: np.ndarray
    late: np.ndarray
    x: np.ndarray
    y: np.ndarray

    @property
    def speed(self) -> np.ndarray:
        return np.hypot(self.u, self.v)


@dataclass(frozen=True)
class Body:
    """Length, breadth, draught [m], density of the water [kg/m³], areas above water [m²]; Yv, Yr,
    Nv and Nr of the hull over ½ρL²U² and ½ρL³U²."""

    L: float
    B: float
    d: float
    rho: float
    front: float
    flank: float
    linear: tuple[float, float, float, float]


def hidden_forces(
    body: Body, hidden: Hidden, now: Motion, blows: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """X, Y [N] and N [N m] of what is hidden on the hull and of the wind.

    `blows` holds the true wind of each run, its speed [m/s] and where it comes from [rad], and the
    significant height of its waves [m] and where they come from.
    """
    U = now.speed
    q = 0.5 * body.rho * body.L**2 * U**2
    v, r = now.v / U, now.r * body.L / U
    Y = hidden.side + hidden.vvr[0] * v * v * r + hidden.vrr[0] * v * r * r
    N = hidden.turn + hidden.vvr[1] * v * v * r + hidden.vrr[1] * v * r * r
    Y = Y + hidden.late_side * (now.late - v)
    N = N + hidden.late_turn * (now.late - v)
    Yv, Yr, Nv, Nr = (hidden.bottom * x * y for x, y in zip(body.linear, GROWTH, strict=True))
    Y, N = Y + Yv * v + Yr * r, N + Nv * v + Nr * r
    drag = body.d / body.L
    if hidden.plate:
        plate = -hidden.plate * drag * v * np.abs(v)
        Y, N = Y + plate, N - 0.2 * plate
    if hidden.ends:
        strips = -hidden.ends * drag * (1.0 - TAPER * STRIPS) * STRIPS * np.abs(STRIPS)
        Y = Y + strips.mean() * r * np.abs(r)
        N = N + (strips * STRIPS).mean() * r * np.abs(r)
    if hidden.strips:
        across = v[:, None] + r[:, None] * STRIPS
        strips = -hidden.strips * drag * across * np.abs(across)
        Y, N = Y + strips.mean(axis=1), N + (strips * STRIPS).mean(axis=1)
    X = hidden.vr * v * r
    if hidden.bank:
        pull = hidden.bank / (1.0 + np.maximum(BANK - now.y / body.L, 0.0)) ** 2
        X, Y = X + pull * np.sin(now.psi), Y + pull * np.cos(now.psi)
        N = N - 0.1 * pull * np.cos(now.psi)
    if hidden.tether:
        away = np.arctan2(-now.y, -now.x) - now.psi
        taut = hidden.tether * np.minimum(np.hypot(now.x, now.y) / body.L, 1.0)
        X, Y = X + taut * np.cos(away), Y + taut * np.sin(away)
        N = N - 0.5 * taut * np.sin(away)
    X, Y, N = q * X, q * Y, q * body.L * N
    if hidden.windage:
        wind = wind_forces(body, now, blows)
        X, Y, N = (a + hidden.windage * b for a, b in zip((X, Y, N), wind, strict=True))
    if hidden.waves:
        sea = wave_forces(body, now, blows)
        X, Y, N = (a + hidden.waves * b for a, b in zip((X, Y, N), sea, strict=True))
    return X, Y, N


def hull_coefficients(body: Body, hidden: Hidden) -> dict[str, dict[str, float]]:
    """What is hidden on the hull, as coefficients of the effects that have the same form."""
    drag = body.d / body.L
    plate = -hidden.plate * drag
    ends = -hidden.ends * drag * (1.0 - TAPER * STRIPS) * STRIPS * np.abs(STRIPS)
    return {
        "asymmetry": {"Y0": hidden.side, "N0": hidden.turn},
        "yaw_sway_coupling": {
            "Yvvr": hidden.vvr[0],
            "Yvrr": hidden.vrr[0],
            "Nvvr": hidden.vvr[1],
            "Nvrr": hidden.vrr[1],
        },
        "surge_yaw_coupling": {"Xvr": hidden.vr},
        "modulus_sway_drag": {"Yv|v|": plate, "Nv|v|": -0.2 * plate},
        "modulus_yaw_drag": {"Yr|r|": float(ends.mean()), "Nr|r|": float((ends * STRIPS).mean())},
        "crossflow_drag": {"CD": hidden.strips},
        "current": {"current_x": hidden.current[0], "current_y": hidden.current[1]},
        "propeller_load": {"wp": hidden.wake, "t": hidden.deduction},
        "rudder_hull_interaction": {
            "aH": hidden.hull_share,
            "xH": hidden.hull_point,
            "tR": hidden.steering_drag,
        },
    }


def relative_wind(now: Motion, blows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Speed of the wind past the ship [m/s], and where it comes from, off the bow [rad]."""
    ahead = blows[0] * np.cos(blows[1] - now.psi) + now.u
    abeam = blows[0] * np.sin(blows[1] - now.psi) + now.v
    return np.hypot(ahead, abeam), np.arctan2(abeam, ahead)


def wind_forces(
    body: Body, now: Motion, blows: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """X, Y, N of the wind on blunt ends and a flat flank; its centre moves with the angle."""
    past, angle = relative_wind(now, blows)
    pressure = 0.5 * AIR * past**2
    X = -pressure * body.front * (0.75 * np.cos(angle) - 0.05 * np.cos(3.0 * angle))
    Y = -pressure * body.flank * (0.82 * np.sin(angle) - 0.04 * np.sin(3.0 * angle))
    return X, Y, Y * body.L * (0.23 * np.cos(angle) + 0.01)


def wave_forces(
    body: Body, now: Motion, blows: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """X, Y, N of short waves on walls that send half of their energy back, as Faltinsen and others
    (1980) have it: by the square of how squarely they meet the exposed wall, and more the faster
    they meet it."""
    angle = (blows[3] - now.psi)[:, None]
    square = np.maximum(np.cos(angle) * NORMALS[0] + np.sin(angle) * NORMALS[1], 0.0) ** 2
    met = np.maximum(1.0 + 2.0 * SWELL * now.u / GRAVITY * np.cos(angle[:, 0]), 0.0)
    size = 0.5 * body.rho * GRAVITY * blows[2] ** 2 / 16.0 * met
    X, Y, N = (
        -(square * way * PIECES).sum(axis=1)
        for way in (NORMALS[0], NORMALS[1], WALL[0] * NORMALS[1] - WALL[1] * NORMALS[0])
    )
    return size * body.L * X, size * body.L * Y, size * body.L**2 * N


def normal_lift(
    slope: float, attack: np.ndarray, stalled: float, ventilated: float = 0.0
) -> np.ndarray:
    """Coefficient of a rudder's normal force; `stalled` is the share of one that stalls, and
    `ventilated` what it loses to starboard where it draws air."""
    airy = 1.0 - ventilated / (1.0 + np.exp(-(attack - AIRY) / math.radians(1.0)))
    attached = slope * np.sin(attack) * airy
    if not stalled:
        return attached
    beyond = np.maximum(np.abs(attack) - STALL, 0.0)
    top = slope * np.sin(np.minimum(np.abs(attack), STALL))
    fallen = np.sign(attack) * top * (1.0 - LOST * (1.0 - np.exp(-((beyond / FALL) ** 2))))
    return (1.0 - stalled) * attached + stalled * fallen


def revolutions_for(
    thrust: np.ndarray, inflow: np.ndarray, D: float, rho: float, kt: tuple[float, float, float]
) -> np.ndarray:
    """Revolutions [1/s] at which a propeller gives a thrust [N] in a flow [m/s]."""
    a, b, c = kt[0], kt[1] * inflow, kt[2] * inflow**2 - thrust / (rho * D * D)
    return (-b + np.sqrt(b * b - 4.0 * a * c)) / (2.0 * a) / D
