"""Entries of the catalogue, taken out in turn and hidden in the runs of a user.

The forces of the runs are replaced by those of the fitted base and one entry at a share of its
usual size, with noise and run scatter as they were estimated. The whole of the diagnosis then looks
for it without that entry.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Final

import numpy as np

from pmmkit.base import DataError, Progress, Workers, __version__, each, opened
from pmmkit.diagnosis.captive.base import CaptiveBase
from pmmkit.diagnosis.captive.build import build
from pmmkit.diagnosis.captive.candidate import Candidate
from pmmkit.diagnosis.captive.formula import Source, answer_with_formula
from pmmkit.diagnosis.captive.least_squares import (
    effect_columns,
    linearised,
    refined,
    solved,
    stacked,
)
from pmmkit.diagnosis.captive.system import CandidateColumns, System
from pmmkit.diagnosis.captive.verdict import at_usual_size, signal_of, taken_as_given
from pmmkit.diagnosis.captive.whitening import Channel
from pmmkit.diagnosis.evidence import SHOWS
from pmmkit.diagnosis.findings import Diagnosis
from pmmkit.diagnosis.outside import (
    FILE,
    SIZES,
    End,
    HiddenEntries,
    HiddenEntry,
    read_hidden_entries,
    save_hidden_entries,
)
from pmmkit.numerics import Array, one_thread
from pmmkit.reduction import View

LAYOUT: Final = 1
"""Version of what is hidden, and how."""
ROUNDING: Final = 1e-3
"""Squared signal below which its digits are those of rounding, and differ between machines."""
Rows = Mapping[str, Array]
"""Means and harmonics of all runs by channel (n,)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class OutsideCheck:
    """Where it is told what names stand for outside the catalogue, and who works it out.

    `file`: where the tables lie. `made`: whether a table that is not there is made; it goes on
    where it was interrupted. `executor`: who works, as for `diagnose_captive`. `progress`: told of
    each entry.
    """

    file: Path
    made: bool = False
    executor: Workers = None
    progress: Progress | None = None

    @classmethod
    def beside(
        cls,
        folder: Path,
        *,
        made: bool = False,
        executor: Workers = None,
        progress: Progress | None = None,
    ) -> OutsideCheck:
        """With the file of a folder."""
        return cls(file=folder / FILE, made=made, executor=executor, progress=progress)

    def judged(
        self, found: Diagnosis, system: System, given: Sequence[str], source: Source
    ) -> Diagnosis:
        """A diagnosis of a system with what hidden entries say of it, where they are known."""
        if not self.made and not self.file.is_file():
            return found
        digest = digest_of(system, given)
        try:
            table = read_hidden_entries(self.file).get(digest)
        except DataError as error:
            if not self.made:
                return replace(found, notes=(*found.notes, str(error)))
            table = None
        if self.made and (table is None or not table.complete):
            table = self._made(system, given, source, table, digest)
            if not save_hidden_entries(self.file, table):
                lost = f"{self.file} cannot be written: --outside hides all entries again."
                found = replace(found, notes=(*found.notes, lost))
        if table is None or not table.complete:
            return found
        if self.progress is not None:
            count = len(table.ends)
            self.progress(count, count, f"hidden entries, kept in {self.file.name}")
        return found.beside(table)

    def _made(
        self,
        system: System,
        given: Sequence[str],
        source: Source,
        begun: HiddenEntries | None,
        digest: str,
    ) -> HiddenEntries:
        """The table of a system; each end is kept as soon as it is known."""
        families = {
            x.candidate.name: x.candidate.family
            for x in system.blocks
            if x.candidate.name not in given
        }
        order = [(name, size) for name in families for size in SIZES]
        ends = {(item.effect, item.size): item for item in (begun.ends if begun else ())}
        table = begun or HiddenEntries(digest=digest, families=MappingProxyType(families))
        jobs = [x for x in _drawn(system, given, order, digest) if (x.effect, x.size) not in ends]
        work = partial(
            _called,
            views=system.views,
            base=replace(system.base, values={}),
            candidates=_candidates(system),
            channels=tuple(replace(c, noise=()) for c in system.channels),
            given=tuple(given),
            floor=system.floor,
            source=source,
        )
        names = [f"{job.effect} at {job.size:g} of its usual size" for job in jobs]
        with opened(self.executor, rounds=True) as crew:
            for _, end in each(work, jobs, crew, names=names):
                ends[end.effect, end.size] = end
                table = replace(table, ends=tuple(ends[key] for key in order if key in ends))
                save_hidden_entries(self.file, table)
                if self.progress is not None:
                    self.progress(len(ends), len(order), f"hidden: {end}")
        return table


def digest_of(system: System, given: Sequence[str] = ()) -> str:
    """Of programme, noise, run scatter, base and catalogue: hexadecimal.

    The squared signals of all columns hold what the runs are, how they are weighed, and what each
    entry does to them; six digits of them are the same on every machine.
    """
    signals = np.diagonal(system.normal.information)[: system.floor_columns.start].tolist()
    for block in system.blocks:
        signals += [] if block.drawn is None else block.drawn.squares.tolist()
    base = system.base
    parts = (
        LAYOUT,
        __version__,
        SIZES,
        tuple(given),
        [(x.candidate.name, x.candidate.family, x.value) for x in system.blocks],
        [(name, f"{x:.6g}") for name, x in base.values.items()],
        [f"{x:.6g}" if x > ROUNDING else "0" for x in signals],
        f"{system.floor:.6g}",
    )
    return hashlib.sha256(repr(parts).encode()).hexdigest()


@dataclass(frozen=True, kw_only=True, eq=False)
class HiddenForces:
    """Forces of all runs with one entry hidden in them.

    `effect, size`: which, at which share of its usual size. `rows`: the forces; none where these
    runs cannot show it at that size.
    """

    effect: str
    size: float
    rows: Rows | None


def _drawn(
    system: System, given: Sequence[str], order: Sequence[tuple[str, float]], digest: str
) -> list[HiddenForces]:
    """Forces with each entry hidden in turn; the same of the same digest."""
    with one_thread():
        about, fitted = _fitted(system, given)
        whole = [x for x in about.blocks if not x.candidate.partial]
        made = []
        for name, size in order:
            own = [x for x in whole if x.candidate.name == name]
            seed = hashlib.sha256(f"{digest} {name} {size:g}".encode()).digest()
            rng = np.random.default_rng(np.frombuffer(seed, np.uint32))
            block = own[int(rng.integers(len(own)))]
            shown = signal_of(about, block) * size**2 >= SHOWS
            rows = _with_noise(about, fitted, block, size, rng) if shown else None
            made.append(HiddenForces(effect=name, size=size, rows=rows))
        return made


def _fitted(system: System, given: Sequence[str]) -> tuple[System, Rows]:
    """A system about its base with what is given, and the forces that both have by a joint fit."""
    known = refined(system, taken_as_given(system, given)[-1])
    if known:
        system = linearised(system, known)
        known = refined(system, taken_as_given(system, given)[-1])
    stack = stacked(system, known, floor=system.floor)
    forces = stack.plain[:, :-1] @ solved(stack).solution[: len(stack.names)]
    return system, {name: forces[rows] for name, rows in stack.places.items()}


def _with_noise(
    system: System, fitted: Rows, block: CandidateColumns, size: float, rng: np.random.Generator
) -> Rows:
    """Forces with one entry, noise and what each run draws."""
    columns = effect_columns(system, block)
    coefficients = size * at_usual_size(block)
    if block.candidate.each_run:
        coefficients = coefficients * rng.standard_normal(len(coefficients))
    made = {}
    for piece in system.pieces:
        channel = piece.projection.channel
        rows = fitted[channel.name].copy()
        if channel.name in columns:
            rows += columns[channel.name] @ coefficients
        for own, root in zip(channel.runs, piece.projection.roots, strict=True):
            rows[own] += root @ rng.standard_normal(len(own))
        made[channel.name] = rows
    return made


def _candidates(system: System) -> tuple[Candidate, ...]:
    """What a system is asked for, each once and whole."""
    every = {x.candidate.name: x.candidate for x in system.blocks if not x.candidate.partial}
    return tuple(every.values())


def _called(
    job: HiddenForces,
    *,
    views: Sequence[View],
    base: CaptiveBase,
    candidates: Sequence[Candidate],
    channels: Sequence[Channel],
    given: tuple[str, ...],
    floor: float,
    source: Source,
) -> HiddenEntry:
    """What a hidden entry is called while it is taken out of the candidates."""
    rest = [item for item in candidates if item.name != job.effect]
    if job.rows is None or all(item.each_run for item in rest):
        return HiddenEntry(effect=job.effect, size=job.size, end="not_shown")
    forces = [dict(view.force) for view in views]
    for channel in channels:
        for i, rows in zip(channel.views, channel.rows, strict=True):
            forces[i][channel.name] = job.rows[channel.name][rows]
    read = [replace(view, force=own) for view, own in zip(views, forces, strict=True)]
    with one_thread():
        system = build(read, base, rest, floor=floor).whole(given)
        found = answer_with_formula(system, given, floor=floor, source=source, offered=False)
    return end_of(job.effect, job.size, found)


ENDS: Final[Mapping[str, End]] = {"suspected": "suspected", "unexplained": "unexplained"}
"""Of verdicts that name nothing and say more than noise."""


def end_of(effect: str, size: float, found: Diagnosis) -> HiddenEntry:
    """What a diagnosis called an entry that the catalogue has not."""
    if found.best:
        score = {item.effect: item.log_odds for item in found.findings}
        return HiddenEntry(
            effect=effect,
            size=size,
            end="flagged" if found.flags else "named",
            names=found.best,
            log_odds=tuple(score[name] for name in found.best),
        )
    near = () if found.nearest is None else found.nearest.effects
    return HiddenEntry(effect=effect, size=size, end=ENDS.get(found.verdict, "noise"), names=near)
