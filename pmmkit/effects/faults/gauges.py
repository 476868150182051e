"""Faults of the balance: what its gauges show is not the force at the stated point."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np

from pmmkit.effects.effect import Parameter
from pmmkit.effects.faults.fault import AT_SEA, Columns, fault, one, size
from pmmkit.effects.seen import Move, Observed, Vessel
from pmmkit.numerics import Array


def _of_both_gauges(shown: Array) -> Columns:
    """The same history in newtons on the gauge of Y, and in newton metres on that of N."""
    none = np.zeros_like(shown)
    return {"Y": (shown, none), "N": (none, shown)}


def zero(run: Observed, value: float) -> Columns:
    """Constant newtons of the gauges."""
    del value
    return _of_both_gauges(run.project(np.ones_like(run.t)))


def creep(run: Observed, value: float) -> Columns:
    """Gauges that creep over a record [N/min, N m/min]."""
    del value
    return _of_both_gauges(run.project(run.t / 60.0))


def creep_over_the_day(run: Observed, value: float) -> Columns:
    """Gauges that show more from run to run, by so much from the first to the last [N, N m]."""
    del value
    return _of_both_gauges(run.project(np.full_like(run.t, run.day)))


Y_IN_X: Final = 0.0
X_IN_Y: Final = 1.0
"""Places of the forms of `cross_talk` in its grid, as findings and saved steps hold them."""


def cross_talk(run: Observed, into: float) -> Columns:
    """Share of one channel in another."""
    shown = run.expected
    if "X" not in shown or "Y" not in shown:
        return {}
    return one({"X": shown["Y"]} if into == Y_IN_X else {"Y": shown["X"]})


def gain(run: Observed, value: float) -> Columns:
    """The side force shown too large, by a share."""
    del value
    return one({"Y": run.expected["Y"]}) if "Y" in run.expected else {}


def point(run: Observed, value: float) -> Columns:
    """Moments about a point one ship length forward of the one stated: N - x Y."""
    del value
    shown = run.expected
    return one({"N": -run.ship.L * shown["Y"]}) if {"Y", "N"} <= set(shown) else {}


def point_of_the_model(vessel: Vessel) -> Mapping[str, Move]:
    """The captive moments of a model about another point: each N gains from its Y."""
    known = vessel.derivatives()
    arm = {
        f"N{name[1:]}": value
        for name, value in known.items()
        if name[0] == "Y" and f"N{name[1:]}" in known and value
    }
    return {"x over L": Move(values=arm, typical=0.01)} if "Nv" in arm else {}


def inertia(run: Observed, value: float) -> Columns:
    """A share of the ship's mass left in the forces."""
    del value
    m, mass = run.motion, run.ship.mass
    return one(
        {
            "X": run.project(-mass * (m.udot - m.v * m.r)),
            "Y": run.project(-mass * (m.vdot + m.u * m.r)),
        }
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
    ),
    fault(
        "fault_gauge_gain",
        "gauges",
        "The side force gauge shows too much.",
        gain,
        (size("share", "-", 0.03, "of the side force"),),
        known_as="gain",
        check="weights; oscillate the dry model",
    ),
    fault(
        "fault_moment_point",
        "gauges",
        "Moments about another point than stated.",
        point,
        (size("x over L", "-", 0.01, "the point forward of the one stated"),),
        known_as="moment point",
        check="a weight at a known lever",
        moves=point_of_the_model,
    ),
    fault(
        "fault_inertia",
        "gauges",
        "Part of the model's inertia left in the forces.",
        inertia,
        (size("mass share", "-", 0.02, "of the mass"),),
        known_as="inertia",
        check="oscillate the dry model; weigh it",
        moves=inertia_of_the_model,
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
    ),
)
