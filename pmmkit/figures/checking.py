"""Figures of what the checks found."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pmmkit.channels import CHANNEL_UNITS
from pmmkit.checks.finding import CheckFinding
from pmmkit.checks.zeros import zero_channels
from pmmkit.plotting.zeros import zeros_over_the_day

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def zeros_at_rest(finding: CheckFinding) -> Figure:
    """What the gauges show at rest, run by run in the order of the day.

    Parameters
    ----------
    finding : CheckFinding
        Of the check ``zeros``.
    """
    runs = finding.by_run
    channels = zero_channels(finding)
    return zeros_over_the_day(
        list(runs),
        {name: np.array([x.get(name, np.nan) for x in runs.values()]) for name in channels},
        {
            name: np.array([x.get(f"{name}_std", np.nan) for x in runs.values()])
            for name in channels
        },
        CHANNEL_UNITS,
    )
