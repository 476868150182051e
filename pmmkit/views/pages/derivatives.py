"""The derivatives of a campaign: intervals, families of tests, what determines and trades."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from pmmkit.base import TableError
from pmmkit.models import DerivativeTable, ReferenceTable, compare
from pmmkit.numerics import Array
from pmmkit.presentation import plus_minus
from pmmkit.reduction import Reduction
from pmmkit.views.figures.derivatives import correlated
from pmmkit.views.pages.numbers import short

TOLD: Final = 6
"""Runs and derivatives that are told of each."""
TRADES: Final = 0.3
"""Correlation from which two derivatives are said to trade with each other."""


def derivatives_page(reduction: Reduction, beside: ReferenceTable | None = None) -> dict[str, Any]:
    """A reduction as the page shows it."""
    table = reduction.table
    reference = beside or ReferenceTable.published(table)
    published = _published(table, reference.table) if reference else {}
    moved, trades = _moved(reduction), _trades(table)
    families = reduction.families
    low, high = table.interval()
    return {
        "speeds": table.speeds,
        "Fn": short(table.Fn),
        "factor": table.factor,
        "system": table.convention.system,
        "about": table.grid().caption,
        "structure": str(table.provenance.get("structure", "")),
        "reference": reference.name if reference else "",
        "notes": list(table.notes),
        "verdict": str(reduction.verdict),
        "use": reduction.verdict.use,
        "reasons": list(reduction.verdict.reasons),
        "rows": [
            {
                "name": name,
                "values": [
                    _value(table.value, low, high, k, i)
                    | {"told": _told(table, low[k, i], high[k, i], k, i)}
                    for k in range(len(table.Fn))
                ],
                "published": [short(x) for x in published.get(name, [])],
                "families": [
                    {"title": title, "values": _of_family(table, own, name)}
                    for title, own in families.items()
                    if name in own
                ],
                "runs": moved.get(name, []),
                "trades": trades.get(name, []),
                "count": int(np.max(table.runs[:, i])) if np.ndim(table.runs) == 2 else None,
            }
            for i, name in enumerate(table.names)
        ],
    }


def _value(values: Array, low: Array, high: Array, k: int, i: int) -> dict[str, Any]:
    return {"value": short(values[k, i]), "low": short(low[k, i]), "high": short(high[k, i])}


def _told(table: DerivativeTable, low: float, high: float, k: int, i: int) -> str | None:
    """A value with half of its interval; None where it is not determined."""
    value = table.factor * float(table.value[k, i])
    return plus_minus(value, table.factor * (high - low) / 2) or None


def _of_family(
    table: DerivativeTable, own: DerivativeTable, name: str
) -> list[dict[str, Any] | None]:
    """Its values at the speeds of the table."""
    low, high = own.interval()
    found: list[dict[str, Any] | None] = []
    for Fn in table.Fn:
        near = np.flatnonzero(np.isclose(own.Fn, Fn, rtol=1e-3, equal_nan=True))
        place = int(near[0]) if len(near) else None
        if place is None or not np.isfinite(own.value[place, own.index(name)]):
            found.append(None)
            continue
        found.append(_value(own.value, low, high, place, own.index(name)))
    return found


def _published(table: DerivativeTable, reference: DerivativeTable) -> Mapping[str, list[float]]:
    try:
        beside = compare(table, reference)
    except TableError:
        return {}
    found: dict[str, list[float]] = {}
    for name, value in zip(beside["derivative"], beside["reference"], strict=True):
        found.setdefault(str(name), []).append(float(value))
    return found


def _moved(reduction: Reduction) -> dict[str, list[dict[str, Any]]]:
    """The runs that determine each derivative: without one it would move by so much."""
    found: dict[str, list[dict[str, Any]]] = {}
    for item in reduction.influences.items:
        for name, share in zip(item.names, item.share.tolist(), strict=True):
            if np.isfinite(share):
                found.setdefault(name, []).append({"run": item.run, "share": short(share)})
    return {
        name: sorted(own, key=lambda item: -abs(item["share"]))[:TOLD]
        for name, own in found.items()
    }


def _trades(table: DerivativeTable) -> dict[str, list[dict[str, Any]]]:
    try:
        names, matrix = correlated(table)
    except TableError:
        return {}
    found = {}
    for i, name in enumerate(names):
        order = np.argsort(-np.abs(matrix[i]))
        found[name] = [
            {"name": names[j], "correlation": short(matrix[i, j])}
            for j in order[: TOLD + 1].tolist()
            if j != i and abs(matrix[i, j]) >= TRADES
        ]
    return found
