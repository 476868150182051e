"""What a test was set to, from the motion that was measured where nobody states it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from pmmkit.campaigns.run_settings import RUN_SETTINGS, setting_key
from pmmkit.campaigns.test_kinds.registry import TEST_KINDS
from pmmkit.numerics import Array

_PERIOD: Final = ("period", "frequency_hz")


def speed_measured(values: Mapping[str, Any]) -> dict[str, float]:
    """The speed through the water from u and v, where u is there.

    Examples
    --------
    >>> speed_measured({"u": 0.6, "v": -0.8, "Y": 3.0}), speed_measured({"Y": 3.0})
    ({'speed': 1.0}, {})
    """
    if "u" not in values:
        return {}
    return {"speed": float(np.mean(np.hypot(values["u"], values.get("v", 0.0))))}


def settings_measured(
    test: str, values: Mapping[str, Array], stated: Mapping[str, Any]
) -> tuple[dict[str, float], tuple[str, ...]]:
    """Speed, period and amplitudes of one cycle that was sampled evenly, and whence they are.

    The angular frequency is the root mean square of a velocity over that of its displacement,
    both without their means.

    Examples
    --------
    >>> phase = np.arange(24) * 2 * np.pi / 24
    >>> sway = {"u": np.full(24, 0.6), "y": 0.2 * np.sin(phase), "v": 0.1 * np.cos(phase)}
    >>> found, notes = settings_measured("pure_sway", sway, {"speed": 0.6})
    >>> {key: round(value, 3) for key, value in found.items()}, notes
    ({'period': 12.566, 'amplitude_m': 0.2}, ('period from v over y',))
    """
    found = {} if "speed" in stated else speed_measured(values)
    notes: tuple[str, ...] = ("speed from u and v",) if found else ()
    for swing in TEST_KINDS[test].swings:
        size = _rms(values, swing.displacement)
        rate = _rms(values, swing.velocity)
        if not size:
            continue
        key = setting_key(swing.amplitude)
        if key not in stated:
            found[key] = RUN_SETTINGS[swing.amplitude].to_file(math.sqrt(2.0) * size)  # of a sine
        if rate and not {*_PERIOD} & {*stated, *found}:
            found["period"] = 2 * math.pi * size / rate
            notes = (*notes, f"period from {swing.velocity} over {swing.displacement}")
    return {key: found[key] for key in ("speed", "period", *found) if key in found}, notes


def _rms(values: Mapping[str, Array], name: str) -> float:
    """Root mean square of a channel about its mean; zero where it is not there."""
    return float(np.std(values[name])) if name in values else 0.0
