"""From a model to the right-hand side of its equations of motion, on plain floats.

The functions from `hydrodynamics` on use floats, tuples and named tuples alone, the subset that
interpreted and compiled code share.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np

from pmmkit.effects import added_mass, propeller, roll, rudder
from pmmkit.effects.catalogue import catalogue
from pmmkit.effects.hull import Monomial, polynomial, polynomial_forces
from pmmkit.errors import DataError, MissingPartError, ModelError
from pmmkit.model import Model

STATES: Final = ("x", "y", "psi", "u", "v", "r", "p", "phi")
"""Order of the states; a model without roll has the first six."""
_SLOWEST: Final = 1e-9


class Constants(NamedTuple):
    """A model at one approach speed, SI.

    `reference` is the fixed speed of the non-dimensional system, 0 for the instantaneous speed;
    `square` the fixed square of the speed in the unit of force, 0 for that of `reference`.
    `inverse` is the inverse of the mass matrix of sway, yaw and roll, row by row.
    """

    L: float
    rho: float
    mass: float
    xG: float
    zG: float
    surge_mass: float
    inverse: tuple[float, ...]
    added: added_mass.AddedMass
    monomials: tuple[Monomial, ...]
    reference: float
    square: float
    loss_from: float
    propeller: propeller.Propeller | None
    rudder: rudder.Rudder | None
    roll: roll.Roll | None


def prepare(model: Model, speed: float, *, extrapolate: bool = False) -> Constants:
    """The constants of a model's equations for an approach speed.

    Parameters
    ----------
    model : Model
        A model with hull, added mass, propulsion and rudder.
    speed : float
        Approach speed [m/s]; the values of its Froude number hold throughout the manoeuvre.
    extrapolate : bool
        Allow a Froude number outside the model's range.

    Returns
    -------
    Constants

    Raises
    ------
    MissingPartError
        If a part is missing.
    ExtrapolationError
        If the speed is outside the range of the model's values.
    ModelError
        If the mass matrix cannot be inverted.

    Examples
    --------
    >>> from pmmkit.model import load_model
    >>> c = prepare(load_model("s175"), 9.0)
    >>> round(60 * self_propulsion(c, 9.0), 2)
    85.95
    """
    if not (math.isfinite(speed) and speed > 0):
        raise DataError(f"The approach speed {speed} m/s must be positive.")
    _check_parts(model)
    ship, water, convention = model.ship, model.water, model.convention
    Fn = ship.froude(speed, water.g)

    def values(effect: str) -> dict[str, float]:
        return model.values(effect, Fn, extrapolate=extrapolate) if effect in model.parts else {}

    def options(effect: str) -> dict[str, str]:
        return catalogue()[effect].chosen(model.parts[effect].options)

    added = added_mass.resolve(values("added_mass"), ship=ship, water=water, convention=convention)
    terms = values("hull_polynomial")
    for name, value in values("rudder_abkowitz").items():
        terms[name] = terms.get(name, 0.0) + value
    bis = convention.system == "bis"
    fixed = convention.U == "carriage" and not bis
    return Constants(
        L=ship.L,
        rho=water.rho,
        mass=ship.mass,
        xG=ship.xG,
        zG=ship.zG or 0.0,
        surge_mass=ship.mass - added.Xudot,
        inverse=_inverse_mass(model, added),
        added=added,
        monomials=polynomial(terms, ship=ship, water=water, convention=convention),
        reference=math.sqrt(water.g * ship.L) if bis else speed if fixed else 0.0,
        square=1.0 if bis else 0.0,
        loss_from=speed if convention.surge == "delta-u" else 0.0,
        propeller=propeller.resolve(values("propeller"), options("propeller"))
        if "propeller" in model.parts
        else None,
        rudder=rudder.resolve(values("rudder_mmg"), options("rudder_mmg"))
        if "rudder_mmg" in model.parts
        else None,
        roll=roll.resolve(values("roll"), options("roll"), ship=ship, water=water)
        if model.rolls
        else None,
    )


def _check_parts(model: Model) -> None:
    parts = model.parts
    missing = [name for name in ("hull_polynomial", "added_mass") if name not in parts]
    if "propeller" not in parts and model.convention.surge != "delta-u":
        missing.append("propeller")
    if "rudder_mmg" not in parts and "rudder_abkowitz" not in parts:
        missing.append("rudder_mmg (or rudder_abkowitz)")
    elif "rudder_mmg" in parts and "propeller" not in parts:
        missing.append("propeller")
    if missing:
        raise MissingPartError(
            f"Model {model.name!r} cannot be simulated: it has no part "
            f"{', '.join(dict.fromkeys(missing))}. Take parts from a library ship "
            f'(to_model(table, parts="…")) or write them into the model file.'
        )


def _inverse_mass(model: Model, added: added_mass.AddedMass) -> tuple[float, ...]:
    ship = model.ship
    zG = ship.zG or 0.0
    matrix = np.array(
        [
            [
                ship.mass - added.Yvdot,
                ship.mass * ship.xG - added.Yrdot,
                -ship.mass * zG - added.Ypdot,
            ],
            [ship.mass * ship.xG - added.Nvdot, ship.Izz - added.Nrdot, -added.Npdot],
            [
                -ship.mass * zG - added.Kvdot,
                -added.Krdot,
                (ship.Ixx or 0.0) - added.Kpdot if model.rolls else 1.0,
            ],
        ]
    )
    if not model.rolls:
        matrix[2, :2] = matrix[:2, 2] = 0.0
    size = np.array([1.0, 1.0 / ship.L, 1.0 / ship.L])
    balanced = matrix * size[:, None] * size[None, :]
    surge = ship.mass - added.Xudot
    if surge <= 0 or np.any(np.diagonal(matrix) <= 0) or np.linalg.det(balanced[:2, :2]) <= 0:
        raise ModelError(
            f"The mass matrix of model {model.name!r} is not positive: {surge:g} kg in surge, "
            f"{np.diagonal(matrix)} in sway, yaw and roll. Check Xudot, Yvdot, Nrdot (negative by "
            f"nature) and the masses of the ship."
        )
    inverse = np.linalg.inv(balanced) * size[:, None] * size[None, :]
    return tuple(inverse.ravel().tolist())


def hydrodynamics(
    u: float, v: float, r: float, p: float, phi: float, delta: float, n: float, c: Constants
) -> tuple[float, float, float, float]:
    """Forces of hull, propeller, rudder and righting, without those of acceleration.

    Parameters
    ----------
    u, v, r, p, phi : float
        Velocities at midship [m/s, rad/s], heel [rad].
    delta : float
        Rudder angle [rad], positive turns the ship to starboard.
    n : float
        Propeller revolutions per second.
    c : Constants
        From `prepare`.

    Returns
    -------
    X, Y, N, K : float
        [N] and [N m].
    """
    reference = c.reference
    if reference == 0.0:
        reference = max(math.sqrt(u * u + v * v), _SLOWEST)
    square = c.square if c.square > 0.0 else reference * reference
    X, Y, N, K = polynomial_forces(
        u, v, r, p, phi, delta, reference, square, c.loss_from, c.L, c.monomials
    )
    if c.propeller is not None:
        water = propeller.inflow(u, v, r, c.L, c.propeller)
        pull = propeller.thrust(water, n, c.rho, c.propeller)
        X += (1.0 - c.propeller.t) * pull
        if c.rudder is not None:
            jet = pull / (c.rho * c.propeller.D**2)
            along, across = rudder.flow(u, v, r, c.L, water, jet, c.rudder)
            normal = rudder.normal_force(along, across, delta, c.rho, c.rudder)
            x, y, turn, heel = rudder.forces(normal, delta, c.L, c.rudder)
            X += x
            Y += y
            N += turn
            K += heel
    if c.roll is not None:
        K += roll.moment(p, phi, c.roll)
    return X, Y, N, K


def accelerations(
    u: float, v: float, r: float, p: float, phi: float, delta: float, n: float, c: Constants
) -> tuple[float, float, float, float]:
    """Surge, sway [m/s²], yaw and roll acceleration [rad/s²] in ship axes at midship.

    m(u̇ - v r - xG r²), m(v̇ + u r + xG ṙ - zG ṗ), Izz ṙ + m xG (v̇ + u r) and
    Ixx ṗ - m zG (v̇ + u r) equal the forces; parameters as for `hydrodynamics`.
    """
    X, Y, N, K = hydrodynamics(u, v, r, p, phi, delta, n, c)
    X += (c.mass + c.added.coriolis_x) * v * r + c.mass * c.xG * r * r
    Y += (c.added.coriolis_y - c.mass) * u * r
    N -= c.mass * c.xG * u * r
    K += (c.added.coriolis_k + c.mass * c.zG) * u * r
    i = c.inverse
    if c.roll is None:
        return X / c.surge_mass, i[0] * Y + i[1] * N, i[3] * Y + i[4] * N, 0.0
    return (
        X / c.surge_mass,
        i[0] * Y + i[1] * N + i[2] * K,
        i[3] * Y + i[4] * N + i[5] * K,
        i[6] * Y + i[7] * N + i[8] * K,
    )


def rates(y: tuple[float, ...], delta: float, n: float, c: Constants) -> tuple[float, ...]:
    """Rates of the states `STATES` (the first six without roll).

    Parameters
    ----------
    y : tuple of float
        The states, SI and radians; x and y are earth-fixed.
    delta, n : float
        Rudder angle [rad], revolutions per second.
    c : Constants
        From `prepare`.

    Returns
    -------
    tuple of float
    """
    u, v, r = y[3], y[4], y[5]
    ahead, aside = math.cos(y[2]), math.sin(y[2])
    if c.roll is None:
        udot, vdot, rdot, _ = accelerations(u, v, r, 0.0, 0.0, delta, n, c)
        return u * ahead - v * aside, u * aside + v * ahead, r, udot, vdot, rdot
    p, phi = y[6], y[7]
    upright = math.cos(phi)
    udot, vdot, rdot, pdot = accelerations(u, v, r, p, phi, delta, n, c)
    level = v * upright
    return (
        u * ahead - level * aside, u * aside + level * ahead, r * upright,
        udot, vdot, rdot, pdot, p,
    )  # fmt: skip


def self_propulsion(c: Constants, speed: float) -> float:
    """Revolutions per second that hold a speed straight ahead, rudder amidships.

    Parameters
    ----------
    c : Constants
        From `prepare`.
    speed : float
        [m/s]

    Returns
    -------
    float
        0 for a model without a propeller (surge written in the loss of speed).

    Raises
    ------
    ModelError
        If no revolutions give the thrust that the resistance asks for.
    """
    if c.propeller is None:
        return 0.0
    idle = c._replace(propeller=None, rudder=None)
    resistance = -hydrodynamics(speed, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, idle)[0]
    water = propeller.inflow(speed, 0.0, 0.0, c.L, c.propeller)
    n = propeller.revolutions(resistance / (1.0 - c.propeller.t), water, c.rho, c.propeller)
    if not n > 0.0:
        raise ModelError(
            f"No propeller revolutions hold {speed:g} m/s: the resistance is {resistance:.4g} N. "
            f"Check Xuu (negative), the propeller's diameter, KT and wake."
        )
    return n
