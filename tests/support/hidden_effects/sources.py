"""Table 2: the same effects put in at a physical source that no catalogue writes down.

Constants were chosen so that each force has, at size 1, about the rms of the catalogue's form over
the runs where that acts (within 20 %, channels weighted by their scale; `test_hidden_tank.py`
holds it). Faults of the motion are exact here (`motion.Rig`): nothing to add.
"""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from .catalogue import Source
from .hull import TRUTH, Force, one_pole, prime, stations
from .motion import Array, Motion
from .sizes import REFERENCE_FROUDE, SHIP


def _local(m: Motion, x: Array) -> Array:
    """Crossflow v + xr over the speed, a column per station."""
    return m.vp[:, None] + m.rp[:, None] * x


def modulus_sway_drag(m: Motion) -> Force:
    """Drag of a deep keel on the after half: a plate in crossflow, strip by strip."""
    x, weight = stations(-0.45, 0.05, 8)
    w = _local(m, x)
    drag = -0.0404 * w * np.sqrt(w**2 + 0.015**2)
    return prime(m, Y=drag @ weight, N=drag @ (weight * x))


def modulus_yaw_drag(m: Motion) -> Force:
    """Drag of forefoot and skeg swinging sideways; sway only adds to the speed they feel."""
    Y, N = 0.0, 0.0
    for x, strength in ((0.45, 0.0036), (-0.45, 0.0136)):
        swing = x * m.rp
        drag = -strength * swing * np.sqrt(swing**2 + (0.35 * m.vp) ** 2)
        Y, N = Y + drag, N + x * drag
    return prime(m, Y=Y, N=N)


_SECTION_X = np.array([-0.5, -0.42, -0.3, -0.1, 0.1, 0.3, 0.42, 0.5])
_SECTION_CD = np.array([1.05, 0.90, 0.55, 0.46, 0.44, 0.50, 0.72, 0.80])


def crossflow_drag(m: Motion) -> Force:
    """Strip drag with section coefficients read from a table, falling with Reynolds number.

    After Hooft 1994: fuller sections amidships, sharp ones at the ends; CD ∝ |w|^-0.08.
    """
    x, weight = stations()
    coefficient = 0.86 * np.interp(x, _SECTION_X, _SECTION_CD)
    w = _local(m, x)
    drag = -coefficient * SHIP.d / SHIP.L * w * abs(w) * (abs(w) + 0.01) ** -0.08
    return prime(m, Y=drag @ weight, N=drag @ (weight * x))


def yaw_sway_coupling(m: Motion) -> Force:
    """What drift and turning make together: strip drag of both less that of each alone."""
    x, weight = stations()
    strength = 0.058 * (1 - 0.35 * x)
    v, swing = m.vp[:, None], m.rp[:, None] * x
    both = _drag(v + swing) - _drag(v) - _drag(swing)
    drag = -strength * both
    return prime(m, Y=drag @ weight, N=drag @ (weight * x))


def _drag(w: Array) -> Array:
    return w * np.sqrt(w**2 + 0.03**2)


def surge_yaw_coupling(m: Motion) -> Force:
    """Coriolis force of the sway added mass, strip by strip, cut by 44 % for separation."""
    x, weight = stations()
    added = -TRUTH["Yvdot"] * 1.5 * (1 - (2 * x - 0.04) ** 2)
    sway = (m.v[:, None] + m.r[:, None] * x * SHIP.L) @ (weight * added)
    return {"X": 0.56 * m.q / m.U**2 * SHIP.L * sway * m.r}


def surge_fourth_order(m: Motion) -> Force:
    """Suction of the bow shoulder that sets in with drift, √(1 + (v/v0)⁴) - 1."""
    return prime(m, X=1.72e-4 * (np.sqrt(1 + (m.vp / 0.19) ** 4) - 1))


def _waves(m: Motion) -> float:
    """Growth of the ship's own wave with speed over its reference; zero at Fn 0.217."""
    return float(np.expm1(9 * (m.froude**2 - REFERENCE_FROUDE**2)) / (9 * REFERENCE_FROUDE**2))


def froude_linear(m: Motion) -> Force:
    """Lift of a hull that sits deeper and trims by the bow wave: Y, N of fore and after body."""
    growth = _waves(m)
    fore, aft = m.vp + 0.31 * m.rp, m.vp - 0.36 * m.rp
    lift_fore = -0.00048 * growth * m.up * fore
    lift_aft = -0.00055 * growth * m.up * aft
    turning = -0.00046 * growth * m.rp
    return prime(
        m,
        Y=lift_fore + lift_aft + turning,
        N=0.38 * lift_fore - 0.68 * lift_aft - 0.00005 * growth * m.rp,
    )


def froude_nonlinear(m: Motion) -> Force:
    """Separated drag that grows with the wave trough amidships, a broken power of crossflow."""
    growth = _waves(m)
    sway, turn = m.vp * abs(m.vp) ** 1.7, m.rp * abs(m.rp) ** 1.7
    return prime(
        m, Y=growth * (-0.0205 * sway + 0.0031 * turn), N=growth * (0.0004 * sway - 0.00062 * turn)
    )


def resistance_curve(m: Motion) -> Force:
    """Wave resistance A exp(-b/Fn²) with a little interference, over that at Fn 0.217."""

    def waves(froude: float) -> float:
        return np.exp(-0.15 / froude**2) * (1 + 0.08 * np.cos(1 / froude**2))

    return prime(m, X=-3.6e-4 * (waves(m.froude) - waves(REFERENCE_FROUDE)))


def asymmetry(m: Motion) -> Force:
    """Side force of a right-handed screw at x = -0.47 L, with the wake it works in."""
    inflow = m.up * (1 - 0.3 * np.exp(-4 * (m.vp - 0.47 * m.rp) ** 2)) / 0.7
    side = 0.98e-4 * inflow**2
    return prime(m, Y=side, N=-0.47 * side)


def even_hull_terms(m: Motion) -> Force:
    """Port side rougher at the ends than starboard: drag differs with the side of the flow."""
    Y, N = 0.0, 0.0
    for x, strength in ((0.45, 0.0018), (-0.45, 0.00165)):
        w = m.vp + x * m.rp
        push = strength * abs(w) ** 1.9
        Y, N = Y + push, N + x * push
    return prime(m, Y=Y, N=N)


def memory(m: Motion) -> Force:
    """Lift that builds up as after Wagner: two exponentials of the distance run, integrated."""
    unit = SHIP.L / m.carriage
    v = m.v / m.carriage
    late = 0.62 * one_pole(v, m.dt, 0.17 * unit) + 0.38 * one_pole(v, m.dt, 0.55 * unit) - v
    return prime(m, **{a: 0.2 * TRUTH[f"{a}v"] * late for a in "YN"})


def lagged_crossflow(m: Motion) -> Force:
    """Separated force following its steady value the faster the stronger the crossflow is."""
    target = m.vp**3
    if not m.plan.dynamic:
        return {}
    rate = m.carriage / SHIP.L * (1.35 + 5.5 * abs(m.vp))
    fade = np.exp(-rate * m.dt)
    state, force = target[0], np.empty_like(target)
    for k, (keep, aim) in enumerate(zip(fade.tolist(), target.tolist(), strict=True)):
        state = keep * state + (1 - keep) * aim
        force[k] = state
    late = 0.95 * (force - target)
    return prime(m, **{a: TRUTH[f"{a}vvv"] * late for a in "YN"})


def nonlinear_added_mass(m: Motion) -> Force:
    """Rate of a momentum a(v)·v whose added mass a rises with sway and levels off."""
    if not m.plan.dynamic:
        return {}
    momentum = 0.0072 * m.vp**3 / (1 + 2.5 * m.vp**2)
    rate = np.gradient(momentum, m.dt, edge_order=2) * SHIP.L / m.U
    return prime(m, Y=-rate, N=-0.2 * rate)


def heel_coupling(m: Motion) -> Force:
    """A heeled hull as a cambered one: suction ∝ u² of each section, pressure ∝ its crossflow²."""
    x, weight = stations()
    w = _local(m, x)
    camber = np.sin(m.phi) * np.cos(m.phi)
    ahead = -(3.9e-4 + 3.6e-3 * x)
    aside = -0.19 * x
    line = camber[:, None] * (m.up[:, None] ** 2 * ahead + w**2 * aside)
    return prime(m, Y=line @ weight, N=line @ (weight * x))


def _bent(angle: Array | float, stall: float) -> Array | float:
    """A lift curve of unit slope that bends over at an angle."""
    return angle / (1 + (abs(angle) / stall) ** 4) ** 0.25


def _over_zero(force, delta: float):
    """What a deflection adds to the force of the rudder amidships, which the hull's terms hold."""
    return force(delta) - force(0.0)


def rudder_stall(m: Motion) -> Force:
    """Lift curve of the rudder bending over, angle of attack with the flow at the stern."""
    inflow = 0.3 * (m.vp - 0.5 * m.rp)
    loss = _over_zero(lambda d: _bent(d + inflow, 0.335) - (d + inflow), m.delta)
    return prime(m, Y=TRUTH["Yd"] * loss, N=TRUTH["Nd"] * loss)


def rudder_cross_terms(m: Motion) -> Force:
    """Rudder in a wake that thins in drift, struck at the angle of the flow there.

    Only what drift and rudder make together: the force of both less that of each alone.
    """
    side = m.vp - 0.5 * m.rp

    def force(d: float, side: Array | float):
        wake = 0.50 * np.exp(-12 * side**2)
        speed = ((1 - wake) / 0.50) ** 2
        return speed * 0.33 * np.tanh((d + 1.15 * side) / 0.33)

    both = _over_zero(lambda d: force(d, side), m.delta)
    alone = _over_zero(lambda d: force(d, 0.0), m.delta)
    return prime(m, Y=TRUTH["Yd"] * (both - alone), N=TRUTH["Nd"] * (both - alone))


FORCES: dict[str, Source] = {
    function.__name__: function
    for function in (
        modulus_sway_drag,
        modulus_yaw_drag,
        crossflow_drag,
        yaw_sway_coupling,
        surge_yaw_coupling,
        surge_fourth_order,
        froude_linear,
        froude_nonlinear,
        resistance_curve,
        asymmetry,
        even_hull_terms,
        memory,
        lagged_crossflow,
        nonlinear_added_mass,
        heel_coupling,
        rudder_stall,
        rudder_cross_terms,
    )
}
"""Forces at size 1, of the true motion."""


def digital_filter(x: Array, t: Array, lag: float, rate: float = 50.0) -> Array:
    """A data logger's y += α(x - y) at its own sample rate [1/s], read at the times asked for."""
    clock = np.arange(t[0], t[-1] + 1 / rate, 1 / rate)
    alpha = 1 - np.exp(-1 / (rate * lag))
    fed = np.interp(clock, t, x)
    y, _ = lfilter([alpha], [1.0, alpha - 1], fed, zi=[(1 - alpha) * fed[0]])
    return np.interp(t, clock, y)
