"""The hull without any hidden effect, and the tools that sources of force are built from."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from scipy.signal import lfilter, lfilter_zi

from .motion import Array, Motion
from .sizes import ROLL, SHIP, WATER

Force = dict[str, Array]
"""X, Y, N of the water on the hull about midship [N, N m]; channels without force are left out."""

TRUTH: dict[str, float] = {
    "Xudot": -0.000238,
    "Xuu": -0.0004226,
    "Xvv": -0.00386,
    "Xrr": 0.00020,
    "Xdd": -0.0014,
    "Yv": -0.0116,
    "Yr": 0.00242 - 0.000238,
    "Yvvv": -0.109,
    "Yrrr": 0.00177,
    "Yvdot": -0.007049,
    "Yrdot": -0.00035245,
    "Yd": -0.00298,
    "Nv": -0.0038545,
    "Nr": -0.00222,
    "Nvvv": 0.001492,
    "Nrrr": -0.00229,
    "Nvdot": -0.00035245,
    "Nrdot": -0.000419,
    "Nd": 0.00148,
}
"""Son and Nomoto's (1981) S175 as a PMM measures it (Yr - mx), without coupling terms.

The rudder's three are a straight-ahead tangent of Son and Nomoto's rudder force with the propeller
at the model's self-propulsion point, rounded.
"""
BASE = tuple(name for name in TRUTH if not name.endswith("d"))
"""The derivatives from which a diagnosis of the tank starts: the rudder brings its own."""


def hull_force(m: Motion) -> Force:
    """Force of the water with `TRUTH`, instantaneous speed, every term by hand."""
    c = TRUTH
    v, r, d = m.vp, m.rp, m.delta
    X = c["Xudot"] * m.ud + c["Xuu"] * m.up**2 + c["Xvv"] * v**2 + c["Xrr"] * r**2 + c["Xdd"] * d**2
    Y, N = (
        c[f"{a}v"] * v
        + c[f"{a}r"] * r
        + c[f"{a}vvv"] * v**3
        + c[f"{a}rrr"] * r**3
        + c[f"{a}vdot"] * m.vd
        + c[f"{a}rdot"] * m.rd
        + c[f"{a}d"] * d
        for a in "YN"
    )
    return {"X": m.q * X, "Y": m.q * Y, "N": m.q * SHIP.L * N}


def prime(m: Motion, **channels: Array | float) -> Force:
    """Forces given in the prime system, in newtons."""
    return {
        name: m.q * (SHIP.L if name == "N" else 1.0) * value for name, value in channels.items()
    }


def add(*forces: Mapping[str, Array]) -> Force:
    """The sum of forces, channel by channel."""
    total: Force = {}
    for force in forces:
        for name, values in force.items():
            total[name] = total[name] + values if name in total else values
    return total


def times(factor: float, force: Mapping[str, Array]) -> Force:
    """A force made larger."""
    return {name: factor * values for name, values in force.items()}


def along(force: Callable[[Motion], Force], m: Motion, other: Motion, step: float = 1e-2) -> Force:
    """First-order change of a force from one motion to another: what a catalogue's fault is."""
    ahead, back = force(m.moved(other, step)), force(m.moved(other, -step))
    return {name: (ahead[name] - back[name]) / (2 * step) for name in ahead}


def one_pole(x: Array, dt: float, lag: float) -> Array:
    """First-order lag, exact for an input that is straight between samples; settled at the start.

    Source: y' = (x - y)/T solved over one step with a first-order hold.
    """
    if lag <= 0:
        return np.array(x)
    ratio = dt / lag
    fade = np.exp(-ratio)
    new = 1 - (1 - fade) / ratio
    old = (1 - fade) / ratio - fade
    y, _ = lfilter([new, old], [1.0, -fade], x, zi=[fade * x[0] + old * x[0]])
    return y


def heel(m: Motion) -> Array:
    """Heel [rad] from the roll equation integrated in time by the trapezoidal rule.

    φ'' + 2ζω0 φ' + ω0² φ = ω0² K/(ρ g V GM); the moment K is that of the side force of the
    hull about the tow point, K = -lever·Y.
    """
    moment = -ROLL["lever"] * hull_force(m)["Y"]
    target = moment / (WATER.rho * WATER.g * SHIP.volume * ROLL["GM"])
    w, z, k = ROLL["resonance"], ROLL["damping"], 2 / m.dt
    numerator = w**2 * np.array([1.0, 2.0, 1.0])
    denominator = np.array(
        [k**2 + 2 * z * w * k + w**2, 2 * w**2 - 2 * k**2, k**2 - 2 * z * w * k + w**2]
    )
    b, a = numerator / denominator[0], denominator / denominator[0]
    phi, _ = lfilter(b, a, target, zi=lfilter_zi(b, a) * target[0])
    return phi


def stations(first: float = -0.5, last: float = 0.5, count: int = 24) -> tuple[Array, Array]:
    """Places x/L and weights of a Gauss-Legendre strip integral over part of the hull."""
    x, w = np.polynomial.legendre.leggauss(count)
    return first + (last - first) * (x + 1) / 2, w * (last - first) / 2
