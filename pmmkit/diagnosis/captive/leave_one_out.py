"""What is left of an effect without the one run that shows it best: a run may be wrong."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise

import numpy as np

from pmmkit.campaigns import Run
from pmmkit.diagnosis.captive.conditioning import spread
from pmmkit.diagnosis.captive.system import CandidateColumns, System
from pmmkit.diagnosis.captive.whitening import Piece, Places
from pmmkit.inference import Normal
from pmmkit.numerics import Array


def columns_at(piece: Piece, at: Places) -> Array:
    """Columns of a piece at places of the system, zeros where it has none (n + D, q)."""
    where = {place: i for i, place in enumerate(piece.places.tolist())}
    columns = np.zeros((len(piece.data), len(at)))
    for k, place in enumerate(at.tolist()):
        if place in where:
            columns[:, k] = piece.columns[:, where[place]]
    return columns


def taken_with(
    system: System, columns: Sequence[Array], named: Callable[[Run], str] = lambda run: run.id
) -> Mapping[str, Array]:
    """Products of columns that go when a run is left out, base and floor fitted without it.

    columns (n + D, q).

    Notes
    -----
    Whitening is run by run: to leave a run out is to leave its rows out. With S the basis of base
    and floor at these rows, B the columns there, it takes B' (I - S S')⁻¹ B of their products
    (`of_others`).
    """
    products: dict[str, Array] = {}
    for piece, columns_here in zip(system.pieces, columns, strict=True):
        projection = piece.projection
        channel = projection.channel
        first = {
            rows.start: system.views[i].run
            for i, rows in zip(channel.views, channel.rows, strict=True)
        }
        together: dict[str, list[int]] = {}
        for number, rows in enumerate(channel.runs):
            together.setdefault(named(first[int(rows[0])]), []).append(number)
        for name, numbers in together.items():
            rows = np.concatenate([projection.channel.runs[number] for number in numbers])
            part = columns_here[rows].T @ projection.without(numbers) @ columns_here[rows]
            products[name] = products[name] + part if name in products else part
    return products


def least_gains(
    system: System, blocks: Sequence[CandidateColumns], given: Sequence[CandidateColumns] = ()
) -> tuple[tuple[float, str], ...]:
    """ln evidence that each effect of a set adds without the run that helps it most, and that
    run."""
    system, every = spread(system, [*blocks, *given])
    at = np.concatenate([block.places for block in every])
    columns = [np.column_stack([columns_at(p, at), p.data]) for p in system.pieces]
    known = system.normal.only(at)
    edges = np.cumsum([0, *(block.count for block in blocks)])
    rest = [np.delete(np.arange(len(at)), np.arange(a, b)) for a, b in pairwise(edges)]
    least = [(np.inf, "")] * len(blocks)
    for run, taken in taken_with(system, columns).items():
        others = known - Normal.of_products(taken)
        whole = others.log_evidence
        for k, keep in enumerate(rest):
            least[k] = min(least[k], (whole - others.only(keep).log_evidence, run))
    return tuple(least)
