"""Where the hull is at each sample of a captive run: recorded, from a file, or as it was set.

The place counts from where the hull lies at rest, in axes that move with the carriage.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import ArrayLike

from pmmkit.base import CampaignError
from pmmkit.campaigns.motion.kinematics import displacement_phase
from pmmkit.campaigns.motion.nominal import require_settings
from pmmkit.campaigns.run import Kind, Run
from pmmkit.campaigns.settings import Settings
from pmmkit.numerics import Array, unwrapped
from pmmkit.signals import local

if TYPE_CHECKING:
    import xarray as xr


# Velocities over ground and in ship axes, and the true wind, of a free-running record.


SMOOTHED: Final = 0.15
"""Half of the window of local fits in ship lengths over the approach speed, at least 3 samples."""


def half_window(t: Array, L: float, speed: float) -> float:
    """Half of the window in which places and headings of a record are smoothed [s].

    Parameters
    ----------
    t : array (n,)
        Increasing times [s].
    L, speed : float
        Ship length [m] and speed of the approach [m/s].

    Examples
    --------
    >>> half_window(np.arange(60.0), 320.0, 8.0), half_window(np.arange(60.0), 7.0, 1.2)
    (6.0, 3.0)
    """
    return max(SMOOTHED * L / speed, 3.0 * float(np.median(np.diff(t))))


def velocity(t: Array, x: Array, y: Array, at: ArrayLike, half: float) -> tuple[Any, Any]:
    """Velocity along x and y at an instant or at several, from the positions about it.

    Parameters
    ----------
    t, x, y : array (n,)
        Increasing times [s] and positions [m].
    at : float or array (m,)
        The instants [s].
    half : float
        Half of the window in which places are smoothed [s]; slopes take one twice as wide.

    Returns
    -------
    float or array (m,), float or array (m,)
        [m/s]

    Examples
    --------
    >>> t = np.arange(0.0, 60.0)
    >>> ahead, aside = velocity(t, 5.0 * t, 0.01 * t**2, [10.0, 30.0], 3.0)
    >>> ahead.round(6).tolist(), aside.round(6).tolist()
    ([5.0, 5.0], [0.2, 0.6])
    """
    window = 2.0 * half
    return local(t, x, at, window).slope, local(t, y, at, window).slope


def over_ground(u: Array, v: Array, psi: Array, phi: Array | float = 0.0) -> tuple[Array, Array]:
    """Velocities of a ship along x (north) and y (east) from those in her axes.

    Parameters
    ----------
    u, v : array (n,)
        Surge and sway velocity [m/s]; those through the water give the way through the water.
    psi : array (n,)
        Heading [rad].
    phi : array (n,), optional
        Heel [rad], by which the sway leans out of the horizontal plane.

    Examples
    --------
    >>> north, east = over_ground(np.array([2.0]), np.array([-1.0]), np.array([np.pi / 2]))
    >>> north.round(9).tolist(), east.round(9).tolist()
    ([1.0], [2.0])
    """
    ahead, aside = np.cos(psi), np.sin(psi)
    level = v * np.cos(phi)
    return u * ahead - level * aside, u * aside + level * ahead


def in_ship_axes(
    north: Array, east: Array, psi: Array, phi: Array | float = 0.0
) -> tuple[Array, Array]:
    """Surge and sway velocity of a ship from those along x (north) and y (east).

    Parameters
    ----------
    north, east : array (n,)
        [m/s]
    psi, phi
        As for `over_ground`, of which this is the inverse.

    Examples
    --------
    >>> u, v = in_ship_axes(np.array([1.0]), np.array([2.0]), np.array([np.pi / 2]))
    >>> u.round(9).tolist(), v.round(9).tolist()
    ([2.0], [-1.0])
    """
    ahead, aside = np.cos(psi), np.sin(psi)
    return north * ahead + east * aside, (east * ahead - north * aside) / np.cos(phi)


def true_wind(
    psi: Array, speed: Array, direction: Array, north: Array, east: Array
) -> tuple[Array, Array]:
    """True wind over ground from that which a ship feels.

    Parameters
    ----------
    psi : array (n,)
        Heading [rad].
    speed, direction : array (n,)
        Of the relative wind [m/s] and where it comes from, from the bow to starboard [rad].
    north, east : array (n,)
        Velocity of the ship over ground [m/s]. That through the water makes a wind that is off by
        the current.

    Returns
    -------
    array (n,), array (n,)
        Speed [m/s] and where it comes from, from north, without jumps of 2π [rad]; NaN where
        something is not known.

    Examples
    --------
    A ship at 4 m/s to the east in a calm feels her own way from ahead:

    >>> still, four = np.zeros(1), np.array([4.0])
    >>> true_wind(np.array([np.pi / 2]), four, still, still, four)[0].round(9)
    array([0.])
    >>> blows, comes_from = true_wind(still, np.array([10.0]), still, four, still)
    >>> blows.tolist(), comes_from.tolist()
    ([6.0], [0.0])
    """
    way = direction + psi
    along, across = speed * np.cos(way) - north, speed * np.sin(way) - east
    return np.hypot(along, across), unwrapped(np.arctan2(across, along))


PLACE: Final = ("x", "y", "psi")


def hull_path(
    values: Mapping[str, Array], run: Run, needed: Sequence[str]
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
    return CampaignError(message, run=run, remedy=remedy)
