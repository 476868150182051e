"""Shallow water: the derivatives of the hull grow as the bottom comes near."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Final

from pmmkit.base import DataError
from pmmkit.conventions import Derivative, Ship, parse_derivative
from pmmkit.effects.definition import Effect, Parameter

SHALLOW_WATER: Final = Effect(
    name="shallow_water",
    family="environment",
    kind="force",
    roles=("depth",),
    summary="Derivatives of hull and added mass at the depth of the manoeuvre, from those in deep "
    "water.",
    parameters=(
        Parameter(
            name="lambda_Yv", text="power of the bottom's effect on Yv", default=2.3, low=0.0
        ),
        Parameter(name="lambda_Nv", text="on Nv", default=1.7, low=0.0),
        Parameter(name="lambda_Nr", text="on Yr and Nr", default=0.7, low=0.0),
        Parameter(
            name="share",
            text="share of what the formulas add that this ship feels",
            default=1.0,
            typical=1.0,
        ),
    ),
    needs=("depth",),
    excites=("depth",),
    not_captive="tests at each depth have a table of their own; how it grows from depth to depth "
    "stands beside these formulas",
    check="the same manoeuvre in deep water",
    sources=("hirano_1985", "kijima_1990", "ankudinov_1990"),
    remark="added mass and products from the last; all as public programs quote them, not "
    "against their texts",
)
EFFECTS: Final = (SHALLOW_WATER,)
SHALLOWEST: Final = 1.2
"""Least depth over draught for which the formulas are taken."""


def aspect_ratio(k: float, draught_over_depth: float, power: Any) -> Any:
    """Aspect ratio k = 2d/L of a hull that seems longer between bottom and surface.

    k / [k d/(2h) + (πd/(2h) cot(πd/(2h)))^λ], Hirano et al. 1985.

    Examples
    --------
    >>> aspect_ratio(0.13, 0.0, 2.3)
    0.13
    >>> round(aspect_ratio(0.13, 0.5, 2.3) / 0.13, 2)
    1.65
    """
    half = 0.5 * draught_over_depth
    if half == 0.0:
        return k
    angle = math.pi * half
    return k / (k * half + (angle / math.tan(angle)) ** power)


def factors(
    depth: float,
    d: float,
    L: float,
    B: float,
    CB: float,
    *,
    lambda_Yv: Any = 2.3,
    lambda_Nv: Any = 1.7,
    lambda_Nr: Any = 0.7,
    share: Any = 1.0,
) -> dict[str, Any]:
    """What derivatives are multiplied by in water of a depth.

    d, L, B [m].

    Notes
    -----
    Yv, Nv, Nr: Inoue's formulas -(πk/2 + 1.4 CB B/L), -k, -(0.54 k - k²) with the effective aspect
    ratio in place of k (Hirano et al. 1985); Yr with k alone. Between 1.5 and 3 draughts Kijima's
    (1990) 1/(1 - d/h)^n - d/h with n = 0.40 CB B/d (Yv) and 0.425 CB B/d (Nv) lies within a tenth
    of it for a full tanker (KVLCC2); for the finer S175 its Yv is a third lower at 1.5 draughts. Nr
    turns back close to the bottom where d/L is above 0.07.

    Added mass, X and products: Ankudinov et al. 1990, with F = h/d - 1, b = CB (B/d)(1 + B/L)² and
    K0 + a1 K1 b + a2 K2 b². For B/d above 4 K2 = 0.137 d/(B F), which meets 0.0342/F at 4; a
    program at hand has B/d there. Nvvr and Nvrr 1 + 6 (d/h)^2.5, resistance 1 + 0.388 (d/h)²
    (Furukawa et al. 2016). Not included: sinkage and trim, the ship's own waves towards the
    critical speed sqrt(g h), and what becomes of wake, thrust deduction and flow at the rudder.
    Hulls with cross-flow drag take the factor of Yvvv on its coefficient. Below about two draughts
    the tactical diameters of the library's ships by these formulas hardly grow any more, or fall.

    Examples
    --------
    >>> found = factors(41.6, 20.8, 320.0, 58.0, 0.81)
    >>> {name: round(found[name], 2) for name in ("Yv", "Nv", "Nr", "Yvdot")}
    {'Yv': 1.32, 'Nv': 1.44, 'Nr': 1.09, 'Yvdot': 1.24}
    """
    if not depth >= SHALLOWEST * d:
        raise DataError(
            f"The depth {depth:g} m is {depth / d:.2f} draughts; the formulas for shallow water "
            f"hold down to {SHALLOWEST:g}. Choose a depth of {SHALLOWEST * d:.4g} m or more."
        )
    near = d / depth
    k, c = 2.0 * d / L, 1.4 * CB * B / L
    sway, turn, yaw = (aspect_ratio(k, near, power) for power in (lambda_Yv, lambda_Nv, lambda_Nr))
    clearance = near / (1.0 - near)  # d/(h - d), zero in deep water
    b = CB * (B / d) * (1.0 + B / L) ** 2
    K0 = 1.0 + 0.0775 * clearance**2 - 0.011 * clearance**3 + 0.000068 * clearance**5
    K1 = (
        -0.0643 * clearance
        + 0.0724 * clearance**2
        - 0.0113 * clearance**3
        + 0.0000767 * clearance**5
    )
    K2 = (0.0342 if 4.0 * d >= B else 0.137 * d / B) * clearance

    def strip(first: float, second: float) -> float:
        return K0 + first * K1 * b + second * K2 * b**2

    cross = 1.5 * strip(1 / 2, 1 / 3) - 0.5
    grown = {
        "Yv": (0.5 * math.pi * sway + c) / (0.5 * math.pi * k + c),
        "Yr": yaw / k,
        "Nv": turn / k,
        "Nr": (0.54 * yaw - yaw**2) / (0.54 * k - k**2),
        "Yvvv": cross,
        "Yrrr": strip(8 / 15, 40 / 105),
        "Nvvr": 1.0 + 6.0 * near**2.5,
        "Xuu": 1.0 + 0.388 * near**2,
        "Xvv": cross,
        "Xvr": strip(2 / 5, 24 / 105),
        "Xrr": strip(1 / 2, 1 / 3),
        "Yvdot": strip(2 / 3, 8 / 15),
        "Nrdot": strip(8 / 15, 40 / 105),
    }
    return {name: 1.0 + share * (factor - 1.0) for name, factor in grown.items()}


def apply(
    values: Mapping[str, Any], *, ship: Ship, depth: float, nearly: float = 1.0, **powers: Any
) -> dict[str, Any]:
    """Values of a part at a depth, from those in deep water.

    Parameters
    ----------
    values : mapping
        Derivatives by name, in any non-dimensional system: each is multiplied by a ratio.
    ship : Ship
        Length, breadth, draught and block.
    depth : float
        Depth of the water [m].
    nearly : float
        Share of the least depth from which they are taken as at that depth.
    **powers : float
        Parameters of the effect.

    Returns
    -------
    dict
        K follows Y. Terms of the rudder and of roll, and the added mass of surge, do not change.
        In tables whose derivatives hold the added-mass Coriolis terms, these grow with them.

    Raises
    ------
    DataError
        If the depth is less than 1.2 draughts.

    Examples
    --------
    >>> ship = Ship(name="s", L=320.0, B=58.0, d=20.8, volume=312600.0, mass=3.2e8, Izz=2e12)
    >>> found = apply({"Yv": -0.315, "Yd": -0.05}, ship=ship, depth=31.2)
    >>> round(found["Yv"], 3), found["Yd"]
    (-0.597, -0.05)
    """
    least = SHALLOWEST * ship.d
    if depth >= nearly * least:
        depth = max(depth, least)
    found = factors(depth, ship.d, ship.L, ship.B, ship.block, **powers)
    return {
        name: value if name == "lx" else value * found.get(_like(parse_derivative(name)), 1.0)
        for name, value in values.items()
    }


def _like(derivative: Derivative) -> str:
    """The derivative whose factor one takes, empty where it does not change."""
    if any(derivative.count(other) for other in ("d", "T", "phi", "p", "pdot")):
        return ""
    sway, yaw = derivative.count("v"), derivative.count("r")
    X, N = derivative.channel == "X", derivative.channel == "N"
    for dot, share in (("udot", ""), ("vdot", "Yvdot"), ("rdot", "Nrdot")):
        if dot in derivative.factors:
            return "" if X else share
    if X:
        return ("Xvr" if yaw else "Xvv") if sway else "Xrr" if yaw else "Xuu"
    if sway + yaw == 1:
        return ("N" if N else "Y") + ("v" if sway else "r")
    if sway and yaw:
        return "Nvvr" if N else "Yvvv"
    return "Yvvv" if sway else "Yrrr" if yaw else ""
