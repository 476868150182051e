"""Propeller and rudder from what is stated of them, and from the ship's particulars where not."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from pmmkit.base import DataError
from pmmkit.conventions import Ship, Water
from pmmkit.effects import CATALOGUE, Effect, Parameter
from pmmkit.models.empirical import (
    RUDDER_SOURCES,
    StandardError,
    rudder_values,
    shares,
    wake_fraction,
)
from pmmkit.models.model import Model
from pmmkit.models.part import Part
from pmmkit.models.stated_parts import SECTIONS
from pmmkit.models.wageningen import open_water_curve
from pmmkit.numerics import Array

STATED: Final = "measured: the campaign file"
HIGHEST_J: Final = 0.8
"""Advance ratios up to which the open-water curve is fitted."""
ASPECT: Final = 1.6
"""Height squared over area of a usual rudder."""
AREAS: Final = ("area", "area_movable", "area_lateral")
"""Words for the rudder's area [m²], the first that is there counts."""
SCREWS: Final = ("KVLCC2", "KCS", "S175", "Esso Osaka")
"""Ships of the library whose propeller and rudder were measured."""
BLADES: Final = ("KVLCC2", "KCS", "Esso Osaka")
"""Those whose rudder has the inflow of Yasukawa and Yoshimura."""
ALIKE: Final = "as straightening and lever of the other form"
RUDDER_ERRORS: Final[Mapping[str, StandardError]] = MappingProxyType(
    shares(*SCREWS, area=0.26, lift_slope=0.11, epsilon=0.15, tR=0.38, aH=0.24, xH=0.05)
    # Behind a propeller that turns the other way the two are exchanged: the worse side counts.
    | shares(*BLADES, eta=0.12, kappa=0.38, gamma_positive=0.4, gamma_negative=0.4, lR=0.2)
    | {name: StandardError(0.4, ships=(), why=ALIKE) for name in ("gamma", "cRrrv")}
    | {name: StandardError(0.3, ships=(), why=ALIKE) for name in ("cRr", "cRrrr")}
)
"""How far rudders of the library lie from `rudder_values` and `rudder_area`."""
C2: Final = 1.37
"""Usual growth of the inflow at large drift: the mean of KVLCC2's 1.6 and 1.1 and of S175, whose
inflow grows in the cross flow of a 35° turn, 0.4, as by 1.39. KCS has it constant without a test,
and Esso Osaka's form is for low speeds."""
WAKE_GROWTH: Final = StandardError(number=0.2, ships=("KVLCC2", "S175"))
GROWN: Final = StandardError(0.4, ships=(), why="as the growth of the other form")
PROPELLER_ERRORS: Final[Mapping[str, StandardError]] = MappingProxyType(
    shares(*SCREWS, D=0.26, t=0.1, kt0=0.43, kt1=0.36)
    # Esso Osaka's 0.61 is of a model of 3 m, and her epsilon of 1.42 makes up for it.
    | shares(wp=0.21)
    | {"C2_positive": WAKE_GROWTH, "C2_negative": WAKE_GROWTH, "tau": GROWN, "cp": GROWN}
)
"""How far propellers of the library lie from `propeller_values` and `propeller_diameter`."""
SERIES: Final = StandardError(0.07, ships=(), why="HP801 of HMRI lies so far off")
SERIES_ERRORS: Final[Mapping[str, StandardError]] = MappingProxyType({"kt0": SERIES, "kt1": SERIES})
"""How far a propeller of the same pitch and area may lie from the B series."""
DRAWN: Final = ("D", "kt0", "kt1", "area", "eta")
"""What of a propeller and a rudder drawings and an open-water test say."""
ELSEWHERE: Final = 0.5
"""Share of those errors that is left where the same ship lends a value: t, wp, ε, κ, γ, tR and aH
of KVLCC2 lie apart in two laboratories by 0.6 of the deviation of ships (leave_one_ship_out)."""
ANOTHER: Final = 1.2
"""The same where another ship lends it. Two ships that lie off a formula each for itself are √2 of
that apart: KVLCC2 and Esso Osaka, KCS and S175 by 1.9 of it, but one ship is a model of 3 m."""
ANOTHER_DRAWN: Final = 0.4
"""The same of what is drawn: similar ships have similar propellers and areas."""
WAKE: Final = MappingProxyType({"wake": "mmg"})
"""The form of a wake of which nobody says how it grows with drift: one whose growth can vary."""
GROWTH: Final = ("C1", "C2_positive", "C2_negative")
"""What says how a wake of that form grows."""
UNTOLD: Final = "not stated: usual growth in drift"
"""Where the growth of a stated propeller's wake comes from: no ground to call her an estimate."""
USUAL_LENGTH: Final = 200.0
"""Of a ship whose model is tested, where nobody states it [m]."""


def propeller_diameter(ship: Ship) -> float:
    """A usual propeller, 0.6 of the draught [m]; the library's have 0.42 to 0.77."""
    return 0.6 * ship.d


def propeller_values(ship: Ship, *, D: float) -> dict[str, float]:
    """Propeller of a merchant ship from particulars.

    D [m].
    """
    return {
        "D": D,
        "t": 0.2,
        "kt0": 0.33,
        "kt1": -0.3,
        "kt2": -0.13,
        "wp": wake_fraction(ship),
        "xp": -0.48,
        "C1": 2.0,
        "C2_positive": C2,
        "C2_negative": C2,
    }


def rudder_area(ship: Ship) -> float:
    """The least area of a rudder behind the propeller by Det Norske Veritas [m²].

    L d/100 (1 + 25 (B/L)²), of the rules of 1975 as textbooks quote them; the library's rudders
    have 0.92 to 1.45 of it.
    """
    return ship.L * ship.d / 100.0 * (1.0 + 25.0 * (ship.B / ship.L) ** 2)


def steering_rate(ship: Ship, full_length: float | None = None) -> float:
    """Rate of a steering gear that just satisfies SOLAS, 2.32 deg/s on the ship [deg/s]."""
    usual = USUAL_LENGTH if ship.L < Ship.LONGEST_MODEL else ship.L
    return 2.32 * math.sqrt((full_length or usual) / ship.L)


def parts_from_particulars(
    ship: Ship, propeller: Mapping[str, Any], rudder: Mapping[str, Any]
) -> tuple[Part, Part]:
    """Propeller and rudder: values as stated, the rest estimated from the ship's particulars.

    Examples
    --------
    >>> from pmmkit.models.library import load_ship
    >>> screw, blade = parts_from_particulars(load_ship("kvlcc2"), {"D": 9.86}, {"area": 112.5})
    >>> screw.source_of("D"), screw.source_of("t"), round(screw.std["t"], 3)
    ('measured: the campaign file', 'empirical: usual for a merchant ship', 0.022)
    """
    diameter = _number(propeller, "D") or propeller_diameter(ship)
    curve = _series(propeller)
    screw = _completed(
        CATALOGUE["propeller"],
        {**WAKE, **propeller},
        propeller_values(ship, D=diameter) | curve,
        {**PROPELLER_ERRORS, **(SERIES_ERRORS if curve else {})},
        "empirical: usual for a merchant ship"
        + (", KT of the Wageningen B series" if curve else ""),
        ("oosterveld_van_oossanen_1975",) if curve else (),
    )
    untold = {name: UNTOLD for name in GROWTH if name in screw.sources}
    screw = replace(screw, sources=MappingProxyType({**screw.sources, **untold}))
    stated = [area for name in AREAS if (area := _number(rudder, name))]
    area = stated[0] if stated else rudder_area(ship)
    height = _number(rudder, "height")
    aspect = height**2 / area if height else ASPECT
    blade = _completed(
        CATALOGUE["rudder_mmg"],
        {**rudder, "area": area} if stated else rudder,
        rudder_values(ship, area=area, aspect=aspect, D=diameter)
        | {"rate_deg_s": steering_rate(ship, _number(rudder, "full_length"))},
        rudder_errors(drawn=bool(height) and _number(propeller, "D") is not None),
        "empirical: Fujii; Quadvlieg 2013; Yoshimura and Masumoto 2012",
        RUDDER_SOURCES,
    )
    return screw, blade


def hull_less_model(
    ship: Ship, water: Water, propeller: Mapping[str, Any], rudder: Mapping[str, Any]
) -> Model:
    """A ship with propeller and rudder as `parts_from_particulars`, and no hull yet.

    Parameters
    ----------
    ship, water : Ship, Water
        As tested.
    propeller, rudder : mapping
        What the campaign file states of both, by key.
    """
    parts = parts_from_particulars(ship, propeller, rudder)
    return Model(
        name=ship.name,
        ship=ship,
        water=water,
        parts=MappingProxyType({part.effect: part for part in parts}),
        notes=tuple(filter(None, map(_guessed, parts))),
        scale=f"L = {ship.L:.4g} m, the scale of the tests",
    )


def _guessed(part: Part) -> str:
    """What of a part was not stated, in words."""
    guessed = [name for name in part.values if part.source_of(name) != STATED]
    section = next(name for name, own in SECTIONS.items() if own.effect_name == part.effect)
    return (
        f"Not stated in [{section}] of the campaign file, so estimated from the "
        f"particulars: {', '.join(guessed)}."
        if guessed
        else ""
    )


def rudder_errors(*, drawn: bool) -> Mapping[str, StandardError]:
    """Errors of a rudder; what the slipstream reaches of it is `drawn` or an estimate too."""
    return {name: x for name, x in RUDDER_ERRORS.items() if not (drawn and name == "eta")}


def _series(given: Mapping[str, Any]) -> dict[str, float]:
    """The curves of the Wageningen B series, where the geometry is stated and no curve."""
    pitch, area = _number(given, "P_over_D"), _number(given, "area_ratio")
    if pitch is None or area is None or _number(given, "kt0") is not None:
        return {}
    J = np.linspace(0.0, HIGHEST_J, 17)
    blades = int(_number(given, "blades") or 4)
    try:
        KT, KQ = open_water_curve(J, pitch=pitch, area_ratio=area, blades=blades)
    except DataError:
        return {}
    return straight_polynomial(J, KT, KQ)


def straight_polynomial(J: Array, KT: Array, KQ: Array) -> dict[str, float]:
    """Open-water curves as the polynomials of the effect ``propeller``, up to J = 0.8.

    Parameters
    ----------
    J, KT, KQ : array (n,)
        Advance ratio and coefficients.
    """
    inside = J <= HIGHEST_J
    found: dict[str, float] = {}
    for name, values in (("kt", KT), ("kq", KQ)):
        fitted = np.polyfit(J[inside], values[inside], 2)[::-1]
        found |= {f"{name}{power}": float(x) for power, x in enumerate(fitted)}
    return found


def _completed(
    effect: Effect,
    given: Mapping[str, Any],
    guess: Mapping[str, float],
    errors: Mapping[str, StandardError],
    source: str,
    references: tuple[str, ...] = (),
) -> Part:
    """A part whose values are those stated, and the guess where nothing is."""
    options = _options(effect, given, guess)
    needed = [item for item in effect.parameters if _belongs(item, options)]
    stated = {item.name: x for item in needed if (x := _number(given, item.name)) is not None}
    lacking = {
        item.name for item in needed if item.default is None or not stated or item.name in errors
    }
    guessed = {name: guess[name] for name in guess if name in lacking and name not in stated}
    return Part(
        effect=effect.name,
        options=MappingProxyType(options),
        values=MappingProxyType({**stated, **guessed}),
        source=STATED if stated else source,
        sources=MappingProxyType(dict.fromkeys(guessed, source) if stated else {}),
        references=references if guessed else (),
        std=MappingProxyType(
            {name: errors[name].of(x) for name, x in guessed.items() if name in errors}
        ),
    )


def _options(
    effect: Effect, given: Mapping[str, Any], guess: Mapping[str, float]
) -> dict[str, str]:
    """The form that is stated; else the first for which everything is stated or guessed."""
    found: dict[str, str] = {}
    for name, words in effect.options.items():
        if given.get(name) in words:
            found[name] = str(given[name])
            continue
        whole = [
            word
            for word in words
            if all(
                item.default is not None or item.name in guess or item.name in given
                for item in effect.parameters
                if item.form is not None and item.form[0] == name and word in item.form[1:]
            )
        ]
        found[name] = whole[0] if whole else words[0]
    return found


def _belongs(item: Parameter, options: Mapping[str, str]) -> bool:
    return item.form is None or options[item.form[0]] in item.form[1:]


def _number(given: Mapping[str, Any], name: str) -> float | None:
    value = given.get(name)
    return float(value) if isinstance(value, int | float) else None
