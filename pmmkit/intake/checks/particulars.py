"""Particulars of ship, rudder and propeller that contradict one another."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from pmmkit.intake.checks.expected import round_factor
from pmmkit.intake.checks.finding import Check, CheckFinding, figure
from pmmkit.presentation import WIDE

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign
    from pmmkit.intake.checks.finding import Summary

BLOCK: Final = 0.0075
ROUNDED: Final = 0.015
"""What breadth and draught of few digits may be off by, at most: 0.46 m for the 0.455 m of a KVLCC2
of 7 m is 1.1 %. More is an error: 0.5 m is seldom known to 10 % alone."""
BLOCKS: Final = (0.1, 1.05)
"""Block coefficients of anything that floats, from a slender catamaran to a box."""
DENSITIES: Final = (900.0, 1100.0)
"""Of water, in kg/m³; computations without dimensions may have 1."""
MASS: Final = 0.05
HEIGHT: Final = 0.5
GYRATION: Final = (0.21, 0.28)
"""Radii of gyration of yaw over L: those of the library's and of published ships are 0.22 to 0.27.
An inertia that is wrong by 30 % is outside from 0.25 on."""
CENTRE: Final = 0.06
"""Centres of gravity lie so near to midship, over L; the library's -0.023 to 0.036."""
EFFICIENCY: Final = (0.3, 0.85)


def examine_ship(campaign: Campaign, _summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """Mass against volume, block coefficient against its parts, radius of gyration."""
    ship, rho = campaign.ship, campaign.water.rho
    ratio = ship.mass / (rho * ship.volume)
    if abs(ratio - 1) > MASS:
        near = round_factor(ratio, spread=1.1)
        yield CheckFinding(
            check="particulars",
            severity="error" if abs(math.log(ratio)) > math.log(1.5) else "warning",
            message=f"The mass {figure(ship.mass, 4)} kg is {figure(ratio)} times the displaced "
            f"{figure(rho * ship.volume, 4)} kg (rho times volume)"
            + (f", near {near}." if near else "; a floating hull has 1.")
            + _strange_density(rho),
            remedy="Check mass, volume and rho; give what hangs on the balance as balance_mass.",
            numbers={"ratio": ratio},
        )
    if not BLOCKS[0] <= ship.block <= BLOCKS[1]:
        near = round_factor(ship.block / 0.6, spread=2.0)
        yield CheckFinding(
            check="particulars",
            severity="error",
            message=f"volume/(L B d) is {figure(ship.block)}"
            + (f", near {near}" if near else "")
            + f"; hulls have 0.3 to 0.9. L/B is {figure(ship.L / ship.B)} (ships have 3 to 12), "
            f"B/d {figure(ship.B / ship.d)} (1.5 to 7).",
            remedy="Check L, B, d [m] and volume [m³].",
            numbers={"block": ship.block, "L_B": ship.L / ship.B, "B_d": ship.B / ship.d},
        )
    radius = math.sqrt(max(ship.Izz / ship.mass - ship.xG**2, 0.0)) / ship.L
    if abs(ratio - 1) <= MASS and not GYRATION[0] < radius < GYRATION[1]:
        yield CheckFinding(
            check="particulars",
            severity="warning",
            message=f"Izz gives a yaw radius of gyration of {figure(radius)} L; ships have 0.22 to "
            f"0.27 L.",
            remedy="Check Izz (kg m², about midship), mass and L.",
            numbers={"radius": radius},
        )
    if abs(ship.xG) > CENTRE * ship.L:
        aft = ship.xG - 0.5 * ship.L
        yield CheckFinding(
            check="particulars",
            severity="warning",
            message=f"xG is {figure(ship.xG)} m, {figure(ship.xG / ship.L)} L; hulls have -0.03 to "
            f"0.04 L."
            + (
                f" Taken from the after perpendicular it is {figure(aft)} m forward of midship."
                if abs(aft) <= CENTRE * ship.L
                else ""
            ),
            remedy="Give xG forward of midship [m].",
            numbers={"xG": ship.xG, "aft": aft},
        )
    for item in campaign.uncertainty:
        if item.assumed:
            yield CheckFinding(
                check="particulars",
                severity="warning",
                message=f"Nobody states {item.name}, which the forces of a balance hold: it is "
                f"taken as {figure(getattr(ship, item.name))} ± {figure(WIDE * item.std)} m "
                f"(95 %), and the derivatives' intervals with it.",
                remedy=f"State {item.name} under [ship] as the model was ballasted [m].",
                numbers={item.name: getattr(ship, item.name), "std": item.std},
            )
    if ship.GM is not None and not 0 < ship.GM < HEIGHT * ship.B:
        yield CheckFinding(
            check="particulars",
            severity="warning",
            message=f"GM is {figure(ship.GM)} m with a breadth of {figure(ship.B)} m; hulls have "
            f"up to about 0.3 B. It may be the height of the full-scale ship.",
            remedy="Give GM of the model as tested.",
            numbers={"GM": ship.GM, "B": ship.B},
        )
    stated = ship.block_stated
    if stated is not None and abs(ship.block / stated - 1) > BLOCK + _rounded(ship.B, ship.d):
        length = ship.volume / (stated * ship.B * ship.d)
        near = round_factor(ship.block / stated, spread=1.05)
        yield CheckFinding(
            check="particulars",
            severity="warning" if abs(ship.block / stated - 1) < 0.03 else "error",
            message=f"volume/(L B d) is {ship.block:.4f}, but the block coefficient is stated as "
            f"{stated:.4f}; with this volume, B and d it belongs to L = {length:.3f} m, stated are "
            f"{ship.L:.4f} m" + (f" (the ratio is near {near})." if near else "."),
            remedy="Check L, B, d and volume, and to which length the coefficient belongs.",
            numbers={"block": ship.block, "stated": stated, "length": length},
        )
    yield from _rudder_areas(campaign.rudder)


def _rounded(*lengths: float) -> float:
    """Share by which a product of lengths may be off, each by half of its last digit."""
    digits = (repr(float(x)).partition(".")[2] for x in lengths)
    halves = (0.5 * 10.0 ** -len(x) if x.isdecimal() else 0.0 for x in digits)
    return min(sum(half / x for half, x in zip(halves, lengths, strict=True)), ROUNDED)


def _strange_density(rho: float) -> str:
    if DENSITIES[0] <= rho <= DENSITIES[1]:
        return ""
    return f" rho is {figure(rho, 4)} kg/m³; water has about 1000."


def _rudder_areas(rudder: Mapping[str, Any]) -> Iterator[CheckFinding]:
    whole = next(
        (rudder[key] for key in ("area_lateral", "area_total", "area") if key in rudder), None
    )
    part = rudder.get("area_movable")
    if isinstance(whole, (int, float)) and isinstance(part, (int, float)) and part > whole:
        yield CheckFinding(
            check="particulars",
            severity="warning",
            message=f"The movable rudder area {figure(part)} m² is larger than the whole lateral "
            f"area {figure(whole)} m², of which it is a part: the two are exchanged.",
            remedy="Exchange the two areas.",
            numbers={"movable": float(part), "lateral": float(whole)},
        )


def examine_open_water(campaign: Campaign, _summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """The best efficiency J KT/(2π KQ) of the open-water table, which lies at 0.3 to 0.85."""
    table = campaign.open_water
    if table is None:
        if "open_water" in campaign.propeller:
            yield CheckFinding(
                check="open water",
                severity="warning",
                message="open_water of [propeller] cannot be read "
                f"({campaign.propeller['open_water']!r}): the propeller is estimated instead.",
                remedy="Name a CSV file beside the data with the columns J, KT and KQ, or state "
                "the three as lists of equal length.",
            )
        return
    J, KT, KQ = table
    good = (KT > 0) & (KQ > 0) & (J > 0)
    if not good.any():
        return
    efficiency = J[good] * KT[good] / (2 * math.pi * KQ[good])
    best = float(efficiency.max())
    if EFFICIENCY[0] <= best <= EFFICIENCY[1]:
        return
    power = next(
        (
            factor
            for factor in (10.0, 100.0, 1000.0, 0.1, 0.01)
            if EFFICIENCY[0] <= best * factor <= EFFICIENCY[1]
        ),
        None,
    )
    found = (
        f" With KQ divided by {power:g} it is {best * power:.3f}: the table holds "
        f"{power:g} KQ (or KT and KQ differ by that factor)."
        if power
        else ""
    )
    yield CheckFinding(
        check="open water",
        severity="error",
        message=f"The best efficiency J KT/(2π KQ) of the open-water table is {figure(best)}, at "
        f"J = {figure(float(J[good][np.argmax(efficiency)]))}; propellers reach 0.3 to 0.85."
        f"{found}",
        remedy=f"Divide KQ by {power:g} (KQ_factor = {1 / power:g} under [propeller])."
        if power
        else "Check the columns of the table.",
        numbers={"efficiency": best, "factor": power or math.nan},
    )


CHECKS = (
    Check(
        "particulars", "mass, volume, block coefficient, gyration and rudder areas", examine_ship
    ),
    Check("open water", "the efficiency that the open-water table implies", examine_open_water),
)
