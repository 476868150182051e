"""One run of captive tests, measured and modelled: over time, over the cycle, over the motion."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from pmmkit.campaigns import TEST_KINDS, Rig
from pmmkit.conventions import CHANNEL_UNITS
from pmmkit.numerics import Array
from pmmkit.validation import CaptiveRun, Comparison
from pmmkit.views.pages.numbers import BUCKETS, short, thinned

MOTIONS: Final = {"v": "m/s", "r": "rad/s", "u": "m/s", "phi": "rad"}
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
        "motion": {
            key: {"unit": MOTIONS[key], "values": short(x[kept])} for key, x in motion.items()
        },
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
    for name in MOTIONS:
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
