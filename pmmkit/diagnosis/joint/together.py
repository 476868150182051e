"""Several campaigns of one ship, captive and free running, asked the same question at once."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from pmmkit.campaigns import Campaign
from pmmkit.conventions import parse_derivative
from pmmkit.diagnosis.captive.system import WIDER, System
from pmmkit.diagnosis.captive.verdict import CHANCE
from pmmkit.diagnosis.evidence import LEAST, PRICE, RIVALS
from pmmkit.diagnosis.findings import Transfer, Verdict
from pmmkit.diagnosis.joint.another import others
from pmmkit.diagnosis.joint.belongs import (
    LABORATORY,
    SCATTER,
    LaboratoryValues,
    found_size,
    log_shared,
    owner,
    third,
)
from pmmkit.diagnosis.joint.captive_vote import Ballot, CaptiveVote, Names, Vote, of_ship
from pmmkit.diagnosis.joint.records_vote import RecordsVote
from pmmkit.diagnosis.joint.result import Another, Belonging, JointEntry, Together
from pmmkit.identification import Chosen, FreeRecord
from pmmkit.intake import Disagreement
from pmmkit.models import Model, scaled
from pmmkit.presentation import listed

# Which sets of effects all campaigns are asked for, and what they say.


SINGLES: Final = 6
"""Single effects in front that are fitted to all campaigns; the others are by linear problems."""
SETS: Final = 5
"""Sets of several effects that are fitted to all campaigns."""
TRIED: Final = 15
"""Sets that are tried for that at most: a promise of the linear problem may not be kept."""
NAMED: Final = 3
"""Sets in front of each campaign that are tried beside those of the others."""


BEAM: Final = 3
"""Sets in front whose parts are tried, and what is larger by one of the single effects in front."""


def weigh(
    votes: Sequence[Vote], every: Sequence[str], tell: Callable[[str], None]
) -> tuple[tuple[JointEntry, ...], tuple[tuple[str, Names], ...]]:
    """Single effects, the sets of several that promise most, and what is near those in front."""
    entries: dict[Names, JointEntry] = {}
    refused: dict[Names, str] = {}

    def prepare(sets: Sequence[Names]) -> None:
        new = [names for names in sets if names not in entries and names not in refused]
        for vote in votes:
            vote.prepare([names for names in new if _votes(vote, names)])

    def look(names: Names) -> bool:
        if names not in entries and names not in refused:
            tell(f"All campaigns with {' and '.join(names)}")
            found = _entry(votes, names)
            if isinstance(found, JointEntry):
                entries[names] = found
            else:
                refused[names] = found
        return names in entries

    def hopeful(names: Names) -> bool:
        """Whether nothing in a set was refused but inside of another that a campaign has kept."""
        inside = [set(x) for vote in votes for x in vote.kept if set(x) <= set(names)]
        bad = [set(x) for x in refused if set(x) <= set(names)]
        return all(any(x <= own for own in inside) for x in bad)

    singles = _ranked(_promised(votes, (name,)) for name in every)
    prepare([item.names for item in singles[:SINGLES]])
    for item in singles[:SINGLES]:
        look(item.names)
    promised = [_promised(votes, names) for names in _several(votes)]
    kept = tried = 0
    for item in _ranked(promised):
        front = max((x.log_evidence for x in entries.values()), default=0.0)
        if kept == SETS or tried == TRIED or item.log_evidence < front - RIVALS:
            break
        if hopeful(item.names):
            tried += 1
            kept += look(item.names)
    several = [x.names[0] for x in singles[:SINGLES]]
    seen: set[Names] = set()
    while ahead := [x.names for x in _ranked(entries.values())[:BEAM] if x.names not in seen]:
        seen.add(ahead[0])
        for sets in (_parts(ahead[0]), _larger(ahead[0], several)):
            prepare([names for names in sets if hopeful(names)])
            for near in filter(hopeful, sets):
                look(near)
    others = [x for x in singles if x.names not in entries and x.names not in refused]
    return (
        (*_ranked(entries.values()), *_ranked(others)),
        tuple((who, names) for names, who in refused.items()),
    )


def _several(votes: Sequence[Vote]) -> list[Names]:
    """Sets of several effects that any campaign looked at, and those that several name together."""
    ranked = [sorted(x.diagnosis.entries, key=lambda item: -item.log_evidence) for x in votes]
    pool = {of_ship(entry.names) for own in ranked for entry in own}
    front = [
        list(dict.fromkeys(of_ship(item.names) for item in own if item.log_evidence > 0.0))[:NAMED]
        for own in ranked
    ]
    pool |= {of_ship({*one, *two}) for a, b in combinations(front, 2) for one in a for two in b}
    return sorted(names for names in pool if len(names) > 1)


def _ranked(entries: Iterable[JointEntry]) -> tuple[JointEntry, ...]:
    return tuple(sorted(entries, key=lambda item: -item.log_evidence))


def _promised(votes: Sequence[Vote], names: Names) -> JointEntry:
    """A set as far as it is known without another fit."""
    return _sum(names, {x.name: x.promised(names) for x in votes if _votes(x, names)})


def _entry(votes: Sequence[Vote], names: Names) -> JointEntry | str:
    """A set with the evidence of all campaigns; the name of the campaign that refuses it."""
    ballots = {}
    for item in votes:
        if not _votes(item, names):
            continue
        ballot = item.weighed(names)
        if ballot is None:
            return item.name
        ballots[item.name] = ballot
    return _sum(names, ballots)


def _votes(vote: Vote, names: Names) -> bool:
    """Whether a campaign was asked for any of a set."""
    return bool(vote.asked.intersection(names))


def _sum(names: Names, ballots: dict[str, Ballot]) -> JointEntry:
    total = sum(item.log_evidence for item in ballots.values()) - PRICE * len(names)
    return JointEntry(names=names, log_evidence=total, ballots=MappingProxyType(ballots))


def _parts(names: Names) -> list[Names]:
    """A set without each of its effects; none of a single one."""
    found = [tuple(x for x in names if x != name) for name in names]
    return [rest for rest in found if rest]


def _larger(names: Names, more: Sequence[str]) -> list[Names]:
    """A set with each of some other effects."""
    return [of_ship((*names, name)) for name in more if name not in names]


# Whose the effects of a set are, by the coefficients that each campaign measures.


def shown_beside(best: JointEntry, entries: Sequence[JointEntry]) -> dict[str, Mapping[str, float]]:
    """By effect of a set what each campaign says for it beside the others, in ln evidence; nothing
    where the others were refused."""
    known = {item.names: item.ballots for item in entries} | {(): {}}
    found: dict[str, Mapping[str, float]] = {}
    for name in best.names:
        rest = known.get(tuple(x for x in best.names if x != name))
        whole = best.ballots if rest is not None else {}
        found[name] = {
            of: ballot.log_evidence - (rest or {}).get(of, _NONE).log_evidence
            for of, ballot in whole.items()
        }
    return found


def belongings(
    votes: Sequence[Vote], best: JointEntry, entries: Sequence[JointEntry]
) -> tuple[Belonging, ...]:
    """Whose each effect of the best set is.

    Of an effect that comes to values which the model has, the captive tests say nothing by
    themselves; the model, which is taken to be of the first of them, says how well these are known.
    """
    sizes = [
        item.sizes(best.names, best.ballots[item.name].faults)
        for item in votes
        if item.name in best.ballots
    ]
    tests = [item.name for item in votes if isinstance(item, CaptiveVote)]
    records = [item for item in votes if isinstance(item, RecordsVote)]
    stated = records[0].stated(tests[0]) if tests and records else {}
    if stated:
        measured = {name for own in sizes for name, x in own.items() if x.laboratory in tests}
        sizes = [{name: x for name, x in stated.items() if name not in measured}, *sizes]
    shown = shown_beside(best, entries)
    return tuple(
        _belonging(name, [own[name] for own in sizes if name in own], shown[name])
        for name in best.names
    )


def with_shown(
    votes: Sequence[Vote], entries: Sequence[JointEntry]
) -> tuple[tuple[JointEntry, ...], tuple[Belonging, ...], tuple[Belonging, ...]]:
    """The entries without sets of an effect that no campaign shows; whose the effects of the best
    one then are, and what was refused.

    An effect of the ship is paid for once. Where each laboratory has a size of its own it is as
    many effects, and each pays: what all together hardly pay once is none.
    """
    left, refused = tuple(entries), list[Belonging]()
    while left and is_told(left[0]):
        belongs = belongings(votes, left[0], entries)
        bad = [item for item in belongs if item.unshown]
        if not bad:
            return left, belongs, tuple(refused)
        refused += bad
        names = {item.effect for item in bad}
        left = tuple(item for item in left if not names.intersection(item.names))
    return left, (), tuple(refused)


def is_told(item: JointEntry) -> bool:
    """Whether a set in front is named: chance gives such evidence in less than `CHANCE`."""
    return not item.linear and item.log_evidence > max(LEAST, -math.log(CHANCE))


def laboratories_apart(
    votes: Sequence[Vote], best: JointEntry
) -> dict[str, tuple[Disagreement, ...]]:
    """Of each campaign the group of runs that disagrees beside the best set; and the groups, one in
    each campaign that votes for it, that explain as much in its place: then it is no ship's.
    """
    found: dict[str, tuple[Disagreement, ...]] = {}
    instead = {}
    for item in votes:
        ballot = best.ballots.get(item.name, _NONE)
        groups = item.groups(best.names, ballot.faults)
        # Each campaign alone is never asked for the place of the set: all together are.
        if told := Disagreement.telling(groups, math.inf):
            found[item.name] = told
        # What its own faults explain is no group's.
        if groups and item.name in best.ballots and not ballot.faults:
            most = max(groups, key=lambda x: x.instead)
            if most.instead > 0.0:
                instead[item.name] = replace(most, rival=True)
    if sum(item.instead for item in instead.values()) > best.log_evidence - RIVALS:
        found |= {name: (*found.get(name, ()), item) for name, item in instead.items()}
    return found


def _apart(found: Mapping[str, Sequence[Disagreement]]) -> list[str]:
    """What is warned of: an error of one laboratory's runs is no effect of the ship."""
    return [
        f"{name}: {item}{', and it is not the ship but the laboratory' if item.rival else ''}."
        for name, own in found.items()
        for item in own
    ]


def _belonging(
    name: str, found: Sequence[LaboratoryValues], shown: Mapping[str, float]
) -> Belonging:
    """Whose an effect is, by the coefficients that all have."""
    common = (
        [x for x in found[0].coefficients if all(x in own.coefficients for own in found)]
        if found
        else []
    )
    measured = tuple(own.only(common) for own in found)
    typical = dict(zip(found[0].coefficients, found[0].typical, strict=True)) if found else {}
    usual = np.array([abs(typical[x]) for x in common])
    size = found_size(measured, usual) if common else 1.0
    asked = len(found) > 1 and bool(common)
    prior = np.diag((WIDER * usual) ** 2)
    ratio = log_shared(measured, prior) if asked else math.nan
    return Belonging(
        effect=name,
        owner=owner(ratio) if asked else "cannot tell",
        log_odds=ratio,
        coefficients=tuple(common),
        usual=tuple(usual.tolist()),
        size=size,
        measured=measured,
        thirds=tuple(
            third(measured, prior, size * usual, scale=x)
            for x in (SCATTER, SCATTER / 2, SCATTER * 2)
        )
        if common
        else (),
        shown=MappingProxyType(dict(shown)),
    )


# The base of each campaign of one ship: what captive tests know of it, at the length tested.


SAME: Final = 1e-3
"""Share by which two lengths of one ship may differ without carrying the model over."""


FittedCampaign = tuple[str, System, Callable[[], Model | None]]
"""Captive tests that the base is fitted to: their name, their system, and the model with its
derivatives fitted to them; None if they excite too little."""


def known_from(model: Model, tests: Sequence[FittedCampaign]) -> tuple[Model, tuple[str, ...]]:
    """The model with what captive tests know of its base, and how it came to be."""
    if model.covariance is not None:
        return model, ("the base is known as the covariance of the model says",)
    for name, system, fitted in tests:
        if _is_bare(system) and (made := fitted()) is not None:
            return made, (f"the base is known as {name} tells it: its derivatives are fitted",)
    note = (
        "the base stays as the model has it: in the captive tests rudder or propeller took part, "
        "or too little is excited; reduce them for a model with covariance"
    )
    return model, (note,) if tests else ()


def carried(model: Model, name: str, campaign: Campaign) -> tuple[Model, tuple[str, ...]]:
    """The model at the length of the ship that was tested, and what is to be said of it.

    Parameters
    ----------
    model : Model
        At its own length.
    name : str
        Of the campaign.
    campaign : Campaign
        Free-running records.
    """
    ship = campaign.ship
    if abs(ship.L / model.ship.L - 1.0) < SAME:
        return model, ()
    note = (
        f"{name}: the model is carried from L = {model.ship.L:g} m to {ship.L:g} m by Froude's "
        f"law, without correction of friction or wake; its propulsion point stays"
    )
    return scaled(model, ship.L), (note,)


def _is_bare(system: System) -> bool:
    """Whether tests show the forces of the hull alone."""
    names = [name for own in system.base.names.values() for name in own]
    return "XT" not in names and not any(parse_derivative(name).count("d") for name in names)


Tests = Campaign | Sequence[FreeRecord]


def records_among(
    item: Tests, model: Model, chosen: Mapping[str, Any]
) -> tuple[Sequence[FreeRecord], Sequence[FreeRecord]]:
    """Records as they are given, or those of a campaign that are chosen, and those held out."""
    if not isinstance(item, Campaign):
        return item, ()
    used, kept = Chosen.of(item, model, rudder="auto", wind=True, **chosen)
    return used.records, kept.records if kept else ()


def answered(
    votes: Sequence[Vote],
    *,
    given: Sequence[str] = (),
    notes: Sequence[str] = (),
    progress: Callable[[str], None] | None = None,
) -> Together:
    """What campaigns that were diagnosed one by one say together."""
    tell = progress or (lambda _: None)
    said = list(notes)
    every = sorted(set().union(*(item.asked for item in votes)))
    weighed, refused = weigh(votes, every, tell)
    entries, belongs, unshared = with_shown(votes, weighed)
    best = entries[0] if entries and not entries[0].linear else None
    told = best is not None and is_told(best)
    group = _group(entries) if told else ()
    added: dict[str, float] = {}
    transfers: dict[str, tuple[Transfer, ...]] = {}
    apart: Mapping[str, tuple[Disagreement, ...]] = {}
    made = None
    if told and best is not None:
        tell("Groups of runs")
        apart = laboratories_apart(votes, best)
        known = {item.names: item.log_evidence for item in weighed}
        for name in best.names:
            rest = tuple(x for x in best.names if x != name)
            added[name] = best.log_evidence - known.get(rest, 0.0)
        made = _model(votes, best)
        own = [item.effect for item in belongs if item.owner != LABORATORY]
        order = tuple(sorted(own, key=lambda name: -added[name]))
        transfers = {
            item.name: found
            for item in votes
            if (found := item.transfers(order, best.ballots.get(item.name, _NONE).faults))
        }
    more: tuple[Another, ...] = ()
    if not given:
        tell("Another laboratory")
        more = others(
            votes,
            best.names if told and best is not None else (),
            best.ballots if told and best is not None else {},
            belongs,
        )
        if not more and any(isinstance(item, RecordsVote) for item in votes):
            said.append(
                "there is no model of another laboratory: what the campaigns say together is "
                "beyond what a value can be"
            )
    models = {"another laboratory": more[0].model} if more else {}
    errors = {}
    for item in votes:
        names = best.names if told and best is not None else ()
        faults = best.ballots.get(item.name, _NONE).faults if names and best else _own_faults(item)
        if found_there := item.held_out_errors(names, faults, models):
            errors[item.name] = found_there
    verdict: Verdict = "missing_effect" if told else _unnamed(votes)
    return Together(
        verdict=verdict,
        group=group,
        entries=entries,
        diagnoses=MappingProxyType({item.name: item.diagnosis for item in votes}),
        belongs=belongs,
        added=MappingProxyType(added),
        refused=refused,
        flags=(*_flags(votes), *_owned(belongs), *_apart(apart)),
        disagreements=MappingProxyType(dict(apart)),
        errors=MappingProxyType(errors),
        transfers=MappingProxyType(transfers),
        unshared=unshared,
        notes=(
            *said,
            f"each effect pays {PRICE:.2f} once: odds of 1 to 80 before any test",
            *(
                f"{vote.name}: own faults {' and '.join(faults)}"
                for vote in votes
                if best is not None and (faults := best.ballots.get(vote.name, _NONE).faults)
            ),
        ),
        model=made,
        others=more,
        given=tuple(given),
    )


_NONE: Final = Ballot(log_evidence=0.0)


def _unnamed(votes: Sequence[Vote]) -> Verdict:
    """The verdict where nothing is named: what the campaigns alone say, their own faults apart."""
    said = {item.diagnosis.verdict for item in votes if not _own_faults(item)}
    if said & {"unexplained", "missing_effect"}:
        return "unexplained"
    return "suspected" if "suspected" in said else "noise"


def _own_faults(vote: Vote) -> Names:
    """Faults that a campaign alone names, where it names nothing else."""
    found: Names = vote.diagnosis.best
    return () if of_ship(found) else found


def _flags(votes: Sequence[Vote]) -> tuple[str, ...]:
    """Campaigns that hold more than is explained."""
    found = []
    for item in votes:
        if item.diagnosis.verdict == "unexplained":
            found.append(f"{item.name} alone holds something that nothing explains.")
        elif faults := _own_faults(item):
            found.append(f"{item.name} has {' and '.join(faults)} of its own.")
        elif item.diagnosis.flags:
            found.append(f"{item.name} alone: what it names is not the whole story.")
    return tuple(found)


def _owned(belongs: Sequence[Belonging]) -> list[str]:
    """Effects that are named, and are not the ship's."""
    names = [item.effect for item in belongs if item.owner == LABORATORY]
    if not names:
        return []
    return [
        f"{listed(names)}: each laboratory has a size of its own, so in one of them at least it "
        "stands for something else. It is not proposed; the next one may have any size between."
    ]


def _group(entries: Sequence[JointEntry]) -> tuple[tuple[Names, float], ...]:
    """Sets of no greater size within `RIVALS` of the best."""
    best = entries[0]
    return tuple(
        (item.names, math.exp(item.log_evidence - best.log_evidence))
        for item in entries
        if not item.linear
        and len(item.names) <= len(best.names)
        and best.log_evidence - item.log_evidence < RIVALS
    )


def _model(votes: Sequence[Vote], best: JointEntry) -> Model | None:
    """With the best set: fitted to the first records, else to the first captive tests."""
    for kind in (RecordsVote, CaptiveVote):
        for item in votes:
            if isinstance(item, kind):
                made = item.model_with(best.names, best.ballots.get(item.name, _NONE).faults)
                if made is not None:
                    return made
    return None
