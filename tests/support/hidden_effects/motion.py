"""How the model really moves, exact in every angle, with whatever the rig does wrong."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .programmes import Plan
from .sizes import REFERENCE_FROUDE, SHIP, WATER

Array = NDArray[np.float64]
YAW_TESTS = ("pure_yaw", "yaw_drift")


@dataclass(frozen=True, kw_only=True)
class Rig:
    """What the rig does other than stated.

    Parameters
    ----------
    heading : float
        Model turned in its mount, its gauges with it, to starboard [rad].
    speed : float
        Share by which the carriage is faster than stated, at `fast_speed` only.
    stroke : float
        Share by which the PMM's sway and yaw strokes are longer than stated.
    mistiming : float
        Phase by which the sway drive leads the yaw drive [rad].
    current : float
        Velocity of the water across the tank, to starboard [m/s].
    """

    heading: float = 0.0
    speed: float = 0.0
    fast_speed: float = 2.0
    stroke: float = 0.0
    mistiming: float = 0.0
    current: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Motion:
    """Motion of midship through the water along a record, ship axes, SI.

    `ax`, `ay` are the components of its acceleration in space, `y` its lateral place in the tank,
    `ydot` its lateral velocity over ground.
    """

    t: Array
    u: Array
    v: Array
    r: Array
    udot: Array
    vdot: Array
    rdot: Array
    ax: Array
    ay: Array
    y: Array
    ydot: Array
    psi: Array
    delta: float
    carriage: float
    plan: Plan
    phi: Array = field(default_factory=lambda: np.zeros(1))

    @cached_property
    def U(self) -> Array:
        return np.hypot(self.u, self.v)

    @cached_property
    def up(self) -> Array:
        return self.u / self.U

    @cached_property
    def vp(self) -> Array:
        return self.v / self.U

    @cached_property
    def rp(self) -> Array:
        return self.r * SHIP.L / self.U

    @cached_property
    def ud(self) -> Array:
        return self.udot * SHIP.L / self.U**2

    @cached_property
    def vd(self) -> Array:
        return self.vdot * SHIP.L / self.U**2

    @cached_property
    def rd(self) -> Array:
        return self.rdot * SHIP.L**2 / self.U**2

    @cached_property
    def q(self) -> Array:
        """½ρL²U² with the instantaneous speed [N]."""
        return 0.5 * WATER.rho * SHIP.L**2 * self.U**2

    @property
    def froude(self) -> float:
        """Froude number of the carriage's true speed."""
        return self.carriage / (WATER.g * SHIP.L) ** 0.5

    @property
    def F(self) -> float:
        return (self.froude / REFERENCE_FROUDE) ** 2 - 1

    @property
    def dt(self) -> float:
        return float(self.t[1] - self.t[0])

    def moved(self, other: Motion, share: float) -> Motion:
        """This motion and a share of the way to another: the argument of a linearisation."""
        names = ("u", "v", "r", "udot", "vdot", "rdot")
        mixed = {
            n: getattr(self, n) + share * (getattr(other, n) - getattr(self, n)) for n in names
        }
        return replace(self, **mixed)


def motion_of(plan: Plan, t: Array, rig: Rig | None = None) -> Motion:
    """Motion of a run at times t.

    Tank axes: x along the rails, y to starboard. Pure sway y = a sin ωt; yaw tests
    ψ = ψ0 sin ωt on the path dy/dt = Uc tan ψ; sway with yaw y = a sin ωt, ψ = -ψ0 cos ωt;
    heading ψ + β. The rig keeps to this path whatever the carriage's true speed.
    """
    rig = rig or Rig()
    carriage = plan.speed
    if abs(plan.speed - rig.fast_speed) < 1e-9:
        carriage *= 1 + rig.speed
    theta, omega = plan.omega * t, plan.omega
    lead = theta + rig.mistiming
    stroke = 1 + rig.stroke
    zero = np.zeros_like(t)
    psi, r, rdot, y, ydot, yddot = zero, zero, zero, zero, zero, zero
    if plan.test in YAW_TESTS:
        size = plan.yaw * stroke
        psi, r, rdot = _sine(size, omega, theta)
        path, rate, _ = _sine(size, omega, lead)
        ydot, yddot = plan.speed * np.tan(path), plan.speed * rate / np.cos(path) ** 2
        y = -plan.speed * size / omega * np.cos(lead)
    elif plan.test == "pure_sway":
        y, ydot, yddot = _sine(plan.sway * stroke, omega, theta)
    elif plan.test == "sway_yaw":
        y, ydot, yddot = _sine(plan.sway * stroke, omega, lead)
        psi, r, rdot = _sine(plan.yaw * stroke, omega, theta - np.pi / 2)
    psi = psi + plan.drift + rig.heading
    cosine, sine = np.cos(psi), np.sin(psi)
    across = ydot - rig.current
    u, v = carriage * cosine + across * sine, -carriage * sine + across * cosine
    ax, ay = yddot * sine, yddot * cosine
    return Motion(
        t=t,
        u=u,
        v=v,
        r=r,
        udot=ax + r * v,
        vdot=ay - r * u,
        rdot=rdot,
        ax=ax,
        ay=ay,
        y=y,
        ydot=ydot,
        psi=psi,
        delta=plan.rudder,
        carriage=carriage,
        plan=plan,
    )


def _sine(size: float, omega: float, theta: Array) -> tuple[Array, Array, Array]:
    """size·sin θ and its two derivatives."""
    sine = np.sin(theta)
    return size * sine, size * omega * np.cos(theta), -size * omega**2 * sine
