"""Which derivatives a programme of tests tells apart: their correlation."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.base import TableError
from pmmkit.conventions import CHANNELS
from pmmkit.models import DerivativeTable
from pmmkit.numerics import Array
from pmmkit.plotting import INK, canvas, styled
from pmmkit.presentation import counted

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_TOLD: Final = 0.5
"""Correlation from which on the number stands in its cell."""
_CELL: Final = 0.27
"""Side of a cell [inch]."""


def correlated(table: DerivativeTable, Fn: float | None = None) -> tuple[list[str], Array]:
    """Correlation of the derivatives at one Froude number, by channel: X, Y, N, K.

    Examples
    --------
    >>> from pmmkit.conventions import Ship, Water
    >>> from pmmkit.models import from_values
    >>> ship = Ship(name="m", L=4.0, B=1.0, d=.25, volume=.5, mass=500., Izz=500.)
    >>> table = from_values({"Nv": -.004, "Yv": -.01}, std={"Nv": 1e-4, "Yv": 1e-4},
    ...                     ship=ship, water=Water())
    >>> correlated(table)
    (['Yv', 'Nv'], array([[1., 0.],
           [0., 1.]]))
    """
    row = _row(table, Fn)
    order = sorted(range(len(table.names)), key=lambda i: CHANNELS.index(table.names[i][0]))
    kept = [i for i in order if table.std[row, i] > 0]
    if len(kept) < 2:
        raise TableError("Fewer than two derivatives have an uncertainty: nothing is correlated.")
    own = table.covariance[row, kept][:, row, kept]
    std = table.std[row, kept]
    return [table.names[i] for i in kept], np.clip(own / np.outer(std, std), -1.0, 1.0)


def _row(table: DerivativeTable, Fn: float | None) -> int:
    if Fn is None:
        known = (table.std > 0).sum(axis=1)
        best = np.flatnonzero(known == known.max())
        return int(best[len(best) // 2])
    near = np.flatnonzero(np.isclose(table.Fn, Fn, rtol=1e-3, atol=0) | table.pooled)
    if not len(near):
        raise TableError(f"Fn {Fn:g} is no row of the table: {', '.join(map(str, table.Fn))}.")
    return int(near[0])


def correlations(table: DerivativeTable, Fn: float | None = None) -> Figure:
    """The correlation matrix of the derivatives, in blocks of X, Y, N and K."""
    names, matrix = correlated(table, Fn)
    size = len(names)
    with styled():
        figure = canvas(_CELL * size + 1.3, max(5.0, _CELL * size + 2.0))
        axis = figure.subplots()
        picture = axis.imshow(matrix, cmap="RdBu_r", vmin=-1.0, vmax=1.0)
        axis.grid(visible=False)
        symbols = [f"${table.convention.latex(name)}$" for name in names]
        axis.set_xticks(range(size), symbols, rotation=90)
        axis.set_yticks(range(size), symbols)
        axis.spines[:].set_visible(False)
        axis.tick_params(length=0)
        for place, (one, other) in enumerate(itertools.pairwise(names)):
            if one[0] != other[0]:
                axis.axhline(place + 0.5, color=INK, lw=1.0)
                axis.axvline(place + 0.5, color=INK, lw=1.0)
        _numbers(axis, matrix)
        bar = figure.colorbar(picture, ax=axis, shrink=0.6, aspect=30)
        bar.set_label("correlation [-]; in the cells in hundredths")
        froude = table.Fn[_row(table, Fn)]
        axis.set_title("all speeds" if table.pooled else f"Fn {froude:.3f}")
    return figure


def strongest(names: Sequence[str], matrix: Array, most: int = 3) -> list[str]:
    """The strongest correlations in a sentence.

    matrix (n, n).

    Examples
    --------
    >>> strongest(["Yv", "Yvvv"], np.array([[1.0, -0.93], [-0.93, 1.0]]))
    ['Strongest correlations: Yv and Yvvv -0.93; 1 pair of 1 beyond 0.5.']
    """
    rows, columns = np.triu_indices(len(names), 1)
    values = matrix[rows, columns]
    order = np.argsort(-np.abs(values), kind="stable")[:most]
    told = [f"{names[rows[i]]} and {names[columns[i]]} {values[i]:+.2f}" for i in order.tolist()]
    beyond = counted(int(np.count_nonzero(np.abs(values) >= _TOLD)), "pair")
    return [f"Strongest correlations: {', '.join(told)}; {beyond} of {len(values)} beyond {_TOLD}."]


def _numbers(axis: Axes, matrix: Array) -> None:
    for row, column in np.argwhere(np.abs(matrix) >= _TOLD).tolist():
        if row != column:
            value = matrix[row, column]
            axis.text(
                column,
                row,
                f"{100 * value:+.0f}",
                ha="center",
                va="center",
                fontsize=6.5,
                color="white" if abs(value) > 0.7 else INK,
            )
