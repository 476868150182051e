"""Which runs, tests and sources of uncertainty make the uncertainty of a result."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from pmmkit.errors import DataError
from pmmkit.numerics import Array
from pmmkit.reduction.estimate import SETTING

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
        A row per test type (the noise of its runs and what each draws for itself: offset, gain, the
        setting of the drift angle) and per source that all runs share (such as a gauge), with the
        number of runs, the standard deviation of the result by it alone, and its share of the
        variance, the largest first. The shares sum to 1.

    Raises
    ------
    DataError
        If no derivative with a slope was determined.

    Notes
    -----
    The variance of g'θ is the sum over runs of g'Gᵢ Σᵢ Gᵢ'g and over sources of (g'p)², with Gᵢ
    the map from the rows of a run to the derivatives and p the change of the derivatives per
    standard deviation of a source: the sum that also makes the covariance of the table.
    """
    import pandas as pd

    solution = reduction.solution
    weight = _weights(solution.Fn, Fn)
    by_test: dict[str, float] = defaultdict(float)
    runs_of: dict[str, set[int]] = defaultdict(set)
    pushes: dict[tuple[str, int, int, str], float] = defaultdict(float)
    for group, item in solution.fits:
        if weight[group] == 0.0:
            continue
        there = np.isfinite(item.fit.value)
        gradient = (
            weight[group] * np.array([slopes.get(name, 0.0) for name in item.fit.names]) * there
        )
        values = item.values()
        pulls = item.pulls()
        for index, (block, gain) in enumerate(zip(item.blocks, item.gains(), strict=True)):
            run = solution.groups[group][block.run]
            test = reduction.rows[run].result.run.test
            pull = gradient @ pulls[index]
            by_test[test] += float(pull @ item.noise.covariances[index] @ pull)
            runs_of[test].add(run)
            for kind, column in enumerate(item.width.columns[index].T):
                own = "" if kind == SETTING else item.channel
                pushes["drawn", kind, run, own] += float(pull @ column)
            for number, change in enumerate(reduction.sensitivities[run]):
                if not change.source.shared and block.covariance is None:
                    continue
                shift = np.nan_to_num(change.residual(item.channel, values)[block.keep])
                if change.source.shared:
                    pushes["stated", number, -1, ""] += float(gradient @ gain @ shift)
                else:
                    pushes["stated", number, run, ""] += float(pull @ shift)
    shared: dict[str, float] = defaultdict(float)
    for (_, number, run, _), push in pushes.items():
        if run >= 0:
            by_test[reduction.rows[run].result.run.test] += push**2
        else:
            shared[reduction.sensitivities[0][number].source.name] += push**2
    total = sum(by_test.values()) + sum(shared.values())
    if not total > 0.0:
        raise DataError("None of these derivatives was determined with an uncertainty.")
    rows = [
        {
            "source": test,
            "runs": len(runs_of[test]),
            "std": variance**0.5,
            "share": variance / total,
        }
        for test, variance in by_test.items()
    ] + [
        {
            "source": name,
            "runs": len(reduction.rows),
            "std": variance**0.5,
            "share": variance / total,
        }
        for name, variance in shared.items()
    ]
    frame = pd.DataFrame(rows).set_index("source")
    return frame.sort_values("share", ascending=False)


def _weights(known: Array, Fn: float | None) -> Array:
    """Share of each group of runs in the derivatives at a Froude number."""
    if len(known) == 1:
        return np.ones(1)
    if Fn is None:
        raise DataError("The table has several Froude numbers: say which.")
    place = np.interp(Fn, known, np.arange(len(known)))
    return np.maximum(0.0, 1.0 - np.abs(np.arange(len(known)) - place))
