"""Forces of a CFD in earth axes, about a centre that stays behind, seen from the hull.

A solver that moves the mesh states forces along axes that stay where they were, and its moments
about a point that does so too unless it is told to move it. With ψ the heading and (x, y) the
place of the hull, both from rest::

    X = Fx cos ψ + Fy sin ψ        Y = -Fx sin ψ + Fy cos ψ
    N = Mz - (rx Fy - ry Fx)       r from the centre to the ship's moment reference
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.errors import CampaignError, Problem
from pmmkit.runs.kinematics import displacement_phase
from pmmkit.runs.nominal import YAW_TESTS, require_settings, tank_motion
from pmmkit.runs.readers.base import Array
from pmmkit.runs.run import Kind, Run, Settings

if TYPE_CHECKING:
    import xarray as xr

PLACE: Final = ("x", "y", "psi")
_PAIRS: Final = (("X", "Y"), ("FX_rudder", "FY_rudder"))
_ORDERS: Final = range(1, 64, 2)
_GRID: Final = 512


@dataclass(frozen=True, kw_only=True)
class Solver:
    """What ``[cfd]`` says of the forces of a computation, besides factors.

    Parameters
    ----------
    earth_axes : bool
        Whether forces and moments are stated along earth axes.
    centre_moves : bool
        Whether the point that moments refer to moves with the hull.
    centre_x, motion_x : float
        Where that point (at rest), and the point whose path is stated, lie forward of midship [m].
    ramp : float
        Duration from the first sample that belongs to the start-up of the computation [s].
    stated : frozenset of str
        Keys that ``[cfd]`` has.
    """

    earth_axes: bool = False
    centre_moves: bool = True
    centre_x: float = 0.0
    motion_x: float = 0.0
    ramp: float = 0.0
    stated: frozenset[str] = frozenset()

    @property
    def turns(self) -> bool:
        """Whether anything depends on where the hull is."""
        return self.earth_axes or not self.centre_moves


def without_ramp(
    values: Mapping[str, Array], ramp: float, *, file: str, run: str
) -> tuple[dict[str, Array], list[str]]:
    """A history without the start-up of the computation.

    Raises
    ------
    CampaignError
        If nothing is left.
    """
    if not ramp:
        return dict(values), []
    times = values["t"]
    kept = times >= times[0] + ramp
    if not kept.any():
        raise CampaignError(
            Problem(
                message=f"ramp_s = {ramp:g} s leaves no samples; they are from t = {times[0]:g} to "
                f"{times[-1]:g} s.",
                file=file,
                run=run,
                remedy="Correct ramp_s under [cfd].",
            )
        )
    note = f"first {ramp:g} s left out (ramp_s): {int(np.sum(~kept))} of {len(times)} samples"
    return {name: numbers[kept] for name, numbers in values.items()}, [note]


def seen_from_hull(
    values: Mapping[str, Array],
    solver: Solver,
    *,
    kind: Kind,
    test: str,
    settings: Settings,
    run: str,
    motion: Mapping[str, Array] | None = None,
) -> tuple[dict[str, Array], list[str]]:
    """Forces and moments in ship axes, about the ship's own moment reference.

    Parameters
    ----------
    values : mapping of str to array
        Channels in SI, our directions of axes and our signs.
    solver : Solver
        What the forces refer to.
    kind : {"history", "means", "harmonics"}
        What the values are.
    test, settings, run
        Kind of test, what it was set to, its id.
    motion : mapping of str to array, optional
        Path from a file of its own: ``t`` and ``x, y, psi`` or ``u, v, r``, as `values`. It counts
        before recorded channels, these before the motion that the test was set to.

    Returns
    -------
    turned : dict
        The same channels; K is left out where the heading changes it.
    notes : list of str
        What was done.

    Raises
    ------
    CampaignError
        If the path is not known, or a force is there without the one that it turns into.

    Examples
    --------
    >>> side = {"X": np.array([0.0]), "Y": np.array([10.0]), "N": np.array([0.0])}
    >>> turned, _ = seen_from_hull(side, Solver(earth_axes=True), kind="means",
    ...     test="static_drift", settings=Settings(speed=1.0, drift=math.pi / 6), run="SD")
    >>> turned["X"].round(3), turned["Y"].round(3)
    (array([5.]), array([8.66]))
    """
    if not solver.turns:
        return dict(values), []
    bare = Run(id=run, test=test, kind=kind, settings=settings, loader=_no_data)
    _check_pairs(values, solver, run)
    path, whence = _path(values, bare, motion, needed=("psi",) if solver.centre_moves else PLACE)
    cosine, sine = np.cos(path["psi"]), np.sin(path["psi"])
    out = dict(values)
    notes = [f"heading{' and place' if not solver.centre_moves else ''} of the hull: {whence}"]
    if solver.earth_axes:
        for ahead, aside in _PAIRS:
            if ahead in values:
                along, across = values[ahead], values[aside]
                out[ahead] = along * cosine + across * sine
                out[aside] = -along * sine + across * cosine
        notes.append("forces turned from earth axes to ship axes by the heading")
    if not solver.centre_moves and "N" in values:
        arm = solver.centre_x - solver.motion_x
        rx, ry = path["x"] + arm * cosine - arm, path["y"] + arm * sine
        ahead_of, beside = rx * cosine + ry * sine, -rx * sine + ry * cosine
        out["N"] = values["N"] - (ahead_of * out["Y"] - beside * out["X"])
        notes.append(
            "N moved from the centre that stays behind to the hull, which is up to "
            f"{float(np.hypot(rx, ry).max()):.4g} m away"
        )
    if "K" in out and (not solver.centre_moves or float(np.abs(sine).max()) > 0):
        del out["K"]
        notes.append("K left out: it turns into the pitching moment, which is not read")
    return out, notes


def _check_pairs(values: Mapping[str, Array], solver: Solver, run: str) -> None:
    """Refuse a force without the one that it turns into, and N without the forces that move it."""
    lacking = {
        other
        for pair in _PAIRS
        for one, other in (pair, pair[::-1])
        if solver.earth_axes and one in values and other not in values
    }
    if not solver.centre_moves and "N" in values:
        lacking |= {"X", "Y"} - set(values)
    if lacking:
        raise _problem(
            run,
            f"there is no {' and no '.join(sorted(lacking))}, which the other forces and moments "
            "need to be seen from the hull.",
            "Map them under [columns].",
        )


def _path(
    values: Mapping[str, Array],
    run: Run,
    motion: Mapping[str, Array] | None,
    needed: Sequence[str],
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
    if motion is not None:
        return _read_path(motion, times, run, needed), "from the file named by motion"
    recorded = {name: values[name] for name in PLACE if name in values}
    if "psi" in recorded:
        recorded["psi"] = np.unwrap(recorded["psi"])
    if set(needed) <= set(recorded):
        return recorded, "as recorded"
    theta = _phase(run, values) if run.dynamic else np.zeros_like(times)
    path = {**_set_path(run, theta), **recorded}
    told = f", recorded {', '.join(recorded)}" if recorded else ""
    return path, f"as the test was set{told}"


def _phase(run: Run, values: Mapping[str, Array]) -> Array:
    import xarray as xr

    moved = {name: ("t", values[name]) for name in (*PLACE, "u", "v", "r") if name in values}
    return displacement_phase(run, xr.Dataset(moved, coords={"t": values["t"]}), values["t"])


def _set_path(run: Run, theta: Array) -> dict[str, Array]:
    """The path that a test was set to, in axes that move with the carriage."""
    if run.test == "circular_motion" or run.test not in _SET:
        raise _problem(
            run.id,
            f"a {run.test} test does not say where the hull is at each instant.",
            'Name a file of t, x, y, psi: motion = "…".',
        )
    require_settings(run)
    zero = np.zeros_like(theta)
    if not run.dynamic:
        return {"x": zero, "y": zero, "psi": zero + run.settings.drift}
    sway = (run.settings.amplitude or 0.0) * np.sin(theta)
    if run.test in YAW_TESTS:
        sway = _tangent_path(run, theta)
    surge = run.test == "pure_surge"
    return {
        "x": sway if surge else zero,
        "y": zero if surge else sway,
        "psi": tank_motion(run, theta).psi,
    }


_SET: Final = (
    "resistance", "propulsion", "static_drift", "static_heel", "static_rudder", "drift_rudder",
    "pure_surge", "pure_sway", "sway_yaw", *YAW_TESTS,
)  # fmt: skip


def _tangent_path(run: Run, theta: Array) -> Array:
    """y of dy/dt = Uc tan(ψ0 sin θ), about its mean [m].

    The tangent is a series of odd sines; each is integrated on its own.
    """
    grid = 2 * math.pi * np.arange(_GRID) / _GRID
    slope = np.tan((run.settings.yaw_amplitude or 0.0) * np.sin(grid))
    waves = -2.0 * np.fft.rfft(slope).imag / _GRID
    total = np.zeros_like(theta)
    for order in _ORDERS:
        if abs(waves[order]) > 1e-15:
            total = total - waves[order] / order * np.cos(order * theta)
    return total * run.settings.speed / (run.settings.omega or math.inf)


def _read_path(
    motion: Mapping[str, Array], times: Array, run: Run, needed: Sequence[str]
) -> dict[str, Array]:
    """The path of a file of its own at the samples, straight lines between its rows."""
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
    if "psi" not in path:
        raise _problem(run.id, "the file named by motion has neither psi nor r.", "Map one.")
    path["psi"] = np.unwrap(path["psi"])
    if {"u", "v"} <= set(path) and not {"x", "y"} & set(path):
        cosine, sine = np.cos(path["psi"]), np.sin(path["psi"])
        u, v = path["u"], path["v"]
        path["x"] = _integral(own, u * cosine - v * sine - run.settings.speed)
        path["y"] = _integral(own, u * sine + v * cosine)
    missing = [name for name in needed if name not in path]
    if missing:
        raise _problem(
            run.id,
            f"the file named by motion has no {' and no '.join(missing)}.",
            "Write x, y, psi, or u, v, r.",
        )
    return {name: np.interp(times, own, path[name]) for name in needed}


def _integral(times: Array, rates: Array) -> Array:
    steps = 0.5 * (rates[1:] + rates[:-1]) * np.diff(times)
    return np.concatenate([np.zeros(1), np.cumsum(steps)])


def _no_data() -> xr.Dataset:
    """A run that only stands for its settings has no data."""
    raise CampaignError("There are no data.")


def _problem(run: str, message: str, remedy: str | None) -> CampaignError:
    return CampaignError(Problem(message=message, run=run, remedy=remedy))
