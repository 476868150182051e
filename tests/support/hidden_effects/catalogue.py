"""Table 1: every effect in the form a catalogue writes it, with the coefficients of `sizes.toml`.

Physics: monomials of prime velocities with the instantaneous speed. Faults of the motion: the
first-order change of the hull's force. Faults of the gauges: see `gauges`, the same in both truths
where a fault has but one form. Coefficients grow with the size factor, nonlinear parameters do not.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from .hull import TRUTH, Force, add, along, one_pole, prime, stations, times
from .motion import Array, Motion, Rig, motion_of
from .sizes import SHIP, SIZES

Source = Callable[[Motion], Force]

_MONOMIALS: dict[str, Callable[[Motion], Array | float]] = {
    "0": lambda m: 1.0,
    "v": lambda m: m.vp,
    "r": lambda m: m.rp,
    "vv": lambda m: m.vp**2,
    "rr": lambda m: m.rp**2,
    "vr": lambda m: m.vp * m.rp,
    "v|v|": lambda m: m.vp * abs(m.vp),
    "r|r|": lambda m: m.rp * abs(m.rp),
    "vvv": lambda m: m.vp**3,
    "rrr": lambda m: m.rp**3,
    "vvr": lambda m: m.vp**2 * m.rp,
    "vrr": lambda m: m.vp * m.rp**2,
    "vvvv": lambda m: m.vp**4,
    "vvvdot": lambda m: m.vp**2 * m.vd,
    "phi": lambda m: m.phi,
    "vphiphi": lambda m: m.vp * m.phi**2,
    "vvphi": lambda m: m.vp**2 * m.phi,
    "ddd": lambda m: m.delta**3,
    "vvd": lambda m: m.vp**2 * m.delta,
    "vdd": lambda m: m.vp * m.delta**2,
}


def _polynomial(effect: str, factor: Callable[[Motion], float] = lambda m: 1.0) -> Source:
    terms = [(name[0], _MONOMIALS[name[1:]], value) for name, value in SIZES[effect].items()]

    def force(m: Motion) -> Force:
        return add(*(prime(m, **{ch: factor(m) * value * term(m)}) for ch, term, value in terms))

    return force


def crossflow_drag(m: Motion) -> Force:
    """Strip drag -CD d/L ∫(1 + p(2x)²)/(1 + p/3) |v + xr|(v + xr) dx, row 3."""
    size = SIZES["crossflow_drag"]
    x, weight = stations()
    p = size["shape"]
    weight = weight * (1 + p * (2 * x) ** 2) / (1 + p / 3)
    w = m.vp[:, None] + m.rp[:, None] * x
    drag = -size["CD"] * SHIP.d / SHIP.L * abs(w) * w
    return prime(m, Y=drag @ weight, N=drag @ (weight * x))


def resistance_curve(m: Motion) -> Force:
    """X_F F + X_FF F², row 10."""
    size = SIZES["resistance_curve"]
    return prime(m, X=size["X_F"] * m.F + size["X_FF"] * m.F**2)


def memory(m: Motion) -> Force:
    """A share of Yv v and Nv v behind a one-pole lag in L/U, row 19."""
    size = SIZES["memory"]
    late = one_pole(m.vp, m.dt, size["lag_LU"] * SHIP.L / m.carriage) - m.vp
    return prime(m, **{a: size["share"] * TRUTH[f"{a}v"] * late for a in "YN"})


def lagged_crossflow(m: Motion) -> Force:
    """A share of Yvvv v³ and Nvvv v³ behind a one-pole lag in L/U, row 20."""
    size = SIZES["lagged_crossflow"]
    late = one_pole(m.vp**3, m.dt, size["lag_LU"] * SHIP.L / m.carriage) - m.vp**3
    return prime(m, **{a: size["share"] * TRUTH[f"{a}vvv"] * late for a in "YN"})


FORCES: dict[str, Source] = {
    **{
        name: _polynomial(name)
        for name in (
            "modulus_sway_drag",
            "modulus_yaw_drag",
            "yaw_sway_coupling",
            "surge_yaw_coupling",
            "surge_fourth_order",
            "asymmetry",
            "even_hull_terms",
            "nonlinear_added_mass",
            "heel_coupling",
            "rudder_stall",
            "rudder_cross_terms",
        )
    },
    **{name: _polynomial(name, lambda m: m.F) for name in ("froude_linear", "froude_nonlinear")},
    "crossflow_drag": crossflow_drag,
    "resistance_curve": resistance_curve,
    "memory": memory,
    "lagged_crossflow": lagged_crossflow,
}
"""Forces at size 1, of the true motion."""


def rig_of(effects: dict[str, float]) -> Rig:
    """What the rig does wrong, from the sizes of the faults of motion."""
    size = {name: effects.get(name, 0.0) for name in RIG_EFFECTS}
    degrees = np.pi / 180
    return Rig(
        heading=size["fault_misalignment"] * SIZES["fault_misalignment"]["deg"] * degrees,
        current=size["current"] * SIZES["current"]["metres_per_second"],
        stroke=size["fault_pmm_amplitude"] * SIZES["fault_pmm_amplitude"]["share"],
        mistiming=size["fault_pmm_phase"] * SIZES["fault_pmm_phase"]["deg"] * degrees,
        speed=size["fault_carriage_speed"] * SIZES["fault_carriage_speed"]["share"],
        fast_speed=SIZES["fault_carriage_speed"]["speed"],
    )


RIG_EFFECTS = (
    "fault_misalignment",
    "current",
    "fault_pmm_amplitude",
    "fault_pmm_phase",
    "fault_carriage_speed",
)


def rig_change(m: Motion, effects: dict[str, float], force: Callable[[Motion], Force]) -> Force:
    """Faults of the motion to first order in the force of the whole ship, rows 25, 40, 48, 51 and
    52.

    The amplitude fault is one of the sway motion alone (row 51), that of the phase a sway
    v = (U φ/ω) r in yaw tests (row 52); the others are the tangent of the exact motion.
    """
    changes = []
    for name in RIG_EFFECTS:
        size = effects.get(name, 0.0)
        acts = {
            "fault_pmm_amplitude": ("pure_sway", "sway_yaw"),
            "fault_pmm_phase": ("pure_yaw", "yaw_drift"),
        }.get(name, (m.plan.test,))
        if not size or m.plan.test not in acts:
            continue
        if name == "fault_pmm_amplitude":
            longer = replace(m.plan, sway=m.plan.sway * (1 + SIZES[name]["share"]))
            other = motion_of(longer, m.t)
        elif name == "fault_pmm_phase":
            turn = np.radians(SIZES[name]["deg"]) * m.plan.speed / m.plan.omega
            other = replace(m, v=m.v + turn * m.r, vdot=m.vdot + turn * m.rdot)
        else:
            other = motion_of(m.plan, m.t, rig_of({name: 1.0}))
        changes.append(times(size, along(force, m, other)))
    return add(*changes)
