"""A hull polynomial summed monomial by monomial, as an oracle for what the kernel writes out."""

from __future__ import annotations

import math

from pmmkit.equations.structure import FACTOR_PLACES, polynomial


def polynomial_forces(values, motion, *, ship, water, convention, approach):
    """X, Y, N, K of derivatives at one motion (u, v, r, p, phi, delta)."""
    u, v, r, p, phi, delta = motion
    bis = convention.system == "bis"
    U = math.hypot(u, v) if convention.U == "instantaneous" else approach
    reference = math.sqrt(water.g * ship.L) if bis else U
    lost = approach if convention.surge == "delta-u" else 0.0
    primed = {
        "u": (u - lost) / reference,
        "v": v / reference,
        "r": r * ship.L / reference,
        "p": p * ship.L / reference,
        "phi": phi,
        "d": delta,
    }
    primed |= {f"|{name}|": abs(value) for name, value in primed.items()}
    sums = dict.fromkeys("XYNK", 0.0)
    for places, numbers in polynomial(values, ship=ship, water=water, convention=convention):
        product = 1.0 if bis else reference**2
        for place in places:
            product *= primed[FACTOR_PLACES[place]]
        for channel, number in numbers.items():
            sums[channel] += number * product
    return tuple(sums[channel] for channel in "XYNK")
