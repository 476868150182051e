"""Whether a named effect has one size in all tests: by kind, speed, side, amplitude, frequency.

The force of the effect, as it is fitted, is multiplied by 1 + δ in the runs of each level of a
factor. With base and effects fitted beside them the scores r of the δ are N(0, S) if the effect has
one size, so r' S⁺ r is a χ². Factors of all effects are asked at once: their chances are Holm's
(1979, Scandinavian Journal of Statistics 6).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from pmmkit.campaigns import Run
from pmmkit.diagnosis.captive.evidence import columns_at, spread, wide
from pmmkit.diagnosis.captive.least_squares import effect_columns
from pmmkit.diagnosis.captive.system import CandidateColumns, System
from pmmkit.diagnosis.findings import Homogeneity
from pmmkit.numerics import Array
from pmmkit.reduction import View

FEWEST: Final = 2
"""Levels that a factor has at least."""
REACH: Final = 1e-9
"""Share of the largest eigenvalue below which levels are not told apart."""


def homogeneity(
    system: System, given: Sequence[CandidateColumns], answer: Sequence[CandidateColumns]
) -> tuple[Homogeneity, ...]:
    """Sizes of the effects of an answer over each factor, the most doubtful first."""
    asked = [block for block in answer if not wide(block) and not block.candidate.each_run]
    if not asked:
        return ()
    factors = _factors(system.views, system.base.ship.L)
    found = [x for block in asked for x in _of_effect(system, given, answer, block, factors)]
    # Factors whose levels are the same runs have one chance, but for rounding: they stay in order.
    found.sort(key=lambda item: float(f"{item.chance:.6e}"))
    held, told = 0.0, []
    for number, item in enumerate(found):
        held = max(held, min((len(found) - number) * item.chance, 1.0))
        told.append(replace(item, chance=held))
    return tuple(told)


def _factors(views: Sequence[View], L: float) -> dict[str, dict[str, frozenset[str]]]:
    """Levels of runs over which an effect may vary, by factor."""
    of_run = {view.run.id: view for view in views}
    swing: dict[str, float] = {}
    for name, view in of_run.items():
        m = view.motion
        moved = (m.v**2 + (m.r * L) ** 2) / view.speed**2
        swing[name] = float(np.sqrt(np.mean(moved)))
    middle = float(np.median(list(swing.values())))
    factors = Run.levels([view.run for view in of_run.values()]) | {
        "amplitude": {
            "in small motions": frozenset(x for x in swing if swing[x] <= middle),
            "in large motions": frozenset(x for x in swing if swing[x] > middle),
        }
    }
    return {factor: levels for factor, levels in factors.items() if len(levels) >= FEWEST}


def _of_effect(
    system: System,
    given: Sequence[CandidateColumns],
    answer: Sequence[CandidateColumns],
    block: CandidateColumns,
    factors: Mapping[str, Mapping[str, frozenset[str]]],
) -> Iterator[Homogeneity]:
    """One effect over every factor of which two levels at least have its force."""
    place = answer.index(block)
    system, blocks = spread(system, [*given, *answer])
    at = np.concatenate([item.places for item in blocks])
    fitted, covariance = system.normal.only(at).posterior
    begin = sum(item.count for item in blocks[: len(given) + place])
    own = fitted[begin : begin + block.count]
    known = [columns_at(piece, at) for piece in system.pieces]
    rest = [piece.data - x @ fitted for piece, x in zip(system.pieces, known, strict=True)]
    raw = effect_columns(system, block)
    left: dict[str, list[Array]] = {}
    for piece in system.pieces:
        channel = piece.projection.channel
        force = raw[channel.name] @ own if channel.name in raw else np.zeros(len(channel.y))
        ids = dict.fromkeys(system.views[i].run.id for i in channel.views)
        for factor, levels in factors.items():
            held = np.array([[name in runs for runs in levels.values()] for name in ids])
            inside = held[piece.projection.run_of_row] * force[:, None]
            left.setdefault(factor, []).append(piece.projection.left(inside))
    for factor, levels in factors.items():
        inner = np.sum([x.T @ x for x in left[factor]], axis=0)
        score, cross = np.zeros(len(levels)), np.zeros((len(at), len(levels)))
        for beside, residual, columns in zip(known, rest, left[factor], strict=True):
            score += columns.T @ residual
            cross += beside.T @ columns
        yield from _varied(
            block.candidate.name,
            factor,
            list(levels),
            inner,
            inner - cross.T @ covariance @ cross,
            score,
        )


def _varied(
    effect: str, factor: str, words: Sequence[str], inner: Array, spread: Array, score: Array
) -> Iterator[Homogeneity]:
    """The χ² of the levels that have a force of the effect."""
    from scipy.stats import chi2

    weight = np.diagonal(inner)
    keep = np.flatnonzero(weight > REACH * weight.max())
    if len(keep) < FEWEST:
        return
    values, vectors = np.linalg.eigh(spread[np.ix_(keep, keep)])
    good = values > REACH * values.max()
    along = vectors[:, good]
    square = float(np.sum((along.T @ score[keep]) ** 2 / values[good]))
    # A common factor is what the fit of the effect itself has: levels are told about their mean.
    share = weight[keep] / weight[keep].sum()
    about = np.eye(len(keep)) - share
    inverse = about @ (along / values[good]) @ along.T
    delta, std = inverse @ score[keep], np.sqrt(np.diagonal(inverse @ about.T))
    names = [words[k] for k in keep.tolist()]
    yield Homogeneity(
        effect=effect,
        factor=factor,
        sizes=dict(zip(names, (1.0 + delta).tolist(), strict=True)),
        std=dict(zip(names, std.tolist(), strict=True)),
        chance=float(chi2.sf(square, int(good.sum()))),
    )
