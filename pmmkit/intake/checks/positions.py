"""Recorded positions by themselves: jumps, steps, digits, and the speed and course beside them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.campaigns import Fixes
from pmmkit.intake.checks.finding import Check, CheckFinding, figure, name_runs
from pmmkit.numerics import Array, last_digits

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign
    from pmmkit.intake.checks.finding import Summary

NDArrayBool = NDArray[np.bool_]

OUTLYING: Final = 8.0
"""A step of position that misses the way of its neighbours by so many times the usual miss."""
OF_THE_WAY: Final = 0.3
"""Or by this share of the usual way between two samples, whichever is more."""
ROUNDED: Final = 4.0
"""Or so many times the miss that a tenth of the steps exceeds: positions with few digits."""
STOOD: Final = 1.5
"""A lasting step is more than so many times the usual way between two samples."""
LONGEST_SPIKE: Final = 10
"""Samples that jump away together and come back together."""
HALF: Final = 6
_GRIDS: Final = (1e-2, 1 / 600, 1e-3, 1 / 6000, 1e-4, 1 / 60000, 1e-5, 1 / 600000, 1e-6)
_GRIDS_M: Final = (100.0, 10.0, 5.0, 1.0, 0.5, 0.1, 0.05)
COARSE: Final = 0.02
WAY: Final = 0.2
SPEED: Final = 0.05
METRES_PER_DEGREE: Final = 111195.0


def position_jumps(t: Array, x: Array, y: Array) -> tuple[NDArrayBool, Array]:
    """Samples that jump away and come back, and steps after which the position stays away.

    Parameters
    ----------
    t, x, y : array (n,)
        Increasing times [s] and positions [m].

    Returns
    -------
    spikes : array of bool (n,)
        Samples that jumped.
    steps : array (m, 3)
        Index of the first sample after a lasting step, and the step in x and y [m].

    Notes
    -----
    The velocity between neighbours is held against the median of the velocities about it. What
    misses it by 8 times the usual and by 0.3 of the usual way is a jump; two that cancel within
    10 samples are a spike, one alone is a step. Across gaps nothing is judged.

    Examples
    --------
    >>> t = np.arange(60.0)
    >>> x = 5.0 * t
    >>> x[20] += 80.0
    >>> spikes, steps = position_jumps(t, x, 0 * t)
    >>> np.flatnonzero(spikes), len(steps)
    (array([20]), 0)
    """
    spikes, none = np.zeros(len(t), bool), np.zeros((0, 3))
    if len(t) < 4 * HALF:
        return spikes, none
    span = np.diff(t)
    rate = np.stack([np.diff(x), np.diff(y)]) / span
    windows = np.lib.stride_tricks.sliding_window_view(
        np.pad(rate, ((0, 0), (HALF, HALF)), mode="edge"), 2 * HALF + 1, axis=1
    )
    miss = (rate - np.median(windows, axis=2)) * span
    size = np.hypot(*miss)
    way = float(np.median(np.hypot(*rate))) * float(np.median(span))
    usual = max(OUTLYING * 1.4826 * float(np.median(size)), ROUNDED * float(np.quantile(size, 0.9)))
    worth = Fixes.ROUNDS * Fixes.rounded(x, y)
    limits = np.maximum(np.maximum(worth[1:], worth[:-1]), max(usual, OF_THE_WAY * way, 1e-9))
    judged = span <= 2.5 * np.median(span)
    found = np.flatnonzero((size > limits) & judged)
    steps: list[tuple[float, float, float]] = []
    place = 0
    while place < len(found):
        first, total = found[place], np.zeros(2)
        limit = float(limits[first])
        for later in range(place, len(found)):
            if found[later] - first > LONGEST_SPIKE:
                break
            total = total + miss[:, found[later]]
            if later > place and float(np.hypot(*total)) <= limit:
                spikes[first + 1 : found[later] + 1] = True
                place = later
                break
        else:
            later = place
        apart = not steps or first + 1 - steps[-1][0] > 2 * HALF
        if not spikes[first + 1] and apart:
            away = _offset(t, np.stack([x, y]), rate, int(first) + 1)
            if float(np.hypot(*away)) > max(limit, STOOD * way):
                steps.append((first + 1.0, float(away[0]), float(away[1])))
        place += 1
    return spikes, np.array(steps) if steps else none


def _offset(t: Array, places: Array, rate: Array, index: int) -> Array:
    """By how much the path goes on elsewhere, from the medians before and after a sample.

    A position that stands for some samples and then catches up goes on where it was.
    """
    before = slice(max(index - 2 * HALF, 0), index)
    after = slice(index, index + 2 * HALF)
    pace = np.median(rate[:, before.start : after.stop], axis=1)
    level = [
        np.median(places[:, part] - pace[:, None] * (t[part] - t[index]), axis=1)
        for part in (before, after)
    ]
    offset: Array = level[1] - level[0]
    return offset


def position_facts(column: Mapping[str, Array], t: Array) -> Mapping[str, float]:
    """Facts of the positions of a free-running record that need no velocities.

    t [s].
    """
    x, y = column["x"], column["y"]
    spikes, steps = position_jumps(t, x, y)
    kept = ~spikes
    facts = {
        "spikes": float(np.count_nonzero(spikes)),
        "steps": float(len(steps)),
        "step_size": float(np.hypot(steps[:, 1], steps[:, 2]).max()) if len(steps) else 0.0,
        "grid": digits(column),
        "way": float(np.sum(np.hypot(*_chords(t, x, y)))) / (len(t) - 1),
    }
    if "sog" in column and not len(steps):
        path = float(np.sum(np.hypot(*_chords(t[kept], x[kept], y[kept]))))
        sog = column["sog"][kept]
        area = float(np.sum(0.5 * (sog[1:] + sog[:-1]) * np.diff(t[kept])))
        if path > 0:
            facts["sog_scale"] = area / path
    return facts


def _chords(t: Array, x: Array, y: Array, count: int = 40) -> tuple[Array, Array]:
    """Ways between places so far apart that noise does not lengthen them."""
    at = np.linspace(t[0], t[-1], count + 1)
    return np.diff(np.interp(at, t, x)), np.diff(np.interp(at, t, y))


def digits(column: Mapping[str, Array]) -> float:
    """Spacing of the digits to which positions are written, at most; 0 if they have many [m].

    Parameters
    ----------
    column : mapping of str to array (n,)
        ``lat`` and ``lon`` [deg], or ``x`` and ``y`` [m].

    Examples
    --------
    >>> digits({"x": np.array([0.5, 3.0]), "y": np.array([1.0, 7.5])})
    0.5
    """
    if {"lat", "lon"} <= set(column):
        values, metre = (column["lat"], column["lon"]), METRES_PER_DEGREE
    else:
        values, metre = (column["x"], column["y"]), 1.0
    for grid in _GRIDS if metre > 1 else _GRIDS_M:
        if all(np.all(np.abs(part / grid - np.rint(part / grid)) < 1e-3) for part in values):
            return grid * metre
    return metre * float(max(last_digits(part).max(initial=0.0) for part in values))


def examine_positions(campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """Positions that jump, step, have too few digits, or do not go as fast as the recorded speed.

    What is said here is handled where a sea trial is evaluated: samples that jump are left out,
    a step is closed with the velocity about it, digits count in the uncertainty.
    """
    held = [item for item in summaries if "spikes" in item.facts]
    for fact, what, remedy in (
        ("spikes", "jump away and come back", "They are left out where a trial is evaluated."),
        (
            "steps",
            "step and stay away",
            "Trim the record to the part after or before it; without that the step is closed with "
            "the velocity about it where a trial is evaluated.",
        ),
    ):
        torn = [item for item in held if item.facts[fact]]
        if torn:
            worst = max(torn, key=lambda item: item.facts[fact])
            size = f" of up to {figure(worst.facts['step_size'], 2)} m" if fact == "steps" else ""
            yield CheckFinding(
                check="positions",
                severity="warning",
                message=f"Positions {what} in {name_runs([item.run.id for item in torn])}: "
                f"{worst.facts[fact]:.0f} times{size} in {worst.run.id} (0 expected).",
                runs=tuple(item.run.id for item in torn),
                remedy=remedy,
                numbers={fact: worst.facts[fact], "step_size": worst.facts["step_size"]},
            )
    coarse = [item for item in held if item.facts["grid"] > WAY * max(item.facts["way"], 1e-9)]
    if coarse:
        worst = max(coarse, key=lambda item: item.facts["grid"])
        grid = worst.facts["grid"]
        yield CheckFinding(
            check="positions",
            severity="warning" if grid > COARSE * campaign.ship.L else "info",
            message=f"Positions are written to {figure(grid, 2)} m "
            f"({grid / campaign.ship.L:.3f} L) in {name_runs([item.run.id for item in coarse])}, "
            f"where the ship goes {figure(worst.facts['way'], 2)} m from sample to sample.",
            runs=tuple(item.run.id for item in coarse),
            remedy="Write them with more digits; velocities come from fits over many samples.",
            numbers={"grid": grid, "way": worst.facts["way"]},
        )
    off = [item for item in held if abs(item.facts.get("sog_scale", 1.0) - 1.0) > SPEED]
    if off:
        scales = np.array([item.facts["sog_scale"] for item in off])
        middle = float(np.median(scales))
        unit = ""
        if math.isclose(middle, 3600 / 1852, rel_tol=0.05):
            unit = " That is near 1.94, knots taken for m/s."
        yield CheckFinding(
            check="positions",
            severity="error" if abs(middle - 1) > 0.3 else "warning",
            message=f"The recorded speed over ground is {figure(middle)} times that of the "
            f"positions in {name_runs([item.run.id for item in off])} (1 expected).{unit}",
            runs=tuple(item.run.id for item in off),
            remedy='State its unit under [columns]: sog = { name = "SOG", unit = "kn" }.',
            numbers={"scale": middle},
        )


CHECKS = (
    Check(
        "positions",
        "positions that jump, have too few digits, or differ from the speed over ground",
        examine_positions,
    ),
)
