"""Several campaigns of one ship, captive and free running, asked the same question at once."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from pmmkit.campaigns.run import Campaign
from pmmkit.conventions import parse_derivative
from pmmkit.diagnosis.captive.adequacy import LEAST
from pmmkit.diagnosis.captive.system import WIDER
from pmmkit.diagnosis.captive.verdict import CHANCE, RIVALS
from pmmkit.diagnosis.findings import Verdict
from pmmkit.diagnosis.together.belongs import SCATTER, Measured, log_shared, owner, third
from pmmkit.diagnosis.together.captive_vote import CaptiveVote, captive_vote
from pmmkit.diagnosis.together.records_vote import RecordsVote, records_vote
from pmmkit.diagnosis.together.result import Belonging, JointEntry, Together
from pmmkit.diagnosis.together.vote import Ballot, Names, Sized, Vote, of_ship
from pmmkit.errors import DataError
from pmmkit.identification.chosen import chosen_records
from pmmkit.identification.record import FreeRecord
from pmmkit.models import Model, scaled

SETS: Final = 5
"""Sets of several effects that are fitted to all campaigns, beside all single effects."""
TRIED: Final = 15
"""Sets that are tried for that at most: a promise of the linear problem may not be kept."""
SAME: Final = 1e-3
"""Share by which two lengths of one ship may differ without carrying the model over."""
CHOSEN: Final = ("runs", "channels", "shortest")
"""Settings of `chosen_records`."""
Tests = Campaign | Sequence[FreeRecord]


def together(
    model: Model,
    campaigns: Sequence[Campaign] | Mapping[str, Tests],
    *,
    captive: Mapping[str, Any] = MappingProxyType({}),
    free: Mapping[str, Any] = MappingProxyType({}),
    progress: Callable[[str], None] | None = None,
) -> Together:
    """Name what a model lacks that several campaigns of one ship show together.

    Parameters
    ----------
    model : Model
        Complete where there are free-running records. Its derivatives of hull and added mass are
        the base of captive tests.
    campaigns : sequence of Campaign, or mapping of str to Campaign or sequence of FreeRecord
        Captive tests and free-running records, by name if a mapping. The model is carried to the
        length of a free-running campaign's ship by Froude's law (`scaled`).
    captive : mapping of str to object
        ``floor``, ``noise`` and ``seed`` as for `diagnose_captive`.
    free : mapping of str to object
        ``candidates`` (effects), ``most``, ``floor``, ``spread``, ``window``, ``sensors``,
        ``windage``, ``extrapolate`` and ``seed`` as for `diagnose_free`; ``runs``, ``channels`` and
        ``shortest``, which records of campaigns take part, as for `chosen_records`.
    progress : callable, optional
        Is told what is being done.

    Returns
    -------
    Together

    Raises
    ------
    DataError
        If there is no campaign, or one cannot be asked.

    Notes
    -----
    Each campaign is diagnosed alone, with its own noise and its own faults. Then, for a set S of
    effects of the ship, ln odds are ``Σ_i [ln p_i(S, F_i(S)) − ln p_i(F_i)] − |S| ln 2K``, where
    F_i are the faults that make campaign i most probable, without S or with it, each at its price;
    an effect of the ship is paid for once, by the number K of effects that any campaign was asked
    for. A campaign that was not asked for an effect does not vote on it.

    Each campaign averages over coefficients of its own, by the prior of usual sizes: that S acts
    is what they vote for, not that it has one size; whether it has is asked afterwards of each
    effect (`log_shared`). The values of the base as captive tests know them are the prior for
    the records: the covariance of the model, or where it has none and the tests are of the bare
    hull, that of its derivatives fitted to these tests. Base and effects are taken as independent
    there, so that what both kinds of tests know of the base in common is used once.

    Sets are fitted to records through the equations before they count, single effects first: a set
    that makes records left out one after another worse, or that holds an effect which alone does
    so, is refused. A set is named if its odds are above e after the price and chance gives such
    evidence in less than 1 % of ships without any effect: by Markov's inequality that is less than
    one over the odds.
    """
    tell = progress or (lambda _: None)
    named = campaigns if isinstance(campaigns, Mapping) else _by_title(campaigns)
    if not named:
        raise DataError("There is no campaign: give captive tests or free-running records.")
    notes: list[str] = []
    tests = {
        name: x for name, x in named.items() if isinstance(x, Campaign) and x.kind != "free-running"
    }
    votes: list[Vote] = []
    for name, tested in tests.items():
        tell(f"{name}: captive tests")
        votes.append(captive_vote(name, model, tested, **captive))
    known = _known_from(model, votes, notes)
    for name, item in named.items():
        if name in tests:
            continue
        own = _carried(known, name, item, notes)
        said = partial(_tell, tell, name)
        records = _records(item, own, free)
        settings = {key: x for key, x in free.items() if key not in CHOSEN}
        votes.append(records_vote(name, own, records, progress=said, **settings))
    return _answered(sorted(votes, key=lambda x: list(named).index(x.name)), notes, tell)


def _tell(tell: Callable[[str], None], name: str, word: str) -> None:
    tell(f"{name}: {word}")


def _by_title(campaigns: Sequence[Campaign]) -> dict[str, Campaign]:
    """Campaigns by their titles, numbered where two have the same."""
    found: dict[str, Campaign] = {}
    for number, item in enumerate(campaigns, 1):
        name = item.title or item.ship.name
        found[f"{name} ({number})" if name in found else name] = item
    return found


def _records(item: Tests, model: Model, chosen: Mapping[str, Any]) -> Sequence[FreeRecord]:
    """Records as they are given, or those of a campaign that are chosen."""
    if not isinstance(item, Campaign):
        return item
    wanted = {name: chosen.get(name) for name in CHOSEN}
    used, _ = chosen_records(item, model, test_runs=None, rudder="auto", wind=True, **wanted)
    return used.records


def _carried(model: Model, name: str, item: Tests, notes: list[str]) -> Model:
    """The model at the length of the ship that was tested."""
    if not isinstance(item, Campaign) or abs(item.ship.L / model.ship.L - 1.0) < SAME:
        return model
    notes.append(
        f"{name}: the model is carried from L = {model.ship.L:g} m to {item.ship.L:g} m by "
        f"Froude's law, without correction of friction or wake; its propulsion point stays"
    )
    return scaled(model, item.ship.L)


def _known_from(model: Model, votes: Sequence[Vote], notes: list[str]) -> Model:
    """The model with what captive tests know of its base."""
    tests = [item for item in votes if isinstance(item, CaptiveVote)]
    if model.covariance is not None:
        notes.append("the base is known as the covariance of the model says")
        return model
    for item in tests:
        if _is_bare(item):
            notes.append(f"the base is known as {item.name} tells it: its derivatives are fitted")
            return item.model_with((), ())
    if tests:
        notes.append(
            "the base stays as the model has it: rudder or propeller took part in the captive "
            "tests, whose forces are not those of the hull; reduce them for a model with covariance"
        )
    return model


def _is_bare(vote: CaptiveVote) -> bool:
    """Whether tests show the forces of the hull alone."""
    names = [name for own in vote.system.base.names.values() for name in own]
    return "XT" not in names and not any(parse_derivative(name).count("d") for name in names)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Weighed:
    """Sets that all campaigns were asked for, and those that one refuses."""

    entries: dict[Names, JointEntry]
    refused: dict[Names, str]


def _answered(votes: Sequence[Vote], notes: list[str], tell: Callable[[str], None]) -> Together:
    every = sorted(set().union(*(item.asked for item in votes)))
    price = math.log(2.0 * max(len(every), 1))
    weighed = _weigh(votes, every, price, tell)
    entries = sorted(weighed.entries.values(), key=lambda item: -item.log_evidence)
    best = entries[0] if entries else None
    told = best is not None and best.log_evidence > max(LEAST, -math.log(CHANCE))
    group = _group(entries) if told else ()
    added: dict[str, float] = {}
    belongs: tuple[Belonging, ...] = ()
    made = None
    if told and best is not None:
        for name in best.names:
            less = weighed.entries.get(tuple(x for x in best.names if x != name))
            added[name] = best.log_evidence - (less.log_evidence if less else 0.0)
        belongs = _belongings(votes, best)
        made = _model(votes, best)
    verdict: Verdict = "missing_effect" if told else _unnamed(votes)
    return Together(
        verdict=verdict,
        group=group,
        entries=tuple(entries),
        diagnoses=MappingProxyType({item.name: item.diagnosis for item in votes}),
        belongs=belongs,
        added=MappingProxyType(added),
        refused=tuple((who, names) for names, who in weighed.refused.items()),
        price=price,
        flags=_flags(votes),
        notes=(
            *notes,
            f"each effect pays ln 2K = {price:.2f} once, K = {len(every)}",
            *(
                f"{vote.name}: own faults {' and '.join(faults)}"
                for vote in votes
                if best is not None and (faults := best.ballots.get(vote.name, _NONE).faults)
            ),
        ),
        model=made,
    )


_NONE: Final = Ballot(log_evidence=0.0)


def _unnamed(votes: Sequence[Vote]) -> Verdict:
    """The verdict where nothing is named: what the campaigns alone say."""
    said = {item.diagnosis.verdict for item in votes}
    if said & {"unexplained", "missing_effect"}:
        return "unexplained"
    return "suspected" if "suspected" in said else "noise"


def _flags(votes: Sequence[Vote]) -> tuple[str, ...]:
    """Campaigns that hold more than is explained."""
    found = []
    for item in votes:
        if item.diagnosis.verdict == "unexplained":
            found.append(f"{item.name} alone holds something that nothing explains.")
        elif item.diagnosis.flags:
            found.append(f"{item.name} alone: what it names is not the whole story.")
    return tuple(found)


def _group(entries: Sequence[JointEntry]) -> tuple[tuple[Names, float], ...]:
    """Sets of no greater size within `RIVALS` of the best."""
    best = entries[0]
    return tuple(
        (item.names, math.exp(item.log_evidence - best.log_evidence))
        for item in entries
        if len(item.names) <= len(best.names) and best.log_evidence - item.log_evidence < RIVALS
    )


def _weigh(
    votes: Sequence[Vote], every: Sequence[str], price: float, tell: Callable[[str], None]
) -> _Weighed:
    """All single effects, and the sets of several that promise most."""
    weighed = _Weighed(entries={}, refused={})
    for name in every:
        _entry(votes, (name,), price, weighed, tell)
    pool = {of_ship(entry.names) for item in votes for entry in item.diagnosis.entries}
    promised = {names: _promise(votes, names, price) for names in sorted(pool) if len(names) > 1}
    tried = kept = 0
    for names in sorted(promised, key=lambda names: -promised[names]):
        front = max((item.log_evidence for item in weighed.entries.values()), default=0.0)
        if kept == SETS or tried == TRIED or promised[names] < front - RIVALS:
            break
        if any(set(names) >= set(bad) for bad in weighed.refused):
            continue
        tried += 1
        kept += _entry(votes, names, price, weighed, tell) is not None
    _with_parts(votes, price, weighed, tell)
    return weighed


def _with_parts(
    votes: Sequence[Vote], price: float, weighed: _Weighed, tell: Callable[[str], None]
) -> None:
    """The best set without each of its effects, until none of these is better."""
    best: JointEntry | None = None
    while weighed.entries:
        first = max(weighed.entries.values(), key=lambda item: item.log_evidence)
        if first is best:
            return
        best = first
        for rest in _parts(best.names):
            _entry(votes, rest, price, weighed, tell)


def _parts(names: Names) -> list[Names]:
    """A set without each of its effects; none of a single one."""
    found = [tuple(x for x in names if x != name) for name in names]
    return [rest for rest in found if rest]


def _promise(votes: Sequence[Vote], names: Names, price: float) -> float:
    return sum(item.promised(names).log_evidence for item in votes) - price * len(names)


def _entry(
    votes: Sequence[Vote],
    names: Names,
    price: float,
    weighed: _Weighed,
    tell: Callable[[str], None],
) -> JointEntry | None:
    """A set with the evidence of all campaigns; None if one refuses it. Kept for the next time."""
    if names in weighed.entries:
        return weighed.entries[names]
    tell(f"All campaigns with {' and '.join(names)}")
    ballots = {}
    for item in votes:
        if not item.asked.intersection(names):
            continue
        ballot = item.weighed(names)
        if ballot is None:
            weighed.refused[names] = item.name
            return None
        ballots[item.name] = ballot
    total = sum(item.log_evidence for item in ballots.values()) - price * len(names)
    weighed.entries[names] = JointEntry(
        names=names, log_evidence=total, ballots=MappingProxyType(ballots)
    )
    return weighed.entries[names]


def _belongings(votes: Sequence[Vote], best: JointEntry) -> tuple[Belonging, ...]:
    """Whose each effect of the best set is."""
    sizes = [
        item.sizes(best.names, best.ballots[item.name].faults)
        for item in votes
        if item.name in best.ballots
    ]
    return tuple(
        _belonging(name, [own[name] for own in sizes if name in own]) for name in best.names
    )


def _belonging(name: str, found: Sequence[Sized]) -> Belonging:
    """Whose an effect is, by the coefficients that all have."""
    common = (
        [x for x in found[0].coefficients if all(x in own.coefficients for own in found)]
        if (found)
        else []
    )
    measured = tuple(_only(own, common) for own in found)
    typical = dict(zip(found[0].coefficients, found[0].typical, strict=True)) if found else {}
    usual = np.array([abs(typical[x]) for x in common])
    asked = len(found) > 1 and bool(common)
    prior = np.diag((WIDER * usual) ** 2)
    ratio = log_shared(measured, prior) if asked else math.nan
    return Belonging(
        effect=name,
        owner=owner(ratio) if asked else "cannot tell",
        log_odds=ratio,
        coefficients=tuple(common),
        usual=tuple(usual.tolist()),
        measured=measured,
        thirds=tuple(
            third(measured, prior, usual, scale=x) for x in (SCATTER, SCATTER / 2, SCATTER * 2)
        )
        if common
        else (),
    )


def _only(own: Sized, names: Sequence[str]) -> Measured:
    at = [own.coefficients.index(name) for name in names]
    return Measured(
        laboratory=own.measured.laboratory,
        values=own.measured.values[at],
        covariance=own.measured.covariance[np.ix_(at, at)],
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
