"""Faults of alignment: the model, the water or the rudder does not stand as stated."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

import numpy as np

from pmmkit.effects.faults.fault import DEGREES, STEP, fault, size
from pmmkit.effects.seen import CURRENT, RUDDER_ZERO, Forces, Move, Observed, Vessel
from pmmkit.effects.suspect import Suspect, both_signs

ANGLES: Final = (1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0, 24.0)
"""Angles of the model that the checks try, to either side [deg]."""


def turned(run: Observed, at: Mapping[str, float]) -> Forces:
    """The model stands turned on the carriage: its drift is larger than stated."""
    m, angle = run.motion, math.radians(at["turned"])
    c, s = math.cos(angle), math.sin(angle)
    moved = m.with_(
        u=c * m.u + s * m.v,
        v=c * m.v - s * m.u,
        udot=c * m.udot + s * m.vdot,
        vdot=c * m.vdot - s * m.udot,
    )
    return run.along(moved)


def drifting_water(run: Observed, at: Mapping[str, float]) -> Forces:
    """Water that moves across the tank to starboard."""
    m, psi, water = run.motion, run.heading, at["current"]
    moved = m.with_(
        u=m.u - water * np.sin(psi),
        v=m.v - water * np.cos(psi),
        udot=m.udot - water * np.cos(psi) * m.r,
        vdot=m.vdot + water * np.sin(psi) * m.r,
    )
    return run.along(moved)


def current_over_ground(vessel: Vessel) -> Mapping[str, Move]:
    """A uniform current, the same in all records."""
    usual = 0.03 * vessel.speed
    return {name: Move(values={name: 1.0}, typical=usual) for name in CURRENT}


def rudder_off(run: Observed, at: Mapping[str, float]) -> Forces:
    """The rudder further to the side that turns to starboard than stated."""
    delta = run.motion.delta
    steered = np.greater(run.means(np.abs(delta)), 0.0)
    if not np.any(steered):
        return {}
    return run.along(run.motion.with_(delta=delta + math.radians(at["angle"]) * steered))


def rudder_column_off(vessel: Vessel) -> Mapping[str, Move]:
    """What the rudder column shows too little, in degrees as in captive tests."""
    del vessel
    unit = MappingProxyType({RUDDER_ZERO: math.radians(1.0)})
    return {"angle": Move(values=unit, typical=0.5)}


MISALIGNMENT: Final = fault(
    "fault_misalignment",
    "alignment",
    "The model stands turned on the carriage.",
    turned,
    (size("turned", "deg", 0.26, "angle of the model, bow to starboard", step=DEGREES),),
    check="turn the model by 180° and repeat static drift",
    suspects=(
        Suspect(
            name="drift",
            says=lambda value: (
                f"the model stood turned by {value:+.1f}° against the drift angle that is stated"
            ),
            remedy="Correct drift_deg (and the kind of test), or look at the mount.",
            at=lambda value: {"turned": value},
            grid=both_signs(ANGLES),
            continuous=True,
        ),
        Suspect(
            name="drift as set",
            says=lambda value: (
                f"in runs with a drift angle the model stood turned by {value:+.1f}° "
                f"against the drift that is stated"
            ),
            remedy="Correct drift_deg of these runs, or look at the turntable.",
            at=lambda value: {"turned": value},
            grid=both_signs(ANGLES),
            continuous=True,
            applies=lambda kind: kind.drifts,
            scope="all",
        ),
    ),
)


EFFECTS: Final = (
    MISALIGNMENT,
    fault(
        "current",
        "alignment",
        "Water moves across the tank, or over the ground.",
        drifting_water,
        (size("current", "m/s", 0.0075, "velocity of the water", step=STEP),),
        check="static drift at low speed, or after a longer wait; the same run on two headings",
        moves=current_over_ground,
        sources=("ittc_7.5-02-06-04", "ittc_7.5-04-02-01"),
    ),
    fault(
        "fault_rudder_zero",
        "asymmetry",
        "The rudder stands, or its column is, off by a constant angle.",
        rudder_off,
        (size("angle", "deg", 0.5, "of the rudder, turning to starboard", step=DEGREES),),
        check="the rudder against a template, or a straight run with the propeller stopped",
        excites=("rudder",),
        moves=rudder_column_off,
    ),
)
