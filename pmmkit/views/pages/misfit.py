"""Where a model fails: the runs as a map, and the sentences above it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from pmmkit.campaigns import RUN_SETTINGS, TEST_KINDS, Run
from pmmkit.validation import Comparison
from pmmkit.views.pages.numbers import short


def misfit_page(comparison: Comparison) -> dict[str, Any]:
    """The map of runs, grouped by kind of test, and what stands out."""
    runs = {item.view.run.id: item.view.run for item in comparison.captive}
    runs |= {item.name: item.run for item in comparison.free}
    rows = comparison.rows()
    columns: dict[str, str] = {}
    groups: dict[str, dict[str, dict[str, Any]]] = {}
    for row in rows:
        columns[row["channel"]] = row["unit"]
        group = groups.setdefault(row["test"], {})
        own = group.setdefault(row["run"], _row(row["run"], runs[row["run"]]))
        own["cells"][row["channel"]] = {
            name: short(row[name]) for name in (*comparison.statistics, "ratio")
        } | {"within": row["within"]}
    leading, more = comparison.leading()
    every = [
        cell for own in groups.values() for row in own.values() for cell in row["cells"].values()
    ]
    return {
        "kind": comparison.kind,
        "model": comparison.model,
        "statistics": [
            {"name": name, "title": title} for name, title in comparison.statistics.items()
        ],
        "columns": [{"name": name, "unit": unit} for name, unit in columns.items()],
        "groups": [
            {"test": test, "title": TEST_KINDS[test].title, "rows": _sorted(list(own.values()))}
            for test, own in groups.items()
        ],
        "sentences": [asdict(item) for item in leading],
        "more": more,
        "within": sum(cell["within"] for cell in every),
        "cells": len(every),
        "notes": list(comparison.notes),
    }


def _row(name: str, run: Run) -> dict[str, Any]:
    return {
        "run": name,
        "words": run.setting,
        "speed": short(run.settings.speed),
        "order": _order(run),
        "cells": {},
    }


def _order(run: Run) -> list[float]:
    """By speed, then by what the run was set to."""
    s = run.settings
    swings = (s.yaw_amplitude or 0.0, s.amplitude or 0.0, s.rudder_amplitude or 0.0)
    more = (s.value(item.name) or 0.0 for item in RUN_SETTINGS.brought)
    return [s.speed, s.drift, s.heel, s.rudder, *swings, s.period or 0.0, *more]


def _sorted(rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    ordered = sorted(rows, key=lambda row: (np.round(row["order"], 6).tolist(), row["run"]))
    return [{name: x for name, x in row.items() if name != "order"} for row in ordered]
