"""Where the hull is at each sample of a captive run: recorded, from a file, or as it was set.

The place counts from where the hull lies at rest, in axes that move with the carriage.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.base import CampaignError
from pmmkit.campaigns.motion.kinematics import displacement_phase
from pmmkit.campaigns.stated_run import StatedRun
from pmmkit.numerics import Array, unwrapped

if TYPE_CHECKING:
    pass


@dataclass(frozen=True, kw_only=True)
class Attitude:
    """How a ship lies over ground, for turning velocities between her axes and those of the ground.

    Parameters
    ----------
    psi : array (n,)
        Heading [rad].
    phi : array (n,), optional
        Heel [rad], by which the sway leans out of the horizontal plane.

    Examples
    --------
    >>> east = Attitude(psi=np.array([np.pi / 2]))
    >>> [x.round(9).tolist() for x in east.over_ground(np.array([2.0]), np.array([-1.0]))]
    [[1.0], [2.0]]
    >>> [x.round(9).tolist() for x in east.in_ship_axes(np.array([1.0]), np.array([2.0]))]
    [[2.0], [-1.0]]
    """

    psi: Array
    phi: Array | float = 0.0

    def over_ground(self, u: Array, v: Array) -> tuple[Array, Array]:
        """Velocities along x (north) and y (east) from surge and sway velocity [m/s]."""
        ahead, aside = np.cos(self.psi), np.sin(self.psi)
        level = v * np.cos(self.phi)
        return u * ahead - level * aside, u * aside + level * ahead

    def in_ship_axes(self, north: Array, east: Array) -> tuple[Array, Array]:
        """Surge and sway velocity from those along x (north) and y (east) [m/s]."""
        ahead, aside = np.cos(self.psi), np.sin(self.psi)
        return north * ahead + east * aside, (east * ahead - north * aside) / np.cos(self.phi)


PLACE: Final = ("x", "y", "psi")


def hull_path(
    values: Mapping[str, Array], run: StatedRun, needed: Sequence[str]
) -> tuple[dict[str, Array], str]:
    """Place and heading of the hull at the samples, from rest, and where they come from."""
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


def _phase(run: StatedRun, values: Mapping[str, Array]) -> Array:
    import xarray as xr

    moved = {name: ("t", values[name]) for name in (*PLACE, "u", "v", "r") if name in values}
    return displacement_phase(run, xr.Dataset(moved, coords={"t": values["t"]}), values["t"])


def _set_path(run: StatedRun, theta: Array) -> dict[str, Array]:
    """The path that a test was set to, in axes that move with the carriage."""
    kind = run.kind_of_test
    place = kind.place(run.settings, theta)
    if place is None:
        raise _problem(
            run.id,
            f"a {run.test} test does not say where the hull is at each instant.",
            'Name a file of t, x, y, psi: motion = "…".',
        )
    run.require_settings()
    return {"x": place[0], "y": place[1], "psi": kind.in_tank(run.settings, theta).psi}


def recorded_in(
    motion: Mapping[str, Array], times: Array, run: StatedRun, needed: Sequence[str]
) -> dict[str, Array]:
    """Motion of a file of its own at the samples of the forces, straight lines between its rows.

    times [s].
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
        along, across = Attitude(psi=path["psi"]).over_ground(path["u"], path["v"])
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
    return CampaignError(message, run=run, remedy=remedy)
