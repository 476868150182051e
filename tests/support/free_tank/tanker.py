"""KVLCC2, a full tanker, as a model of 7 m: the MMG standard method (Yasukawa and Yoshimura 2015).

Forces over ½ρLdU², moments over ½ρL²dU² with the speed of the instant, v at midship; a rudder angle
above zero turns to starboard.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from .flow import Body, Motion, hidden_forces, hull_coefficients, normal_lift, revolutions_for
from .hidden import Hidden

BODY = Body(
    L=7.0, B=1.27, d=0.46, rho=1000.0, front=0.35, flank=1.6,
    linear=(-0.0207, 0.00545, -0.0090, -0.00322),
)  # fmt: skip
MASS, IZZ, XG = 3270.0, 10218.75, 0.25
MX, MY, JZ = 0.022, 0.223, 0.011
R0 = 0.022
T, WAKE, XP, DIAMETER = 0.22, 0.40, -0.48, 0.216
C1, C2 = 2.0, (1.6, 1.1)
KT = (0.2931, -0.2753, -0.1385)
AREA, HEIGHT, SLOPE, EPS, KAPPA = 0.0539, 0.345, 2.747, 1.09, 0.50
GAMMA, LEVER = (0.640, 0.395), -0.710
TR, AH, XH, XR = 0.387, 0.312, -0.464, -0.5


@dataclass(frozen=True)
class Tanker:
    """The model with what is hidden on her; she does not roll."""

    hidden: Hidden
    rolls = False
    body = BODY
    rate = math.radians(15.8)
    """Of the steering gear [rad/s]."""

    def revolutions(self, U: np.ndarray) -> np.ndarray:
        """Of self-propulsion [1/s] straight ahead."""
        drag = 0.5 * BODY.rho * BODY.L * BODY.d * U**2 * R0 * (1.0 + self.hidden.resistance)
        inflow = U * (1.0 - WAKE - self.hidden.wake)
        thrust = drag / (1.0 - T - self.hidden.deduction)
        return revolutions_for(thrust, inflow, DIAMETER, BODY.rho, KT)

    def accelerations(
        self, now: Motion, delta: np.ndarray, n: np.ndarray, blows: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Of surge and sway [m/s²], yaw and roll [rad/s²]."""
        h, L, U = self.hidden, BODY.L, now.speed
        q = 0.5 * BODY.rho * L * BODY.d * U**2
        v, r, beta = now.v / U, now.r * L / U, np.arctan2(-now.v, now.u)
        X = -R0 * (1.0 + h.resistance) - 0.040 * v**2 + 0.002 * v * r + 0.011 * r**2 + 0.771 * v**4
        Y = -0.315 * v + 0.083 * r - 1.607 * v**3 + 0.379 * v * v * r - 0.391 * v * r * r
        N = -0.137 * v - 0.049 * r - 0.030 * v**3 - 0.294 * v * v * r + 0.055 * v * r * r
        inflow, thrust = self._propeller(now.u, beta, r, n)
        normal = self._rudder(U, beta, r, delta, inflow, thrust)
        side, share = normal * np.cos(delta), AH + h.hull_share
        other = hidden_forces(BODY, h, now, blows)
        X = q * X + (1.0 - T - h.deduction) * thrust + other[0]
        X = X - (1.0 - TR - h.steering_drag) * normal * np.sin(delta)
        Y = q * (Y + 0.008 * r**3) - (1.0 + share) * side + other[1]
        N = q * L * (N - 0.013 * r**3) - (XR + share * (XH + h.hull_point)) * L * side + other[2]
        unit = 0.5 * BODY.rho * L**2 * BODY.d
        surging, swaying = MASS + MX * unit, MASS + MY * unit
        masses = np.array([[swaying, XG * MASS], [XG * MASS, IZZ + JZ * unit * L**2]])
        left = [Y - surging * now.u * now.r, N - XG * MASS * now.u * now.r]
        sway, yaw = np.linalg.solve(masses, np.stack(left))
        surge = (X + swaying * now.v * now.r + XG * MASS * now.r**2) / surging
        return surge, sway, yaw, np.zeros_like(yaw)

    @property
    def coefficients(self) -> dict[str, dict[str, float]]:
        """What is hidden, as coefficients of the effects that have the same form."""
        h = self.hidden
        return hull_coefficients(BODY, h) | {
            "scale_effect": {"Xuu": -R0 * h.resistance},
            "flow_straightening": {
                "gamma_positive": h.straightening,
                "gamma_negative": h.straightening,
                "lR": h.crossing,
            },
            "wake_in_drift": {"C2_positive": h.drift_wake, "C2_negative": h.drift_wake},
        }

    def _propeller(
        self, u: np.ndarray, beta: np.ndarray, r: np.ndarray, n: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        h = self.hidden
        turned = beta - XP * r
        limit = np.where(turned > 0.0, C2[0], C2[1]) + h.drift_wake
        growth = 1.0 + (1.0 - np.exp(-C1 * np.abs(turned))) * (limit - 1.0)
        inflow = u * (1.0 - WAKE - h.wake) * growth
        J = inflow / (n * DIAMETER)
        return inflow, BODY.rho * n**2 * DIAMETER**4 * (KT[0] + J * (KT[1] + KT[2] * J))

    def _rudder(
        self,
        U: np.ndarray,
        beta: np.ndarray,
        r: np.ndarray,
        delta: np.ndarray,
        inflow: np.ndarray,
        thrust: np.ndarray,
    ) -> np.ndarray:
        """Normal force [N]; above zero it turns the ship to starboard."""
        h = self.hidden
        turned = beta - (LEVER + h.crossing) * r
        across = U * turned * (np.where(turned > 0.0, *GAMMA) + h.straightening)
        behind = np.sqrt(inflow**2 + 8.0 * thrust / (math.pi * BODY.rho * DIAMETER**2))
        covered = DIAMETER / HEIGHT
        slipstream = inflow + KAPPA * (behind - inflow)
        along = EPS * np.sqrt(covered * slipstream**2 + (1.0 - covered) * inflow**2)
        lift = normal_lift(SLOPE, delta - np.arctan(across / along), h.stalled, h.ventilated)
        return 0.5 * BODY.rho * AREA * (along**2 + across**2) * lift
