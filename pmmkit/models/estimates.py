"""A whole model from particulars, each value marked as an estimate."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from types import MappingProxyType
from typing import Final

import numpy as np

from pmmkit.conventions import Convention, Ship, Water, cite
from pmmkit.effects import HULL, INERTIA
from pmmkit.models.empirical import (
    METHODS,
    RUDDER_SOURCES,
    HullEstimate,
    StandardError,
    estimate,
    friction_coefficient,
    rudder_values,
    wetted_surface,
)
from pmmkit.models.model import Model
from pmmkit.models.part import Part
from pmmkit.models.particulars import (
    ASPECT,
    PROPELLER_ERRORS,
    WAKE,
    propeller_values,
    rudder_errors,
)
from pmmkit.models.reference import hull_table
from pmmkit.models.step import Step
from pmmkit.models.tables.convert import converted, to_system
from pmmkit.models.tables.table import DerivativeTable, from_values

RESISTANCE_ERROR: Final = StandardError(
    0.25, ships=(), why="four tests at their scale lie 10 % off, surface and waves are more"
)
"""How far a resistance from friction, form factor 1.2 and little more may be off. The tests are of
KVLCC2 and KCS at 7 m, Esso Osaka at 3 m, and S175."""
FROUDE: Final = 0.2
"""For the resistance of a table over all speeds."""
COUPLINGS: Final = ("Yvvr", "Yvrr", "Nvvr", "Nvrr")
"""Terms of sway and yaw together."""
SURGE: Final = "yoshimura-masumoto"
"""The method whose surge terms stand in all models."""


def estimated_model(
    ship: Ship,
    method: str = "yoshimura-masumoto",
    *,
    speed: float,
    propeller_diameter: float,
    rudder_area: float,
    rudder_aspect: float | None = None,
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
        One of `pmmkit.models.empirical.METHODS`. Only ``yoshimura-masumoto`` gives surge terms:
        they stand in the others too. The linear ones (``clarke`` and so on) give a model that says
        that it holds for small rudder angles.
    speed : float
        Service speed [m/s], for the resistance.
    propeller_diameter : float
        [m]
    rudder_area : float
        [m²]
    rudder_aspect : float, optional
        Height squared over area; by default that of a usual rudder, 1.6, and what the slipstream
        reaches of the rudder is an estimate too.
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
    >>> from pmmkit.models.library import load_ship
    >>> from pmmkit.simulation import simulate
    >>> model = estimated_model(load_ship("kvlcc2"), speed=7.97, propeller_diameter=9.86,
    ...                         rudder_area=112.5)
    >>> 2.0 < simulate(model, speed=7.97).metrics["tactical_diameter_L"] < 4.5
    True
    """
    sea = water or Water()
    guess = estimate(ship, method)
    lent, doubt = _surge(guess, ship)
    values, std = {**lent, **guess.values}, {**doubt, **guess.std}
    values["Xuu"], std["Xuu"] = resistance_derivative(
        ship, sea, speed, guess.convention, resistance=resistance
    )
    mass = {name: x for name, x in values.items() if name.endswith("dot")}
    hull = {name: x for name, x in values.items() if name not in mass}
    screw = propeller_values(ship, D=propeller_diameter)
    blade = rudder_values(
        ship, area=rudder_area, aspect=rudder_aspect or ASPECT, D=propeller_diameter
    )
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
            effect="propeller",
            options=WAKE,
            values=MappingProxyType(screw),
            source="empirical: typical propeller of a merchant ship, wake 0.5 CB - 0.05",
            std=_errors(PROPELLER_ERRORS, screw, but="D"),
        ),
        Part(
            effect="rudder_mmg",
            options=MappingProxyType({"inflow": "mmg"}),
            values=MappingProxyType(blade | {"rate_deg_s": rate_deg_s}),
            source="empirical: Fujii; Quadvlieg 2013; Yoshimura and Masumoto 2012",
            references=RUDDER_SOURCES,
            std=_errors(rudder_errors(drawn=bool(rudder_aspect)), blade, but="area"),
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


def _errors(
    errors: Mapping[str, StandardError], values: Mapping[str, float], *, but: str
) -> Mapping[str, float]:
    """Standard uncertainties of estimates; what was stated has none."""
    return MappingProxyType(
        {k: error.of(values[k]) for k, error in errors.items() if k in values and k != but}
    )


def resistance_derivative(
    ship: Ship,
    water: Water,
    speed: float,
    convention: Convention,
    *,
    resistance: float | None = None,
) -> tuple[float, float]:
    """Xuu of a resistance, or by skin friction with its standard uncertainty.

    speed [m/s]; resistance [N].

    Examples
    --------
    >>> from pmmkit.models.library import load_ship
    >>> value, std = resistance_derivative(load_ship("kvlcc2"), Water(), 7.97, Convention())
    >>> round(value, 5), round(std, 5)
    (-0.00069, 0.00017)
    """
    unit = convention.force_unit("X", ship=ship, water=water, U=speed)
    if resistance:
        return -resistance / unit, 0.0
    value = -_resistance(ship, water, speed) / unit
    return value, RESISTANCE_ERROR.of(value)


def estimated_table(like: DerivativeTable) -> DerivativeTable:
    """Derivatives from the particulars of a table's ship, in the meaning of that table.

    Examples
    --------
    >>> from pmmkit.models.reference import hull_table
    >>> table = estimated_table(hull_table("s175-3dof"))
    >>> round(table.at()["Xvr"], 4), round(table.at()["Nvvr"], 3)
    (-0.0035, -0.031)
    """
    ship, water, target = like.ship, like.water, like.convention
    guess, cross = estimate(ship, SURGE), estimate(ship, "clarke")
    values, std = dict(guess.values), dict(guess.std)
    over = ship.L / ship.d
    for name in ("Yrdot", "Nvdot"):
        values[name], std[name] = over * cross.values[name], over * cross.std[name]
    froude = FROUDE if like.pooled else float(np.median(like.Fn))
    speed = froude * np.sqrt(water.g * ship.L)
    values["Xuu"], std["Xuu"] = resistance_derivative(ship, water, speed, guess.convention)
    if "Xuu" in like and np.isfinite(like["Xuu"]).any():
        known = float(np.nanmean(to_system(like.select(["Xuu"]), "prime-d")["Xuu"]))
        values["Xuu"], std["Xuu"] = known, 0.0
    meant = guess.convention
    if target.U != meant.U or target.surge == "delta-u":
        values = {name: x for name, x in values.items() if name[0] != "X" or name == "Xudot"}
        meant = meant.with_(U=target.U, surge=target.surge)
    rows = None if like.pooled else like.Fn.tolist()
    count = 1 if rows is None else len(rows)
    made = from_values(
        {name: x if rows is None else [x] * count for name, x in values.items()},
        std={name: x if rows is None else [x] * count for name, x in std.items() if name in values},
        Fn=rows,
        ship=ship,
        water=water,
        convention=meant,
        method=f"empirical: {guess.source}",
    )
    return converted(made, target)


@lru_cache(maxsize=64)
def with_open_couplings(model: Model) -> Model:
    """A model of which bands are made: terms that nobody asked for are open, not zero.

    Parameters
    ----------
    model : Model
        Any.

    Returns
    -------
    Model
        Where nothing of side force and moment goes with sway and yaw together (`Standing`), the
        terms of `COUPLINGS` are zero with the size of their estimate as standard uncertainty; else
        the model itself.

    Examples
    --------
    >>> from pmmkit.models.store import load_model
    >>> ship = load_model("s175-3dof")
    >>> with_open_couplings(ship) is ship
    True
    """
    turns = HULL in model.parts and model.acts_across(lambda v, r: v or r)
    if not turns or model.acts_across(lambda v, r: v and r):
        return model
    guess = estimated_table(hull_table(model))
    std = {name: float(np.mean(np.abs(guess[name]))) for name in COUPLINGS if name in guess}
    hull = model.parts[HULL]
    opened = replace(
        hull,
        values=MappingProxyType({**hull.values, **dict.fromkeys(std, 0.0)}),
        std=MappingProxyType({**hull.std, **std}),
    )
    return model.with_(parts=MappingProxyType({**model.parts, HULL: opened}))


def _surge(guess: HullEstimate, ship: Ship) -> tuple[dict[str, float], dict[str, float]]:
    """Surge terms that a method lacks and their standard errors, in its system and signs."""
    other = estimate(ship, SURGE)
    names = [name for name in other.values if name[0] == "X" and name not in guess.values]
    over = 1.0 if guess.convention.system == other.convention.system else ship.d / ship.L
    side = -1.0 if guess.convention.sway == "beta" else 1.0
    values = {name: over * other.values[name] * (side if name == "Xvr" else 1.0) for name in names}
    return values, {name: over * other.std[name] for name in names}


def _resistance(ship: Ship, water: Water, speed: float) -> float:
    friction = friction_coefficient(speed * ship.L / water.viscosity)
    return 0.5 * water.rho * wetted_surface(ship) * speed**2 * (1.2 * friction + 0.0010)
