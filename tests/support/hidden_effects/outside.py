"""Effects that stand in no catalogue: the right answer to them is that nothing known fits."""

from __future__ import annotations

import numpy as np

from .catalogue import Source
from .hull import TRUTH, Force, one_pole, prime
from .motion import Array, Motion
from .sizes import SHIP, WATER


def outside_wall_spring(m: Motion) -> Force:
    """Suction of the nearer wall: with the place across the tank, whatever the frequency."""
    return prime(m, Y=1.7e-3 * m.y / SHIP.L, N=-0.5e-3 * m.y / SHIP.L)


def _play(x: Array, width: float) -> Array:
    """Play operator (backlash): rate-independent, started in the middle of its gap."""
    state, out = x[0], np.empty_like(x)
    for k, value in enumerate(x.tolist()):
        state = min(max(state, value - width), value + width)
        out[k] = state
    return out


def outside_hysteresis(m: Motion) -> Force:
    """Separation that stays where it was: a loop against sway, the same at any frequency."""
    if not m.plan.dynamic:
        return {}
    loop = _play(m.vp, 0.06) - m.vp
    return prime(m, Y=-0.0045 * loop, N=-0.0012 * loop)


def outside_even_vr(m: Motion) -> Force:
    """A force |v|r, odd in turning, even in drift and of second order."""
    swing = abs(m.vp) * m.rp
    return prime(m, Y=0.0022 * swing, N=-0.0019 * swing)


def outside_sinkage(m: Motion) -> Force:
    """Hull sucked down by its own crossflow at speed: side force by Fn² v² on top of the sway."""
    deeper = 55 * m.froude**2 * (m.vp**2 + 0.1 * m.rp**2)
    return prime(
        m,
        X=-0.0005 * deeper,
        Y=-0.0116 * m.vp * deeper + 0.0022 * m.rp * deeper,
        N=-0.0039 * m.vp * deeper,
    )


def outside_vr3(m: Motion) -> Force:
    """Terms v r³: in surge as it stands, in sway with the modulus that symmetry asks for."""
    return prime(m, X=0.012 * m.vp * m.rp**3, Y=-0.055 * m.vp * abs(m.rp) ** 3)


def outside_sloshing(m: Motion) -> Force:
    """The tank sloshing at 0.37 Hz, in every record, each with its own phase; in newtons."""
    phase = 2.4 * sum(map(ord, m.plan.id))
    wave = np.cos(2 * np.pi * 0.37 * m.t + phase)
    return {"Y": 2.6 * wave, "N": 1.7 * wave}


def outside_mount_friction(m: Motion) -> Force:
    """Dry friction of the sway guide against the motion across the tank; in newtons."""
    rub = -np.tanh(m.ydot / 0.008)
    return {"Y": 2.2 * rub}


def outside_acceleration_drag(m: Motion) -> Force:
    """Drag of the waves that swinging sends out: the square of the acceleration in space."""
    return {"X": -900.0 * (m.ay / WATER.g) ** 2}


def outside_yaw_memory(m: Motion) -> Force:
    """A fifth of the damping of yaw that builds up over half a ship length."""
    late = one_pole(m.rp, m.dt, 0.46 * SHIP.L / m.carriage) - m.rp
    return prime(m, **{a: 0.2 * TRUTH[f"{a}r"] * late for a in "YN"})


def outside_onset(m: Motion) -> Force:
    """Separation at the bilge that sets in at 7° of drift and is not there below."""
    beyond = np.sign(m.vp) * np.maximum(abs(m.vp) - 0.12, 0.0)
    return prime(m, Y=-0.010 * beyond, N=0.002 * beyond)


def outside_pushed_carriage(m: Motion) -> Force:
    """A carriage pushed by the reaction of the sway drive: drag follows its acceleration."""
    return {"X": -60.0 * m.ay / WATER.g}


FORCES: dict[str, Source] = {
    function.__name__: function
    for function in (
        outside_wall_spring,
        outside_hysteresis,
        outside_even_vr,
        outside_sinkage,
        outside_vr3,
        outside_sloshing,
        outside_mount_friction,
        outside_acceleration_drag,
        outside_yaw_memory,
        outside_onset,
        outside_pushed_carriage,
    )
}


def dead_zone(force: Array, half_width: float) -> Array:
    """Slack in the sway link: nothing is felt until the slack is taken up."""
    return force - np.clip(force, -half_width, half_width)
