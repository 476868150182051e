"""The budget of what a manoeuvre measures, from the sources of the tests behind its model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pmmkit.base import DataError
from pmmkit.conventions import METRICS
from pmmkit.imo import sided_tests
from pmmkit.inference import root
from pmmkit.models import DerivativeTable, Model, load_model
from pmmkit.numerics import Array
from pmmkit.reduction.budgets.budget import Budget, BudgetResult, Source, beside
from pmmkit.reduction.budgets.derivatives import derivative_budget
from pmmkit.simulation import Sensitivities, sensitivities

if TYPE_CHECKING:
    from pmmkit.reduction.reduce import Reduction
    from pmmkit.simulation import Manoeuvre


def manoeuvre_budget(
    reduction: Reduction,
    model: Model | str | Path,
    manoeuvre: str | Manoeuvre,
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
        what of the model was not tested but estimated or lent, part by part. Lengths are in ship
        lengths.

    Raises
    ------
    DataError
        If the model holds none of the derivatives of the reduction.

    Notes
    -----
    First order, as `sensitivities`: the sum is the variance that it gives. As in the model, what
    the tests say counts with the width of its interval, which few degrees of freedom make larger.
    """
    loaded = model if isinstance(model, Model) else load_model(model)
    called = manoeuvre if isinstance(manoeuvre, str) else manoeuvre.name
    return _carried(
        derivative_budget(reduction),
        reduction,
        loaded,
        speed,
        sensitivities(loaded, manoeuvre, speed=speed, **settings),
        f"{called.replace('_', ' ')} of {loaded.name} at {speed:.4g} m/s",
    )


def imo_budget(
    reduction: Reduction, model: Model | str | Path, *, speed: float, **settings: Any
) -> Budget:
    """The same for each number that IMO resolution MSC.137(76) limits, to starboard.

    Parameters
    ----------
    reduction, model, speed, **settings
        As for `manoeuvre_budget`.

    Returns
    -------
    Budget
        Its results have the names of the criteria: turning circle, initial turning and zigzags.
        The full astern stop is not among them.
    """
    loaded = model if isinstance(model, Model) else load_model(model)
    budget = derivative_budget(reduction)
    parts = []
    for manoeuvre, asked, pairs in sided_tests(loaded):
        found = sensitivities(loaded, manoeuvre, speed=speed, **settings, **asked)
        subject = f"the IMO's numbers of {loaded.name} at {speed:.4g} m/s"
        whole = _carried(budget, reduction, loaded, speed, found, subject)
        known = {item.name for item in whole.results}
        named = {metric.judged(item): item.name for metric, item in pairs}
        chosen = whole.of(*(name for name in named if name in known))
        parts.append(
            replace(
                chosen,
                results=tuple(replace(item, name=named[item.name]) for item in chosen.results),
            )
        )
    return beside(parts)


def _carried(
    budget: Budget,
    reduction: Reduction,
    model: Model,
    speed: float,
    found: Sensitivities,
    subject: str,
) -> Budget:
    """A budget of derivatives by the slopes of metrics, the main metric first."""
    first = METRICS.main(found.slopes)
    names = [
        name
        for name in sorted(METRICS.in_lengths(found.slopes), key=lambda name: name != first)
        if np.isfinite(found.nominal[name]) and np.isfinite(found.slopes[name]).all()
    ]
    slopes = np.column_stack([found.slopes[name] for name in names])
    table = next(iter(reduction.estimates.values())).table
    weights = _weights(model, speed)
    known = {name: place for place, name in enumerate(found.names)}
    carry = np.zeros((len(budget.results), len(names)))
    for row, item in enumerate(budget.results):
        if item.name in known:
            counts = _weight(weights, item.Fn) * _widening(table, item)
            carry[row] = counts * slopes[known[item.name]]
    if not carry.any():
        raise DataError(
            f"Model {model.name!r} holds no derivative of these tests: make it of their reduction."
        )
    tested = {item.name for item in budget.results}
    results = [
        BudgetResult(name=name, value=found.nominal[name], unit=found.units.get(name, "-"))
        for name in names
    ]
    carried = budget.carried(carry, results, subject)
    return replace(carried, sources=(*carried.sources, *_untested(found, slopes, tested)))


def _untested(found: Sensitivities, slopes: Array, tested: set[str]) -> list[Source]:
    """What of the model does not come from the tests, part by part."""
    if found.covariance is None:
        return []
    parts: dict[str, list[int]] = {}
    for place, name in enumerate(found.names):
        if name not in tested:
            part = name.rpartition(".")[0] or "derivatives"
            title = f"{name}: not stated" if name in found.settings else f"{part}: not tested"
            parts.setdefault(title.replace("_", " "), []).append(place)
    return [
        Source(
            title=title,
            gum="B",
            acts="bias",
            tested=False,
            factors=root(found.covariance[np.ix_(places, places)]).T @ slopes[places],
        )
        for title, places in parts.items()
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


def _widening(table: DerivativeTable, item: BudgetResult) -> float:
    row = 0 if table.pooled else int(np.argmin(np.abs(table.Fn - item.Fn)))
    return float(table.widening[row, table.index(item.name)])
