"""The methods of reduction."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from pmmkit.base import Registry
from pmmkit.reduction.methods.harmonics import by_harmonics
from pmmkit.reduction.methods.kalman import by_filter
from pmmkit.reduction.methods.method import Estimate, Method, MethodInputs
from pmmkit.reduction.methods.sparse import by_sparse_regression

ALL: Final = "all"
"""What asks for every method."""


def by_regression(evidence: MethodInputs) -> Estimate:
    """The global regression that every method starts from."""
    return Estimate(method="global regression", table=evidence.table)


METHODS: Final = Registry(
    Method,
    lambda: (
        Method(
            name="regression",
            text="All runs of a Froude number together, weighted by noise and scatter.",
            estimate=by_regression,
        ),
        Method(
            name="harmonics",
            text="Each derivative from the tests made for it, by curve fits and Fourier "
            "coefficients.",
            estimate=by_harmonics,
        ),
        Method(
            name="sindy",
            text="Terms chosen among a library by pysindy on the histories, in bags of runs.",
            estimate=by_sparse_regression,
            over_time=True,
        ),
        Method(
            name="ekf",
            text="A Kalman filter through the histories with the derivatives as states.",
            estimate=by_filter,
            over_time=True,
        ),
    ),
    what="method",
    unknown=f"There is no method {{name!r}}; there are: {{names}}, {ALL}.",
)
"""By name; the first is the default and the basis of the others."""


def methods_of(choice: str) -> tuple[Method, ...]:
    """The methods that a choice stands for, the basis first.

    Examples
    --------
    >>> [method.name for method in methods_of("ekf")]
    ['regression', 'ekf']
    """
    if choice == ALL:
        return tuple(METHODS.values())
    asked = METHODS[choice]
    return tuple(dict.fromkeys((next(iter(METHODS.values())), asked)))


def estimates(methods: Sequence[Method], evidence: MethodInputs) -> dict[str, Estimate]:
    """What each method makes of the runs, with the seconds it took."""
    found = {}
    for method in methods:
        started = time.perf_counter()
        estimate = method.estimate(evidence)
        found[method.name] = replace(estimate, seconds=time.perf_counter() - started)
    return found
