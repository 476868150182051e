"""Which sets of effects all campaigns are asked for, and what they say."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from itertools import combinations
from types import MappingProxyType
from typing import Final

from pmmkit.diagnosis.captive.verdict import RIVALS
from pmmkit.diagnosis.evidence import PRICE
from pmmkit.diagnosis.joint.captive_vote import Ballot, Names, Vote, of_ship
from pmmkit.diagnosis.joint.result import JointEntry

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
        for near in (*_parts(ahead[0]), *_larger(ahead[0], several)):
            if hopeful(near):
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
