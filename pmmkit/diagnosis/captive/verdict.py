"""What a system answers: nothing, effects with their rivals, a suspicion, something unknown."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from pmmkit.diagnosis.captive.adequacy import blocks_of, chosen, flags, refused
from pmmkit.diagnosis.captive.candidate import Candidate
from pmmkit.diagnosis.captive.disagreement import telling
from pmmkit.diagnosis.captive.evidence import (
    HELD,
    Sets,
    best_blocks,
    columns_at,
    condition_on,
    gate,
    ranked_sets,
    sets_of,
    taken_with,
    wide,
)
from pmmkit.diagnosis.captive.held_out import HeldOut, Misfit, condition, held_out
from pmmkit.diagnosis.captive.homogeneity import homogeneity
from pmmkit.diagnosis.captive.least_squares import (
    JointFit,
    effect_columns,
    joint_fit,
    labels,
    linearised,
    refined,
)
from pmmkit.diagnosis.captive.system import WIDER, CandidateColumns, System
from pmmkit.diagnosis.captive.whitening import Places
from pmmkit.diagnosis.evidence import (
    LEAST,
    RIVALS,
    ROUNDING,
    SHOWS,
    RankedSet,
    Visible,
    could_hide,
    mimics,
    not_asked,
    not_held,
)
from pmmkit.diagnosis.findings import Diagnosis, Finding, Nearest, Verdict
from pmmkit.effects import BY_SPEED, CATALOGUE, Effect
from pmmkit.inference import Normal
from pmmkit.numerics import Array, one_thread

# What these runs could show at all, before anybody looks at the residuals.


def coverage(system: System) -> tuple[Visible, ...]:
    """Coverage of every candidate by the runs of a system; the forces do not enter but by noise."""
    best: dict[str, tuple[float, CandidateColumns]] = {}
    for block in system.blocks:
        signal = signal_of(system, block)
        name = block.candidate.name
        if name not in best or signal > best[name][0]:
            best[name] = (signal, block)
    visible = []
    robust = _without_a_run(system, [block for _, block in best.values()])
    names = [name for name, (left, _) in zip(best, robust, strict=True) if left >= SHOWS]
    mimicked = _mimics(system, names, best)
    for (name, (signal, block)), (left, run) in zip(best.items(), robust, strict=True):
        shown = left >= SHOWS
        visible.append(
            Visible(
                name=name,
                family=block.candidate.family,
                signal=signal,
                without_a_run=left,
                hides=_could_hide(system, block, left / signal if signal > 0.0 else 0.0),
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
                mimics=mimicked.get(name, {}),
            )
        )
    # a signal of rounding alone is none: these stand by their names on any machine
    order = sorted(visible, key=lambda x: (-x.signal if x.signal > ROUNDING else 0.0, x.name))
    return (*order, *map(_not_held, system.unasked))


def _not_held(candidate: Candidate) -> Visible:
    """An effect for which the runs hold nothing."""
    return not_held(candidate.name, candidate.family, _why(candidate, 0.0, "", still=True))


def at_usual_size(block: CandidateColumns) -> Array:
    """Coefficients at the usual size, in units of the prior."""
    if block.candidate.each_run:
        return np.full(block.count, 1.0 / WIDER)
    sizes = np.array(block.candidate.typical)
    centre = block.candidate.centre
    usual: Array = np.array(centre) / (WIDER * np.abs(sizes)) if centre else np.sign(sizes) / WIDER
    return usual


def signal_of(system: System, block: CandidateColumns) -> float:
    """Squared signal over noise at the usual size."""
    a = at_usual_size(block)
    if block.drawn:
        return block.drawn.square_of(a)
    return float(a @ system.normal.information[block.columns, block.columns] @ a)


def _could_hide(system: System, best: CandidateColumns, share: float) -> float:
    """Share of its usual size that could hide without the run that shows most of it, in the middle
    of the grid; `share` is what that leaves of the signal."""
    name, size, share = best.candidate.name, best.candidate.size, max(share, 0.0)
    sizes = []
    for block in system.blocks:
        if (block.candidate.name, block.candidate.size) != (name, size):
            continue
        usual, at = at_usual_size(block), block.columns
        if block.drawn:
            sizes.append(could_hide(share * block.drawn.squares, usual))
        else:
            inside, centre = system.normal.information[at, at], system.normal.centre[at]
            sizes.append(could_hide(share * inside, usual, centre))
    return sorted(sizes)[len(sizes) // 2]


def _signature(system: System, block: CandidateColumns) -> list[Array]:
    """An effect at its usual size in each channel (n + D,)."""
    a = at_usual_size(block)
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
        (signal_of(system, block) - float(lost[:, k].max()), runs[int(np.argmax(lost[:, k]))])
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
    system: System, names: Sequence[str], every: Mapping[str, tuple[float, CandidateColumns]]
) -> dict[str, dict[str, float]]:
    """Effects that reproduce most of the signature of each of some."""
    information = system.normal.information
    across = [np.zeros((len(information), 0))]
    for name in names:
        block = every[name][1]
        products = block.drawn.across if block.drawn else information[:, block.columns]
        across.append((products @ at_usual_size(block))[:, None])
    places = {name: block.places for name, (_, block) in every.items() if not wide(block)}
    signals = np.array([every[name][0] for name in names])
    found = mimics(information, np.hstack(across), signals, places)
    return {
        name: {other: share for other, share in own.items() if other != name}
        for name, own in zip(names, found, strict=True)
    }


# Predictions of left-out conditions by the set that the other conditions would have chosen.


MOST: Final = 12
"""Sets that stand for election beside the best."""


def chosen_anew(
    system: System,
    entries: Sequence[RankedSet],
    best: RankedSet,
    predicted: HeldOut,
    given: Sequence[CandidateColumns] = (),
) -> HeldOut:
    """Held-out errors with the effects chosen anew for each condition, from all others."""
    blocks = blocks_of(system, best)
    if any(wide(block) for block in (*blocks, *given)):
        return predicted
    loss_of_best = _losses(system, [blocks], given)[0]
    least = best.log_evidence + min(loss_of_best.values(), default=0.0)
    rivals = [
        item
        for item in entries
        if item is not best
        and item.log_evidence > least
        and not any(wide(block) for block in blocks_of(system, item))
    ][:MOST]
    losses = [loss_of_best, *_losses(system, [blocks_of(system, item) for item in rivals], given)]
    elected: dict[int, list[int]] = {}
    for number, name in enumerate(predicted.conditions):
        left = [
            item.log_evidence + loss.get(name, 0.0)
            for item, loss in zip((best, *rivals), losses, strict=True)
        ]
        elected.setdefault(int(np.argmax(left)), []).append(number)
    for winner, rows in elected.items():
        if winner:
            more = [*given, *blocks_of(system, rivals[winner - 1])]
            other = held_out(system, more, with_spread=False)
            predicted = predicted.with_rows_of(other, rows)
    return predicted


def _losses(
    system: System, sets: Sequence[Sequence[CandidateColumns]], given: Sequence[CandidateColumns]
) -> list[Mapping[str, float]]:
    """Change of the ln evidence of each set, beside what is given, without each condition."""
    if not sets:
        return []
    every = {id(block): block for own in sets for block in (*own, *given)}
    at = np.concatenate([block.places for block in every.values()])
    place = {column: k for k, column in enumerate(at.tolist())}
    where = [
        np.array([place[x] for block in (*own, *given) for x in block.places.tolist()])
        for own in sets
    ]
    beside = np.array([place[x] for block in given for x in block.places.tolist()], np.intp)
    columns = [np.column_stack([columns_at(p, at), p.data]) for p in system.pieces]
    whole = system.normal.only(at)
    taken = taken_with(system, columns, condition)
    names = list(taken)

    def loss(cut: Places) -> Array:
        if not len(cut):
            return np.zeros(len(names))
        known = whole.only(cut)
        left, few = [], max(1, HELD // len(cut) ** 2)
        for begin in range(0, len(names), few):
            own = np.stack([taken[name] for name in names[begin : begin + few]])
            left.append((known - Normal.of_products(own).only(cut)).log_evidences)
        return np.concatenate(left) - known.log_evidence

    before = loss(beside)
    return [dict(zip(names, (loss(cut) - before).tolist(), strict=True)) for cut in where]


CHANCE: Final = 0.01
"""A best effect that chance alone gives more often than this is no finding; nor is a set whose
errors of left-out conditions noise gives less often."""
ROUNDS: Final = 2
"""So often sets are ranked anew, at most, about what the last ranking names."""
FALLS: Final = 0.001
"""Share by which the error of left-out conditions falls with an effect that tells something of
others. Of 66 names at .3 of the usual size it falls by .5 % and more with 64, all right; with the
two others, a transient and a late clock, it does not fall."""
ABOVE: Final = "errors of left-out conditions stay above noise"


def answer(system: System, given: Sequence[str] = (), *, floor: float, seed: int = 0) -> Diagnosis:
    """Ask a system which effects the base lacks."""
    return told(ranked(system, given, seed), given, floor=floor)


@dataclass(frozen=True, kw_only=True, eq=False)
class RankedSets:
    """The sets of effects of a system, and the best of which every effect is needed.

    `beside`: the system beside what is given, whose columns are `used`; `known` are those at the
    best grid points. `chance`: how often noise alone gives so much evidence. `covered`: what the
    runs could show beside what is given, before anything was ranked. `less`: the ranking before
    faults acted on the best set.
    """

    system: System
    beside: System
    used: tuple[CandidateColumns, ...]
    known: tuple[CandidateColumns, ...]
    sets: Sets
    entries: Sequence[RankedSet]
    chance: float
    best: RankedSet | None
    covered: tuple[Visible, ...]
    less: RankedSets | None = None

    @classmethod
    def of(
        cls,
        system: System,
        given: Sequence[str],
        covered: tuple[Visible, ...],
        seed: int,
        acting: frozenset[str] = frozenset(),
        less: RankedSets | None = None,
    ) -> RankedSets:
        """Of a system as it stands, whose faults act on some effects beside what is given."""
        beside, used, known = taken_as_given(system, given)
        sets = sets_of(beside, acting, less.sets if less else None)
        entries = ranked_sets(sets)
        if less:
            chance = less.chance
        else:
            singles = [item.log_evidence for item in entries if len(item.names) == 1]
            chance = gate(beside, max(singles), seed=seed)
        own = _at_home(entries, sets)
        return cls(
            system=system,
            beside=beside,
            used=used,
            known=known,
            sets=sets,
            entries=entries,
            chance=chance,
            best=chosen(system, own, used) if chance < CHANCE else None,
            covered=covered,
            less=less,
        )

    def home(self, names: Sequence[str]) -> RankedSets:
        """The ranking in whose system a set is asked, and fitted."""
        return self if self.less is None or self.sets.home(names) is self.sets else self.less

    @property
    def at_home(self) -> list[RankedSet]:
        """The sets that are asked in this system, whose columns are theirs."""
        return _at_home(self.entries, self.sets)

    @property
    def together(self) -> list[CandidateColumns]:
        """What is given, and the best set, needed or not, where chance does not give it."""
        if self.chance >= CHANCE:
            return list(self.known)
        return [*self.known, *blocks_of(self.beside, self.best or self.at_home[0])]


def _at_home(entries: Sequence[RankedSet], sets: Sets) -> list[RankedSet]:
    """Entries whose columns are those of the system of these sets."""
    return [item for item in entries if sets.home(item.names) is sets]


def ranked(system: System, given: Sequence[str], seed: int) -> RankedSets:
    """Sets about the model of the moment: the base, what is given, and what the best set names,
    until that stays."""
    with one_thread():
        # What the runs could show is asked about the base alone: beside a coefficient that has a
        # prior, a gain that the base absorbs seems to be seen.
        beside, _, blocks = taken_as_given(system, given)
        covered = coverage(beside)
        known = refined(system, blocks)
        if _acting(known):
            system = linearised(system, known)
        first = ranking = RankedSets.of(system, given, covered, seed)
        for _ in range(ROUNDS):
            acting = _acting(ranking.together) - _acting(ranking.known)
            if acting == ranking.sets.acting:
                break
            system = linearised(system, refined(system, ranking.together))
            ranking = RankedSets.of(system, given, covered, seed, acting, first)
        return ranking


def _acting(effects: Sequence[CandidateColumns]) -> frozenset[str]:
    """Effects of the ship and the water, on whose force faults act."""
    return frozenset(x.candidate.name for x in effects if x.candidate.kind == "physics")


def about(system: System, names: Sequence[str]) -> tuple[System, tuple[CandidateColumns, ...]]:
    """A system about its base with some effects, where faults among them act on the others; and
    these, nonlinear parameters off the grid."""
    known = refined(system, taken_as_given(system, names)[-1])
    if len({block.candidate.kind for block in known}) < 2:
        return system, known
    system = linearised(system, known)
    return system, refined(system, taken_as_given(system, names)[-1])


@one_thread()
def told(ranking: RankedSets, given: Sequence[str], *, floor: float) -> Diagnosis:
    """What a ranking says: a verdict, and the effects with their rivals."""
    system, beside, used, known = ranking.system, ranking.beside, ranking.used, ranking.known
    sets, entries, chance, best = ranking.sets, ranking.at_home, ranking.chance, ranking.best
    covered = ranking.covered
    blocks = blocks_of(beside, best) if best else []
    first = entries[0] if chance < CHANCE and entries[0].log_evidence > LEAST else None
    left = refused(system, sets, first, blocks, used) if first else ()
    hanging = tuple(item for item in left if item.run)
    apart = telling(system, used, blocks, best.log_evidence if best else math.inf)
    sizes = homogeneity(system, used, blocks)
    varied = [str(item) for item in sizes if item.varies]
    doubts = flags(system, blocks, used, (*map(str, left), *map(str, apart), *varied))
    nearest: Nearest | None = None
    findings: tuple[Finding, ...] = ()
    verdict: Verdict = "unexplained" if doubts else "noise"
    if best:
        together = refined(system, [*known, *blocks])
        after = held_out(system, together)
        misfit = chosen_anew(system, entries, best, after, used).misfit
        if misfit.chance >= CHANCE or _leads_on(system, (*given, *best.names)):
            verdict = "missing_effect"
            findings = _findings(
                system, sets.added(best), together, len(known), after, covered, floor
            )
            still = [x.effect for x in findings if x.error_after > (1.0 - FALLS) * x.error_before]
            if still:
                doubts = (
                    *(doubts or ("not_the_whole_story",)),
                    f"the error of left-out conditions does not fall with {' and '.join(still)}",
                )
        else:
            before = held_out(system, together[: len(known)], with_level=False)
            nearest = _nearest(best, before, after, misfit)
        if misfit.chance < CHANCE:
            doubts = doubts or ("not_the_whole_story", ABOVE)
    elif hanging and not flags(system, [item.block for item in hanging], used):
        verdict, doubts = "suspected", (doubts[0], *map(str, hanging))
    elif first and not hanging:
        before = held_out(system, known, with_level=False)
        after = held_out(system, [*known, *blocks_of(beside, first)])
        nearest = _nearest(first, before, after, after.misfit)
    return Diagnosis(
        verdict=verdict,
        group=_group(ranking.entries, best) if findings and best else (),
        flags=doubts,
        findings=findings,
        chance=chance,
        covered=covered,
        entries=tuple(ranking.entries),
        floor=floor,
        base=system.base.values,
        given=tuple(given),
        suspected=tuple(item.suspect for item in hanging),
        nearest=nearest,
        disagreements=apart,
        homogeneity=sizes,
        not_asked=_not_asked(ranking, given),
    )


def _not_asked(ranking: RankedSets, given: Sequence[str]) -> dict[str, str]:
    """The catalogue without what was asked and what the base has, with the reason of each entry."""
    known = {name for names in ranking.system.base.names.values() for name in names}
    done = {item.name for item in ranking.covered} | set(given)
    done |= {x.name for x in CATALOGUE.values() if x.coefficients and known.issuperset(x.typical)}

    def why(effect: Effect) -> str:
        once = "asked once the base has the terms that it changes" if effect.coefficients else ""
        return effect.not_captive or once

    return not_asked(done, why)


def _leads_on(system: System, named: Sequence[str]) -> bool:
    """Whether effects that leave more than noise do so for want of others in the catalogue.

    A set holds three effects at most, and what changes with the speed is asked for once the term is
    there: where more are missing, what is found beside the set must bring the errors of left-out
    conditions down to the noise.
    """
    beside, used, known = taken_as_given(system, named)
    entries = ranked_sets(sets_of(beside))
    best = chosen(system, entries, used)
    if best is None:
        return False
    after = held_out(system, refined(system, [*known, *blocks_of(beside, best)]))
    return chosen_anew(system, entries, best, after, used).misfit.chance >= CHANCE


def _nearest(entry: RankedSet, before: HeldOut, after: HeldOut, misfit: Misfit) -> Nearest:
    return Nearest(
        effects=entry.names,
        error_before=before.share(),
        error_after=after.share(),
        error_level=after.share(kind="level"),
        channel=misfit.where,
        ratio=misfit.ratio,
    )


def _group(
    entries: Sequence[RankedSet], best: RankedSet
) -> tuple[tuple[tuple[str, ...], float], ...]:
    """Sets of no greater size within `RIVALS` of the best, which stands first."""
    rivals = [
        item
        for item in entries
        if item is not best
        and len(item.names) <= len(best.names)
        and 0.0 <= best.log_evidence - item.log_evidence < RIVALS
    ]
    return tuple(
        (item.names, math.exp(item.log_evidence - best.log_evidence)) for item in (best, *rivals)
    )


def taken_as_given(
    system: System, names: Sequence[str]
) -> tuple[System, tuple[CandidateColumns, ...], tuple[CandidateColumns, ...]]:
    """A system beside effects that the base has, one after another at their best grid points.

    Two neighbouring points stand for a value between them.
    """
    used, blocks = [], []
    for name in names:
        near = best_blocks(system, name, 2)
        system = condition_on(system, near)
        used += near
        blocks.append(near[0])
    return _askable(system, blocks), tuple(used), tuple(blocks)


def _askable(system: System, given: Sequence[CandidateColumns]) -> System:
    """Without what changes a derivative with the speed that the base does not have yet.

    Where most runs have one speed, the term and its change with the speed are one.
    """
    known = {name for names in system.base.names.values() for name in names}
    known |= {name for block in given for name in block.candidate.coefficients}
    blocks = [
        block
        for block in system.blocks
        if all(
            name.removesuffix(BY_SPEED) in known
            for name in block.candidate.coefficients
            if name.endswith(BY_SPEED)
        )
    ]
    return replace(system, blocks=tuple(blocks))


def _findings(
    system: System,
    evidence: Sequence[float],
    together: Sequence[CandidateColumns],
    given: int,
    after: HeldOut,
    covered: Sequence[Visible],
    floor: float,
) -> tuple[Finding, ...]:
    """Each effect after those that are given, with the held-out errors without and with it; the
    largest first."""
    fit = joint_fit(system, together, floor=floor)
    visible = {item.name: item for item in covered}
    findings = [
        _finding(
            block,
            fit,
            visible[block.candidate.name],
            log_odds,
            _without(system, block, [item for item in together if item is not block]),
            after,
        )
        for block, log_odds in zip(together[given:], evidence, strict=True)
    ]
    return tuple(sorted(findings, key=lambda item: -item.error_before))


def _without(
    system: System, effect: CandidateColumns, others: Sequence[CandidateColumns]
) -> HeldOut:
    """Held-out errors without an effect: faults among the others act on what is left."""
    if effect.candidate.kind == "physics" and any(x.candidate.kind == "fault" for x in others):
        system = linearised(system, others, asked=())
        others = [replace(x, made=None) if x.candidate.kind == "fault" else x for x in others]
    return held_out(system, others, with_level=False)


def _finding(
    block: CandidateColumns,
    fit: JointFit,
    visible: Visible,
    log_odds: float,
    before: HeldOut,
    after: HeldOut,
) -> Finding:
    c = block.candidate
    values, std = coefficients_of(block, fit)
    old, new = before.of_channel(), after.of_channel()
    return Finding(
        effect=c.name,
        family=c.family,
        kind=c.kind,
        summary=c.summary,
        coefficients=dict(zip(c.coefficients, values, strict=True)),
        std=dict(zip(c.coefficients, std, strict=True)),
        typical=dict(zip(c.coefficients, c.typical, strict=True)),
        value=block.value,
        parameter=c.parameter,
        log_odds=log_odds,
        rivals=tuple(visible.mimics),
        separating_test=c.check,
        error_before=before.share(),
        error_after=after.share(),
        error_level=after.share(kind="level"),
        errors={name: (old[name], new[name]) for name in new},
        levels=after.of_channel(kind="level"),
    )


def coefficients_of(block: CandidateColumns, fit: JointFit) -> tuple[list[float], list[float]]:
    """Values and standard deviations; of a transient its rms share over runs and channels."""
    if not block.candidate.each_run:
        values, std = fit.of(labels(block.candidate))
        return values.tolist(), std.tolist()
    at = [i for i, name in enumerate(fit.names) if name.startswith(f"{block.candidate.name}: ")]
    values, std = fit.values[at], fit.std[at]
    size = float(np.sqrt(np.mean(values**2)))
    return [size], [float(np.sqrt(np.sum((values * std) ** 2)) / (len(at) * size))]
