"""Runs measured and modelled: the map of all, a record that runs free, a captive run."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any, Final

import numpy as np

from pmmkit.campaigns import RUN_SETTINGS, TEST_KINDS, Rig, Run
from pmmkit.conventions import CHANNEL_UNITS
from pmmkit.numerics import Array
from pmmkit.validation import CaptiveRun, Comparison, FreeRun
from pmmkit.views.pages.numbers import BUCKETS, short, thinned

# One run of captive tests, measured and modelled: over time, over the cycle, over the motion.


OVER: Final = {"v": "m/s", "r": "rad/s", "u": "m/s", "phi": "rad"}
"""Motions over which forces are drawn."""


def history_page(comparison: Comparison, name: str, buckets: int = BUCKETS) -> dict[str, Any]:
    """What is drawn of one captive run."""
    item = next((x for x in comparison.captive if x.view.run.id == name), None)
    if item is None:
        raise KeyError(name)
    view, run = item.view, item.view.run
    t, measured, predicted = _histories(item, comparison.rig)
    motion = _motion(item, comparison.ship.L)
    theta = _phase(item)
    kept = thinned({**measured, **{f"m{key}": x for key, x in predicted.items()}}, buckets)
    return {
        "run": run.id,
        "test": run.test,
        "title": TEST_KINDS[run.test].title,
        "words": run.setting,
        "source": run.source,
        "steady": not view.omega,
        "labels": list(view.labels),
        "channels": {
            channel: {
                "unit": CHANNEL_UNITS[channel],
                "measured": short(view.force[channel]),
                "predicted": short(item.predicted[channel]),
                "uncertainty": short(item.uncertainty(channel)),
                "known": view.known(channel),
            }
            for channel in item.channels
        },
        "t": short(t[kept]),
        "theta": [] if theta is None else short(theta[kept]),
        "measured": {channel: short(x[kept]) for channel, x in measured.items()},
        "predicted": {channel: short(x[kept]) for channel, x in predicted.items()},
        "motion": {key: {"unit": OVER[key], "values": short(x[kept])} for key, x in motion.items()},
        "family": _family(comparison, item),
    }


def _histories(
    item: CaptiveRun, rig: Rig
) -> tuple[Array, Mapping[str, Array], Mapping[str, Array]]:
    """Instants, measured and predicted forces; a row of a table has no measured history."""
    if item.view.run.kind != "history":
        return item.view.instants, {}, {name: item.history[name] for name in item.channels}
    columns = item.residual(rig)
    return (
        columns["t"],
        {name: columns[f"{name}_measured"] for name in item.channels},
        {name: columns[f"{name}_predicted"] for name in item.channels},
    )


def _phase(item: CaptiveRun) -> Array | None:
    """The phase θ of the oscillation at the samples [rad]; None of a steady run."""
    view = item.view
    if not view.omega or "C1" not in view.labels or "S1" not in view.labels:
        return None
    basis = view.basis
    # Columns of all harmonics: C0, C1, S1 …; a projection undoes these cosines and sines exactly.
    return np.asarray(np.mod(np.arctan2(basis[:, 2], basis[:, 1]), 2 * np.pi), float)


def _motion(item: CaptiveRun, length: float) -> dict[str, Array]:
    """Motions that vary in the run, the largest first."""
    found, size = {}, {}
    view = item.view
    # What turns counts by the speed at the ends of the ship, beside what moves it sideways.
    weight = {"r": 0.5 * length, "phi": view.speed}
    for name in OVER:
        values = np.asarray(getattr(view.motion, name), float)
        if view.omega and values.shape == view.t.shape and np.ptp(values) > 1e-9:
            found[name], size[name] = values, weight.get(name, 1.0) * float(np.ptp(values))
    return {name: found[name] for name in sorted(found, key=lambda own: -size[own])}


def _family(comparison: Comparison, item: CaptiveRun) -> dict[str, Any]:
    """The means of all steady runs of this test and speed, over what they vary."""
    view = item.view
    if view.omega:
        return {}
    alike = [
        other
        for other in comparison.captive
        if other.view.run.test == view.run.test
        and not other.view.omega
        and abs(other.view.speed - view.speed) < 1e-3
    ]
    axes = {
        "drift": [float(np.degrees(x.view.run.settings.drift)) for x in alike],
        "heel": [float(np.degrees(x.view.run.settings.heel)) for x in alike],
        "rudder": [float(np.degrees(x.view.run.settings.rudder)) for x in alike],
        "yaw_rate": [float(np.degrees(np.mean(x.view.motion.r))) for x in alike],
    }
    over = max(axes, key=lambda name: float(np.ptp(axes[name])))
    if len(alike) < 2 or float(np.ptp(axes[over])) < 1e-9:
        return {}
    order = np.argsort(axes[over], kind="stable")
    ordered = [alike[i] for i in order]
    return {
        "over": over,
        "unit": "°/s" if over == "yaw_rate" else "°",
        "at": short(np.array(axes[over])[order]),
        "runs": [x.view.run.id for x in ordered],
        "channels": {
            channel: {
                "measured": [short(_first(x.view.force.get(channel))) for x in ordered],
                "predicted": [short(_first(x.predicted.get(channel))) for x in ordered],
                "uncertainty": [
                    short(_first(x.uncertainty(channel) if channel in x.channels else None))
                    for x in ordered
                ],
            }
            for channel in item.channels
        },
    }


def _first(values: Array | None) -> float:
    return float("nan") if values is None or not len(values) else float(values[0])


# Where a model fails: the runs as a map, and the sentences above it.


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


DEGREES: Final = math.degrees(1.0)
MOTIONS: Final = {
    "x": ("m", 1.0),
    "y": ("m", 1.0),
    "psi": ("deg", DEGREES),
    "u": ("m/s", 1.0),
    "v": ("m/s", 1.0),
    "r": ("deg/s", DEGREES),
}
"""Motions with their units on the screen, and what SI values are told times."""
WILD: Final = 5.0
"""Times the greatest measured speed from which a motion has left what a model describes."""
SAMPLES: Final = 500
"""Of a record on the screen."""


def record_page(record: FreeRun, length: float, floor: float) -> dict[str, Any]:
    """What is drawn of a record."""
    sailed = np.where(_describes(record), 1.0, np.nan)
    judged = record.errors(floor)
    kept = np.unique(np.linspace(0, len(record.t) - 1, SAMPLES).round().astype(int))

    def told(values: Array, name: str) -> list[float]:
        factor = 1.0 / length if name in ("x", "y") else MOTIONS[name][1]
        found: list[float] = short(factor * values[kept])
        return found

    return {
        "kind": "free",
        "run": record.name,
        "test": record.run.test,
        "title": TEST_KINDS[record.run.test].title,
        "words": record.run.setting,
        "source": record.run.source,
        "t": short(record.t[kept]),
        "delta": short(DEGREES * record.delta[kept]),
        "motion": {
            name: {
                "unit": "L" if name in ("x", "y") else unit,
                "measured": told(record.measured[name], name),
                "predicted": told(sailed * record.predicted[name], name),
                "uncertainty": told(sailed * record.doubt(name), name),
            }
            for name, (unit, _) in MOTIONS.items()
        },
        "forces": {
            name: {
                "unit": CHANNEL_UNITS[name],
                "measured": short(force[kept]),
                "predicted": short(record.force_predicted[name][kept]),
                "uncertainty": short(judged[name].uncertainty[kept]),
            }
            for name, force in record.force.items()
        },
    }


def _describes(record: FreeRun) -> Array:
    """Whether each sample comes before a motion that grows without bound."""
    most = WILD * np.nanmax(np.hypot(record.measured["u"], record.measured["v"]))
    u, v = record.predicted["u"], record.predicted["v"]
    calm: Array = np.logical_and.accumulate((np.abs(u) < most) & (np.abs(v) < most))
    return calm


# One run of any kind, measured and modelled.


def run_page(comparison: Comparison, name: str, buckets: int = BUCKETS) -> dict[str, Any]:
    """What is drawn of one run: of captive tests (see `history_page`) or of a record that runs free
    (see `record_page`).
    """
    for record in comparison.free:
        if record.name == name:
            return record_page(record, comparison.ship.L, comparison.floor)
    return history_page(comparison, name, buckets)
