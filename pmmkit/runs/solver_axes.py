"""Forces of a CFD in earth axes, about a centre that stays behind, seen from the hull.

A solver that moves the mesh states forces along axes that stay where they were, and its moments
about a point that does so too unless it is told to move it. With ψ the heading and (x, y) the
place of the hull, both from rest::

    X = Fx cos ψ + Fy sin ψ        Y = -Fx sin ψ + Fy cos ψ
    N = Mz - (rx Fy - ry Fx)       r from the centre to the ship's moment reference
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.errors import CampaignError, Problem
from pmmkit.runs.hull_path import PLACE, hull_path
from pmmkit.runs.readers.base import Array
from pmmkit.runs.run import Kind, Run, Settings

if TYPE_CHECKING:
    import xarray as xr

_PAIRS: Final = (("X", "Y"), ("FX_rudder", "FY_rudder"))


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
    >>> import math
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
    path, whence = hull_path(
        values, bare, motion, needed=("psi",) if solver.centre_moves else PLACE
    )
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
        raise CampaignError(
            Problem(
                message=f"there is no {' and no '.join(sorted(lacking))}, which the other forces "
                "and moments need to be seen from the hull.",
                run=run,
                remedy="Map them under [columns].",
            )
        )


def _no_data() -> xr.Dataset:
    """A run that only stands for its settings has no data."""
    raise CampaignError("There are no data.")
