"""A whole model from particulars, each value marked as an estimate."""

from __future__ import annotations

from types import MappingProxyType

from pmmkit.bibliography import cite
from pmmkit.effects.added_mass import INERTIA
from pmmkit.effects.hull import HULL
from pmmkit.effects.propeller import PROPELLER
from pmmkit.effects.rudder import RUDDER_MMG
from pmmkit.empirical import (
    METHODS,
    RUDDER_SOURCES,
    estimate,
    friction_coefficient,
    rudder_values,
    wake_fraction,
    wetted_surface,
)
from pmmkit.errors import MissingPartError, UnknownNameError
from pmmkit.models.model import Model, Part
from pmmkit.models.step import Step
from pmmkit.ship import Ship, Water, viscosity


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
    method : {"yoshimura-masumoto", "kijima"}
        Nonlinear hull; the linear methods do not carry a turning circle. Kijima gives no surge
        terms: those of Yoshimura and Masumoto are taken.
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

    Raises
    ------
    UnknownNameError
        If there is no such method.
    MissingPartError
        If the method has no nonlinear terms.

    Examples
    --------
    >>> from pmmkit.ship_library import load_ship
    >>> from pmmkit.simulation import simulate
    >>> model = estimated_model(load_ship("kvlcc2"), speed=7.97, propeller_diameter=9.86,
    ...                         rudder_area=112.5)
    >>> 2.0 < simulate(model, speed=7.97, compiled=False).metrics["tactical_diameter_L"] < 4.5
    True
    """
    if method not in METHODS:
        raise UnknownNameError(f"There is no method {method!r}; there are: {', '.join(METHODS)}.")
    sea = water or Water()
    guess = estimate(ship, method)
    if guess.convention.system == "prime":
        raise MissingPartError(
            f"{method} gives linear derivatives only, which do not carry a manoeuvre. Take "
            f"yoshimura-masumoto or kijima, or join its values with tests (to_model)."
        )
    surge = {
        name: value
        for name, value in estimate(ship, "yoshimura-masumoto").values.items()
        if name[0] == "X" and name != "Xudot"
    }
    if guess.convention.sway == "beta":
        surge = {name: -x if name == "Xvr" else x for name, x in surge.items()}
    values = {**surge, **guess.values}
    unit = 0.5 * sea.rho * ship.L * ship.d * speed**2
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
    hull_sources = [guess.sources[0], METHODS["yoshimura-masumoto"].sources[0]]
    if not resistance:
        hull_sources.append("ittc_1957")
    parts = (
        Part(
            effect=HULL,
            values=MappingProxyType(hull),
            source=f"empirical: {guess.source}",
            references=tuple(dict.fromkeys(hull_sources)),
            sources=MappingProxyType(
                {"Xuu": "measured: resistance" if resistance else "empirical: ITTC 1957 friction"}
            ),
        ),
        Part(
            effect=INERTIA,
            values=MappingProxyType(mass),
            source=f"empirical: {cite(guess.sources[1])}",
            references=guess.sources[1:],
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
        convention=guess.convention,
        parts=MappingProxyType({part.effect: part for part in parts}),
        title=f"{ship.name}, estimated from its particulars",
        scale=f"L = {ship.L:g} m; propulsion point: self-propulsion of the model's equations",
        notes=("Every value is an estimate from particulars: a first look, not a verdict.",),
        steps=(Step(action="estimated", method=method),),
    )


def _resistance(ship: Ship, water: Water, speed: float) -> float:
    friction = friction_coefficient(speed * ship.L / viscosity(water))
    return 0.5 * water.rho * wetted_surface(ship) * speed**2 * (1.2 * friction + 0.0010)
