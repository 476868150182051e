"""Whether the thrust of a propeller that turned can be told from the resistance."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

from pmmkit.inference import COVERAGE
from pmmkit.reduction.observations.equations import Rows
from pmmkit.reduction.solve import Solution

PLAUSIBLE: Final = (0.3, 1.2)
"""Share of the thrust that pushes a hull, 1 - t: merchant hulls have 0.7 to 0.9, and no test that
tells it is so far off as these. Revolutions in proportion to the speed give thrust and resistance
one form; noise of the thrust then decides, and the share goes to zero or to anything."""
TOGETHER: Final = frozenset({"Xuu", "XT"})
"""Derivatives that stand for each other where it cannot be told."""


def thrust_inside(solution: Solution, rows: Sequence[Rows]) -> tuple[int, ...]:
    """Froude groups in which Xuu holds thrust: it was not measured, did not vary by itself, or its
    share is no propeller's.
    """
    return tuple(
        group
        for group, item in solution.fits
        if item.channel == "X"
        and "Xuu" in item.fit.names
        and any(
            rows[solution.groups[group][block.run]].result.run.settings.propeller_rps
            for block in item.blocks
        )
        and not _is_a_propellers(solution, group)
    )


def _is_a_propellers(solution: Solution, group: int) -> bool:
    """Whether a share of the thrust was found that a propeller may have."""
    labels = solution.joint.labels
    if (group, "XT") not in labels:
        return False
    place = labels.index((group, "XT"))
    value = float(solution.joint.value[place])
    half = COVERAGE * math.sqrt(float(solution.joint.covariance[place, place]))
    return value + half > PLAUSIBLE[0] and value - half < PLAUSIBLE[1]
