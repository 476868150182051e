"""Two-strut mechanisms: where the hull is, from the positions of its two struts across the tank.

Both struts stand on the carriage, b apart along the rails, and move across the tank. One is pivoted
to the hull, the other slides along it, so that its heading on the struts is ψb = atan((yf - ya)/b)
exactly. With yf = a sin(θs + ε/2), ya = a sin(θs - ε/2) the point midway goes A sin θs and
tan ψb = K cos θs, with A = a cos(ε/2) and K = (2a/b) sin(ε/2) (Gertler 1959; Abkowitz 1964).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from pmmkit.campaigns.settings import Settings
from pmmkit.numerics import Array


@dataclass(frozen=True, kw_only=True)
class Struts:
    """The two struts of a mechanism, ``[struts]`` of a campaign file.

    `spacing`: distance of the struts along the rails [m]. `centre_x`: where the point midway
    between them is at rest, forward of midship [m]. `slides`: the strut that slides along the
    hull; the other is pivoted to it. `motion_x`: the point whose motion is meant by the
    campaign, forward of midship [m].
    """

    spacing: float
    centre_x: float = 0.0
    slides: Literal["aft", "forward"] = "aft"
    motion_x: float = 0.0

    @property
    def signed(self) -> float:
        """The spacing, negative where the aft strut is pivoted [m]."""
        return self.spacing if self.slides == "aft" else -self.spacing

    @property
    def centre(self) -> float:
        """Where the point midway is, forward of the point whose motion is meant [m]."""
        return self.centre_x - self.motion_x

    def swing(self, amplitude: float, phase: float) -> tuple[float, float]:
        """Amplitude A of the point midway [m] and the largest heading atan K on the struts [rad].

        amplitude [m].

        Examples
        --------
        >>> Struts(spacing=2.0).swing(0.3, 0.0)
        (0.3, 0.0)
        >>> midway, heading = Struts(spacing=2.0).swing(0.3, math.pi)
        >>> round(midway, 9), round(math.tan(heading), 9)
        (0.0, 0.3)
        """
        half = phase / 2
        return (
            amplitude * math.cos(half),
            math.atan(2 * amplitude * math.sin(half) / self.spacing),
        )

    def of_pure_yaw(self, omega: float, speed: float) -> float:
        """Lead of the forward strut at which the hull follows its heading: 2 atan(ωb/2U) [rad].

        Examples
        --------
        >>> round(math.degrees(Struts(spacing=2.0).of_pure_yaw(0.6, 1.2)), 2)
        53.13
        """
        return 2 * math.atan(omega * self.spacing / (2 * speed))

    def amplitude_and_phase(self, settings: Settings, *, lags: bool) -> tuple[float, float]:
        """Amplitude of each strut [m] and lead of the forward one [rad]: undoes `swing`."""
        heading = (settings.yaw_amplitude or 0.0) * (-1 if lags else 1)
        across = 0.5 * self.spacing * math.tan(heading)
        along = settings.amplitude or 0.0
        return math.hypot(along, across), 2 * math.atan2(across, along)


def place_on_struts(
    y_forward: Array, y_aft: Array, struts: Struts, turned: float = 0.0
) -> dict[str, Array]:
    """Place and heading of the hull from the recorded positions of its struts.

    y_forward, y_aft [m].

    Examples
    --------
    >>> found = place_on_struts(np.array([0.1]), np.array([0.1]), Struts(spacing=2.0))
    >>> {name: x.tolist() for name, x in found.items()}
    {'x': [0.0], 'y': [0.1], 'psi': [0.0]}
    """
    bar = np.arctan((y_forward - y_aft) / struts.spacing)
    ahead, aside = _arm(struts.signed, struts.centre, turned)
    pivot = y_forward if struts.slides == "aft" else y_aft
    cosine, sine = np.cos(bar), np.sin(bar)
    return {
        "x": ahead * (cosine - 1.0) - aside * sine,
        "y": pivot + ahead * sine + aside * (cosine - 1.0),
        "psi": bar + turned,
    }


def swung(settings: Settings, theta: Array, *, lags: bool) -> Mapping[str, Array]:
    """Place, velocities and accelerations in tank axes of a hull on struts, exact in every
    angle."""
    spacing, omega = settings.strut_spacing or math.inf, settings.omega or 0.0
    sine, cosine = np.sin(theta), np.cos(theta)
    midway = settings.amplitude or 0.0
    slope = math.tan(settings.yaw_amplitude or 0.0) * (-1 if lags else 1)
    p, pdot, pddot = slope * cosine, -slope * omega * sine, -slope * omega**2 * cosine
    bar = np.arctan(p)
    r = pdot / (1.0 + p**2)
    rdot = pddot / (1.0 + p**2) - 2.0 * p * r**2
    ahead, aside = _arm(spacing, settings.strut_centre, settings.drift)
    c, s = np.cos(bar), np.sin(bar)
    along, across = ahead * c - aside * s, ahead * s + aside * c
    return {
        "x": along - ahead,
        "y": midway * sine + spacing / 2 * p + across - aside,
        "xdot": settings.speed - r * across,
        "ydot": midway * omega * cosine + spacing / 2 * pdot + r * along,
        "xddot": -rdot * across - r**2 * along,
        "yddot": -midway * omega**2 * sine + spacing / 2 * pddot + rdot * along - r**2 * across,
        "psi": bar + settings.drift,
        "r": r,
        "rdot": rdot,
    }


def _arm(spacing: float, centre: float, turned: float) -> tuple[float, float]:
    """From the pivot to the point whose motion is meant, along and across the line of struts."""
    return -spacing / 2 - centre * math.cos(turned), -centre * math.sin(turned)
