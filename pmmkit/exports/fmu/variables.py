"""The variables of an FMU: what a model takes and tells, and where it stands in the program."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal

from pmmkit.effects import CATALOGUE, INERTIA
from pmmkit.equations import POLYNOMIALS, Prepared, prepare
from pmmkit.exports.matlab.hull import variable as spelled
from pmmkit.models import Model

Causality = Literal["independent", "input", "output", "local", "parameter", "calculatedParameter"]
GEAR: Final = "delta_gear"
BEGIN: Final = "_start"
LAG: Final = 0.1
"""Time constant of the steering gear near its order [s]: next to none, and not stiff."""
_STATES: Final[Mapping[str, tuple[str, str]]] = {
    "x": ("m", "position along the x axis of the earth"),
    "y": ("m", "position along the y axis of the earth, to starboard of x"),
    "psi": ("rad", "heading, from the x axis, positive to starboard"),
    "u": ("m/s", "surge velocity through the water at midship"),
    "v": ("m/s", "sway velocity through the water at midship, positive to starboard"),
    "r": ("rad/s", "yaw rate, positive to starboard"),
    "p": ("rad/s", "roll rate"),
    "phi": ("rad", "roll angle, positive with starboard down"),
    "n": ("1/s", "revolutions of the propeller"),
    GEAR: ("rad", "angle of the steering gear"),
}
_TOLD: Final[Mapping[str, tuple[str, str]]] = {
    "X": ("N", "force ahead of water and air, without that of added mass"),
    "Y": ("N", "force to starboard of water and air, without that of added mass"),
    "N": ("N m", "moment about z at midship of water and air, without that of added mass"),
    "K": ("N m", "moment about x of water and air, without that of added mass"),
    "thrust": ("N", "thrust"),
    "torque": ("N m", "torque at the propeller"),
    "rudder_force": ("N", "force across the rudder, or of what steers"),
}
_INPUTS: Final[Mapping[str, tuple[str, str]]] = {
    "delta_order": ("rad", "rudder angle ordered, positive turns the ship to starboard"),
    "n_order": ("1/s", "revolutions ordered"),
    "bucket": ("-", "bucket of the waterjets, 0 up to 1 down"),
    "current_speed": ("m/s", "speed of a uniform current"),
    "current_direction": ("rad", "where the current flows to, from the x axis"),
    "wind_speed": ("m/s", "speed of the true wind"),
    "wind_direction": ("rad", "where the wind comes from, from the x axis"),
    "wave_height": ("m", "significant height of the waves; below zero that of the model"),
    "wave_direction": ("rad", "where the waves come from, from the x axis"),
}
_SHIP: Final[Mapping[str, tuple[str, str]]] = {
    "mass": ("kg", "mass"),
    "xG": ("m", "centre of gravity forward of midship"),
    "zG": ("m", "centre of gravity below the origin"),
    "GM": ("m", "metacentric height"),
    "Izz": ("kg m2", "yaw inertia about midship"),
    "Ixx": ("kg m2", "roll inertia"),
}
_ANY: Final = 1e12
"""Limits of a parameter of an effect that has none."""
_ROLL_ALONE: Final = ("zG", "GM", "Ixx")


@dataclass(frozen=True)
class FmuVariable:
    """One variable of an FMU.

    `name, unit, text`: name; unit, ``-`` for a plain number; what it is. `causality`: as FMI
    names it. `start`: value where none is set, of inputs and parameters. `rate_of`: the state
    whose rate it is. `is_word`: whether it is true or false. `low, high`: values beside these
    make no sense. `nominal`: usual size, of states. `slopes`: of parameters: the places in the
    constants that it enters, each with its factor.
    """

    name: str
    unit: str
    text: str
    causality: Causality
    start: float | None = None
    rate_of: str = ""
    is_word: bool = False
    low: float | None = None
    high: float | None = None
    nominal: float | None = None
    slopes: tuple[tuple[int, float], ...] = ()


@dataclass(frozen=True, kw_only=True)
class Table:
    """All variables in the order of their value references, and the constants without parameters.

    `variables`: the reference of a variable is its place. `states`: continuous states; each
    begins at the parameter of its name with ``_start``. `base`: constants of the equations to
    which the parameters are added.
    """

    variables: tuple[FmuVariable, ...]
    states: tuple[str, ...]
    base: tuple[float, ...]

    def place(self, name: str) -> int:
        """Value reference of a variable."""
        return self.places[name]

    @property
    def places(self) -> dict[str, int]:
        """Value references by name."""
        return {item.name: place for place, item in enumerate(self.variables)}


def table_of(model: Model, ready: Prepared, speed: float) -> Table:
    """The variables of a model at an approach speed [m/s]."""
    states = (*ready.structure.states, GEAR)
    propelled = ready.structure.revolutions
    n = ready.self_propulsion() if propelled else 0.0
    pace = speed / ready.L
    usual = {"x": ready.L, "y": ready.L, "u": speed, "v": speed, "r": pace, "p": pace, "n": n}
    parameters = list(_parameters(model, ready, speed))
    base = list(ready.k)
    for item in parameters:
        for place, _ in item.slopes:
            base[place] = 0.0
    variables = [
        FmuVariable("time", "s", "time", "independent"),
        *(_state(name, usual.get(name, 1.0)) for name in states),
        *(_rate(name) for name in states),
        *_outputs(ready),
        *([_approach()] if propelled else []),
        *_inputs(ready, n),
        *(_begin(name, {"u": speed, "n": n}.get(name, 0.0)) for name in states),
        *_steering(model),
        *parameters,
    ]
    return Table(variables=tuple(variables), states=states, base=tuple(base))


def _state(name: str, nominal: float) -> FmuVariable:
    unit, text = _STATES.get(name, ("", f"{name.replace('_', ' ')}, a state of an effect"))
    causality: Causality = "output" if name in _STATES and name != GEAR else "local"
    return FmuVariable(name, unit or "-", text, causality, nominal=nominal)


def _rate(name: str) -> FmuVariable:
    unit = _STATES.get(name, ("", ""))[0]
    per_second = {"m": "m/s", "m/s": "m/s2", "rad": "rad/s", "rad/s": "rad/s2", "1/s": "1/s2"}
    return FmuVariable(
        f"der({name})", per_second.get(unit, "-"), f"rate of {name}", "local", rate_of=name
    )


def _begin(name: str, start: float) -> FmuVariable:
    unit, text = _STATES.get(name, ("", name))
    return FmuVariable(
        f"{name}{BEGIN}", unit or "-", f"at the start: {text}", "parameter", start=start
    )


def _outputs(ready: Prepared) -> list[FmuVariable]:
    """What follows from the states; the forces last, in the order of `EquationStructure.told`."""
    found = [FmuVariable("delta", "rad", "rudder angle, positive to starboard", "output")]
    if ready.structure.revolutions and "n" not in ready.structure.states:
        unit, text = _STATES["n"]
        found.append(FmuVariable("n", unit, text, "output"))
    for name in ready.structure.told:
        unit, text = _TOLD.get(name, ("-", f"{name.replace('_', ' ')}, between effects"))
        causality: Causality = "output" if name in _TOLD else "local"
        found.append(FmuVariable(name, unit, text, causality))
    return found


def _approach() -> FmuVariable:
    return FmuVariable(
        "n_approach",
        "1/s",
        "revolutions that hold u_start straight ahead in the surroundings of the start",
        "calculatedParameter",
    )


def _inputs(ready: Prepared, n: float) -> list[FmuVariable]:
    asked = {name for item in ready.structure.used for name in item.arguments}
    felt = {
        "n_order": ready.structure.revolutions,
        "bucket": "bucket" in asked,
        **dict.fromkeys(("wind_speed", "wind_direction"), "wind_speed" in asked),
        **dict.fromkeys(("wave_height", "wave_direction"), "wave_height" in asked),
    }
    starts = {"n_order": n, "wave_height": ready.k[ready.place("wave_height")]}
    return [
        FmuVariable(name, unit, text, "input", start=starts.get(name, 0.0))
        for name, (unit, text) in _INPUTS.items()
        if felt.get(name, True)
    ]


def _steering(model: Model) -> list[FmuVariable]:
    limits = model.steering
    rate = limits.get("rate_deg_s")
    return [
        FmuVariable(
            "steering_gear",
            "-",
            "whether the rudder follows its order by a gear; else delta_order is its angle",
            "parameter",
            start=0.0 if rate is None else 1.0,
            is_word=True,
        ),
        FmuVariable(
            "delta_rate",
            "rad/s",
            "rate of the steering gear",
            "parameter",
            start=math.radians(90.0 if rate is None else rate),
            low=0.0,
        ),
        FmuVariable(
            "delta_max",
            "rad",
            "largest rudder angle of the steering gear",
            "parameter",
            start=math.radians(limits.get("max_deg", 90.0)),
            low=0.0,
        ),
        FmuVariable(
            "delta_lag",
            "s",
            "time constant of the steering gear near its order",
            "parameter",
            start=LAG,
            low=0.0,
        ),
    ]


def _parameters(model: Model, ready: Prepared, speed: float) -> Iterator[FmuVariable]:
    """Particulars of the ship, derivatives, and the numbers of the effects."""
    for name, (unit, text) in _SHIP.items():
        if ready.rolls or name not in _ROLL_ALONE:
            place = ready.place(name)
            yield FmuVariable(
                f"ship.{name}",
                unit,
                text,
                "parameter",
                start=ready.k[place],
                slopes=((place, 1.0),),
            )
    values = model.values_at(speed)
    numbers = list(_numbers(ready, values))
    nothing = {effect: dict(own) for effect, own in values.items()}
    for effect, name in numbers:
        nothing[effect][name] = 0.0
    without = prepare(model, speed, values=nothing).k
    for effect, name in numbers:
        alone = nothing | {effect: nothing[effect] | {name: 1.0}}
        with_it = prepare(model, speed, values=alone).k
        slopes = [
            (place, b - a)
            for place, (a, b) in enumerate(zip(without, with_it, strict=True))
            if b != a
        ]
        if slopes:
            yield _number(model, effect, name, values[effect].get(name, 0.0), slopes)


def _numbers(ready: Prepared, values: Mapping[str, Mapping[str, Any]]) -> Iterator[tuple[str, str]]:
    """Effect and name of every single number that the constants are linear in."""
    for effect in (*POLYNOMIALS, INERTIA):
        for name in values.get(effect, {}):
            if CATALOGUE[effect].parameter(name) is None:
                yield effect, name
    for item in ready.structure.used:
        tables, options = dict(item.tables), dict(item.options)
        for name in item.own:
            known = item.known.parameter(name)
            assert known is not None
            chosen = known.form and item.known.options[known.form[0]][options[known.form[0]]]
            if name not in tables and (not known.form or chosen in known.form[1:]):
                yield item.effect, name


def _number(
    model: Model, effect: str, name: str, value: Any, slopes: Sequence[tuple[int, float]]
) -> FmuVariable:
    part = model.parts[effect]
    known = part.known.parameter(name)
    source = part.source_of(name)
    text = f"derivative {name}, {model.convention.system} system" if known is None else known.text
    own = spelled(name) if known is None else name
    return FmuVariable(
        f"{effect}.{own}",
        "-" if known is None else known.unit,
        f"{text}. Source: {source}" if source else text,
        "parameter",
        start=float(value),
        low=None if known is None or known.low <= -_ANY else known.low,
        high=None if known is None or known.high >= _ANY else known.high,
        slopes=tuple(slopes),
    )
