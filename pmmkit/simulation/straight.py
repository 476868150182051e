"""A ship that is held straight, whose hull resists astern as it does ahead."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from types import MappingProxyType
from typing import Final, TypeVar

from pmmkit.base import ModelError
from pmmkit.conventions import parse_derivative
from pmmkit.effects import HULL, INERTIA
from pmmkit.models import Model, Part, Step

T = TypeVar("T")
HELD: Final = (
    "The ship is held straight, and her hull resists astern as it does ahead: derivatives of tests "
    "ahead say nothing of a ship that moves astern."
)
STRAIGHT: Final = frozenset({"u", "|u|", "0"})
"""Factors of the forces on a ship that goes straight."""


@lru_cache(maxsize=64)
def held_straight(model: Model) -> Model:
    """A model of the surge alone, ahead and astern.

    Parameters
    ----------
    model : Model
        Whose propulsion is known in all quadrants, by an estimate where it must be
        (`as_it_stops`): a part ``propeller`` or ``four_quadrant_propeller``, or one with a bucket.

    Returns
    -------
    Model
        Hull, added mass, propulsion and shaft, without what acts across the ship. Ahead the forces
        of a straight run are those of the model. Even terms of the resistance turn with the speed:
        Xuu u² becomes Xu|u| u|u|.

    Raises
    ------
    ModelError
        If nothing is known of its propulsion astern, or its resistance is expanded about a speed.

    Examples
    --------
    >>> from pmmkit.models import load_model
    >>> made = held_straight(load_model("kvlcc2"))
    >>> dict(made.parts["hull_polynomial"].values), list(made.parts)[2:]
    ({'Xu|u|': -0.022}, ['four_quadrant_propeller', 'rudder_abkowitz'])
    """
    turning = model.as_it_stops()
    known = turning and ("four_quadrant_propeller" in turning.parts or model.has_bucket)
    if turning is None or not known:
        raise ModelError(
            f"Model {model.name!r} does not say what its propulsion does while the ship moves "
            f"astern: state a part four_quadrant_propeller."
        )
    if model.convention.surge == "delta-u":
        raise ModelError(
            f"The surge terms of model {model.name!r} are expanded about its approach speed: they "
            f"give no resistance astern. State its resistance as Xuu with surge = "
            f'"u" or "constant".'
        )
    parts, renamed = {}, {}
    for name, part in turning.parts.items():
        if name == HULL:
            renamed = {own: _odd(own) for own in part.values if _along(own)}
            parts[name] = _only(part, renamed)
        elif name == INERTIA:
            kept = [own for own in part.values if own != "lx" and not parse_derivative(own).rolls]
            parts[name] = _only(part, dict(zip(kept, kept, strict=True)))
        elif part.known.drives or "n" in part.known.states:
            parts[name] = _along_the_ship(part)
    parts.setdefault("rudder_abkowitz", Part(effect="rudder_abkowitz"))
    there = {part.place(own) for part in parts.values() for own in part.values}
    names = [x for x in turning.covariance_names if renamed.get(x, x) in there]
    C, names_left = turning.covariance_of(names)
    made = replace(
        turning,
        parts=MappingProxyType(parts),
        covariance=C,
        covariance_names=tuple(renamed.get(x, x) for x in names_left),
    )
    return made.stepped(Step(action="noted", note=HELD))


def _along(name: str) -> bool:
    """Whether a derivative is of the force along a ship that goes straight."""
    known = parse_derivative(name)
    return known.channel == "X" and STRAIGHT.issuperset(known.factors)


def _odd(name: str) -> str:
    """A derivative of the resistance that turns with the speed, and is the same ahead."""
    known = parse_derivative(name)
    factors = [x for x in known.factors if x != "0"] or ["u", "u"]
    if factors.count("u") % 2:
        return name
    return parse_derivative("X" + "".join(["|u|", *factors[1:]])).name


def _only(part: Part, names: Mapping[str, str]) -> Part:
    """A part with some of its values, by their new names."""
    return replace(
        part,
        values=MappingProxyType({new: part.values[old] for old, new in names.items()}),
        sources=_renamed(part.sources, names),
        std=_renamed(part.std, names),
    )


def _renamed(given: Mapping[str, T], names: Mapping[str, str]) -> Mapping[str, T]:
    return MappingProxyType({new: given[old] for old, new in names.items() if old in given})


def _along_the_ship(part: Part) -> Part:
    """A propulsion without a wake that drift changes and without side force astern."""
    across = {"wake", "astern"}
    options = {name: word for name, word in part.options.items() if name not in across}
    chosen = part.known.chosen(options)
    forms = {item.name: item.form for item in part.known.parameters}
    kept = [
        name
        for name in part.values
        for form in [forms.get(name)]
        if form is None or chosen[form[0]] in form[1:]
    ]
    made = replace(part, options=MappingProxyType(options))
    return _only(made, dict(zip(kept, kept, strict=True)))
