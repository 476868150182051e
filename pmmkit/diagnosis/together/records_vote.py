"""Free-running records as one voice among several campaigns."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from pmmkit.diagnosis.findings import Diagnosis
from pmmkit.diagnosis.free_running.base import SPREAD, base_of
from pmmkit.diagnosis.free_running.candidates import FreeCandidate, candidate_of, candidates_for
from pmmkit.diagnosis.free_running.contest import MOST, price_of, steady, within
from pmmkit.diagnosis.free_running.diagnose import diagnose_free
from pmmkit.diagnosis.free_running.findings import model_of
from pmmkit.diagnosis.free_running.fits import Fit, Place, first_place, fitted
from pmmkit.diagnosis.free_running.hypotheses import WIDER
from pmmkit.diagnosis.free_running.left_out import left_out_error
from pmmkit.diagnosis.free_running.question import question_of
from pmmkit.diagnosis.free_running.unknown import FLOOR
from pmmkit.diagnosis.together.belongs import Measured
from pmmkit.diagnosis.together.vote import Ballot, Kind, Names, Sized, asked_in, fault_sets, of_ship
from pmmkit.effects.effect import Effect
from pmmkit.errors import ModelError, SimulationError
from pmmkit.identification.record import FreeRecord
from pmmkit.models import Model
from pmmkit.models.vessel import Sailing

FAULTS: Final = 2
"""Sets of faults that are fitted through the equations, the best promise first."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RecordsVote:
    """Free-running records that have been diagnosed.

    Parameters
    ----------
    name : str
        Of the campaign.
    model : Model
        Complete, of the ship as tested.
    diagnosis : Diagnosis
        Of these records alone.
    every : tuple of FreeCandidate
        Who takes part.
    speed : float
        Speed of the approach [m/s].
    zero : Place
        The linear problem about the model as it is given.
    null : Fit
        Without any effect.
    missed : float
        Sum of ln of the errors of records left out, without any effect.
    faults : tuple of str
        Faults that the records have without any effect of the ship.
    ground : float
        ln evidence of these, with their price.
    """

    name: str
    model: Model
    diagnosis: Diagnosis
    every: tuple[FreeCandidate, ...]
    speed: float
    zero: Place
    null: Fit
    missed: float
    faults: Names = ()
    ground: float = 0.0

    @property
    def kind(self) -> Kind:
        """How the ship was tested."""
        return "free-running"

    @property
    def asked(self) -> frozenset[str]:
        """Effects of the ship that these records were asked for."""
        return asked_in(self.diagnosis.entries)

    @property
    def price(self) -> float:
        """Of each fault."""
        return price_of(self.zero.question)

    def promised(self, names: Names) -> Ballot:
        """A set by the linear problem; of one that was not looked at its best part."""
        mine = self._asked(names)
        if not mine:
            return Ballot(log_evidence=0.0)
        found = {frozenset(item.names): item.log_evidence for item in self.diagnosis.entries}
        whole = [
            found[key]
            for faults in self._beside(mine)
            if (key := frozenset((*mine, *faults))) in found
        ]
        if whole:
            return Ballot(log_evidence=max(whole) + self.price * len(mine) - self.ground)
        parts = [tuple(x for x in mine if x != name) for name in mine]
        return max((self.promised(part) for part in parts), key=lambda item: item.log_evidence)

    def weighed(self, names: Names) -> Ballot | None:
        """A set fitted through the equations; None if records left out get worse by it."""
        mine = self._asked(names)
        if not mine:
            return Ballot(log_evidence=0.0)
        found = []
        for faults in self._beside(mine):
            fit = self.fit((*mine, *faults))
            if fit is not None:
                gain = fit.log_probability - self.null.log_probability
                found.append((gain - self.price * len(faults) - self.ground, faults))
        if not found:
            return None
        value, beside = max(found)
        return Ballot(log_evidence=value, faults=beside)

    def sizes(self, names: Names, faults: Names) -> Mapping[str, Sized]:
        """The effects of a set that come to values which the model does not have."""
        mine = self._asked(names)
        fit = self.fit((*mine, *faults)) if mine else None
        if fit is None:
            return {}
        numbers = fit.place.question.numbers
        found = {}
        for item in self.every:
            if item.name not in mine or self._has(item):
                continue
            at = numbers.columns[item.name]
            size = WIDER * np.array(list(item.typical.values()))
            found[item.name] = Sized(
                coefficients=tuple(item.typical),
                typical=tuple(item.typical.values()),
                measured=Measured(
                    laboratory=self.name,
                    values=size * fit.z[at],
                    covariance=fit.covariance[np.ix_(at, at)] * np.outer(size, size),
                ),
            )
        return found

    def model_with(self, names: Names, faults: Names) -> Model | None:
        """The model with a set, all values fitted to these records."""
        fit = self.fit((*self._asked(names), *faults))
        return None if fit is None else model_of(self.model, self.every, steady(fit), self.speed)

    def fit(self, names: Names) -> Fit | None:
        """A set through the equations; None if it leads to no ship, or predicts worse."""
        if not names:
            return self.null
        order = tuple(item.name for item in self.every if item.name in names)
        try:
            found = fitted(self.zero, order)
            model_of(self.model, self.every, found, self.speed)
        except (ModelError, SimulationError):
            return None
        return found if left_out_error(found) <= self.missed else None

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

    def _has(self, item: FreeCandidate) -> bool:
        """Whether an effect comes to values that the model has."""
        values = [own for part in self.model.parts.values() for own in part.values.items()]
        there = {name for name, value in values if np.any(np.asarray(value) != 0.0)}
        return bool(there.intersection(name.rpartition(".")[2] for name in item.values))


def records_vote(
    name: str,
    model: Model,
    records: Sequence[FreeRecord],
    *,
    candidates: Sequence[Effect] | None = None,
    most: int = MOST,
    floor: float = FLOOR,
    spread: float = SPREAD,
    window: float | None = None,
    sensors: Mapping[str, float] | None = None,
    windage: tuple[float, float] | None = None,
    extrapolate: bool = False,
    seed: int = 0,
    progress: Callable[[str], None] | None = None,
) -> RecordsVote:
    """Diagnose free-running records and keep what more sets need.

    Parameters
    ----------
    name : str
        Of the campaign.
    model : Model
        Complete, of the ship as tested.
    records : sequence of FreeRecord
        At least two.
    candidates, most, floor, spread, window, sensors, windage, extrapolate, seed, progress
        As for `diagnose_free`.

    Raises
    ------
    DataError
        If there are fewer than two records.
    """
    tell = progress or (lambda _: None)
    speed = records[0].speed
    vessel = Sailing(model, speed)
    every = (
        candidates_for(model, records, windage=windage)
        if candidates is None
        else tuple(candidate_of(item, vessel) for item in candidates)
    )
    shared: dict[str, Any] = {
        "floor": floor,
        "window": window,
        "sensors": sensors,
        "extrapolate": extrapolate,
    }
    diagnosis = diagnose_free(
        model,
        records,
        candidates=every,
        most=most,
        spread=spread,
        seed=seed,
        progress=progress,
        **shared,
    )
    base = base_of(model, speed, spread=spread, extrapolate=extrapolate)
    zero = first_place(question_of(model, records, every, base, tell=tell, **shared))
    null = steady(fitted(zero, (), whole=True))
    if not null.spread:
        # A base whose move makes records left out worse is not moved beside an effect either.
        zero = within(zero, 1)
    vote = RecordsVote(
        name=name,
        model=model,
        diagnosis=diagnosis,
        every=every,
        speed=speed,
        zero=zero,
        null=null,
        missed=left_out_error(null),
    )
    for faults in fault_sets(diagnosis.entries, FAULTS):
        tell(f"Fit with {' and '.join(faults)}")
        fit = vote.fit(faults)
        gain = 0.0 if fit is None else fit.log_probability - null.log_probability
        if gain > vote.price * len(faults):
            return replace(vote, faults=faults, ground=gain - vote.price * len(faults))
    return vote
