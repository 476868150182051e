"""Formulas from particulars."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from functools import cache
from typing import Final

from pmmkit.effects.cross_flow import hoerner_cd
from pmmkit.effects.four_quadrant import b4_70
from pmmkit.models import HullEstimate, converted, estimate, hull_table, load_ship
from pmmkit.models.empirical import (
    METHODS,
    criterion,
    friction_coefficient,
    rudder_values,
    wake_fraction,
    wetted_surface,
)
from scripts.studies.paper_b_table import MASS, PRINTED, REASONS, TANKER
from scripts.validation.forces import MMG
from scripts.validation.published import Published, Values, table

TEXT: Final = {"sources": ("tanker_preliminary_design",), "nature": "printed", "part": "program"}
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
SHIPS: Final = {"KVLCC2": "kvlcc2", "KCS": "kcs", "S175": "s175-3dof"}
"""Ships with derivatives from tests, and their names in the library."""
SOURCES: Final = ("yasukawa_yoshimura_2015", "simman_2008", "son_nomoto_1981")
LINEAR: Final = ("Yv", "Yr", "Nv", "Nr")
ADDED: Final = ("Xudot", "Yvdot", "Nrdot")
FORMULAS: Final = "yoshimura-masumoto"


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
    """Derivatives of a library ship as a captive test measures them."""
    return converted(hull_table(ship), MMG).at()


@cache
def estimated(ship: str) -> HullEstimate:
    """The same by Yoshimura and Masumoto's formulas, added masses by Zhou's."""
    return estimate(load_ship(ship), FORMULAS)


def of_ships(names: Iterable[str], of: Callable[[str], Values]) -> Values:
    """Derivatives of the three ships."""
    return {f"{name} of {title}": of(ship)[name] for title, ship in SHIPS.items() for name in names}


@cache
def propulsion() -> Values:
    """Wake, rudder and wetted surface of KVLCC2 by formulas."""
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
        how="`pmmkit.models.empirical`",
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
        how="`pmmkit.models.empirical.criterion` with the same x'G",
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
        part="program",
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
        part="program",
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
        part="program",
        how="`pmmkit.models.empirical.friction_coefficient`",
        within=1e-4,
    ),
    *table(
        "KVLCC2, KCS and S175, linear derivatives by formulas",
        of_ships(LINEAR, tested),
        lambda: of_ships(LINEAR, lambda ship: estimated(ship).values),
        unit="½ρLd",
        sources=SOURCES,
        place="captive tests, as the library of ships has them",
        nature="measured",
        part="prediction",
        how="Yoshimura and Masumoto (2012), from the particulars",
        std=of_ships(LINEAR, lambda ship: estimated(ship).std),
        within=0.75,
        why="Regressions over other hulls. So far the three ships lie off (root mean square): "
        + ", ".join(f"{x} {100 * METHODS[FORMULAS].error_of(x).share:.0f} %" for x in LINEAR)
        + ".",
    ),
    *table(
        "KVLCC2, rudder by formulas",
        {
            "aH": 0.312, "tR": 0.387, "κ": 0.50, "xH": -0.464,
            "γR, mean of both sides": (0.640 + 0.395) / 2,
        },
        propulsion,
        sources=("yasukawa_yoshimura_2015",),
        place="rudder tests of the 7 m model",
        nature="measured",
        part="prediction",
        how="`pmmkit.models.empirical.rudder_values`",
        within=0.5,
        why="Formulas from other hulls, for a first look.",
    ),
    *table(
        "Added masses by formulas",
        of_ships(ADDED, tested),
        lambda: of_ships(ADDED, lambda ship: estimated(ship).values),
        unit="½ρLd",
        sources=SOURCES,
        place="coefficients of their models; none is known to come from a test",
        nature="printed",
        part="program",
        how="Zhou (1983), whose formulas follow Motora's charts, from the particulars",
        within=0.75,
        why="The formula for Xudot is a twentieth of the displacement, whatever the hull.",
    ),
    *table(
        "KVLCC2, wake and inflow of the rudder by formulas",
        {"wake fraction": 0.35, "ε": 1.09, "fα": 2.747},
        propulsion,
        sources=("yasukawa_yoshimura_2015",),
        place="the wake is assumed for full scale, fα is Fujii's formula with an aspect ratio of "
        "1.827",
        nature="printed",
        part="program",
        how="`pmmkit.models.empirical.rudder_values` and `wake_fraction`; ε by a line through "
        "KVLCC2 and KCS, so that it is no prediction",
        within=0.2,
        why={"fα": "The same formula with height squared over area, 2.219."},
    ),
    *table(
        "KVLCC2, wetted surface",
        {"wetted surface [m²]": 27194.0},
        propulsion,
        sources=("simman_2008",),
        place="of the hull's lines, without the rudder",
        nature="printed",
        part="program",
        how="`pmmkit.models.empirical.wetted_surface`",
        within=0.05,
    ),
)  # fmt: skip
