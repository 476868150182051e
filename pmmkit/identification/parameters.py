"""Values of a model as a flat list of numbers, by name, and back."""

from __future__ import annotations

from collections.abc import Sequence

from pmmkit.equations.prepared import Numbers
from pmmkit.errors import UnknownNameError
from pmmkit.models import Model
from pmmkit.models.model import DERIVATIVE_PARTS
from pmmkit.numerics import Array

Place = tuple[str, str]
"""Effect and name of a value."""


def places(model: Model, names: Sequence[str]) -> tuple[Place, ...]:
    """Where the values of names stand: ``Yv``, or ``rudder_mmg.aH`` for a parameter of an effect.

    Raises
    ------
    UnknownNameError
        With all names of which the model has no number.

    Examples
    --------
    >>> from pmmkit.models import load_model
    >>> places(load_model("kvlcc2"), ["Yv", "rudder_mmg.aH"])
    (('hull_polynomial', 'Yv'), ('rudder_mmg', 'aH'))
    """
    found, lost = [], []
    for name in names:
        effect, dot, own = name.partition(".")
        if dot:
            part = model.parts.get(effect)
            parameter = part.known.parameter(own) if part is not None else None
            there = part is not None and (
                (parameter is not None and not parameter.table) or own in part.values
            )
            found.append((effect, own)) if there else lost.append(name)
            continue
        home = [part for part in DERIVATIVE_PARTS if name in _values(model, part)]
        found.append((home[0], name)) if home else lost.append(name)
    if lost:
        raise UnknownNameError(
            f"Model {model.name!r} has no value {', '.join(lost)} that could be fitted. Write a "
            f"derivative as Yv, a parameter with its effect as rudder_mmg.aH, and give it a start "
            f"value in the model."
        )
    return tuple(found)


def _values(model: Model, effect: str) -> dict[str, object]:
    return dict(model.parts[effect].values) if effect in model.parts else {}


def replaced(numbers: Numbers, at: Sequence[Place], values: Array) -> Numbers:
    """Values by effect and name with some of them changed."""
    changed = {effect: dict(own) for effect, own in numbers.items()}
    for (effect, name), value in zip(at, values.tolist(), strict=True):
        changed[effect][name] = value
    return changed


def with_parameters(model: Model, at: Sequence[Place], values: Array) -> Model:
    """The model with other values, the same at all of its Froude numbers."""
    made = model
    for effect in dict.fromkeys(effect for effect, _ in at):
        own = {
            name: value
            for (other, name), value in zip(at, values.tolist(), strict=True)
            if other == effect
        }
        made = made.with_values(effect, **own)
    return made
