"""Turning circles, zigzags and stops of a submission beside the measured ones."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Final

from pmmkit.campaigns.run import Campaign, Run
from pmmkit.campaigns.test_kinds.registry import kind_of
from pmmkit.errors import DataError, PmmkitError
from pmmkit.metrics import unit_of
from pmmkit.trials import Trial
from pmmkit.trials.evaluate import JUDGED, evaluate
from pmmkit.trials.track import track_of
from pmmkit.validation.manoeuvre import Manoeuvre

_FROUDE: Final = 0.05
"""Share by which Froude numbers of the same manoeuvre may differ: approaches are never alike."""
_ANGLE: Final = math.radians(1.0)
"""Rudder and heading of execute may differ by this."""


def compare_trials(
    submission: Campaign, campaign: Campaign
) -> tuple[tuple[Manoeuvre, ...], tuple[str, ...]]:
    """Free-running manoeuvres of one campaign beside those of another, the measurement.

    Parameters
    ----------
    submission, campaign : Campaign
        As for `compare_submission`.

    Returns
    -------
    tuple of Manoeuvre
    tuple of str
        What a reader must know.

    Raises
    ------
    DataError
        If no manoeuvre has a counterpart.
    """
    found: list[Manoeuvre] = []
    alone: list[str] = []
    notes: list[str] = []
    for run in campaign:
        if run.test not in JUDGED:
            continue
        other = _counterpart(run, campaign, submission)
        if other is None:
            alone.append(run.id)
            continue
        try:
            measured, theirs = evaluate(run, campaign), evaluate(other, submission)
        except PmmkitError as error:
            notes.append(f"{run.id} is left out: {error}")
            continue
        there = resized(theirs, measured.L, measured.speed)
        found.append(
            Manoeuvre(
                run=run,
                trial=measured,
                track=track_of(there),
                submitted_run=other.id,
                std=there.std,
            )
        )
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


def resized(trial: Trial, L: float, speed: float) -> Trial:
    """A trial at another length and approach speed, the same in ship lengths.

    Parameters
    ----------
    trial : Trial
        As it was evaluated.
    L, speed : float
        Ship length [m] and approach speed [m/s].
    """
    length, pace = L / trial.L, speed / trial.speed
    time = length / pace
    per_unit = {"m": length, "s": time, "deg/s": 1.0 / time, "m/s": pace}

    def scaled(values: Mapping[str, float]) -> dict[str, float]:
        return {name: x * per_unit.get(unit_of(name), 1.0) for name, x in values.items()}

    return replace(
        trial,
        L=L,
        speed=speed,
        speed_std=trial.speed_std * pace,
        order=trial.order * time,
        orders=tuple(t * time for t in trial.orders),
        rudder_rate_deg=trial.rudder_rate_deg / time,
        metrics=scaled(trial.metrics),
        std=scaled(trial.std),
        t=trial.t * time,
        x=trial.x * length,
        y=trial.y * length,
        x_ground=trial.x_ground * length,
        y_ground=trial.y_ground * length,
    )


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
    if not kind_of(run.test).turns_rudder:
        return 0.0, 0.0
    rudder = given.rudder
    switch = abs(rudder) if given.switch is None else abs(given.switch)
    return rudder, switch if kind_of(run.test).switches else 0.0
