"""What each candidate alone would do to the records, from what a contest has fitted already."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from pmmkit.diagnosis.free_running.contest import Contest
from pmmkit.diagnosis.free_running.fits import SetFit
from pmmkit.diagnosis.free_running.hypotheses import probable
from pmmkit.diagnosis.free_running.left_out import each, pooled, predicted, unimportant
from pmmkit.diagnosis.free_running.windows import joined, sailed, shown
from pmmkit.equations import State
from pmmkit.numerics import Array

MOTION: Final = ("x", "y", "psi", "u", "v", "r")
"""What is told of a path: places [m], heading [rad], velocities [m/s], yaw rate [rad/s]."""
SAMPLES: Final = (40, 200)
"""Least and most samples of a path."""
WORSE: Final = -10.0
"""A share below which the motion of some record is lost: it is none."""
Paths = dict[str, dict[str, Array]]
"""By record its time ``t`` [s] and `MOTION`, places in ship lengths."""


def alone_in_records(
    contest: Contest, names: Sequence[str], heard: Callable[[int, str], None], numbers: int
) -> tuple[dict[str, dict[str, float]], dict[str, Paths], Paths]:
    """By candidate its share of the misfit and its paths, and the paths of the base alone."""
    null = alone(contest)
    records = [item.record for item in null.followed.stretches]
    wanted = numbers // (len(records) * (len(names) + 1) * len(MOTION))
    count = min(max(wanted, SAMPLES[0]), SAMPLES[1])
    length = null.place.question.model.ship.L

    def paths(fit: SetFit) -> Paths:
        return {
            record.name: _thinned(whole_path(fit, number), count, length)
            for number, record in enumerate(records)
        }

    before = errors_of(null)
    shares, beside = {}, {}
    for number, name in enumerate(names):
        heard(number, name)
        fit = alone(contest, name)
        after = errors_of(fit)
        whole = taken_away(fit, before, after)
        if whole < WORSE:
            continue
        shares[name] = {"all": whole} | {
            kind: 1.0 - (after[kind] / x) ** 2 if x > 0.0 else 0.0 for kind, x in before.items()
        }
        beside[name] = paths(fit)
    return shares, beside, paths(null)


def _thinned(path: Mapping[str, Array], count: int, length: float) -> dict[str, Array]:
    """A path at so many instants, evenly over its samples, its places in ship lengths."""
    kept = np.unique(np.linspace(0, len(path["t"]) - 1, count).round().astype(int))
    return {
        name: 1.0 / length * values[kept] if name in ("x", "y") else values[kept]
        for name, values in path.items()
    }


def alone(contest: Contest, name: str | None = None) -> SetFit:
    """The base with one candidate or without any, nothing fitted anew."""
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
    """Share of the mean square errors that an effect takes away, over all kinds of errors."""
    small = unimportant(fit.place.question)
    left = [(after[k] ** 2 + small[k] ** 2) / (x**2 + small[k] ** 2) for k, x in before.items()]
    return 1.0 - sum(left) / len(left)


def whole_path(fit: SetFit, record: int) -> dict[str, Array]:
    """A record sailed from its begin to its end with the measured rudder.

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
