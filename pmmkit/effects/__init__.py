"""The catalogue of effects: what acts on a ship, one family a file."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.effects.added_mass import INERTIA, dimensional, resolve, unknown_places
    from pmmkit.effects.definition import BY_SPEED, KINDS, Effect, Parameter, Role, unit_is_known
    from pmmkit.effects.entries import (
        CATALOGUE,
        arguments_of,
        catalogue,
        effect,
        is_fault,
        register_effect,
    )
    from pmmkit.effects.faults.alignment import MISALIGNMENT
    from pmmkit.effects.faults.fault import shown_by, slopes, suspicion
    from pmmkit.effects.four_quadrant import FOUR_QUADRANT_PROPELLER
    from pmmkit.effects.grammar import function_of_text, own_effect, own_effects, written_effect
    from pmmkit.effects.hull import (
        FACTOR_PLACES,
        HULL,
        RUDDER_POLYNOMIAL,
        Monomial,
        Regressors,
        in_channel,
        polynomial,
        regressors,
        shared_regressors,
    )
    from pmmkit.effects.primitives import PRIMITIVES, over_arrays, rebound
    from pmmkit.effects.propeller import PROPELLER
    from pmmkit.effects.propeller import force as propeller_force
    from pmmkit.effects.roll import ROLL, ROLL_PART
    from pmmkit.effects.rudder import RUDDER_MMG, normal_force, rudder_flow
    from pmmkit.effects.rudder import force as rudder_force
    from pmmkit.effects.seen import (
        ANTENNA,
        CLOCK_LAG,
        CURRENT,
        EXCITES,
        HEADING_OFFSET,
        LOG_GAIN,
        OUTSIDE,
        RUDDER_ZERO,
        SHOWN,
        Factor,
        Forces,
        Move,
        Observed,
    )
    from pmmkit.effects.shaft import SHAFT
    from pmmkit.effects.shallow_water import SHALLOW_WATER, SHALLOWEST, apply, factors
    from pmmkit.effects.state import State
    from pmmkit.effects.suspect import Suspect
    from pmmkit.effects.waves import WAVE_DRIFT

__all__ = [
    "ANTENNA",
    "BY_SPEED",
    "CATALOGUE",
    "CLOCK_LAG",
    "CURRENT",
    "EXCITES",
    "FACTOR_PLACES",
    "FOUR_QUADRANT_PROPELLER",
    "HEADING_OFFSET",
    "HULL",
    "INERTIA",
    "KINDS",
    "LOG_GAIN",
    "MISALIGNMENT",
    "OUTSIDE",
    "PRIMITIVES",
    "PROPELLER",
    "ROLL",
    "ROLL_PART",
    "RUDDER_MMG",
    "RUDDER_POLYNOMIAL",
    "RUDDER_ZERO",
    "SHAFT",
    "SHALLOWEST",
    "SHALLOW_WATER",
    "SHOWN",
    "WAVE_DRIFT",
    "Effect",
    "Factor",
    "Forces",
    "Monomial",
    "Move",
    "Observed",
    "Parameter",
    "Regressors",
    "Role",
    "State",
    "Suspect",
    "apply",
    "arguments_of",
    "catalogue",
    "dimensional",
    "effect",
    "factors",
    "function_of_text",
    "in_channel",
    "is_fault",
    "normal_force",
    "over_arrays",
    "own_effect",
    "own_effects",
    "polynomial",
    "propeller_force",
    "rebound",
    "register_effect",
    "regressors",
    "resolve",
    "rudder_flow",
    "rudder_force",
    "shared_regressors",
    "shown_by",
    "slopes",
    "suspicion",
    "unit_is_known",
    "unknown_places",
    "written_effect",
]

lazy(__name__)
