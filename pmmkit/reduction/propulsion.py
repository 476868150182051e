"""Resistance and propulsion tests: what they give beside the derivatives."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from pmmkit.campaigns import Campaign, Run
from pmmkit.inference import COVERAGE
from pmmkit.numerics import Array
from pmmkit.reduction.observations.equations import Rows
from pmmkit.reduction.observations.prepare import RunResult
from pmmkit.reduction.solve import Solution

# Whether the thrust of a propeller that turned can be told from the resistance.


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


@dataclass(frozen=True, kw_only=True, eq=False)
class Resistance:
    """Resistance straight ahead without propeller.

    `speed, force`: speed [m/s] and resistance [N], ascending speed. `coefficients (3,)`: of R =
    c1 U + c2 U² + c3 U³ fitted to them; fewer points leave the last ones zero.
    """

    speed: Array
    force: Array
    coefficients: Array

    def at(self, speed: Array) -> Array:
        """Resistance at a speed [N]; only within the range tested."""
        inside = (speed >= 0.99 * self.speed[0]) & (speed <= 1.01 * self.speed[-1])
        powers = np.stack([speed, speed**2, speed**3], axis=-1)
        return np.where(inside, powers @ self.coefficients, np.nan)


@dataclass(frozen=True, kw_only=True)
class Propulsion:
    """Self-propulsion factors from straight runs with the propeller turning.

    `thrust_deduction, std`: t in X = (1 - t) T - R, and its standard uncertainty from the
    scatter. `wake`: effective wake fraction by speed [m/s], thrust identity; empty without
    open-water curve. `runs`: the runs it rests on.
    """

    thrust_deduction: float
    std: float
    wake: Mapping[float, float]
    runs: tuple[str, ...]


def resistance(results: Iterable[RunResult]) -> Resistance | None:
    """Resistance curve from resistance tests (and straight tows without propeller)."""
    points = sorted(
        (item.run.settings.speed, -float(item.measured["X"][0]))
        for item in results
        if item.run.kind_of_test.measures_resistance and "X" in item.measured
    )
    if not points:
        return None
    speed, force = np.array(points).T
    order = {1: [1], 2: [1, 2]}.get(len(np.unique(speed)), [0, 1, 2])
    design = np.stack([speed, speed**2, speed**3], axis=1)[:, order]
    coefficients = np.zeros(3)
    coefficients[order] = np.linalg.lstsq(design, force, rcond=None)[0]
    return Resistance(speed=speed, force=force, coefficients=coefficients)


def propulsion(
    results: Iterable[RunResult], campaign: Campaign, curve: Resistance | None
) -> Propulsion | None:
    """Thrust deduction and wake from straight runs with measured thrust."""
    if curve is None:
        return None
    straight = [
        item
        for item in results
        if "T" in item.extras
        and "X" in item.measured
        and straight_ahead(item.run)
        and not item.run.settings.rudder
        and item.run.settings.propeller_rps
        and np.isfinite(curve.at(np.array([item.run.settings.speed]))[0])
    ]
    if not straight:
        return None
    thrust = np.array([item.extras["T"] for item in straight])
    speed = np.array([item.run.settings.speed for item in straight])
    surplus = np.array([float(item.measured["X"][0]) for item in straight]) + curve.at(speed)
    share = float(thrust @ surplus / (thrust @ thrust))
    spread = surplus - share * thrust
    freedom = len(straight) - 1
    std = float(np.sqrt(spread @ spread / freedom / (thrust @ thrust))) if freedom else np.nan
    return Propulsion(
        thrust_deduction=1 - share,
        std=std,
        wake=_wake(straight, campaign),
        runs=tuple(item.run.id for item in straight),
    )


def straight_ahead(run: Run) -> bool:
    """Whether a run is towed straight: no drift, no heel, no turning, no oscillation."""
    here = run.settings
    return run.kind_of_test.straight and not here.drift and not here.heel


def _wake(straight: Sequence[RunResult], campaign: Campaign) -> dict[float, float]:
    """Effective wake by thrust identity, by speed."""
    diameter = campaign.propeller.get("D")
    curve = campaign.open_water
    if not diameter or curve is None:
        return {}
    advance, coefficient, _ = curve
    order = np.argsort(coefficient)
    found: dict[float, list[float]] = {}
    for item in straight:
        rps = item.run.settings.propeller_rps or 0.0
        loading = item.extras["T"] / (campaign.water.rho * rps**2 * diameter**4)
        if coefficient.min() <= loading <= coefficient.max():
            J = float(np.interp(loading, coefficient[order], advance[order]))
            speed = item.run.settings.speed
            found.setdefault(speed, []).append(1 - J * rps * diameter / speed)
    return {speed: float(np.mean(values)) for speed, values in sorted(found.items())}
