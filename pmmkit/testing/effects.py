"""What every effect must hold."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import cycle, product
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from pmmkit.base import ModelError, PmmkitError
from pmmkit.conventions import CHANNELS, bibliography, parse_derivative
from pmmkit.diagnosis import candidate_of, standard_tests
from pmmkit.diagnosis import candidate_of as captive_candidate
from pmmkit.diagnosis import free_candidate_of as free_candidate
from pmmkit.effects import BY_SPEED, CATALOGUE, OUTSIDE, Effect
from pmmkit.equations import ACCELERATIONS, GIVEN, Conditions, Prepared, prepare
from pmmkit.models import (
    Model,
    Part,
    Sailing,
    load_model,
    scaled,
    ships,
    with_effect,
    without_effect,
)
from pmmkit.numerics import Array
from pmmkit.reduction import RunViews
from pmmkit.testing import hold

# What every fault of a measurement must hold.


def declared_fault(effect: Effect) -> Iterator[str]:
    """What is wrong with what a fault says of itself."""
    if effect.acts is None and not effect.not_captive:
        yield "it does not act on records"
    if not (effect.coefficients or effect.suspects):
        yield "it has no size, and the checks do not suspect it"
    if effect.roles:
        yield "a fault has no role in a model"
    known = {item.name for item in effect.parameters}
    for form in effect.suspects:
        named = {form.unknown, *(name for value in form.grid for name in form.at(value))} - {""}
        lost = sorted(named - known)
        if lost:
            yield f"it is suspected by {', '.join(lost)}, which are none of its parameters"


def acts_on_records(case: _Case) -> Iterator[str]:
    """Forces are shown in their form; nothing at zero, and in proportion where it says so."""
    effect = case.effect
    if effect.acts is None or not effect.coefficients:
        return
    views, base = standard_tests()
    speeds = sorted({view.speed for view in views})
    for view, value in product(views, candidate_of(effect, speeds).grid):
        run = RunViews(views=(view,), base=base)
        at = {effect.nonlinear.name: value} if effect.nonlinear else {}
        for item in effect.coefficients:
            none, once, twice = (
                effect.shown(run, {**at, item.name: times * item.step}) for times in (0, 1, 2)
            )
            for channel, shown in once.items():
                true = run.forces[channel]
                if shown.shape != true.shape:
                    yield f"what it shows of {channel} has the shape {shown.shape}"
                    continue
                change, size = shown - true, float(np.abs(true).max())
                if not _alike(none.get(channel, true), true, size):
                    yield f"it shows something of {channel} where {item.name} is zero"
                elif item.step == 1.0 and not _alike(twice[channel] - true, 2.0 * change, size):
                    yield f"it is not in proportion to {item.name}: state a step"


def _alike(one: Array, other: Array, size: float) -> bool:
    """Whether forces are the same but for rounding; what is not finite is told elsewhere."""
    finite = np.isfinite(one) & np.isfinite(other)
    return bool(np.allclose(one[finite], other[finite], rtol=1e-9, atol=1e-9 * size))


_FROUDE: Final = 0.142
"""Froude number at which models are tried."""
_SPEEDS: Final = (0.1, 0.142, 0.2)
"""Froude numbers of tests, for effects of the speed."""
_LARGER: Final = 3.0
"""Scale by which a ship grows."""
_ROLES: Final[Mapping[str, str]] = {"thrust": "propulsion", "rudder_force": "steering"}
"""What a part does for a ship that gives a signal."""


@dataclass(frozen=True)
class _Case:
    """An effect, and a model that holds it or is to be tried with it."""

    effect: Effect
    given: Model | None

    @cached_property
    def tried(self) -> tuple[Model, Model] | None:
        """A model without the effect and one with it; None where it enters no ship."""
        for model in self.models:
            if self.effect.name in model.parts and not self.effect.coefficients:
                return model, model
            plain = self._taken_out(model)
            made = self._added(plain) or self._as_part(plain)
            if made is not None:
                return plain, made
        return None

    def _added(self, plain: Model) -> Model | None:
        """With the effect of usual size; None where it has no place."""
        tests = _SPEEDS if self.effect.kind == "terms" or self._of_speed else ()
        try:
            made = with_effect(plain, self.effect, coefficients="typical", Fn=tests)
            prepare(made, made.ship.speed(_FROUDE))
        except PmmkitError:
            return None
        return made

    @property
    def _of_speed(self) -> bool:
        return self.effect.parameter("Fn0") is not None

    def _taken_out(self, model: Model) -> Model:
        if self.effect.kind == "freed":
            return model
        try:
            return without_effect(model, self.effect)
        except ModelError:
            return model

    def _as_part(self, model: Model) -> Model | None:
        """With the effect as a part of its defaults and usual sizes, in place of its like."""
        effect = self.effect
        if not effect.enters:
            return None
        vessel = Sailing(model, model.ship.speed(_FROUDE))
        known = dict(effect.estimates(vessel)) if effect.estimates is not None else {}
        sizes = {**known, **effect.typical}
        lacking = [name for name in effect.required({}) if name not in sizes]
        if lacking:
            return None
        alike = {name for role in effect.roles for name in model.in_role(role)}
        parts = {name: part for name, part in model.parts.items() if name not in alike}
        own = Part(effect=effect.name, values=MappingProxyType(sizes), text=effect.text)
        made = model.with_(parts=MappingProxyType({**parts, effect.name: own}))
        try:
            prepare(made, made.ship.speed(_FROUDE))
        except PmmkitError:
            return None
        return made

    @cached_property
    def models(self) -> tuple[Model, ...]:
        """The model that was given, or the ships of the library, those that hold it first."""
        if self.given is not None:
            return (self.given,)
        every = [load_model(name) for name in ships()]
        return tuple(sorted(every, key=lambda model: self.effect.name not in model.parts))

    @property
    def values(self) -> dict[str, Any]:
        """Parameters and options of the force, as a model has them."""
        effect = self.effect
        part = self.tried[1].parts.get(effect.name) if self.tried is not None else None
        found: dict[str, Any] = {}
        for item in effect.parameters:
            usual = item.grid[len(item.grid) // 2] if item.grid else item.typical
            plain = item.default if item.default is not None else usual
            table = (0.0, 0.0) * max(len(item.over), 1)
            found[item.name] = table if item.table else plain or 0.0
        options = effect.chosen(part.options if part is not None else {})
        return {
            **found,
            **(part.values if part is not None else {}),
            **{name: effect.options[name].index(word) for name, word in options.items()},
        }


def check_effect(effect: Effect, model: Model | None = None) -> None:
    """Whether an effect can stand beside those of pmmkit.

    Its words and numbers are complete, and those of its kind are there; its force is finite, the
    same for numbers and arrays, linear in each coefficient and grows by Froude's law; both
    diagnoses can ask for it, or it says why not; it goes into a model and out again, and the
    compiled equations give what the interpreted ones do.

    Parameters
    ----------
    effect : Effect
        An entry, yours or pmmkit's; one that enters models must be in the catalogue
        (`register_effect`), or be made of text.
    model : Model, optional
        One that holds it, where parameters have neither defaults nor usual sizes; by default a
        ship of the library that takes it.

    Raises
    ------
    AssertionError
        With everything that does not hold.

    Examples
    --------
    >>> from pmmkit.effects import CATALOGUE
    >>> check_effect(CATALOGUE["modulus_sway_drag"])
    >>> check_effect(Effect(name="Keel", family="own", kind="terms", summary="A keel"))
    Traceback (most recent call last):
    AssertionError: Effect 'Keel':
    - words: the name 'Keel' is not of small letters, digits and _
    - words: the summary 'A keel' is no sentence
    - kind: it stands for no derivatives
    """
    case = _Case(effect, model)
    found = [f"{rule}: {fault}" for rule in DECLARED for fault in _faults(DECLARED[rule], case)]
    if not found:
        found = [f"{rule}: {fault}" for rule in RULES for fault in _faults(RULES[rule], case)]
    hold(f"Effect {effect.name!r}", found)


def _faults(rule: Callable[[_Case], Iterator[str]], case: _Case) -> list[str]:
    try:
        return list(dict.fromkeys(rule(case)))
    except Exception as error:
        return [f"{type(error).__name__}: {error}"]


def _small(name: str) -> bool:
    return name.isidentifier() and name == name.lower()


def _words(case: _Case) -> Iterator[str]:
    effect = case.effect
    if not _small(effect.name):
        yield f"the name {effect.name!r} is not of small letters, digits and _"
    if not _small(effect.family.replace(" ", "_")):
        yield f"the family {effect.family!r} is not of small letters, digits and _"
    said = effect.summary.strip()
    if said and (not said.endswith(".") or ". " in said or not said[0].isupper()):
        yield f"the summary {said!r} is no sentence"
    unknown = sorted(set(effect.sources) - set(bibliography()))
    if unknown:
        yield f"the sources {', '.join(unknown)} are not in the bibliography"
    if not said and not effect.text:
        yield "it has no summary"
    if effect.coefficients and not (effect.check or effect.text):
        yield "no check is named that would show it"
    strange = sorted(set(effect.excites) - set(effect.EXCITES))
    if strange:
        known = ", ".join(effect.EXCITES)
        yield f"{', '.join(strange)} are no words for what tests hold; there are {known}"


def _parameters(case: _Case) -> Iterator[str]:
    effect = case.effect
    names = [item.name for item in effect.parameters]
    yield from (f"{name} comes twice" for name in sorted({n for n in names if names.count(n) > 1}))
    for item in effect.parameters:
        if effect.force is not None and not item.name.isidentifier():
            yield f"{item.name!r} is no name of an argument"
        if not item.unit_is_known:
            yield f"the unit {item.unit!r} of {item.name} is not known"
        if item.typical is not None and not (
            math.isfinite(item.typical) and item.typical != 0.0 and _inside(item, item.typical)
        ):
            yield f"the usual size {item.typical:g} of {item.name} is zero or outside its limits"
        if list(item.grid) != sorted(set(item.grid)):
            yield f"the grid of {item.name} does not ascend"
        if not all(_inside(item, value) for value in item.grid):
            yield f"the grid of {item.name} goes beyond its limits"
        if item.default is not None and not _inside(item, item.default):
            yield f"the default of {item.name} is outside its limits"
        if item.form is not None and (
            set(item.form[1:]) - set(effect.options.get(item.form[0], ()))
        ):
            yield f"{item.name} is for an option {' '.join(item.form)} that there is not"
    if sum(bool(item.grid or item.of_the_tests) for item in effect.parameters) > 1:
        yield "more than one parameter is tried on a grid"
    if effect.nonlinear is not None and effect.nonlinear.typical is not None:
        yield f"{effect.nonlinear.name} is a coefficient and tried on a grid"


def _inside(item: Any, value: float) -> bool:
    return bool(item.low <= value <= item.high)


def _kind(case: _Case) -> Iterator[str]:
    effect = case.effect
    if effect.kind not in effect.KINDS:
        yield f"there is no kind {effect.kind!r}"
        return
    yield from _OF_KIND[effect.kind](effect)
    if not effect.enters and (effect.force is not None or effect.outputs or effect.states):
        yield f"it is of kind {effect.kind} and has a force"
    if effect.kind != "fault" and (effect.acts is not None or effect.suspects):
        yield "it acts on records and is no fault"


def _of_part(effect: Effect) -> Iterator[str]:
    if (effect.force is None) != (not effect.outputs):
        yield "a force needs outputs, and outputs a force"
    if effect.force is None and not effect.roles:
        yield "it has neither a force nor a role"
    rates = {f"{state}_rate" for state in effect.states}
    if rates != {output for output in effect.outputs if output.endswith("_rate")}:
        yield f"its states are {', '.join(effect.states) or 'none'}, its rates are of others"
    if (effect.kind == "state") != bool(effect.states):
        yield f"it is of kind {effect.kind} and has states {', '.join(effect.states) or 'none'}"
    masses = [output for output in effect.outputs if output in ACCELERATIONS]
    if effect.kind == "mass" and effect.force is not None and not masses:
        yield "it is of kind mass and gives no share of the mass matrix"
    for signal, role in _ROLES.items():
        if signal in effect.outputs and role not in effect.roles:
            yield f"it gives {signal} and has not the role {role}"


def _of_terms(effect: Effect) -> Iterator[str]:
    if not effect.coefficients:
        yield "it stands for no derivatives"
    for label in effect.typical:
        for name in effect.derivatives_of(label):
            try:
                parse_derivative(name.removesuffix(BY_SPEED))
            except PmmkitError as error:
                yield str(error)


def _of_freed(effect: Effect) -> Iterator[str]:
    part = CATALOGUE.get(effect.frees)
    if part is None or not part.enters:
        yield f"it frees values of {effect.frees!r}, which is no part of a model"
    elif effect.moves is None:
        lost = [label for label in effect.typical if part.parameter(label) is None]
        if lost:
            yield f"{effect.frees} has no {', '.join(lost)}"
        if not effect.coefficients:
            yield "it moves nothing"


_OF_KIND: Final[Mapping[str, Callable[[Effect], Iterator[str]]]] = {
    "force": _of_part,
    "mass": _of_part,
    "state": _of_part,
    "terms": _of_terms,
    "freed": _of_freed,
    "fault": declared_fault,
}


def _arguments(case: _Case) -> Iterator[str]:
    effect = case.effect
    own = {*(item.name for item in effect.parameters), *effect.options, *effect.states}
    signals = {x for item in CATALOGUE.values() for x in (*item.outputs, *item.states)}
    lost = [x for x in effect.arguments if x not in own | GIVEN | signals]
    if lost:
        yield f"nobody gives the force {', '.join(lost)}"


def _asked(case: _Case) -> Iterator[str]:
    effect = case.effect
    if effect.coefficients and not effect.asked_in_captive and not effect.not_captive:
        yield "captive tests are not asked for it, and no reason is given"
    if effect.moves is not None and not effect.coefficients and not effect.not_captive:
        yield "captive tests cannot be asked for it, and no reason is given"
    if not (effect.coefficients or effect.moves) and (
        effect.not_captive or effect.not_free_running
    ):
        yield "it gives a reason why a diagnosis does not ask for it, and has nothing to ask for"
    sized = effect.coefficients and effect.moves is None
    if effect.faulty and sized and not effect.not_free_running:
        yield "free-running records cannot be asked for it, and no reason is given"


def _point(case: _Case) -> Iterator[dict[str, Any]]:
    """What a force may be given: motions all around, at several speeds, astern too."""
    model = case.tried[1] if case.tried is not None else case.models[0]
    ship, water = model.ship, model.water
    speed = ship.speed(_FROUDE)
    fixed: dict[str, Any] = {
        "L": ship.L, "B": ship.B, "d": ship.d, "mass": ship.mass, "volume": ship.volume,
        "GM": ship.GM or 0.05 * ship.B, "rho": water.rho, "g": water.g, "n_order": 1.5,
        "wind_speed": speed, "wind_direction": 0.7, "depth": 3.0 * ship.d, "bucket": 0.0,
        "wave_height": 0.01 * ship.L, "wave_direction": 0.4,
    }  # fmt: skip
    signals = [x for x in case.effect.arguments if x not in GIVEN]
    for share, angle, turn, rudder in product(
        (0.3, 1.0), (-2.8, -1.2, -0.2, 0.0, 0.15, 1.0, 3.1), (-0.5, 0.0, 0.3), (-0.5, 0.2)
    ):
        U = share * speed
        u, v = U * math.cos(angle), -U * math.sin(angle)
        yield {
            **fixed,
            **{name: 0.1 + 0.2 * abs(turn + rudder) for name in signals},
            "u": u, "v": v, "r": turn * U / ship.L, "p": 0.1 * turn * U / ship.L, "U": U,
            "phi": 0.2 * turn, "psi": angle, "beta": math.atan2(-v, u), "delta": rudder,
            "Fn": ship.froude(U, water.g), "n": 2.0 * share,
        }  # fmt: skip


def _outputs(case: _Case, there: Mapping[str, Any], **changed: Any) -> tuple[Any, ...]:
    given = {**there, **case.values, **changed}
    assert case.effect.force is not None
    found: tuple[Any, ...] = case.effect.force(**{x: given[x] for x in case.effect.arguments})
    return found


def _by_arrays(case: _Case) -> Iterator[str]:
    effect = case.effect
    if effect.force is None or (effect.enters and case.tried is None):
        return
    points = list(_point(case))
    values = case.values
    single = np.array([_outputs(case, point) for point in points], float)
    if single.shape[1:] != (len(effect.outputs),):
        yield f"it has outputs {', '.join(effect.outputs)} and gives {single.shape[1]}"
        return
    wrong = [x for x, column in zip(effect.outputs, single.T, strict=True)
             if not np.all(np.isfinite(column))]  # fmt: skip
    if wrong:
        yield f"{', '.join(wrong)} are not finite at all motions"
    several = {name: np.array([point[name] for point in points]) for name in points[0]}
    given = {**several, **values}
    with np.errstate(all="ignore"):
        found = effect.force_over_arrays(**{x: given[x] for x in effect.arguments})
    for name, column, numbers in zip(effect.outputs, found, single.T, strict=True):
        size = np.max(np.abs(numbers), initial=1e-300)
        if not np.allclose(column, numbers, rtol=1e-12, atol=1e-13 * size, equal_nan=True):
            yield f"{name} of arrays is not that of single numbers"


def _linear(case: _Case) -> Iterator[str]:
    effect = case.effect
    if effect.force is None or not effect.coefficients:
        return
    sizes = effect.typical
    none = dict.fromkeys(sizes, 0.0)
    places = [i for i, x in enumerate(effect.outputs) if x in (*CHANNELS, *ACCELERATIONS)]

    def forces(point: Mapping[str, Any], **given: float) -> Any:
        found = _outputs(case, point, **(none | given))
        return np.array([found[i] for i in places], float)

    for point in _point(case):
        if np.any(forces(point)):
            yield "with all coefficients at zero there is a force"
        alone = {name: forces(point, **{name: size}) for name, size in sizes.items()}
        for name, size in sizes.items():
            twice, back = (forces(point, **{name: x * size}) for x in (2.0, -1.0))
            if not (
                np.array_equal(twice, 2.0 * alone[name]) and np.array_equal(back, -alone[name])
            ):
                yield f"the force is not linear in {name}"
        whole = np.sum(list(alone.values()), axis=0)
        most = np.sum(np.abs(list(alone.values())), axis=0)
        if np.any(np.abs(forces(point, **sizes) - whole) > 1e-12 * most):
            yield "the force is not the sum of those of its coefficients"


def _states(case: _Case) -> Iterator[str]:
    """A diagnosis, and a history without the states, settle what follows a linear equation."""
    effect = case.effect
    if effect.force is None or not effect.coefficients:
        return
    for state in effect.states:
        place = effect.outputs.index(f"{state}_rate")
        for point in _point(case):
            at_zero, at_one, at_two = (
                _outputs(case, point, **{state: level})[place] for level in (0.0, 1.0, 2.0)
            )
            fading = at_zero - at_one
            if not math.isclose(at_zero - at_two, 2.0 * fading, rel_tol=1e-6):
                yield f"the rate of {state} is not linear in it"
            if not fading > 0.0:
                yield f"{state} does not settle"


def _history(model: Model, stretch: float) -> dict[str, Any]:
    """A weaving motion with its time; lengths are stretched, times by the root."""
    now, ship = np.linspace(0.0, 20.0, 41), model.ship
    time = math.sqrt(stretch)
    length = ship.L / stretch
    U = _FROUDE * math.sqrt(model.water.g * length)
    wave = np.sin(0.8 * now)
    return {
        "t": now * time * length / U,
        "u": U * time * (1.0 + 0.1 * wave),
        "v": U * time * 0.2 * wave,
        "r": 0.3 * U / length / time * np.cos(0.5 * now),
        "p": 0.02 * U / length / time * wave,
        "phi": 0.1 * wave,
        "psi": 0.3 * now,
        "vdot": 0.05 * U**2 / length * wave,
        "rdot": 0.05 * (U / length) ** 2 / stretch * wave,
        "delta": 0.3 * np.cos(0.7 * now),
        "n": np.full(len(now), 8.0 * U / length / time),
        "n_order": np.full(len(now), 8.0 * U / length / time),
    }


def _in_wind(model: Model) -> Prepared:
    speed = model.ship.speed(_FROUDE)
    return prepare(model, speed, conditions=Conditions(wind_speed=speed, wind_direction_deg=40.0))


def _by_froude(case: _Case) -> Iterator[str]:
    if not case.effect.enters or case.tried is None:
        return
    model = case.tried[1]
    large = scaled(model, _LARGER * model.ship.L)
    found = []
    for ship, stretch in ((model, 1.0), (large, _LARGER)):
        ready = _in_wind(ship)
        found.append(ready.water_forces(_history(ship, stretch)))
    small, grown = found
    for channel in CHANNELS:
        expected = small[channel] * _LARGER ** (4 if channel in "NK" else 3)
        if not np.allclose(grown[channel], expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max()):
            yield f"{channel} of a larger ship is not that of Froude's law"


def _enters(case: _Case) -> Iterator[str]:
    effect = case.effect
    if effect.faulty:
        return
    if case.tried is None:
        yield "no ship of the library takes it: give a model that holds it"
        return
    plain, made = case.tried
    if plain is made or not (effect.coefficients or effect.moves):
        return
    back = without_effect(made, effect)
    for name in sorted({*plain.parts, *back.parts}):
        one, other = (x.parts[name].values if name in x.parts else {} for x in (plain, back))
        if {key: _middle(x) for key, x in one.items()} != {
            key: _middle(x) for key, x in other.items()
        }:
            yield f"taken out again, it leaves another {name}"


def _middle(value: Any) -> float:
    return float(np.median(value))


def _compiled(case: _Case) -> Iterator[str]:
    if not case.effect.enters or case.tried is None:
        return
    ready = _in_wind(case.tried[1])
    fast, constants = ready.functions(fast=True), np.array(ready.constants)
    for point in _point(case):
        y = [point.get(name, 0.1) for name in ready.structure.states]
        controls = point["delta"], point["n"], point["bucket"]
        out = np.zeros(len(y))
        fast.rates(np.array(y), *controls, constants, out)
        if not np.allclose(out, ready.rates(y, *controls), rtol=1e-9, atol=1e-12):
            yield "compiled equations are not those that are interpreted"


def _captive(case: _Case) -> Iterator[str]:
    effect = case.effect
    if not effect.asked_in_captive:
        return
    views, base = standard_tests()
    views = tuple(replace(view, day=i / len(views)) for i, view in enumerate(views))
    candidate = captive_candidate(effect, sorted({view.speed for view in views}))
    if not candidate.grid:
        yield "there are no values to try of its parameter"
    acts = False
    found = [x for value in candidate.grid for x in candidate.columns(views, base, value)]
    for view, by_channel in zip(cycle(views), found, strict=False):
        for channel, columns in by_channel.items():
            if columns.shape != (view.rows, candidate.size):
                yield f"columns of {channel} have the shape {columns.shape}"
            elif not np.all(np.isfinite(columns)):
                yield f"columns of {channel} are not finite"
            else:
                acts |= bool(np.any(columns))
    if not acts and base.excited(views).issuperset(effect.excites):
        yield "it acts in no standard test"


def _free_running(case: _Case) -> Iterator[str]:
    effect = case.effect
    if not effect.asked_in_free_running:
        return
    found = []
    for model in case.models:
        if "roll" in effect.excites and not model.rolls:
            continue
        candidate = free_candidate(effect, Sailing(model, model.ship.speed(_FROUDE)))
        if not candidate.moves:
            continue
        found.append(candidate)
        made = candidate.added_to(model)
        for place in candidate.values:
            if place in OUTSIDE:
                continue
            part, _, name = place.rpartition(".")
            homes = [part] if part else list(made.parts)
            if not any(
                home in made.parts
                and (name in made.parts[home].values or made.parts[home].known.parameter(name))
                for home in homes
            ):
                yield f"it moves {place}, which {model.name} has not"
        if not all(math.isfinite(x) and x != 0.0 for x in candidate.typical.values()):
            yield f"a usual size is zero or not finite for {model.name}"
    if not found:
        yield "it has a place in no ship of the library"


DECLARED: Final[Mapping[str, Callable[[_Case], Iterator[str]]]] = {
    "words": _words,
    "parameters": _parameters,
    "kind": _kind,
    "arguments": _arguments,
    "asked": _asked,
}
"""What it says of itself; the rest is tried where this holds."""
RULES: Final[Mapping[str, Callable[[_Case], Iterator[str]]]] = {
    "numbers and arrays agree": _by_arrays,
    "linear in its coefficients": _linear,
    "states follow the motion": _states,
    "in and out of a model": _enters,
    "Froude's law": _by_froude,
    "compiled and interpreted": _compiled,
    "what records show": acts_on_records,
    "captive tests can be asked": _captive,
    "free-running records can be asked": _free_running,
}
"""What is tried, and how."""
