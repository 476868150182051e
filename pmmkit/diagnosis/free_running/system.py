"""Records, a model and its candidates, with what is made of them once."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property

from pmmkit.base import Workers
from pmmkit.campaigns import Campaign
from pmmkit.diagnosis.captive.candidate import no_such_effect
from pmmkit.diagnosis.free_running.base import SPREAD, FreeBase, base_of, stated_base
from pmmkit.diagnosis.free_running.candidates import (
    FreeCandidate,
    candidates_for,
    check_seas,
    free_candidate_of,
)
from pmmkit.diagnosis.free_running.contest import base_alone, steady
from pmmkit.diagnosis.free_running.fits import Linearised, SetFit, first_place, fitted, place_at
from pmmkit.diagnosis.free_running.hypotheses import Names
from pmmkit.diagnosis.free_running.left_out import each, pooled, predicted
from pmmkit.diagnosis.free_running.question import RecordQuestion, question_of, records_of
from pmmkit.diagnosis.free_running.unknown import FLOOR
from pmmkit.effects import Effect
from pmmkit.identification import FreeRecord, Prior
from pmmkit.models import Model, Sailing


@dataclass(frozen=True, kw_only=True, eq=False)
class FreeSystem:
    """What free-running records are asked about a model.

    `model`: complete, without the candidates. `base`: what is known of the values of the model.
    `tell`: is told what is being done. `executor`: who fits the sets.
    """

    model: Model
    records: tuple[FreeRecord, ...]
    every: tuple[FreeCandidate, ...]
    base: FreeBase
    floor: float
    window: float | None
    sensors: Mapping[str, float] | None
    extrapolate: bool
    tell: Callable[[str], None]
    executor: Workers = None

    @property
    def speed(self) -> float:
        """Speed of the approach [m/s]."""
        return self.records[0].speed

    @cached_property
    def question(self) -> RecordQuestion:
        """The question, with starts and noise of the records."""
        return question_of(
            self.model,
            self.records,
            self.every,
            self.base,
            floor=self.floor,
            window=self.window,
            sensors=self.sensors,
            extrapolate=self.extrapolate,
            tell=self.tell,
        )

    @cached_property
    def place(self) -> Linearised:
        """The linear problem about the model as it is given, with the slopes of all."""
        question = self.question
        self.tell(f"Slopes of {len(question.numbers.values)} values")
        return first_place(question)

    @cached_property
    def alone(self) -> tuple[Linearised, SetFit]:
        """The base without any effect, as far as it may move, and the linear problem of that."""
        place = self.place
        self.tell("The base alone")
        return base_alone(place)

    @cached_property
    def fit(self) -> Callable[[Names], SetFit]:
        """The base fitted together with a set of candidates, each set once."""
        return cache(lambda names: steady(self._moving(names)))

    @cached_property
    def _moving(self) -> Callable[[Names], SetFit]:
        """The same with a base that moves, each set from where the one before its last ended.

        From the model as it is given the way to several effects is long, and may end elsewhere.
        """

        def made(names: Names) -> SetFit:
            if not names:
                return self.alone[1]
            before = self._moving(names[:-1])
            self.tell(f"Fit with {' and '.join(names)}")
            return fitted(place_at(before.place.question, before.z), names, before.forces)

        return cache(made)

    @cached_property
    def errors(self) -> Callable[[Names, Names], dict[str, float]]:
        """Errors of records left out one after another, by a fit with a set of candidates.

        The noise of the sensors that is taken off is that of a fit with another set.
        """

        def made(names: Names, last: Names) -> dict[str, float]:
            fit = self.fit(names).read_by(self.fit(last).sensors)
            return pooled(predicted(fit, each(self.records)))

        return cache(made)


def free_system(
    model: Model,
    records: Sequence[FreeRecord] | Campaign,
    *,
    prior: Prior | None = None,
    spread: float = SPREAD,
    floor: float = FLOOR,
    window: float | None = None,
    candidates: Sequence[FreeCandidate | Effect | str] | None = None,
    own: Sequence[Effect] = (),
    windage: tuple[float, float] | None = None,
    sensors: Mapping[str, float] | None = None,
    extrapolate: bool = False,
    progress: Callable[[str], None] | None = None,
    also: Sequence[str] = (),
    executor: Workers = None,
) -> FreeSystem:
    """What records are asked about a model; nothing of it is worked out before it is needed."""
    given = tuple(records_of(records, model))
    check_seas(model, given)
    speed = given[0].speed
    offered = {x.name: x for x in candidates_for(model, given, windage=windage, own=own)}
    every: dict[str, FreeCandidate] = offered if candidates is None else {}
    for item in candidates or ():
        if isinstance(item, str) and item not in offered:
            raise no_such_effect(item, list(offered))
        if isinstance(item, str):
            chosen = offered[item]
        else:
            chosen = (
                item
                if isinstance(item, FreeCandidate)
                else free_candidate_of(item, Sailing(model, speed))
            )
        every[chosen.name] = chosen
    beside = {name: offered[name] for name in also if name in offered}
    return FreeSystem(
        model=model,
        records=given,
        every=tuple((every | {n: x for n, x in beside.items() if n not in every}).values()),
        base=(
            base_of(model, speed, spread=spread, extrapolate=extrapolate)
            if prior is None
            else stated_base(prior)
        ),
        floor=floor,
        window=window,
        sensors=sensors,
        extrapolate=extrapolate,
        tell=progress or (lambda _: None),
        executor=executor,
    )
