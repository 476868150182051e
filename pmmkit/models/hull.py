"""The derivatives of a model as a table."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from pmmkit.base import UnknownNameError
from pmmkit.conventions import parse_derivative
from pmmkit.effects import HULL, INERTIA
from pmmkit.models.model import Model
from pmmkit.models.store import load_model
from pmmkit.models.tables.table import DerivativeTable, from_values


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


def _named(name: str) -> bool:
    try:
        parse_derivative(name)
    except UnknownNameError:
        return False
    return True
