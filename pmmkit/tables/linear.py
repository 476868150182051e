"""Linear maps of a table: values, covariance, degrees of freedom and origin together."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from pmmkit.conventions import Derivative, parse_derivative
from pmmkit.numerics import Array
from pmmkit.tables.table import DerivativeTable

Expansion = Callable[[Derivative], Mapping[str, float | Array]]


def mapped(
    table: DerivativeTable, weights: Array, *, names: Sequence[str], Fn: Array
) -> DerivativeTable:
    """The table whose values are linear combinations of another's.

    Parameters
    ----------
    table : DerivativeTable
        A table with k Froude numbers and n derivatives.
    weights : array (K, m, k, n)
        What each new value takes of each old one.
    names : sequence of str
        The m derivatives of the new table.
    Fn : array (K,)
        Its Froude numbers.

    Returns
    -------
    DerivativeTable
        Covariance J C Jᵀ. What depends on an unknown (NaN) entry is unknown, nothing else. The
        degrees of freedom and the runs of a combination are the smallest of its parts.
    """
    K, m, k, n = weights.shape
    J = weights.reshape(K * m, k * n)
    uses = J != 0
    covariance = table.covariance.reshape(k * n, k * n)
    unknown = np.isnan(covariance)
    result = J @ np.where(unknown, 0.0, covariance) @ J.T
    touched = uses.astype(float) @ unknown.astype(float) @ uses.T.astype(float) > 0
    value = table.value.ravel()
    missing = np.isnan(value)
    values = np.where(uses @ missing, np.nan, J @ np.where(missing, 0.0, value))
    exact = np.diagonal(covariance) == 0
    dof = np.where(uses & ~exact, table.dof.ravel(), np.inf).min(axis=1, initial=np.inf)
    runs = np.where(uses, table.runs.ravel(), np.iinfo(np.int64).max).min(axis=1)
    return table.with_(
        names=tuple(names),
        Fn=np.asarray(Fn, float),
        value=values.reshape(K, m),
        covariance=np.where(touched, np.nan, result).reshape(K, m, K, m),
        dof=dof.reshape(K, m),
        method=_methods(uses, table.method.ravel()).reshape(K, m),
        runs=np.where(uses.any(axis=1), runs, 0).reshape(K, m),
    )


def rewritten(table: DerivativeTable, expand: Expansion) -> DerivativeTable:
    """The table after each derivative was written as a sum of others.

    Parameters
    ----------
    table : DerivativeTable
        What to rewrite.
    expand : callable
        For a derivative of the table, the derivatives it goes to and with which factor (a number,
        or one per Froude number).
    """
    k = len(table.Fn)
    sums = [expand(parse_derivative(name)) for name in table.names]
    names = tuple(dict.fromkeys([*table.names, *(name for parts in sums for name in parts)]))
    weights = np.zeros((k, len(names), k, len(table.names)))
    rows = np.arange(k)
    for column, parts in enumerate(sums):
        for name, factor in parts.items():
            weights[rows, names.index(name), rows, column] += factor
    return mapped(table, weights, names=names, Fn=table.Fn)


def _methods(uses: NDArray[np.bool_], method: NDArray[np.str_]) -> NDArray[np.str_]:
    """How each combination was found: the methods of its parts, each once."""
    return np.array([" + ".join(dict.fromkeys(method[row].tolist())) for row in uses], np.str_)
