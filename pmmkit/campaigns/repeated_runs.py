"""Runs that repeat each other: what the campaign file says, else equal settings."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Final

import numpy as np

from pmmkit.campaigns.run import Run
from pmmkit.campaigns.run_settings import RUN_SETTINGS
from pmmkit.campaigns.setting import ANGLE, LENGTH, RATE, Resolution, RunSetting
from pmmkit.campaigns.settings import Settings
from pmmkit.numerics import Array

_BESIDE: Final = {"turn_rate": RATE, "strut_spacing": LENGTH, "strut_centre": LENGTH}


def resolution() -> Mapping[str, Resolution]:
    """How far two values of a setting may differ and still be the same one.

    Absolute (SI, radians) and relative. The phase is not among them: it says when a record begins,
    not what was tested.
    """
    return RUN_SETTINGS.derived(_resolution)


def _resolution(settings: Iterable[RunSetting]) -> Mapping[str, Resolution]:
    found = {item.name: item.resolution for item in settings if item.resolution is not None}
    return MappingProxyType(found | _BESIDE)


def repeats(runs: Sequence[Run]) -> tuple[tuple[Run, ...], ...]:
    """Runs in groups that repeat each other.

    A run that states `repeat_of` belongs to that run, whatever its settings are; any other to the
    first run of the same test that was set like it, within `resolution`. A setting that one of
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
        unstated = tuple(settings.value(name) is None for name in resolution())
        kinds.setdefault((test, unstated), []).append((test, settings))
    found = {}
    for keys in kinds.values():
        for key, first in zip(keys, _first_alike([item[1] for item in keys]), strict=True):
            found.update(dict.fromkeys(equal[key], equal[keys[first]][0]))
    return found


def _first_alike(settings: Sequence[Settings]) -> list[int]:
    """Place of the first of settings that each is alike; all state the same ones."""
    limits = resolution()
    values = np.array([[s.value(name) or 0.0 for name in limits] for s in settings])
    allowed = np.array(list(limits.values()))
    angular = np.array([limit is ANGLE for limit in limits.values()])
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
