"""What a fit says of values of a model, and how it comes into the model as steps."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from pmmkit.models import Model, Part, Step, Value, before_of, place_name
from pmmkit.numerics import Array

Place = tuple[str, str]
"""A part of a model and one of its values."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FittedValues:
    """What a fit says of values of a model, by name.

    `values`: by part and name; one for each of the model's Froude numbers where they differ.
    `known`: those of which the fit knows how uncertain they are. `covariance (n, n)`: of
    `known`, alike at all Froude numbers; or of `known` at one Froude number after another.
    `sources`: where each value comes from. `Fn`: Froude numbers of the values that differ with
    them.
    """

    values: Mapping[Place, Value]
    known: tuple[Place, ...]
    covariance: Array
    sources: Mapping[Place, str]
    Fn: tuple[float, ...] = ()


def put_back(model: Model, fitted: FittedValues) -> Model:
    """A model with fitted values, their sources and their covariance, and with no other one.

    Examples
    --------
    >>> from pmmkit.models import load_model
    >>> one = FittedValues(
    ...     values={("hull_polynomial", "Yv"): -0.3}, known=(("hull_polynomial", "Yv"),),
    ...     covariance=np.array([[1e-4]]), sources={("hull_polynomial", "Yv"): "measured: tank"},
    ... )
    >>> made = put_back(load_model("kvlcc2"), one)
    >>> made.values("hull_polynomial")["Yv"], made.std["Yv"]
    (-0.3, (0.01,))
    >>> made.parts["hull_polynomial"].source_of("Yv")
    'measured: tank'
    """
    parts = dict(model.parts)
    for (home, name), value in fitted.values.items():
        part = parts.get(home, Part(effect=home))
        parts[home] = replace(
            part,
            values=MappingProxyType({**part.values, name: value}),
            sources=MappingProxyType({**part.sources, name: fitted.sources[home, name]}),
        )
    for home, name in fitted.known:
        std = {label: x for label, x in parts[home].std.items() if label != name}
        parts[home] = replace(parts[home], std=MappingProxyType(std))
    Fn = model.Fn or fitted.Fn
    if not fitted.known:
        return model.with_(
            parts=MappingProxyType(parts), Fn=Fn, covariance=None, covariance_names=()
        )
    copies = max(len(Fn), 1) * len(fitted.known) // len(fitted.covariance)
    return model.with_(
        parts=MappingProxyType(parts),
        Fn=Fn,
        covariance=np.tile(0.5 * (fitted.covariance + fitted.covariance.T), (copies, copies)),
        covariance_names=tuple(place_name(*place) for place in fitted.known),
    )


@dataclass(frozen=True, kw_only=True)
class FittedEffect:
    """What the last fit says of an effect that a step took in.

    `coefficients`: of the effect; those that are not known do not count. `places`: parts and
    values (``hull_polynomial.Yvvr``) of the model that it stands in; none of a fault, which
    corrects the tests and does not sail with the ship. `parameter, value`: nonlinear parameter
    of the effect.
    """

    coefficients: Mapping[str, float]
    places: tuple[str, ...] = ()
    parameter: str = ""
    value: float | None = None


def stepped(
    old: Model,
    new: Model,
    fit: Step,
    steps: Sequence[Step],
    found: Sequence[FittedEffect],
    errors: Sequence[float],
    of: str = "",
) -> Model:
    """A model that was fitted, with a step for each effect that was taken in, or one for the
    fit."""
    if not steps:
        return new.stepped(fit) if fit.count else new
    made = []
    brought: set[str] = set()
    for number, (step, own) in enumerate(zip(steps, found, strict=True)):
        places = [place for place in own.places if place not in brought]
        brought.update(places)
        # In another convention no value is what it was.
        kept = bool(own.places) and old.convention == new.convention
        made.append(
            replace(
                fit,
                action=step.action,
                effect=step.effect,
                coefficients={x: one for x, one in own.coefficients.items() if math.isfinite(one)},
                system="" if step.action == "fault_corrected" else "prime",
                parameter=own.parameter,
                value=own.value,
                log_odds=step.log_odds,
                note=step.note,
                error_before=_finite(errors[number]),
                error_after=_finite(errors[number + 1]),
                error_of=of,
                before=before_of(old, new, places) if kept else None,
            )
        )
    return new.stepped(*made)


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
