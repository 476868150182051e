"""A model at another scale: Froude's law alone, or with friction and wake of the ship."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np

from pmmkit.base import MissingPartError, ModelError, Problem, Remedy, Way
from pmmkit.conventions import Ship, Water
from pmmkit.effects import HULL
from pmmkit.models.empirical import form_factor, friction_coefficient, wetted_surface
from pmmkit.models.model import Model
from pmmkit.models.part import Part, place_name
from pmmkit.models.step import Step, Value


def scaled(model: Model, length: float) -> Model:
    """The model at another scale by Froude's law, with no correction of friction or wake.

    Parameters
    ----------
    model : Model
        Any model.
    length : float
        Length between perpendiculars of the scaled ship [m].

    Returns
    -------
    Model
        Non-dimensional values, density and gravity stay; lengths grow with the scale, rates with
        its inverse root, masses with its cube.

    Raises
    ------
    ModelError
        If the length is not positive.
    """
    if not (math.isfinite(length) and length > 0):
        raise ModelError(f"The length {length} m must be positive.")
    ratio = length / model.ship.L
    powers = {
        "L": 1,
        "B": 1,
        "d": 1,
        "volume": 3,
        "mass": 3,
        "Izz": 5,
        "xG": 1,
        "zG": 1,
        "GM": 1,
        "Ixx": 5,
        "balance_mass": 3,
        "balance_Izz": 5,
        "balance_xG": 1,
    }
    ship = replace(
        model.ship,
        **{
            name: getattr(model.ship, name) * ratio**power
            for name, power in powers.items()
            if getattr(model.ship, name) is not None
        },
    )
    parts = {
        name: replace(
            part,
            values=MappingProxyType(
                {
                    key: _times(value, ratio ** _scaling(part, key))
                    for key, value in part.values.items()
                }
            ),
            std=MappingProxyType(
                {key: x * ratio ** _scaling(part, key) for key, x in part.std.items()}
            ),
        )
        for name, part in model.parts.items()
    }
    factors = {
        place_name(effect, name): ratio ** _scaling(part, name)
        for effect, part in model.parts.items()
        for name in part.values
    }
    spread = np.tile([factors[x] for x in model.covariance_names], max(len(model.Fn), 1))
    step = Step(
        action="scaled",
        numbers=MappingProxyType({"length_before": model.ship.L, "length": float(length)}),
    )
    return replace(
        model,
        ship=ship,
        parts=MappingProxyType(parts),
        covariance=None
        if model.covariance is None
        else model.covariance * np.outer(spread, spread),
        scale=f"L = {length:g} m, by Froude's law from L = {model.ship.L:g} m without correction "
        f"of friction or wake ({model.scale})",
        steps=(*model.steps, step),
    )


def _scaling(part: Part, name: str) -> float:
    parameter = part.known.parameter(name)
    return 0.0 if parameter is None else parameter.scaling


def _times(value: Value, factor: float) -> Value:
    return tuple(x * factor for x in value) if isinstance(value, tuple) else value * factor


def full_scale(
    model: Model,
    length: float,
    *,
    speed: float | None = None,
    form: float | None = None,
    wetted: float | None = None,
    roughness: float = 150e-6,
    water: Water | None = None,
    wake: bool = True,
) -> Model:
    """The model of the ship from that of the ship model: friction and wake corrected.

    Froude's law carries over everything but two values. The resistance loses the excess of skin
    friction that a small hull has (with it the propeller works at the propulsion point of the
    ship), and the wake becomes thinner, and with it the inflow of the rudder, which the model
    keeps as a multiple of that of the propeller (``epsilon``).

    Parameters
    ----------
    model : Model
        At the scale of the tests, at the propulsion point of the model.
    length : float
        Length between perpendiculars of the ship [m].
    speed : float, optional
        Speed of the ship [m/s] for the Reynolds numbers; needed where the model has one set of
        values for all speeds.
    form : float, optional
        Form factor k; by default Watanabe's estimate.
    wetted : float, optional
        Wetted surface of the ship [m²]; by default 1.7 L d + volume/d.
    roughness : float
        Height of the roughness of the ship's hull [m].
    water : Water, optional
        Of the ship; by default that of the model, which then keeps its density.
    wake : bool
        Whether to scale the wake.

    Returns
    -------
    Model
        ``scale`` and ``steps`` state what was done, with the numbers.

    Raises
    ------
    MissingPartError
        If the model does not keep resistance and propulsion apart.
    ModelError
        If the length or the speed is missing or not positive, or the ship is no larger.

    Notes
    -----
    ITTC 1957: CF = 0.075/(log10 Re - 2)². ITTC 1978: CT of the ship less that of the model is
    (1 + k)(CFs - CFm) + ΔCF, ΔCF = [105 (ks/L)^(1/3) - 0.64] 10⁻³, not below 0; and for a single
    screw behind which the rudder stands ws = t + 0.04 + (wm - t - 0.04)
    [(1 + k) CFs + ΔCF]/[(1 + k) CFm], not above wm. The kinematic viscosity is that of fresh or
    salt water at 15 °C where ``water.nu`` is absent.

    References
    ----------
    ITTC recommended procedure 7.5-02-03-01.4, 1978 performance prediction method, 1999.
    Watanabe 1973 for the form factor, as quoted in textbooks.

    Examples
    --------
    >>> from pmmkit.models.store import load_model
    >>> ship = full_scale(load_model("kvlcc2-l7"), 320.0, speed=7.97, form=0.2)
    >>> round(ship.values("propeller")["wp"], 3), round(ship.values("hull_polynomial")["Xuu"], 4)
    (0.328, -0.0143)
    """
    carried = scaled(model, length)
    hull = carried.part(HULL, "the correction of friction").values
    if "Xuu" not in hull or not any(part.known.drives for part in model.parts.values()):
        raise MissingPartError(
            Problem(
                message=f"Model {model.name!r} does not keep the resistance of its hull (Xuu) "
                f"apart from the thrust of a propeller: there is no friction to correct.",
                remedy=Remedy("Take {}.", (Way("scaled()", "--froude-only"),)),
            )
        )
    if length <= model.ship.L:
        raise ModelError(
            f"The ship of {length:g} m must be longer than the model of {model.ship.L:g} m."
        )
    sea = water or model.water
    g = model.water.g
    if (speed is None) == (not model.Fn):
        raise ModelError(
            f"Model {model.name!r} has "
            + (
                "values at several Froude numbers and is corrected at each: give no speed."
                if model.Fn
                else "one set of values for all speeds: say the speed of the ship."
            )
        )
    numbers = model.Fn if speed is None else (carried.ship.froude(speed, g),)
    if not all(math.isfinite(x) and x > 0 for x in numbers):
        raise ModelError(f"The speed {speed} m/s must be positive.")
    ship, small = carried.ship, model.ship
    k = form_factor(ship) if form is None else form
    surface = wetted_surface(ship) if wetted is None else wetted
    extra = max(105.0 * (roughness / length) ** (1.0 / 3.0) - 0.64, 0.0) * 1e-3
    of_model = [
        friction_coefficient(small.speed(x, g) * small.L / model.water.viscosity) for x in numbers
    ]
    of_ship = [friction_coefficient(ship.speed(x, g) * ship.L / sea.viscosity) for x in numbers]
    side = ship.L**2 if model.convention.system == "prime" else ship.L * ship.d
    if model.convention.system == "bis":
        side = 2.0 * ship.volume / ship.L
    less = [
        ((1.0 + k) * (m - s) - extra) * surface / side
        for m, s in zip(of_model, of_ship, strict=True)
    ]
    parts = dict(carried.parts)
    parts[HULL] = _changed(carried, HULL, "Xuu", lambda value, i: min(value + less[i], 0.0))
    friction: dict[str, Value] = {
        "form": k,
        "wetted": surface,
        "roughness_um": roughness * 1e6,
        "roughness_allowance": extra,
        "CF_model": tuple(of_model),
        "CF_ship": tuple(of_ship),
        "Xuu_gain": tuple(less),
    }
    steps = [Step(action="friction_corrected", numbers=MappingProxyType(friction))]
    if wake and "propeller" in parts:
        screw = carried.values("propeller", model.Fn[0] if model.Fn else None)
        share = [
            ((1.0 + k) * s + extra) / ((1.0 + k) * m)
            for m, s in zip(of_model, of_ship, strict=True)
        ]
        floor = screw["t"] + 0.04
        parts["propeller"] = _changed(
            carried,
            "propeller",
            "wp",
            lambda value, i: min(floor + (value - floor) * share[i], value),
        )
        wakes = {
            f"wp_{place}": part.values["wp"]
            for place, part in (("model", carried.parts["propeller"]), ("ship", parts["propeller"]))
        }
        steps.append(Step(action="wake_corrected", numbers=MappingProxyType(wakes)))
    done = "friction" + (" and wake" if len(steps) > 1 else "")
    return replace(
        carried,
        parts=MappingProxyType(parts),
        water=sea,
        ship=replace(ship, **_in_other_water(ship, sea.rho / model.water.rho)),
        scale=f"L = {length:g} m, ship scale from L = {small.L:g} m with {done} corrected; "
        f"propulsion point of the ship",
        steps=(*carried.steps, *steps),
    )


def _changed(model: Model, effect: str, name: str, law: Callable[[float, int], float]) -> Part:
    """A part with one value changed at each Froude number."""
    part = model.parts[effect]
    value = part.values[name]
    if isinstance(value, tuple):
        new: Value = tuple(law(x, i) for i, x in enumerate(value))
    else:
        new = tuple(law(value, i) for i in range(len(model.Fn))) if model.Fn else law(value, 0)
    noted = {**part.sources, name: f"{part.source_of(name)}; corrected to the scale of the ship"}
    return replace(
        part, values=MappingProxyType({**part.values, name: new}), sources=MappingProxyType(noted)
    )


def _in_other_water(ship: Ship, ratio: float) -> dict[str, Any]:
    """Masses and inertia of the same hull at the same draught in water of another density."""
    names = ("mass", "Izz", "Ixx", "balance_mass", "balance_Izz")
    return {name: x * ratio for name in names if (x := getattr(ship, name)) is not None}
