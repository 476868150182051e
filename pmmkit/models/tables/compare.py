"""Are two tables the same, and how far is one from another."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from pmmkit.base import TableError
from pmmkit.conventions import parse_derivative
from pmmkit.models.tables.convert import converted
from pmmkit.models.tables.interpolate import interpolate
from pmmkit.models.tables.table import DerivativeTable, from_values

if TYPE_CHECKING:
    import pandas as pd

Reference = DerivativeTable | Mapping[str, float | Sequence[float]]


def identical(first: DerivativeTable, second: DerivativeTable) -> bool:
    """Whether two tables hold the same, bit for bit; provenance is not looked at.

    Examples
    --------
    >>> from pmmkit.conventions import Ship, Water
    >>> from pmmkit.models.tables.table import from_values
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


def compare(
    table: DerivativeTable, reference: Reference, *, names: Sequence[str] | None = None
) -> pd.DataFrame:
    """A table beside reference values.

    Parameters
    ----------
    table : DerivativeTable
        The table in question.
    reference : DerivativeTable or mapping
        A table, which is converted to the convention of the first (reference points at the same
        share of the ship's length) and interpolated to its Froude numbers; or plain numbers in the
        first table's own convention, one each or one per Froude number.
    names : sequence of str, optional
        Which derivatives; those that both have where absent.

    Returns
    -------
    pandas.DataFrame
        A row per Froude number and derivative: Fn, derivative, value, std, ci_low, ci_high,
        reference, difference (value - reference), difference_std (over the standard uncertainty
        of the difference; that of the reference counts where it is known), difference_percent (of
        the reference's size), inside (whether the reference lies in the confidence interval).

    Raises
    ------
    TableError
        If the two have no derivative in common, or the reference cannot be converted.
    UnknownNameError
        If a name asked for is missing in one of them.

    Examples
    --------
    >>> from pmmkit.conventions import Ship, Water
    >>> ship = Ship(name="m", L=4.0, B=1.0, d=.25, volume=.5, mass=500., Izz=500.)
    >>> table = from_values({"Yv": -.0118, "Nv": -.004}, std={"Yv": .0001, "Nv": .0001},
    ...                     ship=ship, water=Water())
    >>> beside = compare(table, {"Yv": -.0116, "Nv": -.00385})
    >>> beside[["derivative", "difference_std", "inside"]]
      derivative  difference_std  inside
    0         Yv            -2.0   False
    1         Nv            -1.5    True
    """
    import pandas as pd

    if isinstance(reference, DerivativeTable):
        other = alike(table, reference)
    else:
        other = _from_numbers(table, reference)
    chosen = [
        parse_derivative(name).name
        for name in names or [name for name in table.names if name in other]
    ]
    if not chosen:
        raise TableError(
            f"No derivative in common: the table has {', '.join(table.names)}; the reference "
            f"{', '.join(other.names)}."
        )
    own, beside = table.select(chosen), other.select(chosen)
    frame = own.to_pandas().drop(columns=["method", "runs"])
    k = len(own.Fn)
    value = np.broadcast_to(beside.value, (k, len(chosen))).ravel()
    spread = np.nan_to_num(np.broadcast_to(beside.std, (k, len(chosen))).ravel())
    difference = own.value.ravel() - value
    with np.errstate(divide="ignore", invalid="ignore"):
        deviation = difference / np.hypot(own.std.ravel(), spread)
        percent = 100 * difference / np.abs(value)
    columns = {
        "reference": value,
        "difference": difference,
        "difference_std": deviation,
        "difference_percent": percent,
        "inside": (frame["ci_low"] <= value) & (value <= frame["ci_high"]),
    }
    return pd.concat([frame, pd.DataFrame(columns)], axis=1)


def alike(table: DerivativeTable, reference: DerivativeTable) -> DerivativeTable:
    """The reference in the convention and at the Froude numbers of the table."""
    scale = reference.ship.L / table.ship.L
    if not np.isfinite(scale):
        scale = 1.0
    target = table.convention
    other = converted(
        reference,
        target.with_(
            moment_reference_x=target.moment_reference_x * scale,
            motion_reference_x=target.motion_reference_x * scale,
        ),
    )
    if other.pooled:
        return other
    if table.pooled:
        raise TableError(
            "The table is pooled and the reference is per Froude number. Interpolate the "
            "reference to one Froude number, or compare with its row."
        )
    return interpolate(other, table.Fn)


def _from_numbers(
    table: DerivativeTable, reference: Mapping[str, float | Sequence[float]]
) -> DerivativeTable:
    k = len(table.Fn)
    wrong = [
        f"{name} has {np.size(number)} reference values; the table has {k} Froude numbers."
        for name, number in reference.items()
        if np.size(number) not in (1, k)
    ]
    if wrong:
        raise TableError(wrong, title="Not compared")
    return from_values(
        reference,
        ship=table.ship,
        water=table.water,
        Fn=None if table.pooled else [float(speed) for speed in table.Fn],
        convention=table.convention,
    )
