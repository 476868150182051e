"""How large the forces are that nothing explains."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Final

import numpy as np

from pmmkit.base import DataError
from pmmkit.diagnosis.free_running.information import Forces, Information, WindowInformation
from pmmkit.identification import FreeRecord
from pmmkit.models import Model
from pmmkit.numerics import Array

FLOOR: Final = 0.001
"""Unknown forces below this share of the rms force of a channel do not matter."""
MEMORIES: Final = (0.5, 1.5, 5.0)
"""Times over which they may hang together, in ship lengths over the speed."""
FACTORS: Final = (10.0, 4.0, 2.0, 1.4)
"""By which their sizes are varied, round by round."""
MOST: Final = 0.3
"""None is larger, over ½ρLdU² and ½ρL²dU²."""


def most_likely(
    information: Information,
    value: Callable[[WindowInformation], float],
    least: Array,
    begin: Forces | None = None,
    factors: Sequence[float] = FACTORS,
) -> tuple[Forces, float]:
    """Unknown forces of the size and memory that make records most probable, and how probable.

    least (f,).
    """
    told: dict[tuple[bytes, float], float] = {}  # a quarter is asked again

    def probability(forces: Forces) -> float:
        key = (forces.shares.tobytes(), forces.memory)
        if key not in told:
            told[key] = value(information.under(forces))
        return told[key]

    made = begin or Forces(shares=np.maximum(0.01, least), memory=MEMORIES[1])
    known = probability(made)
    for factor in factors:
        for i in range(len(least)):
            for f in (1.0 / factor, factor):
                while True:
                    shares = made.shares.copy()
                    shares[i] = min(max(shares[i] * f, least[i]), MOST)
                    if shares[i] == made.shares[i]:
                        break
                    other = Forces(shares=shares, memory=made.memory)
                    found = probability(other)
                    if found <= known:
                        break
                    made, known = other, found
        for memory in MEMORIES:
            if memory == made.memory:
                continue
            # Size and memory trade with each other: varied one by one they get stuck.
            root = math.sqrt(made.memory / memory)
            for scale in (1.0, root, 1.0 / root):
                shares = np.clip(scale * made.shares, least, MOST)
                other = Forces(shares=shares, memory=memory)
                found = probability(other)
                if found > known:
                    made, known = other, found
    return made, known


def usual_forces(model: Model, records: Sequence[FreeRecord]) -> Array:
    """Root mean square of the force of each channel over its unit, from rates of the heading.

    Surge force of the resistance, side force of m u r, moment of the inertia in a change of the
    yaw rate over a ship length; of roll that of the side force on a lever of a tenth of the
    draught.
    """
    words = ("X", "Y", "N", "K") if model.rolls else ("X", "Y", "N")
    squares = []
    for record in records:
        ship, unit = model.ship, record.force_units(model)
        pace = record.speed / ship.L
        rate = record.measured.get("r")
        if rate is None and "psi" in record.measured:
            rate = np.gradient(record.measured["psi"], record.t)
        if rate is None:
            raise DataError(f"Record {record.name!r} holds neither heading nor yaw rate.")
        r = rate[np.isfinite(rate)]
        size = math.sqrt(float(np.mean(r**2))) if len(r) else 0.0
        motion = {
            "u": np.array([record.speed]),
            "v": np.zeros(1),
            "r": np.array([size]),
            "udot": np.array([0.05 * record.speed * pace]),
            "vdot": np.zeros(1),
            "rdot": np.array([size * pace]),
        }
        force = ship.rigid_body_forces(motion)
        sizes = {name: abs(float(force[name][0])) for name in ("X", "Y", "N")}
        sizes["K"] = 0.1 * ship.d * sizes["Y"]
        squares.append(np.array([sizes[word] / unit[word] for word in words]) ** 2)
    shares: Array = np.maximum(np.sqrt(np.mean(squares, axis=0)), 1e-3)
    return shares
