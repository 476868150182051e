"""One free-running record, measured and sailed by the model with the measured rudder."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np

from pmmkit.campaigns import TEST_KINDS
from pmmkit.conventions import CHANNEL_UNITS
from pmmkit.numerics import Array
from pmmkit.validation import Comparison, FreeRun
from pmmkit.views.pages.history import history_page
from pmmkit.views.pages.numbers import BUCKETS, short

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
