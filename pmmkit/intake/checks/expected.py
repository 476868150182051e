"""What size forces should have: rough estimates from the particulars, to tell a factor by."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from pmmkit.effects import apply

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign
    from pmmkit.conventions import Ship, Water

SHALLOW: Final = 3.0
"""Draughts of depth above which the bottom is not felt (ITTC 7.5-02-06-02)."""
ROUND_FACTORS: Final[tuple[tuple[float, str], ...]] = (
    (9.80665, "g: kilogram-force against newton"),
    (1000.0, "1000: kilo, or milli"),
    (1e6, "a million"),
    (180 / math.pi, "180/π: degrees against radians"),
    (2 * math.pi, "2π: revolutions against radians"),
    (60.0, "60: minutes against seconds"),
    (3600 / 1852, "1.944: knots against m/s"),
    ((3600 / 1852) ** 2, "1.944²: knots against m/s, squared"),
    (10.0, "10"),
    (100.0, "100: per cent, or centimetres"),
    (2.0, "2: ½ρ against ρ, or half a ship"),
)


@dataclass(frozen=True, kw_only=True)
class ExpectedHull:
    """Estimates for a hull, SI.

    `m, Izz`: what oscillates on the balance [kg], [kg m²] about midship. `mx, my, Jz`: added
    masses [kg], added inertia [kg m²]. `Yv, Yr, Nv, Nr`: linear derivatives in the prime system
    [-].
    """

    m: float
    Izz: float
    mx: float
    my: float
    Jz: float
    Yv: float
    Yr: float
    Nv: float
    Nr: float
    wetted: float


def expected(campaign: Campaign) -> ExpectedHull:
    """Estimates for the ship of a campaign.

    Linear derivatives and accelerations after Clarke, Gedling and Hine (1983), surge added mass
    5 % of the mass, wetted surface 1.7 L d + volume/d (Denny, Mumford). Right within some 30 %
    for merchant hulls in deep water, which is enough to tell a factor of two. In less water than
    three draughts they grow as `pmmkit.effects.shallow_water.factors` says, which holds within a
    factor of two or so down to 1.2 draughts, and is taken there for less.

    Examples
    --------
    >>> from pmmkit.campaigns import Campaign
    >>> from pmmkit.conventions import Ship, Water
    >>> s175 = Ship(name="S175", L=175., B=25.4, d=8.5, volume=21222., mass=2.1752e7, Izz=3.84e10)
    >>> guess = expected(Campaign(title="", ship=s175, water=Water(rho=1025.), runs=()))
    >>> round(guess.Yv, 5), round(guess.Nr, 5), round(guess.my / guess.m, 2)
    (-0.01239, -0.00211, 1.09)
    """
    ship, rho = campaign.ship, campaign.water.rho
    L, B, d, block = ship.L, ship.B, ship.d, ship.block
    slender = math.pi * (d / L) ** 2
    force, inertia = 0.5 * rho * L**3, 0.5 * rho * L**5
    grown = _grown(campaign)
    return ExpectedHull(
        m=ship.mass if ship.balance_mass is None else ship.balance_mass,
        Izz=ship.Izz if ship.balance_Izz is None else ship.balance_Izz,
        mx=0.05 * ship.mass * grown["Xuu"],
        my=slender * (1 + 0.16 * block * B / d - 5.1 * (B / L) ** 2) * force * grown["Yvdot"],
        Jz=slender * (1 / 12 + 0.017 * block * B / d - 0.33 * B / L) * inertia * grown["Nrdot"],
        Yv=-slender * (1 + 0.4 * block * B / d) * grown["Yv"],
        Yr=-slender * (-0.5 + 2.2 * B / L - 0.08 * B / d) * grown["Yr"],
        Nv=-slender * (0.5 + 2.4 * d / L) * grown["Nv"],
        Nr=-slender * (0.25 + 0.039 * B / d - 0.56 * B / L) * grown["Nr"],
        wetted=1.7 * L * d + ship.volume / d,
    )


def is_shallow(campaign: Campaign) -> bool:
    """Whether the bottom is near enough to change what is expected."""
    depth = campaign.water.depth
    return depth is not None and depth < SHALLOW * campaign.ship.d


def _grown(campaign: Campaign) -> Mapping[str, float]:
    """By what derivatives grow with the bottom near; 1 in deep water."""
    ship, depth = campaign.ship, campaign.water.depth
    if depth is None or not is_shallow(campaign):
        return defaultdict(lambda: 1.0)
    names = ("Yv", "Yr", "Nv", "Nr", "Xuu", "Yvdot", "Nrdot")
    return apply(dict.fromkeys(names, 1.0), ship=ship, depth=depth, nearly=0.0)


def prime_unit(campaign: Campaign, name: str, speed: float) -> float:
    """Unit of a force, moment or motion in the prime system at a speed, SI.

    Examples
    --------
    >>> from pmmkit.campaigns import Campaign
    >>> from pmmkit.conventions import Ship, Water
    >>> ship = Ship(name="", L=2., B=1., d=.5, volume=1., mass=1., Izz=1.)
    >>> base = Campaign(title="", ship=ship, water=Water(rho=1000.), runs=())
    >>> prime_unit(base, "N", 3.0), prime_unit(base, "rdot", 3.0)
    (36000.0, 2.25)
    """
    L = campaign.ship.L
    pressure = 0.5 * campaign.water.rho * speed**2
    units = {
        "X": pressure * L**2,
        "Y": pressure * L**2,
        "N": pressure * L**3,
        "K": pressure * L**3,
        "T": pressure * L**2,
        "u": speed,
        "v": speed,
        "r": speed / L,
        "udot": speed**2 / L,
        "vdot": speed**2 / L,
        "rdot": (speed / L) ** 2,
    }
    return units[name]


def resistance_estimate(ship: Ship, water: Water, speed: float, wetted: float) -> float:
    """Resistance [N] of a smooth hull at low Froude number: 1.2 times the ITTC 1957 line."""
    reynolds = max(speed * ship.L / (water.nu or 1.14e-6), 1e5)
    friction = 0.075 / (math.log10(reynolds) - 2) ** 2
    return 1.2 * friction * 0.5 * water.rho * wetted * speed**2


def round_factor(ratio: float, ship: Ship | None = None, spread: float = 1.35) -> str | None:
    """The round factor, or its inverse, that a ratio comes near to, in words.

    Examples
    --------
    >>> round_factor(1 / 9.7)
    '1/g: kilogram-force against newton'
    >>> round_factor(27.0) is None
    True
    """
    candidates = list(ROUND_FACTORS)
    if ship is not None:
        candidates += [
            (ship.L / ship.d, f"L/d = {ship.L / ship.d:.3g}: ½ρL² against ½ρLd"),
            ((ship.L / ship.d) ** 2, "(L/d)²"),
            (ship.L, f"L = {ship.L:.4g} m: a moment in another arm"),
        ]
    size = abs(ratio)
    if not math.isfinite(size) or size == 0:
        return None
    tried = [(abs(math.log(size / factor)), words) for factor, words in candidates]
    tried += [(abs(math.log(size * factor)), f"1/{words}") for factor, words in candidates]
    distance, words = min(tried)
    return words if distance < math.log(spread) else None
