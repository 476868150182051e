"""Faults of timing: forces and motions that do not belong to one instant."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.effects.definition import Parameter
from pmmkit.effects.faults.fault import ITTC_CAPTIVE, fault, size
from pmmkit.effects.seen import Factor, Forces, Observed
from pmmkit.effects.suspect import CHANNELS, Suspect, both_signs, late_or_early, oscillating
from pmmkit.numerics import Array

SOON: Final = 1e-7
"""Small delay [s] for derivatives: e^(-ix) - 1 = -ix (1 - ix/2 …) bends in quadrature to it."""
LAGS: Final = (0.03, 0.06, 0.12, 0.25, 0.5)
"""Delays that the checks try, to either side [s]."""
PHASES: Final = (2.0, 5.0, 10.0, 20.0, 45.0, 90.0)
"""Phases that the checks try, to either side [deg]."""


def late(run: Observed, at: Mapping[str, float]) -> Forces:
    """Forces that come late: all by seconds or a phase, one channel by seconds of its own."""
    phase = math.radians(at["phase"])
    shown: dict[str, Array] = {}
    for channel in run.forces:
        seconds = at["lag"] + at.get(channel, 0.0)
        if seconds or phase:
            shown |= run.filtered(_delay(seconds, phase), channel)
    return shown


def _delay(seconds: float, phase: float) -> Factor:
    def factor(n: Array, omega: Array) -> NDArray[np.complex128]:
        angle = n * omega * seconds + n * phase
        return np.asarray(np.cos(angle) - 1j * np.sin(angle), np.complex128)

    return factor


def filtered(run: Observed, at: Mapping[str, float]) -> Forces:
    """A one-pole filter of a corner frequency [Hz] on the forces."""
    share, pole = at["share"], 2.0 * math.pi * at["corner"]

    def factor(n: Array, omega: Array) -> NDArray[np.complex128]:
        whole = 1.0 / (1.0 + 1j * n * omega / pole)
        return np.asarray(1.0 + share * (whole - 1.0), np.complex128)

    return run.filtered(factor)


def _own_lag(channel: str) -> Suspect:
    return Suspect(
        name=f"{channel} late",
        says=lambda value: f"{channel} alone comes {abs(value):.2g} s {late_or_early(value)}",
        remedy=f"Look at the filter and the clock of {channel}: a knock shows them.",
        at=lambda value: {channel: value},
        grid=both_signs(LAGS),
        continuous=True,
        applies=oscillating,
        channels=(channel,),
    )


EFFECTS: Final = (
    fault(
        "fault_time_lag",
        "timing",
        "Forces come later than the motion.",
        late,
        (
            size("lag", "s", 0.04, "delay of the forces", step=SOON),
            Parameter(name="phase", unit="deg", text="delay of the forces in phase"),
            *(Parameter(name=c, unit="s", text=f"delay of {c} alone") for c in CHANNELS),
        ),
        check="a knock that both clocks see",
        sources=(ITTC_CAPTIVE,),
        suspects=(
            *map(_own_lag, CHANNELS),
            Suspect(
                name="clocks",
                says=lambda value: (
                    f"the clock of each record starts when it likes, early or late by some "
                    f"{value:.1g} s"
                ),
                remedy="Record the motion beside the forces, or a mark that tells the phase.",
                unknown="lag",
                each_run=True,
                grid=(0.05, 0.15, 0.4),
                applies=oscillating,
                scope="all",
            ),
            Suspect(
                name="half a cycle",
                says=lambda _: "the record starts half a cycle (180°) later than stated",
                remedy="Correct phase_deg of the run by 180°.",
                at=lambda value: {"phase": value},
                grid=(180.0,),
                applies=oscillating,
                slip=True,
            ),
            Suspect(
                name="phase",
                says=lambda value: f"the forces lag the stated motion by a phase of {value:.1f}°",
                remedy="Correct phase_deg, or record the motion.",
                at=lambda value: {"phase": value},
                grid=both_signs(PHASES),
                continuous=True,
                applies=oscillating,
            ),
            Suspect(
                name="lag",
                says=lambda value: (
                    f"the forces come {abs(value):.2g} s {late_or_early(value)} against the motion "
                    f"(a clock)"
                ),
                remedy="Look at the clocks of forces and motion: a knock that both see shows it.",
                at=lambda value: {"lag": value},
                grid=both_signs(LAGS),
                continuous=True,
                applies=oscillating,
            ),
        ),
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
        check="the filter's settings; a knock",
        sources=(ITTC_CAPTIVE,),
        suspects=(
            Suspect(
                name="filter",
                says=lambda value: (
                    f"a one-pole filter of {value:.2g} s ({1 / (2 * math.pi * value):.2g} "
                    f"Hz) makes the forces late"
                ),
                remedy="State the filter, or pass the motion through the same one.",
                at=lambda value: {"share": 1.0, "corner": 1 / (2 * math.pi * value)},
                grid=LAGS,
                continuous=True,
                applies=oscillating,
            ),
        ),
    ),
)
