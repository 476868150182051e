"""What balance and logger make of the force: faults of the instruments, in newtons and seconds."""

from __future__ import annotations

import numpy as np

from .hull import Force, one_pole
from .motion import Array, Motion
from .outside import dead_zone
from .sizes import CHANNELS, SHIP, SIZES, STARTUP
from .sources import digital_filter

GAUGE_EFFECTS = (
    "fault_gauge_zero",
    "fault_time_lag",
    "fault_filter_lag",
    "fault_cross_talk",
    "fault_transient",
    "fault_gauge_drift",
    "fault_gauge_gain",
    "fault_moment_point",
    "fault_inertia",
    "outside_dead_zone",
)
DEAD_ZONE = 2.5
"""Half width of the dead zone at size 1 [N]."""


def inertia(m: Motion, mass: float = SHIP.mass, Izz: float = SHIP.Izz, x: float = 0.0) -> Force:
    """Mass times acceleration of a body about midship, its centre at x [m]."""
    return {
        "X": mass * (m.ax - x * m.r**2),
        "Y": mass * (m.ay + x * m.rdot),
        "N": Izz * m.rdot + mass * x * m.ay,
    }


def read(force: Force, m: Motion, effects: dict[str, float], foreign: bool) -> Force:
    """The reading of the balance along the whole (fine) time axis; t = 0 is the record's start.

    Order: forgotten mass, start-up, skewed axes, gain and dead zone of the Y gauge, moment point,
    filter, clock, zero and its drift.
    """
    F = {name: np.array(np.broadcast_to(force[name], m.t.shape)) for name in CHANNELS}
    size = effects.get

    if share := size("fault_inertia", 0.0):
        for name, part in _forgotten(m, foreign).items():
            F[name] -= share * part
    if m.plan.dynamic:
        sizes = {name: 0.5 * float(np.ptp(values[m.t < 0])) for name, values in F.items()}
        _start_up(F, m, sizes)
        if share := size("fault_transient", 0.0):
            _transient(F, m, sizes, share, foreign)
    if share := size("fault_cross_talk", 0.0):
        angle = share * SIZES["fault_cross_talk"]["X_from_Y"]
        if foreign:  # the X gauge stands askew
            F["X"] = np.cos(angle) * F["X"] + np.sin(angle) * F["Y"]
        else:
            F["X"] = F["X"] + angle * F["Y"]
    F["Y"] *= 1 + size("fault_gauge_gain", 0.0) * SIZES["fault_gauge_gain"]["Y"]
    if share := size("outside_dead_zone", 0.0):
        F["Y"] = dead_zone(F["Y"], share * DEAD_ZONE)
    F["N"] -= (
        size("fault_moment_point", 0.0)
        * SIZES["fault_moment_point"]["x_over_L"]
        * (SHIP.L * F["Y"])
    )
    if share := size("fault_filter_lag", 0.0):
        F = {name: _filtered(values, m, share, foreign) for name, values in F.items()}
    if share := size("fault_time_lag", 0.0):
        late = share * SIZES["fault_time_lag"]["seconds"]
        F = {name: np.interp(m.t - late, m.t, values) for name, values in F.items()}
    for name in ("Y", "N"):
        F[name] = (
            F[name]
            + size("fault_gauge_zero", 0.0) * SIZES["fault_gauge_zero"][name]
            + size("fault_gauge_drift", 0.0)
            * SIZES["fault_gauge_drift"][f"{name}_per_minute"]
            * _warming(m.t, foreign)
        )
    return F


def _forgotten(m: Motion, foreign: bool) -> Force:
    """Inertia that nobody takes off: a share of the model's, or two weights forgotten aboard."""
    share = SIZES["fault_inertia"]["mass_share"]
    if not foreign:
        return inertia(m, share * SHIP.mass, share * SHIP.Izz)
    weight, ahead, behind = share * SHIP.mass / 2, 0.26 * SHIP.L, -0.23 * SHIP.L
    parts = [inertia(m, weight, weight * x**2, x) for x in (ahead, behind)]
    return {name: parts[0][name] + parts[1][name] for name in CHANNELS}


def _start_up(F: Force, m: Motion, sizes: dict[str, float]) -> None:
    """The start of every oscillation: over when the first cycle is."""
    fade = np.exp(-np.maximum(m.t, 0) * m.carriage / SHIP.L / STARTUP["decay_LU"])
    fade[m.t < 0] = 0.0
    for name, values in F.items():
        F[name] = values + STARTUP["share"] * sizes[name] * fade


def _transient(F: Force, m: Motion, sizes: dict[str, float], share: float, foreign: bool) -> None:
    """A slow start-up; the share is what is left of it at the end of the first cycle.

    In Y and N, of the amplitude of their oscillation and with the sign of the oscillating force
    at the start: the first cycles read too much.
    Catalogue: exp(-t/T). Foreign: a flow that rises and dies, t exp(-t/T), with a wave on it.
    """
    distance = m.carriage / SHIP.L
    t, first = m.t * distance, 2 * np.pi / m.plan.omega * distance
    if foreign:
        fade = np.maximum(t, 0) / first * np.exp(-(t - first) / 1.02)
        fade = fade + 0.3 * np.exp(-(t - first) / 1.2) * np.cos(2.3 * (m.t - m.t[0]))
    else:
        fade = np.exp(-(t - first) / SIZES["fault_transient"]["decay_LU"])
    fade = np.where(t < 0, 0.0, fade)
    for name in ("Y", "N"):
        start = np.sign(F[name][m.t < 0][0] - np.mean(F[name][m.t < 0]))
        size = start * SIZES["fault_transient"]["share"] * sizes[name]
        F[name] = F[name] + share * size * fade


def _filtered(x: Array, m: Motion, share: float, foreign: bool) -> Array:
    """Low-pass of one pole; a negative share turns its action round (a lead)."""
    lag = abs(share) / (2 * np.pi * SIZES["fault_filter_lag"]["corner_hz"])
    y = digital_filter(x, m.t, lag) if foreign else one_pole(x, m.dt, lag)
    return y if share > 0 else 2 * x - y


def _warming(t: Array, foreign: bool) -> Array:
    """Minutes since the zero was taken; a gauge that warms up slows down."""
    if foreign:
        warm = 80.0
        return warm / 60 * -np.expm1(-t / warm) * 1.12
    return t / 60
