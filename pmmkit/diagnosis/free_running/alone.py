"""What each candidate alone would do to the records, from what a contest has fitted already."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

from pmmkit.diagnosis.free_running.contest import Contest
from pmmkit.diagnosis.free_running.fits import SetFit
from pmmkit.diagnosis.free_running.hypotheses import probable
from pmmkit.diagnosis.free_running.left_out import each, pooled, predicted, unimportant
from pmmkit.diagnosis.free_running.windows import joined, sailed, shown
from pmmkit.numerics import Array
from pmmkit.simulation import State

MOTION: Final = ("x", "y", "psi", "u", "v", "r")
"""What is told of a path: places [m], heading [rad], velocities [m/s], yaw rate [rad/s]."""


def alone(contest: Contest, name: str | None = None) -> SetFit:
    """The base with one candidate or without any, nothing fitted anew.

    Parameters
    ----------
    contest : Contest
        Of the base.
    name : str, optional
        The candidate.

    Returns
    -------
    SetFit
        Through the equations where the contest has fitted it, else by the linear problem about
        the base alone.
    """
    null = contest.null
    if name is None:
        return null
    for item in contest.settled:
        if item.names == (name,):
            return item.fit
    numbers = null.place.question.numbers
    z, covariance = probable(null.known, numbers, (name,), null.spread)
    return replace(null, names=(name,), z=z, covariance=covariance)


def errors_of(fit: SetFit) -> dict[str, float]:
    """Errors of records that are left out one after another, as a diagnosis tells them."""
    return pooled(predicted(fit, each([item.record for item in fit.followed.stretches])))


def taken_away(fit: SetFit, before: Mapping[str, float], after: Mapping[str, float]) -> float:
    """Share of the mean square errors that an effect takes away, over all kinds of errors.

    Parameters
    ----------
    fit : SetFit
        To the records.
    before, after : mapping of str to float
        Errors without and with the effect. What does not matter is no misfit.
    """
    small = unimportant(fit.place.question)
    left = [(after[k] ** 2 + small[k] ** 2) / (x**2 + small[k] ** 2) for k, x in before.items()]
    return 1.0 - sum(left) / len(left)


def whole_path(fit: SetFit, record: int) -> dict[str, Array]:
    """A record sailed from its begin to its end with the measured rudder.

    Parameters
    ----------
    fit : SetFit
        To all records.
    record : int
        Which.

    Returns
    -------
    dict
        ``t`` [s] and `MOTION`, as the sensors should show it; NaN where the motion is lost.

    Notes
    -----
    It begins where the most probable path does: sensors alone tell the sway of a start too badly
    for a record that is sailed in one. The numbers are those of the linear problem where the fit
    ended, as for the errors of records left out.
    """
    question = fit.place.question
    z = probable(fit.known, question.numbers, fit.names, fit.spread)[0]
    stretch = question.stretches[record]
    whole = joined(stretch, len(stretch.begins)).free
    change = question.numbers.T @ z
    states = sailed(whole, change)
    seen = shown(whole, states, change)
    found = {name: states[:, State[name]] for name in MOTION}
    found |= {name: seen[:, place] for place, name in enumerate(whole.channels) if name in MOTION}
    return {"t": whole.record.t, **found}
