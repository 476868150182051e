"""Which runs, tests and sources of uncertainty make the uncertainty of a result."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from pmmkit.errors import DataError
from pmmkit.numerics import Array
from pmmkit.reduction.budgets.budget import Result
from pmmkit.reduction.budgets.derivatives import measured_budget

if TYPE_CHECKING:
    import pandas as pd

    from pmmkit.reduction.reduce import Reduction


def contributions(
    reduction: Reduction, slopes: Mapping[str, float], *, Fn: float | None = None
) -> pd.DataFrame:
    """Share of each test type and of each shared uncertainty in the variance of a result.

    Parameters
    ----------
    reduction : Reduction
        The reduced tests.
    slopes : mapping of str to float
        Change of the result per unit of each derivative, such as
        ``dict(zip(found.names, found.slopes["tactical_diameter"]))`` with `found` from
        `sensitivities`; derivatives without an entry do not count.
    Fn : float, optional
        Froude number of the result; needed where the table has several. Between two of them the
        derivatives are interpolated linearly.

    Returns
    -------
    DataFrame
        `derivative_budget` grouped by test: a row per test type (the noise of its runs and what
        each draws for itself: offset, gain, the setting of the drift angle) and per source that
        all runs share (such as a gauge), with the number of runs, the standard deviation of the
        result by it alone, and its share of the variance, the largest first. The shares sum to 1.

    Raises
    ------
    DataError
        If no derivative with a slope was determined.
    """
    budget, known = measured_budget(reduction), reduction.solution.Fn
    weights = _weights(known, Fn)
    carry = np.zeros((len(budget.results), 1))
    for place, item in enumerate(budget.results):
        weight = weights[0] if len(known) == 1 else weights[known == item.Fn][0]
        if math.isfinite(item.value):
            carry[place] = weight * slopes.get(item.name, 0.0)
    result = Result(name="", value=math.nan)
    carried = budget.carried(carry, [result], budget.subject).by_test()
    if not carried.std[0] > 0.0:
        raise DataError("None of these derivatives was determined with an uncertainty.")
    runs, every = _runs(reduction, weights), len(reduction.rows)
    frame = carried.to_pandas().set_index("source")
    frame["runs"] = [runs[item.title] if item.drawn else every for item in carried.sources]
    kept = frame.loc[frame["runs"] > 0, ["runs", "std", "share"]]
    return kept.sort_values("share", ascending=False)


def _runs(reduction: Reduction, weights: Array) -> Counter[str]:
    """How many runs of each kind of test count at a Froude number."""
    groups = reduction.solution.groups
    return Counter(
        reduction.rows[run].result.run.test
        for weight, runs in zip(weights.tolist(), groups, strict=True)
        for run in runs
        if weight > 0.0
    )


def _weights(known: Array, Fn: float | None) -> Array:
    """Share of each group of runs in the derivatives at a Froude number."""
    if len(known) == 1:
        return np.ones(1)
    if Fn is None:
        raise DataError("The table has several Froude numbers: say which.")
    place = np.interp(Fn, known, np.arange(len(known)))
    return np.maximum(0.0, 1.0 - np.abs(np.arange(len(known)) - place))
