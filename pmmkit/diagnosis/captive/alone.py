"""What each candidate alone would do to captive tests, before anything is added."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from pmmkit.diagnosis.captive.adequacy import blocks_of
from pmmkit.diagnosis.captive.held_out import held_out
from pmmkit.diagnosis.captive.least_squares import Stack, sizes_of, solved, stacked
from pmmkit.diagnosis.captive.system import CandidateColumns, System
from pmmkit.diagnosis.captive.verdict import taken_as_given
from pmmkit.diagnosis.evidence import RankedSet
from pmmkit.numerics import Array

Changes = dict[str, dict[str, Array]]
"""Change of the model by run and channel, harmonic by harmonic [N, N m]."""


def alone_in_tests(
    system: System,
    given: Sequence[str],
    chosen: Sequence[RankedSet],
    heard: Callable[[int, str], None],
    *,
    changes: bool = True,
) -> tuple[dict[str, dict[str, float]], dict[str, Changes]]:
    """Shares of the error that candidates take away, and what they change, each beside the base."""
    beside, _, known = taken_as_given(system, given)
    base = held_out(system, known, with_level=False)
    before = base.of_channel()
    each = [tuple(blocks_of(beside, entry)) for entry in chosen]
    shares = {}
    for number, (entry, own) in enumerate(zip(chosen, each, strict=True)):
        heard(number, entry.names[0])
        errors = held_out(system, (*known, *own), with_level=False)
        shares[entry.names[0]] = {"all": 1.0 - (errors.share() / base.share()) ** 2} | {
            name: 1.0 - (after / before[name]) ** 2 for name, after in errors.of_channel().items()
        }
    if not changes:
        return shares, {}
    # One stack for all: the features of the smooth floor cost most, and are the same for each.
    stack = stacked(system, [*known, *(block for own in each for block in own)], floor=system.floor)
    first = stack.begin + _width(known)
    edges = np.cumsum([first, *map(_width, each)]).tolist()
    without = _forces(stack, first, range(0))
    return shares, {
        entry.names[0]: _change(system, without, _forces(stack, first, range(begin, end)))
        for entry, (begin, end) in zip(chosen, pairwise(edges), strict=True)
    }


def _width(blocks: Sequence[CandidateColumns]) -> int:
    """Number of columns of some effects."""
    return sum(len(sizes_of(block)) for block in blocks)


def _forces(stack: Stack, known: int, more: range) -> dict[str, Array]:
    """Forces of all rows by channel [N, N m] with the base, its effects and the columns of one
    candidate fitted."""
    floor = range(len(stack.names), stack.white.shape[1])
    kept = np.array([*range(known), *more, *floor])
    effects = kept[stack.begin : -1] - stack.begin
    one = replace(stack, white=stack.white[:, kept], centre=stack.centre[effects])
    count = known + len(more)
    fitted = stack.plain[:, kept[:count]] @ solved(one).solution[:count]
    return {name: fitted[rows] for name, rows in stack.places.items()}


def _change(system: System, before: Mapping[str, Array], after: Mapping[str, Array]) -> Changes:
    """Differences of forces by run and channel; the second cycle by itself is left out."""
    changes: Changes = {}
    for channel in system.channels:
        moved = after[channel.name] - before[channel.name]
        for i, rows in zip(channel.views, channel.rows, strict=True):
            view = system.views[i]
            if not view.early:
                changes.setdefault(view.run.id, {})[channel.name] = moved[rows]
    return changes
