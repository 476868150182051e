"""How far about straight ahead a polynomial in the motion reaches, and the runs beyond."""

from __future__ import annotations

import math
from typing import Final

from pmmkit.campaigns.run import Campaign, Run

FARTHEST: Final = math.radians(45.0)
"""Drift from which a steady run says nothing to polynomials: the programmes that these were made
for end at 20 to 30°, harbour tests begin beyond."""


def out_of_reach(run: Run) -> bool:
    """Whether a hull was held at a drift angle that no polynomial reaches."""
    drift = abs(math.remainder(run.settings.drift, 2 * math.pi))
    return not run.kind_of_test.swings_hull and drift > FARTHEST


def within_reach(campaign: Campaign) -> Campaign:
    """The campaign without its runs across the flow, which are left out with the reason.

    A campaign that holds no others stays as it is.

    Examples
    --------
    >>> from pmmkit.campaigns.settings import Settings
    >>> from pmmkit.conventions import Ship, Water
    >>> ship = Ship(name="m", L=4.0, B=1.0, d=.25, volume=.5, mass=500., Izz=500.)
    >>> runs = tuple(Run(id=f"{drift}°", test="static_drift", kind="means", loader=None,
    ...                  settings=Settings(speed=1.0, drift=math.radians(drift)))
    ...              for drift in (10, 90))
    >>> near = within_reach(Campaign(title="", ship=ship, water=Water(), runs=runs))
    >>> [run.id for run in near.runs], [run.id for run, _ in near.excluded]
    (['10°'], ['90°'])
    """
    far = [run for run in campaign.runs if out_of_reach(run)]
    if not far or len(far) == len(campaign.runs):
        return campaign
    reason = (
        f"its drift is above {math.degrees(FARTHEST):.0f}°, where the flow goes across the hull: a "
        "polynomial about straight ahead does not reach so far (use cross-flow drag)"
    )
    return campaign.with_(
        runs=tuple(run for run in campaign.runs if not out_of_reach(run)),
        excluded=(*campaign.excluded, *((run, reason) for run in far)),
    )
