"""Whether an answer is the whole story: what it leaves that it should have explained.

What its bounds do is counted by scripts/studies/hidden_effects.py (nothing hidden, one effect, two)
and beyond_catalogue.py (truths that stand in no catalogue); docs/diagnose.md has the tables.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from types import MappingProxyType
from typing import Final

import numpy as np

from pmmkit.diagnosis.captive.evidence import (
    Sets,
    columns_at,
    condition_on,
    drawn_in,
    evidence_of,
    least_gains,
    spread,
)
from pmmkit.diagnosis.captive.system import FEATURES, CandidateColumns, System, is_even
from pmmkit.diagnosis.captive.whitening import Channel, Piece, Places
from pmmkit.diagnosis.evidence import LEAST, PRICE, RankedSet
from pmmkit.diagnosis.findings import SuspectRun
from pmmkit.models import odds
from pmmkit.numerics import Array
from pmmkit.reduction import View

# Symmetry of port and starboard: which parts of a force an effect, or an error of it, can have.


PRESENT: Final = 0.01
"""Share of its square from which a parity counts as one that an effect has."""
Parity = bool
"""True: Y and N odd, X even, as a symmetric ship has them; False: the other."""
BOTH: Final[frozenset[Parity]] = frozenset((True, False))


def mirrored(view: View) -> View:
    """A run in a mirror: sway, yaw, rudder, heel and heading turned over."""
    m = view.motion
    turned = {
        name: -getattr(m, name) for name in ("v", "r", "p", "phi", "vdot", "rdot", "pdot", "delta")
    }
    return replace(
        view, motion=m.with_(**turned), heading=-view.heading, expected=MappingProxyType({})
    )


def parities(system: System, block: CandidateColumns) -> frozenset[Parity]:
    """Parities that an effect has: those of its columns in a motion and in its mirror."""
    if block.candidate.each_run:
        return BOTH
    squares = {True: 0.0, False: 0.0}
    seen = {(view.run.test, round(view.speed, 6)): view for view in system.views}
    scale = {channel.name: channel.scale for channel in system.channels}
    views = list(seen.values())
    both = (
        block.candidate.columns(own, system.base, block.value)
        for own in (views, [mirrored(view) for view in views])
    )
    for view, here, there in zip(views, *both, strict=True):
        for name in here:
            other = there[name] if is_even(name) else -there[name]
            unit = scale[name] * view.speed**2
            for own, part in ((True, here[name] + other), (False, here[name] - other)):
                squares[own] += float(np.sum((0.5 * part / unit) ** 2))
    whole = sum(squares.values())
    return frozenset(own for own, square in squares.items() if square > PRESENT * whole) or BOTH


def floor_places(system: System, wanted: frozenset[Parity]) -> Places:
    """Places of the smooth floor's features of some parities."""
    at = np.arange(system.floor_columns.start, system.floor_columns.stop)
    of_ship = (at - system.floor_columns.start) % FEATURES < FEATURES // 2
    places: Places = at[[parity in wanted for parity in of_ship.tolist()]]
    return places


SMOOTH: Final = 3.0
"""ln evidence from which something smooth is left that the answer does not explain."""
LACK: Final = 6.0
"""ln evidence from which the forces of some tests scatter more than noise lets them."""
UnexplainedScatter = tuple[float, str, str, str]
"""ln evidence, averaged over `SIZES`, that rows scatter more about an answer than noise and run
scatter let them, against none; their channel, test and harmonic, ``all`` for every one."""
SIZES: Final = (0.0025, 0.005, 0.01, 0.02, 0.04)
"""Sizes of a lack of fit that are tried, over the rms force of a channel."""
MANY: Final = 3
"""So many effects at once are more often one that is not in the catalogue."""
FORM: Final = 4.0
"""Floors as large as the errors of form that a catalogue's effect must be expected to have."""
NEEDED: Final = 3.0
"""ln evidence that an effect must keep beside others whose form may err."""
KIN: Final = 0.25
"""Share of the gain of another of its family below which an effect may be an error of its form."""
MAY_ERR: Final = "may stand for an error of form of the others"
LOOKED_AT: Final = 80
"""Oscillating runs that are looked at for a lack of fit."""
HIGH: Final = 3
"""First of the high harmonics, which a smooth force hardly has."""


def chosen(
    system: System, entries: Sequence[RankedSet], given: Sequence[CandidateColumns] = ()
) -> RankedSet | None:
    """The best set of which every effect is needed."""
    known = condition_on(system, given)
    symmetry = cache(partial(parities, known))
    least = PRICE + LEAST
    alone: set[str] = set()
    unneeded: list[set[str]] = []
    for entry in entries:
        if entry.log_evidence <= LEAST:
            return None
        names = set(entry.names)
        if names & alone or any(names >= other for other in unneeded):
            continue
        blocks = blocks_of(known, entry)
        if min(gains(known, blocks, symmetry)) < NEEDED:
            unneeded.append(names)
            continue
        left = least_gains(system, blocks, given)
        if min(left)[0] >= least:
            return entry
        alone |= {name for name, (gain, _) in zip(entry.names, left, strict=True) if gain < least}
    return None


def blocks_of(system: System, entry: RankedSet) -> list[CandidateColumns]:
    """The effects of a set at their best grid points."""
    return [
        next(
            b
            for b in system.blocks
            if (b.candidate.name, b.value, b.candidate.size) == (name, value, terms)
        )
        for name, value, terms in zip(entry.names, entry.values, entry.terms, strict=True)
    ]


def gains(
    system: System,
    blocks: Sequence[CandidateColumns],
    symmetry: Callable[[CandidateColumns], frozenset[Parity]] | None = None,
) -> tuple[float, ...]:
    """ln evidence that each effect of a set adds to the others where their form may err.

    A hull never follows v² r exactly. The error of form is a smooth force `FORM` times the floor,
    with the symmetry of the others: an error of form of an odd force is odd. One effect alone adds
    all there is: infinity.
    """
    if len(blocks) < 2:
        return (math.inf,) * len(blocks)
    of = cache(partial(parities, system)) if symmetry is None else symmetry
    added = []
    for place, _ in enumerate(blocks):
        others = [other for k, other in enumerate(blocks) if k != place]
        err = frozenset[Parity]().union(*map(of, others))
        whole = _with_floor(system, blocks, FORM, err)
        added.append(whole - _with_floor(system, others, FORM, err))
    return tuple(added)


def flags(
    system: System,
    blocks: Sequence[CandidateColumns],
    given: Sequence[CandidateColumns] = (),
    more: Sequence[str] = (),
) -> tuple[str, ...]:
    """Reasons to think that something else is left beside an answer, with `more` of them."""
    known, reasons = condition_on(system, given), []
    if remainder(known, blocks) > SMOOTH:
        reasons.append("something smooth in the motion is left")
    for log_evidence, channel, test, harmonic in lack_of_fit(system, [*given, *blocks])[:1]:
        if log_evidence > LACK:
            reasons.append(f"{harmonic} of {channel} in {test} is not explained")
    if len(blocks) >= MANY:
        reasons.append(f"{len(blocks)} effects are needed at once")
    reasons += [f"{name} {MAY_ERR}" for name in _lesser_kin(known, blocks)]
    reasons += more
    return ("not_the_whole_story", *reasons) if reasons else ()


@dataclass(frozen=True, kw_only=True)
class RefusedEffect:
    """An effect of the set of the greatest evidence that is not named.

    `log_odds`: ln of the odds for it beside the others of the set. `run`: the run without which
    it would not pay its price; empty where it may be an error of form. `others`: ln evidence for
    it without that run, before any price.
    """

    block: CandidateColumns
    log_odds: float
    run: str = ""
    others: float = 0.0

    def __str__(self) -> str:
        name = self.block.candidate.name
        if not self.run:
            return f"{name} {MAY_ERR}"
        who = f"{name} ({odds(self.log_odds)})"
        if self.suspect.agrees:
            return f"{who}: the run {self.run} carries most of it, and the other runs agree"
        return f"{who} hangs on the run {self.run} alone: repeat it"

    @property
    def suspect(self) -> SuspectRun:
        """The run that decides it."""
        return SuspectRun(
            effect=self.block.candidate.name,
            run=self.run,
            log_odds=self.log_odds,
            others=self.others,
        )


def refused(
    system: System,
    sets: Sets,
    first: RankedSet,
    blocks: Sequence[CandidateColumns],
    given: Sequence[CandidateColumns] = (),
) -> tuple[RefusedEffect, ...]:
    """Effects of the set of the greatest evidence that are not in the answer, and why.

    What adds next to nothing to the others of the set is left out.
    """
    answered = [block.candidate.name for block in blocks]
    if first.log_evidence <= LEAST or set(first.names) <= set(answered):
        return ()
    tried = blocks_of(sets.system, first)
    least = PRICE + LEAST
    return tuple(
        RefusedEffect(block=block, log_odds=log_odds, run=run if left < least else "", others=left)
        for block, log_odds, (left, run) in zip(
            tried, sets.added(first), least_gains(system, tried, given), strict=True
        )
        if block.candidate.name not in answered and log_odds > LEAST
    )


def _lesser_kin(system: System, blocks: Sequence[CandidateColumns]) -> list[str]:
    """Effects that add little beside another of their family: what its form may err by."""
    added = list(zip(blocks, gains(system, blocks), strict=True))
    return [
        block.candidate.name
        for block, gain in added
        if any(
            other.candidate.family == block.candidate.family and gain < KIN * most
            for other, most in added
        )
    ]


def remainder(system: System, blocks: Sequence[CandidateColumns]) -> float:
    """ln evidence that something smooth is left beside some effects, larger than the floor.

    What is symmetric as a ship is, and what is not, have sizes of their own: two tries, each as
    likely as the other.
    """
    without = _with_floor(system, blocks)
    top = max(
        _with_floor(system, blocks, factor, frozenset((parity,))) - without
        for parity in BOTH
        for factor in (2.0, 4.0, 8.0)
    )
    return top - math.log(len(BOTH))


def _with_floor(
    system: System,
    blocks: Sequence[CandidateColumns],
    factor: float = 1.0,
    wanted: frozenset[Parity] = frozenset(),
) -> float:
    """ln evidence of blocks beside a floor larger by a factor in some parities, against the floor
    as it is."""
    alone, drawn = 0.0, [block for block in blocks if block.drawn]
    if len(drawn) == 1:
        one = drawn_in(system, drawn[0])
        alone = evidence_of(system, one)
        blocks = [block for block in blocks if not block.drawn]
        system = condition_on(replace(system, blocks=(*blocks, one)), [one])
    system, blocks = spread(system, blocks)
    floor = floor_places(system, wanted)
    at = np.concatenate([*(block.places for block in blocks), floor])
    if not len(at):
        return alone
    size = np.ones(len(at))
    size[len(at) - len(floor) :] = math.sqrt(factor**2 - 1.0)
    return alone + system.normal.only(at, size).log_evidence


def lack_of_fit(
    system: System, blocks: Sequence[CandidateColumns]
) -> tuple[UnexplainedScatter, ...]:
    """Scatter of the oscillating runs beyond noise, by channel, test and harmonic; worst first.

    A force that no run repeats, or that jumps, has no smooth form; but it makes a harmonic of one
    kind of test scatter more about the answer than the noise between the harmonics allows. Means
    are left out: what each run draws as its offset is not normal on every rig.
    """
    system, blocks = spread(system, blocks)
    at = np.concatenate([np.zeros(0, np.intp), *(block.places for block in blocks)])
    fitted, covariance = system.normal.only(at).posterior
    lacks = [
        lack
        for piece in system.pieces
        for lack in _lacks(system.views, piece, columns_at(piece, at), fitted, covariance)
    ]
    return tuple(sorted(lacks, key=lambda lack: -lack[0]))


def _lacks(
    views: Sequence[View], piece: Piece, columns: Array, fitted: Array, covariance: Array
) -> list[UnexplainedScatter]:
    projection = piece.projection
    groups, runs, unit = _units(views, projection.channel)
    if not groups:
        return []
    white = projection.whitened_runs(runs, unit)
    rows = np.concatenate([projection.channel.runs[number] for number in runs])
    explained = projection.span[rows].T @ white
    shared = white.T @ columns[rows]
    gram = white.T @ white - explained.T @ explained - shared @ covariance @ shared.T
    score = white.T @ (piece.data[rows] - columns[rows] @ fitted)
    lacks = []
    for (test, harmonic), members in groups.items():
        values, vectors = np.linalg.eigh(gram[np.ix_(members, members)])
        values, power = np.maximum(values, 0.0), (vectors.T @ score[members]) ** 2
        growth = np.square(SIZES)[:, None]
        tried = 0.5 * np.sum(
            growth * power / (1.0 + growth * values) - np.log1p(growth * values), axis=1
        )
        top = float(tried.max())
        log_evidence = top + math.log(float(np.mean(np.exp(tried - top))))
        lacks.append((log_evidence, projection.channel.name, test, harmonic))
    return lacks


def _units(
    views: Sequence[View], channel: Channel
) -> tuple[Mapping[tuple[str, str], list[int]], tuple[int, ...], Array]:
    """A column for each harmonic of each oscillating run, all its cycles alike: their groups, the
    numbers of these runs, and the columns in the rows of these runs.

    Columns have the rms force of the channel at the speed of the run. Of very many runs `LOOKED_AT`
    are taken, evenly.
    """
    of_channel = dict.fromkeys(views[i].run.id for i in channel.views)
    numbers = {run: number for number, run in enumerate(of_channel)}
    ids = list(dict.fromkeys(views[i].run.id for i in channel.views if views[i].run.dynamic))
    looked_at = ids[:: max(-(-len(ids) // LOOKED_AT), 1)]
    runs = tuple(numbers[run] for run in looked_at)
    every = [row for number in runs for row in channel.runs[number].tolist()]
    place = {row: k for k, row in enumerate(every)}
    columns: dict[tuple[str, int], Array] = {}
    groups: dict[tuple[str, str], list[int]] = {}
    for i, rows in zip(channel.views, channel.rows, strict=True):
        view = views[i]
        if rows.start not in place:
            continue
        for row in range(1, view.rows):
            if (view.run.id, row) not in columns:
                for group in _groups(view.run.test, row):
                    groups.setdefault(group, []).append(len(columns))
                columns[view.run.id, row] = np.zeros(len(place))
            columns[view.run.id, row][place[rows.start + row]] = channel.scale * view.speed**2
    return groups, runs, np.stack([*columns.values()], axis=1) if columns else np.zeros((0, 0))


def _groups(test: str, row: int) -> list[tuple[str, str]]:
    order = (row + 1) // 2
    harmonics = [f"{'CS'[(row + 1) % 2]}{order}", "all"]
    if order >= HIGH:
        harmonics.append("high")
    return [(kind, harmonic) for kind in (test, "all") for harmonic in harmonics]
