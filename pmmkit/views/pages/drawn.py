"""What each candidate alone would do to the tests, before anything is added."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from pmmkit.diagnosis import (
    CandidateColumns,
    CaptiveTests,
    FreeRecords,
    RankedSet,
    Stack,
    System,
    blocks_of,
    held_out,
    sizes_of,
    solved,
    stacked,
    taken_as_given,
)
from pmmkit.models import Step
from pmmkit.numerics import Array
from pmmkit.views.pages.numbers import short
from pmmkit.views.pages.record_overlays import NUMBERS, record_effects

Overlay = dict[str, dict[str, list[float]]]
"""Change of the model by run and channel, harmonic by harmonic [N, N m]."""


@dataclass(frozen=True, kw_only=True)
class CandidateCurves:
    """What candidates would do to the tests of a campaign.

    `shares`: by effect ``all`` and, by channel or kind of error, ``channels``: shares of the
    mean square error of what is left out that it takes away. What loses the motion has none.
    `overlays`: by effect: of captive tests the change of the model, of records the paths.
    `base`: of records the paths without any candidate.
    """

    shares: Mapping[str, Mapping[str, Any]]
    overlays: Mapping[str, Mapping[str, Any]]
    base: Mapping[str, Any]


def drawn_over(
    evidence: CaptiveTests | FreeRecords,
    steps: Sequence[Step],
    chosen: Sequence[RankedSet],
    heard: Callable[[float, str], None],
    *,
    overlays: bool = True,
    numbers: int = NUMBERS,
) -> CandidateCurves:
    """What each candidate would do, alone beside the base as it stands."""
    names = [entry.names[0] for entry in chosen]

    def told(number: int, name: str) -> None:
        heard(number / len(names), name)

    if isinstance(evidence, CaptiveTests):
        tests = evidence.standing(steps)
        return _captive_effects(tests.system, tests.begun, chosen, told, overlays=overlays)
    if not overlays:
        return CandidateCurves(shares={}, overlays={}, base={})
    shares, paths, base = record_effects(
        evidence.contest(evidence.sets(steps)[-1]), names, told, numbers
    )
    return CandidateCurves(shares=shares, overlays=paths, base=base)


def _captive_effects(
    system: System,
    given: Sequence[str],
    chosen: Sequence[RankedSet],
    heard: Callable[[int, str], None],
    *,
    overlays: bool,
) -> CandidateCurves:
    known = taken_as_given(system, given)
    base = held_out(system, known.blocks, with_level=False)
    before = base.of_channel()
    each = [tuple(blocks_of(known.system, entry)) for entry in chosen]
    shares = {}
    for number, (entry, own) in enumerate(zip(chosen, each, strict=True)):
        heard(number, entry.names[0])
        errors = held_out(system, (*known.blocks, *own), with_level=False)
        after = errors.of_channel()
        shares[entry.names[0]] = {
            "all": short(1.0 - (errors.share() / base.share()) ** 2),
            "channels": {name: short(1.0 - (after[name] / before[name]) ** 2) for name in after},
        }
    if not overlays:
        return CandidateCurves(shares=shares, overlays={}, base={})
    # One stack for all: the features of the smooth floor cost most, and are the same for each.
    whole = _Whole.of(system, known.blocks, each)
    without = whole.forces()
    changes = {
        entry.names[0]: _change(system, without, whole.forces(number))
        for number, entry in enumerate(chosen)
    }
    return CandidateCurves(shares=shares, overlays=changes, base={})


@dataclass(frozen=True, kw_only=True, eq=False)
class _Whole:
    """Base, what is known and all candidates in one stack, and the columns of each candidate."""

    stack: Stack
    known: int
    columns: tuple[slice, ...]

    @classmethod
    def of(
        cls,
        system: System,
        known: Sequence[CandidateColumns],
        each: Sequence[tuple[CandidateColumns, ...]],
    ) -> _Whole:
        stack = stacked(
            system, [*known, *(block for own in each for block in own)], floor=system.floor
        )
        first = stack.begin + sum(len(sizes_of(block)) for block in known)
        ends = np.cumsum([first, *(sum(len(sizes_of(block)) for block in own) for own in each)])
        columns = tuple(slice(int(a), int(b)) for a, b in pairwise(ends))
        return cls(stack=stack, known=first, columns=columns)

    def forces(self, number: int | None = None) -> Mapping[str, Array]:
        """Forces of all rows by channel [N, N m], as the model predicts them that `add` of a
        candidate, or of none, would give."""
        stack = self.stack
        given = range(self.known)
        more = () if number is None else range(stack.plain.shape[1])[self.columns[number]]
        floor = range(len(stack.names), stack.white.shape[1])
        kept = np.array([*given, *more, *floor])
        effects = kept[stack.begin : -1] - stack.begin
        one = replace(stack, white=stack.white[:, kept], centre=stack.centre[effects])
        own = kept[: len(given) + len(more)]
        fitted = stack.plain[:, own] @ solved(one).solution[: len(own)]
        return {name: fitted[rows] for name, rows in stack.places.items()}


def _change(system: System, before: Mapping[str, Array], after: Mapping[str, Array]) -> Overlay:
    found: Overlay = {}
    for channel in system.channels:
        moved = after[channel.name] - before[channel.name]
        for i, rows in zip(channel.views, channel.rows, strict=True):
            view = system.views[i]
            if not view.early:
                found.setdefault(view.run.id, {})[channel.name] = short(moved[rows])
    return found
