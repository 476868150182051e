"""A model fitted to free-running records together with effects that it lacked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from threadpoolctl import threadpool_limits

from pmmkit.diagnosis.free_running.candidates import FreeCandidate
from pmmkit.diagnosis.free_running.findings import model_of
from pmmkit.diagnosis.free_running.fits import Fit
from pmmkit.diagnosis.free_running.hypotheses import WIDER
from pmmkit.diagnosis.free_running.system import FreeSystem
from pmmkit.errors import DataError, Problem, Remedy, Way
from pmmkit.identification.record import title_of
from pmmkit.models import Model
from pmmkit.models.changes import before_of
from pmmkit.models.step import Step, odds


def refitted(system: FreeSystem, begun: Sequence[str], steps: Sequence[Step]) -> Model:
    """The model with its uncertain values and effects fitted together, a step for each.

    Parameters
    ----------
    system : FreeSystem
        Records and model.
    begun : sequence of str
        Faults of the records that are known.
    steps : sequence of Step
        What is added, one after another, with its odds and a remark. Faults correct the records
        and enter no model.

    Raises
    ------
    DataError
        If no step towards an effect helps: it would be added with nothing in it.
    """
    with threadpool_limits(1):
        return _refitted(system, begun, steps)


def _refitted(system: FreeSystem, begun: Sequence[str], steps: Sequence[Step]) -> Model:
    every = {item.name: item for item in system.every}
    names = tuple(begun)
    fit = system.fit(names)
    count = len(system.base.names) if fit.spread or np.any(system.base.known) else 0
    first = Step(action="fitted", count=count, campaign="records")
    made = model_of(system.model, system.every, fit, system.speed)
    made = made.with_(steps=(*system.model.steps, *([first] if count else [])))
    last = (*names, *(step.effect for step in steps))
    for step in steps:
        before = system.errors(names, last)["heading"]
        names = (*names, step.effect)
        fit = system.fit(names)
        if not np.any(fit.z[fit.place.question.numbers.columns[step.effect]]):
            raise DataError(_not_found(step.effect))
        after = model_of(system.model, system.every, fit, system.speed)
        fall = f"{before:.2f} to {system.errors(names, last)['heading']:.2f}"
        said = f"error of heading of records left out {fall}°"
        why = step.note or ("" if step.log_odds is None else f"evidence {odds(step.log_odds)}")
        taken = replace(
            step_of(made, after, every[step.effect], fit),
            log_odds=step.log_odds,
            note="; ".join(text for text in (why, said) if text),
        )
        made = after.with_(steps=(*made.steps, taken))
    title = title_of(system.records)
    return made.with_(steps=tuple(_as_fitted(step, every, fit, title) for step in made.steps))


def _as_fitted(step: Step, every: Mapping[str, FreeCandidate], fit: Fit, title: str) -> Step:
    """A step with what the last fit says of its fault: it belongs to that fit's model."""
    if step.action != "fault_corrected" or step.effect not in fit.names:
        return step
    if step.campaign not in ("", title):
        return step
    return replace(step, campaign=title, coefficients=_coefficients(every[step.effect], fit))


def _coefficients(item: FreeCandidate, fit: Fit) -> dict[str, float]:
    """Coefficients of an effect by a fit."""
    columns = fit.place.question.numbers.columns[item.name].tolist()
    return {
        label: WIDER * typical * float(fit.z[column])
        for (label, typical), column in zip(item.typical.items(), columns, strict=True)
    }


def step_of(old: Model, new: Model, item: FreeCandidate, fit: Fit) -> Step:
    """The step by which a fit to records took an effect in.

    Parameters
    ----------
    old, new : Model
        Before and after.
    item : FreeCandidate
        The effect.
    fit : Fit
        To the records.
    """
    found = _coefficients(item, fit)
    if item.kind == "fault":
        return Step(action="fault_corrected", effect=item.name, coefficients=found)
    part = () if item.part is None else (item.part.effect,)
    home = {name: f"{effect}.{name}" for effect, own in new.parts.items() for name in own.values}
    places = [*part, *(home.get(name, name) for name in item.values)]
    return Step(
        action="effect_added",
        effect=item.name,
        coefficients=found,
        system="prime",
        source="diagnosis",
        before=before_of(old, new, places),
    )


def _not_found(name: str) -> Problem:
    return Problem(
        message=f"These records give {name} no size: from the model as it is no step towards it "
        "makes them more probable.",
        remedy=Remedy(
            "{} says what is wrong with the records: cut them to what is sound (trim), state what "
            "their sensors are uncertain by, or begin with a model that sails them.",
            (Way("pmmkit.checks.examine(campaign)", "pmmkit check"),),
        ),
    )
