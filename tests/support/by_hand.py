"""What a faulty laboratory would have written down, from the exact motion of the tests' tank.

Nothing here is the package's: the forces are `hull_force`, the motions `motion_of`, both of the
virtual tank, and each fault is one line of mechanics.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from tests.support.hidden_effects.hull import hull_force
from tests.support.hidden_effects.motion import Motion, Rig, motion_of
from tests.support.hidden_effects.programmes import Plan
from tests.support.hidden_effects.sizes import SHIP

Array = np.ndarray
Shown = Mapping[str, Array]


def forces(m: Motion) -> dict[str, Array]:
    """Histories of the forces of the water on the hull of the tank."""
    return {name: np.broadcast_to(x, m.t.shape) * 1.0 for name, x in hull_force(m).items()}


def misaligned(plan: Plan, t: Array, degrees: float) -> Shown:
    """The heading is larger than stated, the path the same."""
    return forces(motion_of(plan, t, Rig(heading=math.radians(degrees))))


def longer_sway(plan: Plan, t: Array, share: float) -> Shown:
    """The sway carriage travels further, the heading swings as stated."""
    return forces(motion_of(replace(plan, sway=plan.sway * (1 + share)), t))


def longer_strokes(plan: Plan, t: Array, share: float) -> Shown:
    """Sway and heading swing further, the path of pure yaw with them."""
    return forces(motion_of(plan, t, Rig(stroke=share)))


def late(plan: Plan, t: Array, seconds: float) -> Shown:
    """What is shown at t happened before."""
    return forces(motion_of(plan, t - seconds if plan.dynamic else t))


def behind_a_filter(plan: Plan, t: Array, seconds: float) -> Shown:
    """T y' + y = x, settled, by complex amplitudes over whole cycles of the samples."""
    shown = forces(motion_of(plan, t))
    if not plan.dynamic:
        return shown
    w = 2 * np.pi * np.fft.rfftfreq(len(t), t[1] - t[0])
    return {
        name: np.fft.irfft(np.fft.rfft(x) / (1 + 1j * w * seconds), len(t))
        for name, x in shown.items()
    }


def motion_of_a_point(plan: Plan, t: Array, x_over_L: float) -> Shown:
    """The stated motion is that of a point forward of midship: there v = v(midship) + x r."""
    m, x = motion_of(plan, t), x_over_L * SHIP.L
    return forces(replace(m, v=m.v - x * m.r, vdot=m.vdot - x * m.rdot))


def moments_about_a_point(plan: Plan, t: Array, x_over_L: float) -> Shown:
    """A force Y at a place a forward of midship has the moment (a - x) Y about x."""
    shown = forces(motion_of(plan, t))
    return {**shown, "N": shown["N"] - x_over_L * SHIP.L * shown["Y"]}


def larger_side_force(plan: Plan, t: Array, share: float) -> Shown:
    """The gauge of Y shows too much."""
    shown = forces(motion_of(plan, t))
    return {**shown, "Y": (1 + share) * shown["Y"]}


def side_force_in_x(plan: Plan, t: Array, share: float) -> Shown:
    """A part of Y stands in X."""
    shown = forces(motion_of(plan, t))
    return {**shown, "X": shown["X"] + share * shown["Y"]}


def weight_left_in(plan: Plan, t: Array, share: float) -> Shown:
    """A mass at midship that nobody takes off: the gauges carry it, F - m a."""
    m, mass = motion_of(plan, t), share * SHIP.mass
    shown = forces(m)
    return {**shown, "X": shown["X"] - mass * m.ax, "Y": shown["Y"] - mass * m.ay}


def drifting_water(plan: Plan, t: Array, speed: float) -> Shown:
    """Water that moves to starboard."""
    return forces(motion_of(plan, t, Rig(current=speed)))


BY_HAND: Mapping[str, Callable[[Plan, Array, float], Shown]] = {
    "fault_misalignment": misaligned,
    "fault_pmm_amplitude": longer_sway,
    "fault_time_lag": late,
    "fault_motion_point": motion_of_a_point,
    "fault_moment_point": moments_about_a_point,
    "fault_gauge_gain": larger_side_force,
    "fault_cross_talk": side_force_in_x,
    "fault_inertia": weight_left_in,
    "current": drifting_water,
}
"""By fault of the catalogue, what its first coefficient does."""
