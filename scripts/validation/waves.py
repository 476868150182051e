"""Sections, motions and added resistance in waves."""

from __future__ import annotations

import math
from functools import cache
from typing import Final

import numpy as np

from pmmkit.seakeeping import sea
from pmmkit.seakeeping.responses import dose_weight
from pmmkit.seakeeping.sectional import HEAVE, SWAY, solve
from scripts.validation import measurements, tank
from scripts.validation.published import Published, Values, pairs, table

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


FIGURES: tuple[Published, ...] = (
    *table(
        "Half circle in heave",
        pairs([(Ka, *x) for Ka, x in URSELL.items()], "added mass", "damping", "Ka {:g}".format),
        half_circle,
        unit="½ρπa²",
        sources=("ursell_1949",),
        place="converged values of that problem",
        nature="recomputed",
        part="program",
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
        part="program",
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
        part="program",
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
        part="program",
        how="`pmmkit.seakeeping.sea`; 173 and 691 are rounded",
        within=5e-3,
    ),
    *tank.FIGURES,
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
        part="program",
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
        part="program",
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
        part="program",
        how="Gerritsma and Beukelman with reflection of short waves; made with that program's file",
        within=0.25,
        why="Another method: energy of the waves sent out, not pressure.",
    ),
)  # fmt: skip
