"""Shallow water: the derivatives of the hull grow as the bottom comes near."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Final

from pmmkit.effects.effect import Effect, Parameter
from pmmkit.errors import DataError
from pmmkit.ship import Ship

SHALLOW_WATER: Final = Effect(
    name="shallow_water",
    family="environment",
    kind="force",
    summary="Derivatives of hull and added mass at the depth of the manoeuvre, by the aspect ratio "
    "that the hull has between bottom and surface.",
    parameters=(
        Parameter(name="power_Yv", text="power of the bottom's effect on Yv", default=2.3, low=0.0),
        Parameter(name="power_Nv", text="on Nv", default=1.7, low=0.0),
        Parameter(name="power_Nr", text="on Nr", default=0.7, low=0.0),
        Parameter(
            name="power_mass", text="on the added mass of sway and yaw, an assumption",
            default=1.0, low=0.0,
        ),
    ),
    needs=("depth",),
    source="Effective aspect ratio of Hirano et al. 1985 and Kijima et al. 1990, in Inoue's "
    "formulas; checked for its limits, not against their texts",
)  # fmt: skip
EFFECTS: Final = (SHALLOW_WATER,)
SHALLOWEST: Final = 1.2
"""Least depth over draught for which the formulas are taken."""


def aspect_ratio(k: float, draught_over_depth: float, power: float) -> float:
    """Aspect ratio k = 2d/L of a hull that seems longer between bottom and surface.

    k / [k d/(2h) + (πd/(2h) cot(πd/(2h)))^λ]

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
    return k / (k * half + float((angle / math.tan(angle)) ** power))


def apply(
    values: Mapping[str, Any], *, ship: Ship, depth: float, power_Yv: float, power_Nv: float,
    power_Nr: float, power_mass: float,
) -> dict[str, Any]:  # fmt: skip
    """Values of a part at a depth, from those in deep water.

    Parameters
    ----------
    values : mapping
        Derivatives by name, in any non-dimensional system: each is multiplied by a ratio.
    ship : Ship
        Length, breadth, draught and block.
    depth : float
        Depth of the water [m].
    power_Yv, power_Nv, power_Nr, power_mass : float
        Parameters of the effect.

    Returns
    -------
    dict
        Terms odd in sway follow Yv in Y and Nv in N, terms of yaw follow Nr; X does not change.

    Raises
    ------
    DataError
        If the depth is less than 1.2 draughts.
    """
    if depth < SHALLOWEST * ship.d:
        raise DataError(
            f"The depth {depth:g} m is {depth / ship.d:.2f} draughts; the formulas for shallow "
            f"water hold down to {SHALLOWEST:g}."
        )
    k, c = 2.0 * ship.d / ship.L, 1.4 * ship.block * ship.B / ship.L
    at = {
        name: aspect_ratio(k, ship.d / depth, power)
        for name, power in (("Yv", power_Yv), ("Nv", power_Nv), ("Nr", power_Nr))
    }
    sway = (0.5 * math.pi * at["Yv"] + c) / (0.5 * math.pi * k + c)
    turn = at["Nv"] / k
    yaw = (0.54 * at["Nr"] - at["Nr"] ** 2) / (0.54 * k - k**2)
    mass = aspect_ratio(k, ship.d / depth, power_mass) / k

    def factor(name: str) -> float:
        if name == "lx" or name[0] not in "YN":
            return 1.0
        if name.endswith("dot"):
            return mass
        if "v" in name:
            return sway if name[0] == "Y" else turn
        return yaw if "r" in name else 1.0

    return {name: value * factor(name) for name, value in values.items()}
