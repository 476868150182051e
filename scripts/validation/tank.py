"""Wigley hulls in head waves: strip theory beside a tank."""

from __future__ import annotations

from functools import cache
from typing import Any, Final

import numpy as np

from pmmkit.seakeeping import AddedResistance, Rao, added_resistance, rao
from pmmkit.seakeeping.explanation import FLOOR
from pmmkit.seakeeping.strips import coefficients, strips_of
from scripts.validation.published import Published, Values, pairs, table
from scripts.validation.wigley import (
    AT_REST,
    FORCED_HEAVE,
    HEAVE,
    PEAKS,
    RHO,
    VOLUME,
    WAVE_LOADS,
    G,
    L,
    loaded,
    wigley,
)

TANK: Final[dict[str, Any]] = {
    "sources": ("journee_1992",),
    "nature": "measured",
    "part": "prediction",
    "how": "strip theory on the formula of the hull",
}
FROUDE: Final = {"I": (0.2, 0.3), "II": (0.2,), "III": (0.0, 0.2, 0.3, 0.4), "IV": (0.0, 0.2, 0.3)}
"""Speeds at which the hulls were tested."""
WAVENUMBERS: Final = np.unique(
    2 * np.pi
    / L
    / np.concatenate(
        [
            np.linspace(0.7, 2.0, 27),
            [row[0] for rows in AT_REST.values() for row in rows],
            [row[1] for row in HEAVE],
            [row[0] for row in WAVE_LOADS],
        ]
    )
)  # fmt: skip
"""Of the waves that they were tested in, and of some between [1/m]."""
METHODS: Final = {
    "momentum": "momentum",
    "Gerritsma-Beukelman": "Gerritsma and Beukelman",
    "with reflection": "Gerritsma and Beukelman with reflection",
    "SNNM": "SNNM",
}
"""Methods of added resistance, and what the page calls them."""
STRIPS: Final = "Strip theory has no flow along the hull."


@cache
def sailed(model: str) -> Rao:
    """Motions of a Wigley hull in head waves at its speeds and wave lengths."""
    hull = wigley(model)
    return rao(
        hull,
        speeds=np.array(FROUDE[model]) * np.sqrt(G * L),
        omega=np.sqrt(G * WAVENUMBERS),
        loading=loaded(hull),
        rho=RHO,
        g=G,
    )


def places(lengths: tuple[float, ...]) -> np.ndarray:
    """Where wave lengths over that of the ship stand among those computed."""
    return np.searchsorted(WAVENUMBERS, 2 * np.pi / (np.asarray(lengths) * L) - 1e-9)


def at_rest(model: str) -> tuple[Published, ...]:
    """Heave and pitch of a Wigley hull at rest."""
    rows = AT_REST[model]

    @cache
    def ours() -> Values:
        motion = np.abs(sailed(model).motion[:, 0, 0, places(tuple(row[0] for row in rows))])
        values = {}
        for row, heave, pitch in zip(rows, motion[2], motion[4] * L / (2 * np.pi), strict=True):
            values |= {f"heave/ζ, λ/L {row[0]:g}": heave, f"pitch L/2πζ, λ/L {row[0]:g}": pitch}
        return values

    values, std = {}, {}
    for length, heave, pitch, _ in rows:
        lift, turn = f"heave/ζ, λ/L {length:g}", f"pitch L/2πζ, λ/L {length:g}"
        values |= {lift: heave, turn: pitch}
        std |= {lift: FLOOR, turn: FLOOR / length}
    return table(
        f"Wigley {model} at rest, heave and pitch in head waves",
        values,
        ours,
        std=std,
        place="tables 10, read to two digits",
        within=0.8,
        why=STRIPS
        + " Heave is off by 0.05 of the wave (rms), pitch by 0.09 of its slope, too low as "
        "the report's own strip programs found it.",
        **TANK,
    )


@cache
def at_speed() -> Values:
    """Heave of Wigley III at speed."""
    values = {}
    for Fn in (0.2, 0.3):
        lengths = tuple(row[1] for row in HEAVE if row[0] == Fn)
        heave = sailed("III").mode("heave")[FROUDE["III"].index(Fn), 0, places(lengths)]
        for length, x in zip(lengths, np.abs(heave), strict=True):
            values[f"heave/ζ, Fn {Fn}, λ/L {length:g}"] = x
    return values


@cache
def forced() -> Values:
    """Added mass and damping of Wigley III in heave."""
    nondimensional = np.array(FORCED_HEAVE)[:, 0]
    hull = wigley("III")
    omega = nondimensional * np.sqrt(G / L)
    speed = np.array(0.3 * np.sqrt(G * L))
    found = coefficients(strips_of(hull, 1.1 * omega.max(), g=G), speed, omega)[2, 2]
    volume = hull.hydrostatics.volume
    damping = -found.imag * omega / volume * np.sqrt(L / G)
    values = {}
    for at, a, b in zip(nondimensional, found.real / volume, damping, strict=True):
        values |= {f"A33/ρ∇, ω√(L/g) {at:g}": a, f"B33/ρ∇ √(L/g), ω√(L/g) {at:g}": b}
    return values


@cache
def loads() -> Values:
    """Forces of waves on Wigley III, held."""
    lengths = np.array(WAVE_LOADS)[:, 0]
    found = sailed("III")
    held = found.strips.hull.hydrostatics
    at = FROUDE["III"].index(0.3)
    force = np.abs(found.force[:, at, 0, places(tuple(lengths))]) / (RHO * G)
    slope = 2 * np.pi / (lengths * L)
    heave, pitch = force[2] / held.waterplane, force[4] / held.along / slope
    values = {}
    for length, lift, turn in zip(lengths, heave, pitch, strict=True):
        values |= {f"X3/C33ζ, λ/L {length:g}": lift, f"X5/kC55ζ, λ/L {length:g}": turn}
    return values


@cache
def added(model: str) -> AddedResistance:
    """Added resistance of a Wigley hull."""
    return added_resistance(sailed(model))


def resistance(method: str) -> tuple[Published, ...]:
    """Largest added resistance of the Wigley hulls by one method."""

    @cache
    def ours() -> Values:
        values = {}
        for model, speeds in FROUDE.items():
            largest = np.max(added(model).methods[method], axis=-1)[:, 0] / added(model).unit
            for Fn, x in zip(speeds, largest, strict=True):
                values[f"Wigley {model}, Fn {Fn}"] = x
        return values

    return table(
        f"Wigley hulls, largest added resistance by {METHODS[method]}",
        {f"Wigley {model}, Fn {Fn}": x for model, Fn, x in PEAKS},
        ours,
        unit="ρgζ²B²/L",
        place="tables 8",
        within=1.0,
        why="Added resistance goes with the square of motions that strip theory has to some per "
        "cent; no method is closer at all speeds and breadths.",
        **TANK,
    )


FIGURES: tuple[Published, ...] = (
    *table(
        "Wigley hulls, displacement",
        {f"Wigley {model}": volume for model, volume in VOLUME.items()},
        lambda: {f"Wigley {model}": wigley(model).hydrostatics.volume for model in VOLUME},
        unit="m³",
        sources=("journee_1992",),
        place="particulars",
        nature="printed",
        part="program",
        how="the formula of the hull, integrated",
        within=3e-3,
    ),
    *at_rest("III"),
    *at_rest("IV"),
    *table(
        "Wigley III at speed, heave in head waves",
        {f"heave/ζ, Fn {Fn}, λ/L {length:g}": x for Fn, length, x in HEAVE},
        at_speed,
        std={f"heave/ζ, Fn {Fn}, λ/L {length:g}": FLOOR for Fn, length, _ in HEAVE},
        place="table 8-III",
        within=0.1,
        why=STRIPS,
        **TANK,
    ),
    *table(
        "Wigley III, forced heave at Fn 0.3",
        pairs(FORCED_HEAVE, "A33/ρ∇", "B33/ρ∇ √(L/g)", "ω√(L/g) {:g}".format),
        forced,
        place="table 2-III",
        within=0.15,
        why=STRIPS,
        **TANK,
    ),
    *table(
        "Wigley III, held in waves at Fn 0.3",
        pairs(WAVE_LOADS, "X3/C33ζ", "X5/kC55ζ", "λ/L {:g}".format),
        loads,
        place="table 6-III",
        within=0.11,
        why=STRIPS,
        **TANK,
    ),
    *(figure for method in METHODS for figure in resistance(method)),
)  # fmt: skip
