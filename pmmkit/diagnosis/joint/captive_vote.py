"""Captive tests as one voice among several campaigns."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal, Protocol

import numpy as np

from pmmkit.base import ModelError, TableError
from pmmkit.campaigns import Campaign
from pmmkit.diagnosis.captive.adequacy import blocks_of
from pmmkit.diagnosis.captive.disagreement import disagreements
from pmmkit.diagnosis.captive.formula import told_with_formula
from pmmkit.diagnosis.captive.held_out import missed
from pmmkit.diagnosis.captive.least_squares import JointFit, joint_fit, labels, refined
from pmmkit.diagnosis.captive.refit import in_convention, refitted
from pmmkit.diagnosis.captive.system import WIDER, CandidateColumns, System
from pmmkit.diagnosis.captive.verdict import RankedSets, ranked
from pmmkit.diagnosis.evidence import PRICE, RankedSet
from pmmkit.diagnosis.findings import Diagnosis, Transfer
from pmmkit.diagnosis.joint.belongs import LaboratoryValues
from pmmkit.effects import Effect, is_fault
from pmmkit.intake import Disagreement, Untold
from pmmkit.models import DerivativeTable, Model
from pmmkit.numerics import Array
from pmmkit.reduction import View

# What one campaign says of sets of effects, its own faults taken out.


Names = tuple[str, ...]
Kind = Literal["captive", "free-running"]


@dataclass(frozen=True, kw_only=True)
class Ballot:
    """What a campaign says of a set of effects.

    `log_evidence`: ln of how much more probable the campaign is with the set and the faults
    that it then has than with its own faults alone. The set pays no price here, each fault
    does. `faults`: the faults beside the set. `linear`: whether it is by a linear problem
    alone, where the equations themselves might be asked.
    """

    log_evidence: float
    faults: Names = ()
    linear: bool = False


class Vote(Protocol):
    """A campaign that has been diagnosed, and can be asked for more sets of effects."""

    @property
    def name(self) -> str:
        """Of the campaign."""

    @property
    def kind(self) -> Kind:
        """How the ship was tested."""

    @property
    def diagnosis(self) -> Diagnosis:
        """Of the campaign alone."""

    @property
    def asked(self) -> frozenset[str]:
        """Effects of the ship that this campaign was asked for."""

    @property
    def kept(self) -> frozenset[Names]:
        """Sets that its own diagnosis fitted, and that predict what is left out better."""

    def promised(self, names: Names) -> Ballot:
        """A set, as far as is known without another fit."""

    def prepare(self, sets: Sequence[Names], /) -> None:
        """Make ready for sets that are weighed next."""

    def weighed(self, names: Names) -> Ballot | None:
        """A set after its own fit; None if that fit leads nowhere."""

    def sizes(self, names: Names, faults: Names) -> Mapping[str, LaboratoryValues]:
        """The effects of a set, fitted together."""

    def groups(self, names: Names, faults: Names) -> Sequence[Disagreement]:
        """Groups of runs with the evidence that they disagree, beside a set and in its place."""

    def model_with(self, names: Names, faults: Names) -> Model | None:
        """The model with a set, all fitted to this campaign; None without a complete model."""

    def transfers(self, names: Names, faults: Names, /) -> tuple[Transfer, ...]:
        """What effects do to kinds of records that are left out, each beside those before it."""

    def held_out_errors(
        self, names: Names, faults: Names, others: Mapping[str, Model], /
    ) -> Mapping[str, Mapping[str, float]]:
        """Errors of what is held out: of the base alone, of a set, and of other models."""


def of_ship(names: Iterable[str]) -> Names:
    """Effects of the ship, for which campaigns vote together; in one order."""
    return tuple(sorted(name for name in names if not is_fault(name)))


def asked_in(entries: Sequence[RankedSet]) -> frozenset[str]:
    """Effects of the ship that stand in sets."""
    return frozenset(name for item in entries for name in of_ship(item.names))


def fault_sets(entries: Sequence[RankedSet], most: int) -> list[Names]:
    """The best sets of faults alone that are worth their price."""
    found = [item for item in entries if not of_ship(item.names) and item.log_evidence > 0.0]
    return [item.names for item in sorted(found, key=lambda item: -item.log_evidence)[:most]]


def faults_beside(entries: Sequence[RankedSet], names: Names) -> Names:
    """The faults of the best set that has just these effects of the ship; none if there is none."""
    same = [item for item in entries if set(of_ship(item.names)) == set(names)]
    if not same:
        return ()
    best = max(same, key=lambda item: item.log_evidence)
    return tuple(name for name in best.names if is_fault(name))


FAULTS: Final = 3
"""Sets of faults that may stand beside an effect, or instead of it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Beside:
    """Effects as captive tests measure them together, and how the base moves with them.

    `values, covariance (k,)`: fitted, with what was known before. `before (k,)`: standard
    deviations before the tests. `base`: derivatives of the base. `along (b, k)`: change of each
    for a coefficient of 1, in the convention of the model.
    """

    labels: tuple[tuple[str, str], ...]
    values: Array
    covariance: Array
    before: Array
    base: Names
    along: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class CaptiveVote:
    """Captive tests that have been diagnosed.

    `model`: whose derivatives are the base. `diagnosis`: of these tests alone. `ranking`: runs,
    base and candidates, the effects that the model has, and sets of the others beside these.
    `faults`: none, and the best sets of faults. `own`: effects of the user. `unseen`: runs that are
    held out.
    """

    name: str
    campaign: Campaign
    model: Model
    diagnosis: Diagnosis
    ranking: RankedSets
    faults: list[Names]
    own: tuple[Effect, ...] = ()
    unseen: tuple[View, ...] = ()

    @property
    def kind(self) -> Kind:
        """How the ship was tested."""
        return "captive"

    @property
    def asked(self) -> frozenset[str]:
        """Effects of the ship that these tests were asked for."""
        return asked_in(self.diagnosis.entries)

    @property
    def kept(self) -> frozenset[Names]:
        """None: all sets are one linear problem."""
        return frozenset()

    def promised(self, names: Names) -> Ballot:
        """A set of effects: all sets are one linear problem."""
        mine = tuple(name for name in names if name in self.ranking.sets.by_name)
        if not mine:
            return Ballot(log_evidence=0.0)
        paid = PRICE * len(mine)
        alone = max(self._evidence(faults) for faults in self.faults)
        value, faults = max(
            (self._evidence((*mine, *beside)), beside) for beside in self._beside(mine)
        )
        return Ballot(log_evidence=value + paid - alone, faults=faults)

    def prepare(self, _sets: Sequence[Names]) -> None:
        """Nothing takes long."""

    def weighed(self, names: Names) -> Ballot:
        """The same."""
        return self.promised(names)

    def sizes(self, names: Names, faults: Names) -> Mapping[str, LaboratoryValues]:
        """The effects of a set, fitted together with the base."""
        _, blocks, fit = self._fitted(names, faults)
        found = {}
        for block in blocks:
            c = block.candidate
            if c.name not in names or c.each_run:
                continue
            at = [fit.names.index(label) for label in labels(c)]
            if not np.all(np.isfinite(fit.values[at])):
                continue
            found[c.name] = LaboratoryValues(
                laboratory=self.name,
                values=fit.values[at],
                covariance=fit.covariance[np.ix_(at, at)],
                coefficients=c.coefficients,
                typical=c.typical,
            )
        return found

    def beside(self, names: Names, faults: Names) -> Beside:
        """The effects of a set, and how the base moves with them.

        Where a regression is given an effect, its other values move by what they share: given the
        coefficients, the base is what it is without them, and ``C_be C_ee⁻¹`` times these more.
        """
        _, blocks, fit = self._fitted(names, faults)
        told: dict[str, tuple[tuple[str, str], float]] = {}
        for block in blocks:
            c = block.candidate
            if c.name in names and not c.each_run:
                every = zip(c.coefficients, labels(c), c.typical, strict=True)
                told |= {x: ((c.name, own), WIDER * abs(size)) for own, x, size in every}
        known = np.isfinite(fit.values)
        at = [i for i, x in enumerate(fit.names) if x in told and known[i]]
        base = [i for i, x in enumerate(fit.names) if x in self._derivatives and known[i]]
        covariance = fit.covariance[np.ix_(at, at)]
        cross: Array = fit.covariance[np.ix_(at, base)]
        along = np.linalg.solve(covariance, cross).astype(float) if at else None
        names_of, moved = self._converted(fit, base, along)
        return Beside(
            labels=tuple(told[fit.names[i]][0] for i in at),
            values=fit.values[at],
            covariance=covariance,
            before=np.array([told[fit.names[i]][1] for i in at]),
            base=names_of,
            along=moved,
        )

    @property
    def _derivatives(self) -> frozenset[str]:
        return frozenset(name for own in self.ranking.system.base.names.values() for name in own)

    def _converted(
        self, fit: JointFit, base: Sequence[int], along: Array | None
    ) -> tuple[Names, Array]:
        """Derivatives by the convention of the model, and changes (k, b) of the base in it."""

        def told(values: Array) -> DerivativeTable:
            own = JointFit(
                names=tuple(fit.names[i] for i in base),
                values=values,
                covariance=fit.covariance[np.ix_(base, base)],
            )
            return in_convention(
                own, self.ranking.system.base, self.campaign, self.model.convention
            )

        first = told(fit.values[base])
        changes = [] if along is None else [told(fit.values[base] + row) for row in along]
        found = np.array([item.value[0] - first.value[0] for item in changes])
        return tuple(first.names), found.reshape(len(changes), len(first.names)).T

    def groups(self, names: Names, faults: Names) -> Sequence[Disagreement]:
        """Groups of runs with the evidence that they disagree, beside a set and in its place."""
        mine = [name for name in (*names, *faults) if name in self.ranking.sets.by_name]
        home = self.ranking.home(mine)
        blocks = blocks_of(home.beside, home.sets.entry(mine)) if mine else []
        return disagreements(home.system, home.used, blocks)

    def model_with(self, names: Names, faults: Names) -> Model | None:
        """The model with a set, all fitted together; None if these tests excite too little."""
        _, blocks, fit = self._fitted(names, faults)
        try:
            base = self.ranking.system.base
            return refitted(self.model, fit, blocks, base, self.campaign, self.own)[0]
        except (TableError, ModelError):
            return None

    def transfers(self, _names: Names, _faults: Names) -> tuple[Transfer, ...]:
        """None: whether an effect is of one size in all tests is asked of it (homogeneity)."""
        return ()

    def held_out_errors(
        self, names: Names, faults: Names, _others: Mapping[str, Model]
    ) -> Mapping[str, Mapping[str, float]]:
        """Errors of runs that are held out: of the base fitted to the others, and with a set.

        Other models are of ships that sail free: their hull stands behind a propeller.
        """
        if not self.unseen:
            return {}
        rows: dict[str, tuple[Names, Names]] = {"base refitted": ((), ())}
        if names or faults:
            rows["with the effects"] = names, faults
        found = {}
        for row, own in rows.items():
            system, blocks, fit = self._fitted(*own)
            found[f"held out, {row}"] = missed(self.unseen, system.base, blocks, fit)
        return found

    def _beside(self, names: Names) -> list[Names]:
        """Sets of faults that may stand beside effects: the best alone, and the best with them."""
        found = faults_beside(self.diagnosis.entries, names)
        return [*self.faults, *([found] if found not in self.faults else [])]

    def _evidence(self, names: Names) -> float:
        return self.ranking.sets.entry(names).log_evidence if names else 0.0

    def _fitted(
        self, names: Names, faults: Names
    ) -> tuple[System, tuple[CandidateColumns, ...], JointFit]:
        """The system in which a set is asked, its effects, and these fitted with the base."""
        mine = [name for name in (*names, *faults) if name in self.ranking.sets.by_name]
        home = self.ranking.home(mine)
        blocks = blocks_of(home.beside, home.sets.entry(mine)) if mine else []
        together = refined(home.system, [*home.known, *blocks])
        return home.system, together, joint_fit(home.system, together, floor=home.system.floor)


def vote_of_tests(
    name: str,
    model: Model,
    campaign: Campaign,
    system: System,
    given: Sequence[str] = (),
    *,
    own: Sequence[Effect] = (),
    unseen: tuple[View, ...] = (),
    seed: int = 0,
) -> CaptiveVote:
    """Diagnose a system of captive tests and keep what more sets need."""
    ranking = ranked(system, given, seed)
    found = told_with_formula(ranking, given, floor=system.floor, source=model)
    untold = Untold.of(campaign.within_reach(), values=found.base, recorded=True)
    return CaptiveVote(
        name=name,
        campaign=campaign,
        model=model,
        diagnosis=replace(found, untold=untold),
        ranking=ranking,
        faults=[(), *fault_sets(ranking.entries, FAULTS)],
        own=tuple(own),
        unseen=unseen,
    )
