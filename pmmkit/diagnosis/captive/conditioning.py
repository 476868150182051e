"""A system beside effects that are known to be there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from pmmkit.diagnosis.captive.drawn import RunEffectColumns
from pmmkit.diagnosis.captive.system import CandidateColumns, System


def condition_on(system: System, blocks: Sequence[CandidateColumns]) -> System:
    """The system of a base that has some effects, of unknown size within their prior.

    Notes
    -----
    With S the columns of what is known, the covariance of the data grows by S S'; of all products
    the part that S explains, with its unit prior, is taken off.
    """
    if not blocks:
        return system
    names = {block.candidate.name for block in blocks}
    rest = [block for block in system.blocks if block.candidate.name not in names]
    if len(blocks) == 1 and blocks[0].drawn and not any(block.drawn for block in rest):
        return replace(_beside_drawn(system, blocks[0].drawn), blocks=tuple(rest))
    if any(block.drawn for block in blocks):
        system, dense = spread(system, [*blocks, *rest])
        blocks, rest = dense[: len(blocks)], list(dense[len(blocks) :])
    return _beside(replace(system, blocks=tuple(rest)), blocks)


def _beside(system: System, blocks: Sequence[CandidateColumns]) -> System:
    taken = system.normal.taken(np.concatenate([block.places for block in blocks]))
    return replace(
        system,
        normal=system.normal.given(taken),
        blocks=tuple(
            block if block.drawn is None else replace(block, drawn=block.drawn.beside(taken))
            for block in system.blocks
        ),
    )


def _beside_drawn(system: System, drawn: RunEffectColumns) -> System:
    known = drawn.solve(np.column_stack([drawn.across.T, drawn.score]))
    normal = system.normal
    return replace(
        system,
        normal=replace(
            normal,
            information=normal.information - drawn.across @ known[:, :-1],
            score=normal.score - drawn.across @ known[:, -1],
            square=normal.square - float(drawn.score @ known[:, -1]),
        ),
    )


def spread(
    system: System, blocks: Sequence[CandidateColumns]
) -> tuple[System, tuple[CandidateColumns, ...]]:
    """A system that holds the columns of some blocks, and these blocks in it."""
    made = []
    for block in blocks:
        if block.drawn is not None:
            system, block = _written_out(system, block)
        made.append(block)
    return system, tuple(made)


def drawn_in(system: System, asked: CandidateColumns) -> CandidateColumns:
    """A block that each run draws as it stands in a system, beside what that knows."""
    key = (asked.candidate.name, asked.value, asked.count)
    return next(
        block
        for block in system.blocks
        if block.drawn and (block.candidate.name, block.value, block.count) == key
    )


def _written_out(system: System, asked: CandidateColumns) -> tuple[System, CandidateColumns]:
    """A system with the columns of a block that each run draws, and that block."""
    old = drawn_in(system, asked)
    drawn = old.drawn
    assert drawn is not None
    normal = system.normal
    width = len(normal.score)
    new = replace(old, columns=slice(width, width + drawn.count), drawn=None)
    blocks = []
    for block in system.blocks:
        if block.drawn and block is not old:
            across = np.vstack([block.drawn.across, drawn.products(block.drawn)])
            block = replace(block, drawn=replace(block.drawn, across=across))
        blocks.append(new if block is old else block)
    edges = np.cumsum([0, *(part.shape[1] for part in drawn.parts)]).tolist()
    return (
        replace(
            system,
            normal=replace(
                normal,
                information=np.block(
                    [[normal.information, drawn.across], [drawn.across.T, drawn.products(drawn)]]
                ),
                score=np.concatenate([normal.score, drawn.score]),
                centre=np.concatenate([normal.centre, np.zeros(drawn.count)]),
            ),
            prior=np.concatenate([system.prior, np.ones(drawn.count)]),
            blocks=tuple(blocks),
            pieces=tuple(
                replace(
                    piece,
                    columns=np.hstack([piece.columns, piece.projection.outside(part.toarray())]),
                    places=np.concatenate([piece.places, width + np.arange(begin, end)]),
                )
                for piece, part, (begin, end) in zip(
                    system.pieces, drawn.parts, pairwise(edges), strict=True
                )
            ),
        ),
        new,
    )
