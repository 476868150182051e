"""A whole model from particulars, each value marked as an estimate."""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

import numpy as np

from pmmkit.bibliography import cite
from pmmkit.conventions import force_unit
from pmmkit.effects.added_mass import INERTIA
from pmmkit.effects.hull import HULL
from pmmkit.effects.propeller import PROPELLER
from pmmkit.effects.rudder import RUDDER_MMG
from pmmkit.empirical import (
    METHODS,
    RUDDER_SOURCES,
    Estimate,
    estimate,
    friction_coefficient,
    rudder_values,
    wake_fraction,
    wetted_surface,
)
from pmmkit.models.model import Model, Part
from pmmkit.models.step import Step
from pmmkit.ship import Ship, Water, viscosity

SURGE: Final = "yoshimura-masumoto"
"""The method whose surge terms stand in all models."""


def estimated_model(
    ship: Ship,
    method: str = "yoshimura-masumoto",
    *,
    speed: float,
    propeller_diameter: float,
    rudder_area: float,
    rudder_aspect: float = 1.6,
    rate_deg_s: float = 2.32,
    resistance: float | None = None,
    water: Water | None = None,
) -> Model:
    """A model that can be simulated, from a ship's particulars alone.

    Parameters
    ----------
    ship : Ship
        Particulars.
    method : str
        One of `pmmkit.empirical.METHODS`. Only ``yoshimura-masumoto`` gives surge terms: they
        stand in the others too. The linear ones (``clarke`` and so on) give a model that says
        that it holds for small rudder angles.
    speed : float
        Service speed [m/s], for the resistance.
    propeller_diameter : float
        [m]
    rudder_area : float
        [m²]
    rudder_aspect : float
        Height squared over area.
    rate_deg_s : float
        Rate of the steering gear [deg/s]; by default the least that SOLAS allows.
    resistance : float, optional
        Resistance at that speed [N]; by default ITTC 1957 friction with a form factor of 1.2, an
        allowance of 0.0004 and a residuary coefficient of 0.0006 on a wetted surface of
        1.7 L d + volume/d.
    water : Water, optional
        Salt water by default.

    Returns
    -------
    Model
        With the standard errors of the methods, independent of each other, as covariance.

    Raises
    ------
    UnknownNameError
        If there is no such method.

    Examples
    --------
    >>> from pmmkit.ship_library import load_ship
    >>> from pmmkit.simulation import simulate
    >>> model = estimated_model(load_ship("kvlcc2"), speed=7.97, propeller_diameter=9.86,
    ...                         rudder_area=112.5)
    >>> 2.0 < simulate(model, speed=7.97, compiled=False).metrics["tactical_diameter_L"] < 4.5
    True
    """
    sea = water or Water()
    guess = estimate(ship, method)
    lent, doubt = _surge(guess, ship)
    values, std = {**lent, **guess.values}, {**doubt, **guess.std}
    unit = force_unit(
        "X", guess.convention.system, L=ship.L, d=ship.d, volume=ship.volume, rho=sea.rho, g=sea.g,
        U=speed,
    )  # fmt: skip
    values["Xuu"] = -(resistance or _resistance(ship, sea, speed)) / unit
    mass = {name: x for name, x in values.items() if name.endswith("dot")}
    hull = {name: x for name, x in values.items() if name not in mass}
    w = wake_fraction(ship)
    screw = {
        "D": propeller_diameter,
        "t": 0.2,
        "kt0": 0.33,
        "kt1": -0.3,
        "kt2": -0.13,
        "wp": w,
        "xp": -0.48,
    }
    blade = rudder_values(ship, area=rudder_area, aspect=rudder_aspect, D=propeller_diameter)
    surge = METHODS[SURGE].sources
    hull_sources = [guess.sources[0], surge[0]]
    if not resistance:
        hull_sources.append("ittc_1957")
    parts = (
        Part(
            effect=HULL,
            values=MappingProxyType(hull),
            source=f"empirical: {guess.source}",
            references=tuple(dict.fromkeys(hull_sources)),
            sources=MappingProxyType(
                {name: f"empirical: {cite(surge[0])}" for name in lent if name in hull}
                | {"Xuu": "measured: resistance" if resistance else "empirical: ITTC 1957 friction"}
            ),
        ),
        Part(
            effect=INERTIA,
            values=MappingProxyType(mass),
            source=f"empirical: {cite(guess.sources[1])}",
            references=tuple(
                dict.fromkeys([guess.sources[1], *(surge[1:] if "Xudot" in lent else ())])
            ),
            sources=MappingProxyType(
                {name: f"empirical: {cite(surge[1])}" for name in lent if name in mass}
            ),
        ),
        Part(
            effect=PROPELLER.name,
            values=MappingProxyType(screw),
            source="empirical: typical propeller of a merchant ship, wake 0.5 CB - 0.05",
        ),
        Part(
            effect=RUDDER_MMG.name,
            options=MappingProxyType({"inflow": "mmg"}),
            values=MappingProxyType(blade | {"rate_deg_s": rate_deg_s}),
            source="empirical: Fujii; Quadvlieg 2013; Yoshimura and Masumoto 2012",
            references=RUDDER_SOURCES,
        ),
    )
    return Model(
        name=ship.name,
        ship=ship,
        water=sea,
        convention=guess.convention.with_(surge=METHODS[SURGE].convention.surge),
        parts=MappingProxyType({part.effect: part for part in parts}),
        title=f"{ship.name}, estimated from its particulars",
        scale=f"L = {ship.L:g} m; propulsion point: self-propulsion of the model's equations",
        covariance=np.diag([x * x for x in std.values()]),
        covariance_names=tuple(std),
        notes=(
            "Every value is an estimate from particulars: a first look, not a verdict.",
            *(f"{guess.source}: {text}." for text in guess.notes),
        ),
        steps=(Step(action="estimated", method=method),),
    )


def _surge(guess: Estimate, ship: Ship) -> tuple[dict[str, float], dict[str, float]]:
    """Surge terms that a method lacks and their standard errors, in its system and signs."""
    other = estimate(ship, SURGE)
    names = [name for name in other.values if name[0] == "X" and name not in guess.values]
    over = 1.0 if guess.convention.system == other.convention.system else ship.d / ship.L
    side = -1.0 if guess.convention.sway == "beta" else 1.0
    values = {name: over * other.values[name] * (side if name == "Xvr" else 1.0) for name in names}
    return values, {name: over * other.std[name] for name in names}


def _resistance(ship: Ship, water: Water, speed: float) -> float:
    friction = friction_coefficient(speed * ship.L / viscosity(water))
    return 0.5 * water.rho * wetted_surface(ship) * speed**2 * (1.2 * friction + 0.0010)
