"""Frequencies of the oscillation against what keeps the test quasi-steady and free of waves."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.campaigns import TEST_KINDS
from pmmkit.intake.checks.finding import Check, CheckFinding, figure

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign
    from pmmkit.intake.checks.finding import Summary

QUARTER: Final = 0.25
NEAR_QUARTER: Final = 0.2
RESONANCE: Final = 0.05


def examine_frequencies(campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """ωU/g against 1/4, ω' = ωL/U against guidance, and standing waves across the tank.

    Above ωU/g = 1/4 the waves of the oscillation no longer run ahead of the model; at 1/4 they
    stay with it. ω' up to about 2 in sway and 3 in yaw counts as quasi-steady. Across a tank of
    width W waves stand at ω² = g k tanh(k h) with k = n π/W.
    """
    moved = [
        (item, omega)
        for item in summaries
        if item.run.dynamic and (omega := item.run.settings.omega) is not None
    ]
    g, L = campaign.water.g, campaign.ship.L
    tau = [(item, omega * item.run.settings.speed / g) for item, omega in moved]
    high = [(item, value) for item, value in tau if value >= QUARTER]
    near = [(item, value) for item, value in tau if NEAR_QUARTER <= value < QUARTER]
    if high:
        top = max(value for _, value in high)
        yield CheckFinding(
            check="frequency",
            severity="warning",
            message=f"ωU/g reaches {figure(top)} in {len(high)} runs; it should stay well below "
            f"0.25, where the model meets its own waves.",
            runs=tuple(item.run.id for item, _ in high),
            remedy="Leave these runs out, or expect derivatives that depend on the frequency.",
            numbers={"tau": top},
        )
    if near:
        top = max(value for _, value in near)
        yield CheckFinding(
            check="frequency",
            severity="info",
            message=f"ωU/g is {figure(top)} in {len(near)} runs, near 0.25.",
            runs=tuple(item.run.id for item, _ in near),
            numbers={"tau": top},
        )
    quick = [
        (item, value)
        for item, omega in moved
        if (value := omega * L / item.run.settings.speed) > item.run.kind_of_test.quasi_steady
    ]
    if quick:
        top = max(value for _, value in quick)
        limits = ", ".join(
            f"{TEST_KINDS[test].quasi_steady:.0f} in {test}"
            for test in sorted({item.run.test for item, _ in quick})
        )
        yield CheckFinding(
            check="frequency",
            severity="info",
            message=f"ω' = ωL/U reaches {figure(top)} in {len(quick)} runs; up to about {limits} "
            f"counts as quasi-steady.",
            runs=tuple(item.run.id for item, _ in quick),
            remedy="Look whether the derivatives of these runs follow the slower ones.",
            numbers={"omega_prime": top},
        )
    width = campaign.water.tank_width
    if width:
        yield from _standing(moved, width, campaign.water.tank_depth or campaign.water.depth, g)


def _standing(
    moved: Sequence[tuple[Summary, float]], width: float, depth: float | None, g: float
) -> Iterator[CheckFinding]:
    wave = np.arange(1, 6) * math.pi / width
    resonances = np.sqrt(g * wave * (np.tanh(wave * depth) if depth else 1.0))
    close = [
        (item, omega) for item, omega in moved if np.min(np.abs(omega / resonances - 1)) < RESONANCE
    ]
    if close:
        item, omega = min(close, key=lambda pair: float(np.min(np.abs(pair[1] / resonances - 1))))
        order = int(np.argmin(np.abs(omega / resonances - 1)))
        yield CheckFinding(
            check="frequency",
            severity="warning",
            message=f"The frequency {figure(omega)} rad/s of {item.run.id} lies within 5 % of wave "
            f"number {order + 1} standing across a tank {figure(width)} m wide, "
            f"{figure(float(resonances[order]))} rad/s.",
            runs=tuple(entry.run.id for entry, _ in close),
            remedy="Choose another frequency, or look for beating in the records.",
            numbers={"omega": omega, "resonance": float(resonances[order])},
        )


CHECKS = (
    Check(
        "frequency",
        "ωU/g against 1/4, ω' and waves standing across the tank",
        examine_frequencies,
        by_particulars=True,
    ),
)
