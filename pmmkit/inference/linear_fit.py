"""Least squares by QR of scaled columns, and what the data do and do not determine."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.numerics import Array

# What a fit to all other rows makes of some: leave one block out, of one factorisation.


ALONE: Final = 1e-6
"""Share of the variance of a direction among the rows that the fit to all leaves, below which the
others do not determine it: they predict it a thousand times worse than it is measured."""


def of_others(rows: Array, *, hat: bool = False) -> tuple[Array, NDArray[np.bool_]]:
    """What turns the residuals of blocks of rows into errors of predictions by all other rows.

    Parameters
    ----------
    rows : array (…, m, k)
        Rows S of an orthonormal basis of the columns that were fitted, by blocks.
    hat : bool
        Whether they are those of the hat matrix instead, in the columns of the block (m, m).

    Returns
    -------
    inverse : array (…, m, m)
        ``(1 - S S')⁻¹``; what the others do not determine is left out (a pseudo-inverse).
    determined : array of bool (…)
        Whether the others determine all of a block.

    Notes
    -----
    With the hat matrix ``H = Q Q'`` and residuals e of a fit to all rows, those of a fit without
    the rows k are ``(1 - H_kk)⁻¹ e_k`` (Cook and Weisberg 1982). A block of more rows than columns
    is inverted in the space of the columns (Woodbury).

    Examples
    --------
    A mean of four readings: without the last the mean of the others is 2, so its error is 3.

    >>> y = np.array([1.0, 2.0, 3.0, 5.0])
    >>> inverse, determined = of_others(np.full((1, 1), 0.5))
    >>> inverse @ (y - y.mean())[3:], bool(determined)
    (array([3.]), True)
    """
    m, k = rows.shape[-2:]
    turned = np.swapaxes(rows, -1, -2)
    if hat:
        return _inverted(np.eye(m) - 0.5 * (rows + turned))
    if m <= k:
        return _inverted(np.eye(m) - rows @ turned)
    # Along a lost direction 1 + S x S' shall be zero, where S has the length one: x = -1.
    inner, determined = _inverted(np.eye(k) - turned @ rows, lost=-1.0)
    return np.eye(m) + rows @ inner @ turned, determined


def _inverted(left: Array, lost: float = 0.0) -> tuple[Array, NDArray[np.bool_]]:
    """Inverse of symmetric arrays (…, m, m), and whether nothing was lost; there `lost` stands."""
    sizes, directions = np.linalg.eigh(left)
    known = sizes >= ALONE
    over = np.where(known, 1.0 / np.where(known, sizes, 1.0), lost)
    inverse = (directions * over[..., None, :]) @ np.swapaxes(directions, -1, -2)
    return np.asarray(inverse, float), np.asarray(known.all(axis=-1))


ROUNDING: Final = 1e-14
"""Columns shorter than this share of the longest are zeros that were rounded."""
RANK_TOLERANCE: Final = 1e-9
"""Columns of length one whose remainder after the others is below this count as dependent. Those
that are but for rounding have 4e-15 and less (one drift angle, two angles and three terms), the
nearest of real libraries 1e-2 (cubic and modulus terms of the S175 together, one yaw amplitude):
each tolerance from 1e-13 to 1e-3 tells them apart."""
INVOLVED: Final = 1e-6
"""Share of a combination that vanishes from which a column is part of it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LeastSquares:
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

    @classmethod
    def of(cls, names: Sequence[str], design: Array, rows: Array) -> LeastSquares:
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
        LeastSquares
            A coefficient is determined if no combination of columns that vanishes contains it.

        Notes
        -----
        Columns are scaled to length one before the factorisation (Businger and Golub 1965), so that
        the rank decision does not depend on units.

        Examples
        --------
        >>> v = np.array([-.2, -.1, .1, .2])
        >>> X = np.stack([v, v**3, 0 * v], axis=1)
        >>> found = LeastSquares.of(["Yv", "Yvvv", "Yr"], X, -v - 2 * v**3)
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
            rank = _rank(triangle)
            basic = columns[order[:rank]]
            inverse = np.linalg.inv(triangle[:rank, :rank])
            gain[basic] = (inverse / scale[basic][:, None]) @ q[:, :rank].T
            inflation[basic] = np.sum(inverse**2, axis=1)
            condition = float(np.linalg.cond(scaled[:, order[:rank]]))
            involved = np.zeros((len(columns), len(columns) - rank), dtype=bool)
            involved[order] = _vanishing(inverse @ triangle[:rank, rank:])
            determined[columns] = ~involved.any(axis=1)
            tied = _groups(involved, [names[column] for column in columns.tolist()])
        gain[~determined] = 0.0
        value = gain @ rows
        value[~determined] = np.nan
        inflation[~determined] = np.nan
        return cls(
            names=tuple(names),
            value=value,
            gain=gain,
            determined=determined,
            condition=condition,
            inflation=inflation,
            tied=tied,
        )


def dependent(triangle: Array) -> NDArray[np.bool_]:
    """Which scaled columns a triangle of a QR decomposition does not determine.

    Parameters
    ----------
    triangle : array (q, q)
        R of a QR decomposition of columns of length one.

    Returns
    -------
    array of bool (q,)
        All that share a combination which vanishes, not only the last of them.

    Examples
    --------
    >>> columns = np.array([[1.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]])
    >>> dependent(np.linalg.qr(columns, mode="r"))
    array([ True,  True, False])
    """
    from scipy.linalg import qr

    again, order = qr(triangle, mode="r", pivoting=True, check_finite=False)
    rank = _rank(again)
    along = np.linalg.solve(again[:rank, :rank], again[:rank, rank:])
    found = np.zeros(len(again), dtype=bool)
    found[order] = _vanishing(np.asarray(along, float)).any(axis=1)
    return found


def _rank(triangle: Array) -> int:
    """Of a triangle of scaled columns in the order of their pivots."""
    diagonal = np.abs(np.diagonal(triangle))
    return int(np.sum(diagonal > RANK_TOLERANCE * diagonal[0])) if len(diagonal) else 0


def _vanishing(along: Array) -> NDArray[np.bool_]:
    """Which columns take part in the combinations that vanish (b + r, r): r columns, which stand
    last, along the b that determine them."""
    return np.vstack([np.abs(along) > INVOLVED, np.eye(along.shape[1], dtype=bool)])


def _groups(involved: NDArray[np.bool_], names: Sequence[str]) -> tuple[tuple[str, ...], ...]:
    """Connected groups of names that share a vanishing combination."""
    groups: list[set[str]] = []
    for combination in involved.T:
        members = {name for name, inside in zip(names, combination, strict=True) if inside}
        apart = [group for group in groups if not group & members]
        groups = [*apart, members.union(*(group for group in groups if group & members))]
    return tuple(tuple(name for name in names if name in group) for group in groups)
