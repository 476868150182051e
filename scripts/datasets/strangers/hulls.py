"""Two hulls that are in no library: their forces, and the turn that they really make.

Prime system with the speed of the instant, added-mass Coriolis terms inside the derivatives, x
forward, y to starboard, z down. Propeller and rudder are those of the MMG standard (Yasukawa and
Yoshimura 2015, equations 8 to 27) with a constant wake.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Array = NDArray[np.float64]
RHO, GRAVITY = 999.1, 9.81
ORDER = math.radians(35.0)


@dataclass(frozen=True)
class Steering:
    """Propeller and rudder; lengths in metres, places over L."""

    D: float
    t: float
    wp: float
    kt: tuple[float, float, float]
    area: float
    lift_slope: float
    eta: float
    epsilon: float
    kappa: float
    gamma: float
    lR: float
    tR: float
    aH: float
    xH: float
    rate_deg_s: float


@dataclass(frozen=True)
class Hull:
    """Particulars [m, kg, kg m²] and derivatives: by channel, the letters of each term.

    In the letters f is the heel; a dotted letter (``vdot``) is an acceleration.
    """

    name: str
    L: float
    B: float
    d: float
    volume: float
    mass: float
    Izz: float
    xG: float
    steering: Steering
    truth: Mapping[str, float]
    zG: float = 0.0
    GM: float = 0.0
    Ix: float = 0.0
    damping: float = 0.0

    @property
    def rolls(self) -> bool:
        """Whether she heels in a turn."""
        return self.Ix > 0


Motion = Mapping[str, Array]


def forces(hull: Hull, motion: Motion) -> dict[str, Array]:
    """Force of the water on the hull [N, N m], each (n,)."""
    speed = np.hypot(motion["u"], motion["v"])
    letters = {
        "u": motion["u"] / speed,
        "v": motion["v"] / speed,
        "r": motion["r"] * hull.L / speed,
        "f": motion["phi"],
    }
    lengths = {"udot": hull.L, "vdot": hull.L, "rdot": hull.L**2}
    pressure = 0.5 * RHO * hull.L**2 * speed**2
    scale = {"X": pressure, "Y": pressure, "N": pressure * hull.L, "K": pressure * hull.L}
    found = {channel: np.zeros_like(speed) for channel in scale}
    for name, value in hull.truth.items():
        channel, term = name[0], name[1:]
        if term in lengths:
            part = motion[term] * lengths[term] / speed**2
        else:
            part = np.prod([letters[letter] for letter in term], axis=0)
        found[channel] = found[channel] + scale[channel] * value * part
    return found


def inertia(hull: Hull, motion: Motion) -> dict[str, Array]:
    """What a balance feels less of the water's force because the model is accelerated."""
    u, v, r = motion["u"], motion["v"], motion["r"]
    across = motion["vdot"] + u * r
    return {
        "X": hull.mass * (motion["udot"] - v * r - hull.xG * r**2),
        "Y": hull.mass * (across + hull.xG * motion["rdot"]),
        "N": hull.Izz * motion["rdot"] + hull.mass * hull.xG * across,
        "K": -hull.mass * hull.zG * across,
    }


def thrust(hull: Hull, u: float, n: float) -> float:
    """Thrust [N] at a surge velocity [m/s] and revolutions [1/s]."""
    own = hull.steering
    inflow = (1 - own.wp) * u
    a, b, c = own.kt
    return RHO * own.D**2 * (a * (n * own.D) ** 2 + b * n * own.D * inflow + c * inflow**2)


def revolutions(hull: Hull, speed: float) -> float:
    """Revolutions [1/s] at which she keeps a speed [m/s] straight ahead."""
    own = hull.steering
    wanted = -0.5 * RHO * hull.L**2 * speed**2 * hull.truth["Xuu"] / (1 - own.t)
    a, b, c = own.kt
    inflow = (1 - own.wp) * speed
    load = wanted / (RHO * own.D**2) - c * inflow**2
    return (-b * inflow + math.sqrt((b * inflow) ** 2 + 4 * a * load)) / (2 * a * own.D)


def rudder(hull: Hull, u: float, v: float, r: float, n: float, delta: float) -> tuple[float, ...]:
    """X, Y [N] and N [N m] of the rudder with what it raises on the hull."""
    own = hull.steering
    speed = math.hypot(u, v)
    inflow = (1 - own.wp) * u
    jet = math.sqrt(inflow**2 + 8 * thrust(hull, u, n) / (math.pi * RHO * own.D**2))
    mixed = inflow + own.kappa * (jet - inflow)
    along = own.epsilon * math.sqrt(own.eta * mixed**2 + (1 - own.eta) * inflow**2)
    across = -own.gamma * speed * (math.atan2(-v, u) - own.lR * r * hull.L / speed)
    angle = delta + math.atan2(across, along)
    normal = 0.5 * RHO * own.area * own.lift_slope * (along**2 + across**2) * math.sin(angle)
    side = normal * math.cos(delta)
    return (
        -(1 - own.tR) * normal * math.sin(delta),
        -(1 + own.aH) * side,
        -(-0.5 + own.aH * own.xH) * hull.L * side,
    )


@dataclass(frozen=True)
class Turn:
    """A turning circle: the track of midship, and its lengths over L."""

    t: Array
    x: Array
    y: Array
    psi: Array
    delta: Array
    n: float
    advance: float
    tactical_diameter: float
    heel_deg: float


def turn(hull: Hull, speed: float, order: float = ORDER, *, duration: float = 0.0) -> Turn:
    """The turn that a hull makes from a speed [m/s], the rudder [rad] put over at t = 0."""
    n = revolutions(hull, speed)
    rate = math.copysign(math.radians(hull.steering.rate_deg_s), order)

    def laid(t: float) -> float:
        return math.copysign(min(abs(rate) * t, abs(order)), order)

    def rates(t: float, state: Array) -> list[float]:
        u, v, r, p, phi, _, _, psi = map(float, state)
        still = {"udot": 0.0, "vdot": 0.0, "rdot": 0.0}
        moved = {"u": u, "v": v, "r": r, "phi": phi, **still}
        hull_force = forces(hull, {key: np.array([value]) for key, value in moved.items()})
        X, Y, N = rudder(hull, u, v, r, n, laid(t))
        X += float(hull_force["X"][0]) + (1 - hull.steering.t) * thrust(hull, u, n)
        Y += float(hull_force["Y"][0])
        N += float(hull_force["N"][0])
        weight = RHO * GRAVITY * hull.volume
        K = float(hull_force["K"][0]) - weight * hull.GM * phi - hull.damping * p
        udot, vdot, rdot, pdot = accelerations(hull, u, v, r, (X, Y, N, K))
        xdot = u * math.cos(psi) - v * math.sin(psi)
        ydot = u * math.sin(psi) + v * math.cos(psi)
        return [udot, vdot, rdot, pdot, p, xdot, ydot, r]

    end = duration or 60 * hull.L / speed
    times = np.linspace(0, end, 2001)
    start = [speed, 0, 0, 0, 0, 0, 0, 0]
    state = solve_ivp(rates, (0, end), start, t_eval=times, rtol=1e-8, atol=1e-9).y
    x, y, psi = state[5], state[6], state[7]
    turned = np.abs(psi)
    return Turn(
        t=times,
        x=x,
        y=y,
        psi=psi,
        delta=np.array([laid(t) for t in times]),
        n=n,
        advance=float(np.interp(math.pi / 2, turned, x)) / hull.L,
        tactical_diameter=float(np.interp(math.pi, turned, np.abs(y))) / hull.L,
        heel_deg=float(np.degrees(state[4][-1])),
    )


def accelerations(
    hull: Hull, u: float, v: float, r: float, force: tuple[float, float, float, float]
) -> tuple[float, float, float, float]:
    """u̇, v̇, ṙ and ṗ from the forces [N, N m] at no acceleration."""
    X, Y, N, K = force
    area = 0.5 * RHO * hull.L**3
    added = {name: area * hull.truth.get(name, 0.0) for name in ("Xudot", "Yvdot")}
    yaw_in_sway = area * hull.L * hull.truth.get("Yrdot", 0.0)
    sway_in_yaw = area * hull.L * hull.truth.get("Nvdot", 0.0)
    sway_in_roll = area * hull.L * hull.truth.get("Kvdot", 0.0)
    own_yaw = area * hull.L**2 * hull.truth.get("Nrdot", 0.0)
    m, xG, zG = hull.mass, hull.xG, hull.zG
    udot = (X + m * (v * r + xG * r * r)) / (m - added["Xudot"])
    matrix = np.array(
        [
            [m - added["Yvdot"], m * xG - yaw_in_sway, -m * zG],
            [m * xG - sway_in_yaw, hull.Izz - own_yaw, 0.0],
            [-m * zG - sway_in_roll, 0.0, hull.Ix],
        ]
    )
    right = np.array([Y - m * u * r, N - m * xG * u * r, K + m * zG * u * r])
    if not hull.rolls:
        vdot, rdot = np.linalg.solve(matrix[:2, :2], right[:2])
        return udot, float(vdot), float(rdot), 0.0
    vdot, rdot, pdot = np.linalg.solve(matrix, right)
    return udot, float(vdot), float(rdot), float(pdot)


TANKER = Hull(
    name="coaster",
    L=4.0,
    B=0.7,
    d=0.25,
    volume=0.4504,
    mass=450.0,
    Izz=451.62,
    xG=0.06,
    steering=Steering(
        D=0.16, t=0.20, wp=0.30, kt=(0.34, -0.26, -0.14), area=0.0196, lift_slope=2.8, eta=0.8,
        epsilon=1.0, kappa=0.5, gamma=0.4, lR=-0.85, tR=0.25, aH=0.28, xH=-0.45, rate_deg_s=16.0,
    ),
    truth={
        "Xuu": -1.9e-3, "Xvv": -3.0e-3, "Xvr": 7.5e-3, "Xrr": 0.3e-3, "Xudot": -0.9e-3,
        "Yv": -15e-3, "Yvvv": -60e-3, "Yr": 3.2e-3, "Yrrr": 1.5e-3, "Yvvr": 10e-3, "Yvrr": -30e-3,
        "Yvdot": -9.5e-3, "Yrdot": -0.4e-3,
        "Nv": -5.0e-3, "Nvvv": -6e-3, "Nr": -2.6e-3, "Nrrr": -1.0e-3, "Nvvr": -25e-3,
        "Nvrr": 3e-3, "Nvdot": -0.35e-3, "Nrdot": -0.55e-3,
    },
)  # fmt: skip
"""A full coaster of 4 m."""

CONTAINER = Hull(
    name="container feeder",
    L=5.2,
    B=0.78,
    d=0.27,
    volume=0.630,
    mass=629.4,
    Izz=1064.0,
    xG=-0.08,
    zG=-0.04,
    GM=0.035,
    Ix=52.0,
    damping=13.0,
    steering=Steering(
        D=0.18, t=0.18, wp=0.26, kt=(0.42, -0.28, -0.15), area=0.0258, lift_slope=2.7, eta=0.85,
        epsilon=1.0, kappa=0.55, gamma=0.38, lR=-0.9, tR=0.24, aH=0.25, xH=-0.46, rate_deg_s=15.0,
    ),
    truth={
        "Xuu": -1.3e-3, "Xvv": -3.4e-3, "Xvr": 4.5e-3, "Xrr": 0.2e-3, "Xff": -0.2e-3,
        "Xudot": -0.4e-3,
        "Yv": -11.4e-3, "Yvvv": -90e-3, "Yr": 2.4e-3, "Yrrr": 1.6e-3, "Yvvr": 18e-3,
        "Yvrr": -38e-3, "Yf": -0.1e-3, "Yvvf": 5e-3, "Yvff": -6e-3, "Yrrf": 1.5e-3, "Yrff": -2e-3,
        "Yvdot": -7.2e-3, "Yrdot": -0.3e-3,
        "Nv": -3.7e-3, "Nvvv": -2e-3, "Nr": -2.1e-3, "Nrrr": -2.1e-3, "Nvvr": -36e-3,
        "Nvrr": 2e-3, "Nf": -0.12e-3, "Nvvf": -1.5e-3, "Nvff": -2.5e-3, "Nrrf": -0.9e-3,
        "Nrff": 0.8e-3, "Nvdot": -0.3e-3, "Nrdot": -0.42e-3,
        "Kv": 0.26e-3, "Kvvv": 2.2e-3, "Kr": -0.06e-3, "Krrr": -0.05e-3, "Kvvr": -0.5e-3,
        "Kvrr": 0.9e-3, "Kf": -0.02e-3, "Kvvf": 0.1e-3, "Kvff": 0.15e-3, "Krrf": -0.05e-3,
        "Krff": 0.06e-3, "Kvdot": 0.15e-3,
    },
)  # fmt: skip
"""A container feeder of 5.2 m that heels in her turns."""
