"""From a model to its structure and the flat list of its constants."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from types import ModuleType
from typing import Any, Final

import numpy as np

from pmmkit.base import DataError, MissingPartError, ModelError, Problem, Remedy, Way
from pmmkit.conventions import CHANNELS
from pmmkit.effects import CATALOGUE, HULL, INERTIA, AddedMass, apply
from pmmkit.models import TAKE_PARTS, Model
from pmmkit.numerics import Array
from pmmkit.simulation.equations.code_generation import GIVEN
from pmmkit.simulation.equations.compilation import compiled, interpreted
from pmmkit.simulation.equations.layouts import NO_SEA, Constant, State
from pmmkit.simulation.equations.monomials import Monomial, polynomial
from pmmkit.simulation.equations.structure import POLYNOMIALS, EquationStructure, Used, in_order
from pmmkit.simulation.equations.surroundings import flow, wind_over_current

Numbers = Mapping[str, Mapping[str, Any]]
"""Values of the parts by effect and name: floats, tables, or arrays with a value per ship."""


@dataclass(frozen=True, kw_only=True)
class Conditions:
    """What surrounds the ship during a manoeuvre.

    Parameters
    ----------
    wind_speed : float
        Speed of the true wind [m/s].
    wind_direction_deg : float
        Direction it comes from, from the heading of the approach, positive to starboard [deg].
    current_speed : float
        Speed of the uniform current [m/s].
    current_direction_deg : float
        Direction it flows to, from the heading of the approach, positive to starboard [deg].
    depth : float, optional
        Depth of the water [m]; by default that of the model's water, deep if it has none.
    wave_height : float, optional
        Significant height of the waves [m]; by default that of the model's part ``wave_drift``.
    waves_from_deg : float
        Direction they come from, from the heading of the approach, positive to starboard [deg].
    """

    wind_speed: float = 0.0
    wind_direction_deg: float = 0.0
    current_speed: float = 0.0
    current_direction_deg: float = 0.0
    depth: float | None = None
    wave_height: float | None = None
    waves_from_deg: float = 0.0

    @property
    def current(self) -> tuple[float, float]:
        """Velocity of the current along and to starboard of the approach [m/s]."""
        return flow(self.current_speed, math.radians(self.current_direction_deg))

    @property
    def wind_on_water(self) -> tuple[float, float]:
        """The wind as the drifting water feels it: speed [m/s], direction it comes from [rad]."""
        direction = math.radians(self.wind_direction_deg)
        return wind_over_current(self.wind_speed, direction, *self.current)


CALM: Final[Conditions] = Conditions()


@dataclass(frozen=True, kw_only=True, eq=False)
class Prepared:
    """A model at one approach speed, ready to be integrated.

    Parameters
    ----------
    structure : EquationStructure
        What decides on the code.
    k : tuple of float
        The constants, `Constant` first.
    speed : float
        Approach speed [m/s].
    name : str
        Of the model, for messages.
    """

    structure: EquationStructure
    k: tuple[float, ...]
    speed: float
    name: str = ""

    @property
    def L(self) -> float:
        """Ship length [m]."""
        return self.k[Constant.L]

    @property
    def rolls(self) -> bool:
        """Whether roll is a degree of freedom."""
        return self.structure.rolls

    def functions(self, *, fast: bool = False) -> ModuleType:
        """The functions of the structure, interpreted or compiled."""
        return self._compiled if fast else self._interpreted

    @cached_property
    def _compiled(self) -> ModuleType:
        return compiled(self.structure)

    @cached_property
    def _interpreted(self) -> ModuleType:
        return interpreted(self.structure)

    @cached_property
    def array(self) -> Array:
        """The constants as the compiled functions take them."""
        return np.array(self.k)

    @cached_property
    def constants(self) -> list[float]:
        """The constants with the inverse of the mass matrix filled in.

        Raises
        ------
        ModelError
            If the mass matrix is not positive.
        """
        full = list(self.k)
        if self.functions().complete(full):
            raise ModelError(mass_problem(self.name))
        return full

    def rates(self, y: Sequence[float], delta: float, n: float, bucket: float = 0.0) -> list[float]:
        """Rates of the states `structure.states` at a rudder angle [rad] and revolutions [1/s]."""
        out = [0.0] * len(self.structure.states)
        self.functions().rates(list(y), delta, n, bucket, self.constants, out)
        return out

    def accelerations(
        self,
        u: float,
        v: float,
        r: float,
        p: float = 0.0,
        phi: float = 0.0,
        delta: float = 0.0,
        n: float = 0.0,
    ) -> tuple[float, float, float, float]:
        """Surge, sway [m/s²], yaw and roll acceleration [rad/s²] in ship axes at midship.

        States of lags are settled.
        """
        out = self.rates(self.settled(u, v, r, p, phi, delta, n), delta, n)
        roll = out[State.p] if self.rolls else 0.0
        return out[State.u], out[State.v], out[State.r], roll

    def settled(
        self,
        u: float,
        v: float,
        r: float,
        p: float = 0.0,
        phi: float = 0.0,
        delta: float = 0.0,
        n: float = 0.0,
    ) -> list[float]:
        """States of a motion, those that effects bring where their rates vanish."""
        given = {"u": u, "v": v, "r": r, "p": p, "phi": phi, "n": n}
        states = self.structure.states
        lags = [states.index(name) for name in self.structure.brought if name not in given]
        y = [given.get(name, 0.0) for name in states]
        if not lags:
            return y
        begin = self.rates(y, delta, n)
        end = self.rates([1.0 if i in lags else x for i, x in enumerate(y)], delta, n)
        return [begin[i] / (begin[i] - end[i]) if i in lags else x for i, x in enumerate(y)]

    def self_propulsion(self, speed: float | None = None) -> float:
        """Revolutions per second that hold a speed straight ahead, rudder amidships.

        Returns
        -------
        float
            0 for a model without a propeller (surge written in the loss of speed).

        Raises
        ------
        ModelError
            If no revolutions give the thrust that the resistance asks for.
        """
        size = len(self.structure.states)
        asked = self.speed if speed is None else speed
        n: float = self.functions().self_propulsion(
            asked, self.constants, [0.0] * size, [0.0] * size
        )
        if math.isnan(n):
            raise ModelError(propulsion_problem(self.name, asked))
        return n


def mass_problem(name: str) -> str:
    """What to say of a mass matrix that is not positive."""
    return (
        f"The mass matrix of model {name!r} is not positive. Check Xudot, Yvdot, Nrdot (negative "
        f"by nature) and the masses of the ship."
    )


def propulsion_problem(name: str, speed: float) -> str:
    """What to say where no revolutions hold a speed."""
    return (
        f"No propeller revolutions hold {speed:g} m/s in model {name!r}. Check Xuu (negative), the "
        f"propeller's diameter, KT and wake, and the wind."
    )


@lru_cache(maxsize=64)
def prepare(
    model: Model,
    speed: float,
    *,
    conditions: Conditions = CALM,
    extrapolate: bool = False,
    generic: bool = False,
) -> Prepared:
    """A model at an approach speed, as code and constants.

    Parameters
    ----------
    model : Model
        A model with hull, added mass, propulsion and rudder.
    speed : float
        Approach speed [m/s]; the values of its Froude number hold throughout the manoeuvre.
    conditions : Conditions
        Wind, current and depth.
    extrapolate : bool
        Allow a Froude number outside the model's range.
    generic : bool
        Take the hull polynomial as data: one code for all polynomials.

    Returns
    -------
    Prepared

    Raises
    ------
    MissingPartError
        If a part is missing, such as the roll of a model with derivatives of the heel.
    ExtrapolationError
        If the speed is outside the range of the model's values.

    Examples
    --------
    >>> from pmmkit.models import load_model
    >>> ready = prepare(load_model("s175"), 9.0)
    >>> round(60 * ready.self_propulsion(), 2)
    85.95
    """
    values = values_at(model, speed, extrapolate=extrapolate)
    structure, k = packed(model, values, speed, conditions, generic=generic)
    return Prepared(structure=structure, k=tuple(k), speed=speed, name=model.name)


def values_at(
    model: Model, speed: float, *, extrapolate: bool = False
) -> dict[str, dict[str, Any]]:
    """Values of all parts at the Froude number of a speed, by effect and name."""
    if not (math.isfinite(speed) and speed > 0):
        raise DataError(f"The approach speed {speed} m/s must be positive.")
    Fn = model.ship.froude(speed, model.water.g)
    return {effect: model.values(effect, Fn, extrapolate=extrapolate) for effect in model.parts}


def packed(
    model: Model,
    values: Numbers,
    speed: float,
    conditions: Conditions,
    *,
    generic: bool = False,
    sails: bool = True,
    heeled: bool = False,
) -> tuple[EquationStructure, list[Any]]:
    """Structure and constants of a model from the values of its parts.

    Parameters
    ----------
    model : Model
        Ship, water, convention and options.
    values : mapping
        As `values_at` gives them; some may be arrays with a value per ship.
    speed : float
        Approach speed [m/s].
    conditions : Conditions
        Wind, current and depth.
    generic : bool
        As for `prepare`.
    sails : bool
        Whether the model must have all that a manoeuvre needs; False for forces on given motions,
        such as those of a towed hull.
    heeled : bool
        Whether a model that does not roll is given a measured heel.

    Returns
    -------
    Structure, list
        Constants are floats, or arrays with a value per ship.
    """
    if sails:
        _check_parts(model)
    if sails and model.heeled and not heeled:
        raise MissingPartError(_heel_problem(model))
    ship, water, convention = model.ship, model.water, model.convention
    depth = conditions.depth or water.depth or math.inf
    if depth <= ship.d:
        raise DataError(
            f"The depth {depth:g} m is {depth / ship.d:.2f} draughts: the ship is aground."
        )
    values = _in_shallow_water(model, values, depth)
    added = AddedMass.of(values.get(INERTIA, {}), ship=ship, water=water, convention=convention)
    terms: dict[str, Any] = {}
    for effect in POLYNOMIALS:
        known = CATALOGUE[effect]
        for name, value in values.get(effect, {}).items():
            if known.parameter(name) is None:
                terms[name] = terms.get(name, 0.0) + value
    monomials = polynomial(terms, ship=ship, water=water, convention=convention)
    structure = structure_of(model, values, None if generic else monomials)
    bis = convention.system == "bis"
    wind_speed, wind_direction = conditions.wind_on_water
    current_x, current_y = conditions.current
    common: dict[Constant, Any] = {
        Constant.L: ship.L,
        Constant.B: ship.B,
        Constant.d: ship.d,
        Constant.mass: ship.mass,
        Constant.volume: ship.volume,
        Constant.GM: ship.GM or 0.0,
        Constant.rho: water.rho,
        Constant.g: water.g,
        Constant.xG: ship.xG,
        Constant.zG: ship.zG or 0.0,
        Constant.Izz: ship.Izz,
        Constant.Ixx: ship.Ixx or 0.0,
        Constant.rolls: float(model.rolls),
        **{Constant[name]: value for name, value in added._asdict().items()},
        Constant.reference: math.sqrt(water.g * ship.L)
        if bis
        else speed
        if refers_to_carriage(model)
        else 0.0,
        Constant.square: 1.0 if bis else 0.0,
        Constant.loss_from: speed if convention.surge == "delta-u" else 0.0,
        Constant.wind_speed: wind_speed,
        Constant.wind_direction: wind_direction,
        Constant.depth: depth,
        Constant.current_x: current_x,
        Constant.current_y: current_y,
        Constant.speed: speed,
        Constant.wave_height: NO_SEA if conditions.wave_height is None else conditions.wave_height,
        Constant.wave_direction: math.radians(conditions.waves_from_deg),
    }
    k: list[Any] = [common.get(place, 0.0) for place in Constant]
    if not generic:
        k += [number for _, numbers in monomials for number in numbers.values()]
    for item in structure.used:
        lengths = dict(item.tables)
        for name in item.own:
            value = values[item.effect].get(name, 0.0)
            k += list(value) if name in lengths and isinstance(value, tuple) else [value]
    if generic:
        at = len(k)
        k.append(float(len(monomials)))
        for factors, numbers in monomials:
            k += [float(len(factors)), *map(float, factors)]
            k += [numbers.get(channel, 0.0) for channel in CHANNELS]
        k.append(float(at))
    return structure, k


def refers_to_carriage(model: Model) -> bool:
    """Whether the derivatives refer to the speed of the carriage, the same all through a run."""
    return model.convention.U == "carriage" and model.convention.system != "bis"


def stacked(k: Sequence[Any], ships: int) -> Array:
    """Constants of many ships, a row each, from those of `packed`."""
    table = np.empty((ships, len(k)))
    for column, value in enumerate(k):
        table[:, column] = value
    return table


def structure_of(
    model: Model, values: Numbers, monomials: Sequence[Monomial] | None
) -> EquationStructure:
    """The structure of a model; without `monomials` that of the kernel for all polynomials."""
    used = {}
    for effect, part in sorted(model.parts.items()):
        known = part.known
        if known.force is None:
            continue
        chosen = known.chosen(part.options)
        used[effect] = Used(
            effect=effect,
            options=tuple(
                (name, words.index(chosen[name])) for name, words in known.options.items()
            ),
            tables=tuple(
                (name, len(table) if isinstance(table := values[effect].get(name), tuple) else 1)
                for name in sorted(known.tables)
            ),
            text=part.text,
            edition=CATALOGUE.edition(effect),
        )
    products = None
    if monomials is not None:
        products = tuple((factors, tuple(numbers)) for factors, numbers in monomials)
    return EquationStructure(
        products=products, used=in_order(used, model.name, GIVEN), rolls=model.rolls
    )


def _in_shallow_water(model: Model, values: Numbers, depth: float) -> Numbers:
    name = "shallow_water"
    if name not in model.parts or math.isinf(depth):
        return values
    ship, powers = model.ship, values[name]
    found = {effect: dict(own) for effect, own in values.items()}
    for effect in (HULL, INERTIA):
        found[effect] = apply(values[effect], ship=ship, depth=depth, **powers)
    for effect, part in model.parts.items():
        for parameter, derivative in part.known.grows_with.items():
            grown = apply({derivative: 1.0}, ship=ship, depth=depth, **powers)[derivative]
            found[effect][parameter] = values[effect][parameter] * grown
    return found


def feels_depth(model: Model) -> bool:
    """Whether the depth of the water changes the forces of a model."""
    return any("depth" in part.known.needs for part in model.parts.values())


def feels_waves(model: Model) -> bool:
    """Whether the height of the waves changes the forces of a model."""
    return any("wave_height" in part.known.needs for part in model.parts.values())


def missing_parts(model: Model) -> list[str]:
    """Parts without which a model cannot be simulated; alternatives in one, by *or*.

    Examples
    --------
    >>> from pmmkit.models import load_model
    >>> missing_parts(load_model("kvlcc2"))
    []
    """
    missing = [name for name in (HULL, INERTIA) if name not in model.parts]
    missing += ["roll"] if model.heeled else []
    every = CATALOGUE.values()
    return missing + [
        " or ".join(effect.name for effect in every if role in effect.roles)
        for role in model.lacking
    ]


def _heel_problem(model: Model) -> Problem:
    """What to say of a manoeuvre with derivatives of a heel that nothing gives."""
    return Problem(
        message=f"Model {model.name!r} has derivatives of heel and roll rate "
        f"({', '.join(model.heeled)}), but does not roll: it goes along with a measured heel, and "
        f"no manoeuvre has one.",
        remedy=Remedy(
            "Give it roll, by its heel in free-running records and GM and Ixx of the ship ({}), or "
            "take these derivatives out.",
            (
                Way(
                    "identification.with_roll(model, records)",
                    "pmmkit add MODEL roll --fit RECORDS",
                ),
            ),
        ),
    )


def _check_parts(model: Model) -> None:
    missing = [name for name in missing_parts(model) if name != "roll"]
    if missing:
        raise MissingPartError(
            Problem(
                message=f"Model {model.name!r} cannot be simulated: it has no part "
                f"{', '.join(missing)}.",
                remedy=TAKE_PARTS,
            )
        )
