"""What a diagnosis of free-running records tells: coverage, findings, the better model."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Final

import numpy as np

from pmmkit.diagnosis.evidence import SHOWS, Visible, could_hide, mimics
from pmmkit.diagnosis.findings import LARGE, Finding
from pmmkit.diagnosis.free_running.fits import SetFit
from pmmkit.diagnosis.free_running.hypotheses import WIDER, FreeCandidate, Names, Numbers, Screen
from pmmkit.diagnosis.free_running.left_out import left_out_errors, mean_log
from pmmkit.diagnosis.refit import Place, put_back
from pmmkit.effects import OUTSIDE, Parameter
from pmmkit.identification import FreeRecord, Prediction, Smoothed, places
from pmmkit.models import Model
from pmmkit.numerics import Array
from pmmkit.presentation import WIDE

BEYOND: Final = 2.0
"""Standard deviations by which a fit may leave a value beyond the least or most that there is."""


@dataclass(frozen=True, kw_only=True, eq=False)
class NamedSet:
    """A set after its fit through the equations.

    `gain`: ln of its odds against none.
    """

    names: Names
    gain: float
    fit: SetFit

    @cached_property
    def error(self) -> float:
        """Mean of ln of the errors of records that are left out."""
        return mean_log(self._left_out)

    @property
    def predicts(self) -> bool:
        """Whether no error of records left out matters over windows."""
        return all(x <= small for x, small in self._left_out[0])

    @cached_property
    def _left_out(self) -> list[list[tuple[float, float]]]:
        return left_out_errors(self.fit)


def moved(fit: SetFit) -> dict[str, float]:
    """By how much a fit moves values of the model, and what else it finds."""
    numbers = fit.place.question.numbers
    change = (numbers.T @ fit.z).tolist()
    return {name: x for name, x in zip(numbers.values, change, strict=True) if x != 0.0}


MOST: Final = 3
"""Values that are told of those that moved, the farthest first."""


def moved_most(fit: SetFit) -> str:
    """How far the values of the base are from those of the model as it is given, in words."""
    numbers = fit.place.question.numbers
    base, own = numbers.base, slice(len(numbers.base.names))
    z, known = fit.z[own], np.sqrt(np.diagonal(base.known)[own])
    if not np.any(z):
        return "the base stands as it is given"
    said = []
    for i in np.argsort(-np.abs(z))[:MOST].tolist():
        far = f"{100 * abs(z[i]):.2g} % of its usual size"
        if known[i] and not base.open[i]:
            far = f"{abs(z[i]) / known[i]:.1f} of its standard deviations"
        said.append(f"{base.names[i]} by {z[i] * base.sizes[i]:+.3g} ({far})")
    return f"values of the base moved, most of all {', '.join(said)}"


def odd_sizes(fit: SetFit, every: Sequence[FreeCandidate]) -> list[str]:
    """Effects of a fit of another sign or far more of them than is usual, in words.

    All coefficients of an effect are looked at together. An error of an instrument, and a wind, may
    be as large as they like.
    """
    numbers, found = fit.place.question.numbers, []
    for item in every:
        if item.name not in fit.names or item.kind == "fault":
            continue
        at = numbers.columns[item.name][[label != item.lag for label in item.moves]]
        z, C = fit.z[at], fit.covariance[np.ix_(at, at)]
        if item.signed and np.sum(z) < -WIDE * math.sqrt(np.sum(C)):
            found.append(f"{item.name} is of the other sign than usual")
        size, std = math.sqrt(np.mean(z**2)), math.sqrt(np.trace(C) / len(at))
        if item.family != "environment" and size - WIDE * std > LARGE / WIDER:
            found.append(f"{item.name} is far larger than usual")
    return found


def _unknown(fit: SetFit) -> Array:
    """Covariance of the values of the model by a fit."""
    T = fit.place.question.numbers.T
    whole: Array = T @ fit.covariance @ T.T
    return whole


def model_of(
    model: Model,
    every: Sequence[FreeCandidate],
    fit: SetFit,
    speed: float,
    tests: str | None = None,
) -> Model:
    """The model with the values of a fit, their covariance, and the parts of its effects.

    What a fit moves is moved alike at all Froude numbers, and is as uncertain at each. What it
    leaves a little beyond the least or the most that there is, by less than it knows of it, is put
    there. Values that the fit cannot move, and what is no value of a model, do not differ. What the
    model had is known from there and from the records, and its source says both.

    speed [m/s].
    """
    made = model
    for item in every:
        if item.name in fit.names:
            made = item.added_to(made)
    change = {name: x for name, x in moved(fit).items() if name not in OUTSIDE}
    numbers = made.values_at(speed, extrapolate=True)
    whole = _unknown(fit)
    deviations = np.sqrt(np.maximum(np.diagonal(whole), 0.0)).tolist()
    std = dict(zip(fit.place.question.numbers.values, deviations, strict=True))
    values: dict[Place, float | tuple[float, ...]] = {}
    for (effect, name), (label, x) in zip(places(made, list(change)), change.items(), strict=True):
        own = made.parts[effect].values.get(name)
        within = partial(_within, made.parts[effect].known.parameter(name), unsure=std[label])
        values[effect, name] = (
            tuple(within(value + x) for value in own)
            if isinstance(own, tuple)
            else within(float(numbers[effect][name]) + x)
        )
    title = tests
    if title is None:
        title = FreeRecord.title_of([x.record for x in fit.place.question.stretches]) or "records"
    known, covariance = _known(made, fit, values, whole)
    return put_back(
        made,
        values=values,
        known=known,
        covariance=covariance,
        sources={place: _source(model, place, title) for place in values},
    )


def _source(model: Model, place: Place, title: str) -> str:
    """Where a value comes from that records tell more of, or alone."""
    effect, name = place
    part = model.parts.get(effect)
    stated = (
        effect not in model.derivative_parts and part is not None and part.known.parameter(name)
    )
    if part is None or (name not in part.values and not stated):
        return f"measured: {title}"
    said = f"; fitted to {title}"
    return f"{part.source_of(name).removesuffix(said)}{said}"


def _known(
    model: Model, fit: SetFit, values: Mapping[Place, float | tuple[float, ...]], whole: Array
) -> tuple[tuple[Place, ...], Array]:
    """Values of a model of which a fit knows how uncertain they are, and their covariance."""
    numbers = fit.place.question.numbers
    moves = [
        i for i, name in enumerate(numbers.values) if name not in OUTSIDE and whole[i, i] > 0.0
    ]
    at = places(model, [numbers.values[i] for i in moves])
    held = [
        k
        for k, (effect, name) in enumerate(at)
        if (effect, name) in values or name in model.parts[effect].values
    ]
    return tuple(at[k] for k in held), whole[np.ix_(moves, moves)][np.ix_(held, held)]


def _within(parameter: Parameter | None, value: float, unsure: float) -> float:
    """A value at the limit that it is beyond by less than is known of it, else as it is."""
    if parameter is None:
        return value
    near = min(max(value, parameter.low), parameter.high)
    return near if abs(value - near) <= BEYOND * unsure else value


def held_out_errors(
    given: Model,
    others: Mapping[str, Model],
    better: Model | None,
    records: Sequence[FreeRecord],
    *,
    window: float,
    corrections: Mapping[str, float],
    sensors: Mapping[str, float] | None,
    extrapolate: bool,
) -> dict[str, dict[str, float]]:
    """Errors of `predict` over held-out records: as given, of others, with the effects."""
    courses = Smoothed.references(given, records, sensors=sensors, extrapolate=extrapolate)
    rows = {"model as given": given, **others}
    errors = {
        f"held out, {name}": Prediction.of(
            model, courses, window=window, extrapolate=extrapolate
        ).pooled()
        for name, model in rows.items()
    }
    if better is not None:
        sailed = Smoothed.corrected(
            given, courses, corrections, sensors=sensors, extrapolate=extrapolate
        )
        errors["held out, with the effects"] = Prediction.of(
            better, sailed, window=window, extrapolate=extrapolate
        ).pooled()
    return errors


def _signal(seen: Screen, name: str, a: Array) -> float:
    """Information on an effect at some size."""
    at = seen.columns[name]
    return float(a @ seen.normal.information[np.ix_(at, at)] @ a)


def coverage_of(
    seen: Screen, fewer: Sequence[Screen], every: Sequence[FreeCandidate]
) -> tuple[Visible, ...]:
    """What the records could show of each candidate at its usual size; the most visible first."""
    usual = {item.name: np.full(len(item.moves), 1.0 / WIDER) for item in every}
    signal = {name: _signal(seen, name, a) for name, a in usual.items()}
    visible = []
    for item in every:
        own, a = seen.columns[item.name], usual[item.name]
        strength = signal[item.name]
        others = {name: at for name, at in seen.columns.items() if name != item.name}
        across = seen.normal.information[:, own] @ a
        shown = strength >= SHOWS
        visible.append(
            Visible(
                name=item.name,
                family=item.family,
                signal=strength,
                without_a_run=min(_signal(x, item.name, a) for x in fewer),
                hides=could_hide(seen.normal.information[np.ix_(own, own)], a),
                shown=shown,
                why="" if shown else _why(strength),
                mimics=mimics(
                    seen.normal.information, across[:, None], np.array([strength]), others
                )[0]
                if strength > 1.0
                else {},
            )
        )
    return tuple(sorted(visible, key=lambda item: -item.signal))


def _why(signal: float) -> str:
    if signal < 0.1:
        return "the base absorbs it, or the records do not excite it"
    return "too small beside noise, unknown forces and what is not known of the base"


def _lag(fit: SetFit, item: FreeCandidate) -> float:
    """How long a flow remembers by a fit; zero where an effect has no such coefficient."""
    if not item.lag:
        return 0.0
    question = fit.place.question
    stretch, (place,) = question.stretches[0], item.moves[item.lag]
    at = stretch.binding.names.index(place)
    return float(stretch.binding.mean[at]) + moved(fit).get(place, 0.0)


def findings_of(
    best: NamedSet,
    every: Sequence[FreeCandidate],
    covered: Sequence[Visible],
    odds: Mapping[str, float],
    errors: Mapping[str, tuple[Mapping[str, float], Mapping[str, float]]],
    levels: Mapping[str, float],
) -> tuple[Finding, ...]:
    """The effects of the best set for people."""
    visible = {item.name: item for item in covered}
    numbers: Numbers = best.fit.place.question.numbers
    std = np.sqrt(np.diagonal(best.fit.covariance))
    found = []
    for item in every:
        if item.name not in best.names:
            continue
        columns = numbers.columns[item.name].tolist()
        size = {label: WIDER * typical for label, typical in item.typical.items()}
        every_pair = list(zip(size.items(), columns, strict=True))
        pairs = [pair for pair in every_pair if pair[0][0] != item.lag]
        before, after = errors[item.name]
        found.append(
            Finding(
                effect=item.name,
                family=item.family,
                kind=item.kind,
                summary=item.summary,
                coefficients={x: factor * float(best.fit.z[j]) for (x, factor), j in pairs},
                std={x: abs(factor) * float(std[j]) for (x, factor), j in pairs},
                typical={x: item.typical[x] for (x, _), _ in pairs},
                value=_lag(best.fit, item),
                parameter=item.lag,
                log_odds=odds[item.name],
                rivals=tuple(visible[item.name].mimics),
                separating_test=item.check,
                beside=True,
                error_before=before.get("heading", math.nan),
                error_after=after.get("heading", math.nan),
                error_level=levels.get("heading", math.nan),
                levels=dict(levels),
                errors={name: (before[name], after[name]) for name in before},
            )
        )
    return tuple(found)
