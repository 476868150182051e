"""The catalogue of effects: what acts on a ship, one family a file."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.effects.added_mass import INERTIA, AddedMass
    from pmmkit.effects.definition import BY_SPEED, Effect, Parameter
    from pmmkit.effects.entries import CATALOGUE, catalogue, effect, is_fault, register_effect
    from pmmkit.effects.grammar import (
        function_of_text,
        own_effect,
        own_effects,
        own_effects_text,
        written_effect,
    )
    from pmmkit.effects.hull import HULL, Regressors
    from pmmkit.effects.primitives import PRIMITIVES, rebound
    from pmmkit.effects.seen import CURRENT, OUTSIDE, Move
    from pmmkit.effects.shallow_water import apply
    from pmmkit.effects.state import State
    from pmmkit.effects.suspect import Suspect

__all__ = [
    "BY_SPEED",
    "CATALOGUE",
    "CURRENT",
    "HULL",
    "INERTIA",
    "OUTSIDE",
    "PRIMITIVES",
    "AddedMass",
    "Effect",
    "Move",
    "Parameter",
    "Regressors",
    "State",
    "Suspect",
    "apply",
    "catalogue",
    "effect",
    "function_of_text",
    "is_fault",
    "own_effect",
    "own_effects",
    "own_effects_text",
    "rebound",
    "register_effect",
    "written_effect",
]

lazy(__name__)
