"""Faults of alignment: the model, the water or the rudder does not stand as stated."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

import numpy as np

from pmmkit.effects.faults.fault import STEP, Columns, fault, one, size
from pmmkit.effects.seen import CURRENT, RUDDER_ZERO, Move, Observed, Vessel


def turned(run: Observed, value: float) -> Columns:
    """The model stands turned by a degree on the carriage: its drift is larger than stated."""
    del value
    m, c, s = run.motion, math.cos(STEP), math.sin(STEP)
    moved = m.with_(
        u=c * m.u + s * m.v,
        v=c * m.v - s * m.u,
        udot=c * m.udot + s * m.vdot,
        vdot=c * m.vdot - s * m.udot,
    )
    return one(run.changed(moved, math.degrees(STEP)))


def drifting_water(run: Observed, value: float) -> Columns:
    """Water that moves across the tank to starboard [m/s]."""
    del value
    m, psi = run.motion, run.heading
    moved = m.with_(
        u=m.u - STEP * np.sin(psi),
        v=m.v - STEP * np.cos(psi),
        udot=m.udot - STEP * np.cos(psi) * m.r,
        vdot=m.vdot + STEP * np.sin(psi) * m.r,
    )
    return one(run.changed(moved, STEP))


def current_over_ground(vessel: Vessel) -> Mapping[str, Move]:
    """A uniform current, the same in all records."""
    usual = 0.03 * vessel.speed
    return {name: Move(values={name: 1.0}, typical=usual) for name in CURRENT}


def rudder_off(run: Observed, value: float) -> Columns:
    """The rudder a degree further to the side that turns to starboard than stated."""
    del value
    if not np.any(run.motion.delta):
        return {}
    moved = run.motion.with_(delta=run.motion.delta + STEP)
    return one(run.changed(moved, math.degrees(STEP)))


def rudder_column_off(vessel: Vessel) -> Mapping[str, Move]:
    """What the rudder column shows too little, in degrees as in captive tests."""
    del vessel
    unit = MappingProxyType({RUDDER_ZERO: math.radians(1.0)})
    return {"angle": Move(values=unit, typical=0.5)}


EFFECTS: Final = (
    fault(
        "fault_misalignment",
        "alignment",
        "The model stands turned on the carriage.",
        turned,
        (size("turned", "deg", 0.26, "angle of the model, bow to starboard"),),
        known_as="drift",
        check="turn the model by 180° and repeat static drift",
    ),
    fault(
        "current",
        "alignment",
        "Water moves across the tank, or over the ground.",
        drifting_water,
        (size("current", "m/s", 0.0075, "velocity of the water"),),
        check="static drift at low speed, or after a longer wait; the same run on two headings",
        moves=current_over_ground,
        sources=("ittc_7.5-02-06-04", "ittc_7.5-04-02-01"),
    ),
    fault(
        "fault_rudder_zero",
        "asymmetry",
        "The rudder stands, or its column is, off by a constant angle.",
        rudder_off,
        (size("angle", "deg", 0.5, "of the rudder, turning to starboard"),),
        check="the rudder against a template, or a straight run with the propeller stopped",
        excites=("rudder",),
        moves=rudder_column_off,
    ),
)
