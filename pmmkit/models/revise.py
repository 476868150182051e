"""A value or a part of a model changed by hand, with the reason."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Final

from pmmkit.base import ModelError, UnknownNameError, did_you_mean
from pmmkit.conventions import parse_derivative
from pmmkit.models.model import Model
from pmmkit.models.part import DERIVATIVE_PARTS, Part, place_name
from pmmkit.models.particulars import (
    ANOTHER,
    ANOTHER_DRAWN,
    DRAWN,
    ELSEWHERE,
    PROPELLER_ERRORS,
    RUDDER_ERRORS,
)
from pmmkit.models.scale import scaled
from pmmkit.models.step import Step, Value

ERRORS: Final = MappingProxyType({"propeller": PROPELLER_ERRORS, "rudder_mmg": RUDDER_ERRORS})


def with_stated(model: Model, values: Mapping[str, float], because: str) -> Model:
    """A model with values that somebody states, the same at all Froude numbers.

    Parameters
    ----------
    model : Model
        The model.
    values : mapping of str to float
        By place: a part and its value (``rudder_mmg.area``, or ``rudder.area`` and
        ``propeller.D`` for whatever steers and drives), or a derivative (``Nvvr``).
    because : str
        The reason, which the model keeps.

    Returns
    -------
    Model
        What is stated has no uncertainty any more.

    Raises
    ------
    UnknownNameError
        If the model has no such part or value.

    Examples
    --------
    >>> from pmmkit.models.store import load_model
    >>> larger = with_stated(load_model("kvlcc2"), {"rudder.area": 120.0}, "the yard's drawing")
    >>> larger.values("rudder_mmg")["area"], larger.steps[-1].note
    (120.0, "the yard's drawing")
    """
    parts = dict(model.parts)
    stated: dict[str, Value] = {}
    for place, value in values.items():
        effect, name = place_of(model, place)
        part = parts[effect]
        size = len(model.Fn) if isinstance(part.values.get(name), tuple) else 0
        whole: Value = (float(value),) * size if size else float(value)
        stated[f"{effect}.{name}"] = whole
        parts[effect] = replace(
            part,
            values=MappingProxyType({**part.values, name: whole}),
            sources=MappingProxyType({**part.sources, name: f"stated: {because}"}),
            std=MappingProxyType({k: x for k, x in part.std.items() if k != name}),
        )
    sure = {place_name(*place.split(".", 1)) for place in stated}
    C, names = model.covariance_of([name for name in model.covariance_names if name not in sure])
    made = replace(model, parts=MappingProxyType(parts), covariance=C, covariance_names=names)
    step = Step(
        action="stated",
        numbers=MappingProxyType(stated),
        note=because,
        before=model.before(made, tuple(stated)),
    )
    return made.stepped(step)


def place_of(model: Model, words: str) -> tuple[str, str]:
    """Part and value that words mean, as ``rudder.area`` or ``Yv``."""
    said, dot, name = words.rpartition(".")
    if dot:
        return _known(model, part_of(model, said), name)
    for effect in DERIVATIVE_PARTS:
        if effect in model.parts and _spelled(name) in model.parts[effect].values:
            return effect, _spelled(name)
    everywhere = [f"{effect}.{own}" for effect, part in model.parts.items() for own in part.values]
    raise UnknownNameError(
        f"Model {model.name!r} has no value {words!r}{did_you_mean(words, everywhere) or '.'} "
        f"Values of parts are written as rudder.area; pmmkit model show lists all."
    )


def part_of(model: Model, words: str) -> str:
    """The part that words mean: its name, or ``rudder`` and ``propeller`` for what it does."""
    if words in model.parts:
        return words
    role = {"rudder": "steering", "propeller": "propulsion"}.get(words, "")
    found = [name for name, part in model.parts.items() if part.known.serves(role)]
    if len(found) != 1:
        raise UnknownNameError(
            f"Model {model.name!r} has no part {words!r}"
            f"{did_you_mean(words, model.parts) or '.'} It has {', '.join(model.parts)}."
        )
    return found[0]


def _known(model: Model, effect: str, name: str) -> tuple[str, str]:
    part = model.parts[effect]
    parameters = [item.name for item in part.known.parameters]
    own = name if name in parameters else _spelled(name)
    if own in part.values or own in parameters or part.known.accepts(own):
        return effect, own
    known = [*part.values, *(item for item in parameters if item not in part.values)]
    raise UnknownNameError(
        f"{effect} has no value {name!r}{did_you_mean(name, known) or '.'} It has "
        f"{', '.join(known)}."
    )


def _spelled(name: str) -> str:
    try:
        return parse_derivative(name).name
    except UnknownNameError:
        return name


def with_part_of(model: Model, words: str, donor: Model, because: str = "") -> Model:
    """A model with a part of another one, scaled to its length by Froude's law.

    Parameters
    ----------
    model : Model
        The model.
    words : str
        The part: its name, or ``propeller`` or ``rudder`` for whatever drives or steers; what
        does the same in the model goes.
    donor : Model
        The model that lends it.
    because : str
        The reason, which the model keeps.

    Returns
    -------
    Model
        The part as `lent`. The slipstream reaches as much of the rudder as the diameter of the
        propeller says.

    Raises
    ------
    UnknownNameError
        If the donor has no such part.

    Examples
    --------
    >>> from pmmkit.models.store import load_model
    >>> other = with_part_of(load_model("kcs"), "propeller", load_model("kvlcc2"))
    >>> other.part("propeller").source
    'library: kvlcc2'
    """
    name = part_of(donor, words)
    own_ship = not donor.ship.form_apart(model.ship)
    part = lent(scaled(donor, model.ship.L).parts[name], donor.name, same_ship=own_ship)
    same = [
        own
        for own, there in model.parts.items()
        if own == name
        or (there.known.drives and part.known.drives)
        or (there.known.steers and part.known.steers)
    ]
    if any(own in DERIVATIVE_PARTS for own in (*same, name)):
        raise ModelError("The hull comes from tests: reduce them, or take the other model whole.")
    parts = {own: there for own, there in model.parts.items() if own not in same} | {name: part}
    made = replace(model, parts=MappingProxyType(parts))
    step = Step(action="part_replaced", effect=name, parts=donor.name, note=because)
    return _in_the_slipstream(model, made).stepped(step)


def _in_the_slipstream(old: Model, new: Model) -> Model:
    """The rudder with as much of its height in the slipstream as a new diameter reaches."""
    if not all(x in m.parts for m in (old, new) for x in ("propeller", "rudder_mmg")):
        return new
    before, after = (m.parts["propeller"].values["D"] for m in (old, new))
    eta = new.parts["rudder_mmg"].values.get("eta")
    kept = old.parts["rudder_mmg"] == new.parts["rudder_mmg"]
    if not (isinstance(eta, float) and isinstance(before, float) and isinstance(after, float)):
        return new
    return new.with_values("rudder_mmg", eta=eta * after / before) if kept else new


def lent(part: Part, source: str = "", *, same_ship: bool) -> Part:
    """A part from elsewhere, with the uncertainty that its values have on the ship that takes it.

    Parameters
    ----------
    part : Part
        Of the other model.
    source : str
        Its name, where it is not said in the part.
    same_ship : bool
        Whether that is of the same ship: what drawings and an open-water test say is no other
        there, and is certain.
    """
    errors = ERRORS.get(part.effect, {})
    left = {name: share_left(name, same_ship=same_ship) for name in errors}
    return replace(
        part,
        source=f"library: {source}" if source else part.source,
        sources=MappingProxyType({}) if source else part.sources,
        std=MappingProxyType(
            {
                name: left[name] * errors[name].of(value)
                for name, value in part.values.items()
                if left.get(name) and isinstance(value, float)
            }
        ),
    )


def share_left(name: str, *, same_ship: bool) -> float:
    """Share of the error of an estimate that a value has where a ship lends it.

    Examples
    --------
    >>> share_left("aH", same_ship=True), share_left("area", same_ship=True)
    (0.5, 0.0)
    """
    if name in DRAWN:
        return 0.0 if same_ship else ANOTHER_DRAWN
    return ELSEWHERE if same_ship else ANOTHER
