"""Runs as the diagnosis looks at them: harmonics of forces, and how to project a history."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pmmkit.effects.state import State
from pmmkit.errors import DataError
from pmmkit.reduction.inertia import Rig, rig_of
from pmmkit.reduction.prepare import Prepared, prepare
from pmmkit.runs.run import Campaign, Run

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class View:
    """One piece of a run: a steady mean, the cycles that count, or an early cycle.

    Parameters
    ----------
    run : Run
        The run it comes from.
    early : bool
        Whether this is the earliest cycle that is used of an oscillating run.
    projection : array (m, n)
        From n samples to the mean (m = 1) or the harmonics C0, C1, S1 …
    motion : State
        Motion of midship at the samples.
    t : array (n,)
        Time since the record began [s].
    force : mapping of channel to array (m,)
        Force of the water at midship [N, N m].
    covariance : mapping of channel to array (m, m)
        Of its noise.
    heading : array (n,)
        Heading of the model in the tank [rad].
    """

    run: Run
    early: bool
    projection: Array
    motion: State
    t: Array
    force: Mapping[str, Array]
    covariance: Mapping[str, Array]
    heading: Array

    @property
    def speed(self) -> float:
        """Carriage speed [m/s]."""
        return self.run.settings.speed

    @property
    def omega(self) -> float:
        """Angular frequency of the oscillation [rad/s]; 0 for a static run."""
        return (self.run.settings.omega or 0.0) if self.run.dynamic else 0.0

    @property
    def rows(self) -> int:
        """Number of harmonics."""
        return len(self.projection)

    def project(self, history: Array) -> Array:
        """Mean or harmonics of a history (n,) or (n, q)."""
        found: Array = self.projection @ history
        return found


def views_of(campaign: Campaign) -> tuple[View, ...]:
    """All runs of a captive campaign, oscillating ones in two pieces.

    Parameters
    ----------
    campaign : Campaign
        Captive tests.

    Returns
    -------
    tuple of View
        The first cycle is left out; of four cycles or more the second is a piece of its own: it
        shows what dies away. Noise is pooled over runs of one speed and kind, channel by channel.

    Raises
    ------
    DataError
        If the campaign is not captive.
    """
    if campaign.kind != "captive":
        raise DataError("Forces are diagnosed in captive tests; this campaign is free-running.")
    rig = rig_of(campaign)
    found: list[View] = []
    for run in campaign.runs:
        found += _pieces(run, campaign, rig)
    return tuple(_pooled(found))


def _pieces(run: Run, campaign: Campaign, rig: Rig) -> list[View]:
    """The run as a reduction takes it; a long record in two pieces, its second cycle and the rest.

    Noise is that of all cycles but the first together; that of a piece goes with the inverse of
    its cycles.
    """
    if run.kind != "history" or not run.dynamic:
        return [_view(prepare(run, campaign), rig)]
    data = run.data
    run = run.with_(loader=lambda: data)
    times = np.asarray(data["t"].values, float)
    omega = run.settings.omega or 1.0
    covered = (times[-1] - times[0]) * omega / (2 * math.pi)
    for count in (int(covered + 0.5), int(covered + 0.5) - 1):
        if count < 4:
            return [_view(prepare(run, campaign), rig)]
        try:
            return _cycles(run, campaign, rig, count)
        except DataError:
            continue
    return [_view(prepare(run, campaign), rig)]


def _cycles(run: Run, campaign: Campaign, rig: Rig, count: int) -> list[View]:
    whole = _view(prepare(run, campaign, cycles=(2, count)), rig)
    found = []
    for first, last, early in ((2, 2, True), (3, count, False)):
        piece = _view(prepare(whole.run, campaign, cycles=(first, last)), rig)
        wider = (count - 1.0) / (last - first + 1.0)
        noise = {name: wider * x for name, x in whole.covariance.items()}
        found.append(replace(piece, covariance=noise, early=early))
    return found


def _view(prepared: Prepared, rig: Rig) -> View:
    result = prepared.result
    motion = prepared.motion_at_midship(rig)
    force = {
        name: values for name, values in prepared.water_force(rig).items()
        if np.isfinite(values).all()
    }  # fmt: skip
    covariance = {name: item for name in force if (item := result.covariance.get(name)) is not None}
    return View(
        run=result.run, early=False, projection=prepared.projection, motion=motion,
        t=prepared.t - prepared.begin, force={name: force[name] for name in covariance},
        covariance=covariance, heading=_heading(result.run, motion),
    )  # fmt: skip


def _heading(run: Run, motion: State) -> Array:
    """Heading in the tank: drift, and the integral of a harmonic yaw rate."""
    omega = run.settings.omega if run.dynamic else None
    turned = -motion.rdot / omega**2 if omega else np.zeros_like(motion.u)
    return run.settings.drift + turned


def _pooled(views: Sequence[View]) -> list[View]:
    """Covariances averaged over pieces of one speed, frequency and kind."""
    kin: dict[tuple[object, ...], list[int]] = {}
    for place, view in enumerate(views):
        key = (
            round(math.log(view.speed), 2), round(view.omega / view.speed, 1), view.rows, view.early
        )  # fmt: skip
        kin.setdefault(key, []).append(place)
    made = list(views)
    for members in kin.values():
        channels = {name for place in members for name in views[place].covariance}
        mean = {
            name: np.mean(
                [views[p].covariance[name] for p in members if name in views[p].covariance], axis=0
            )
            for name in channels
        }
        for place in members:
            own = views[place]
            made[place] = replace(own, covariance={name: mean[name] for name in own.covariance})
    return made
