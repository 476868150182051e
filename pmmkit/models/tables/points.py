"""Derivatives about another point: moments and motions referred elsewhere on the ship."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import TableError
from pmmkit.conventions import Derivative, parse_derivative
from pmmkit.models.tables.table import DerivativeTable
from pmmkit.numerics import Array

# Linear maps of a table: values, covariance, degrees of freedom and origin together.


Expansion = Callable[[Derivative], Mapping[str, float | Array]]


def mapped(
    table: DerivativeTable, weights: Array, *, names: Sequence[str], Fn: Array
) -> DerivativeTable:
    """The table whose values are linear combinations of another's.

    weights (K, m, k, n); Fn (K,).
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
    """The table after each derivative was written as a sum of others."""
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


NOT_MOVED: Final = "The table is not converted"


def moved(table: DerivativeTable, *, moment: float, motion: float) -> DerivativeTable:
    """The table with moments and motions referred to other points.

    moment, motion [m].

    Notes
    -----
    With Δ the step forward over L, the moment becomes N - Δ Y, exactly and term by term. Motions:
    v = v_new - Δ r and v̇ = v̇_new - Δ ṙ are put into every term. The instantaneous speed changes
    too, U² = U_new² (1 - 2 Δ v r + Δ² r²): terms whose power of speed is not 2 gain terms two
    orders higher in v and r. They are kept up to the highest order that the table has in surge and
    in the other channels; with carriage U and in bis there are none. There and back gives the
    same numbers.
    """
    L = table.ship.L
    convention = table.convention
    if not math.isfinite(L):
        raise TableError("The ship's length is not known.", title=NOT_MOVED)
    step = (motion - convention.motion_reference_x) / L
    if step:
        table = _motion(table, step)
    step = (moment - convention.moment_reference_x) / L
    if step:
        table = _moment(table, step)
    return table.with_(
        convention=convention.with_(moment_reference_x=moment, motion_reference_x=motion)
    )


def _moment(table: DerivativeTable, step: float) -> DerivativeTable:
    def expand(derivative: Derivative) -> Mapping[str, float]:
        own = {derivative.name: 1.0}
        if derivative.channel == "Y":
            own[f"N{derivative.term}"] = -step
        return own

    return rewritten(table, expand)


def _motion(table: DerivativeTable, step: float) -> DerivativeTable:
    parsed = [parse_derivative(name) for name in table.names]
    closed = [derivative.name for derivative in parsed if "|v|" in derivative.factors]
    if closed:
        raise TableError(
            f"{', '.join(closed)}: |v| at one point is |v - x r| at another, which is no sum of "
            f"such terms. Reduce the runs again with motions referred to the point you need.",
            title=NOT_MOVED,
        )
    highest: dict[bool, int] = defaultdict(int)
    for derivative in parsed:
        surge = derivative.channel == "X"
        highest[surge] = max(highest[surge], _order(derivative))
    varying = table.convention.U == "instantaneous" and table.convention.system != "bis"

    def expand(derivative: Derivative) -> Mapping[str, float]:
        exponent = (2 - derivative.speed_power) / 2 if varying else 0.0
        room = highest[derivative.channel == "X"] - _order(derivative)
        rest = tuple(factor for factor in derivative.factors if factor not in ("v", "vdot"))
        sums: dict[str, float] = defaultdict(float)
        for first, rates in _shifted(derivative.factors.count("v"), "v", "r", step):
            for second, accelerations in _shifted(
                derivative.factors.count("vdot"), "vdot", "rdot", step
            ):
                for third, gained in _speed_ratio(exponent, room, step):
                    new = (*rates, *accelerations, *gained)
                    kept = tuple(factor for factor in rest if factor != "0" or not new)
                    name = parse_derivative(derivative.channel + "".join((*kept, *new))).name
                    sums[name] += first * second * third
        return sums

    return rewritten(table, expand)


def _order(derivative: Derivative) -> int:
    """Order of a term in v and r."""
    return sum(factor.strip("|") in ("v", "r") for factor in derivative.factors)


def _shifted(
    power: int, sway: str, yaw: str, step: float
) -> Iterator[tuple[float, tuple[str, ...]]]:
    """Terms of (sway - step yaw)**power."""
    for count in range(power + 1):
        yield math.comb(power, count) * (-step) ** count, (sway,) * (power - count) + (yaw,) * count


def _speed_ratio(
    exponent: float, room: int, step: float
) -> Iterator[tuple[float, tuple[str, ...]]]:
    """Terms of (1 - 2 step v r + step² r²)**exponent up to an order in v and r."""
    factor = 1.0
    for outer in range(room // 2 + 1):
        for inner in range(outer + 1):
            weight = math.comb(outer, inner) * (-2 * step) ** inner * step ** (2 * (outer - inner))
            if factor:
                yield factor * weight, ("v",) * inner + ("r",) * (2 * outer - inner)
        factor *= (exponent - outer) / (outer + 1)
