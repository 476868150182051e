"""What a workshop asks of a captive run: means of static ones, one cycle of oscillating ones."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from pmmkit.base import CampaignError, DataError, Problem
from pmmkit.campaigns import Attitude, Campaign, Rig, Run
from pmmkit.numerics import Array
from pmmkit.reduction import PreparedRun, one_cycle
from pmmkit.signals import design_matrix

MOTION: Final = {name: name for name in ("u", "v", "r", "udot", "vdot", "rdot")}
HELD: Final = {"phi": "phi", "delta": "delta", "n": "rps"}
"""Channels that a test holds, and their names in `State`."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SimmanResult:
    """The means of a static run, or the Fourier coefficients of an oscillating one.

    `run`: the run, with the period that its record has. `labels`: ``C0``, or ``C0, C1, S1, C2
    …`` with the displacement ∝ sin θ. `force (m,)`: force of the water at midship, without the
    inertia of the model [N, N m]; NaN where the source gives no such coefficient. `std (m,)`:
    their standard uncertainties from the noise of the record, where they are known. `motion
    (m,)`: velocities and accelerations of midship, heel, rudder, revolutions, SI and radians.
    `extras`: means of further channels: thrust, sinkage …. `samples`: samples that count; 0
    where the source is a table. `cycles`: whole cycles that count. `begin, end`: times of the
    first and the last sample that counts [s]; NaN without a record.
    """

    run: Run
    labels: tuple[str, ...]
    force: Mapping[str, Array]
    std: Mapping[str, Array]
    motion: Mapping[str, Array]
    extras: Mapping[str, float]
    samples: int
    cycles: int | None
    begin: float
    end: float

    @property
    def recorded(self) -> bool:
        """Whether there is a record, and not a row of a table alone."""
        return self.samples > 0


def results_of(campaign: Campaign) -> list[SimmanResult]:
    """The results of all captive runs, as `reduce` takes them."""
    rig = campaign.rig
    found: list[SimmanResult] = []
    problems: list[Problem] = []
    for run in campaign.runs:
        try:
            found.append(_result(PreparedRun.of(run, campaign), rig))
        except DataError as error:
            problems += [replace(item, run=item.run or run.id) for item in error.problems]
    if problems:
        raise CampaignError(problems, title=f"{campaign.title!r} has no results to hand in")
    return found


def _result(prepared: PreparedRun, rig: Rig) -> SimmanResult:
    result = prepared.result
    motion = prepared.motion_at_midship(rig)
    recorded = result.run.kind == "history"
    return SimmanResult(
        run=result.run,
        labels=result.labels,
        force=_handed_in(prepared, rig),
        std={
            name: np.sqrt(np.diag(matrix))
            for name, matrix in result.covariance.items()
            if matrix is not None
        },
        motion={
            name: prepared.projection @ getattr(motion, attribute)
            for name, attribute in {**MOTION, **HELD}.items()
        },
        extras=result.extras,
        samples=result.samples if recorded else 0,
        cycles=result.cycles,
        begin=float(prepared.t[0]) if recorded else np.nan,
        end=float(prepared.t[-1]) if recorded else np.nan,
    )


def _handed_in(prepared: PreparedRun, rig: Rig) -> dict[str, Array]:
    """Harmonics of the force of the water; what a record was not fitted to is zero in it."""
    order = prepared.result.smoothed
    force = prepared.water_force(rig)
    if order is None:
        return force
    return {name: np.where(np.arange(len(x)) > 2 * order, 0.0, x) for name, x in force.items()}


def cycle_of(result: SimmanResult) -> dict[str, Array]:
    """One cycle from its Fourier coefficients, at equal steps from the displacement's
    upcrossing."""
    order = int(result.labels[-1][1:])
    theta = one_cycle()
    basis = design_matrix(theta, order)
    omega = result.run.settings.omega or 1.0
    t = theta / omega
    known = {name: x for name, x in result.force.items() if np.isfinite(x).all()}
    moved = {name: basis @ x for name, x in result.motion.items()}
    psi = result.run.settings.drift + _integral(moved["r"], omega)
    u, v = moved["u"], moved["v"]
    ahead, aside = Attitude(psi=psi).over_ground(u, v)
    x = ahead.mean() * t + _integral(ahead, omega)
    y = aside.mean() * t + _integral(aside, omega)
    forces = {name: basis @ x for name, x in known.items()}
    return {"t": t, **forces, "x": x - x[0], "y": y, "psi": psi, **moved}


def _integral(values: Array, omega: float) -> Array:
    """Integral over time of what a cycle holds beside its mean, itself with a mean of zero."""
    size = len(values)
    spectrum = np.fft.rfft(values)
    orders = np.arange(len(spectrum))
    spectrum[0] = 0.0
    spectrum[1:] /= 1j * omega * orders[1:]
    return np.asarray(np.fft.irfft(spectrum, size), np.float64)
