"""Files of a tank that knows nothing of us: its own names of columns, and runs by number."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from small_campaign import forces

ANSWERS = {
    "ship.L": "4.861111",
    "ship.B": "0,705556",
    "ship.d": ".236111",
    "ship.mass": "454.476",
    "ship.Izz": "618.332",
    "water.rho": "999.1",
}
"""What its files do not say, as people type it."""
DRIFTS = (-8.0, 0.0, 8.0)


def write_files(folder: Path) -> list[Path]:
    """Static drift at 1 m/s; the carriage starts in 4 s."""
    folder.mkdir(parents=True, exist_ok=True)
    generator = np.random.default_rng(2)
    t = np.arange(0.0, 30.0, 0.1)
    still, ramp = np.zeros_like(t), np.clip(t / 4.0, 0.0, 1.0)
    found = []
    for number, drift in enumerate(DRIFTS, start=1):
        beta = math.radians(drift)
        motion = {"u": still + math.cos(beta), "v": still - math.sin(beta), "r": still}
        own = forces(**motion, udot=still, vdot=still, rdot=still)
        columns = {
            "Time [s]": t,
            "Carriage speed (m/s)": ramp,
            "drift deg": still + drift,
            "Fx (N)": ramp**2 * own["X"] + 0.4 * generator.normal(size=t.size),
            "Fy (N)": ramp**2 * own["Y"] + generator.normal(size=t.size),
            "Mz (Nm)": ramp**2 * own["N"] + 1.5 * generator.normal(size=t.size),
        }
        found.append(folder / f"run{number:03d}.csv")
        table = np.stack(list(columns.values()), axis=1)
        head = ",".join(columns)
        np.savetxt(found[-1], table, fmt="%.6g", delimiter=",", header=head, comments="")
    return found
