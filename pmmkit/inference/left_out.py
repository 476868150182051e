"""What a fit to all other rows makes of some: leave one block out, of one factorisation."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.numerics import Array

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
