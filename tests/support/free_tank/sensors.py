"""What instruments write of a run: their faults first, then white noise."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from scipy.interpolate import CubicSpline

from .flow import relative_wind
from .hidden import Hidden
from .sailing import Sailed

COLUMNS = ("t", "x", "y", "psi", "u", "v", "r", "phi", "delta", "n", "wind_speed", "wind_direction")


def recorded(
    run: Sailed, hidden: Hidden, noise: Mapping[str, float], every: int, rng: np.random.Generator
) -> dict[str, np.ndarray]:
    """Columns of a record, every so many steps; those of the wind where there is one.

    Velocities are those through the water at midship.
    """
    own = run.motion
    true = {name: own[name] for name in ("psi", "r", "phi")}
    for name, along in (("x", np.cos(own["psi"])), ("y", np.sin(own["psi"]))):
        antenna = CubicSpline(run.t, own[name] + hidden.antenna * along)
        true[name] = antenna(run.t - hidden.late_positions)
    true["psi"] = own["psi"] + hidden.heading_offset
    true |= {name: own[name] * (1.0 + hidden.log_gain) for name in ("u", "v")}
    true["delta"] = run.delta
    if run.order.wind_speed:
        blows = np.array([[run.order.wind_speed], [run.order.wind_from]])
        true["wind_speed"], true["wind_direction"] = relative_wind(run.now(), blows)
    seen = {
        name: true[name][::every] + noise[name] * rng.standard_normal(len(run.t[::every]))
        for name in COLUMNS
        if name in true and name in noise
    }
    seen |= {"t": run.t[::every], "n": np.full(len(run.t[::every]), run.n)}
    return {name: seen[name] for name in COLUMNS if name in seen}


def fault_coefficients(hidden: Hidden) -> dict[str, dict[str, float]]:
    """What is hidden in the instruments, as coefficients of the faults of the same form."""
    return {
        "fault_rudder_zero": {"angle": math.degrees(hidden.rudder_zero)},
        "fault_clock_lag": {"clock_lag": hidden.late_positions},
        "fault_antenna": {"antenna_x": hidden.antenna, "antenna_y": 0.0},
        "fault_heading_offset": {"heading_offset": math.degrees(hidden.heading_offset)},
        "fault_log": {"log_gain": hidden.log_gain},
    }
