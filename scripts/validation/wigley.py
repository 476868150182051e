"""Journée's Wigley hulls, which are formulas, and what was measured on them in head waves.

Half breadth over B/2: (1 - ζ²)(1 - ξ²)(1 + 0.2 ξ²) + α ζ²(1 - ζ⁸)(1 - ξ²)⁴ with ξ = 2x/L, ζ = z/d
downward; α = 1 for I and II, 0 for III and IV. L 3 m, d 0.1875 m, B 0.3 m (I, III) or 0.6 m, radius
of gyration in pitch 0.75 m. Numbers are those of Journée's report 909 (Delft University of
Technology, 1992) as two public programs quote its tables (michell, openhull); the report was not at
hand.
"""

from __future__ import annotations

import numpy as np

from pmmkit.seakeeping import Hull, Loading
from pmmkit.seakeeping.hull_forms.hull import Station

L, D, KYY, RHO, G = 3.0, 0.1875, 0.75, 1000.0, 9.81
BREADTH = {"I": 0.3, "II": 0.6, "III": 0.3, "IV": 0.6}
VOLUME = {"I": 0.0946, "II": 0.1892, "III": 0.0780, "IV": 0.1560}

AT_REST = {
    # tables 10: λ/L, heave/ζ, pitch L/(2πζ), phase of heave less that of pitch [deg]
    "III": (
        (0.857, 0.19, 0.49, 27 - 274), (1.000, 0.29, 0.57, 7 - 259), (1.250, 0.45, 0.63, -4 - 258),
        (1.500, 0.57, 0.57, -3 - 264), (1.750, 0.67, 0.54, -6 - 262), (2.000, 0.74, 0.50, -5 - 262),
    ),
    "IV": (
        (0.750, 0.10, 0.33, 42 - 282), (1.000, 0.30, 0.57, 25 - 273), (1.250, 0.43, 0.62, 13 - 270),
        (1.500, 0.65, 0.69, -5 - 277), (1.750, 0.71, 0.60, -3 - 275), (2.000, 0.79, 0.54, -6 - 275),
    ),
}  # fmt: skip
HEAVE = (
    # table 8-III: Fn, λ/L, heave/ζ
    (0.2, 1.25, 0.71), (0.2, 1.5, 0.81), (0.2, 2.0, 0.90),
    (0.3, 1.25, 1.28), (0.3, 1.384, 1.11), (0.3, 1.5, 1.01), (0.3, 2.0, 0.99),
)  # fmt: skip
FORCED_HEAVE = (
    # table 2-III, Fn 0.3: ω√(L/g), A33/(ρ∇), B33/(ρ∇)√(L/g)
    (2.22, 0.707, 1.963), (2.78, 0.537, 1.994), (3.34, 0.465, 1.854), (3.88, 0.425, 1.706),
    (4.45, 0.421, 1.518),
)  # fmt: skip
WAVE_LOADS = (
    # table 6-III, Fn 0.3: λ/L, |X3|/(C33 ζ), |X5|/(k C55 ζ)
    (1.25, 0.345, 0.444), (1.5, 0.454, 0.546), (1.75, 0.515, 0.600), (2.0, 0.577, 0.658),
)  # fmt: skip
PEAKS = (
    # tables 8: hull, Fn, largest added resistance over ρgζ²B²/L
    ("I", 0.2, 31.8), ("II", 0.2, 11.1), ("III", 0.2, 22.2), ("IV", 0.2, 13.5),
    ("I", 0.3, 27.6), ("III", 0.3, 20.2), ("IV", 0.3, 19.3), ("III", 0.4, 27.7),
)  # fmt: skip


def wigley(model: str, stations: int = 41) -> Hull:
    """One of the four hulls, the ends a little inside of the perpendiculars."""
    full = 1.0 if model in ("I", "II") else 0.0
    depth = np.sin(np.linspace(0.5 * np.pi, 0.0, 41))
    rows = []
    for place in 0.995 * np.sin(np.linspace(-0.5 * np.pi, 0.5 * np.pi, stations)):
        along = 1 - place**2
        half = (1 - depth**2) * along * (1 + 0.2 * place**2)
        half = half + full * depth**2 * (1 - depth**8) * along**4
        rows.append(Station(x=0.5 * L * place, y=0.5 * BREADTH[model] * half, z=D * (1 - depth)))
    return Hull(name=f"Wigley {model}", L=L, draught=D, stations=tuple(rows))


def loaded(hull: Hull) -> Loading:
    """As tested, but for a little stability in roll, which the rig gave."""
    return Loading.of(hull, GM=0.01, kxx=0.1, kyy=KYY, kzz=KYY, roll_damping=0.05)
