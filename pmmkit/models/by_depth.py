"""A model in water of a depth between those of the tests."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from pmmkit.base import ModelError
from pmmkit.effects import HULL, INERTIA, apply
from pmmkit.models.model import Model
from pmmkit.models.part import Part
from pmmkit.models.step import Value
from pmmkit.models.tables.by_depth import SPEEDS_APART, TablesByDepth, place_of
from pmmkit.numerics import Array


def model_at_depth(
    models: Mapping[float, Model], ratio: float, *, by_formulas: bool = False
) -> Model:
    """The model at a depth between those of the tests: hull and added mass on straight lines over
    the draught over the depth, of which the laws of shallow water are functions.

    Parameters
    ----------
    models : mapping of float to Model
        Models of one ship by the depth of their water over the draught.
    ratio : float
        Depth of the water over the draught.
    by_formulas : bool
        Whether the model in the deepest water is carried there by the formulas of
        `pmmkit.effects.shallow_water`.

    Returns
    -------
    Model
        That of the tests where there is one; else other parts, and values that one of its two
        neighbours lacks, from the nearer one. Errors at two depths are taken as independent.

    Raises
    ------
    ExtrapolationError
        If the depth lies outside.
    ModelError
        If the two neighbours have values at other Froude numbers.
    DataError
        If the formulas do not hold there.
    """
    if by_formulas:
        return _carried(models[max(models)], max(models), ratio)
    known = np.array(sorted(models, reverse=True))
    above, share = place_of(ratio, known)
    if share == 0.0:
        return models[float(known[above])]
    ends_of = float(known[above]), float(known[above + 1])
    deep, shallow = (models[end] for end in ends_of)
    if not _alike(deep, shallow):
        raise ModelError("The models at two depths have values at other Froude numbers.")
    nearer = deep if share < 0.5 else shallow
    parts = {
        name: _between(nearer.parts[name], deep.parts[name], shallow.parts[name], share)
        if name in (HULL, INERTIA) and name in deep.parts and name in shallow.parts
        else part
        for name, part in nearer.parts.items()
    }
    forced = [x for x in (*deep.steps, *shallow.steps) if x.action == "forced"]
    told = f"Between the models at {ends_of[0]:.4g} and {ends_of[1]:.4g} draughts of water."
    return nearer.with_(
        parts=MappingProxyType(parts),
        water=replace(nearer.water, depth=ratio * nearer.ship.d),
        covariance=_covariance(deep, shallow, nearer, share),
        notes=(told, *nearer.notes),
        steps=(*nearer.steps, *(x for x in forced if x not in nearer.steps)),
    )


def _carried(model: Model, deepest: float, ratio: float) -> Model:
    """A model of tests at a depth over the draught, carried to another one by the formulas."""

    def grown(name: str, ratio: float) -> float:
        depth = ratio * model.ship.d
        found = apply({name: 1.0}, ship=model.ship, depth=depth, nearly=TablesByDepth.NEARLY)
        return float(found[name])

    def carried(part: Part) -> Part:
        laws = {name: grown(name, ratio) / grown(name, deepest)
                for name in part.values}  # fmt: skip
        return replace(
            part,
            values=MappingProxyType(
                {name: _scaled(value, laws[name]) for name, value in part.values.items()}
            ),
        )

    parts = {
        name: carried(part) if name in (HULL, INERTIA) else part
        for name, part in model.parts.items()
    }
    return model.with_(
        parts=MappingProxyType(parts),
        water=replace(model.water, depth=ratio * model.ship.d),
        covariance=None,
        covariance_names=(),
    )


def _alike(deep: Model, shallow: Model) -> bool:
    """Whether two models have values at the same Froude numbers."""
    return len(deep.Fn) == len(shallow.Fn) and bool(
        np.allclose(deep.Fn, shallow.Fn, rtol=SPEEDS_APART, atol=0)
    )


def _between(nearer: Part, deep: Part, shallow: Part, share: float) -> Part:
    values: dict[str, Value] = dict(nearer.values)
    for name in nearer.values:
        if name in deep.values and name in shallow.values:
            one, other = np.asarray(deep.values[name]), np.asarray(shallow.values[name])
            values[name] = _as_value((1.0 - share) * one + share * other)
    return replace(nearer, values=MappingProxyType(values))


def _scaled(value: Value, factor: float) -> Value:
    return _as_value(factor * np.asarray(value, float))


def _as_value(found: Array) -> Value:
    return tuple(float(x) for x in found) if found.ndim else float(found)


def _covariance(deep: Model, shallow: Model, nearer: Model, share: float) -> Array | None:
    """That of both, where both know it of the same values; else that of the nearer one."""
    one, other = deep.covariance, shallow.covariance
    if one is None or other is None or deep.covariance_names != shallow.covariance_names:
        return nearer.covariance
    found: Array = (1.0 - share) ** 2 * one + share**2 * other
    return found
