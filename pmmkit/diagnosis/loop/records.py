"""Free-running records as the evidence of a session."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from pmmkit.base import DataError, ModelError, Problem, Remedy, Way
from pmmkit.campaigns import Campaign
from pmmkit.conventions import Structure
from pmmkit.diagnosis.any_campaign import complete_model
from pmmkit.diagnosis.captive.candidate import Candidate
from pmmkit.diagnosis.evidence import RankedSet, Visible
from pmmkit.diagnosis.findings import UNITS, Diagnosis
from pmmkit.diagnosis.free_running.base import FLOOR, known_faults
from pmmkit.diagnosis.free_running.contest import MOST, Contest
from pmmkit.diagnosis.free_running.diagnose import (
    FreeSystem,
    answer,
    contest_about,
    free_system,
    sailing,
)
from pmmkit.diagnosis.free_running.findings import model_of
from pmmkit.diagnosis.free_running.fits import SetFit
from pmmkit.diagnosis.free_running.hypotheses import (
    WIDER,
    FreeCandidate,
    Names,
    probable,
    why_not_asked,
)
from pmmkit.diagnosis.free_running.left_out import (
    ERRORS,
    band,
    each,
    left_out_windows,
    noise_level,
    pooled,
    predicted,
    unimportant,
)
from pmmkit.diagnosis.free_running.question import records_of
from pmmkit.diagnosis.free_running.windows import joined, sailed, shown
from pmmkit.diagnosis.loop.captive import only_campaign
from pmmkit.diagnosis.loop.fall import ALL, BASE, ErrorWords, Fall, FallRow
from pmmkit.diagnosis.record_figures import Sailed, before_and_after
from pmmkit.diagnosis.refit import stepped
from pmmkit.effects import Effect
from pmmkit.equations import State
from pmmkit.identification import FreeRecord
from pmmkit.models import Model, Step
from pmmkit.numerics import Array, one_thread
from pmmkit.presentation import counted

if TYPE_CHECKING:
    from pmmkit.plotting import Figure


# A model fitted to free-running records together with effects that it lacked.


HEADING: Final = "heading"
"""The error of records that a step tells [deg]."""


@one_thread()
def refitted(system: FreeSystem, begun: Sequence[str], steps: Sequence[Step]) -> Model:
    """The model with its uncertain values and effects fitted together, a step for each."""
    every = {item.name: item for item in system.every}
    names = (*begun, *(step.effect for step in steps))
    sets = [names[: len(begun) + number] for number in range(len(steps) + 1)]
    for step, own in zip(steps, sets[1:], strict=True):
        taken = system.fit(own)
        if not np.any(taken.z[taken.place.question.numbers.columns[step.effect]]):
            raise DataError(_not_found(step.effect))
    fit = system.fit(names)
    made = model_of(system.model, system.every, fit, system.speed)
    title = FreeRecord.title_of(system.records)
    kept = [
        step if step.campaign not in ("", title) else _as_fitted(step, every, fit, title)
        for step in made.steps
    ]
    plain = Step(
        action="fitted",
        campaign=title,
        count=int(np.count_nonzero(np.diagonal(fit.covariance) > 0.0)),
        faults=tuple(name for name in names if every[name].kind == "fault"),
    )
    errors = [system.errors(own, names)[HEADING] for own in sets]
    return stepped(
        system.model,
        made.with_(steps=tuple(kept)),
        plain,
        [replace(step, parameter="", value=None) for step in steps],
        [
            (_coefficients(item, fit), _places(item, made))
            for item in (every[step.effect] for step in steps)
        ],
        errors,
        HEADING,
    )


def _as_fitted(step: Step, every: Mapping[str, FreeCandidate], fit: SetFit, title: str) -> Step:
    """A step with what the last fit says of its fault: it belongs to that fit's model."""
    if step.action != "fault_corrected" or step.effect not in fit.names:
        return step
    return replace(step, campaign=title, coefficients=_coefficients(every[step.effect], fit))


def _coefficients(item: FreeCandidate, fit: SetFit) -> dict[str, float]:
    """Coefficients of an effect by a fit."""
    columns = fit.place.question.numbers.columns[item.name].tolist()
    return {
        label: WIDER * typical * float(fit.z[column])
        for (label, typical), column in zip(item.typical.items(), columns, strict=True)
    }


def _places(item: FreeCandidate, made: Model) -> tuple[str, ...]:
    """Where an effect stands in a ship that has it; a fault nowhere."""
    if item.kind == "fault":
        return ()
    part = () if item.part is None else (item.part.effect,)
    home = {name: f"{effect}.{name}" for effect, own in made.parts.items() for name in own.values}
    return (*part, *(home.get(name, name) for name in item.values))


def _not_found(name: str) -> Problem:
    return Problem(
        message=f"These records give {name} no size: from the model as it is no step towards it "
        "makes them more probable.",
        remedy=Remedy(
            "{} says what is wrong with the records: cut them to what is sound (trim), state what "
            "their sensors are uncertain by, or begin with a model that sails them.",
            (Way("pmmkit.intake.checks.examine(campaign)", "pmmkit check"),),
        ),
    )


# What each candidate alone would do to the records, from what a contest has fitted already.


MOTION: Final = ("x", "y", "psi", "u", "v", "r")
"""What is told of a path: places [m], heading [rad], velocities [m/s], yaw rate [rad/s]."""
SAMPLES: Final = (40, 200)
"""Least and most samples of a path."""
WORSE: Final = -10.0
"""A share below which the motion of some record is lost: it is none."""
Paths = dict[str, dict[str, Array]]
"""By record its time ``t`` [s] and `MOTION`, places in ship lengths."""


def alone_in_records(
    contest: Contest, names: Sequence[str], heard: Callable[[int, str], None], numbers: int
) -> tuple[dict[str, dict[str, float]], dict[str, Paths], Paths]:
    """By candidate its share of the misfit and its paths, and the paths of the base alone.

    `noise`: the share that goes where noise alone is left, as the candidate that takes most away
    says: before it, what is missing stands among the unknown forces.
    """
    null = alone(contest)
    records = [item.record for item in null.followed.stretches]
    wanted = numbers // (len(records) * (len(names) + 1) * len(MOTION))
    count = min(max(wanted, SAMPLES[0]), SAMPLES[1])
    length = null.place.question.model.ship.L

    def paths(fit: SetFit) -> Paths:
        return {
            record.name: _thinned(whole_path(fit, number), count, length)
            for number, record in enumerate(records)
        }

    before = errors_of(null)
    shares, beside, most = {}, {}, (0.0, null)
    for number, name in enumerate(names):
        heard(number, name)
        fit = alone(contest, name)
        after = errors_of(fit)
        whole = taken_away(fit, before, after)
        if whole < WORSE:
            continue
        shares[name] = {"all": whole} | {
            kind: 1.0 - (after[kind] / x) ** 2 if x > 0.0 else 0.0 for kind, x in before.items()
        }
        beside[name] = paths(fit)
        most = max(most, (whole, fit), key=lambda pair: pair[0])
    if shares:
        noise = taken_away(null, before, before | noise_level(most[1]))
        shares = {name: own | {"noise": noise} for name, own in shares.items()}
    return shares, beside, paths(null)


def _thinned(path: Mapping[str, Array], count: int, length: float) -> dict[str, Array]:
    """A path at so many instants, evenly over its samples, its places in ship lengths."""
    kept = np.unique(np.linspace(0, len(path["t"]) - 1, count).round().astype(int))
    return {
        name: 1.0 / length * values[kept] if name in ("x", "y") else values[kept]
        for name, values in path.items()
    }


def alone(contest: Contest, name: str | None = None) -> SetFit:
    """The base with one candidate or without any, nothing fitted anew."""
    null = contest.null
    if name is None:
        return null
    for item in contest.settled:
        if item.names == (name,):
            return item.fit
    numbers = null.place.question.numbers
    z, covariance = probable(null.known, numbers, (name,), null.spread)
    return replace(null, names=(name,), z=z, covariance=covariance)


def errors_of(fit: SetFit) -> dict[str, float]:
    """Errors of records that are left out one after another, as a diagnosis tells them."""
    return pooled(predicted(fit, each([item.record for item in fit.followed.stretches])))


def taken_away(fit: SetFit, before: Mapping[str, float], after: Mapping[str, float]) -> float:
    """Share of the mean square errors that an effect takes away, over all kinds of errors."""
    small = unimportant(fit.place.question)
    left = [(after[k] ** 2 + small[k] ** 2) / (x**2 + small[k] ** 2) for k, x in before.items()]
    return 1.0 - sum(left) / len(left)


def whole_path(fit: SetFit, record: int) -> dict[str, Array]:
    """A record sailed from its begin to its end with the measured rudder.

    Notes
    -----
    It begins where the most probable path does: sensors alone tell the sway of a start too badly
    for a record that is sailed in one. The numbers are those of the linear problem where the fit
    ended, as for the errors of records left out.
    """
    question = fit.place.question
    z = probable(fit.known, question.numbers, fit.names, fit.spread)[0]
    stretch = question.stretches[record]
    whole = joined(stretch, len(stretch.begins)).free
    change = question.numbers.T @ z
    states = sailed(whole, change)
    seen = shown(whole, states, change)
    found = {name: states[:, State[name]] for name in MOTION}
    found |= {name: seen[:, place] for place, name in enumerate(whole.channels) if name in MOTION}
    return {"t": whole.record.t, **found}


DRAWN: Final = 3
"""Records of which tracks are drawn."""
BASE_FITTED: Final = "base fitted to the other records"
WITH_EFFECTS: Final = "with the effects"
TOLD: Final = ErrorWords(
    of="heading",
    judged=tuple(ERRORS),
    left_out="records",
    total="heading {}",
    how="Each record was left out of the fit in turn and sailed by what all others say, over "
    "windows with its measured rudder: root mean square error, the noise of the sensors taken off, "
    "beside what a model would leave that lacks nothing.",
)


@dataclass(frozen=True, kw_only=True, eq=False)
class FreeRecords:
    """Free-running records, a model, and what may be missing of it.

    `given`: records, model and candidates. `begun`: faults of the records that the model's
    steps tell of. `own`: effects of the user.
    """

    title: str
    given: FreeSystem
    begun: tuple[str, ...] = ()
    held_out: tuple[FreeRecord, ...] = ()
    held_out_window: float | None = None
    most: int = MOST
    own: tuple[Effect, ...] = ()

    @cached_property
    def system(self) -> FreeSystem:
        """The same without records in which the model turns another way."""
        return sailing(self.given)

    @property
    def base(self) -> str:
        """The base in words."""
        return self.given.model.name

    @property
    def about(self) -> str:
        """The tests in words."""
        records = counted(len(self.given.records), "record")
        return f"{records} of {self.title}" if self.title else records

    @property
    def floor(self) -> float:
        """What is too small to matter, over the rms force of a channel."""
        return self.given.floor

    @property
    def kinds(self) -> Mapping[str, str]:
        """Who takes part: ``physics`` or ``fault`` by name."""
        return {item.name: item.kind for item in self.given.every}

    def why_not_asked(self, effect: Effect, _covered: Sequence[Visible]) -> str:
        """Why an effect takes no part, in words; empty where it does."""
        return why_not_asked(effect, self.given.model, self.given.records)

    def fitted(self, steps: Sequence[Step]) -> frozenset[str]:
        """Effects that a contest beside some steps has fitted through the equations: they stand
        before those of which the linear problem promises more, which the equations may not keep."""
        settled = self.contest(self.sets(steps)[-1]).settled
        return frozenset(name for item in settled for name in item.names)

    def alone(
        self,
        steps: Sequence[Step],
        chosen: Sequence[RankedSet],
        heard: Callable[[int, str], None],
        *,
        numbers: int,
    ) -> tuple[dict[str, dict[str, float]], dict[str, Paths], Paths]:
        """What each candidate would do, alone beside the base with some steps: the share of the
        error that it takes away and its paths; the paths of the base alone. Nothing where no
        numbers of paths are asked for, which tell of the error."""
        if not numbers:
            return {}, {}, {}
        names = [entry.names[0] for entry in chosen]
        return alone_in_records(self.contest(self.sets(steps)[-1]), names, heard, numbers)

    def named(self, effect: str, campaign: str) -> str:
        """Nothing: there is one campaign alone."""
        return only_campaign(self.title, effect, campaign)

    def diagnose(self, steps: Sequence[Step], seed: int) -> Diagnosis:
        """What the base still lacks with some steps."""
        given = self.sets(steps)[-1]
        return answer(
            self.system,
            given,
            held_out=self.held_out,
            held_out_window=self.held_out_window,
            most=self.most,
            seed=seed,
            contest=self.contest(given),
        )

    @cached_property
    def contest(self) -> Callable[[Names], Contest]:
        """Sets of effects against a base that has some already, each base once."""
        return cache(lambda given: contest_about(self.system, given, most=self.most))

    def sets(self, steps: Sequence[Step]) -> tuple[tuple[str, ...], ...]:
        """The effects of the base, and after each step."""
        names = (*self.begun, *(step.effect for step in steps))
        first = len(self.begun)
        return tuple(names[: first + number] for number in range(len(steps) + 1))

    def fall(self, steps: Sequence[Step]) -> Fall:
        """Errors of records left out one after another, of the base and after each step.

        The level of each is that of the last step: before it, what is missing stands among the
        unknown forces.
        """
        names, sets = (BASE, *(step.effect for step in steps)), self.sets(steps)
        levels = noise_level(self.system.fit(sets[-1]))
        rows = [
            FallRow(
                step=step,
                campaign=self.title,
                group=ALL,
                quantity=quantity,
                error=error,
                level=levels.get(quantity, math.nan),
                unit=UNITS[quantity],
            )
            for step, names in zip(names, sets, strict=True)
            for quantity, error in self.system.errors(names, sets[-1]).items()
        ]
        mine = tuple(replace(step, campaign="") for step in steps)
        return Fall(added=mine, rows=tuple(rows), told={self.title: TOLD})

    def held_out_errors(self, steps: Sequence[Step]) -> dict[str, dict[str, float]]:
        """Errors of records that are held out: model as given, base refitted, with the effects."""
        if not self.held_out:
            return {}
        system = self.system
        before, after = (system.fit(names) for names in (self.sets(steps)[0], self.sets(steps)[-1]))
        made, better = (
            model_of(system.model, system.every, fit, system.speed) for fit in (before, after)
        )
        return system.held_out_errors(
            self.held_out,
            self.held_out_window,
            {"base refitted": made},
            (better, after) if steps else None,
        )

    def sailed(self, steps: Sequence[Step], most: int = DRAWN) -> list[Sailed]:
        """The records that the base misses most, each left out, measured and sailed."""
        sets = self.sets(steps)
        fits = {BASE_FITTED: self.system.fit(sets[0])}
        if steps:
            fits[WITH_EFFECTS] = self.system.fit(sets[-1])
        missed = [
            item["heading"] for item in predicted(fits[BASE_FITTED], each(self.system.records))
        ]
        worst = sorted(range(len(missed)), key=lambda j: -missed[j])[:most]
        return [_sailed(fits, j) for j in sorted(worst)]

    @staticmethod
    def plot(records: Sequence[Sailed]) -> Figure:
        """Records that were sailed: tracks, headings and yaw rates, and how far they are off."""
        return before_and_after(records)

    def model(self, steps: Sequence[Step]) -> Model:
        """The model with base and effects fitted together, and with a step per effect."""
        return refitted(self.system, self.begun, steps)

    @one_thread()
    def rival(self, steps: Sequence[Step], names: Sequence[str]) -> Model:
        """The ship that a set named by `diagnose` says, with its uncertainty and without steps."""
        given = self.sets(steps)[-1]
        settled = self.contest(given).settled
        fit = next((item.fit for item in settled if item.names == tuple(names)), None)
        if fit is None:
            raise ModelError(f"{' + '.join(names)} was not named.")
        system, model = self.system, self.system.model
        for item in system.every:
            if item.name in given:
                model = item.added_to(model)
        return model_of(model, system.every, fit, system.speed)


def _sailed(fits: Mapping[str, SetFit], record: int) -> Sailed:
    """A record left out, as fits to the others sail it."""
    found = {name: left_out_windows(fit, record) for name, fit in fits.items()}
    stretch = next(iter(found.values()))[0]
    return Sailed(
        name=stretch.record.name,
        t=stretch.record.t,
        begins=stretch.begins[:-1],
        measured=stretch.record.measured,
        simulated={
            name: dict(zip(stretch.channels, shown.T, strict=True))
            for name, (_, shown) in found.items()
        },
        std={
            name: dict(zip(stretch.channels, band(fit, record).T, strict=True))
            for name, fit in fits.items()
        },
    )


def free_running(
    model: Model | str | Path | Sequence[str] | Structure,
    records: Campaign | Sequence[FreeRecord],
    *,
    floor: float | None,
    candidates: Sequence[Candidate | FreeCandidate | Effect | str] | None,
    own: Sequence[Effect],
    held_out: Sequence[FreeRecord] = (),
    held_out_window: float | None = None,
    most: int = MOST,
    **settings: Any,
) -> FreeRecords:
    """The evidence of free-running records; arguments as for `diagnose_free`."""
    complete = complete_model(model)
    asked: list[FreeCandidate | Effect | str] | None = None if candidates is None else []
    for item in candidates or ():
        if isinstance(item, Candidate):
            raise DataError(f"{item.name} is a candidate of captive tests: these records run free.")
        if asked is not None:
            asked.append(item)
    given = records_of(records, complete)
    faults = known_faults(complete, given)
    system = free_system(
        complete,
        given,
        floor=FLOOR if floor is None else floor,
        candidates=asked,
        own=own,
        also=faults,
        **settings,
    )
    there = {item.name for item in system.every}
    return FreeRecords(
        title=records.title if isinstance(records, Campaign) else "",
        given=system,
        begun=tuple(name for name in faults if name in there),
        held_out=tuple(held_out),
        held_out_window=held_out_window,
        most=most,
        own=tuple(own),
    )
