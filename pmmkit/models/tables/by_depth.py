"""Derivatives over the depth of the water: a table at each, and what lies between them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar, Final

import numpy as np

from pmmkit.base import ExtrapolationError, Problem, TableError
from pmmkit.models.tables.interpolate import SAME, interpolate
from pmmkit.models.tables.table import DerivativeTable
from pmmkit.numerics import Array

if TYPE_CHECKING:
    import pandas as pd

SPEEDS_APART: Final = 0.01
"""Share by which Froude numbers of two depths differ and are still one, as for runs of one."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TablesByDepth:
    """Derivatives of one ship at several depths of the water.

    Parameters
    ----------
    tables : tuple of DerivativeTable
        One for each depth, the deepest first; each states it (`water.depth`).

    Raises
    ------
    TableError
        If there is no table, a depth is not stated or stands twice, or their draughts or the
        meanings of their numbers differ.
    """

    RATIO: ClassVar = "h_T"
    """Column of the depth over the draught."""
    NEARLY: ClassVar = 0.99
    """Share of the least depth of the formulas of shallow water from which they are taken as
    there: a basin is filled to a millimetre or two."""

    tables: tuple[DerivativeTable, ...]

    def __post_init__(self) -> None:
        wrong = []
        if not self.tables:
            wrong.append("There is no table.")
        elif any(table.water.depth is None for table in self.tables):
            wrong.append("A table does not state the depth of its water.")
        elif not np.all(np.diff(self.ratios) < 0):
            wrong.append("Depths must stand once each, the deepest first.")
        if len({table.convention for table in self.tables}) > 1:
            wrong.append("Their numbers have different meanings (convention).")
        if len({table.ship.d for table in self.tables}) > 1:
            wrong.append("They are of different draughts.")
        if wrong:
            raise TableError(wrong, title="Not tables of one ship over the depth")

    @property
    def ratios(self) -> Array:
        """Depth of the water over the draught at each table, array (k,), the largest first."""
        return np.array([(table.water.depth or np.nan) / table.ship.d for table in self.tables])

    def at(self, ratio: float) -> DerivativeTable:
        """The derivatives at a depth between those of the tables.

        Straight lines over the draught over the depth, of which the laws of shallow water are
        functions; a Froude number of one table alone is interpolated in the other. Errors at two
        depths are taken as independent.

        Parameters
        ----------
        ratio : float
            Depth of the water over the draught.

        Returns
        -------
        DerivativeTable
            In water of that depth. Derivatives that one of the two tables lacks are left out, and
            a note says so; where one of them is not usable, neither is the result.

        Raises
        ------
        ExtrapolationError
            If the depth, or every Froude number of both, lies outside.

        Examples
        --------
        >>> from pmmkit.conventions import Ship, Water
        >>> from pmmkit.models.tables.table import from_values
        >>> ship = Ship(name="m", L=4.0, B=1.0, d=.25, volume=.5, mass=500., Izz=500.)
        >>> deep, shallow = (from_values({"Yv": [x]}, Fn=[.1], ship=ship, water=Water(depth=h))
        ...                  for x, h in ((-.01, .5), (-.02, .3125)))
        >>> found = TablesByDepth(tables=(deep, shallow)).at(1 / .65)
        >>> found["Yv"].round(12), round(found.water.depth, 4)
        (array([-0.015]), 0.3846)
        """
        above, share = place_of(ratio, self.ratios)
        if share == 0.0:
            return self.tables[above]
        return _between(self.tables[above], self.tables[above + 1], share, ratio)

    def in_step(self, shallow: DerivativeTable) -> tuple[DerivativeTable, DerivativeTable]:
        """The table of the deepest water and another, at the Froude numbers of both.

        Parameters
        ----------
        shallow : DerivativeTable
            One of the others.

        Raises
        ------
        TableError, ExtrapolationError
            If one is pooled over all speeds and the other is not, or they share no speed.
        """
        return _in_step(self.tables[0], shallow)

    def to_pandas(self) -> pd.DataFrame:
        """The rows of all tables, the depth over the draught before each."""
        import pandas as pd

        parts = [table.to_pandas() for table in self.tables]
        for ratio, part in zip(self.ratios.tolist(), parts, strict=True):
            part.insert(0, self.RATIO, ratio)
        return pd.concat(parts, ignore_index=True)


def place_of(ratio: float, known: Array) -> tuple[int, float]:
    """Where a depth lies among others: the deeper neighbour, and how far it is to the next one.

    known (k,).

    Examples
    --------
    >>> place_of(1.6, np.array([4.0, 2.0, 1.25])), place_of(2.0, np.array([4.0, 2.0, 1.25]))
    ((1, 0.41666666666666663), (1, 0.0))
    """
    same = np.flatnonzero(np.isclose(known, ratio, rtol=SAME, atol=0))
    if len(same):
        return int(same[0]), 0.0
    if len(known) == 0 or not known[-1] < ratio < known[0]:
        ends = f"{known[-1]:.4g} to {known[0]:.4g}" if len(known) > 1 else "no two depths"
        raise ExtrapolationError(
            Problem(
                message=f"A depth of {ratio:.4g} draughts is outside of the tests, which hold "
                f"{ends}.",
                remedy="Measure there, or choose a depth between theirs.",
            )
        )
    above = int(np.flatnonzero(known > ratio)[-1])
    share = (1 / ratio - 1 / known[above]) / (1 / known[above + 1] - 1 / known[above])
    return above, float(share)


def _between(
    deep: DerivativeTable, shallow: DerivativeTable, share: float, ratio: float
) -> DerivativeTable:
    """A share of the way from one table to another in less water."""
    names = [name for name in deep.names if name in shallow.names]
    lost = sorted({*deep.names, *shallow.names} - {*names})
    if not names:
        raise TableError("The tables at two depths have no derivative in common.")
    ends = [table.select(names) for table in (deep, shallow)]
    one, other = _in_step(*ends)
    weights = (1.0 - share, share)
    depths = [f"{(table.water.depth or 0.0) / table.ship.d:.4g}" for table in (deep, shallow)]
    notes = [f"Between the tables at {depths[0]} and {depths[1]} draughts of water."]
    if lost:
        notes.append(f"Left out, known at one of the two depths alone: {', '.join(lost)}.")
    worse = next((x for x in (deep, shallow) if x.verdict and x.verdict.faults), deep)
    origin = {**deep.provenance, "between_depths": depths}
    return one.with_(
        value=weights[0] * one.value + weights[1] * other.value,
        covariance=weights[0] ** 2 * one.covariance + weights[1] ** 2 * other.covariance,
        dof=np.minimum(one.dof, other.dof),
        method=np.where(one.method == other.method, one.method, "between depths"),
        runs=np.minimum(one.runs, other.runs),
        water=replace(deep.water, depth=ratio * deep.ship.d),
        notes=tuple(dict.fromkeys((*notes, *deep.notes, *shallow.notes))),
        provenance=MappingProxyType(
            origin | {k: x for k, x in worse.provenance.items() if k == "verdict"}
        ),
    )


def _in_step(
    one: DerivativeTable, other: DerivativeTable
) -> tuple[DerivativeTable, DerivativeTable]:
    """Two tables at the same Froude numbers: those of both, within the range of both."""
    if one.pooled != other.pooled:
        raise TableError("One table is pooled over all speeds, the other is not.")
    if one.pooled:
        return one, other
    low = max(one.Fn[0], other.Fn[0]) * (1 - SAME)
    high = min(one.Fn[-1], other.Fn[-1]) * (1 + SAME)
    rows: list[float] = []
    for Fn in sorted({*one.Fn.tolist(), *other.Fn.tolist()}):
        if low <= Fn <= high and not (rows and Fn <= rows[-1] * (1 + SPEEDS_APART)):
            rows.append(Fn)
    if not rows:
        raise ExtrapolationError("The tables at two depths have no Froude number in common.")
    place = np.array(rows)
    return interpolate(_held(one, place), place), interpolate(_held(other, place), place)


def _held(table: DerivativeTable, rows: Array) -> DerivativeTable:
    """The table with its own Froude numbers where they are as good as those that are asked for."""
    near = np.argmin(np.abs(table.Fn[:, None] - rows), axis=1)
    same = np.abs(table.Fn / rows[near] - 1) <= SPEEDS_APART
    return table.with_(Fn=np.where(same, rows[near], table.Fn))
