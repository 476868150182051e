"""A force of one's own in the records of a campaign of the virtual tank."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from hidden_effects.motion import Array, Motion, motion_of
from hidden_effects.programmes import plans
from hidden_effects.sizes import SHIP, WATER
from hidden_effects.tank import record_times

from pmmkit import Campaign, Run

Forces = Callable[[Motion], Mapping[str, Array]]
"""Forces over ½ρL²U², moments over ½ρL³U², along the motion of midship."""


def with_force(campaign: Campaign, programme: str, force: Forces) -> Campaign:
    """A campaign whose gauges read a force more, along the motion that its programme states."""
    by_id = {plan.id: plan for plan in plans(programme)}

    def run_of(run: Run) -> Run:
        plan = by_id[run.id]
        motion = motion_of(plan, record_times(plan))
        unit = 0.5 * WATER.rho * SHIP.L**2 * (motion.u**2 + motion.v**2)
        data = run.data.copy()
        for name, prime in force(motion).items():
            arm = SHIP.L if name == "N" else 1.0
            data[name] = data[name] + unit * arm * np.asarray(prime)
        return replace(run, loader=lambda: data)

    return campaign.with_(runs=tuple(map(run_of, campaign.runs)))
