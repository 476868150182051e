"""Are two tables the same, and how far is one from another."""

from __future__ import annotations

import numpy as np

from pmmkit.tables.table import DerivativeTable


def identical(first: DerivativeTable, second: DerivativeTable) -> bool:
    """Whether two tables hold the same, bit for bit; provenance is not looked at.

    Examples
    --------
    >>> from pmmkit.ship import Ship, Water
    >>> from pmmkit.tables import from_values
    >>> ship = Ship(name="m", L=4.0, B=1.0, d=.25, volume=.5, mass=500., Izz=500.)
    >>> table = from_values({"Yv": -.01}, ship=ship, water=Water())
    >>> identical(table, table.with_(value=table.value * 2))
    False
    """
    arrays = ("Fn", "value", "covariance", "dof")
    return (
        first.names == second.names
        and first.notes == second.notes
        and all(
            repr(getattr(first, part)) == repr(getattr(second, part))
            for part in ("convention", "ship", "water")
        )
        and all(
            np.array_equal(getattr(first, key), getattr(second, key), equal_nan=True)
            for key in arrays
        )
        and np.array_equal(first.method, second.method)
        and np.array_equal(first.runs, second.runs)
    )
