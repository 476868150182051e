"""A model fitted to free-running records together with effects that it lacked."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Final

from pmmkit.campaigns.run import Campaign
from pmmkit.diagnosis.captive.candidate import no_such_effect
from pmmkit.diagnosis.free_running.candidates import FreeCandidate, candidates_for
from pmmkit.diagnosis.free_running.evidence import WIDER, Basis, Fit, fitted, point_at
from pmmkit.diagnosis.free_running.findings import model_of, pooled
from pmmkit.diagnosis.free_running.question import judge_of, records_of
from pmmkit.diagnosis.free_running.weighing import FLOOR, TOLERANCE, base_prior
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


@dataclass(frozen=True, kw_only=True)
class RecordError:
    """How well records left out are predicted after a step.

    Parameters
    ----------
    step : str
        ``base``, or the effect that was added.
    heading_deg, speed : float
        Root mean square errors over windows with the measured rudder [deg, m/s].
    """

    step: str
    heading_deg: float
    speed: float


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
        rows = [[item.step, f"{item.heading_deg:.2f}", f"{item.speed:.4f}"] for item in self.errors]
        return aligned(["records left out", "heading [deg]", "speed [m/s]"], rows)

    @property
    def useless(self) -> tuple[str, ...]:
        """Steps after which neither heading nor speed is predicted better."""
        return tuple(
            after.step
            for before, after in pairwise(self.errors)
            if after.heading_deg > FALLS * before.heading_deg and after.speed > FALLS * before.speed
        )

    def to_pandas(self) -> pd.DataFrame:
        """A row per step: step, heading_deg [deg], speed [m/s] of records left out."""
        import pandas as pd

        return pd.DataFrame([asdict(item) for item in self.errors])


def fit_to_records(
    model: Model,
    records: Sequence[FreeRecord] | Campaign,
    effects: Sequence[str] = (),
    *,
    prior: Prior | None = None,
    spread: float = 0.05,
    loose: float = 0.1,
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
    prior, spread, loose, floor, window, windage, sensors, own, extrapolate
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
    prior = prior or base_prior(model, speed, spread=spread, loose=loose, extrapolate=extrapolate)
    offered = {x.name: x for x in candidates_for(model, given, windage=windage, own=own)}
    for name in effects:
        if name not in offered:
            raise no_such_effect(name, list(offered))
    asked = tuple(offered[name] for name in effects)
    judge, largest = judge_of(
        model,
        given,
        asked,
        prior,
        floor=floor,
        tolerance=TOLERANCE,
        window=window,
        sensors=sensors,
        extrapolate=extrapolate,
        tell=tell,
    )
    system, basis = judge.system, judge.basis
    errors, made, begin = [], model, largest.z
    for count in range(len(asked) + 1):
        names = tuple(effects[:count])
        tell(f"Fit with {', '.join(names) or 'the base alone'}")
        fit = fitted(system, basis, names, wider=judge.wider, begin=begin)
        here = fit.here if names else point_at(system, basis, fit.z)
        heading, pace = pooled(judge, judge.left_out(here, names)).tolist()
        errors.append(
            RecordError(
                step=names[-1] if names else "base", heading_deg=math.degrees(heading), speed=pace
            )
        )
        begin = fit.z
        after = model_of(model, asked, system, basis, fit)
        if names:
            step = step_of(made, after, asked[count - 1], basis, fit)
            fall = " to ".join(f"{item.heading_deg:.2f}" for item in errors[-2:])
            said = f"error of heading of records left out {fall}°"
            step = replace(step, note=f"{why}; {said}" if why else said)
            made = after.with_(steps=(*made.steps, step))
        else:
            steps = (
                *model.steps,
                Step(action="fitted", count=len(prior.names), campaign="records"),
            )
            made = after.with_(steps=steps)
    return FreeRefit(model=made, errors=tuple(errors))


def step_of(old: Model, new: Model, item: FreeCandidate, basis: Basis, fit: Fit) -> Step:
    """The step by which a fit to records took an effect in.

    Parameters
    ----------
    old, new : Model
        Before and after.
    item : FreeCandidate
        The effect.
    basis, fit
        Of the records.
    """
    found = {
        label: WIDER * typical * float(fit.z[column])
        for (label, typical), column in zip(
            item.typical.items(), basis.columns[item.name], strict=True
        )
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
