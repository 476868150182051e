"""Eight more effects that stand in no catalogue, of other kinds than those of `outside`."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .catalogue import Source
from .hull import Force, hull_force, prime
from .motion import Array, Motion
from .sizes import SHIP, scale


def _change(m: Motion, other: Motion) -> Force:
    """What the hull feels of another motion beside this one."""
    now, then = hull_force(m), hull_force(other)
    return {name: then[name] - now[name] for name in now}


def beyond_vortex_burst(m: Motion) -> Force:
    """Bilge vortices that burst near 9° of drift: side force is lost there, and only there."""
    lost = m.vp * np.exp(-(((abs(m.vp) - 0.155) / 0.045) ** 2))
    return prime(m, Y=0.0022 * lost, N=-0.0009 * lost)


def beyond_stiff_gauge(m: Motion) -> Force:
    """A gauge for Y that reads more the larger the force: a cubic in newtons."""
    Y = hull_force(m)["Y"]
    return {"Y": 0.008 * (Y / scale("Y")) ** 2 * Y}


def beyond_second_balance(m: Motion) -> Force:
    """Oscillating tests made on another balance, whose N reads 6 % less."""
    return {"N": -0.06 * hull_force(m)["N"]} if m.plan.dynamic else {}


def beyond_slack_turntable(m: Motion) -> Force:
    """Lost motion of the turntable: every steady drift angle is 0.25° smaller than it reads."""
    if m.plan.dynamic or not m.plan.drift:
        return {}
    turn = np.radians(0.25) * np.sign(m.plan.drift)
    u, v = m.u - turn * m.v, m.v + turn * m.u
    return _change(m, replace(m, u=u, v=v))


def beyond_sheared_tank(m: Motion) -> Force:
    """Water that flows faster on one side of the tank: speed changes with the place across it."""
    faster = 1.0 + 0.06 * m.y / SHIP.L
    return _change(m, replace(m, u=m.u * faster, v=m.v * faster))


def _transported(x: Array, dt: float, delay: float) -> Array:
    """A history that arrives later, as it was."""
    t = np.arange(len(x)) * dt
    return np.interp(t - delay, t, x)


def beyond_transported_drag(m: Motion) -> Force:
    """Drag of eddies that are felt at the stern when they arrive there: a pure delay."""
    if not m.plan.dynamic:
        return {}
    drag = m.vp * abs(m.vp)
    late = _transported(drag, m.dt, 0.6 * SHIP.L / m.carriage) - drag
    return prime(m, Y=-0.016 * late, N=0.007 * late)


def beyond_laminar_hull(m: Motion) -> Force:
    """A laminar boundary layer at the lowest speed: 8 % of the side force of drift is not there."""
    if m.carriage > 1.2:
        return {}
    return prime(m, Y=0.08 * 0.0116 * m.vp, N=-0.08 * 0.0038545 * m.vp)


def beyond_one_bilge_keel(m: Motion) -> Force:
    """A bilge keel left on one side only: drag of sway to starboard."""
    keel = np.maximum(m.vp, 0.0) ** 2
    return prime(m, Y=-0.009 * keel, N=-0.002 * keel)


FORCES: dict[str, Source] = {
    function.__name__: function
    for function in (
        beyond_vortex_burst,
        beyond_stiff_gauge,
        beyond_second_balance,
        beyond_slack_turntable,
        beyond_sheared_tank,
        beyond_transported_drag,
        beyond_laminar_hull,
        beyond_one_bilge_keel,
    )
}
