"""What a true model leaves of records that were left out: the level below which no error falls."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final

import numpy as np

from pmmkit.diagnosis.free_running.fits import SetFit
from pmmkit.diagnosis.free_running.information import Forces
from pmmkit.diagnosis.free_running.left_out import of_others, pooled, squares
from pmmkit.diagnosis.free_running.windows import RecordWindows, of_instants, sailed, shown
from pmmkit.numerics import Array

DRAWS: Final = 24
"""Records that are made anew in all, each as often as another: three records eight times told the
level of five windows to a tenth."""
RIDGE: Final = 1e-9
"""Comes to the correlations of values that others tell alone, so that they have a root."""


def noise_level(fit: SetFit) -> dict[str, float]:
    """Errors of records left out one after another if the fit says all there is, by channel.

    Each record is made anew from where its windows start, with values that the others allow, the
    unknown forces of the fit and the noise of the sensors; what is then missed is missed by those,
    and by the starts that the sensors tell of it.
    """
    records = len(fit.followed.stretches)
    times = math.ceil(DRAWS / records)
    return pooled([_missed(fit, j, draw) for j in range(records) for draw in range(times)])


def _missed(fit: SetFit, record: int, draw: int) -> dict[str, float]:
    """Mean squares of the errors of a record that is made anew; none where its motion is lost."""
    random = np.random.default_rng([record, draw])
    question, numbers = fit.followed, fit.place.question.numbers
    z, covariance = of_others(fit, (record,))
    change = numbers.T @ (z + _drawn(covariance, random))
    stretch = _pushed(question.stretches[record], fit.forces, random)
    states = sailed(stretch, change)
    if not np.all(np.isfinite(states)):
        return {}
    seen = shown(stretch, states, change)
    measured = {
        name: np.where(
            np.isfinite(stretch.record.measured[name]),
            seen[:, place] + question.sensors[name] * random.standard_normal(len(seen)),
            np.nan,
        )
        for place, name in enumerate(stretch.channels)
    }
    short = question.short[record]
    short = replace(short, record=short.record.with_(measured=measured)).free
    anew = replace(
        question, short=(short.along(states[short.begins[:-1]], short.forces),)
    ).followed(z)
    return squares(anew, anew.stretches[0], z)


def _drawn(covariance: Array, random: np.random.Generator) -> Array:
    """Numbers (q,) with a covariance."""
    size = np.sqrt(np.diagonal(covariance))
    free = size > 0.0
    own = covariance[np.ix_(free, free)] / np.outer(size[free], size[free])
    root = np.linalg.cholesky(own + RIDGE * np.eye(len(own)))
    found = np.zeros(len(size))
    found[free] = size[free] * (root @ random.standard_normal(len(own)))
    return found


def _pushed(stretch: RecordWindows, forces: Forces, random: np.random.Generator) -> RecordWindows:
    """A stretch with unknown forces that are drawn."""
    drawn = []
    last = stretch.pieces[stretch.begins[1:] - 1] + 1
    for spacing, pieces in zip(stretch.spacing, last.tolist(), strict=True):
        root = forces.root(np.array([spacing]), pieces)[0]
        drawn.append((root @ random.standard_normal(len(root))).reshape(pieces, -1))
    return stretch.along(stretch.starts, of_instants(stretch, np.concatenate(drawn)))
