"""One free-running record, measured and sailed by the model with the measured rudder."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np

from pmmkit.campaigns.test_kinds.registry import kind_of
from pmmkit.numerics import Array
from pmmkit.validation.free_running import FORCE_UNITS, FreeRun
from pmmkit.workbench.pages.numbers import short

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
    """What is drawn of a record.

    Parameters
    ----------
    record : FreeRun
        From a comparison.
    length : float
        Of the ship [m]: the track is told in it.
    floor : float
        Of the comparison: share of the measured rms force that counts as uncertain.

    Returns
    -------
    dict
        ``kind`` is ``free``; ``t`` [s], ``delta`` [deg], and by motion and by channel of force
        unit, ``measured``, ``predicted`` and ``uncertainty``, by which the error is judged
        (`FreeRun.errors`), x and y in ship lengths; what is predicted ends where it leaves what a
        model describes. Forces are those that the water must have exerted by the smoothed motion,
        and what the model says along it.
    """
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
        "title": kind_of(record.run.test).title,
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
                "unit": FORCE_UNITS[name],
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
