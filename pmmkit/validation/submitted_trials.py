"""Turning circles, zigzags and stops of a submission beside the measured ones."""

from __future__ import annotations

import math
from typing import Final

from pmmkit.base import DataError, PmmkitError
from pmmkit.campaigns import TEST_KINDS, Campaign, Run
from pmmkit.identification import Trial, evaluate_trials
from pmmkit.validation.manoeuvre import ManoeuvreComparison

_FROUDE: Final = 0.05
"""Share by which Froude numbers of the same manoeuvre may differ: approaches are never alike."""
_ANGLE: Final = math.radians(1.0)
"""Rudder and heading of execute may differ by this."""


def compare_trials(
    submission: Campaign, campaign: Campaign
) -> tuple[tuple[ManoeuvreComparison, ...], tuple[str, ...]]:
    """Free-running manoeuvres of one campaign beside those of another, the measurement."""
    found: list[ManoeuvreComparison] = []
    alone: list[str] = []
    notes: list[str] = []
    for run in campaign:
        if run.test not in Trial.TESTS:
            continue
        other = _counterpart(run, campaign, submission)
        if other is None:
            alone.append(run.id)
            continue
        try:
            (measured,) = evaluate_trials(campaign, runs=[run.id])
            (theirs,) = evaluate_trials(submission, runs=[other.id])
        except PmmkitError as error:
            notes.append(f"{run.id} is left out: {error}")
            continue
        there = theirs.resized(measured.L, measured.speed)
        found.append(ManoeuvreComparison(run=run, trial=measured, track=there))
    if not found:
        raise DataError(
            [
                f"No turning circle, zigzag or stop of {submission.title!r} has the orders of one "
                f"of {campaign.title!r}: nothing can be compared.",
                *notes,
            ]
        )
    if alone:
        notes.append(f"Without a counterpart in the submission: {', '.join(alone)}.")
    return tuple(found), tuple(notes)


def _counterpart(run: Run, ours: Campaign, theirs: Campaign) -> Run | None:
    """The run of the submission with the same orders, nearest in speed, of the same id first."""
    Fn = ours.froude(run)
    near = [
        other
        for other in theirs
        if other.test == run.test
        and abs(theirs.froude(other) / Fn - 1.0) <= _FROUDE
        and all(abs(a - b) <= _ANGLE for a, b in zip(_orders(run), _orders(other), strict=True))
    ]
    near.sort(key=lambda other: (other.id != run.id, abs(theirs.froude(other) / Fn - 1.0)))
    return next(iter(near), None)


def _orders(run: Run) -> tuple[float, float]:
    """Rudder and heading of execute [rad], 0 where a test has none."""
    given = run.settings
    if not TEST_KINDS[run.test].turns_rudder:
        return 0.0, 0.0
    rudder = given.rudder
    switch = abs(rudder) if given.switch is None else abs(given.switch)
    return rudder, switch if TEST_KINDS[run.test].switches else 0.0
