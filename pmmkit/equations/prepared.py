"""From a model to its structure and the flat list of its constants."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property, lru_cache
from types import ModuleType
from typing import Any, ClassVar, Final

import numpy as np

from pmmkit.base import DataError, MissingPartError, ModelError, Problem, Remedy, Way
from pmmkit.conventions import CHANNELS
from pmmkit.effects import CATALOGUE, HULL, INERTIA, AddedMass, apply
from pmmkit.equations.code_generation import CARRYING, ESTIMATING, GIVEN, module_text
from pmmkit.equations.compilation import compiled, interpreted
from pmmkit.equations.histories import repeating_states, water_forces
from pmmkit.equations.layouts import Constant, Control, GearField, State
from pmmkit.equations.structure import (
    POLYNOMIALS,
    EquationStructure,
    Monomial,
    Used,
    in_order,
    polynomial,
)
from pmmkit.equations.surroundings import flow, wind_over_current
from pmmkit.models import Model
from pmmkit.numerics import Array


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
    NO_SEA: ClassVar[float] = -1.0
    """Wave height in the equations where none is stated."""

    @property
    def current(self) -> tuple[float, float]:
        """Velocity of the current along and to starboard of the approach [m/s]."""
        return flow(self.current_speed, math.radians(self.current_direction_deg))

    @property
    def wind_on_water(self) -> tuple[float, float]:
        """The wind as the drifting water feels it: speed [m/s], direction it comes from [rad]."""
        direction = math.radians(self.wind_direction_deg)
        return wind_over_current(self.wind_speed, direction, *self.current)


LONGEST_STEP: Final = 2.0
"""Longest step in ship lengths over the approach speed. Near a steady turn the error estimate
alone lets the steps grow to the limit of stability, where the dense output loses digits."""


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
    RTOL: ClassVar[float] = 1e-8
    """Relative tolerance of an integration where none is given."""

    @property
    def L(self) -> float:
        """Ship length [m]."""
        return self.k[Constant.L]

    @property
    def longest_step(self) -> float:
        """Longest step of the integration [s]."""
        return LONGEST_STEP * self.L / self.speed

    @property
    def rolls(self) -> bool:
        """Whether roll is a degree of freedom."""
        return self.structure.rolls

    def __getstate__(self) -> dict[str, Any]:
        """For another process, which compiles the functions or has them."""
        return {item.name: getattr(self, item.name) for item in fields(self)}

    @property
    def estimators(self) -> ModuleType:
        """The functions of filters and smoothers, compiled."""
        return compiled(self.structure, ESTIMATING)

    def program(self) -> tuple[str, ModuleType]:
        """What a program in another language is made of: a text, and the module that it makes."""
        return module_text(self.structure, CARRYING), interpreted(self.structure, CARRYING)

    @staticmethod
    def gears() -> dict[str, int]:
        """Places in the lists of a program: of each control, and how it follows its order.

        ``GEARS`` numbers tell how all of them do; ``RUDDER_ORDER`` is the place of the order.
        """
        return {
            "GEARS": len(Control) * len(GearField),
            **{control.name.upper(): int(control) for control in Control},
            "RUDDER_ORDER": len(GearField) * Control.rudder + GearField.order,
        }

    @staticmethod
    def place(name: str) -> int:
        """Where a constant stands that every model has, such as ``mass``."""
        return int(Constant[name])

    def water_forces(self, motion: Mapping[str, Array]) -> dict[str, Array]:
        """Forces of the water on the ship, added mass included, along a history.

        Parameters
        ----------
        motion : mapping of str to array (n,)
            u, v, r, p, phi, psi, their rates udot, vdot, rdot, pdot, and delta, n, n_order,
            bucket: SI and radians, ship axes at midship, through the water; and the states that
            effects bring. States that are left out follow the motion where the time ``t`` is
            given, settled at its start; without ``t`` they are settled throughout. Revolutions of
            a model with a shaft are those given. With ``wind_speed`` and ``wind_direction`` the
            true wind changes along the history, and so do waves with ``wave_height`` and
            ``wave_direction``.

        Returns
        -------
        dict of str to array (n,)
            X, Y [N], N, K [N m] about midship, without the inertia of the ship itself.

        Examples
        --------
        >>> from pmmkit.models import load_model
        >>> ready = prepare(load_model("s175-3dof"), 9.0)
        >>> ahead = {"u": np.array([9.0]), "n": np.array([ready.self_propulsion()])}
        >>> bool(abs(ready.water_forces(ahead)["X"][0]) < 1e-3)
        True
        """
        return water_forces(self.structure, self.k, motion)

    def repeating_states(self, motion: Mapping[str, Array], t: Array) -> dict[str, Array]:
        """States that effects bring, along a motion that repeats itself or stands still.

        Parameters
        ----------
        motion : mapping of str to array (n,)
            As for `water_forces`, without these states.
        t : array (n,)
            Instants [s], ascending, of whole cycles without the end of the last; all alike for a
            motion that stands still.

        Returns
        -------
        dict of str to array (n,)
            All but the revolutions, which are given.

        Raises
        ------
        ModelError
            If a state does not follow a linear equation of its own.

        Examples
        --------
        >>> from pmmkit.models import load_model
        >>> ready = prepare(load_model("s175-3dof"), 9.0)
        >>> ready.repeating_states({"u": np.array([9.0])}, np.zeros(1))
        {}
        """
        return repeating_states(self.structure, self.k, motion, t)

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

    @property
    def mass_matrix(self) -> Array:
        """Mass matrix of sway and yaw, and roll if the ship rolls, in the prime system."""
        k, L, rho = self.k, self.L, self.k[Constant.rho]
        mass, xG, zG = k[Constant.mass], k[Constant.xG], k[Constant.zG]
        matrix = np.array(
            [
                [
                    mass - k[Constant.Yvdot],
                    mass * xG - k[Constant.Yrdot],
                    -mass * zG - k[Constant.Ypdot],
                ],
                [
                    mass * xG - k[Constant.Nvdot],
                    k[Constant.Izz] - k[Constant.Nrdot],
                    -k[Constant.Npdot],
                ],
                [
                    -mass * zG - k[Constant.Kvdot],
                    -k[Constant.Krdot],
                    k[Constant.Ixx] - k[Constant.Kpdot],
                ],
            ]
        )
        arm = np.array([1.0, L, L])
        primed: Array = matrix / (0.5 * rho * L**3 * np.outer(arm, arm))
        return primed if self.rolls else primed[:2, :2]

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


def prepare(
    model: Model,
    speed: float,
    *,
    values: Mapping[str, Mapping[str, Any]] | None = None,
    conditions: Conditions | None = None,
    extrapolate: bool = False,
    generic: bool = False,
    sails: bool = True,
    heeled: bool = False,
) -> Prepared:
    """A model at an approach speed, as code and constants.

    Parameters
    ----------
    model : Model
        A model with hull, added mass, propulsion and rudder.
    speed : float
        Approach speed [m/s]; the values of its Froude number hold throughout the manoeuvre.
    values : mapping, optional
        Values of the parts by effect and name, where they are not those of the model.
    conditions : Conditions, optional
        Wind, current and depth; by default calm water as deep as the model says.
    extrapolate : bool
        Allow a Froude number outside the model's range.
    generic : bool
        Take the hull polynomial as data: one code for all polynomials.
    sails : bool
        Whether the model must have all that a manoeuvre needs; False for forces on given motions,
        such as those of a towed hull.
    heeled : bool
        Whether a model that does not roll is given a measured heel.

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
    around = conditions or Conditions()
    if values is None:
        return _prepared(model, speed, around, extrapolate, generic, sails, heeled)
    structure, k = packed(model, values, speed, around, generic=generic, sails=sails, heeled=heeled)
    return Prepared(structure=structure, k=tuple(k), speed=speed, name=model.name)


@lru_cache(maxsize=64)
def _prepared(
    model: Model,
    speed: float,
    conditions: Conditions,
    extrapolate: bool,
    generic: bool,
    sails: bool,
    heeled: bool,
) -> Prepared:
    values = model.values_at(speed, extrapolate=extrapolate)
    return prepare(
        model,
        speed,
        values=values,
        conditions=conditions,
        generic=generic,
        sails=sails,
        heeled=heeled,
    )


def packed(
    model: Model,
    values: Mapping[str, Mapping[str, Any]],
    speed: float,
    conditions: Conditions,
    *,
    generic: bool = False,
    sails: bool = True,
    heeled: bool = False,
) -> tuple[EquationStructure, list[Any]]:
    """Structure and constants, which are floats, or arrays with a value per ship."""
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
        Constant.wave_height: Conditions.NO_SEA
        if conditions.wave_height is None
        else conditions.wave_height,
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
        k.append(float(len(monomials)))
        for factors, numbers in monomials:
            k += [float(len(factors)), *map(float, factors)]
            k += [numbers.get(channel, 0.0) for channel in CHANNELS]
    return structure, k


def refers_to_carriage(model: Model) -> bool:
    """Whether the derivatives refer to the speed of the carriage, the same all through a run."""
    return model.convention.U == "carriage" and model.convention.system != "bis"


def structure_of(
    model: Model, values: Mapping[str, Mapping[str, Any]], monomials: Sequence[Monomial] | None
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


def _in_shallow_water(
    model: Model, values: Mapping[str, Mapping[str, Any]], depth: float
) -> Mapping[str, Mapping[str, Any]]:
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
    missing = [name for name in model.missing_parts if name != "roll"]
    if missing:
        raise MissingPartError(
            Problem(
                message=f"Model {model.name!r} cannot be simulated: it has no part "
                f"{', '.join(missing)}.",
                remedy=Model.TAKE_PARTS,
            )
        )
