"""Which runs, tests and sources of uncertainty make the uncertainty of a result."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from pmmkit.campaigns.uncertainty import TypeB
from pmmkit.errors import DataError
from pmmkit.numerics import Array
from pmmkit.reduction.joint import with_their_causes

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
    standard deviation of a source: the sum that also makes the covariance of the table. Sources of
    one common cause each take half of what they have in common.
    """
    import pandas as pd

    solution = reduction.solution
    weight = _weights(solution.Fn, Fn)
    joint = solution.joint
    slope = np.array([weight[group] * slopes.get(name, 0.0) for group, name in joint.labels])
    slope[~np.isfinite(joint.value)] = 0.0
    by_test: dict[str, float] = defaultdict(float)
    runs_of: dict[str, set[int]] = defaultdict(set)
    start = 0
    for group, item in solution.fits:
        gradient = slope[start : start + len(item.fit.names)]
        start += len(gradient)
        if weight[group] == 0.0:
            continue
        for block, gain, noise in zip(
            item.blocks, item.pulls(), item.noise.covariances, strict=True
        ):
            run = solution.groups[group][block.run]
            test = reduction.rows[run].result.run.test
            pull = gradient @ gain
            by_test[test] += float(pull @ noise @ pull)
            runs_of[test].add(run)
    shared: dict[str, float] = defaultdict(float)
    for push, others in zip(joint.pushes, with_their_causes(joint.pushes), strict=True):
        variance = float(slope @ push.column) * float(slope @ others)
        if push.run is not None:
            by_test[reduction.rows[push.run].result.run.test] += variance
        elif isinstance(push.source, TypeB):
            shared[push.source.name] += variance
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
            "std": float(np.sqrt(max(variance, 0.0))),
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
