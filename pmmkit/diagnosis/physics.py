"""Effects of ship and water that a base model may lack."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.conventions import force_unit
from pmmkit.diagnosis.base import Base
from pmmkit.diagnosis.candidate import Candidate, polynomial, spread_over
from pmmkit.diagnosis.views import View

Array = NDArray[np.float64]
STRIPS: Final = 41
"""Stations over the length of a cross-flow integral."""


def _unit(base: Base, channel: str, motion_speed: Array) -> Array:
    unit = force_unit(
        channel, base.convention.system, L=base.ship.L, d=base.ship.d, volume=base.ship.volume,
        rho=base.water.rho, g=base.water.g, U=1.0,
    )  # fmt: skip
    return unit * motion_speed**2


def _primed(view: View, base: Base) -> tuple[Array, Array, Array, Array]:
    """U, v', r', v̇' along a view."""
    motion, L = view.motion, base.ship.L
    U = motion.speed
    return U, motion.v / U, motion.r * L / U, motion.vdot * L / U**2


def _crossflow(view: View, base: Base, growth: float) -> Mapping[str, Array]:
    """Drag of each strip; CD grows to the ends as 1 + growth (2x)²."""
    U, v, r, _ = _primed(view, base)
    x = np.linspace(-0.5, 0.5, STRIPS)
    weight = np.full(STRIPS, 1.0 / (STRIPS - 1))
    weight[[0, -1]] /= 2.0
    flow = v[:, None] + r[:, None] * x
    drag = -np.abs(flow) * flow * (1.0 + growth * (2.0 * x) ** 2) * weight
    ratio = base.ship.d / base.ship.L if base.convention.system == "prime" else 1.0
    return spread_over(
        view,
        {
            "Y": [view.project(_unit(base, "Y", U) * ratio * drag.sum(axis=1))],
            "N": [view.project(_unit(base, "N", U) * ratio * (drag @ x))],
        },
        1,
    )


def _late(view: View, base: Base, lag: float, history: Array) -> Array:
    """What is missing of harmonics that build up late: those of a lag less those without.

    The lag is in ship lengths over the speed; a static run has had the time.
    """
    plain = view.project(history)
    if view.omega == 0.0:
        return np.zeros(view.rows)
    rate = view.omega * lag * base.ship.L / view.speed
    found = np.zeros(view.rows)
    for n in range(1, (view.rows - 1) // 2 + 1):
        share = 1.0 / (1.0 + 1j * n * rate) - 1.0
        late = (plain[2 * n - 1] - 1j * plain[2 * n]) * share
        found[2 * n - 1], found[2 * n] = late.real, -late.imag
    return found


def _lagged(power: int):  # type: ignore[no-untyped-def]
    def columns(view: View, base: Base, lag: float) -> Mapping[str, Array]:
        U, v, _, _ = _primed(view, base)
        zero = np.zeros(view.rows)
        side = _late(view, base, lag, _unit(base, "Y", U) * v**power)
        turn = _late(view, base, lag, _unit(base, "N", U) * v**power)
        return spread_over(view, {"Y": [side, zero], "N": [zero, turn]}, 2)

    return columns


def _added(view: View, base: Base, value: float) -> Mapping[str, Array]:
    """v² v̇ in Y and N."""
    del value
    U, v, _, vdot = _primed(view, base)
    zero = np.zeros(view.rows)
    return spread_over(
        view,
        {
            "Y": [view.project(_unit(base, "Y", U) * v**2 * vdot), zero],
            "N": [zero, view.project(_unit(base, "N", U) * v**2 * vdot)],
        },
        2,
    )


def _with_speed(base: Base, speed: float) -> Mapping[str, float]:
    F = base.law(speed)
    return dict.fromkeys((*_LINEAR_FN, *_CUBIC_FN), F)


def _resistance(view: View, base: Base, value: float) -> Mapping[str, Array]:
    """Resistance over F and F²."""
    del value
    U = view.motion.speed
    F = base.law(view.speed)
    plain = view.project(_unit(base, "X", U))
    return spread_over(view, {"X": [plain * F, plain * F**2]}, 2)


_LINEAR_FN: Final = {"Yv F": -0.0010, "Nv F": 0.0003, "Yr F": -0.00045, "Nr F": -0.00012}
_CUBIC_FN: Final = {"Yvvv F": -0.035, "Nvvv F": 0.0006, "Yrrr F": 0.004, "Nrrr F": -0.0008}
LAGS: Final = (0.15, 0.3, 0.5, 0.8)

PHYSICS: Final = (
    polynomial(
        "modulus_sway_drag", "cross flow", "Drag of sway with the square of its velocity.",
        {"Yv|v|": -0.020, "Nv|v|": 0.004},
        check="static drift at 15 to 25°, or pure sway at a third amplitude",
    ),
    polynomial(
        "modulus_yaw_drag", "cross flow", "Drag of yaw with the square of its rate.",
        {"Yr|r|": 0.0022, "Nr|r|": -0.0017}, check="pure yaw at r' 0.8, or circular motion",
    ),
    Candidate(
        name="crossflow_drag", family="cross flow", kind="physics",
        summary="Drag of the flow across each section, in one proportion of force and moment.",
        coefficients=("CD",), typical=(0.55,), columns=_crossflow, grid=(0.0, 0.8, 2.0),
        parameter="growth of CD to the ends",
        check="yaw with drift at large r/v, so that the flow changes side inside the hull",
    ),
    polynomial(
        "yaw_sway_coupling", "hull coupling", "Products of sway and yaw in side force and moment.",
        {"Yvvr": 0.0214, "Yvrr": -0.0405, "Nvvr": -0.0424, "Nvrr": 0.00156},
        check="yaw with drift at two drift angles of both signs",
    ),
    polynomial(
        "surge_yaw_coupling", "surge", "Surge force of sway and yaw together.", {"Xvr": 0.0039},
        check="yaw with drift at two drift angles",
    ),
    polynomial(
        "surge_fourth_order", "surge", "Surge force with the fourth power of sway.",
        {"Xvvvv": 0.05}, check="static drift to 20°",
    ),
    polynomial(
        "froude_linear", "speed", "Linear derivatives that change with the Froude number.",
        _LINEAR_FN, law=_with_speed, check="a third speed", excites=("several speeds",),
    ),
    polynomial(
        "froude_nonlinear", "speed", "Cubic derivatives that change with the Froude number.",
        _CUBIC_FN, law=_with_speed, check="amplitude steps at the extreme speeds",
        excites=("several speeds",),
    ),
    Candidate(
        name="resistance_curve", family="speed", kind="physics",
        summary="Resistance that does not go with the square of the speed.",
        coefficients=("X F", "X FF"), typical=(-4e-5, -2.5e-5), columns=_resistance,
        check="resistance at more speeds", excites=("several speeds",),
    ),
    polynomial(
        "asymmetry", "asymmetry", "A constant side force and moment, with the square of the speed.",
        {"Y0": 1.0e-4, "N0": -4.5e-5}, check="a straight run without the propeller",
    ),
    polynomial(
        "even_hull_terms", "asymmetry", "Forces that are the same to port and to starboard.",
        {"Yvv": 0.003, "Nvv": 0.0004, "Yrr": 0.001, "Nrr": -0.0003},
        check="static drift to both sides",
    ),
    Candidate(
        name="memory", family="memory", kind="physics",
        summary="Part of the sway force builds up late, so that damping falls with frequency.",
        coefficients=("Yv late", "Nv late"), typical=(0.2 * 0.0116, 0.2 * 0.00385),
        columns=_lagged(1), grid=LAGS, parameter="lag in L/U",
        check="pure sway at ω' = 1 and 6 beside static drift",
    ),
    Candidate(
        name="lagged_crossflow", family="memory", kind="physics",
        summary="The cubic sway force lags behind the motion.",
        coefficients=("Yvvv late", "Nvvv late"), typical=(0.9 * 0.109, 0.9 * 0.0015),
        columns=_lagged(3), grid=LAGS, parameter="lag in L/U",
        check="pure sway at two frequencies and one large amplitude",
    ),
    Candidate(
        name="nonlinear_added_mass", family="memory", kind="physics",
        summary="Added mass that changes with the sway velocity.",
        coefficients=("Yvvvdot", "Nvvvdot"), typical=(-0.020, -0.004), columns=_added,
        check="pure sway at more amplitudes",
    ),
    polynomial(
        "heel_coupling", "heel", "Forces of the heel angle.",
        {"Yphi": -4e-4, "Nphi": -3e-4, "Yvphiphi": 0.003, "Nvvphi": -0.019},
        check="static heel of 5 and 10° straight ahead", excites=("roll",),
    ),
    polynomial(
        "rudder_stall", "rudder", "Rudder force that bends over at large angles.",
        {"Yddd": 0.0045, "Nddd": -0.0022}, check="rudder at 25, 30 and 35°", excites=("rudder",),
    ),
    polynomial(
        "rudder_cross_terms", "rudder", "Rudder force that changes with drift.",
        {"Yvvd": -0.06, "Yvdd": 0.02, "Nvvd": 0.03, "Nvdd": -0.01},
        check="drift with rudder at both signs of each", excites=("rudder",),
    ),
)  # fmt: skip
