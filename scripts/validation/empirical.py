"""Formulas from particulars."""

from __future__ import annotations

import math
from functools import cache
from typing import Final

from pmmkit.effects.cross_flow import hoerner_cd
from pmmkit.effects.four_quadrant import b4_70
from pmmkit.empirical import (
    METHODS,
    criterion,
    estimate,
    friction_coefficient,
    rudder_values,
    wake_fraction,
    wetted_surface,
)
from pmmkit.models.hull import hull_table
from pmmkit.ship_library import load_ship
from pmmkit.tables.convert import converted
from scripts.studies.paper_b_table import MASS, PRINTED, REASONS, TANKER
from scripts.validation.forces import MMG
from scripts.validation.published import Published, Values, table

TEXT: Final = {"sources": ("tanker_preliminary_design",), "nature": "printed"}
LEVERS: Final = {
    "wagner-smitt": (0.8757, 0.3899),
    "norrbin": (1.0453, 0.3647),
    "inoue": (1.0845, 0.31721),
    "clarke": (0.5288, 0.34463),
}
"""(Nr - m'xG')/(Yr - m') and Nv/Yv as the table has them."""
B4_70: Final = {
    0.5: (0.0887, 0.1684, 0.912, 0.793),
    0.8: (0.1654, 0.3140, 0.801, 0.806),
    1.0: (0.2199, 0.4176, 0.746, 0.776),
    1.4: (0.3042, 0.5777, 0.634, 0.674),
}
"""CT* at 0, KT at J = 0, CT* at -90, -CT* at 90 degrees, from the published harmonics 0 to 13."""
KEEL: Final = {
    "S175, B/2d 1.49": ((25.4, 8.5), 0.721),
    "S175, B/2d 1.34": ((25.4, 9.5), 0.754),
    "KVLCC2, B/2d 1.39": ((58.0, 20.8), 0.742),
    "KCS, B/2d 1.49": ((32.2, 10.8), 0.722),
}
"""Breadth and draught, and the coefficient of cross-flow drag read off Hoerner's curve."""
SHIPS: Final = {
    "kvlcc2": ("yasukawa_yoshimura_2015",),
    "kcs": ("simman_2008",),
    "s175-3dof": ("son_nomoto_1981",),
}


def named(method: str, name: str) -> str:
    """What an estimate is called."""
    return f"{name} by {method}"


@cache
def tanker() -> Values:
    """Table 11.1."""
    return {
        named(method, name): estimate(TANKER, method).values[name]
        for method, printed in PRINTED.items()
        for name in printed
    }


@cache
def levers() -> Values:
    """Levers of the same table by our formulas, with its centre of gravity."""
    found = {}
    for method in LEVERS:
        yaw, sway = criterion(estimate(TANKER, method).values, MASS, 0.534)
        found |= {named(method, "lever of yaw"): yaw, named(method, "lever of sway"): sway}
    return found


@cache
def four_quadrants() -> Values:
    """The B4-70 screws."""
    found = {}
    for pitch in B4_70:
        ahead = b4_70(0.0, pitch)[0]
        found |= {
            f"CT* at 0°, P/D {pitch}": ahead,
            f"KT at J = 0, P/D {pitch}": ahead * math.pi / 8 * (0.7 * math.pi) ** 2,
            f"CT* at -90°, P/D {pitch}": b4_70(-math.pi / 2, pitch)[0],
            f"CT* at 90°, P/D {pitch}": b4_70(math.pi / 2, pitch)[0],
        }
    return found


def quadrants_published() -> Values:
    """The same as published."""
    found = {}
    for pitch, (CT, KT, astern, ahead) in B4_70.items():
        found |= {
            f"CT* at 0°, P/D {pitch}": CT,
            f"KT at J = 0, P/D {pitch}": KT,
            f"CT* at -90°, P/D {pitch}": astern,
            f"CT* at 90°, P/D {pitch}": -ahead,
        }
    return found


def tested(ship: str) -> Values:
    """Linear derivatives and added masses of a library ship as a captive test measures them."""
    values = converted(hull_table(ship), MMG).at()
    return {name: values[name] for name in ("Yv", "Yr", "Nv", "Nr", "Xudot", "Yvdot", "Nrdot")}


@cache
def estimated(ship: str) -> Values:
    """The same by Yoshimura and Masumoto's formulas, added masses by Zhou's."""
    return estimate(load_ship(ship), "yoshimura-masumoto").values


def regression(ship: str) -> tuple[Published, ...]:
    """Formulas beside the tests of one ship."""
    method = METHODS["yoshimura-masumoto"]
    values = tested(ship)
    return table(
        f"{ship}, tests beside formulas",
        values,
        lambda: estimated(ship),
        unit="½ρLd",
        sources=SHIPS[ship],
        place="library ship",
        nature="measured",
        how="Yoshimura and Masumoto (2012), added masses by Zhou (1983), from the particulars",
        within=0.75,
        why="Regressions over other hulls. So far the ships behind their standard errors lie off: "
        + ", ".join(f"{name} {100 * method.error_of(name).share:.0f} %" for name in values)
        + ".",
    )


@cache
def propulsion() -> Values:
    """Wake and rudder of KVLCC2 by formulas."""
    ship = load_ship("kvlcc2")
    rudder = rudder_values(ship, area=112.5, aspect=15.8**2 / 112.5, D=9.86)
    return {
        "wake fraction": wake_fraction(ship),
        "aH": rudder["aH"],
        "tR": rudder["tR"],
        "κ": rudder["kappa"],
        "ε": rudder["epsilon"],
        "fα": rudder["lift_slope"],
        "xH": rudder["xH"],
        "γR, mean of both sides": rudder["gamma_positive"],
        "wetted surface [m²]": wetted_surface(ship),
    }


FIGURES: tuple[Published, ...] = (
    *table(
        "Tanker of 280 000 dwt, derivatives by four formulas",
        {named(m, name): x for m, printed in PRINTED.items() for name, x in printed.items()},
        tanker,
        unit="½ρL²",
        place="table 11.1",
        how="`pmmkit.empirical`",
        within=3e-3,
        but={
            named("norrbin", "Nv"): 0.05, named("norrbin", "Yr"): 0.01,
            named("norrbin", "Nr"): 0.005, named("clarke", "Yr"): 0.04,
            named("clarke", "Nr"): 0.65,
        },
        why={named(*key): f"{reason[0].upper()}{reason[1:]}." for key, reason in REASONS.items()},
        **TEXT,
    ),
    *table(
        "Tanker of 280 000 dwt, levers of straight-line stability",
        {
            named(m, name): x
            for m, printed in LEVERS.items()
            for name, x in zip(("lever of yaw", "lever of sway"), printed, strict=True)
        },
        levers,
        unit="L",
        place="table 11.1, with its x'G of 0.534, which is measured from the after perpendicular "
        "where the formula asks for midship (0.034, with which two of the four are unstable)",
        how="`pmmkit.empirical.criterion` with the same x'G",
        within=0.8,
        why={
            named("norrbin", "lever of sway"): "Nv is misprinted (0.04 T/L, see its derivatives).",
            named("clarke", "lever of yaw"): "Nr with 0.15 in place of 1/4, and Yr with the other "
            "sign.",
        },
        **TEXT,
    ),
    *table(
        "Wageningen B4-70 in four quadrants",
        quadrants_published(),
        four_quadrants,
        sources=("roddy_hess_faller_2006", "van_lammeren_van_manen_oosterveld_1969"),
        place="harmonics 0 to 13 of six pitches",
        nature="printed",
        how="`four_quadrant_propeller`: one parabola in pitch for all tables, which keeps CT* to "
        "0.012",
        within=0.035,
    ),
    *table(
        "Cross-flow drag over B/2d",
        {name: CD for name, (_, CD) in KEEL.items()},
        lambda: {name: hoerner_cd(*hull) for name, (hull, _) in KEEL.items()},
        sources=("leite_1998", "fossen_perez_2004"),
        place="read off the curve of `Hoerner.m`",
        nature="recomputed",
        how="`pmmkit.effects.cross_flow.hoerner_cd`",
        within=1e-3,
    ),
    *table(
        "Friction line",
        {"Re 10⁶": 4.6875e-3, "Re 10⁷": 3.0e-3, "Re 10⁹": 1.5306e-3},
        lambda: {
            "Re 10⁶": friction_coefficient(1e6),
            "Re 10⁷": friction_coefficient(1e7),
            "Re 10⁹": friction_coefficient(1e9),
        },
        sources=("ittc_1957",),
        place="0.075/(log Re - 2)²",
        nature="printed",
        how="`pmmkit.empirical.friction_coefficient`",
        within=1e-4,
    ),
    *(figure for ship in SHIPS for figure in regression(ship)),
    *table(
        "KVLCC2, propeller and rudder by formulas",
        {
            "wake fraction": 0.35, "aH": 0.312, "tR": 0.387, "κ": 0.50, "ε": 1.09, "fα": 2.747,
            "xH": -0.464, "γR, mean of both sides": (0.640 + 0.395) / 2,
        },
        propulsion,
        sources=("yasukawa_yoshimura_2015",),
        place="values of the ship",
        nature="measured",
        how="`pmmkit.empirical.rudder_values` and `wake_fraction`",
        within=0.5,
        why="Formulas from other hulls, for a first look.",
    ),
    *table(
        "KVLCC2, wetted surface",
        {"wetted surface [m²]": 27194.0},
        propulsion,
        sources=("simman_2008",),
        place="without the rudder",
        nature="measured",
        how="`pmmkit.empirical.wetted_surface`",
        within=0.05,
    ),
)  # fmt: skip
