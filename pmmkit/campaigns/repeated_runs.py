"""Runs that repeat each other: what the campaign file says, else equal settings."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from pmmkit.campaigns.run import Run
from pmmkit.campaigns.settings import Settings
from pmmkit.numerics import Array

SPEED: Final = (0.003, 0.001)
"""3 mm/s or 0.1 %, whichever is larger: what the ITTC (7.5-02-02-01) asks of a carriage. No
programme has two speeds so close."""
ANGLE: Final = (math.radians(0.1), 0.0)
"""0.1°: turntables and steering gears are read to that; programmes step by more than twice."""
LENGTH: Final = (0.001, 0.0)
"""1 mm: to what a crank or a strut is set."""
RATE: Final = (0.0, 0.005)
"""0.5 %: what a drive holds of its revolutions, of a period and of a rate of turn; programmes step
by a few per cent at least."""
SEA: Final = (0.0, 0.02)
"""2 %: to what a wave maker repeats a significant height."""

RESOLUTION: Final = {
    "speed": SPEED,
    "drift": ANGLE,
    "heel": ANGLE,
    "rudder": ANGLE,
    "switch": ANGLE,
    "yaw_amplitude": ANGLE,
    "rudder_amplitude": ANGLE,
    "waves_from": ANGLE,
    "amplitude": LENGTH,
    "depth": LENGTH,
    "strut_spacing": LENGTH,
    "strut_centre": LENGTH,
    "propeller_rps": RATE,
    "period": RATE,
    "wave_period": RATE,
    "turn_rate": RATE,
    "wave_height": SEA,
}
"""How far two values of a setting may differ and still be the same one: absolute (SI, radians) and
relative. The phase is not among them: it says when a record begins, not what was tested."""


def repeats(runs: Sequence[Run]) -> tuple[tuple[Run, ...], ...]:
    """Runs in groups that repeat each other.

    A run that states `repeat_of` belongs to that run, whatever its settings are; any other to the
    first run of the same test that was set like it, within `RESOLUTION`. A setting that one of
    them does not state is another setting.

    Parameters
    ----------
    runs : sequence of Run
        In any order.

    Returns
    -------
    tuple of tuple of Run
        Each run in one group, alone where nothing repeats it. Groups, and the runs in a group, in
        the order in which they came.

    Examples
    --------
    >>> runs = [Run(id=name, test="static_drift", kind="means", loader=None,
    ...             settings=Settings(speed=speed, drift=drift))
    ...         for name, speed, drift in (("a", 1.0, 0.1), ("b", 1.0, 0.2), ("c", 1.001, 0.1))]
    >>> [[run.id for run in group] for group in repeats(runs)]
    [['a', 'c'], ['b']]
    """
    origin = _stated(runs)
    free = [run for run in runs if origin[run.id] == run.id]
    leader = _set_alike(free)
    groups: dict[str, list[Run]] = {}
    for run in runs:
        first = origin[run.id]
        groups.setdefault(leader.get(first, first), []).append(run)
    return tuple(tuple(group) for group in groups.values())


def _stated(runs: Sequence[Run]) -> dict[str, str]:
    """The run at the end of the chain of `repeat_of`; one that is not among `runs` counts too."""
    named = {run.id: run.settings.repeat_of or run.id for run in runs}
    found = {}
    for start in named:
        seen = [start]
        while (following := named.get(seen[-1], seen[-1])) not in seen:
            seen.append(following)
        # where runs name each other in a circle, the one that comes first in `runs` is the origin
        circle = seen[seen.index(following) :]
        found[start] = next((x for x in named if x in circle), following)
    return found


def _set_alike(runs: Sequence[Run]) -> dict[str, str]:
    """The first run of the same test that was set like each, by id."""
    equal: dict[tuple[str, Settings], list[str]] = {}
    for run in runs:
        key = (run.test, replace(run.settings, repeat_of=None))
        equal.setdefault(key, []).append(run.id)
    kinds: dict[tuple[object, ...], list[tuple[str, Settings]]] = {}
    for test, settings in equal:
        unstated = tuple(getattr(settings, name) is None for name in RESOLUTION)
        kinds.setdefault((test, unstated), []).append((test, settings))
    found = {}
    for keys in kinds.values():
        for key, first in zip(keys, _first_alike([item[1] for item in keys]), strict=True):
            found.update(dict.fromkeys(equal[key], equal[keys[first]][0]))
    return found


def _first_alike(settings: Sequence[Settings]) -> list[int]:
    """Place of the first of settings that each is alike; all state the same ones."""
    values = np.array([[getattr(s, name) or 0.0 for name in RESOLUTION] for s in settings])
    allowed = np.array(list(RESOLUTION.values()))
    angular = np.array([RESOLUTION[name] is ANGLE for name in RESOLUTION])
    first = np.full(len(settings), -1)
    for place in range(len(settings)):
        if first[place] < 0:
            later = np.flatnonzero(first < 0)
            first[later[_alike(values[later], values[place], allowed, angular)]] = place
    return [int(place) for place in first]


def _alike(values: Array, one: Array, allowed: Array, angular: Array) -> Array:
    """Whether rows of values are as one of them; 180° is -180°."""
    apart = np.abs(values - one)
    apart = np.where(angular, np.abs(np.remainder(apart + np.pi, 2 * np.pi) - np.pi), apart)
    # the last digits of numbers that were converted may differ
    limit = np.maximum(allowed[:, 0], allowed[:, 1] * np.abs(one)) * (1 + 1e-9)
    alike: Array = np.all(apart <= limit, axis=1)
    return alike
