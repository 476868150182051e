"""What is known before free-running records are asked, and how large what nothing explains is."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from pmmkit.diagnosis.captive.adequacy import LEAST
from pmmkit.diagnosis.free_running.evidence import Basis, Fit, fitted
from pmmkit.diagnosis.free_running.system import FreeSystem, agile, held, log_likelihood, sized
from pmmkit.effects.catalogue import effect_of
from pmmkit.identification.prior import Prior, prior_of
from pmmkit.models import Model
from pmmkit.models.model import DERIVATIVE_PARTS

FLOOR: Final = 0.02
"""Unknown forces below this share of the rms force of a channel do not matter."""
WINDOW: Final = 5.0
"""Length of the windows by which sets are judged, in ship lengths over the speed."""
TOLERANCE: Final = (math.radians(0.5), 0.005)
"""Errors of heading [rad] and of speed over the approach that do not matter over a window."""
TURNS: Final = 8
"""Most turns in which the sizes of unknown forces and the values of the largest model are found."""


def base_prior(
    model: Model,
    speed: float,
    *,
    spread: float = 0.05,
    loose: float = 0.1,
    extrapolate: bool = False,
) -> Prior:
    """What is known of the values of a model before records are looked at.

    Parameters
    ----------
    model : Model
        Complete.
    speed : float
        Speed of the approach [m/s].
    spread : float
        By how much of each value another ship of the same lines differs: relative standard
        deviation, beside the covariance of the model.
    loose : float
        Relative standard deviation of values of which the model holds no covariance.
    extrapolate : bool
        Allow a speed outside the range of the model's values.

    Returns
    -------
    Prior
        Derivatives of hull, rudder and added mass, and the uncertain values of other parts.

    Examples
    --------
    >>> from pmmkit.models import load_model
    >>> found = base_prior(load_model("kvlcc2-l7"), 1.179, loose=0.03)
    >>> len(found.names), round(float(found.std[found.names.index("Yv")]), 4)
    (25, 0.0184)
    """
    names = [
        name
        for part in DERIVATIVE_PARTS
        if part in model.parts
        for name in model.parts[part].values
        if effect_of(part).parameter(name) is None
    ] + [
        f"{part.effect}.{item.name}"
        for part in model.parts.values()
        for item in part.known.parameters
        if item.uncertain and item.name in part.values
    ]
    relative = {name: loose for name in names if name not in model.covariance_names}
    found = prior_of(model, names, speed, spread=relative, extrapolate=extrapolate)
    more = np.diag((spread * found.mean) ** 2)
    return replace(found, covariance=found.covariance + more)


def weighed(system: FreeSystem, basis: Basis, every: Sequence[str]) -> tuple[FreeSystem, Fit]:
    """Unknown forces of their most likely size under the largest model, and its fit.

    It begins with large unknown forces: the filter then follows the ship whatever the values are,
    and what is left is almost linear in them. With small ones a fit hangs on where it begins. The
    sizes and the values are found in turns for as long as the records become more probable.
    """
    largest = fitted(agile(system), basis, every)
    best, known = (system, largest), -math.inf
    for _ in range(TURNS):
        found = sized(best[0], system.start + basis.T @ best[1].z)
        largest = fitted(found, basis, every, begin=best[1].z)
        values = system.start + basis.T @ largest.z
        new = log_likelihood(found, values) + largest.log_width
        if new < known + LEAST:
            break
        best, known = (held(found, values), largest), new
    return best
