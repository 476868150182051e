"""Faults of the balance: what its gauges show is not the force at the stated point."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np

from pmmkit.effects.definition import Parameter
from pmmkit.effects.faults.fault import AT_SEA, beside, fault, size, suspicion
from pmmkit.effects.seen import Forces, Move, Observed, Vessel
from pmmkit.effects.suspect import CHANNELS, Suspect, both_signs, larger_or_smaller
from pmmkit.numerics import Array

SHARES: Final = (0.8, 0.9, 0.95, 1.05, 1.1, 1.25)
"""Factors that the checks try on forces."""
POINTS: Final = (0.02, 0.05, 0.1, 0.2)
"""Levers that the checks try, to either side, over the length."""
FORGOTTEN: Final = 0.3
"""Usual size of a share of the mass that is doubted: about what a wrong mass was off by."""


def _of_both_gauges(run: Observed, at: Mapping[str, float], shown: Array) -> Forces:
    """The same history in newtons on the gauge of Y, and in newton metres on that of N."""
    return beside(run, {name: at[name] * shown for name in ("Y", "N")})


def zero(run: Observed, at: Mapping[str, float]) -> Forces:
    """Constant newtons of the gauges."""
    return _of_both_gauges(run, at, np.ones_like(run.t))


def creep(run: Observed, at: Mapping[str, float]) -> Forces:
    """Gauges that creep over a record [N/min, N m/min]."""
    return _of_both_gauges(run, at, run.t / 60.0)


def creep_over_the_day(run: Observed, at: Mapping[str, float]) -> Forces:
    """Gauges that show more from run to run, by so much from the first to the last [N, N m]."""
    return _of_both_gauges(run, at, run.day)


Y_IN_X: Final = 0.0
X_IN_Y: Final = 1.0
"""Places of the forms of `cross_talk` in its grid, as findings and saved steps hold them."""


def cross_talk(run: Observed, at: Mapping[str, float]) -> Forces:
    """Share of one channel in another."""
    shown, share = run.forces, at["share"]
    if "X" not in shown or "Y" not in shown:
        return {}
    if at["into"] == Y_IN_X:
        return {"X": shown["X"] + share * shown["Y"]}
    return {"Y": shown["Y"] + share * shown["X"]}


def gain(run: Observed, at: Mapping[str, float]) -> Forces:
    """Forces shown too large, each by a share of its own."""
    shares = {"Y": at["share"], "X": at["of X"], "N": at["of N"]}
    return {
        channel: (1.0 + share) * run.forces[channel]
        for channel, share in shares.items()
        if share and channel in run.forces
    }


def _of_gain(value: float, *channels: str) -> Mapping[str, float]:
    """Gains of some channels that show their force so many times too large."""
    names = {"Y": "share", "X": "of X", "N": "of N"}
    return {names[channel]: value - 1.0 for channel in channels}


def _own_gain(channel: str) -> Suspect:
    return Suspect(
        name=f"gain of {channel}",
        says=lambda value: (
            f"the gauge of {channel} shows {abs(100 * (value - 1)):.1f} % too "
            f"{'much' if value > 1 else 'little'} (its gain)"
        ),
        remedy=f"Look at the calibration of {channel} in this run: a weight shows it.",
        at=lambda value: _of_gain(value, channel),
        grid=(0.3, 0.5, 0.7, *SHARES, 1.5, 2.0),
        continuous=True,
        scope="one",
        channels=(channel,),
    )


def clipping(run: Observed, at: Mapping[str, float]) -> Forces:
    """An amplifier that bends: it ends at so many times the largest force."""

    def bent(force: Array) -> Array:
        end = at["end"] * np.abs(force).max()
        return np.asarray(end * np.tanh(force / end))

    shown = {c: x for c, x in run.forces.items() if at.get(c)}
    return {c: x + at[c] * (run.shaped(x, bent) - x) for c, x in shown.items()}


def _clipped(channel: str) -> Suspect:
    return Suspect(
        name=f"{channel} clipped",
        says=lambda value: (
            f"the amplifier of {channel} bends at large forces: it is clipped softly, to an end of "
            f"{value:.1f} times the largest"
        ),
        remedy=f"Look at the range of the gauge and the amplifier of {channel}.",
        at=lambda value: {"end": value},
        unknown=channel,
        spread=lambda _: 1.0,
        grid=(0.9, 1.2, 1.6, 2.2),
        channels=(channel,),
    )


def point(run: Observed, at: Mapping[str, float]) -> Forces:
    """Moments about a point so many ship lengths forward of the one stated: N - x Y."""
    shown = run.forces
    if not {"Y", "N"} <= set(shown):
        return {}
    return {"N": shown["N"] - at["x over L"] * run.ship.L * shown["Y"]}


def point_of_the_model(vessel: Vessel) -> Mapping[str, Move]:
    """The captive moments of a model about another point: each N gains from its Y."""
    known = vessel.derivatives()
    arm = {
        f"N{name[1:]}": value
        for name, value in known.items()
        if name[0] == "Y" and f"N{name[1:]}" in known and value
    }
    return {"x over L": Move(values=arm, typical=0.01)} if "Nv" in arm else {}


def inertia(run: Observed, at: Mapping[str, float]) -> Forces:
    """A share of what hangs below the balance left in the forces, as if it were a point mass."""
    m, ship = run.motion, run.ship
    mass = ship.mass if ship.balance_mass is None else ship.balance_mass
    x = ship.xG if ship.balance_xG is None else ship.balance_xG
    share = at["mass share"] * mass
    across = m.vdot + m.u * m.r
    return beside(
        run,
        {
            "X": -share * (m.udot - m.v * m.r - x * m.r**2),
            "Y": -share * (across + x * m.rdot),
            "N": -share * x * across,
        },
    )


def inertia_of_the_model(vessel: Vessel) -> Mapping[str, Move]:
    """Mass, moment of inertia or added mass of a model off, each by a share."""
    known = vessel.derivatives()
    return {
        name: Move(values={name: known[name]}, typical=0.05)
        for name in ("Xudot", "Yvdot", "Nrdot")
        if known.get(name)
    }


EFFECTS: Final = (
    fault(
        "fault_gauge_zero",
        "asymmetry",
        "Gauges that do not show zero at rest: constant newtons.",
        zero,
        (size("Y", "N", 2.4, "shown at rest"), size("N", "N m", 3.5, "shown at rest")),
        check="zero records before and after, and a slow run",
    ),
    fault(
        "fault_cross_talk",
        "gauges",
        "One channel of the balance shows part of another.",
        cross_talk,
        (
            size("share", "-", 0.010, "of the other channel"),
            Parameter(
                name="into",
                text=f"Y in X ({Y_IN_X:g}), X in Y ({X_IN_Y:g})",
                grid=(Y_IN_X, X_IN_Y),
                continuous=False,
            ),
        ),
        check="pull with weights along each axis",
        in_words="Cross-talk of the gauges",
    ),
    fault(
        "fault_gauge_gain",
        "gauges",
        "The side force gauge shows too much.",
        gain,
        (
            size("share", "-", 0.03, "of the side force"),
            Parameter(name="of X", text="share of the longitudinal force"),
            Parameter(name="of N", text="share of the moment"),
        ),
        check="weights; oscillate the dry model",
        suspects=(
            *map(_own_gain, CHANNELS),
            Suspect(
                name="gain of all",
                says=lambda value: (
                    f"all forces are {larger_or_smaller(value)} than they should be (a gain, or "
                    f"the speed of the carriage by half of it)"
                ),
                remedy="Look at the amplifier and at the speed of the carriage.",
                at=lambda value: _of_gain(value, *CHANNELS),
                grid=SHARES,
                continuous=True,
                scope="one",
            ),
        ),
    ),
    fault(
        "fault_moment_point",
        "gauges",
        "Moments about another point than stated.",
        point,
        (size("x over L", "-", 0.01, "the point forward of the one stated"),),
        check="a weight at a known lever",
        moves=point_of_the_model,
        own_checks=("moment reference",),
        suspects=(
            Suspect(
                name="moment point",
                says=lambda value: (
                    f"the moments refer to a point {abs(value):.3f} L "
                    f"{'forward' if value > 0 else 'aft'} of the one stated"
                ),
                remedy="Find the point to which the moments refer and write moment_reference_x.",
                at=lambda value: {"x over L": value},
                grid=both_signs(POINTS),
                continuous=True,
                channels=("N",),
            ),
        ),
        in_words="Point of the moments",
    ),
    fault(
        "fault_inertia",
        "gauges",
        "Part of the model's inertia left in the forces.",
        inertia,
        (size("mass share", "-", 0.02, "of the mass"),),
        check="oscillate the dry model; weigh it",
        moves=inertia_of_the_model,
        own_checks=("inertia",),
        suspects=(
            Suspect(
                name="mass",
                says=lambda _: (
                    "the mass that is taken off as the model's inertia is not the one that "
                    "oscillated"
                ),
                remedy="Weigh what hangs below the balance (balance_mass), or oscillate the dry "
                "model.",
                unknown="mass share",
                spread=lambda _: FORGOTTEN,
                scope="all",
                by_size=True,
            ),
        ),
        in_words="Inertia stated wrong",
    ),
    fault(
        "fault_gauge_drift",
        "gauges",
        "Gauges that creep during a run.",
        creep,
        (
            size("Y", "N/min", 2.0, "creep of the side force"),
            size("N", "N m/min", 3.0, "creep of the moment"),
        ),
        check="zero records after each run",
    ),
    fault(
        "fault_gauge_drift_of_the_day",
        "gauges",
        "Gauges that show more from run to run, in the order of the day.",
        creep_over_the_day,
        (
            size("Y", "N", 2.4, "from the first run to the last"),
            size("N", "N m", 3.5, "from the first run to the last"),
        ),
        check="zero records between the runs; repeat the first run at the end",
        excites=("repeats",),
        not_free_running=AT_SEA,
        in_words="Gauge drift through the day",
    ),
    suspicion(
        "fault_gauge_clipping",
        "gauges",
        "An amplifier that bends at large forces.",
        clipping,
        tuple(map(_clipped, CHANNELS)),
        parameters=(
            *(
                Parameter(name=c, text=f"share of the bend in {c}; 1 is all of it")
                for c in CHANNELS
            ),
            Parameter(name="end", text="end of the amplifier over the largest force"),
        ),
    ),
)
