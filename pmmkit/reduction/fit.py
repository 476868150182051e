"""Weighted least squares by pivoted QR, and what the data do and do not determine."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pmmkit.numerics import Array

ROUNDING = 1e-14
"""Columns shorter than this share of the longest are zeros that were rounded."""
RANK_TOLERANCE = 1e-9
"""Scaled columns whose remainder after the others is below this count as dependent."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Fit:
    """A linear fit ``rows ≈ design @ value``.

    Parameters
    ----------
    names : tuple of str
        The p coefficients.
    value : array (p,)
        NaN for a coefficient that the rows do not determine.
    gain : array (p, m)
        The linear map from the rows to the values (zero rows where undetermined).
    determined : array of bool (p,)
        Which coefficients the rows determine.
    condition : float
        Condition number of the design with columns scaled to length one.
    inflation : array (p,)
        Variance inflation: 1 if no other column resembles it.
    tied : tuple of tuple of str
        Groups of coefficients of which only combinations are determined.
    """

    names: tuple[str, ...]
    value: Array
    gain: Array
    determined: NDArray[np.bool_]
    condition: float
    inflation: Array
    tied: tuple[tuple[str, ...], ...]


def fit(names: Sequence[str], design: Array, rows: Array) -> Fit:
    """Solve least squares with scaled columns by pivoted QR.

    Parameters
    ----------
    names : sequence of str (p,)
        The coefficients.
    design : array (m, p)
        What each coefficient multiplies in each row, divided by the row's standard deviation.
    rows : array (m,)
        The data, divided alike.

    Returns
    -------
    Fit
        A coefficient is determined if no combination of columns that vanishes contains it.

    Notes
    -----
    Columns are scaled to length one before the factorisation (Businger and Golub 1965), so that
    the rank decision does not depend on units.

    Examples
    --------
    >>> v = np.array([-.2, -.1, .1, .2])
    >>> found = fit(["Yv", "Yvvv", "Yr"], np.stack([v, v**3, 0 * v], 1), -v - 2 * v**3)
    >>> found.value
    array([-1., -2., nan])
    """
    from scipy.linalg import qr

    size, count = design.shape
    length = np.linalg.norm(design, axis=0)
    excited = length > ROUNDING * length.max(initial=0.0)
    scale = np.where(excited, length, 1.0)
    columns = np.flatnonzero(excited)
    gain = np.zeros((count, size))
    inflation = np.full(count, np.nan)
    determined = np.zeros(count, dtype=bool)
    condition = 1.0
    tied: tuple[tuple[str, ...], ...] = ()
    if len(columns):
        scaled = design[:, columns] / scale[columns]
        q, triangle, order = qr(scaled, mode="economic", pivoting=True, check_finite=False)
        diagonal = np.abs(np.diagonal(triangle))
        rank = int(np.sum(diagonal > RANK_TOLERANCE * diagonal[0]))
        basic = columns[order[:rank]]
        inverse = np.linalg.inv(triangle[:rank, :rank])
        gain[basic] = (inverse / scale[basic][:, None]) @ q[:, :rank].T
        inflation[basic] = np.sum(inverse**2, axis=1)
        condition = float(np.linalg.cond(scaled[:, order[:rank]]))
        null = np.zeros((len(columns), len(columns) - rank))
        null[order[:rank]] = -inverse @ triangle[:rank, rank:]
        null[order[rank:]] = np.eye(len(columns) - rank)
        involved = np.abs(null) > 1e-6
        determined[columns] = ~involved.any(axis=1)
        tied = _groups(involved, [names[column] for column in columns.tolist()])
    gain[~determined] = 0.0
    value = gain @ rows
    value[~determined] = np.nan
    inflation[~determined] = np.nan
    return Fit(
        names=tuple(names),
        value=value,
        gain=gain,
        determined=determined,
        condition=condition,
        inflation=inflation,
        tied=tied,
    )


def _groups(involved: NDArray[np.bool_], names: Sequence[str]) -> tuple[tuple[str, ...], ...]:
    """Connected groups of names that share a vanishing combination."""
    groups: list[set[str]] = []
    for combination in involved.T:
        members = {name for name, inside in zip(names, combination, strict=True) if inside}
        apart = [group for group in groups if not group & members]
        groups = [*apart, members.union(*(group for group in groups if group & members))]
    return tuple(tuple(name for name in names if name in group) for group in groups)


def optional_columns(
    required: Array, candidates: Sequence[str], columns: Array, *, limit: float = 100.0
) -> list[int]:
    """Which optional columns can be added without spoiling what the others determine.

    Parameters
    ----------
    required : array (m, p)
        Weighted columns that are asked for.
    candidates : sequence of str (q,)
        Names of the optional columns, in order of preference.
    columns : array (m, q)
        The optional columns, weighted alike.
    limit : float
        A column is left out if its variance inflation would exceed this.

    Returns
    -------
    list of int
        Indices of the columns that can be added.
    """
    kept: list[int] = []
    base = required[:, np.linalg.norm(required, axis=0) > 0]
    for index in range(len(candidates)):
        column = columns[:, index]
        length = np.linalg.norm(column)
        if length == 0:
            continue
        others = np.column_stack([base, *(columns[:, other] for other in kept)])
        if others.shape[1]:
            unit = others / np.linalg.norm(others, axis=0)
            solution, *_ = np.linalg.lstsq(unit, column / length, rcond=1e-10)
            remainder = np.linalg.norm(column / length - unit @ solution)
            if remainder**2 * limit < 1.0:
                continue
        kept.append(index)
    return kept
