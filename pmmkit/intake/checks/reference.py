"""The point to which the moments refer: symmetry of the mass matrix, lever of the rudder."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.intake.checks.expected import expected, is_shallow
from pmmkit.intake.checks.finding import Check, CheckFinding, figure, share_of
from pmmkit.intake.checks.signs import RUDDER_LIMIT
from pmmkit.presentation import WIDE

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign
    from pmmkit.intake.checks.finding import Summary

SIGMAS: Final = 3.0
ASYMMETRY: Final = 0.02
IN_SHALLOW_WATER: Final = 0.12
"""The same near the bottom, over the length: moments of KCS are about midship and seem to be about
a point 0.05, 0.05 and 0.11 L forward of it at 2, 1.5 and 1.2 draughts (Flanders Hydraulics)."""
STERN: Final = 0.5
SLACK: Final = 0.05


def examine_reference(campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """Where the moments refer to, from the data, against `moment_reference_x`.

    The matrix of inertia (hull, water, or both) is symmetric where motions and moments refer to
    one point: N over v̇ equals Y over ṙ. Moments about a point at x_p instead give
    x_p = (Y_ṙ - N_v̇)/Y_v̇. A rudder acts at the stern, so the lever N_δ/Y_δ about midship cannot
    exceed half the length by much; a longer one says that the moments refer to a point forward.
    Symmetry alone is a warning, as hulls with way on keep it only roughly, near the bottom more so;
    together with the rudder, or where it is the weight of the model that speaks, it is an error.
    """
    L = campaign.ship.L
    stated = campaign.moment_reference_x
    motion = campaign.motion_reference_x
    symmetric = _symmetry(campaign, summaries)
    lever = _lever(summaries)
    forward = _too_long(lever, stated, L) if lever is not None else None
    if symmetric is not None:
        point, std, runs = symmetric
        point += motion
        agrees = forward is not None and point > stated
        slack = IN_SHALLOW_WATER if is_shallow(campaign) and not agrees else ASYMMETRY
        if abs(point - stated) > max(SIGMAS * std, slack * L):
            yield CheckFinding(
                check="moment reference",
                severity="error" if agrees else "warning",
                message=f"Y in phase with ṙ and N in phase with v̇ are equal, as a mass matrix "
                f"asks, only if the moments refer to a point at x = {figure(point)} ± "
                f"{figure(WIDE * std, 2)} m ({point / L:+.3f} ± {WIDE * std / L:.3f} L); the "
                f"campaign file says moment_reference_x = {stated:.4g} m ({stated / L:+.3f} L)."
                + (
                    " The lever of the rudder speaks for a point forward as well." if agrees else ""
                ),
                runs=runs,
                remedy="Find the point between or at the gauges to which the moments refer "
                f"(the centre of gravity lies at {campaign.ship.xG:.4g} m) and write it as "
                "moment_reference_x.",
                numbers={"x": point, "std": std, "stated": stated, "x_over_L": point / L},
            )
    if forward is not None and lever is not None:
        value, std, runs = lever
        yield CheckFinding(
            check="moment reference",
            severity="error" if value + stated < -(STERN + 0.25) * L else "warning",
            message=f"The lever N/Y of the rudder is {figure(value / L)} ± "
            f"{figure(WIDE * std / L, 2)} L about the point of the moments, "
            f"{figure((value + stated) / L)} L about midship with moment_reference_x "
            f"= {stated:.4g} m; a rudder cannot act further aft than the stern, -0.5 L. "
            f"The moments refer to a point at least {figure(forward)} m further forward, or N and "
            f"Y differ in scale by {100 * (abs(value + stated) / (STERN * L) - 1):.0f} %.",
            runs=runs,
            remedy="Find the point to which the moments refer, and check the gauges of Y and N.",
            numbers={"lever": value, "std": std, "lever_over_L": value / L, "forward": forward},
        )


def _symmetry(
    campaign: Campaign, summaries: Sequence[Summary]
) -> tuple[float, float, tuple[str, ...]] | None:
    """The point, its standard error [m], and the runs."""
    sway = [item for item in summaries if item.run.kind_of_test.pure == "v" and item.s("vdot", 1)]
    yaw = [
        item
        for item in summaries
        if item.run.kind_of_test.pure == "r"
        and abs(item.run.settings.drift) < math.radians(0.2)
        and item.s("rdot", 1)
    ]
    if len(sway) < 2 or len(yaw) < 2 or {item.run.forces for item in (*sway, *yaw)} == set():
        return None
    vdot = np.array([item.s("vdot", 1) for item in sway])
    rdot = np.array([item.s("rdot", 1) for item in yaw])
    Yv, Yv_std = share_of(vdot, np.array([item.s("Y", 1) for item in sway]))
    Nv, Nv_std = share_of(vdot, np.array([item.s("N", 1) for item in sway]))
    Yr, Yr_std = share_of(rdot, np.array([item.s("Y", 1) for item in yaw]))
    if not all(map(math.isfinite, (Yv, Nv, Yr))) or abs(Yv) < 0.3 * expected(campaign).my:
        return None
    point = (Yr - Nv) / Yv
    std = math.sqrt(Nv_std**2 + Yr_std**2 + (point * Yv_std) ** 2) / abs(Yv)
    return point, std, tuple(item.run.id for item in (*sway, *yaw))


def _lever(summaries: Sequence[Summary]) -> tuple[float, float, tuple[str, ...]] | None:
    """Slope of N on Y over the rudder angle at the speed with most runs [m]."""
    groups: dict[tuple[float, float | None], list[Summary]] = {}
    for item in summaries:
        settings = item.run.settings
        if (
            item.run.kind_of_test.upright
            and abs(settings.drift) < math.radians(0.3)
            and abs(settings.rudder) <= RUDDER_LIMIT
            and math.isfinite(item.mean("Y"))
            and math.isfinite(item.mean("N"))
        ):
            groups.setdefault((round(settings.speed, 3), settings.propeller_rps), []).append(item)
    group = max(groups.values(), key=len, default=[])
    if len({round(item.run.settings.rudder, 6) for item in group}) < 4:
        return None
    Y = np.array([item.mean("Y") for item in group])
    N = np.array([item.mean("N") for item in group])
    slope, std = share_of(Y - Y.mean(), N - N.mean())
    correlation = float(np.corrcoef(Y, N)[0, 1])
    if abs(correlation) < 0.95:
        return None
    return slope, std, tuple(item.run.id for item in group)


def _too_long(lever: tuple[float, float, tuple[str, ...]], stated: float, L: float) -> float | None:
    value, std, _ = lever
    beyond = -(value + stated) - STERN * L
    return beyond if beyond > max(SLACK * L, 2 * std) else None


CHECKS = (
    Check(
        "moment reference",
        "the point to which moments refer, by symmetry and by the rudder",
        examine_reference,
        by_particulars=True,
    ),
)
