"""Zigzags of the 7 m model of KVLCC2 as a tank would record them, with noise and a wrong rudder."""

import math

import numpy as np

import pmmkit as pk
from tests.support.recorded import recorded

SPEED = 1.179
SHIP = pk.load_model("kvlcc2-l7")
SENSORS = {"x": 0.02, "y": 0.02, "psi": math.radians(0.1), "r": math.radians(0.05), "u": 0.006}
KNOWN = ("Xuu", "Yv", "Yr", "Nv", "Nr", "Nvvr", "rudder_mmg.epsilon")
"""Values of which the tests say how well they are known."""
ASYMMETRY = SHIP.with_values("hull_polynomial", Y0=0.0022, N0=-0.001)
RUNS = ((20.0, 20.0), (-10.0, 10.0), (25.0, 5.0))
"""Rudder and heading of reversal [deg]."""


def sailed(model, seed, *, zero=0.0, runs=RUNS):
    """Zigzags with noise; the rudder column shows less than there is by `zero`."""
    rng = np.random.default_rng(seed)
    found = []
    for number, (rudder, switch) in enumerate(runs):
        track = pk.simulate(
            model, "zigzag", rudder_deg=rudder, switch_deg=switch, speed=SPEED, dt=0.5
        )
        record = recorded(track, SENSORS, rng, name=f"zigzag {number}", speed=SPEED, zero=zero)
        found.append(record.cut(0.0, 75.0))
    return found
