"""Columns whose names tell nothing and that are the track of a ship: by her motion alone."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Final

import numpy as np

from pmmkit.intake.guessing import Suggestion
from pmmkit.numerics import Array


def track_told(
    found: Sequence[Suggestion | None], headers: Sequence[str], values: Mapping[int, Array]
) -> tuple[Suggestion | None, ...]:
    """What columns are, with those of a track whose names tell nothing: two along whose course a
    third one heads, their rates, what was held in steps before she turned, and perhaps what was
    held throughout."""
    named = {item.name: place for place, item in enumerate(found) if item}
    clock = named.get("t")
    bare = {
        place: numbers
        for place, numbers in values.items()
        if found[place] is None and np.all(np.isfinite(numbers))
    }
    taken = {"x", "y", "psi", "X", "Y", "N"} & {*named}
    if taken or clock is None or clock not in values or not 3 <= len(bare) <= _MOST_BARE:
        return tuple(found)
    rates = rates_of(values[clock], bare)
    track = _track(bare, rates, len(values[clock]))
    if track is None:
        return tuple(found)
    x, y, psi, unit, side = track
    names = {place: headers[place] or f"column {place + 1}" for place in (x, y, psi)}
    along = f"{names[psi]} heads along its course"
    course = f"the course along {names[x]} and {names[y]}"
    probable = partial(Suggestion, certainty="probably")
    told = {
        x: probable(name="x", reason=along),
        y: probable(name="y", reason=along + ("" if side > 0 else ", to port"), scale=side),
        psi: probable(name="psi", reason=f"it follows {course}", unit=unit),
    }
    for place, (of, factor) in rates.items():
        why, alike = f"the rate of {names.get(of)}", np.isclose(factor, 1.0, rtol=0.03)
        if of == x and alike:
            told[place] = probable(name="xdot", reason=why)
        elif of == y and alike:
            told[place] = probable(name="ydot", reason=why, scale=side)
        elif of == psi:
            own = "deg/s" if (unit == "deg") == alike else "rad/s"
            told[place] = probable(name="r", reason=why, unit=own)
    heading = np.unwrap(bare[psi] * _ANGLES[unit])
    steered = _steered(heading, {k: v for k, v in bare.items() if k not in told})
    if steered is not None:
        place, held = steered
        why = f"held in steps, and {names[psi]} turns after them"
        told[place] = probable(name="delta", reason=why, unit=held)
    elif np.ptp(heading) < _CIRCLE:
        return tuple(found)
    still = [k for k, v in bare.items() if k not in told and k not in rates and _is_held(v)]
    if len(still) == 1 and "n" not in named:
        own = "rpm" if bare[still[0]][0] > _MOST_TURNS else "rps"
        why = f"held throughout, {own} by its size"
        told[still[0]] = Suggestion(name="n", reason=why, certainty="perhaps", unit=own)
    return tuple(told.get(place, item) for place, item in enumerate(found))


def _is_held(numbers: Array) -> bool:
    """Whether numbers stay at one value, as the revolutions of a governed engine do."""
    return bool(numbers.min() > max(_FEWEST_TURNS, (1.0 - _GOVERNED) * numbers.max()))


_GOVERNED: Final = 0.03
"""Share by which revolutions scatter that are held: .9 % of the KVLCC2's in MARIN's turns and
zigzags."""
_MOST_BARE: Final = 16
"""Columns among which a track is looked for, at most."""
_TURNED: Final = math.radians(4.0)
"""A heading that changes by less than this tells no track."""
_ASTRAY: Final = math.radians(25.0)
"""Root mean square of the drift angle of a ship under way, at most: 18° in the tightest turn of the
KVLCC2 with a rudder of 35°."""
_ANGLES: Final = {"deg": math.pi / 180.0, "rad": 1.0}
"""Radians of a unit."""
_FEWEST_TURNS: Final = 0.5
_MOST_TURNS: Final = 30.0
"""Revolutions of a propeller [1/s]: those of a ship's turn more than 0.5, a model's less than 30;
a number beyond that counts minutes."""
_CIRCLE: Final = math.radians(90.0)
"""A heading that changes by more is that of no towed model."""


def _track(
    bare: Mapping[int, Array], rates: Mapping[int, tuple[int, float]], count: int
) -> tuple[int, int, int, str, float] | None:
    """Places of x, y and heading, its unit, and -1 where y counts to port; None where no heading
    follows the course of two others."""
    places = list(bare)
    edges = np.arange(0, count, max(2, count // 300))
    table = np.stack([bare[place] for place in places])[:, edges]
    if table.shape[1] < 20:
        return None
    steps = np.diff(table, axis=1)
    # Where she is, is the rate of nothing; the heading and its rate would be followed too.
    lengths = [k for k, place in enumerate(places) if place not in rates]
    found: list[tuple[float, tuple[int, int, int, str, float]]] = []
    for unit, factor in _ANGLES.items():
        turned = np.unwrap(table * factor, axis=1)
        heading = (turned[:, 1:] + turned[:, :-1]) / 2.0
        still = np.ptp(heading, axis=1) < _TURNED
        for a, b in itertools.permutations(lengths, 2):
            run = np.hypot(steps[a], steps[b])
            if np.mean(run > 0.2 * np.median(run)) < 0.9:
                continue
            # A rate of y is the sine of the course, and no heading.
            barred = [
                place in (places[a], places[b])
                or rates.get(place, (None,))[0] in (places[a], places[b])
                for place in places
            ]
            course = np.unwrap(np.arctan2(steps[b], steps[a]))
            if np.ptp(course) < _TURNED:
                continue
            for side in (1.0, -1.0):
                away = np.angle(np.exp(1j * (side * course - heading)))
                told = 1.0 - np.var(away, axis=1) / np.var(course)
                astray = np.sqrt(np.mean(away**2, axis=1)) > _ASTRAY
                told[barred | still | astray | (told < 0.5)] = 0.0
                c = int(np.argmax(told))
                if told[c] > 0.0:
                    size = float(told[c] * np.var(course))
                    found.append((size, (places[a], places[b], places[c], unit, side)))
    return max(found)[1] if found else None


_HELD_STEPS: Final = 0.5
"""Share of a record in which a rudder stands still, at least."""
_RUDDER: Final = (("deg", 3.0, 50.0), ("rad", 0.05, 0.9))
"""Largest angle of a rudder in a manoeuvre, by unit."""


def _steered(psi: Array, bare: Mapping[int, Array]) -> tuple[int, str] | None:
    """Place of the rudder angle and its unit: it is held, and the rate of turn goes with it."""
    edges = np.arange(0, len(psi), max(2, len(psi) // 60))
    turning = np.diff(psi[edges]) if len(edges) > 20 else np.zeros(0)
    if not turning.any():
        return None
    best: tuple[float, tuple[int, str]] | None = None
    for place, numbers in bare.items():
        own = numbers[edges]
        size = float(np.max(np.abs(own)))
        unit = next((name for name, low, high in _RUDDER if low <= size <= high), None)
        still = np.mean(np.abs(np.diff(own)) < 0.02 * size)
        if unit is None or still < _HELD_STEPS or np.ptp(own) < 0.5 * size:
            continue
        late = [abs(np.corrcoef(own[:-1][: len(turning) - k], turning[k:])[0, 1]) for k in range(5)]
        if max(late) > max(0.5, best[0] if best else 0.0):
            best = max(late), (place, unit)
    return best[1] if best else None


def rates_of(time: Array, values: Mapping[int, Array]) -> dict[int, tuple[int, float]]:
    """Columns that are the rate of change of another one.

    Examples
    --------
    >>> t = np.linspace(0.0, 60.0, 601)
    >>> rates_of(t, {1: np.sin(t), 2: 2.0 * np.cos(t), 3: np.cos(t)})
    {3: (1, 0.999)}
    """
    if not values or not np.all(np.isfinite(np.stack(list(values.values())))):
        return {}
    # Over longer stretches noise is less, and what swings fast is gone.
    return {k: v for count in _STRETCHES for k, v in _rates(time, values, count)}


_STRETCHES: Final = (60, 300)


def _rates(
    time: Array, values: Mapping[int, Array], stretches: int
) -> Iterator[tuple[int, tuple[int, float]]]:
    """Columns whose mean over each of so many stretches is the slope of another one."""
    edges = np.arange(0, len(time), max(2, len(time) // stretches))
    places, table = list(values), np.stack(list(values.values()))
    span = np.diff(time[edges])
    if len(edges) < 20 or not np.all(span > 0):
        return
    summed = np.cumsum((table[:, 1:] + table[:, :-1]) / 2 * np.diff(time), axis=1)
    summed = np.concatenate([np.zeros((len(places), 1)), summed], axis=1)
    means, slopes = np.diff(summed[:, edges]) / span, np.diff(table[:, edges]) / span
    powers = np.sum(slopes**2, axis=1)
    for row, place in enumerate(places):
        if np.ptp(means[row]) < 1e-3 * np.abs(means[row]).max(initial=1e-30):
            continue
        with np.errstate(divide="ignore", invalid="ignore"):
            factors = slopes @ means[row] / powers
            left = np.sum((means[row] - factors[:, None] * slopes) ** 2, axis=1)
        near = np.isclose(factors[:, None], [1.0, 57.29578, 1 / 57.29578], rtol=0.03).any(axis=1)
        share = np.where(near, left / np.sum(means[row] ** 2), np.inf)
        share[row] = np.inf
        best = int(np.argmin(share))
        # Two that hardly change agree by chance: what changes must agree as well.
        if share[best] < 0.01 and left[best] < 0.5 * len(span) * np.var(means[row]):
            yield place, (places[best], float(f"{factors[best]:.3g}"))
