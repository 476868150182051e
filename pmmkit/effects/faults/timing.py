"""Faults of timing: forces and motions that do not belong to one instant."""

from __future__ import annotations

import math
from typing import Final

from pmmkit.effects.effect import Parameter
from pmmkit.effects.faults.fault import ITTC_CAPTIVE, Columns, fault, one, size
from pmmkit.effects.seen import Observed


def late(run: Observed, value: float) -> Columns:
    """Forces that come a second late."""
    del value
    return one(run.filtered(lambda n: -1j * n * run.omega))


def filtered(run: Observed, corner: float) -> Columns:
    """A one-pole filter of a corner frequency [Hz] on the forces."""
    pole = 2.0 * math.pi * corner
    return one(run.filtered(lambda n: 1.0 / (1.0 + 1j * n * run.omega / pole) - 1.0))


EFFECTS: Final = (
    fault(
        "fault_time_lag",
        "timing",
        "Forces come later than the motion.",
        late,
        (size("lag", "s", 0.04, "delay of the forces"),),
        known_as="lag",
        check="a knock that both clocks see",
        sources=(ITTC_CAPTIVE,),
    ),
    fault(
        "fault_filter_lag",
        "timing",
        "A filter on the forces and not on the motion.",
        filtered,
        (
            size("share", "-", 0.1, "of a one-pole filter; 1 is the whole filter", expected=1.0),
            Parameter(
                name="corner",
                unit="1/s",
                text="corner [Hz]",
                grid=(1.0, 1.4, 2.0, 2.8, 4.0, 6.0, 10.0),
            ),
        ),
        known_as="filter",
        check="the filter's settings; a knock",
        sources=(ITTC_CAPTIVE,),
    ),
)
