"""Published derivatives to stand beside those of tests."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Final

from pmmkit.base import TableError
from pmmkit.conventions import Ship
from pmmkit.effects import HULL
from pmmkit.models.hull import hull_table
from pmmkit.models.library import load_ship, ships
from pmmkit.models.model import Model
from pmmkit.models.store import load_model
from pmmkit.models.tables.compare import compare
from pmmkit.models.tables.io import is_table, read_table
from pmmkit.models.tables.table import DerivativeTable

ALIKE: Final = 0.005
"""Share by which the proportions of two models of one ship may differ."""


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


def reference_of(given: str, name: str = "") -> ReferenceTable:
    """The derivatives of a library ship, a model file or a table, told by its ending.

    Parameters
    ----------
    given : str
        Name or path.
    name : str
        Its name in tables and figures; that of the ship or file where empty.

    Examples
    --------
    >>> reference_of("s175-3dof", "Son and Nomoto 1981").table.at()["Nvvr"]
    -0.0424
    """
    if is_table(given):
        return ReferenceTable(table=read_table(given), name=name or Path(given).stem)
    model = load_model(given)
    return ReferenceTable(table=hull_table(model), name=name or given, model=model)


def published_of(table: DerivativeTable) -> ReferenceTable | None:
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
        known = ReferenceTable(table=hull_table(model), name=source, model=model)
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
