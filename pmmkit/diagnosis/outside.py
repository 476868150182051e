"""How probable it is that a name without a flag stands for something outside the catalogue.

Each entry of the catalogue is taken out in turn and hidden in the runs that were made. What it is
called then tells how often a name stands for something else (docs/theory/evidence.md).
"""

from __future__ import annotations

import hashlib
import json
import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, Literal, get_args

from pmmkit.base import DataError, Remedy, Way
from pmmkit.diagnosis.evidence import PRICE, SHOWS, Visible
from pmmkit.files import readable, write_text
from pmmkit.presentation import listed, percent

FILE: Final = "hidden_entries.json"
"""File beside a campaign that keeps what its hidden entries were called."""
SIZES: Final = (1.0, 0.3)
"""Shares of its usual size at which an entry is hidden."""
WIDTH: Final = math.log(1.0 / 0.3)
"""Width over which the logarithm of a score is spread: evidence grows as the square of the size,
and the sizes that are tried lie as far apart as `SIZES`."""
LEAST: Final = 0.5
"""Least score, so that its logarithm is one."""
DOUBTFUL: Final = 0.05
"""Probability above which a name does not stand without a flag."""
PERHAPS: Final = "perhaps_outside"
"""First of the flags of a name whose only doubt is that it may stand for something else."""
End = Literal["named", "flagged", "suspected", "unexplained", "noise", "not_shown"]
"""How a diagnosis ended: with a name, with one and a flag, with a verdict; or the entry is so small
in these runs that nobody had to ask."""


@dataclass(frozen=True, kw_only=True)
class HiddenEntry:
    """What one entry of the catalogue was called while it was taken out and hidden in the runs.

    `effect, size`: which, at which share of its usual size. `end`: how the diagnosis ended.
    `names`: what was named, or came nearest. `log_odds`: ln of the odds for each name.
    """

    effect: str
    size: float
    end: End
    names: tuple[str, ...] = ()
    log_odds: tuple[float, ...] = ()

    def __str__(self) -> str:
        return self.effect if self.size == 1.0 else f"{self.effect} at {self.size:g} of its size"


@dataclass(frozen=True, kw_only=True)
class Outside:
    """What hidden entries say of an answer.

    `names`: the answer. `probability`: that it stands for something outside the catalogue; None of
    an answer that is flagged, or names nothing. `called`: what was called so too; of an answer
    without probability what got one of its names. `hidden`: how many entries were hidden, each at
    all `SIZES`. `group`: effects of the other sets that the runs cannot tell from the answer.
    """

    names: tuple[str, ...]
    probability: float | None
    called: tuple[HiddenEntry, ...]
    hidden: int
    group: tuple[str, ...] = ()

    @property
    def doubtful(self) -> bool:
        """Whether the name must not stand without a flag."""
        return self.probability is not None and self.probability > DOUBTFUL

    @property
    def may_be(self) -> tuple[str, ...]:
        """What the answer may be: the names, their rivals, and what was called so."""
        effects = (item.effect for item in self.called)
        return tuple(dict.fromkeys((*self.names, *self.group, *effects)))

    def __str__(self) -> str:
        said = []
        if self.probability is not None:
            share = percent(self.probability, signed=False)
            verb = "stands" if len(self.names) == 1 else "stand"
            care = f", above {100 * DOUBTFUL:g} %: do the check first" if self.doubtful else ""
            said.append(
                f"{listed(self.names)} {verb} for something outside the catalogue with a "
                f"probability of {share}{care}."
            )
        if said or self.called:
            who = listed([str(item) for item in self.called]) if self.called else "none of them"
            sizes = listed([f"{size:g}" for size in SIZES])
            said.append(
                f"{self.hidden} entries of the catalogue were taken out in turn and hidden in "
                f"these runs, at {sizes} of their usual size: {who} got {self._these}."
            )
        return " ".join(said)

    @property
    def _these(self) -> str:
        if len(self.names) == 1:
            return "this name"
        return "one of these names" if self.probability is None else "these names"

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return {
            "probability": self.probability,
            "doubtful": self.doubtful,
            "hidden": self.hidden,
            "called_so": [asdict(item) for item in self.called],
            "may_be": list(self.may_be),
        }


@dataclass(frozen=True, kw_only=True)
class HiddenEntries:
    """What the entries of the catalogue were called, hidden in the runs of a programme.

    `digest`: of programme, noise, base and catalogue. `families`: the family of each entry that can
    be asked. `ends`: one for each entry and size; fewer while they are made.
    """

    digest: str
    families: Mapping[str, str]
    ends: tuple[HiddenEntry, ...] = field(default=())

    @property
    def complete(self) -> bool:
        """Whether every entry was hidden at every size."""
        return len(self.ends) == len(self.families) * len(SIZES)

    @property
    def unknown_family(self) -> float:
        """Probability that the next cause is of a family that the catalogue has not: families of
        one entry over entries (Good 1953)."""
        sizes = Counter(self.families.values())
        return sum(count == 1 for count in sizes.values()) / len(self.families)

    def of(
        self,
        names: tuple[str, ...],
        rivals: tuple[str, ...],
        scores: Mapping[str, float],
        covered: Sequence[Visible],
    ) -> Outside:
        """What they say of an answer.

        Parameters
        ----------
        names, rivals : tuple of str
            What is named or comes nearest, and what the runs cannot tell from it.
        scores : mapping of str to float
            ln of the odds for each name that stands without a flag; empty of other answers.
        covered : sequence of Visible
            What the runs can show of each entry.
        """
        known = scores and self.families.keys() >= scores.keys()
        mine = set(names)
        return Outside(
            names=names,
            probability=self.probability(scores, covered) if known else None,
            # Of flagged sets of the virtual tank 18 of 19 hold the truth so, with equal names 14.
            called=tuple(
                item
                for item in self.ends
                if (set(item.names) == mine if known else mine.intersection(item.names))
            ),
            hidden=len(self.families),
            group=rivals,
        )

    def probability(self, scores: Mapping[str, float], covered: Sequence[Visible]) -> float:
        """Probability that names without a flag stand for something outside the catalogue.

        Notes
        -----
        With N entries and the probability q of an unknown family, something outside is N q/(1 - q)
        times as frequent as one entry. docs/theory/evidence.md has the equations.
        """
        q, shows = self.unknown_family, {item.name: item for item in covered}
        inside = {name: self._found(x, shows[name]) for name, x in scores.items()}
        as_set = self._called(scores) * math.exp(PRICE * (len(scores) - 1))
        odds = as_set / math.prod(inside.values())
        if len(scores) > 1:
            odds += sum(self._called({name: x}) / inside[name] for name, x in scores.items())
        odds *= len(self.families) * q
        return odds / (odds + 1.0 - q) if odds else 0.0

    def _called(self, scores: Mapping[str, float]) -> float:
        """Density of hidden entries that are called so, at these scores.

        Names that none got share what is expected of names that are still unseen (Good 1953).
        """
        ends = [item for item in self.ends if item.end == "named"]
        score = sum(scores.values())
        mine = [item for item in ends if set(item.names) == set(scores)]
        if mine or len(scores) > 1:
            return sum(_near(score, sum(item.log_odds)) for item in mine) / len(self.ends)
        alone = [item for item in ends if len(item.names) == 1]
        seen = Counter(item.names for item in alone)
        unseen = len(self.families) - len(seen)
        if not alone or not unseen:
            return 0.0
        once = sum(count == 1 for count in seen.values()) / len(self.ends)
        spread = sum(_near(score, sum(item.log_odds)) for item in alone) / len(alone)
        return once / unseen * spread

    @staticmethod
    def _found(score: float, shown: Visible) -> float:
        """Density at a score of an entry that is what it is called."""
        sizes = [size for size in SIZES if shown.without_a_run * size**2 >= SHOWS] or SIZES[:1]
        expected = (0.5 * shown.signal * size**2 - PRICE for size in sizes)
        return sum(_near(score, x) for x in expected) / len(SIZES)

    def to_dict(self) -> dict[str, Any]:
        """As plain data, with a checksum."""
        content = {
            "digest": self.digest,
            "families": dict(self.families),
            "ends": [asdict(item) for item in self.ends],
        }
        return {**content, "sha256": _checksum(content)}


def _near(score: float, other: float) -> float:
    """Density of a score about another, Laplace's in their logarithms, over its largest value."""
    apart = math.log(max(score, LEAST) / max(other, LEAST))
    return math.exp(-abs(apart) / WIDTH)


# Files of tables, one for each base.


def _checksum(content: Mapping[str, Any]) -> str:
    return hashlib.sha256(readable(content).encode()).hexdigest()


def read_hidden_entries(path: Path) -> dict[str, HiddenEntries]:
    """The tables of a file by their digest; none where there is no file.

    Raises
    ------
    DataError
        If it is damaged, or something else.
    """
    if not path.is_file():
        return {}
    try:
        tables = json.loads(path.read_text(encoding="utf-8"))["tables"]
        found = [_table(item) for item in tables]
    except (OSError, ValueError, TypeError, LookupError, AttributeError, RecursionError) as error:
        raise DataError(
            f"{path.name} beside the campaign is damaged and not used.",
            remedy=Remedy("Delete it; {} makes it anew.", (Way.setting("outside", True),)),
        ) from error
    return {item.digest: item for item in found}


def _table(content: Any) -> HiddenEntries:
    """A table as `HiddenEntries.to_dict` wrote it."""
    content = dict(content)
    if content.pop("sha256") != _checksum(content):
        raise ValueError("its content is another than was written")
    return HiddenEntries(
        digest=str(content["digest"]),
        families=MappingProxyType({str(k): str(x) for k, x in content["families"].items()}),
        ends=tuple(_end(item) for item in content["ends"]),
    )


def _end(content: Mapping[str, Any]) -> HiddenEntry:
    if content["end"] not in get_args(End):
        raise ValueError(content["end"])
    return HiddenEntry(
        effect=str(content["effect"]),
        size=float(content["size"]),
        end=content["end"],
        names=tuple(map(str, content["names"])),
        log_odds=tuple(map(float, content["log_odds"])),
    )


def save_hidden_entries(path: Path, table: HiddenEntries) -> bool:
    """Put a table into a file, all or nothing; those of other digests stay.

    A damaged file is replaced. False where the folder cannot be written.
    """
    try:
        others = read_hidden_entries(path)
    except DataError:
        others = {}
    tables = {**others, table.digest: table}
    try:
        write_text(path, readable({"tables": [x.to_dict() for x in tables.values()]}) + "\n")
    except OSError:
        return False
    return True
