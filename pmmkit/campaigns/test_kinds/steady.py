"""Captive tests in which the motion is held: straight ahead, with angles, in a circle.

========  =========================================  ===================
course    path and heading                           so that
========  =========================================  ===================
straight  straight, heading β                        u = U cos β, v = -U sin β
circular  circle at speed U, drift β, r = U/radius   the same u and v, r constant
========  =========================================  ===================
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from pmmkit.campaigns.settings import Settings
from pmmkit.campaigns.test_kinds.kind import (
    KindFit,
    NominalMotion,
    ShipMotion,
    TankMotion,
    TestKind,
)
from pmmkit.numerics import Array


def straight(settings: Settings, theta: Array) -> ShipMotion:
    """Straight course at a drift angle, in ship axes."""
    del theta
    return {
        "u": settings.speed * math.cos(settings.drift),
        "v": -settings.speed * math.sin(settings.drift),
    }


def along_the_tank(settings: Settings, theta: Array) -> TankMotion:
    """Straight course at a drift angle, in tank axes."""
    zero = np.zeros_like(theta)
    return TankMotion(
        xdot=zero + settings.speed,
        ydot=zero,
        xddot=zero,
        yddot=zero,
        psi=zero + settings.drift,
        r=zero,
        rdot=zero,
    )


def at_rest(settings: Settings, theta: Array) -> tuple[Array, Array]:
    """The hull stays where it is on the carriage."""
    del settings
    return np.zeros_like(theta), np.zeros_like(theta)


def circle(settings: Settings, theta: Array) -> ShipMotion:
    """Steady turn at a drift angle, in ship axes."""
    return {**straight(settings, theta), "r": settings.turn_rate}


STRAIGHT: Final = NominalMotion(tank=along_the_tank, ship=straight, place=at_rest)

RESISTANCE: Final = TestKind(
    name="resistance",
    title="resistance",
    family="steady",
    varies=("u",),
    motion=STRAIGHT,
    codes=("RE", "RES"),
    phrase=r"\bresistance\b",
    shares={},
    usual=True,
)
PROPULSION: Final = TestKind(
    name="propulsion",
    title="self-propulsion",
    family="steady",
    varies=("u", "rps"),
    motion=STRAIGHT,
    codes=("PR",),
    phrase=r"\b(?:self ?)?propulsion\b",
)
STATIC_DRIFT: Final = TestKind(
    name="static_drift",
    title="static drift",
    family="steady",
    needs=("drift",),
    varies=("v",),
    motion=STRAIGHT,
    fit=KindFit(factors=("u", "v", "T")),
    codes=("SD", "SDT", "OT", "OTT"),
    phrase=r"\b(?:static|steady) ?drift\b|\boblique\b|\bdrift\b",
    shares={"drift": (0.25, 0.5, 1.0)},
    usual=True,
)
STATIC_HEEL: Final = TestKind(
    name="static_heel",
    title="static heel",
    family="steady",
    needs=("heel",),
    varies=("phi",),
    motion=STRAIGHT,
    fit=KindFit(factors=("u", "v", "phi", "T")),
    codes=("SH",),
    phrase=r"\bheel(?:ed)?\b",
    shares={"heel": (0.5, 1.0)},
)
STATIC_RUDDER: Final = TestKind(
    name="static_rudder",
    title="static rudder",
    family="steady",
    needs=("rudder",),
    varies=("delta",),
    motion=STRAIGHT,
    fit=KindFit(factors=("u", "d", "T")),
    codes=("RS", "SR", "SRT"),
    phrase=r"\b(?:static|steady) ?rudder\b|\brudder (?:angle|test)\b",
    shares={"rudder": (0.4, 1.0)},
    usual=True,
)
DRIFT_RUDDER: Final = TestKind(
    name="drift_rudder",
    title="drift with rudder",
    family="steady",
    needs=("drift", "rudder"),
    varies=("v", "delta"),
    motion=STRAIGHT,
    fit=KindFit(factors=("u", "v", "d", "T"), beside=(STATIC_DRIFT.name, STATIC_RUDDER.name)),
    codes=("DR",),
    phrase=r"\bdrift\b.*\brudder\b",
    shares={"drift": (0.5, 1.0), "rudder": (0.8,)},
    usual=True,
)
CIRCULAR_MOTION: Final = TestKind(
    name="circular_motion",
    title="circular motion",
    family="steady",
    needs=("yaw_rate",),
    takes=("drift",),
    varies=("v", "r"),
    motion=NominalMotion(ship=circle),
    fit=KindFit(factors=("u", "v", "r", "T")),
    codes=("CM", "CMT"),
    phrase=r"\bcircular\b|\brotating ?arm\b|\bcmt\b",
)
KINDS: Final = (
    RESISTANCE,
    PROPULSION,
    STATIC_DRIFT,
    STATIC_HEEL,
    STATIC_RUDDER,
    DRIFT_RUDDER,
    CIRCULAR_MOTION,
)
