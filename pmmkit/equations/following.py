"""Derivatives that follow the speed of the moment: what a model has at each speed it knows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from pmmkit.base import ModelError
from pmmkit.equations.layouts import Constant
from pmmkit.equations.prepared import (
    Conditions,
    Prepared,
    mass_problem,
    packed,
    prepare,
    refers_to_carriage,
)
from pmmkit.equations.structure import EquationStructure
from pmmkit.models import Model


@lru_cache(maxsize=64)
def prepare_following(
    model: Model, speed: float, *, conditions: Conditions | None = None, extrapolate: bool = False
) -> Prepared:
    """A model whose values follow the Froude number of the moment.

    speed [m/s].

    Examples
    --------
    >>> from pmmkit.models import load_model
    >>> one_speed = load_model("s175")
    >>> prepare_following(one_speed, 9.0).k == prepare(one_speed, 9.0).k
    True
    """
    conditions = conditions or Conditions()
    plain = prepare(model, speed, conditions=conditions, extrapolate=extrapolate)
    speeds = model.known_speeds(speed)
    values = [model.values_at(each, extrapolate=extrapolate) for each in speeds]
    at_approach = model.values_at(speed, extrapolate=extrapolate)
    structure, k = packed_following(model, at_approach, speeds, values, speed, conditions)
    if not structure.follows:
        return plain
    for known in values:
        if plain.functions().complete(packed(model, known, speed, conditions)[1]):
            raise ModelError(mass_problem(model.name))
    return Prepared(structure=structure, k=tuple(k), speed=speed, name=model.name)


def packed_following(
    model: Model,
    at_approach: Mapping[str, Mapping[str, Any]],
    speeds: Sequence[float],
    values: Sequence[Mapping[str, Mapping[str, Any]]],
    speed: float,
    conditions: Conditions,
) -> tuple[EquationStructure, list[Any]]:
    """Structure and constants of a model from the values of its parts at several speeds.

    Parameters
    ----------
    model : Model
        What does not differ.
    at_approach : mapping
        Values of the parts at the approach.
    speeds : sequence of float
        Ascending [m/s]; none where nothing follows the speed.
    values : sequence of mapping
        Values of the parts at these speeds.
    speed : float
        Of the approach [m/s].
    conditions : Conditions
        What surrounds the ship.

    Returns
    -------
    EquationStructure, list
        Constants are floats, or arrays with a value for each ship.

    Notes
    -----
    The constants are linear in the values, and the values lie on lines between the speeds: what
    stands at the speeds gives the constants of every moment to rounding. The mass matrix is
    solved at every moment, as its inverse is not linear. Derivatives that refer to the speed of
    the carriage belong to a run at the speed of the moment; a loss of speed (``surge =
    "delta-u"``) is still counted from the approach.
    """
    structure, k = packed(model, at_approach, speed, conditions)
    powers = [x for name in model.in_role("depth") for x in model.parts[name].values.values()]
    if speeds and any(isinstance(x, tuple) for x in powers):
        raise ModelError(
            f"The powers of shallow_water in model {model.name!r} differ between Froude "
            f"numbers, which the derivatives of the moment cannot follow. Give one value of each, "
            f'or take fn="approach".'
        )
    rows = [packed(model, own, speed, conditions)[1] for own in values]
    if refers_to_carriage(model):
        for row, own in zip(rows, speeds, strict=True):
            row[Constant.reference] = own
    follows = tuple(
        place
        for place in range(len(k))
        if any(np.any(row[place] != rows[0][place]) for row in rows)
    )
    if not follows:
        return structure, k
    table: list[Any] = [float(len(speeds))]
    for own, row in zip(speeds, rows, strict=True):
        table += [own, *(row[place] for place in follows)]
    return replace(structure, follows=follows), [*k, *table]
