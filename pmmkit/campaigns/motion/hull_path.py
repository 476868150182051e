"""Where the hull is at each sample of a captive run: recorded, from a file, or as it was set.

The place counts from where the hull lies at rest, in axes that move with the carriage.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.campaigns.motion.kinematics import displacement_phase
from pmmkit.campaigns.motion.nominal import require_settings
from pmmkit.campaigns.over_ground import over_ground
from pmmkit.campaigns.run import Kind, Run
from pmmkit.campaigns.settings import Settings
from pmmkit.errors import CampaignError, Problem
from pmmkit.numerics import Array, unwrapped

if TYPE_CHECKING:
    import xarray as xr

PLACE: Final = ("x", "y", "psi")


def hull_path(
    values: Mapping[str, Array], run: Run, needed: Sequence[str]
) -> tuple[dict[str, Array], str]:
    """Place and heading of the hull at the samples, from rest, and where they come from.

    Parameters
    ----------
    values : mapping of str to array
        Channels of the run in SI, our directions of axes and our signs.
    run : Run
        The run, for its test and settings.
    needed : sequence of str
        Which of ``x``, ``y``, ``psi`` must be known.

    Returns
    -------
    path : dict
        ``x``, ``y`` [m] and ``psi`` [rad], each (n,).
    whence : str
        Where they come from, in words.

    Raises
    ------
    CampaignError
        If the path is not known at all samples.
    """
    if run.kind != "history":
        if run.dynamic:
            raise _problem(
                run.id,
                "means or harmonics of an oscillating test in earth axes cannot be turned.",
                "Give the histories, or forces in ship axes.",
            )
        return _set_path(run, np.zeros(1)), "as the test was set"
    times = values["t"]
    recorded = {name: values[name] for name in PLACE if name in values}
    if "psi" in recorded:
        recorded["psi"] = unwrapped(recorded["psi"])
    if set(needed) <= set(recorded):
        return recorded, "as recorded"
    theta = _phase(run, values) if run.dynamic else np.zeros_like(times)
    path = {**_set_path(run, theta), **recorded}
    told = f", recorded {', '.join(recorded)}" if recorded else ""
    return path, f"as the test was set{told}"


def set_to(kind: Kind, test: str, settings: Settings, run_id: str) -> Run:
    """A run without data, for what it was set to."""

    def no_data() -> xr.Dataset:
        raise _problem(run_id, "the data of this run are only being read.", None)

    return Run(id=run_id, test=test, kind=kind, settings=settings, loader=no_data)


def _phase(run: Run, values: Mapping[str, Array]) -> Array:
    import xarray as xr

    moved = {name: ("t", values[name]) for name in (*PLACE, "u", "v", "r") if name in values}
    return displacement_phase(run, xr.Dataset(moved, coords={"t": values["t"]}), values["t"])


def _set_path(run: Run, theta: Array) -> dict[str, Array]:
    """The path that a test was set to, in axes that move with the carriage."""
    kind = run.kind_of_test
    place = kind.place(run.settings, theta)
    if place is None:
        raise _problem(
            run.id,
            f"a {run.test} test does not say where the hull is at each instant.",
            'Name a file of t, x, y, psi: motion = "…".',
        )
    require_settings(run)
    return {"x": place[0], "y": place[1], "psi": kind.in_tank(run.settings, theta).psi}


def recorded_in(
    motion: Mapping[str, Array], times: Array, run: Run, needed: Sequence[str]
) -> dict[str, Array]:
    """Motion of a file of its own at the samples of the forces, straight lines between its rows.

    Parameters
    ----------
    motion : mapping of str to array
        ``t`` and some of ``x, y, psi, u, v, r``, SI, our signs.
    times : array (n,)
        Of the samples [s].
    run : Run
        For its speed and its drift angle, where a path has to be integrated.
    needed : sequence of str
        Which of ``x``, ``y``, ``psi`` must be known.

    Returns
    -------
    dict
        The channels of the file, and what follows from its velocities, each (n,).

    Raises
    ------
    CampaignError
        If the file does not cover the samples, or lacks what is needed.
    """
    own = motion["t"]
    if np.any(np.diff(own) <= 0):
        raise _problem(run.id, "the times of the file named by motion do not rise.", None)
    slack = 1e-6 * float(own[-1] - own[0])
    if own[0] > times[0] + slack or own[-1] < times[-1] - slack:
        raise _problem(
            run.id,
            f"the file named by motion goes from t = {own[0]:.10g} to {own[-1]:.10g} s, the "
            f"forces from {times[0]:.10g} to {times[-1]:.10g} s.",
            "Give the motion of the whole time, or trim with ramp_s.",
        )
    path = dict(motion)
    if "psi" not in path and "r" in path:
        path["psi"] = run.settings.drift + _integral(own, path["r"])
    if "psi" not in path and "psi" in needed:
        raise _problem(run.id, "the file named by motion has neither psi nor r.", "Map one.")
    if "psi" in path:
        path["psi"] = unwrapped(path["psi"])
    if {"u", "v", "psi"} <= set(path) and not {"x", "y"} & set(path):
        along, across = over_ground(path["u"], path["v"], path["psi"])
        path["x"] = _integral(own, along - run.settings.speed)
        path["y"] = _integral(own, across)
    missing = [name for name in needed if name not in path]
    if missing:
        raise _problem(
            run.id,
            f"the file named by motion has no {' and no '.join(missing)}.",
            "Write x, y, psi, or u, v, r.",
        )
    return {name: np.interp(times, own, part) for name, part in path.items() if name != "t"}


def _integral(times: Array, rates: Array) -> Array:
    steps = 0.5 * (rates[1:] + rates[:-1]) * np.diff(times)
    return np.concatenate([np.zeros(1), np.cumsum(steps)])


def _problem(run: str, message: str, remedy: str | None) -> CampaignError:
    return CampaignError(Problem(message=message, run=run, remedy=remedy))
