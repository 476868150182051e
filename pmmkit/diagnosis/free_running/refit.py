"""A model fitted to free-running records together with effects that it lacked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from threadpoolctl import threadpool_limits

from pmmkit.base import DataError, Problem, Remedy, Way
from pmmkit.diagnosis.free_running.candidates import FreeCandidate
from pmmkit.diagnosis.free_running.findings import model_of
from pmmkit.diagnosis.free_running.fits import SetFit
from pmmkit.diagnosis.free_running.hypotheses import WIDER
from pmmkit.diagnosis.free_running.system import FreeSystem
from pmmkit.diagnosis.refit import stepped
from pmmkit.identification import FreeRecord
from pmmkit.models import Model, Step

HEADING: Final = "heading"
"""The error of records that a step tells [deg]."""


def refitted(system: FreeSystem, begun: Sequence[str], steps: Sequence[Step]) -> Model:
    """The model with its uncertain values and effects fitted together, a step for each."""
    with threadpool_limits(1):
        return _refitted(system, begun, steps)


def _refitted(system: FreeSystem, begun: Sequence[str], steps: Sequence[Step]) -> Model:
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
