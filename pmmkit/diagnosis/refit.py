"""What a fit says of values of a model, and how it comes into the model as steps."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from pmmkit.diagnosis.evidence import finite
from pmmkit.models import Model, Part, Step
from pmmkit.numerics import Array

Place = tuple[str, str]
"""A part of a model and one of its values."""


def put_back(
    model: Model,
    *,
    values: Mapping[Place, float | tuple[float, ...]],
    known: Sequence[Place],
    covariance: Array,
    sources: Mapping[Place, str],
    Fn: tuple[float, ...] = (),
) -> Model:
    """A model with fitted values, their sources and their covariance, and with no other one.

    covariance (n, n).

    Examples
    --------
    >>> from pmmkit.models import load_model
    >>> place = ("hull_polynomial", "Yv")
    >>> made = put_back(
    ...     load_model("kvlcc2"), values={place: -0.3}, known=[place],
    ...     covariance=np.array([[1e-4]]), sources={place: "measured: tank"},
    ... )
    >>> made.values("hull_polynomial")["Yv"], made.std["Yv"]
    (-0.3, (0.01,))
    >>> made.parts["hull_polynomial"].source_of("Yv")
    'measured: tank'
    """
    parts = dict(model.parts)
    for (home, name), value in values.items():
        part = parts.get(home, Part(effect=home))
        parts[home] = replace(
            part,
            values=MappingProxyType({**part.values, name: value}),
            sources=MappingProxyType({**part.sources, name: sources[home, name]}),
        )
    for home, name in known:
        std = {label: x for label, x in parts[home].std.items() if label != name}
        parts[home] = replace(parts[home], std=MappingProxyType(std))
    Fn = model.Fn or Fn
    if not known:
        return model.with_(
            parts=MappingProxyType(parts), Fn=Fn, covariance=None, covariance_names=()
        )
    copies = max(len(Fn), 1) * len(known) // len(covariance)
    return model.with_(
        parts=MappingProxyType(parts),
        Fn=Fn,
        covariance=np.tile(0.5 * (covariance + covariance.T), (copies, copies)),
        covariance_names=tuple(parts[home].place(name) for home, name in known),
    )


def stepped(
    old: Model,
    new: Model,
    fit: Step,
    steps: Sequence[Step],
    found: Sequence[tuple[Mapping[str, float], Sequence[str]]],
    errors: Sequence[float],
    of: str = "",
) -> Model:
    """A model that was fitted, with a step for each effect that was taken in, or one for the
    fit."""
    if not steps:
        return new.stepped(fit) if fit.count else new
    made = []
    brought: set[str] = set()
    for number, (step, (coefficients, there)) in enumerate(zip(steps, found, strict=True)):
        new_places = [place for place in there if place not in brought]
        brought.update(new_places)
        # In another convention no value is what it was.
        kept = bool(there) and old.convention == new.convention
        made.append(
            replace(
                fit,
                action=step.action,
                effect=step.effect,
                coefficients={name: x for name, x in coefficients.items() if math.isfinite(x)},
                system="" if step.action == "fault_corrected" else "prime",
                parameter=step.parameter,
                value=step.value,
                log_odds=step.log_odds,
                note=step.note,
                error_before=finite(errors[number]),
                error_after=finite(errors[number + 1]),
                error_of=of,
                before=old.before(new, new_places) if kept else None,
            )
        )
    return new.stepped(*made)
