"""Sections, motions and added resistance in waves."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any, Final

import numpy as np

from pmmkit.seakeeping import Rao, added_resistance, rao, sea
from pmmkit.seakeeping.responses import dose_weight
from pmmkit.seakeeping.sectional import HEAVE, SWAY, solve
from pmmkit.seakeeping.strips import coefficients, strips_of
from scripts.validation import measurements
from scripts.validation.published import Published, Values, table
from scripts.validation.wigley import (
    AT_REST,
    FORCED_HEAVE,
    PEAKS,
    RHO,
    VOLUME,
    WAVE_LOADS,
    G,
    L,
    loaded,
    wigley,
)
from scripts.validation.wigley import HEAVE as AT_SPEED

CIRCLE: Final = np.array([[1.0, 0.0, 0.0]])
URSELL: Final = {0.5: (0.645, 0.812), 1.0: (0.605, 0.397), 2.0: (0.727, 0.121)}
"""Added mass and damping of a half circle in heave over ½ρπa² and ½ρωπa², by Ka."""
ISO: Final = {
    0.02: 24.2, 0.0315: 59.7, 0.05: 157, 0.08: 461, 0.1: 695, 0.125: 895, 0.16: 1006, 0.2: 992,
    0.25: 854, 0.315: 619, 0.4: 384, 0.5: 224, 0.63: 116,
}  # fmt: skip
"""Weighting Wf in thousandths, by frequency [Hz]."""
VERES: Final = {
    "0": {
        1.0: (0.277, 0.567), 1.5: (0.629, 0.827), 2.0: (0.784, 0.924),
    },
    "0.186": {
        1.0: (0.960, 0.843), 1.1: (1.093, 0.983), 1.2: (1.071, 1.053), 1.5: (0.955, 1.114),
        2.0: (0.943, 1.114),
    },
    "0.248": {
        0.7: (0.083, 0.059), 0.8: (0.042, 0.198), 0.9: (0.329, 0.437), 1.0: (0.816, 0.749),
        1.1: (1.277, 1.015), 1.2: (1.462, 1.148), 1.3: (1.423, 1.193), 1.4: (1.320, 1.207),
        1.5: (1.229, 1.210), 1.75: (1.096, 1.198), 2.0: (1.044, 1.179), 2.5: (1.015, 1.147),
        3.0: (1.009, 1.123),
    },
}  # fmt: skip
"""Heave/ζ and pitch/kζ of S175 in head seas by Froude number and wave length over L."""
TANK: Final[dict[str, Any]] = {
    "sources": ("journee_1992",),
    "nature": "measured",
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
            [row[1] for row in AT_SPEED],
            [row[0] for row in WAVE_LOADS],
        ]
    )
)  # fmt: skip
"""Of the waves that they were tested in, and of some between [1/m]."""
METHODS: Final = {
    "Gerritsma-Beukelman": "Gerritsma and Beukelman",
    "with reflection": "the same with reflection",
    "SNNM": "SNNM",
}
"""Methods of added resistance, and what the page calls them."""
STRIPS: Final = "Strip theory has no flow along the hull."


@cache
def half_circle() -> Values:
    """A half circle at the surface."""
    found = solve(CIRCLE, np.array([*URSELL])).added[HEAVE, HEAVE, :, 0] / (math.pi / 2)
    values = {}
    for Ka, x in zip(URSELL, found, strict=True):
        values |= {f"added mass, Ka {Ka:g}": x.real, f"damping, Ka {Ka:g}": -x.imag}
    return values


@cache
def limits() -> Values:
    """A half circle in very long and very short waves."""
    long, short = (
        solve(CIRCLE, np.array([Ka])).added[:, :, 0, 0] / (math.pi / 2) for Ka in (1e-6, 60.0)
    )
    return {
        "damping of heave in long waves": -long[HEAVE, HEAVE].imag,
        "added mass of sway in long waves": long[SWAY, SWAY].real,
        "added mass of heave in short waves": short[HEAVE, HEAVE].real,
        "added mass of sway in short waves": short[SWAY, SWAY].real,
    }


@cache
def weighting() -> Values:
    """Wf in thousandths."""
    found = 1000 * dose_weight(2 * math.pi * np.array([*ISO]))
    return {f"{f:g} Hz": float(x) for f, x in zip(ISO, found, strict=True)}


@cache
def spectrum() -> Values:
    """Periods and height of the ITTC's two-parameter spectrum."""
    found = sea("ittc", Hs=4.0, T1=8.0)
    return {
        "T1/Tp": found.T1 / found.Tp,
        "Tz/T1": found.Tz / found.T1,
        "S at 0.6 rad/s, H 4 m, T1 8 s [m² s]": float(found.spectrum([0.6])[0]),
    }


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

    values = {}
    for length, heave, pitch, _ in rows:
        values |= {f"heave/ζ, λ/L {length:g}": heave, f"pitch L/2πζ, λ/L {length:g}": pitch}
    return table(
        f"Wigley {model} at rest, head waves",
        values,
        ours,
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
        lengths = tuple(row[1] for row in AT_SPEED if row[0] == Fn)
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
def peaks() -> Values:
    """Largest added resistance of the Wigley hulls."""
    values = {}
    for model, speeds in FROUDE.items():
        added = added_resistance(sailed(model))
        for method in METHODS:
            largest = np.max(added.methods[method], axis=-1)[:, 0] / added.unit
            for Fn, x in zip(speeds, largest, strict=True):
                values[of_peak(model, Fn, method)] = float(x)
    return values


def of_peak(model: str, Fn: float, method: str) -> str:
    """What a largest added resistance is called."""
    return f"Wigley {model}, Fn {Fn}, by {METHODS[method]}"


def pairs(rows: Any, first: str, second: str, label: Callable[[float], str]) -> Values:
    """A table of two columns by name."""
    values = {}
    for at, one, other in rows:
        values |= {f"{first}, {label(at)}": one, f"{second}, {label(at)}": other}
    return values


FIGURES: tuple[Published, ...] = (
    *table(
        "Half circle in heave",
        pairs([(Ka, *x) for Ka, x in URSELL.items()], "added mass", "damping", "Ka {:g}".format),
        half_circle,
        unit="½ρπa²",
        sources=("ursell_1949",),
        place="converged values of that problem",
        nature="recomputed",
        how="`pmmkit.seakeeping.sectional.solve`",
        within=2e-3,
    ),
    *table(
        "Half circle, limits",
        {
            "damping of heave in long waves": 8 / math.pi,
            "added mass of sway in long waves": 1.0,
            "added mass of heave in short waves": 1.0,
            "added mass of sway in short waves": 4 / math.pi**2,
        },
        limits,
        unit="½ρπa²",
        sources=("ursell_1949", "tasai_1961"),
        place="closed forms",
        nature="printed",
        how="the same at Ka = 10⁻⁶ and 60; Ka = 60 is not yet the limit",
        within=0.05,
    ),
    *table(
        "Weighting for motion sickness",
        {f"{f:g} Hz": x for f, x in ISO.items()},
        weighting,
        unit="10⁻³",
        sources=("iso_2631_1",),
        place="table of Wf",
        nature="printed",
        how="`pmmkit.seakeeping.responses.dose_weight`",
        within=5e-3,
    ),
    *table(
        "Two-parameter spectrum of the ITTC",
        {
            "T1/Tp": 0.772, "Tz/T1": 0.920,
            "S at 0.6 rad/s, H 4 m, T1 8 s [m² s]":
            173 * 16 / (8.0**4 * 0.6**5) * math.exp(-691 / (8.0**4 * 0.6**4)),
        },
        spectrum,
        sources=("tanker_preliminary_design",),
        place="equation 11.36, and what follows from it",
        nature="printed",
        how="`pmmkit.seakeeping.sea`; 173 and 691 are rounded",
        within=5e-3,
    ),
    *table(
        "Wigley hulls, displacement",
        {f"Wigley {model}": volume for model, volume in VOLUME.items()},
        lambda: {f"Wigley {model}": wigley(model).hydrostatics.volume for model in VOLUME},
        unit="m³",
        sources=("journee_1992",),
        place="particulars",
        nature="printed",
        how="the formula of the hull, integrated",
        within=3e-3,
    ),
    *at_rest("III"),
    *at_rest("IV"),
    *table(
        "Wigley III at speed, head waves",
        {f"heave/ζ, Fn {Fn}, λ/L {length:g}": x for Fn, length, x in AT_SPEED},
        at_speed,
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
    *table(
        "Wigley hulls, largest added resistance in head waves",
        {of_peak(model, Fn, method): x for method in METHODS for model, Fn, x in PEAKS},
        peaks,
        unit="ρgζ²B²/L",
        place="tables 8",
        within=1.0,
        why="Added resistance goes with the square of motions that strip theory has to some per "
        "cent; no method is closer at all speeds and breadths.",
        **TANK,
    ),
    *table(
        "S175 at 9.5 m, hydrostatics",
        {
            "displacement": 24609.6, "LCB from the after perpendicular": 84.953, "KB": 5.207,
            "GM": 0.996, "waterplane coefficient": 0.709,
        },
        measurements.kept("hydrostatics"),
        unit={
            "displacement": "t", "LCB from the after perpendicular": "m", "KB": "m", "GM": "m",
        },
        sources=("fossen_perez_2004",),
        place="VERES 4.02.3 on the same offsets",
        nature="computed",
        how="hydrostatics of the offsets; made with that program's file",
        within=3e-3,
    ),
    *table(
        "S175 at 9.5 m in head seas",
        {
            measurements.of_wave(mode, Fn, length): x
            for Fn, rows in VERES.items()
            for length, row in rows.items()
            for mode, x in zip(("heave", "pitch"), row, strict=True)
        },
        measurements.kept("head_seas"),
        sources=("fossen_perez_2004",),
        place="VERES 4.02.3, heave/ζ and pitch/kζ",
        nature="computed",
        how="strip theory on the same offsets; made with that program's file",
        within=0.5,
        why="Up to 0.08 of the wave where motions rise steeply to resonance (λ/L 1 to 1.1), 0.01 "
        "near their minimum.",
    ),
    *table(
        "S175 at 9.5 m, largest added resistance in head seas",
        {"Fn 0.186": 8.28, "Fn 0.248": 11.26},
        measurements.kept("resistance"),
        unit="ρgζ²B²/L",
        sources=("fossen_perez_2004",),
        place="VERES 4.02.3, which integrates the pressure",
        nature="computed",
        how="Gerritsma and Beukelman with reflection of short waves; made with that program's file",
        within=0.25,
        why="Another method: energy of the waves sent out, not pressure.",
    ),
)  # fmt: skip
