"""What these runs could show at all, before anybody looks at the residuals."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from pmmkit.diagnosis.captive.candidate import Candidate
from pmmkit.diagnosis.captive.evidence import wide
from pmmkit.diagnosis.captive.least_squares import effect_columns
from pmmkit.diagnosis.captive.leave_one_out import columns_at, taken_with
from pmmkit.diagnosis.captive.system import WIDER, CandidateColumns, System
from pmmkit.diagnosis.evidence import ROUNDING, SHOWS, Visible, could_hide, mimics
from pmmkit.effects import Effect
from pmmkit.numerics import Array


def coverage(system: System) -> tuple[Visible, ...]:
    """Coverage of every candidate by the runs of a system; the forces do not enter but by noise."""
    best: dict[str, tuple[float, CandidateColumns]] = {}
    for block in system.blocks:
        signal = _signal(system, block)
        name = block.candidate.name
        if name not in best or signal > best[name][0]:
            best[name] = (signal, block)
    visible = []
    robust = _without_a_run(system, [block for _, block in best.values()])
    for (name, (signal, block)), (left, run) in zip(best.items(), robust, strict=True):
        shown = left >= SHOWS
        visible.append(
            Visible(
                name=name,
                family=block.candidate.family,
                signal=signal,
                without_a_run=left,
                hides=could_hide(signal),
                shown=shown,
                why=""
                if shown
                else _why(
                    block.candidate,
                    signal,
                    run,
                    still=signal <= ROUNDING
                    and not any(np.any(x) for x in effect_columns(system, block).values()),
                ),
                mimics=_mimics(system, block, signal, best) if shown else {},
            )
        )
    # a signal of rounding alone is none: these stand by their names on any machine
    order = sorted(visible, key=lambda x: (-x.signal if x.signal > ROUNDING else 0.0, x.name))
    return (*order, *map(_not_held, system.unasked))


def _not_held(candidate: Candidate) -> Visible:
    """An effect for which the runs hold nothing."""
    return Visible(
        name=candidate.name,
        family=candidate.family,
        signal=0.0,
        without_a_run=0.0,
        hides=math.inf,
        shown=False,
        why=_why(candidate, 0.0, "", still=True),
        mimics={},
    )


def _at_usual_size(block: CandidateColumns) -> Array:
    """Coefficients at the usual size, in units of the prior."""
    if block.candidate.each_run:
        return np.full(block.count, 1.0 / WIDER)
    sizes = np.array(block.candidate.typical)
    centre = block.candidate.centre
    usual: Array = np.array(centre) / (WIDER * np.abs(sizes)) if centre else np.sign(sizes) / WIDER
    return usual


def _signal(system: System, block: CandidateColumns) -> float:
    a = _at_usual_size(block)
    if block.drawn:
        return block.drawn.square_of(a)
    return float(a @ system.normal.information[block.columns, block.columns] @ a)


def _signature(system: System, block: CandidateColumns) -> list[Array]:
    """An effect at its usual size in each channel (n + D,)."""
    a = _at_usual_size(block)
    if block.drawn:
        return block.drawn.left(system.pieces, a)
    return [columns_at(piece, block.places) @ a for piece in system.pieces]


def _without_a_run(system: System, blocks: Sequence[CandidateColumns]) -> list[tuple[float, str]]:
    """What is left of each signal without the run that shows most of it, and that run."""
    shown = zip(*(_signature(system, block) for block in blocks), strict=True)
    columns = [np.column_stack(own) for own in shown]
    taken = {run: np.diagonal(x) for run, x in taken_with(system, columns).items()}
    runs = list(taken)
    lost = np.stack([taken[run] for run in runs])
    return [
        (_signal(system, block) - float(lost[:, k].max()), runs[int(np.argmax(lost[:, k]))])
        for k, block in enumerate(blocks)
    ]


def _why(candidate: Candidate, signal: float, run: str, *, still: bool) -> str:
    if candidate.excites and signal == 0.0:
        lacking = (Effect.EXCITES.get(word, word) for word in candidate.excites)
        return f"these tests lack {' and '.join(lacking)}"
    if still:
        return "these tests do not excite it"
    if signal < 0.1:
        return "the base absorbs it: its coefficients take it over"
    if signal >= SHOWS:
        return f"the run {run} shows it alone; repeat that run"
    return "too small beside noise, run scatter and floor"


def _mimics(
    system: System,
    block: CandidateColumns,
    signal: float,
    others: Mapping[str, tuple[float, CandidateColumns]],
) -> dict[str, float]:
    """Effects that reproduce most of a signature."""
    information = system.normal.information
    products = block.drawn.across if block.drawn else information[:, block.columns]
    name = block.candidate.name
    places = {x: other.places for x, (_, other) in others.items() if x != name and not wide(other)}
    return mimics(information, products @ _at_usual_size(block), signal, places)
