"""Faults of the carriage, the oscillator and the mount: the motion is not the one stated."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.effects.definition import Parameter
from pmmkit.effects.faults.fault import DEGREES, ITTC_CAPTIVE, STEP, beside, fault, size
from pmmkit.effects.faults.gauges import POINTS, SHARES
from pmmkit.effects.seen import Forces, Observed
from pmmkit.effects.state import State
from pmmkit.effects.suspect import Suspect, Tested, both_signs, larger_or_smaller
from pmmkit.numerics import Array

STEEPEST: Final = math.radians(80.0)
"""Headings beyond are not asked for: a path across the tank has no end."""


def strokes(run: Observed, sway: float, yaw: float) -> State:
    """The motion with the stroke of the sway carriage, and of the heading, so many times larger.

    Along the tank nothing changes. Where the heading is swung alone the carriage follows its path,
    whose tangent has the heading: the velocity is Uc/cos ψ with the heading from the mean, ψ.
    """
    m, r, rdot = run.motion, run.motion.r, run.motion.rdot
    swung = run.heading - run.drift
    turn = np.clip(yaw * swung, -STEEPEST, STEEPEST) - swung
    more = np.where(run.yaws, yaw, 1.0) * np.ones_like(r)
    turn = np.where(run.yaws, turn, 0.0)
    # In the tank: along, across, and their rates.
    c, s = np.cos(run.heading), np.sin(run.heading)
    along, across = c * m.u - s * m.v, s * m.u + c * m.v
    a, b = m.udot - r * m.v, m.vdot + r * m.u
    along_rate, across_rate = c * a - s * b, s * a + c * b
    follows = np.logical_and(run.yaws, np.logical_not(run.sways))
    bent = swung + turn
    path, rate = np.tan(bent), more * r / np.cos(bent) ** 2
    was, was_rate = np.tan(swung), r / np.cos(swung) ** 2
    across, across_rate = (
        np.where(follows, across + along * (path - was), np.where(run.sways, sway, 1.0) * across),
        np.where(
            follows,
            across_rate + along * (rate - was_rate) + along_rate * (path - was),
            np.where(run.sways, sway, 1.0) * across_rate,
        ),
    )
    c, s, r = np.cos(run.heading + turn), np.sin(run.heading + turn), more * r
    u, v = c * along + s * across, c * across - s * along
    return m.with_(
        u=u,
        v=v,
        r=r,
        udot=c * along_rate + s * across_rate + r * v,
        vdot=c * across_rate - s * along_rate - r * u,
        rdot=more * rdot,
    )


def amplitude(run: Observed, at: Mapping[str, float]) -> Forces:
    """Strokes larger than stated by a share: of the sway carriage, and of the heading."""
    sway, yaw = at["share"], at["of the heading"]
    if not ((sway and np.any(run.sways)) or (yaw and np.any(run.yaws))):
        return {}
    return run.along(strokes(run, 1.0 + sway, 1.0 + yaw))


def _of_strokes(factor: float) -> Mapping[str, float]:
    return {"share": factor - 1.0, "of the heading": factor - 1.0}


def swung_by_setting(kind: Tested) -> bool:
    """Tests whose amplitude of sway or yaw is a setting."""
    return kind.oscillates and not kind.surges


def _amplitude_of(swing: str, applies: Callable[[Tested], bool]) -> Suspect:
    return Suspect(
        name=f"amplitude of {swing}",
        says=lambda value: (
            f"the amplitude of the runs in {swing} was {larger_or_smaller(value)} than stated"
        ),
        remedy="Measure the motion, or correct the amplitude of these runs.",
        at=_of_strokes,
        grid=SHARES,
        continuous=True,
        applies=lambda kind: swung_by_setting(kind) and applies(kind),
        scope="all",
    )


YAW_ALONE: Final = 0.0
WITH_SWAY: Final = 1.0
"""Places of the forms of `phase` in its grid, as findings and saved steps hold them."""


def phase(run: Observed, at: Mapping[str, float]) -> Forces:
    """Rams out of step: sway follows the acceleration across the tank, ψ̇ U with v̇."""
    swings = np.logical_and(run.yaws, np.greater(run.omega, 0.0))
    if at["combined"] == YAW_ALONE:
        swings = np.logical_and(swings, np.logical_not(run.sways))
    if not np.any(swings):
        return {}
    m = run.motion
    lead = np.where(swings, math.radians(at["phase"]), 0.0) / np.where(swings, run.omega, 1.0)
    swing = m.v - run.means(m.v)
    across = m.vdot + run.speed * m.r
    rate = run.speed * m.rdot - run.omega**2 * swing
    return run.along(m.with_(v=m.v + lead * across, vdot=m.vdot + lead * rate))


def carriage(run: Observed, at: Mapping[str, float]) -> Forces:
    """The carriage faster than stated by a share, at one speed."""
    one = at["speed"]
    there = np.abs(run.speed - one) <= 0.02 * one
    if not np.any(there):
        return {}
    m, faster = run.motion, 1.0 + at["share"] * there
    v = np.where(run.sways, m.v, m.v * faster)
    return run.along(m.with_(u=m.u * faster, v=v), speed=run.speed * faster)


def carriage_surge(run: Observed, at: Mapping[str, float]) -> Forces:
    """A share of the surge that yaw at a constant carriage speed makes, and that is not there.

    Pure yaw has u = Uc/cos ψ where the sway carriage follows the path; where the mean speed is
    held instead, part of that swing is missing, and of its acceleration with it.
    """
    swings = np.logical_and(run.yaws, np.greater(run.omega, 0.0))
    if not np.any(swings):
        return {}
    m, share = run.motion, at["share"] * swings
    return run.along(m.with_(u=m.u - share * (m.u - run.means(m.u)), udot=m.udot * (1 - share)))


def start(run: Observed, at: Mapping[str, float]) -> Forces:
    """A force of the start that dies away, over its size; decay in L/U."""
    if not np.any(run.omega):
        return {}
    fading = at["share"] * np.exp(-run.t * run.speed / (at["decay"] * run.ship.L))
    return beside(run, dict.fromkeys(run.forces, fading * np.greater(run.omega, 0.0)))


def resonance(run: Observed, at: Mapping[str, float]) -> Forces:
    """Forces enlarged by a mount of a natural frequency [Hz], below its resonance.

    An undamped spring shows F/(1 - (n ω/ω0)²) of a harmonic; beyond 0.7 of resonance nothing is
    said, for damping decides there.
    """
    share, own = at["share"], 2.0 * math.pi * at["frequency"]
    if not np.any(run.omega):
        return {}

    def factor(n: Array, omega: Array) -> NDArray[np.complex128]:
        ratio = np.minimum(n * omega / own, 0.7) ** 2
        return np.asarray(1.0 + share * ratio / (1.0 - ratio), np.complex128)

    return run.filtered(factor)


def laminar(run: Observed, at: Mapping[str, float]) -> Forces:
    """A share of the resistance that is missing up to a speed, where the flow stays laminar."""
    slow = np.less_equal(run.speed, 1.02 * at["speed"])
    if not np.any(slow):
        return {}
    unit = 0.5 * run.water.rho * run.ship.L**2 * run.motion.speed**2 * 1e-4
    return beside(run, {"X": at["X"] * unit * slow})


def motion_point(run: Observed, at: Mapping[str, float]) -> Forces:
    """Motions that are those of a point so many ship lengths forward of the one stated."""
    m, x = run.motion, at["x over L"] * run.ship.L
    if not np.any(m.r):
        return {}
    return run.along(m.with_(v=m.v - x * m.r, vdot=m.vdot - x * m.rdot))


EFFECTS: Final = (
    fault(
        "fault_pmm_amplitude",
        "rig",
        "Sway larger than stated.",
        amplitude,
        (
            size("share", "-", 0.03, "of the sway", step=STEP),
            Parameter(name="of the heading", text="share of the swing of the heading"),
        ),
        check="measure the motion",
        suspects=(
            Suspect(
                name="amplitude",
                says=lambda value: f"the amplitude was {larger_or_smaller(value)} than stated",
                remedy="Measure the motion, or correct the amplitude of the runs.",
                at=_of_strokes,
                grid=SHARES,
                continuous=True,
                applies=swung_by_setting,
            ),
            _amplitude_of("sway", lambda kind: kind.pure == "v"),
            _amplitude_of("yaw", lambda kind: kind.yaws),
            Suspect(
                name="peak to peak",
                says=lambda _: "the amplitude is stated peak to peak, twice the true one",
                remedy="State half of it: amplitude_m and yaw_amplitude_deg count from the middle.",
                at=_of_strokes,
                grid=(0.5,),
                applies=swung_by_setting,
                slip=True,
            ),
        ),
        in_words="PMM amplitude",
    ),
    fault(
        "fault_pmm_phase",
        "rig",
        "Rams out of step: pure yaw sways.",
        phase,
        (
            size("phase", "deg", 1.0, "between the rams", step=DEGREES),
            Parameter(
                name="combined",
                text=f"in yaw alone ({YAW_ALONE:g}), with sway too ({WITH_SWAY:g})",
                grid=(YAW_ALONE, WITH_SWAY),
                continuous=False,
            ),
        ),
        check="record both rams",
        in_words="PMM phase",
    ),
    fault(
        "fault_carriage_speed",
        "rig",
        "The carriage is faster than stated at one speed.",
        carriage,
        (
            size("share", "-", 0.010, "of the speed", step=STEP),
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
        (size("share", "-", 0.3, "of the swing of the surge velocity that is missing", step=STEP),),
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
        (size("x over L", "-", 0.01, "the point forward of the one stated", step=STEP),),
        check="measure where the rig holds the model",
        suspects=(
            Suspect(
                name="motion point",
                says=lambda value: (
                    f"the motion is that of a point {abs(value):.3f} L "
                    f"{'forward' if value > 0 else 'aft'} of the one stated"
                ),
                remedy="Find the point that the encoders refer to and write motion_reference_x.",
                at=lambda value: {"x over L": value},
                grid=both_signs(POINTS),
                continuous=True,
                applies=lambda kind: kind.yaws or kind.circles,
            ),
        ),
        in_words="Point of the motions",
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
        in_words="Forces of the start",
    ),
)
