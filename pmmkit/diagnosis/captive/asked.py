"""Which effects of the catalogue captive tests are asked for."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from pmmkit.campaigns.repeats import repeats
from pmmkit.diagnosis.captive.base import Base
from pmmkit.diagnosis.captive.candidate import Candidate, candidate_of
from pmmkit.effects.catalogue import catalogue
from pmmkit.effects.effect import Effect
from pmmkit.observations.views import View

LARGE: Final = (0.3, 0.8)
"""Sway over speed, and yaw rate r', from which terms of high order are looked for."""


def asked_in_captive(effect: Effect) -> bool:
    """Whether captive tests are asked for an effect."""
    return bool(effect.coefficients) and not effect.not_captive


def captive_candidates(
    speeds: Sequence[float] = (), own: Sequence[Effect] = ()
) -> tuple[Candidate, ...]:
    """Every effect and fault that captive tests can be asked for.

    Parameters
    ----------
    speeds : sequence of float
        Of the tests [m/s]; without them, effects whose grid they are have none.
    own : sequence of Effect
        Beside the catalogue.

    Examples
    --------
    >>> "memory" in [item.name for item in captive_candidates()]
    True
    """
    every = {item.name: item for item in (*catalogue().values(), *own)}
    asked = (candidate_of(item, speeds) for item in every.values() if asked_in_captive(item))
    return tuple(item for item in asked if item.grid)


def eligible(
    base: Base, speeds: Sequence[float], own: Sequence[Effect] = ()
) -> tuple[Candidate, ...]:
    """The catalogue and effects of the user, without what the base has already.

    Parameters
    ----------
    base : Base
        Derivatives.
    speeds : sequence of float
        Of the tests [m/s].
    own : sequence of Effect
        Beside the catalogue.
    """
    known = {name for names in base.names.values() for name in names}
    return tuple(
        item for item in captive_candidates(speeds, own) if not set(item.coefficients) <= known
    )


def excited(views: Sequence[View], base: Base) -> frozenset[str]:
    """What runs hold, in the words of `effects.seen.EXCITES`."""
    speeds = {round(view.speed, 6) for view in views}
    runs = tuple({view.run.id: view.run for view in views}.values())
    sway = max(float(np.max(np.abs(view.motion.v) / view.motion.speed)) for view in views)
    yaw = max(
        float(np.max(np.abs(view.motion.r) / view.motion.speed)) * base.ship.L for view in views
    )
    return frozenset(
        word
        for word, there in {
            "several speeds": len(speeds) > 1,
            "four speeds": len(speeds) > 3,
            "repeats": any(len(own) > 1 for own in repeats(runs)),
            "roll": any(np.any(view.motion.phi) or np.any(view.motion.p) for view in views),
            "rudder": any(np.any(view.motion.delta) for view in views),
            "large motion": sway > LARGE[0] or yaw > LARGE[1],
            "sinkage": any(np.any(view.motion.sinkage) for view in views),
        }.items()
        if there
    )
