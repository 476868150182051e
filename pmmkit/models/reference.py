"""Derivatives of models as tables, and published ones to stand beside those of tests."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from pmmkit.base import TableError, UnknownNameError
from pmmkit.conventions import Ship, parse_derivative
from pmmkit.effects import HULL, INERTIA
from pmmkit.models.library import load_ship, ships
from pmmkit.models.model import Model
from pmmkit.models.store import load_model
from pmmkit.models.tables.compare import compare
from pmmkit.models.tables.io import is_table, read_table
from pmmkit.models.tables.table import DerivativeTable, from_values

ALIKE: Final = 0.005
"""Share by which the proportions of two models of one ship may differ."""


def hull_table(model: Model | str | Path) -> DerivativeTable:
    """The derivatives of a model's hull and added mass as a table, e.g. to compare with.

    Parameters
    ----------
    model : Model, str or path
        A model, a library name or a model file.

    Returns
    -------
    DerivativeTable
        In the convention of the model, without uncertainty.

    Examples
    --------
    >>> hull_table("s175-3dof").at()["Nvvr"]
    -0.0424
    """
    loaded = model if isinstance(model, Model) else load_model(model)
    values: dict[str, float | Sequence[float]] = {}
    for effect in (HULL, INERTIA):
        given = loaded.parts[effect].values if effect in loaded.parts else {}
        values |= {name: value for name, value in given.items() if _named(name)}
    return from_values(
        values,
        ship=loaded.ship,
        water=loaded.water,
        Fn=loaded.Fn or None,
        convention=loaded.convention,
        method=f"model {loaded.name}",
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class ReferenceTable:
    """Derivatives of a source that stand beside those of tests.

    Parameters
    ----------
    table : DerivativeTable
        Its values, in any convention.
    name : str
        Its name in tables and figures.
    model : Model or None
        The model that they are of, if they can sail.
    """

    table: DerivativeTable
    name: str
    model: Model | None = None

    @classmethod
    def of(cls, given: str, name: str = "") -> ReferenceTable:
        """The derivatives of a library ship, a model file or a table, told by its ending.

        Parameters
        ----------
        given : str
            Name or path.
        name : str
            Its name in tables and figures; that of the ship or file where empty.

        Examples
        --------
        >>> ReferenceTable.of("s175-3dof", "Son and Nomoto 1981").table.at()["Nvvr"]
        -0.0424
        """
        if is_table(given):
            return cls(table=read_table(given), name=name or Path(given).stem)
        model = load_model(given)
        return cls(table=hull_table(model), name=name or given, model=model)

    @classmethod
    def published(cls, table: DerivativeTable) -> ReferenceTable | None:
        """Published derivatives of the ship that was tested, where the library holds it.

        Parameters
        ----------
        table : DerivativeTable
            Of the tests.

        Returns
        -------
        Reference or None
            Of the library ship with the proportions of the tested one at any scale, the smallest
            model of it.
        """
        found = [load_model(name) for name in ships() if _alike(load_ship(name), table.ship)]
        for model in sorted(found, key=lambda model: (model.rolls, len(model.parts))):
            source = model.parts[HULL].source.removeprefix("library: ")
            known = cls(table=hull_table(model), name=source, model=model)
            try:
                compare(table, known.table)
            except TableError:
                continue
            return known
        return None


def _alike(ship: Ship, other: Ship) -> bool:
    """Whether two ships have the same proportions."""
    pairs = zip(_proportions(ship), _proportions(other), strict=True)
    return all(abs(a / b - 1.0) < ALIKE for a, b in pairs)


def _proportions(ship: Ship) -> tuple[float, float, float]:
    return ship.L / ship.B, ship.B / ship.d, ship.block


def _named(name: str) -> bool:
    try:
        parse_derivative(name)
    except UnknownNameError:
        return False
    return True
