"""Does the balance read the known weights that were put on it?"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Final

from pmmkit.conventions import CHANNEL_UNITS
from pmmkit.intake.checks.expected import round_factor
from pmmkit.intake.checks.finding import Check, CheckFinding, figure
from pmmkit.presentation import counted, plus_minus

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign
    from pmmkit.intake.checks.finding import Summary

WRONG: Final = 0.1
"""Share from which a gain is no calibration any more, but another unit, factor or sign: gauges are
calibrated to some per mille, and a bad pulley or a bent wire takes some per cent."""
SPREAD: Final = 1.03
"""Ratio up to which a gain is near a round factor."""
DEAD: Final = "It does not feel the loads: look at the gauge, at its column and at the loads."
POUNDS: Final = {"N": (4.4482216, "lbf"), "N m": (1.3558179, "lbf ft")}
"""Pound-force and pound-force foot [N, N m]."""


def examine_check_loads(
    campaign: Campaign, _summaries: Sequence[Summary]
) -> Iterator[CheckFinding]:
    """Gain of each gauge, and the point of the moments, by the check loads.

    A gain whose 95 % interval does not hold 1 is a warning; from a tenth on it is an error. The
    factor is told and never applied.
    """
    for check in campaign.gauge_checks:
        unit, name = CHANNEL_UNITS[check.channel], check.channel
        loads = f"{counted(len(check.runs), 'check load')}, up to {figure(check.largest)} {unit}"
        told = f"{name} reads {plus_minus(check.gain, check.half)} times what was applied ({loads})"
        numbers = {"gain": check.gain, "std": check.std, "zero": check.zero}
        if check.agrees:
            yield CheckFinding(
                check="check loads",
                severity="info",
                message=f"{told}: its scale is right to that.",
                runs=check.runs,
                numbers=numbers,
            )
        elif check.holds:
            yield CheckFinding(
                check="check loads",
                severity="warning",
                message=f"{told}: that says nothing of its scale.",
                runs=check.runs,
                channels=(name,),
                remedy="Put more and larger loads on, to both sides; look at pulley and wire.",
                numbers=numbers,
            )
        else:
            near = _near(check.gain, unit) if check.felt else ""
            yield CheckFinding(
                check="check loads",
                severity="error" if abs(check.gain - 1.0) > WRONG else "warning",
                message=f"{told}{f', near {near}' if near else ''}. All derivatives of {name} are "
                "off by as much.",
                runs=check.runs,
                channels=(name,),
                remedy=_remedy(name, check.gain) if check.felt else DEAD,
                numbers=numbers,
            )
        if math.isfinite(check.point) and check.felt:
            yield _point(campaign, check.point, check.factor * check.point_std, check.runs)


def _near(gain: float, unit: str) -> str:
    """The unit or the round factor that a gain comes near to, in words."""
    pound, word = POUNDS[unit]
    if abs(math.log(abs(gain) * pound)) < math.log(SPREAD):
        return f"1/{pound:.5g}: readings in {word}"
    return round_factor(gain, spread=SPREAD) or ""


def _remedy(name: str, gain: float) -> str:
    if gain < 0:
        turned = f'Its sign is turned: [[corrections]] action = "flip", channels = ["{name}"]'
        return f"{turned}, or the side of the load is."
    return (
        f"State the unit of its column, or multiply it by {1.0 / gain:.5g}: [[corrections]] with "
        f'runs = ["*"], action = "scale", channels = ["{name}"], factor = {1.0 / gain:.5g}, and '
        "the reason."
    )


def _point(campaign: Campaign, point: float, half: float, runs: tuple[str, ...]) -> CheckFinding:
    """Whether the moments refer to the point that is stated."""
    stated = campaign.moment_reference_x
    told = f"The side loads say that N is about x = {plus_minus(point, half)} m"
    fits = abs(point - stated) <= half
    return CheckFinding(
        check="check loads",
        severity="info" if fits else "warning",
        message=f"{told}; the campaign file says {stated:.4g} m{', which agrees' if fits else ''}.",
        runs=runs,
        remedy=""
        if fits
        else f"moment_reference_x = {point:.4g} under [campaign], or look at the "
        "stations of the loads.",
        numbers={"x": point, "stated": stated},
    )


CHECKS = (
    Check(
        "check loads",
        "gains and moments' point by known weights on the balance",
        examine_check_loads,
    ),
)
