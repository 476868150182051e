"""S175, a fast container ship: the equations of Son and Nomoto (1981), in prime quantities.

Masses over ½ρL³ and ½ρL⁵, forces over ½ρL²U² and moments over ½ρL³U² with the speed of the instant;
x forward, y to starboard, origin midship; a rudder angle above zero turns to starboard.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .flow import Body, Motion, hidden_forces, hull_coefficients, normal_lift, revolutions_for
from .hidden import Hidden

BODY = Body(
    L=175.0, B=25.4, d=8.5, rho=1025.0, front=420.0, flank=1900.0,
    linear=(-0.0116, 0.00242, -0.0038545, -0.00222),
)  # fmt: skip
VOLUME, GM, G = 21222.0, 0.3, 9.81
m, mx, my, ay, ly, lx = 0.00792, 0.000238, 0.007049, 0.05, 0.0313, 0.0313
Ix, Jx, Iz, Jz = 0.0000176, 0.0000034, 0.000456, 0.000419
X = {"uu": -.0004226, "vr": -.00311, "rr": .00020, "ff": -.00020, "vv": -.00386}  # fmt: skip
ODD = {
    #                 v          r         vvv       rrr        vvr        vrr
    "Y": np.array([-0.0116, 0.00242, -0.109, 0.00177, 0.0214, -0.0405]),
    "N": np.array([-0.0038545, -0.00222, 0.001492, -0.00229, -0.0424, 0.00156]),
    "K": np.array([0.0003026, -0.000063, 0.002843, -0.0000462, -0.000588, 0.0010565]),
}  # fmt: skip
HEEL = {
    #               p          φ         vvφ       vφφ        rrφ        rφφ
    "Y": np.array([0.0, -0.000063, 0.04605, 0.00304, 0.009325, -0.001368]),
    "N": np.array([0.000213, -0.0001424, -0.019058, -0.0053766, -0.0038592, 0.0024195]),
    "K": np.array([-0.0000075, -0.000021, -0.0012012, -0.0000793, -0.000243, 0.00003569]),
}  # fmt: skip
T, WAKE, TAU, XP, DIAMETER = 0.175, 0.184, 1.09, -0.526, 6.533
KT = (0.527, -0.455, 0.0)
AREA, ASPECT, SLIP, EPS = 33.0376, 1.8219, 0.631, 0.921
SLOPE = 6.13 * ASPECT / (ASPECT + 2.25)
GAMMA, CR, CRRR, CRRV = 0.088, -0.156, -0.275, 1.96
FREE, AH, XH, XR, ZR = 0.71, 0.237, -0.48, -0.5, 0.033


@dataclass(frozen=True)
class Container:
    """The ship, rolling or held upright, with what is hidden on her."""

    hidden: Hidden
    rolls: bool = True
    body = BODY
    rate = math.radians(3.0)
    """Of the steering gear [rad/s]."""

    def revolutions(self, U: np.ndarray) -> np.ndarray:
        """Of self-propulsion [1/s] straight ahead."""
        drag = 0.5 * BODY.rho * BODY.L**2 * U**2 * -X["uu"] * (1.0 + self.hidden.resistance)
        inflow = U * (1.0 - WAKE - self.hidden.wake)
        thrust = drag / (1.0 - T - self.hidden.deduction)
        return revolutions_for(thrust, inflow, DIAMETER, BODY.rho, KT)

    def accelerations(
        self, now: Motion, delta: np.ndarray, n: np.ndarray, blows: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Of surge and sway [m/s²], yaw and roll [rad/s²]."""
        h, U, L = self.hidden, now.speed, BODY.L
        q = 0.5 * BODY.rho * L**2 * U**2
        u, v, r, p = now.u / U, now.v / U, now.r * L / U, now.p * L / U
        odd, heel = _products(v, r, p, now.phi)
        hull = {name: terms @ odd for name, terms in ODD.items()}
        lean = {name: terms @ heel for name, terms in HEEL.items()}
        inflow, thrust = self._propeller(now.u, v, r, n)
        normal = self._rudder(U, v, r, delta, inflow, thrust) / q
        side = normal * np.cos(delta)
        other = hidden_forces(BODY, h, now, blows)
        surge = (
            (1.0 + h.resistance) * X["uu"] * u * u
            + X["vr"] * v * r
            + X["vv"] * v * v
            + X["rr"] * r * r
            + h.heel * X["ff"] * now.phi**2
            + (1.0 - T - h.deduction) * thrust / q
            + (FREE - h.steering_drag) * normal * np.sin(delta)
            + other[0] / q
            + (m + my) * v * r
        )
        share = AH + h.hull_share
        sway = hull["Y"] + h.heel * lean["Y"] + (1.0 + share) * side + other[1] / q
        yaw = hull["N"] + h.heel * lean["N"] + (XR + share * (XH + h.hull_point)) * side
        yaw = yaw + other[2] / (q * L)
        roll = hull["K"] + lean["K"] - (1.0 + share) * ZR * side + mx * lx * u * r
        roll = roll - BODY.rho * G * VOLUME * GM * now.phi / (q * L)
        rates = self.mobility @ np.stack([sway - (m + mx) * u * r, roll, yaw])
        scale = U**2 / L
        return (
            surge / (m + mx) * scale,
            rates[0] * scale,
            rates[2] * scale / L,
            rates[1] * scale / L,
        )

    @property
    def coefficients(self) -> dict[str, dict[str, float]]:
        """What is hidden, as coefficients of the effects that have the same form."""
        h = self.hidden
        lean = {
            f"{force}{product}": h.heel * float(value)
            for force in "YN"
            for product, value in zip(
                ("p", "phi", "vvphi", "vphiphi", "rrphi", "rphiphi"), HEEL[force], strict=True
            )
        }
        return hull_coefficients(BODY, h) | {
            "heel_coupling": lean | {"Xphiphi": h.heel * X["ff"], "Ypdot": h.heel * my * ly},
            "scale_effect": {"Xuu": h.resistance * X["uu"]},
            "flow_straightening": {"gamma": h.straightening, "cRr": h.crossing},
            "wake_in_drift": {"tau": h.drift_wake},
        }

    @cached_property
    def mobility(self) -> np.ndarray:
        """Inverse of the masses of sway, roll and yaw."""
        h = self.hidden.heel
        masses = np.array(
            [[m + my, -my * ly * h, my * ay], [-my * ly, Ix + Jx, 0.0], [my * ay, 0.0, Iz + Jz]]
        )
        if self.rolls:
            return np.linalg.inv(masses)
        upright = np.zeros((3, 3))
        upright[np.ix_([0, 2], [0, 2])] = np.linalg.inv(masses[np.ix_([0, 2], [0, 2])])
        return upright

    def _propeller(
        self, u: np.ndarray, v: np.ndarray, r: np.ndarray, n: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        h = self.hidden
        inflow = u * (1.0 - WAKE - h.wake + (TAU + h.drift_wake) * (v + XP * r) ** 2)
        return inflow, BODY.rho * n**2 * DIAMETER**4 * (KT[0] + KT[1] * inflow / (n * DIAMETER))

    def _rudder(
        self,
        U: np.ndarray,
        v: np.ndarray,
        r: np.ndarray,
        delta: np.ndarray,
        inflow: np.ndarray,
        thrust: np.ndarray,
    ) -> np.ndarray:
        """Normal force [N]; below zero it turns the ship to starboard."""
        h = self.hidden
        jet = 8.0 * thrust / (math.pi * BODY.rho * DIAMETER**2)
        along = EPS * np.sqrt(inflow**2 + SLIP * jet)
        across = (GAMMA + h.straightening) * v + (CR + h.crossing) * r
        across = U * (across + CRRR * r**3 + CRRV * r * r * v)
        lift = normal_lift(SLOPE, delta + np.arctan(across / along), h.stalled, h.ventilated)
        return -0.5 * BODY.rho * AREA * (along**2 + across**2) * lift


def _products(
    v: np.ndarray, r: np.ndarray, p: np.ndarray, f: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    odd = np.stack([v, r, v**3, r**3, v * v * r, v * r * r])
    return odd, np.stack([p, f, v * v * f, v * f * f, r * r * f, r * f * f])
