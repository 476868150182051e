"""Forces in axes of the earth or the carriage, about a centre that stays, seen from the hull.

A solver that moves the mesh states forces along axes that stay where they were, and its moments
about a point that does so too unless it is told to move it. With ψ the heading and (x, y) the
place of the hull, both from rest::

    X = Fx cos ψ + Fy sin ψ        Y = -Fx sin ψ + Fy cos ψ
    N = Mz - (rx Fy - ry Fx)       r from the centre to the ship's moment reference
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from pmmkit.base import CampaignError
from pmmkit.campaigns.motion.hull_path import PLACE, hull_path
from pmmkit.campaigns.stated_run import StatedRun
from pmmkit.numerics import Array

_PAIRS: Final = (("X", "Y"), ("FX_rudder", "FY_rudder"))


@dataclass(frozen=True, kw_only=True)
class Solver:
    """What ``[cfd]`` says of the forces of a computation, besides factors.

    `axes`: along what forces and moments are stated: the ship, axes that stay where they were,
    or the way of the carriage; on a rotating arm that is the tangent. `centre_moves`: whether
    the point that moments refer to moves with the hull. `centre_x, motion_x`: where that point
    (at rest), and the point whose path is stated, lie forward of midship [m]. `ramp`: duration
    from the first sample that belongs to the start-up of the computation [s]. `stated`: keys
    that ``[cfd]`` has.
    """

    axes: Literal["body", "earth", "carriage"] = "body"
    centre_moves: bool = True
    centre_x: float = 0.0
    motion_x: float = 0.0
    ramp: float = 0.0
    stated: frozenset[str] = frozenset()

    @property
    def turns(self) -> bool:
        """Whether anything depends on where the hull is."""
        return self.axes != "body" or not self.centre_moves

    @property
    def needed(self) -> tuple[str, ...]:
        """What must be known of where the hull is."""
        return PLACE if not self.centre_moves else ("psi",) if self.axes != "body" else ()


def without_ramp(
    values: Mapping[str, Array], ramp: float, *, file: str, run: str
) -> tuple[dict[str, Array], list[str]]:
    """A history without the start-up of the computation."""
    if not ramp:
        return dict(values), []
    times = values["t"]
    kept = times >= times[0] + ramp
    if not kept.any():
        raise CampaignError(
            f"ramp_s = {ramp:g} s leaves no samples; they are from t = {times[0]:g} to "
            f"{times[-1]:g} s.",
            file=file,
            run=run,
            remedy="Correct ramp_s under [cfd].",
        )
    note = f"first {ramp:g} s left out (ramp_s): {int(np.sum(~kept))} of {len(times)} samples"
    return {name: numbers[kept] for name, numbers in values.items()}, [note]


def seen_from_hull(
    values: Mapping[str, Array], solver: Solver, run: StatedRun
) -> tuple[dict[str, Array], list[str]]:
    """Forces and moments in ship axes, about the ship's own moment reference.

    Examples
    --------
    >>> import math
    >>> from pmmkit.campaigns.settings import Settings
    >>> side = {"X": np.array([0.0]), "Y": np.array([10.0]), "N": np.array([0.0])}
    >>> run = StatedRun(id="SD", test="static_drift", kind="means",
    ...                 settings=Settings(speed=1.0, drift=math.pi / 6))
    >>> turned, _ = seen_from_hull(side, Solver(axes="earth"), run)
    >>> turned["X"].round(3), turned["Y"].round(3)
    (array([5.]), array([8.66]))
    """
    if not solver.turns:
        return dict(values), []
    _check_pairs(values, solver, run.id)
    on_an_arm = run.kind_of_test.motion.tank is None and solver.axes == "carriage"
    if on_an_arm and solver.centre_moves:
        first = next(iter(values.values()))
        path, whence = {"psi": np.full(len(first), run.settings.drift)}, "the drift angle"
    else:
        path, whence = hull_path(values, run, solver.needed)
    cosine, sine = np.cos(path["psi"]), np.sin(path["psi"])
    out = dict(values)
    notes = [f"heading{' and place' if not solver.centre_moves else ''} of the hull: {whence}"]
    if solver.axes != "body":
        for ahead, aside in _PAIRS:
            if ahead in values:
                along, across = values[ahead], values[aside]
                out[ahead] = along * cosine + across * sine
                out[aside] = -along * sine + across * cosine
        notes.append(f"forces turned from {solver.axes} axes to ship axes by the heading")
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
        if solver.axes != "body" and one in values and other not in values
    }
    if not solver.centre_moves and "N" in values:
        lacking |= {"X", "Y"} - set(values)
    if lacking:
        raise CampaignError(
            f"there is no {' and no '.join(sorted(lacking))}, which the other forces "
            "and moments need to be seen from the hull.",
            run=run,
            remedy="Map them under [columns].",
        )
