"""What the parts of a model do for the ship, as their effects declare it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from pmmkit.effects.catalogue import catalogue
from pmmkit.effects.effect import Effect, Role
from pmmkit.models.model import Model

SAILING: Final[tuple[Role, ...]] = ("propulsion", "steering")
"""What a ship needs beside its hull."""


def parts_of(model: Model, role: Role) -> tuple[str, ...]:
    """The parts of a model that have a role.

    Examples
    --------
    >>> from pmmkit.models.store import load_model
    >>> parts_of(load_model("kvlcc2"), "propulsion")
    ('propeller',)
    """
    return tuple(name for name, part in model.parts.items() if role in part.known.roles)


def lacking(model: Model) -> tuple[Role, ...]:
    """What a model has no part for and needs besides the hull, to be sailed.

    A model in the loss of speed Δu holds the propeller's share in its hull.

    Examples
    --------
    >>> from pmmkit.models.store import load_model
    >>> ship = load_model("kvlcc2")
    >>> hull = {"hull_polynomial": ship.parts["hull_polynomial"]}
    >>> lacking(ship), lacking(ship.with_(parts=hull))
    ((), ('propulsion', 'steering'))
    """
    held = {"propulsion"} if model.convention.surge == "delta-u" else set()
    return tuple(role for role in SAILING if role not in held and not parts_of(model, role))


def in_role(role: Role) -> tuple[str, ...]:
    """All effects of the catalogue that have a role."""
    return tuple(effect.name for effect in catalogue().values() if role in effect.roles)


def serves(effect: Effect, role: Role) -> bool:
    """Whether an effect has a role, and is no share of the hull beside it."""
    return role in effect.roles and not _holds_the_hull(effect.outputs)


def drives(effect: Effect) -> bool:
    """Whether an effect is a propeller or another drive, and no share of the hull beside it."""
    return serves(effect, SAILING[0])


def steers(effect: Effect) -> bool:
    """Whether an effect is a rudder or another gear that steers, and nothing of the hull."""
    return serves(effect, SAILING[1])


def _holds_the_hull(outputs: Iterable[str]) -> bool:
    return any(output.endswith("dot") for output in outputs)
