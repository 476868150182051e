"""What stands beside our derivatives in a report."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from pmmkit.models import Model, load_model
from pmmkit.models.hull import hull_table
from pmmkit.tables import DerivativeTable, is_table, read_table


@dataclass(frozen=True, kw_only=True, eq=False)
class Reference:
    """Derivatives of a source that stand beside ours.

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


def reference_of(given: str, name: str = "") -> Reference:
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
        return Reference(table=read_table(given), name=name or Path(given).stem)
    model = load_model(given)
    return Reference(table=hull_table(model), name=name or given, model=model)
