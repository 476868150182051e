"""What a diagnosis of free-running records tells: errors, coverage, findings, the better model."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Final

import numpy as np

from pmmkit.diagnosis.evidence import HIDES, MIMICS, SHOWS, Visible
from pmmkit.diagnosis.findings import Finding
from pmmkit.diagnosis.free_running.candidates import FreeCandidate
from pmmkit.diagnosis.free_running.evidence import WIDER, Basis, Fit, Screen
from pmmkit.diagnosis.free_running.scores import Judge
from pmmkit.diagnosis.free_running.system import FreeSystem
from pmmkit.effects.seen import CURRENT, RUDDER_ZERO
from pmmkit.identification.parameters import places, with_parameters
from pmmkit.identification.predict import predict, reference
from pmmkit.identification.record import FreeRecord
from pmmkit.models import Model
from pmmkit.numerics import Array

Names = tuple[str, ...]
LEFT: Final = 4.0
"""Errors of fitted records over the tolerance from which something is left to explain."""
BEYOND: Final = 10.0
"""ln evidence of unknown forces above the floor from which something is left to explain."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Settled:
    """A set after its fit through the equations."""

    names: Names
    gain: float
    fit: Fit
    errors: Array


def model_of(
    model: Model, every: Sequence[FreeCandidate], system: FreeSystem, basis: Basis, fit: Fit
) -> Model:
    """The model with the values of a fit and the parts of its effects."""
    made = replace(model, covariance=None, covariance_names=())
    for item in every:
        if item.name in fit.names:
            made = item.added_to(made)
    value = system.start + basis.T @ fit.z
    moved = np.any(basis.T[:, fit.used] != 0.0, axis=1)
    names = [
        (i, name)
        for i, name in enumerate(system.names)
        if moved[i] and name not in (*CURRENT, RUDDER_ZERO)
    ]
    at = places(made, [name for _, name in names])
    return with_parameters(made, at, value[[i for i, _ in names]])


def pooled(judge: Judge, found: Array) -> Array:
    """Root mean square over the records of the errors of heading [rad] and speed [m/s]."""
    counts = np.array([item.count for item in judge.courses])
    there = np.isfinite(found[:, 0])
    found_there: Array = np.sqrt(np.average(found[there], axis=0, weights=counts[there]))
    return found_there


def left_over(judge: Judge, found: Array) -> float:
    """Errors over the tolerance, the larger of heading and speed."""
    speed = judge.system.pieces[0].record.speed
    return float(np.max(pooled(judge, found) / (judge.tolerance * np.array([1.0, speed]))))


def errors_of(judge: Judge, before: Array, after: Array | None) -> dict[str, Mapping[str, float]]:
    """Errors of records left out, before and after, heading in degrees."""

    def row(found: Array) -> Mapping[str, float]:
        heading, speed = pooled(judge, found).tolist()
        return MappingProxyType({"heading": math.degrees(heading), "speed": speed})

    found = {"left out, base refitted": row(before)}
    return found if after is None else found | {"left out, with the effects": row(after)}


def errors_held_out(
    given: Model,
    refitted: Model,
    better: Model | None,
    records: Sequence[FreeRecord],
    *,
    window: float,
    current: tuple[float, float],
    zero: float,
    sensors: Mapping[str, float] | None,
    extrapolate: bool,
) -> dict[str, Mapping[str, float]]:
    """Errors of `predict` over the held-out records: as given, refitted, with the effects."""
    courses = reference(given, records, sensors=sensors, extrapolate=extrapolate)
    how = {"window": window, "extrapolate": extrapolate}
    found = {
        "held out, model as given": predict(given, courses, **how).pooled(),  # type: ignore[arg-type]
        "held out, base refitted": predict(refitted, courses, **how).pooled(),  # type: ignore[arg-type]
    }
    if better is not None:
        turned = [
            replace(item, record=item.record.with_(delta=item.record.delta + zero))
            for item in courses
        ]
        found["held out, with the effects"] = predict(
            better,
            turned,
            current=current,
            **how,  # type: ignore[arg-type]
        ).pooled()
    return {name: MappingProxyType(row) for name, row in found.items()}


def flags_of(told: bool, many: bool, left: float) -> tuple[str, ...]:
    """What to warn of."""
    found = ["not_the_whole_story"] if told and left > LEFT else []
    return (*found, *(["no_short_group"] if many else []))


def _signal(seen: Screen, name: str, a: Array) -> float:
    """Information on an effect at some size."""
    at = seen.columns[name]
    return float(a @ seen.gram[np.ix_(at, at)] @ a)


def coverage_of(
    seen: Screen, fewer: Sequence[Screen], likeness: Array, every: Sequence[FreeCandidate]
) -> tuple[Visible, ...]:
    """What the records could show of each candidate at its usual size; the most visible first."""
    usual = {item.name: np.full(len(item.moves), 1.0 / WIDER) for item in every}
    signal = {name: _signal(seen, name, a) for name, a in usual.items()}
    found = []
    for item in every:
        own, a = seen.columns[item.name], usual[item.name]
        shown = signal[item.name] >= SHOWS
        mimics = {}
        strength = float(a @ likeness[np.ix_(own, own)] @ a)
        for other in every:
            at = seen.columns[other.name]
            cross = likeness[np.ix_(at, own)] @ a
            share = float(cross @ np.linalg.lstsq(likeness[np.ix_(at, at)], cross, rcond=1e-9)[0])
            if other is not item and strength > 1.0 and share >= MIMICS * strength:
                mimics[other.name] = share / strength
        found.append(
            Visible(
                name=item.name,
                family=item.family,
                signal=signal[item.name],
                without_a_run=min(_signal(x, item.name, a) for x in fewer),
                hides=math.sqrt(HIDES / max(signal[item.name], 1e-6)),
                shown=shown,
                why="" if shown else _why(signal[item.name]),
                mimics=dict(sorted(mimics.items(), key=lambda x: -x[1])),
            )
        )
    return tuple(sorted(found, key=lambda item: -item.signal))


def _why(signal: float) -> str:
    if signal < 0.1:
        return "the base absorbs it, or the records do not excite it"
    return "too small beside noise, unknown forces and what is not known of the base"


def findings_of(
    best: Settled,
    judge: Judge,
    before: Array,
    every: Sequence[FreeCandidate],
    covered: Sequence[Visible],
) -> tuple[Finding, ...]:
    """The effects of the best set for people."""
    visible = {item.name: item for item in covered}
    price = math.log(2.0 * len(every))
    std = np.sqrt(np.diagonal(best.fit.covariance))
    place = {int(column): i for i, column in enumerate(best.fit.used)}
    found = []
    for item in every:
        if item.name not in best.names:
            continue
        own = judge.basis.columns[item.name]
        size = {label: WIDER * typical for label, typical in item.typical.items()}
        rest = tuple(name for name in best.names if name != item.name)
        without = judge.left_out(best.fit.here, rest) if rest else before
        unit = np.array([math.degrees(1.0), 1.0])
        off = (pooled(judge, without) * unit).tolist()
        now = (pooled(judge, best.errors) * unit).tolist()
        numbers = zip(size.items(), own, strict=True)
        found.append(
            Finding(
                effect=item.name,
                family=item.family,
                kind=item.kind,
                summary=item.summary,
                coefficients={
                    label: factor * float(best.fit.z[column])
                    for (label, factor), column in zip(size.items(), own, strict=True)
                },
                std={
                    label: abs(factor) * float(std[place[int(column)]])
                    for (label, factor), column in numbers
                },
                typical=dict(item.typical),
                value=0.0,
                parameter="",
                log_odds=judge.gain(without, best.errors) - price,
                rivals=tuple(visible[item.name].mimics),
                separating_test=item.check,
                beside=True,
                error_before=off[0],
                error_after=now[0],
                errors={"heading": (off[0], now[0]), "speed": (off[1], now[1])},
            )
        )
    return tuple(found)
