"""Records, and kinds of records, predicted with what all others say."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from pmmkit.diagnosis.free_running.fits import SetFit
from pmmkit.diagnosis.free_running.hypotheses import probable, weighed
from pmmkit.diagnosis.free_running.information import Forces
from pmmkit.diagnosis.free_running.question import RecordQuestion
from pmmkit.diagnosis.free_running.settling import agile
from pmmkit.diagnosis.free_running.slopes import Sheet, sheets_of
from pmmkit.diagnosis.free_running.windows import RecordWindows, joined, of_instants, sailed, shown
from pmmkit.identification import FreeRecord
from pmmkit.numerics import Array

ERRORS: Final[Mapping[str, tuple[tuple[str, ...], float]]] = {
    "position": (("x", "y"), 1.0),
    "heading": (("psi",), 180.0 / math.pi),
    "speed": (("u", "v"), 1.0),
    "yaw_rate": (("r",), 180.0 / math.pi),
}
"""The channels that each error is told by, and its unit in theirs: m, deg, m/s, deg/s."""
LOST: Final = 1e6
"""A lost motion counts as an error so large."""
LONG: Final = 3
"""Windows that are sailed through in one for the slow growth of what is missed."""
NEAR: Final = 0.01
"""Error of position over the ship length that does not matter."""
AIMED: Final = 0.5
"""Error of heading that does not matter [deg], and of yaw rate, in a time of L/U."""
SLOW: Final = 0.005
"""Error of speed over the approach that does not matter."""
TURNS: Final = 0.8
"""Share of its rudder to one side from which a record is a turn."""


def each(records: Sequence[FreeRecord]) -> list[tuple[int, ...]]:
    """Numbers of what is left out together: one record after another."""
    return [(number,) for number in range(len(records))]


def kinds(records: Sequence[FreeRecord]) -> dict[str, tuple[int, ...]]:
    """Numbers of turns, of zigzags, and of each range of speed, where there are others to predict
    them by."""
    turning = np.array([turns(item) for item in records])
    speeds = np.array([item.speed for item in records])
    fast = speeds > 1.1 * np.min(speeds)
    groups = {"turns": turning, "zigzags": ~turning, "slow records": ~fast, "fast records": fast}
    numbers = {name: tuple(np.flatnonzero(there).tolist()) for name, there in groups.items()}
    return {name: own for name, own in numbers.items() if 0 < len(own) < len(records)}


def turns(record: FreeRecord) -> bool:
    """Whether the rudder stands to one side."""
    return abs(float(np.sum(record.delta))) > TURNS * float(np.sum(np.abs(record.delta)))


def log_left_out(fit: SetFit) -> Array:
    """ln of how probable each record (n,) is by what the others say."""
    numbers = fit.place.question.numbers
    whole = weighed(fit.known, numbers)(fit.names)
    return np.array(
        [
            whole - weighed(fit.known.without([j]), numbers)(fit.names)
            for j in fit.known.owners.tolist()
        ]
    )


def through_windows(question: RecordQuestion, stretch: RecordWindows, z: Array) -> Array:
    """What the channels (n, c) of a record show when a model sails through its windows."""
    change = question.numbers.T @ z
    states = np.nan_to_num(sailed(stretch.free, change), nan=LOST, posinf=LOST, neginf=-LOST)
    return shown(stretch, np.clip(states, -LOST, LOST), change)


def squares(question: RecordQuestion, stretch: RecordWindows, z: Array) -> dict[str, float]:
    """Mean squares of the errors of a record over its windows, the sensors' noise taken off."""
    record = stretch.record
    off = np.stack([record.measured[name] for name in stretch.channels], axis=1)
    off = off - through_windows(question, stretch, z)
    squares_of = {}
    for error, (channels, unit) in ERRORS.items():
        there = [name for name in channels if name in stretch.channels]
        if not there:
            continue
        squares_of[error] = unit**2 * sum(
            _square(
                off[:, stretch.channels.index(name)],
                question.sensors[name] / math.sqrt(stretch.samples),
            )
            for name in there
        )
    return squares_of


def _square(off: Array, noise: float) -> float:
    """Mean square without that of the noise; infinite where the motion is lost."""
    measured = ~np.isnan(off)
    if not measured.any():
        return 0.0
    return max(float(np.mean(np.minimum(np.abs(off[measured]), LOST) ** 2)) - noise**2, 0.0)


def predicted(fit: SetFit, left_out: Sequence[Sequence[int]]) -> list[dict[str, float]]:
    """Mean squares of the errors of all records that are left out in turn."""
    return _predicted(fit, left_out, fit.followed)


def _predicted(
    fit: SetFit, left_out: Sequence[Sequence[int]], question: RecordQuestion
) -> list[dict[str, float]]:
    squares_of = []
    for records in left_out:
        squares_of += missed(question, of_others(fit, records)[0], records)
    return squares_of


def judged(question: RecordQuestion) -> tuple[RecordQuestion, RecordQuestion]:
    """Windows, and so long ones that what pushes slowly shows.

    In a short window it hides behind the start, above all where the drift is not measured.
    """
    longer = tuple(joined(item, LONG) for item in question.stretches)
    return question, replace(question, stretches=longer)


def left_out_error(fit: SetFit, windows: Sequence[RecordQuestion] | None = None) -> float:
    """Mean of ln of the errors of records that are left out one after another.

    Each beside what does not matter of it: below that no set is better than another.
    """
    return mean_log(left_out_errors(fit, windows))


def mean_log(errors: Sequence[Sequence[tuple[float, float]]]) -> float:
    """Mean of ln of `left_out_errors`."""
    logs = [0.5 * math.log(x**2 + small**2) for own in errors for x, small in own]
    return sum(logs) / len(logs)


def left_out_errors(
    fit: SetFit, windows: Sequence[RecordQuestion] | None = None
) -> list[list[tuple[float, float]]]:
    """Errors of records that are left out one after another, each with what does not matter.

    A list for each of the windows, as for `left_out_error`.
    """
    asked = judged(fit.followed) if windows is None else windows
    return [_beside_small(fit, question) for question in asked]


def unimportant(question: RecordQuestion) -> dict[str, float]:
    """What does not matter of each error, in its unit."""
    record, L = question.stretches[0].record, question.model.ship.L
    return {
        "position": NEAR * L,
        "heading": AIMED,
        "speed": SLOW * record.speed,
        "yaw_rate": AIMED * record.speed / L,
    }


def _beside_small(fit: SetFit, question: RecordQuestion) -> list[tuple[float, float]]:
    small = unimportant(question)
    left_out = each([item.record for item in question.stretches])
    errors = pooled(_predicted(fit, left_out, question))
    return [(x, small[name]) for name, x in errors.items()]


def left_out_windows(fit: SetFit, record: int) -> tuple[RecordWindows, Array]:
    """A record in its windows, and what its channels (n, c) show by what the others say."""
    question = fit.followed
    stretch = question.stretches[record]
    return stretch, through_windows(question, stretch, of_others(fit, (record,))[0])


def of_others(fit: SetFit, records: Sequence[int]) -> tuple[Array, Array]:
    """The numbers of a set fitted without some records, and their covariance."""
    others = fit.known.without(records)
    return probable(others, fit.place.question.numbers, fit.names, fit.spread)


def missed(question: RecordQuestion, z: Array, records: Sequence[int]) -> list[dict[str, float]]:
    """Mean squares of the errors of records with some numbers.

    z (q,).
    """
    return [squares(question, question.stretches[j], z) for j in records]


def pooled(found: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """Root mean square over records."""
    names = [name for name in ERRORS if any(name in item for item in found)]
    return {
        name: math.sqrt(float(np.mean([item[name] for item in found if name in item])))
        for name in names
    }


# How far a model may be off where it sails records that were left out.


def band(fit: SetFit, record: int) -> Array:
    """Standard deviation (n, c) of what the channels of a record show that was left out.

    It is that of the values, as well as the other records determine them, of the unknown forces of
    the fit, and of the starts of the windows, as well as the sensors tell them.
    """
    question, numbers = fit.followed, fit.place.question.numbers
    z, covariance = of_others(fit, (record,))
    change, steps = numbers.T @ z, numbers.steps(numbers.used(fit.names))
    stretch = question.stretches[record].free
    whole = numbers.T @ covariance @ numbers.T.T
    sigma = np.array([question.sensors[name] for name in stretch.channels])
    sheets = sheets_of(stretch, change, steps)
    return np.concatenate(
        [
            _of_window(
                stretch,
                w,
                sheet,
                _of_start(sheet, agile(stretch), sigma) + _variances(sheet, whole, fit.forces),
            )
            for w, sheet in enumerate(sheets)
        ]
    )


def pushed(sheet: Sheet, forces: Forces) -> Array:
    """What unknown forces that are standard normal do to the rows (b, p f)."""
    root = forces.root(np.array([sheet.spacing]), sheet.forces.shape[1])[0]
    found: Array = sheet.forces.reshape(len(sheet.forces), -1) @ root
    return found


def _variances(sheet: Sheet, values: Array, forces: Forces) -> Array:
    """Variance (b,) of each row by values and unknown forces."""
    moved = np.einsum("bi,ij,bj->b", sheet.values, values, sheet.values)
    found: Array = np.maximum(moved, 0.0) + np.sum(pushed(sheet, forces) ** 2, axis=1)
    return found


def _of_start(sheet: Sheet, forces: Forces, sigma: Array) -> Array:
    """Variance (b,) of each row by the start, told by the sensors along a path that such unknown
    forces may bend."""
    by = pushed(sheet, forces)
    noise = sigma[sheet.channels] ** 2 / sheet.counts
    told = np.linalg.solve(np.diag(noise) + by @ by.T, sheet.starts)
    size = np.sqrt(np.maximum(np.einsum("bi,bi->i", sheet.starts, told), 1e-300))
    # Columns of one length: positions and rates differ by orders of magnitude.
    known = np.linalg.pinv(sheet.starts.T @ told / np.outer(size, size), hermitian=True)
    begun: Array = np.einsum("bi,ij,bj->b", sheet.starts / size, known, sheet.starts / size)
    return np.maximum(begun, 0.0)


def _of_window(stretch: RecordWindows, w: int, sheet: Sheet, variances: Array) -> Array:
    """Standard deviations (n, c) at the instants of a window, straight lines between its blocks."""
    rows = slice(stretch.begins[w], stretch.begins[w + 1])
    t, blocks = stretch.record.t[rows], stretch.blocks[rows]
    middles = {int(block): float(np.mean(t[blocks == block])) for block in np.unique(blocks)}

    def along(channel: int) -> Array:
        own = sheet.channels == channel
        at = [middles[int(block)] for block in sheet.blocks[own]]
        std: Array = np.interp(t, at, np.sqrt(variances[own]))
        return std

    return np.stack([along(channel) for channel in range(len(stretch.channels))], axis=1)


# What a true model leaves of records that were left out: the level below which no error falls.


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
    stretch = _with_drawn_forces(question.stretches[record], fit.forces, random)
    states = sailed(stretch, change)
    if not np.all(np.isfinite(states)):
        return {}
    seen, scale = shown(stretch, states, change), 1.0 / math.sqrt(stretch.samples)
    measured = {
        name: np.where(
            np.isfinite(stretch.record.measured[name]),
            seen[:, place] + scale * question.sensors[name] * random.standard_normal(len(seen)),
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


def _with_drawn_forces(
    stretch: RecordWindows, forces: Forces, random: np.random.Generator
) -> RecordWindows:
    """A stretch with unknown forces that are drawn."""
    drawn = []
    last = stretch.pieces[stretch.begins[1:] - 1] + 1
    for spacing, pieces in zip(stretch.spacing, last.tolist(), strict=True):
        root = forces.root(np.array([spacing]), pieces)[0]
        drawn.append((root @ random.standard_normal(len(root))).reshape(pieces, -1))
    return stretch.along(stretch.starts, of_instants(stretch, np.concatenate(drawn)))
