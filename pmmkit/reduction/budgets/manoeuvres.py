"""The budget of what a manoeuvre measures, from the sources of the tests behind its model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pmmkit.errors import DataError
from pmmkit.metrics import main_of
from pmmkit.models import Model, load_model
from pmmkit.numerics import Array
from pmmkit.reduction.budgets.budget import Budget, Result, Source
from pmmkit.reduction.budgets.derivatives import derivative_budget, root
from pmmkit.simulation.sensitivity import Sensitivities, sensitivities

if TYPE_CHECKING:
    from pmmkit.reduction.reduce import Reduction
    from pmmkit.simulation.manoeuvres.manoeuvre import Manoeuvre


def manoeuvre_budget(
    reduction: Reduction,
    model: Model | str | Path,
    manoeuvre: str | Manoeuvre = "turning",
    *,
    speed: float,
    **settings: Any,
) -> Budget:
    """Which source makes how much of the uncertainty of each metric of a manoeuvre.

    Parameters
    ----------
    reduction : Reduction
        The tests behind the model.
    model : Model, str or path
        Made of this reduction, as by `model_of`.
    manoeuvre, speed, **settings
        As for `sensitivities`.

    Returns
    -------
    Budget
        The sources of the tests, carried by the slopes of each metric over each derivative; and
        what of the model was not tested but estimated or lent, part by part.

    Raises
    ------
    DataError
        If the model holds none of the derivatives of the reduction.

    Notes
    -----
    First order, as `sensitivities`: the sum is the variance that it gives.
    """
    loaded = model if isinstance(model, Model) else load_model(model)
    found = sensitivities(loaded, manoeuvre, speed=speed, **settings)
    budget = derivative_budget(reduction)
    weights = _weights(loaded, speed)
    results = tuple(
        Result(name=name, value=found.nominal[name], unit=found.units.get(name, "-"))
        for name in found.slopes
        if np.isfinite(found.nominal[name]) and np.isfinite(found.slopes[name]).all()
    )
    slopes = np.column_stack([found.slopes[item.name] for item in results])
    known = {name: place for place, name in enumerate(found.names)}
    carry = np.zeros((len(budget.results), len(results)))
    for row, item in enumerate(budget.results):
        if item.name in known:
            carry[row] = _weight(weights, item.Fn) * slopes[known[item.name]]
    if not carry.any():
        raise DataError(
            f"Model {loaded.name!r} holds no derivative of these tests: make it of them "
            "(pmmkit.model_of)."
        )
    tested = {item.name for item in budget.results}
    called = manoeuvre if isinstance(manoeuvre, str) else manoeuvre.name
    return replace(
        budget,
        subject=f"{called.replace('_', ' ')} of {loaded.name} at {speed:.4g} m/s",
        results=_main_first(results),
        sources=_main_first_of(
            results,
            [
                *(replace(item, factors=item.factors @ carry) for item in budget.sources),
                *_untested(found, slopes, tested),
            ],
        ),
    )


def _untested(found: Sensitivities, slopes: Array, tested: set[str]) -> list[Source]:
    """What of the model does not come from the tests, part by part."""
    if found.covariance is None:
        return []
    parts: dict[str, list[int]] = {}
    for place, name in enumerate(found.names):
        if name not in tested:
            parts.setdefault(name.rpartition(".")[0], []).append(place)
    return [
        Source(
            title=f"{part.replace('_', ' ') or 'derivatives'}: not tested",
            gum="B",
            acts="bias",
            factors=root(found.covariance[np.ix_(places, places)]) @ slopes[places],
        )
        for part, places in parts.items()
    ]


def _weights(model: Model, speed: float) -> Mapping[float, float]:
    """Share of the derivatives at each tested Froude number in those of an approach."""
    if not model.Fn:
        return {np.nan: 1.0}
    froude = model.ship.froude(speed, model.water.g)
    shares = model.weights(froude, extrapolate=True)
    return dict(zip(model.Fn, map(float, shares), strict=True))


def _weight(weights: Mapping[float, float], Fn: float) -> float:
    if np.isnan(Fn):
        return 1.0
    return sum(share for at, share in weights.items() if np.isclose(at, Fn, rtol=1e-9))


def _order(results: Sequence[Result]) -> list[int]:
    first = main_of([item.name for item in results])
    return sorted(range(len(results)), key=lambda place: results[place].name != first)


def _main_first(results: Sequence[Result]) -> tuple[Result, ...]:
    return tuple(results[place] for place in _order(results))


def _main_first_of(results: Sequence[Result], sources: Sequence[Source]) -> tuple[Source, ...]:
    order = _order(results)
    return tuple(replace(item, factors=item.factors[:, order]) for item in sources)
