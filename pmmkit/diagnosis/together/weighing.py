"""Which sets of effects all campaigns are asked for, and what they say."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

from pmmkit.diagnosis.captive.verdict import RIVALS
from pmmkit.diagnosis.together.result import JointEntry
from pmmkit.diagnosis.together.vote import Names, Vote, of_ship

SETS: Final = 5
"""Sets of several effects that are fitted to all campaigns, beside all single effects."""
TRIED: Final = 15
"""Sets that are tried for that at most: a promise of the linear problem may not be kept."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Weighed:
    """Sets that all campaigns were asked for.

    Parameters
    ----------
    entries : tuple of JointEntry
        Best first.
    refused : tuple of (campaign, effects)
        Sets that a campaign refuses.
    """

    entries: tuple[JointEntry, ...]
    refused: tuple[tuple[str, Names], ...]


def weigh(
    votes: Sequence[Vote], every: Sequence[str], price: float, tell: Callable[[str], None]
) -> Weighed:
    """All single effects, the sets of several that promise most, and the parts of the best.

    Parameters
    ----------
    votes : sequence of Vote
        The campaigns.
    every : sequence of str
        Effects that any of them was asked for.
    price : float
        Of an effect.
    tell : callable
        Is told what is being done.
    """
    entries: dict[Names, JointEntry] = {}
    refused: dict[Names, str] = {}

    def look(names: Names) -> bool:
        if names not in entries and names not in refused:
            tell(f"All campaigns with {' and '.join(names)}")
            found = _entry(votes, names, price)
            if isinstance(found, JointEntry):
                entries[names] = found
            else:
                refused[names] = found
        return names in entries

    for name in every:
        look((name,))
    pool = {of_ship(entry.names) for item in votes for entry in item.diagnosis.entries}
    promised = {names: _promise(votes, names, price) for names in sorted(pool) if len(names) > 1}
    tried = kept = 0
    for names in sorted(promised, key=lambda names: -promised[names]):
        front = max((item.log_evidence for item in entries.values()), default=0.0)
        if kept == SETS or tried == TRIED or promised[names] < front - RIVALS:
            break
        if any(set(names) >= set(bad) for bad in refused):
            continue
        tried += 1
        kept += look(names)
    best: Names = ()
    while entries:
        first = _ranked(entries.values())[0].names
        if first == best:
            break
        best = first
        for rest in _parts(best):
            look(rest)
    return Weighed(
        entries=_ranked(entries.values()),
        refused=tuple((who, names) for names, who in refused.items()),
    )


def _ranked(entries: Iterable[JointEntry]) -> tuple[JointEntry, ...]:
    return tuple(sorted(entries, key=lambda item: -item.log_evidence))


def _promise(votes: Sequence[Vote], names: Names, price: float) -> float:
    return sum(item.promised(names).log_evidence for item in votes) - price * len(names)


def _entry(votes: Sequence[Vote], names: Names, price: float) -> JointEntry | str:
    """A set with the evidence of all campaigns; the name of the campaign that refuses it."""
    ballots = {}
    for item in votes:
        if not item.asked.intersection(names):
            continue
        ballot = item.weighed(names)
        if ballot is None:
            return item.name
        ballots[item.name] = ballot
    total = sum(item.log_evidence for item in ballots.values()) - price * len(names)
    return JointEntry(names=names, log_evidence=total, ballots=MappingProxyType(ballots))


def _parts(names: Names) -> list[Names]:
    """A set without each of its effects; none of a single one."""
    found = [tuple(x for x in names if x != name) for name in names]
    return [rest for rest in found if rest]
