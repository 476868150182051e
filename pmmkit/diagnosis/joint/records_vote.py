"""Free-running records as one voice among several campaigns."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Final

import numpy as np

from pmmkit.base import ModelError, SimulationError, each, opened
from pmmkit.diagnosis.evidence import PRICE
from pmmkit.diagnosis.findings import Diagnosis, Transfer
from pmmkit.diagnosis.free_running.base import FreeBase
from pmmkit.diagnosis.free_running.contest import Contest, steady, why_not
from pmmkit.diagnosis.free_running.diagnose import FreeSystem, with_given
from pmmkit.diagnosis.free_running.disagreement import disagreements
from pmmkit.diagnosis.free_running.findings import model_of
from pmmkit.diagnosis.free_running.fits import SetFit, fitted, place_at
from pmmkit.diagnosis.free_running.hypotheses import WIDER, FreeCandidate
from pmmkit.diagnosis.free_running.left_out import left_out_error
from pmmkit.diagnosis.free_running.transfer import transfers_of
from pmmkit.diagnosis.joint.belongs import LaboratoryValues
from pmmkit.diagnosis.joint.captive_vote import Ballot, Kind, Names, asked_in, fault_sets, of_ship
from pmmkit.identification import FreeRecord
from pmmkit.intake import Disagreement
from pmmkit.models import Model
from pmmkit.numerics import Array, one_thread

# How well a model knows its values by itself.


EXACT: Final = 1e-3
"""What a value that is stated without uncertainty is known to, over its usual size."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Stated:
    """Values of a model as it knows them.

    `names`: those of the base first, then others that state an uncertainty. `sizes`: usual size
    of each; of the others their standard uncertainty. `covariance, held (n, n)`: over these;
    without what values of the base state alone. `sure`: values of which an uncertainty is
    stated.
    """

    names: tuple[str, ...]
    sizes: Array
    covariance: Array
    held: Array
    sure: frozenset[str]


def stated_values(model: Model, base: FreeBase) -> Stated:
    """The covariance of a model, and what single values state."""
    more = {
        part.place(name): x
        for part in model.parts.values()
        for name, x in part.std.items()
        if x > 0.0 and part.place(name) not in base.names
    }
    b, sizes = len(base.names), np.append(base.sizes, [*more.values()])
    covariance = np.eye(len(sizes))
    covariance[:b, :b] = base.known[:b, :b]
    exact = EXACT**2 * np.eye(len(sizes))
    shared = np.append(~base.alone, np.ones(len(more), bool))
    names = (*base.names, *more)
    known = np.diagonal(covariance) > 0.0
    return Stated(
        names=names,
        sizes=sizes,
        covariance=covariance + exact,
        held=np.where(np.outer(shared, shared), covariance, 0.0) + exact,
        sure=frozenset(name for name, there in zip(names, known.tolist(), strict=True) if there),
    )


FAULTS: Final = 2
"""Sets of faults that are fitted through the equations, the best promise first."""

OWN: Final = 3
"""Effects in a set that records alone are asked for; sets of all campaigns grow from these."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RecordsVote:
    """Free-running records that have been diagnosed.

    `system`: records, model and candidates. `diagnosis`: of these records alone. `contest`:
    that led to it. `given`: candidates that the base has already. `held_out`: records for which it
    is asked how well they are predicted, over windows of `held_out_window` [s].
    """

    name: str
    system: FreeSystem
    diagnosis: Diagnosis
    contest: Contest
    given: Names = ()
    held_out: tuple[FreeRecord, ...] = ()
    held_out_window: float | None = None

    @property
    def kind(self) -> Kind:
        """How the ship was tested."""
        return "free-running"

    @property
    def model(self) -> Model:
        """Complete, of the ship as tested."""
        return self.system.model

    @property
    def asked(self) -> frozenset[str]:
        """Effects of the ship that these records were asked for."""
        return asked_in(self.diagnosis.entries)

    @property
    def kept(self) -> frozenset[Names]:
        """Sets of effects that the contest has fitted, and kept."""
        return frozenset(of_ship(item.names) for item in self.contest.settled)

    def promised(self, names: Names) -> Ballot:
        """A set by the linear problem; of one that was not looked at its best part."""
        mine = self._asked(names)
        if not mine:
            return Ballot(log_evidence=0.0)
        found = self._entries
        whole = [
            found[key]
            for faults in self._beside(mine)
            if (key := frozenset((*mine, *faults))) in found
        ]
        if whole:
            value = max(whole) + PRICE * len(mine) - self.ground
            return Ballot(log_evidence=value, linear=mine not in self.kept)
        parts = [tuple(x for x in mine if x != name) for name in mine]
        return max((self.promised(part) for part in parts), key=lambda item: item.log_evidence)

    def weighed(self, names: Names) -> Ballot | None:
        """A set fitted through the equations; None if records left out get worse by it."""
        mine = self._asked(names)
        if not mine:
            return Ballot(log_evidence=0.0)
        found = []
        for faults in self._beside(mine):
            fit = self.fit(frozenset((*mine, *faults)))
            if fit is not None:
                found.append((self._gain(fit, faults) - self.ground, faults))
        if not found:
            return None
        value, beside = max(found)
        return Ballot(log_evidence=value, faults=beside)

    def sizes(self, names: Names, faults: Names) -> Mapping[str, LaboratoryValues]:
        """The effects of a set; of those that come to values which the model has, by how much."""
        mine = self._asked(names)
        fit = self.fit(frozenset((*mine, *faults))) if mine else None
        if fit is None:
            return {}
        numbers = fit.place.question.numbers
        found = {}
        for item in self.system.every:
            if item.name not in mine:
                continue
            at = numbers.columns[item.name]
            size = WIDER * np.array(list(item.typical.values()))
            found[item.name] = LaboratoryValues(
                laboratory=self.name,
                values=size * fit.z[at],
                covariance=fit.covariance[np.ix_(at, at)] * np.outer(size, size),
                coefficients=tuple(item.typical),
                typical=tuple(item.typical.values()),
            )
        return found

    def stated(self, laboratory: str) -> Mapping[str, LaboratoryValues]:
        """Effects that come to values which the model has: by nothing, as well as it knows
        these."""
        known, found = self.known, {}
        for item in self.system.every:
            labels = [x for x, own in item.moves.items() if own and known.sure.issuperset(own)]
            if not labels:
                continue
            values = list(dict.fromkeys(name for x in labels for name in item.moves[x]))
            at = [known.names.index(name) for name in values]
            size = known.sizes[at]
            back = np.linalg.pinv(
                [[item.moves[x].get(name, 0.0) for x in labels] for name in values]
            )
            covariance = known.covariance[np.ix_(at, at)] * np.outer(size, size)
            found[item.name] = LaboratoryValues(
                laboratory=laboratory,
                values=np.zeros(len(labels)),
                covariance=back @ covariance @ back.T,
                coefficients=tuple(labels),
                typical=tuple(item.typical[x] for x in labels),
            )
        return found

    @cached_property
    def fits_into(self) -> tuple[Model, tuple[FreeCandidate, ...]]:
        """The model with what is given, and the other candidates: what a fit gives values to."""
        return with_given(self.system, self.given)

    @cached_property
    def known(self) -> Stated:
        """How well the model knows its values."""
        return stated_values(self.model, self.system.base)

    def model_with(self, names: Names, faults: Names) -> Model | None:
        """The model with a set, all values fitted to these records."""
        fit = self.steady(frozenset((*self._asked(names), *faults)))
        return None if fit is None else self.model_of(fit)

    def transfers(self, names: Names, faults: Names) -> tuple[Transfer, ...]:
        """What effects do to kinds of records that are left out, each beside those before it."""
        return transfers_of(self._asked(names), self.fit, faults)

    def held_out_errors(
        self, names: Names, faults: Names, others: Mapping[str, Model]
    ) -> Mapping[str, Mapping[str, float]]:
        """Errors of records that are held out: of the model as given, refitted, and with a set; and
        of other models of the ship."""
        if not self.held_out:
            return {}
        base = self.model_of(steady(self.contest.null))
        fit = self.steady(frozenset((*self._asked(names), *faults))) if names or faults else None
        return self.system.held_out_errors(
            self.held_out,
            self.held_out_window,
            {"base refitted": base, **others},
            None if fit is None else (self.model_of(fit), fit),
        )

    @cached_property
    def _known(self) -> dict[frozenset[str], SetFit | None]:
        """Sets through the equations, each once."""
        known: dict[frozenset[str], SetFit | None] = {
            frozenset(item.names): item.fit for item in self.contest.settled
        }
        return known | {frozenset(): self.contest.null}

    def fit(self, names: frozenset[str]) -> SetFit | None:
        """A set through the equations; None if it leads to no ship, or predicts records left out
        worse than the base alone."""
        if names not in self._known:
            self._fit_all([names])
        return self._known[names]

    def prepare(self, sets: Sequence[Names]) -> None:
        """Fit sets that are weighed next, side by side, each from what is known before them."""
        every = [
            frozenset((*own, *x))
            for names in sets
            if (own := self._asked(names))
            for x in self._beside(own)
        ]
        self._fit_all([x for x in dict.fromkeys(every) if x not in self._known])

    def _fit_all(self, sets: Sequence[frozenset[str]]) -> None:
        model, every = self.fits_into
        asked = []
        for names in sets:
            order = tuple(item.name for item in every if item.name in names)
            # From the most probable part of it: far from all of them a motion is easily lost.
            near = max(
                (fit for own, fit in self._known.items() if fit is not None and own < names),
                key=lambda x: x.log_probability,
            )
            asked.append((order, near))
        missed = left_out_error(self.contest.null)

        def made(item: tuple[Names, SetFit]) -> SetFit | None:
            found = _fitted(*item)
            if found is None or why_not(model, every, found, self.system.speed):
                return None
            return found if left_out_error(found) <= missed else None

        words = [f"set {' and '.join(order)}" for order, _ in asked]
        with opened(self.system.executor) as crew, one_thread():
            for place, fit in each(made, asked, crew, names=words):
                self._known[sets[place]] = fit

    @cached_property
    def steady(self) -> Callable[[frozenset[str]], SetFit | None]:
        """The same with a base that stays as it is given, if records left out say so."""

        def made(names: frozenset[str]) -> SetFit | None:
            fit = self.fit(names)
            return None if fit is None else steady(fit)

        return cache(made)

    def groups(self, names: Names, faults: Names) -> Sequence[Disagreement]:
        """Groups of records with the evidence that they disagree, beside a set and in its place."""
        fit = self.steady(frozenset((*self._asked(names), *faults)))
        return [] if fit is None else disagreements(fit, self.contest.null)

    @property
    def faults(self) -> Names:
        """Faults that the records have without any effect of the ship."""
        return self._alone[1]

    @property
    def ground(self) -> float:
        """ln evidence of these, with their price."""
        return self._alone[0]

    @cached_property
    def _alone(self) -> tuple[float, Names]:
        for faults in fault_sets(self.diagnosis.entries, FAULTS):
            self.system.tell(f"Fit with {' and '.join(faults)}")
            fit = self.fit(frozenset(faults))
            if fit is not None and (gain := self._gain(fit, faults)) > 0.0:
                return gain, faults
        return 0.0, ()

    def _gain(self, fit: SetFit, faults: Names) -> float:
        """ln evidence of a fit, each fault of it at its price."""
        gain = fit.log_probability - self.contest.null.log_probability
        return gain - PRICE * len(faults)

    @cached_property
    def _entries(self) -> Mapping[frozenset[str], float]:
        return {frozenset(item.names): item.log_evidence for item in self.diagnosis.entries}

    def model_of(self, fit: SetFit) -> Model:
        """The model with the values of a fit."""
        return model_of(*self.fits_into, fit, self.system.speed)

    def _asked(self, names: Names) -> Names:
        return tuple(name for name in names if name in self.asked)

    def _beside(self, names: Names) -> list[Names]:
        """Sets of faults that may stand beside effects: none, the best alone, and those of a set
        that these records alone name."""
        named = [
            tuple(name for name in item if name not in names)
            for item, _ in self.diagnosis.group
            if set(of_ship(item)) == set(names)
        ]
        return list(dict.fromkeys([(), self.faults, *named]))


def _fitted(order: Names, near: SetFit) -> SetFit | None:
    """A set from where a part of it ended; None if its motion is lost."""
    question = near.place.question
    try:
        place = place_at(question, near.z, question.numbers.used(order))
        return fitted(place, order, near.forces)
    except (ModelError, SimulationError):
        return None
