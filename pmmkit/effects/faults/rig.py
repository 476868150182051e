"""Faults of the carriage, the oscillator and the mount: the motion is not the one stated."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from pmmkit.effects.effect import Parameter
from pmmkit.effects.faults.fault import ITTC_CAPTIVE, STEP, Columns, fault, one, size
from pmmkit.effects.seen import Observed


def amplitude(run: Observed, value: float) -> Columns:
    """Sway larger than stated by a share, in tests that sway."""
    del value
    if not run.sways:
        return {}
    m = run.motion
    return one(run.changed(m.with_(v=m.v * (1 + STEP), vdot=m.vdot * (1 + STEP)), STEP))


YAW_ALONE: Final = 0.0
WITH_SWAY: Final = 1.0
"""Places of the forms of `phase` in its grid, as findings and saved steps hold them."""


def phase(run: Observed, combined: float) -> Columns:
    """Rams a degree out of step: sway follows the acceleration across the tank, ψ̇ U with v̇."""
    if not run.yaws or run.omega == 0.0 or (run.sways and combined == YAW_ALONE):
        return {}
    m = run.motion
    swing = m.v - np.mean(m.v)
    across = m.vdot + run.speed * m.r
    rate = run.speed * m.rdot - run.omega**2 * swing
    gain = STEP / run.omega
    return one(
        run.changed(m.with_(v=m.v + gain * across, vdot=m.vdot + gain * rate), math.degrees(STEP))
    )


def carriage(run: Observed, speed: float) -> Columns:
    """The carriage faster than stated by a share, at one speed."""
    if speed == 0.0 or abs(run.speed / speed - 1) > 0.02:
        return {}
    m = run.motion
    v = m.v if run.sways else m.v * (1 + STEP)
    moved = m.with_(u=m.u * (1 + STEP), v=v)
    return one(run.changed(moved, STEP, speed=run.speed * (1 + STEP)))


def carriage_surge(run: Observed, value: float) -> Columns:
    """A share of the surge that yaw at a constant carriage speed makes, and that is not there.

    Pure yaw has u = Uc/cos ψ where the sway carriage follows the path; where the mean speed is
    held instead, part of that swing is missing, and of its acceleration with it.
    """
    del value
    if not run.yaws or run.omega == 0.0:
        return {}
    m = run.motion
    swing = m.u - np.mean(m.u)
    moved = m.with_(u=m.u - STEP * swing, udot=m.udot * (1 - STEP))
    return one(run.changed(moved, STEP))


def start(run: Observed, decay: float) -> Columns:
    """A force of the start that dies away, over its size; decay in L/U."""
    if run.omega == 0.0:
        return {}
    fading = run.project(np.exp(-run.t * run.speed / (decay * run.ship.L)))
    return one(dict.fromkeys(run.expected, fading))


def resonance(run: Observed, frequency: float) -> Columns:
    """Forces enlarged by a mount of a natural frequency [Hz], below its resonance.

    An undamped spring shows F/(1 - (n ω/ω0)²) of a harmonic; beyond 0.7 of resonance nothing is
    said, for damping decides there.
    """
    own = 2.0 * math.pi * frequency

    def factor(n: int) -> complex:
        ratio = min(n * run.omega / own, 0.7) ** 2
        return ratio / (1.0 - ratio)

    return one(run.filtered(factor)) if run.omega else {}


def laminar(run: Observed, speed: float) -> Columns:
    """A share of the resistance that is missing up to a speed, where the flow stays laminar."""
    if run.speed > 1.02 * speed or "X" not in run.expected:
        return {}
    unit = 0.5 * run.water.rho * run.ship.L**2 * run.motion.speed**2 * 1e-4
    return {"X": (run.project(unit),)}


def motion_point(run: Observed, value: float) -> Columns:
    """Motions that are those of a point one ship length forward of the one stated."""
    del value
    m, step = run.motion, STEP * run.ship.L
    if not np.any(m.r):
        return {}
    return one(run.changed(m.with_(v=m.v - step * m.r, vdot=m.vdot - step * m.rdot), STEP))


EFFECTS: Final = (
    fault(
        "fault_pmm_amplitude",
        "rig",
        "Sway larger than stated.",
        amplitude,
        (size("share", "-", 0.03, "of the sway"),),
        known_as="amplitude",
        check="measure the motion",
    ),
    fault(
        "fault_pmm_phase",
        "rig",
        "Rams out of step: pure yaw sways.",
        phase,
        (
            size("phase", "deg", 1.0, "between the rams"),
            Parameter(
                name="combined",
                text=f"in yaw alone ({YAW_ALONE:g}), with sway too ({WITH_SWAY:g})",
                grid=(YAW_ALONE, WITH_SWAY),
                continuous=False,
            ),
        ),
        check="record both rams",
    ),
    fault(
        "fault_carriage_speed",
        "rig",
        "The carriage is faster than stated at one speed.",
        carriage,
        (
            size("share", "-", 0.010, "of the speed"),
            Parameter(
                name="speed", unit="m/s", text="speed [m/s]", of_the_tests=True, continuous=False
            ),
        ),
        check="an independent speed log",
        excites=("several speeds",),
    ),
    fault(
        "fault_carriage_surge",
        "rig",
        "The surge that pure yaw makes is not what the kinematics say.",
        carriage_surge,
        (size("share", "-", 0.3, "of the swing of the surge velocity that is missing"),),
        check="log the speed of the carriage and of the sway carriage in pure yaw",
        sources=("ittc_7.5-02-06-02",),
    ),
    fault(
        "fault_mount_elasticity",
        "rig",
        "A mount that gives way enlarges the forces near its own frequency.",
        resonance,
        (
            size("share", "-", 0.1, "of an undamped spring; 1 is the whole of it", expected=1.0),
            Parameter(
                name="frequency", unit="1/s", text="natural frequency [Hz]", grid=(1.5, 2.5, 4.0)
            ),
        ),
        check="tap the model on its mount; oscillate at another frequency",
    ),
    fault(
        "fault_turbulence_stimulation",
        "rig",
        "Flow that stays laminar at low speed.",
        laminar,
        (
            size("X", "-", 0.3, "missing resistance, 10⁻⁴ of ½ρL²U²"),
            Parameter(
                name="speed",
                unit="m/s",
                text="up to this speed [m/s]",
                of_the_tests=True,
                continuous=False,
            ),
        ),
        check="studs or a wire at the bow; a resistance curve down to low speed",
        excites=("four speeds",),
    ),
    fault(
        "fault_motion_point",
        "rig",
        "Motions that belong to another point than stated.",
        motion_point,
        (size("x over L", "-", 0.01, "the point forward of the one stated"),),
        known_as="motion point",
        check="measure where the rig holds the model",
    ),
    fault(
        "fault_transient",
        "rig",
        "Forces of the start that have not died away.",
        start,
        (
            size("share", "-", 0.08, "of the force of each run"),
            Parameter(name="decay", text="decay in L/U", grid=(0.7, 1.5, 3.0), continuous=False),
        ),
        check="leave out more cycles",
        sources=(ITTC_CAPTIVE,),
        each_run=True,
    ),
)
