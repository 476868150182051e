"""Several campaigns of one ship, captive and free running, asked the same question at once."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from types import MappingProxyType
from typing import Any, Final

from pmmkit.campaigns.run import Campaign
from pmmkit.campaigns.several import by_title
from pmmkit.diagnosis.captive.adequacy import LEAST
from pmmkit.diagnosis.captive.verdict import CHANCE, RIVALS
from pmmkit.diagnosis.evidence import PRICE
from pmmkit.diagnosis.findings import Verdict
from pmmkit.diagnosis.together.another import others
from pmmkit.diagnosis.together.base import Fitted, carried, known_from
from pmmkit.diagnosis.together.belongings import belongings
from pmmkit.diagnosis.together.captive_vote import CaptiveVote, captive_vote
from pmmkit.diagnosis.together.records_vote import RecordsVote, records_vote
from pmmkit.diagnosis.together.result import Another, Belonging, JointEntry, Together
from pmmkit.diagnosis.together.vote import Ballot, Names, Vote, of_ship
from pmmkit.diagnosis.together.weighing import weigh
from pmmkit.errors import DataError
from pmmkit.identification.chosen import chosen_records
from pmmkit.identification.record import FreeRecord
from pmmkit.models import Model

CHOSEN: Final = ("runs", "test_runs", "channels", "shortest")
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
    effects of the ship, ln odds are ``Σ_i [ln p_i(S, F_i(S)) − ln p_i(F_i)] − |S| ln 80``, where
    F_i are the faults that make campaign i most probable, without S or with it, each at its price;
    an effect of the ship is paid for once (`PRICE`). A campaign that was not asked for an effect
    does not vote on it.

    Each campaign averages over coefficients of its own, by the prior of usual sizes: that S acts
    is what they vote for, not that it has one size; whether it has is asked afterwards of each
    effect (`log_shared`). The values of the base as captive tests know them are the prior for
    the records: the covariance of the model, or where it has none and the tests are of the bare
    hull, that of its derivatives fitted to these tests. Base and effects are taken as independent
    there, so that what both kinds of tests know of the base in common is used once.

    Sets are fitted to records through the equations before they count, beginning with the single
    effects that promise most by linear problems: a set that makes records left out one after
    another worse is refused. A set is named if its
    odds are above e after the price and chance gives such evidence in less than 1 % of ships
    without any effect: by Markov's inequality that is less than one over the odds.
    """
    tell = progress or (lambda _: None)
    named = campaigns if isinstance(campaigns, Mapping) else by_title(campaigns)
    if not named:
        raise DataError("There is no campaign: give captive tests or free-running records.")
    notes: list[str] = []
    tests = {
        name: x for name, x in named.items() if isinstance(x, Campaign) and x.kind != "free-running"
    }
    captives: list[CaptiveVote] = []
    for name, tested in tests.items():
        tell(f"{name}: captive tests")
        captives.append(captive_vote(name, model, tested, **captive))
    known = known_from(
        model,
        [
            Fitted(name=x.name, system=x.system, model=partial(x.model_with, (), ()))
            for x in captives
        ],
    )
    notes += known.notes
    votes: list[Vote] = list(captives)
    for name, item in named.items():
        if name in tests:
            continue
        own = carried(known.model, name, item) if isinstance(item, Campaign) else known
        notes += own.notes if own is not known else ()
        said = partial(_tell, tell, name)
        records, _ = records_among(item, own.model, free)
        settings = {key: x for key, x in free.items() if key not in CHOSEN}
        votes.append(records_vote(name, own.model, records, progress=said, **settings))
    return answered(
        sorted(votes, key=lambda x: list(named).index(x.name)), notes=notes, progress=tell
    )


def _tell(tell: Callable[[str], None], name: str, word: str) -> None:
    tell(f"{name}: {word}")


def records_among(
    item: Tests, model: Model, chosen: Mapping[str, Any]
) -> tuple[Sequence[FreeRecord], Sequence[FreeRecord]]:
    """Records as they are given, or those of a campaign that are chosen, and those held out.

    Parameters
    ----------
    item : Campaign or sequence of FreeRecord
        Free-running tests.
    model : Model
        At the length of the ship that made them.
    chosen : mapping of str to object
        ``runs``, ``test_runs``, ``channels`` and ``shortest`` as for `chosen_records`; all if
        absent.
    """
    if not isinstance(item, Campaign):
        return item, ()
    wanted = {name: chosen.get(name) for name in CHOSEN}
    used, kept = chosen_records(item, model, rudder="auto", wind=True, **wanted)
    return used.records, kept.records if kept else ()


def answered(
    votes: Sequence[Vote],
    *,
    given: Sequence[str] = (),
    notes: Sequence[str] = (),
    progress: Callable[[str], None] | None = None,
) -> Together:
    """What campaigns that were diagnosed one by one say together.

    Parameters
    ----------
    votes : sequence of Vote
        The campaigns, each against a base that has what is given.
    given : sequence of str
        Candidates that the base has already. With any of them nothing is said of another
        laboratory: what it would make of these was not asked.
    notes : sequence of str
        Of the bases.
    progress : callable, optional
        Is told what is being done.
    """
    tell = progress or (lambda _: None)
    said = list(notes)
    every = sorted(set().union(*(item.asked for item in votes)))
    weighed = weigh(votes, every, tell)
    entries = weighed.entries
    best = entries[0] if entries and not entries[0].linear else None
    told = best is not None and best.log_evidence > max(LEAST, -math.log(CHANCE))
    group = _group(entries) if told else ()
    added: dict[str, float] = {}
    belongs: tuple[Belonging, ...] = ()
    made = None
    if told and best is not None:
        known = {item.names: item.log_evidence for item in entries}
        for name in best.names:
            rest = tuple(x for x in best.names if x != name)
            added[name] = best.log_evidence - known.get(rest, 0.0)
        belongs = belongings(votes, best)
        made = _model(votes, best)
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
    verdict: Verdict = "missing_effect" if told else _unnamed(votes)
    return Together(
        verdict=verdict,
        group=group,
        entries=entries,
        diagnoses=MappingProxyType({item.name: item.diagnosis for item in votes}),
        belongs=belongs,
        added=MappingProxyType(added),
        refused=weighed.refused,
        flags=_flags(votes),
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
