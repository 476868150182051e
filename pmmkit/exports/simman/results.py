"""What a workshop asks of a captive run: means of static ones, one cycle of oscillating ones."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from pmmkit.campaigns.motion.inertia import Rig, rig_of
from pmmkit.campaigns.over_ground import over_ground
from pmmkit.campaigns.run import Campaign, Run
from pmmkit.effects.state import State
from pmmkit.errors import CampaignError, DataError, Problem
from pmmkit.numerics import Array
from pmmkit.observations.prepare import Prepared, one_cycle, prepare
from pmmkit.signals import design_matrix

MOTION: Final = {name: name for name in ("u", "v", "r", "udot", "vdot", "rdot")}
HELD: Final = {"phi": "phi", "delta": "delta", "n": "rps"}
"""Channels that a test holds, and their names in `State`."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Result:
    """The means of a static run, or the Fourier coefficients of an oscillating one.

    Parameters
    ----------
    run : Run
        The run, with the period that its record has.
    labels : tuple of str (m,)
        ``C0``, or ``C0, C1, S1, C2 …`` with the displacement ∝ sin θ.
    force : mapping of channel to array (m,)
        Force of the water at midship, without the inertia of the model [N, N m]; NaN where the
        source gives no such coefficient.
    std : mapping of channel to array (m,)
        Their standard uncertainties from the noise of the record, where they are known.
    motion : mapping of channel to array (m,)
        Velocities and accelerations of midship, heel, rudder, revolutions, SI and radians.
    extras : mapping of channel to float
        Means of further channels: thrust, sinkage …
    samples : int
        Samples that count; 0 where the source is a table.
    cycles : int or None
        Whole cycles that count.
    begin, end : float
        Times of the first and the last sample that counts [s]; NaN without a record.
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


def results_of(campaign: Campaign) -> list[Result]:
    """The results of all captive runs, as `reduce` takes them.

    Parameters
    ----------
    campaign : Campaign
        Of captive tests.

    Raises
    ------
    CampaignError
        If runs cannot be read or are too short: all are listed.
    """
    rig = rig_of(campaign)
    found: list[Result] = []
    problems: list[Problem] = []
    for run in campaign.runs:
        try:
            found.append(_result(prepare(run, campaign), rig))
        except DataError as error:
            problems += [replace(item, run=item.run or run.id) for item in error.problems]
    if problems:
        raise CampaignError(problems, title=f"{campaign.title!r} has no results to hand in")
    return found


def _result(prepared: Prepared, rig: Rig) -> Result:
    result = prepared.result
    motion = prepared.motion_at_midship(rig)
    recorded = result.run.kind == "history"
    return Result(
        run=result.run,
        labels=result.labels,
        force=_handed_in(prepared, rig),
        std={
            name: np.sqrt(np.diag(matrix))
            for name, matrix in result.covariance.items()
            if matrix is not None
        },
        motion=_moved(motion, prepared.projection),
        extras=result.extras,
        samples=result.samples if recorded else 0,
        cycles=result.cycles,
        begin=float(prepared.t[0]) if recorded else np.nan,
        end=float(prepared.t[-1]) if recorded else np.nan,
    )


def _handed_in(prepared: Prepared, rig: Rig) -> dict[str, Array]:
    """Harmonics of the force of the water; what a record was not fitted to is zero in it."""
    order = prepared.result.smoothed
    force = prepared.water_force(rig)
    if order is None:
        return force
    return {name: np.where(np.arange(len(x)) > 2 * order, 0.0, x) for name, x in force.items()}


def _moved(motion: State, projection: Array) -> dict[str, Array]:
    return {
        name: projection @ getattr(motion, attribute)
        for name, attribute in {**MOTION, **HELD}.items()
    }


def cycle_of(result: Result) -> dict[str, Array]:
    """One cycle from its Fourier coefficients, at equal steps from the displacement's upcrossing.

    Parameters
    ----------
    result : Result
        Of an oscillating run.

    Returns
    -------
    dict of channel to array (n,)
        ``t`` [s]; the forces all of whose coefficients are known [N, N m]; ``x``, ``y`` [m] and
        ``psi`` [rad] of midship in the tank, integrated from the velocities: x from 0 on, y about
        a mean of 0, psi about the drift angle; velocities and accelerations.
    """
    order = int(result.labels[-1][1:])
    theta = one_cycle()
    basis = design_matrix(theta, order)
    omega = result.run.settings.omega or 1.0
    t = theta / omega
    known = {name: x for name, x in result.force.items() if np.isfinite(x).all()}
    moved = {name: basis @ x for name, x in result.motion.items()}
    psi = result.run.settings.drift + _integral(moved["r"], omega)
    u, v = moved["u"], moved["v"]
    ahead, aside = over_ground(u, v, psi)
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
