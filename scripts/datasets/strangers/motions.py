"""What a towing tank, a rotating arm and a moving mesh do with a hull: exact motions of midship."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from scripts.datasets.strangers.hulls import Array, Motion

Driven = Callable[[Array], Motion]


def _motion(t: Array, **given: float | Array) -> Motion:
    names = ("u", "v", "r", "udot", "vdot", "rdot", "phi", "psi", "y")
    return {name: np.zeros_like(t) + given.get(name, 0.0) for name in names}


def drift(speed: float, beta: float, heel: float = 0.0) -> Driven:
    """Straight along the tank with the bow `beta` degrees to starboard of the way."""
    angle = np.radians(beta)

    def driven(t: Array) -> Motion:
        return _motion(
            t,
            u=speed * np.cos(angle),
            v=-speed * np.sin(angle),
            phi=np.radians(heel),
            psi=angle,
        )

    return driven


def circle(speed: float, radius: float, beta: float = 0.0) -> Driven:
    """Round the tank on an arm [m], to starboard where the radius is positive."""
    angle = np.radians(beta)

    def driven(t: Array) -> Motion:
        return _motion(
            t, u=speed * np.cos(angle), v=-speed * np.sin(angle), r=speed / radius, psi=angle
        )

    return driven


def sway(speed: float, period: float, amplitude: float) -> Driven:
    """y = a sin ωt, heading along the tank."""
    omega = 2 * np.pi / period

    def driven(t: Array) -> Motion:
        return _motion(
            t,
            u=speed,
            v=amplitude * omega * np.cos(omega * t),
            vdot=-amplitude * omega**2 * np.sin(omega * t),
            y=amplitude * np.sin(omega * t),
        )

    return driven


def yaw(
    speed: float, period: float, heading: float, beta: float = 0.0, heel: float = 0.0
) -> Driven:
    """ψ = ψ₀ sin ωt [deg] along the path whose tangent that is, with a drift angle [deg]."""
    omega, top, angle = 2 * np.pi / period, np.radians(heading), np.radians(beta)

    def driven(t: Array) -> Motion:
        psi, r = top * np.sin(omega * t), top * omega * np.cos(omega * t)
        along = speed / np.cos(psi)
        faster = along * np.tan(psi) * r
        return _motion(
            t,
            u=along * np.cos(angle),
            v=-along * np.sin(angle),
            r=r,
            udot=faster * np.cos(angle),
            vdot=-faster * np.sin(angle),
            rdot=-top * omega**2 * np.sin(omega * t),
            phi=np.radians(heel),
            psi=psi + angle,
            y=_path(speed * np.tan(psi), t),
        )

    return driven


def _path(rate: Array, t: Array) -> Array:
    """The way across the tank, by trapezoids, from the middle of its swing."""
    steps = 0.5 * (rate[1:] + rate[:-1]) * np.diff(t)
    path = np.concatenate([np.zeros(1), np.cumsum(steps)])
    return path - 0.5 * (path.max() + path.min())
