"""A model fitted to free-running records together with effects that it lacked."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.campaigns.run import Campaign
from pmmkit.diagnosis.captive.candidate import no_such_effect
from pmmkit.diagnosis.free_running.base import SPREAD, base_of, stated_base
from pmmkit.diagnosis.free_running.candidates import FreeCandidate, candidates_for
from pmmkit.diagnosis.free_running.findings import model_of
from pmmkit.diagnosis.free_running.fits import Fit, first_place, fitted
from pmmkit.diagnosis.free_running.hypotheses import WIDER
from pmmkit.diagnosis.free_running.left_out import each, pooled, predicted
from pmmkit.diagnosis.free_running.question import question_of, records_of
from pmmkit.diagnosis.free_running.unknown import FLOOR
from pmmkit.effects.effect import Effect
from pmmkit.identification.prior import Prior
from pmmkit.identification.record import FreeRecord
from pmmkit.models import Model
from pmmkit.models.changes import before_of
from pmmkit.models.step import Step
from pmmkit.presentation import aligned

if TYPE_CHECKING:
    import pandas as pd

FALLS: Final = 0.995
"""A step whose error is above this share of the one before does not lower it."""
COLUMNS: Final = ("position", "heading", "speed", "yaw_rate")


@dataclass(frozen=True, kw_only=True)
class RecordError:
    """How well records left out are predicted after a step.

    Parameters
    ----------
    step : str
        ``base``, or the effect that was added.
    position, heading, speed, yaw_rate : float
        Root mean square errors over windows with the measured rudder [m, deg, m/s, deg/s]; NaN of
        what was not measured.
    """

    step: str
    position: float = math.nan
    heading: float = math.nan
    speed: float = math.nan
    yaw_rate: float = math.nan


@dataclass(frozen=True, kw_only=True, eq=False)
class FreeRefit:
    """A model after a fit to records, and how the error fell.

    Parameters
    ----------
    model : Model
        With the values of the fit, and a step per effect.
    errors : tuple of RecordError
        Of the base refitted, and after each effect.
    """

    model: Model
    errors: tuple[RecordError, ...]

    def __repr__(self) -> str:
        return f"<FreeRefit of {self.model.name}: {', '.join(x.step for x in self.errors)}>"

    def __str__(self) -> str:
        from pmmkit.diagnosis.findings import UNITS

        head = [f"{name.replace('_', ' ')} [{UNITS[name]}]" for name in COLUMNS]
        rows = [
            [item.step, *(f"{getattr(item, name):.3g}" for name in COLUMNS)] for item in self.errors
        ]
        return aligned(["records left out", *head], rows)

    @property
    def useless(self) -> tuple[str, ...]:
        """Steps after which nothing is predicted better."""
        return tuple(
            after.step
            for before, after in pairwise(self.errors)
            if not any(getattr(after, name) <= FALLS * getattr(before, name) for name in COLUMNS)
        )

    def to_pandas(self) -> pd.DataFrame:
        """A row per step: its errors of records left out."""
        import pandas as pd

        return pd.DataFrame([asdict(item) for item in self.errors])


def fit_to_records(
    model: Model,
    records: Sequence[FreeRecord] | Campaign,
    effects: Sequence[str] = (),
    *,
    prior: Prior | None = None,
    spread: float = SPREAD,
    floor: float = FLOOR,
    window: float | None = None,
    windage: tuple[float, float] | None = None,
    sensors: Mapping[str, float] | None = None,
    own: Sequence[Effect] = (),
    extrapolate: bool = False,
    why: str = "",
    progress: Callable[[str], None] | None = None,
) -> FreeRefit:
    """A model with its uncertain values and effects fitted together to free-running records.

    Parameters
    ----------
    model : Model
        Complete.
    records : sequence of FreeRecord or Campaign
        At least two.
    effects : sequence of str
        What is added, one after another: names of findings of `diagnose_free`. Faults correct the
        records and enter no model.
    prior, spread, floor, window, windage, sensors, own, extrapolate
        As for `diagnose_free`.
    why : str
        A remark for the history of the model.
    progress : callable, optional
        Is told what is being done.

    Returns
    -------
    FreeRefit

    Raises
    ------
    DataError
        If there are no records.
    UnknownNameError
        If an effect has no place in the model or in such records.
    """
    tell = progress or (lambda _: None)
    given = records_of(records, model)
    speed = given[0].speed
    base = (
        base_of(model, speed, spread=spread, extrapolate=extrapolate)
        if prior is None
        else stated_base(prior)
    )
    offered = {x.name: x for x in candidates_for(model, given, windage=windage, own=own)}
    for name in effects:
        if name not in offered:
            raise no_such_effect(name, list(offered))
    asked = tuple(offered[name] for name in effects)
    question = question_of(
        model,
        given,
        asked,
        base,
        floor=floor,
        window=window,
        sensors=sensors,
        extrapolate=extrapolate,
        tell=tell,
    )
    place = first_place(question)
    errors, made, forces = [], model, None
    for count in range(len(asked) + 1):
        names = tuple(effects[:count])
        tell(f"Fit with {', '.join(names) or 'the base alone'}")
        fit = fitted(place, names, forces)
        left = pooled(predicted(fit, each(given)))
        errors.append(RecordError(step=names[-1] if names else "base", **left))
        after = model_of(model, asked, fit, speed)
        if names:
            step = step_of(made, after, asked[count - 1], fit)
            fall = " to ".join(f"{item.heading:.2f}" for item in errors[-2:])
            said = f"error of heading of records left out {fall}°"
            step = replace(step, note=f"{why}; {said}" if why else said)
            made = after.with_(steps=(*made.steps, step))
        else:
            count_of = len(base.names) if fit.spread or np.any(base.known) else 0
            first = Step(action="fitted", count=count_of, campaign="records")
            made = after.with_(steps=(*model.steps, *([first] if count_of else [])))
    return FreeRefit(model=made, errors=tuple(errors))


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
    columns = fit.place.question.numbers.columns[item.name].tolist()
    found = {
        label: WIDER * typical * float(fit.z[column])
        for (label, typical), column in zip(item.typical.items(), columns, strict=True)
    }
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
