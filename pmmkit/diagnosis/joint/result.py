"""What several campaigns say together: verdict, rivals, the share of each, whose an effect is."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from pmmkit.diagnosis.evidence import PRICE, Visible, Weight, weight_of, with_or_without
from pmmkit.diagnosis.findings import AS_LIKELY, VERDICTS, Diagnosis, Transfer, Verdict
from pmmkit.diagnosis.joint.belongs import LABORATORY, LaboratoryValues, Owner, Third
from pmmkit.diagnosis.joint.captive_vote import Ballot, Names, of_ship
from pmmkit.effects import CATALOGUE
from pmmkit.intake import Disagreement
from pmmkit.models import Model, odds
from pmmkit.presentation import WIDE, Described, Grid, Group, Section, counted, number

if TYPE_CHECKING:
    import pandas as pd

    from pmmkit.plotting import Figure

BASE: Final = "the base"
"""What scatters between laboratories beside effects."""
_MOST: Final = 12
"""Effects in the printed table."""


@dataclass(frozen=True, kw_only=True)
class JointEntry:
    """A set of effects of the ship with the evidence of all campaigns.

    `log_evidence`: against no effect, all campaigns together, with the price of each effect.
    `ballots`: what each campaign says, without that price.
    """

    names: Names
    log_evidence: float
    ballots: Mapping[str, Ballot]

    @property
    def linear(self) -> bool:
        """Whether a campaign says it by a linear problem, not through the equations."""
        return any(item.linear for item in self.ballots.values())


@dataclass(frozen=True, kw_only=True, eq=False)
class Belonging:
    """Whether an effect is the ship's or a laboratory's.

    `log_odds`: ln of the odds for one set of coefficients against one for each laboratory; NaN
    where fewer than two of them measure the effect. `coefficients`: those that all laboratories
    have. `size`: of what is found, over these; laboratories differ by τ of it. `thirds`: what
    another laboratory would find, by the scale of what laboratories differ by; the first is the
    one to use, the others show how much hangs on it. `shown`: ln evidence of each campaign for it
    beside the others of the set, without a price.
    """

    effect: str
    owner: Owner
    log_odds: float
    coefficients: tuple[str, ...]
    usual: tuple[float, ...]
    size: float
    measured: tuple[LaboratoryValues, ...]
    thirds: tuple[Third, ...]
    shown: Mapping[str, float]

    @property
    def sentence(self) -> str:
        """The answer in words."""
        if not math.isfinite(self.log_odds):
            return f"{self.effect}: cannot tell whose it is, {self._why()}."
        sides = "one size for all" if self.log_odds > 0.0 else "a size for each"
        alone = [name for name, x in self.shown.items() if x > PRICE]
        by = f"; {alone[0]} alone shows it" if len(alone) == 1 < len(self.shown) else ""
        return f"{self.effect}: {self.owner} ({odds(abs(self.log_odds))} for {sides}{by})."

    @property
    def refusal(self) -> str:
        """Why it is refused where it is `unshown`."""
        told = ", ".join(f"{name} {x:+.1f}" for name, x in self.shown.items())
        return (
            f"{self.effect}: {odds(abs(self.log_odds))} for a size for each, of which each pays "
            f"{PRICE:.1f} (ln evidence {told})"
        )

    @property
    def unshown(self) -> bool:
        """Whether each laboratory has a size of its own, and none pays the price of it."""
        return self.owner == LABORATORY and max(self.shown.values(), default=math.inf) < PRICE

    def _why(self) -> str:
        names = [item.laboratory for item in self.measured]
        if len(names) > 1:
            return f"{' and '.join(names)} measure no coefficient of it that all have"
        return f"only {names[0]} measures it" if names else "none measures it"

    def rows(self) -> list[list[str | None]]:
        """Coefficient, each laboratory, the next one at three scales of their differences."""
        found: list[list[str | None]] = []
        for i, name in enumerate(self.coefficients):
            own = [
                _interval(item.values[i], math.sqrt(item.covariance[i, i]))
                for item in self.measured
            ]
            other = [_interval(item.values[i], item.std[i]) for item in self.thirds]
            found.append([name, *own, *other, number(self.usual[i], 2)])
        return found

    def head(self) -> list[str]:
        """Of `rows`."""
        return [
            "coefficient",
            *(item.laboratory for item in self.measured),
            *(f"another, τ ~ {item.scale:g}" for item in self.thirds),
            "usual size",
        ]

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return {
            "effect": self.effect,
            "owner": self.owner,
            "shown": dict(self.shown),
            "log_odds": self.log_odds if math.isfinite(self.log_odds) else None,
            "coefficients": list(self.coefficients),
            "measured": {
                item.laboratory: {
                    "values": item.values.tolist(),
                    "std": np.sqrt(np.diagonal(item.covariance)).tolist(),
                }
                for item in self.measured
            },
            "another_laboratory": [
                {"scale": x.scale, "values": x.values.tolist(), "std": x.std.tolist()}
                for x in self.thirds
            ],
        }


@dataclass(frozen=True, kw_only=True, eq=False)
class Another:
    """The model of a laboratory that has not tested yet.

    `model`: the ship of the records with what all laboratories share; the covariance holds by
    what they differ. `ship`: the same with what is not known of the ship alone, as if all
    laboratories were one. `scales`: scales of the half-normal priors of what laboratories differ
    by, over usual sizes: of values of the base, and of each effect. `scatter`: what the campaigns
    make of it, root mean square.
    """

    model: Model
    ship: Model
    scales: Mapping[str, float]
    scatter: Mapping[str, float]


def _interval(value: float, std: float) -> str:
    return f"{number(float(value), 3)} ± {number(WIDE * float(std), 2)}"


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Together(Described):
    """What several campaigns of one ship say together.

    Parameters
    ----------
    verdict : {"noise", "missing_effect", "suspected", "unexplained"}
        As of a `Diagnosis`.
    group : tuple of (effects, odds)
        The best set first, with the odds of each against it.
    entries : tuple of JointEntry
        All sets that were weighed, best first; then single effects of little promise, of which
        the linear problems alone were asked.
    diagnoses : mapping of str to Diagnosis
        Of each campaign alone.
    belongs : tuple of Belonging
        Whose the effects of the best set are.
    added : mapping of str to float
        ln of the odds for each effect of the best set beside the others.
    refused : tuple of (campaign, effects)
        Sets that fit a campaign but predict what is left out worse, or make no ship of it.
    flags : tuple of str
        What to warn of.
    notes : tuple of str
        How it was found.
    model : Model, optional
        With the best set, fitted to the records, or to the captive tests where there are none.
    others : tuple of Another
        For a laboratory that has not tested yet, by the scale of what laboratories differ by; the
        first is the one to use. None without free-running records.
    given : tuple of str
        Candidates that the base had already.
    disagreements : mapping of str to tuple of Disagreement
        By campaign: groups of runs that disagree with the others beside the best set; and those
        that, one in each campaign, explain as much in its place.
    errors : mapping of str to Mapping of str to Mapping of str to float
        By campaign: errors of what is held out, by model and quantity.
    transfers : mapping of str to tuple of Transfer
        By campaign: what each effect of the best set does to kinds of records that are left out.
    unshared : tuple of Belonging
        Effects that are refused: no campaign alone shows them, and together they agree on no size.
    """

    verdict: Verdict
    group: tuple[tuple[Names, float], ...]
    entries: tuple[JointEntry, ...]
    diagnoses: Mapping[str, Diagnosis]
    belongs: tuple[Belonging, ...]
    added: Mapping[str, float]
    refused: tuple[tuple[str, Names], ...]
    flags: tuple[str, ...]
    notes: tuple[str, ...]
    model: Model | None = None
    others: tuple[Another, ...] = ()
    given: Names = ()
    disagreements: Mapping[str, tuple[Disagreement, ...]] = field(
        default_factory=lambda: MappingProxyType({})
    )
    errors: Mapping[str, Mapping[str, Mapping[str, float]]] = field(
        default_factory=lambda: MappingProxyType({})
    )
    transfers: Mapping[str, tuple[Transfer, ...]] = field(
        default_factory=lambda: MappingProxyType({})
    )
    unshared: tuple[Belonging, ...] = ()

    @property
    def best(self) -> Names:
        """The best set of effects; empty where none is named."""
        return self.group[0][0] if self.group else ()

    @property
    def proposed(self) -> Names:
        """What to add now: effects of the best set that are no laboratory's, and that hold for all
        kinds of records."""
        apart = {item.effect for item in self.belongs if item.owner == LABORATORY}
        narrow = {x.effect for own in self.transfers.values() for x in own if x.is_narrow}
        return tuple(name for name in self.best if name not in apart | narrow)

    @property
    def answer(self) -> str:
        """The effects that are named, or the verdict, in few words."""
        return " and ".join(self.best) or VERDICTS[self.verdict].rstrip(".").lower()

    @property
    def sentence(self) -> str:
        """The verdict in words."""
        return VERDICTS[self.verdict]

    def weight(self, name: str, share: float = math.nan) -> Weight:
        """Evidence for an effect in words; of one that is not named, `share` of the held-out misfit
        goes with it."""
        return weight_of(name, self.entries, self.best, share)

    def log_odds_of(self, name: str) -> float:
        """ln odds of the best set with an effect against the best one without it."""
        return with_or_without(name, self.entries)

    def rivals_of(self, name: str) -> list[Names]:
        """Sets without an effect that are about as likely as the best one, which has it."""
        return [
            names for names, odd in self.group[1:] if name not in names and odd > 1.0 - AS_LIKELY
        ]

    def faults_of(self, campaign: str) -> Names:
        """Faults that a campaign has beside the best set, or that it alone names."""
        best = self.entries[0] if self.entries and self.group else None
        if best is not None and campaign in best.ballots:
            return best.ballots[campaign].faults
        alone: Names = self.diagnoses[campaign].best
        return () if of_ship(alone) else alone

    @property
    def hidden(self) -> tuple[Visible, ...]:
        """Effects that no campaign could show, as the one says that comes nearest to it."""
        shown: set[str] = set()
        nearest: dict[str, Visible] = {}
        for diagnosis in self.diagnoses.values():
            for item in diagnosis.covered:
                if item.shown:
                    shown.add(item.name)
                elif item.name not in nearest or item.hides < nearest[item.name].hides:
                    nearest[item.name] = item
        return tuple(item for name, item in nearest.items() if name not in shown)

    @property
    def names(self) -> tuple[str, ...]:
        """Of the campaigns."""
        return tuple(self.diagnoses)

    @property
    def singles(self) -> tuple[JointEntry, ...]:
        """Single effects, best first."""
        return tuple(item for item in self.entries if len(item.names) == 1)

    def to_pandas(self) -> pd.DataFrame:
        """Every single effect: ln evidence of each campaign (NaN if not asked for it), of all."""
        import pandas as pd

        return pd.DataFrame(
            [
                {
                    "effect": item.names[0],
                    "family": CATALOGUE[item.names[0]].family,
                    **{
                        name: item.ballots[name].log_evidence if name in item.ballots else math.nan
                        for name in self.names
                    },
                    "together": item.log_evidence,
                    "named": item.names[0] in self.best,
                }
                for item in self.singles
            ],
            columns=["effect", "family", *self.names, "together", "named"],
        )

    def to_dict(self) -> dict[str, Any]:
        """As plain data: what ``pmmkit diagnose --json`` prints for several campaigns."""
        return {
            "verdict": self.verdict,
            "given": list(self.given),
            "group": [{"effects": list(names), "odds": odd} for names, odd in self.group],
            "evidence": [
                {
                    "effects": list(item.names),
                    "log_evidence": item.log_evidence,
                    "linear": item.linear,
                    "campaigns": {
                        name: {"log_evidence": x.log_evidence, "faults": list(x.faults)}
                        for name, x in item.ballots.items()
                    },
                }
                for item in self.entries
            ],
            "added": dict(self.added),
            "belongs": [item.to_dict() for item in self.belongs],
            "unshared": [item.to_dict() for item in self.unshared],
            "proposed": list(self.proposed),
            "transfers": {
                name: [item.to_dict() for item in own] for name, own in self.transfers.items()
            },
            "errors": {
                name: {row: dict(x) for row, x in own.items()} for name, own in self.errors.items()
            },
            "another_laboratory": [
                {"scales": dict(x.scales), "scatter": dict(x.scatter)} for x in self.others
            ],
            "refused": [{"campaign": name, "effects": list(names)} for name, names in self.refused],
            "price": PRICE,
            "disagreements": {
                name: [asdict(item) for item in own] for name, own in self.disagreements.items()
            },
            "flags": list(self.flags),
            "notes": list(self.notes),
            "campaigns": {name: item.to_dict() for name, item in self.diagnoses.items()},
        }

    def plot(self) -> Figure:
        """Evidence of the best effects and sets, all campaigns together."""
        from pmmkit.diagnosis.figures import evidence

        named = [names for names, _ in self.group]
        return evidence(
            [item.names for item in self.entries],
            [item.log_evidence for item in self.entries],
            named=[item.names in named for item in self.entries],
            faults=[False] * len(self.entries),
        )

    def _headline(self) -> str:
        by = counted(len(self.names), "campaign")
        return f"{self.verdict.replace('_', ' ')} by {by}: {self.answer}"

    def _sections(self) -> Sequence[Section]:
        alone = [f"{name}: {item.verdict}: {item.answer}" for name, item in self.diagnoses.items()]
        rivals = [
            f"{' and '.join(names)} "
            f"({f'about {1.0 / odd:.0f} to 1 against it' if odd < AS_LIKELY else 'as likely'})"
            for names, odd in self.group[1:]
        ]
        refused = [f"{' and '.join(names)} by {name}" for name, names in self.refused]
        told = [
            Section(title="Each alone", points=alone),
            Section(title="ln evidence", tables=[self._table()] if self.entries else []),
            Section(title="These campaigns cannot tell it from", points=rivals),
            *(
                Section(
                    title=item.sentence,
                    tables=[Grid(head=item.head(), groups=[Group(rows=item.rows())])]
                    if item.coefficients
                    else [],
                )
                for item in self.belongs
                if item.measured
            ),
            Section(
                title="Refused, since no campaign shows it alone and all agree on no size",
                points=[item.refusal for item in self.unshared],
            ),
            Section(
                title="What each effect does to records of a kind that is left out",
                points=[f"{name}: {x}" for name, own in self.transfers.items() for x in own],
            ),
            Section(
                title="By what another laboratory differs, over usual sizes (scale of the prior)",
                tables=[self._scatter()] if self.others else [],
            ),
            Section(title="Refused, since what is left out gets worse by it", points=refused),
            Section(
                title="What fits where no effect explains it",
                points=[
                    f"{name}: {text}"
                    for name, item in self.diagnoses.items()
                    if item.formula is not None
                    for text in item.formula.remarks()
                ],
            ),
            Section(
                title="What these runs cannot tell",
                points=[f"{name}: {x}" for name, own in self.diagnoses.items() for x in own.untold],
            ),
            Section(title="Notes", points=self.notes),
        ]
        effects = [
            f"{name}: evidence {odds(x)} beside the others" for name, x in self.added.items()
        ]
        first = Section(
            paragraphs=[f"Verdict: {VERDICTS[self.verdict]}", *self.flags], points=effects
        )
        owners = [
            f"{owner}: {', '.join(names)}"
            for owner in ("the ship's", LABORATORY, "cannot tell")
            if (names := [x.effect for x in self.belongs if x.owner == owner])
        ]
        owners += [
            f"{name}'s own: {', '.join(faults)}"
            for name in self.names
            if (faults := self.faults_of(name))
        ]
        told = [Section(title="What belongs to whom", points=owners), *told]
        return [first, *(item for item in told if item.points or item.tables)]

    def _table(self) -> Grid:
        """Sets by campaign: the group, then single effects."""
        named = [names for names, _ in self.group]
        sets = [item for item in self.entries if item.names in named]
        rest = [item for item in self.singles if item not in sets][:_MOST]
        return Grid(
            head=["effects", *self.names, "together, price off"],
            groups=[
                Group(rows=[self._row(item) for item in own], title=title)
                for title, own in (("Named and its rivals", sets), ("Single effects", rest))
                if own
            ],
        )

    def _scatter(self) -> Grid:
        """By what laboratories differ, a column for each scale of the prior."""
        rows: list[list[str | None]] = [
            [
                name,
                *(
                    f"{number(x.scatter[name], 2)} ({number(x.scales[name], 2)})"
                    for x in self.others
                ),
            ]
            for name in self.others[0].scatter
        ]
        head = ["", "to use", *("to compare" for _ in self.others[1:])]
        return Grid(head=head, groups=[Group(rows=rows)])

    def _row(self, item: JointEntry) -> list[str | None]:
        cells: list[str | None] = []
        for name in self.names:
            ballot = item.ballots.get(name)
            beside = f" (with {' and '.join(ballot.faults)})" if ballot and ballot.faults else ""
            about = "about " if ballot and ballot.linear else ""
            cells.append(None if ballot is None else f"{about}{ballot.log_evidence:+.1f}{beside}")
        return [" + ".join(item.names), *cells, f"{item.log_evidence:+.1f}"]
