"""A measured manoeuvre in the shape of a simulated one, so that both are drawn alike."""

from __future__ import annotations

import math

import numpy as np

from pmmkit.simulation.track import Track
from pmmkit.trials.table import Trial


def track_of(trial: Trial) -> Track:
    """A trial from its order on, as a track.

    Parameters
    ----------
    trial : Trial
        As it was evaluated.

    Returns
    -------
    Track
        Velocities are slopes of path and heading; heel, revolutions and Froude number are NaN.
    """
    after = trial.t >= 0.0
    t, x, y, psi = (part[after] for part in (trial.t, trial.x, trial.y, trial.psi))
    ahead, aside = np.gradient(x, t), np.gradient(y, t)
    unknown = np.full(len(t), math.nan)
    return Track(
        t=t,
        x=x,
        y=y,
        psi=psi,
        u=ahead * np.cos(psi) + aside * np.sin(psi),
        v=aside * np.cos(psi) - ahead * np.sin(psi),
        r=np.gradient(psi, t),
        p=unknown,
        phi=unknown,
        delta=trial.delta[after],
        n=unknown,
        name=trial.name,
        manoeuvre=trial.test,
        L=trial.L,
        speed=trial.speed,
        Fn=math.nan,
        rudder_deg=trial.rudder_deg,
        metrics=trial.metrics,
        orders=trial.orders,
    )
