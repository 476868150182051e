"""Measured manoeuvres with the simulated ones over them: turning circles, zigzags."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.campaigns.test_kinds.free_running import TURNING
from pmmkit.campaigns.test_kinds.registry import kind_of
from pmmkit.plotting.histories import zigzag
from pmmkit.plotting.turns import trajectory
from pmmkit.simulation.track import Track
from pmmkit.trials import Trial
from pmmkit.validation.free_running import Manoeuvre

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_FIRST: Final = "overshoot_1_deg"


def _measured(trial: Trial) -> Track:
    """A trial from its order on, in the shape of a simulated track."""
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


def overlays(manoeuvres: Sequence[Manoeuvre]) -> dict[str, Figure]:
    """Turning circles to both sides, and the zigzag that is simulated worst.

    Parameters
    ----------
    manoeuvres : sequence of Manoeuvre
        Of a comparison.

    Returns
    -------
    dict of str to Figure
        ``turning_circles`` and ``zigzag``, as far as there are such tests.
    """
    found: dict[str, Figure] = {}
    turns = _each_side([item for item in manoeuvres if item.run.kind_of_test is TURNING])
    if turns:
        found["turning_circles"] = trajectory(*_tracks(turns))
    weaves = [item for item in manoeuvres if kind_of(item.run.test).switches]
    if weaves:
        worst = max(weaves, key=_off)
        found[worst.run.test] = zigzag(*_tracks([worst]))
    return found


def _each_side(turns: Sequence[Manoeuvre]) -> list[Manoeuvre]:
    """The first turn to each side."""
    sides = {item.trial.rudder_deg > 0: item for item in reversed(turns)}
    return [sides[side] for side in (True, False) if side in sides]


def _off(item: Manoeuvre) -> float:
    """By how much the first overshoot is off [deg]."""
    error = item.track.metrics.get(_FIRST, math.nan) - item.trial.metrics.get(_FIRST, math.nan)
    return abs(error) if math.isfinite(error) else 0.0


def _tracks(items: Sequence[Manoeuvre]) -> tuple[list[Track], list[str]]:
    tracks: list[Track] = []
    names: list[str] = []
    for item in items:
        tracks += [_measured(item.trial), item.track]
        names += [f"{item.run.id}, measured", f"{item.run.id}, simulated"]
    return tracks, names
