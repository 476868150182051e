"""The steady turning rate over the rudder angle, exactly: the curve of a reverse spiral."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import SimulationError
from pmmkit.equations import Conditions, State, prepare
from pmmkit.models import Model, load_model
from pmmkit.numerics import Array
from pmmkit.presentation import Described, Grid, Group, Section

if TYPE_CHECKING:
    import pandas as pd

    from pmmkit.plotting import Figure

_SETTLED: Final = 1e-11
LISTED: Final = 16
"""Steady turns that a report lists, about."""


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class SpiralCurve(Described):
    """Steady turns from one side to the other.

    `rudder_deg, yaw_rate_deg_s, drift_deg, speed_ratio (m,)`: along the curve, by rising yaw
    rate; as of a turning circle, in the horizontal plane. `stable (m,)`: whether the ship stays
    in that turn by itself: the rudder rises with the yaw rate. `loop_width_deg`: rudder angles
    between the two folds of the curve; 0 for a stable ship. `loop_height_deg_s`: yaw rates
    between the two stable turns with the rudder at `neutral_deg`; 0 for a stable ship.
    `neutral_deg`: rudder angle in the middle between the folds, or where a stable ship does not
    turn.
    """

    rudder_deg: Array
    yaw_rate_deg_s: Array
    drift_deg: Array
    speed_ratio: Array
    stable: NDArray[np.bool_]
    loop_width_deg: float
    loop_height_deg_s: float
    neutral_deg: float
    name: str
    scale: str

    def to_pandas(self) -> pd.DataFrame:
        """A row per steady turn."""
        import pandas as pd

        names = ("rudder_deg", "yaw_rate_deg_s", "drift_deg", "speed_ratio", "stable")
        return pd.DataFrame({name: getattr(self, name) for name in names})

    def plot(self) -> Figure:
        """Yaw rate over the rudder that holds it; the loop of an unstable ship is shaded."""
        from pmmkit.plotting import steady_turns

        half = self.loop_width_deg / 2
        loop = (self.neutral_deg - half, self.neutral_deg + half)
        return steady_turns(self.rudder_deg, self.yaw_rate_deg_s, self.stable, loop)

    def _headline(self) -> str:
        loop = (
            f"loop {self.loop_width_deg:.2f}° wide and {self.loop_height_deg_s:.3f}°/s high"
            if self.loop_width_deg > 0
            else "no loop"
        )
        return f"{self.name}: {len(self.rudder_deg)} steady turns, {loop}"

    def _sections(self) -> Sequence[Section]:
        some = self.to_pandas().iloc[:: max(len(self.stable) // LISTED, 1)]
        rows = [
            [
                f"{turn.yaw_rate_deg_s:+.3f}",
                f"{turn.rudder_deg:+.2f}",
                f"{turn.drift_deg:+.2f}",
                f"{turn.speed_ratio:.3f}",
                "yes" if turn.stable else "no",
            ]
            for turn in some.itertuples()
        ]
        head = ["yaw rate [deg/s]", "rudder [deg]", "drift [deg]", "U / U0", "stays"]
        table = Grid(head=head, groups=[Group(rows=rows)])
        return [
            Section(paragraphs=[self.sentence(), *([self.scale] if self.scale else [])]),
            Section(title=f"{len(rows)} of the {len(self.stable)} steady turns", tables=[table]),
        ]

    def sentence(self) -> str:
        """Whether there is a loop and where, in a sentence."""
        if self.loop_width_deg > 0:
            return (
                f"The spiral has a loop {self.loop_width_deg:.2f}° wide and "
                f"{self.loop_height_deg_s:.3f}°/s high about a rudder of {self.neutral_deg:+.2f}°."
            )
        return f"The spiral has no loop; the ship runs straight at {self.neutral_deg:+.2f}°."


def spiral_curve(
    model: Model | str | Path,
    speed: float,
    *,
    most: float = 0.4,
    points: int = 161,
    depth: float | None = None,
    extrapolate: bool = False,
) -> SpiralCurve:
    """The curve of a reverse spiral: the rudder that holds each yaw rate.

    Parameters
    ----------
    model : Model, str or path
        A model, a library name or a file.
    speed : float
        Approach speed [m/s]; its revolutions are kept.
    most : float
        Largest yaw rate over the approach speed and L, to each side.
    points : int
        Number of yaw rates.
    depth : float, optional
        Depth of the water [m], for models with a part ``shallow_water``.
    extrapolate : bool
        Allow a speed outside the range of the model's values.

    Returns
    -------
    SpiralCurve

    Raises
    ------
    SimulationError
        If no steady turn is found at the smallest yaw rates.

    Notes
    -----
    At each yaw rate surge, sway, heel and rudder follow by Newton's method from the last one.

    Examples
    --------
    >>> spiral_curve("s175-3dof", 9.0).loop_width_deg
    0.0
    >>> spiral_curve("kvlcc2", 7.97).loop_width_deg > 0
    True
    """
    loaded = model if isinstance(model, Model) else load_model(model)
    ready = prepare(loaded, speed, conditions=Conditions(depth=depth), extrapolate=extrapolate)
    n, L, rolls = ready.self_propulsion(), ready.L, ready.rolls
    size = np.array([speed, speed, 1.0, 1.0])
    unit = np.array([speed**2 / L, speed**2 / L, (speed / L) ** 2, (speed / L) ** 2])
    balance = [State.u, State.v, State.r, *([State.p] if rolls else [])]
    free = len(balance)

    def residual(z: Array, r: float) -> Array:
        u, v, delta, phi = (z * size).tolist()
        out = ready.rates(ready.settled(u, v, r, 0.0, phi, delta, n), delta, n)
        found: Array = np.array([out[i] for i in balance]) / unit[:free]
        return found

    def follow(z: Array, r: float) -> Array | None:
        z = z.copy()
        for _ in range(30):
            value = residual(z, r)
            if np.max(np.abs(value)) < _SETTLED:
                return z
            steps = np.eye(4)[:free] * 1e-6
            slope = np.stack([(residual(z + h, r) - residual(z - h, r)) / 2e-6 for h in steps], 1)
            try:
                change = np.linalg.solve(slope, value)
            except np.linalg.LinAlgError:
                return None
            if not np.all(np.isfinite(change)) or np.max(np.abs(change)) > 1.0:
                return None
            z[:free] -= change
        return None

    half = np.linspace(0.0, most * speed / L, points // 2 + 1)
    sides = []
    for side in (-1.0, 1.0):
        z, rows = np.array([1.0, 0.0, 0.0, 0.0]), []
        for r in half:
            step = follow(z, side * float(r))
            if step is None or abs(step[2]) > np.pi / 3 or step[0] < 0.05:
                break
            z = step
            rows.append((side * float(r), *z))
        sides.append(rows)
    if len(sides[0]) < 2 or len(sides[1]) < 2:
        raise SimulationError(f"Model {loaded.name!r} has no steady turns at {speed:g} m/s.")
    table = np.array([*sides[0][:0:-1], *sides[1]])
    r, u, v, delta = table[:, 0], table[:, 1], table[:, 2], np.degrees(table[:, 3])
    rising = np.gradient(delta, r) > 0.0
    # In the horizontal plane, as the metrics of a turning circle have them.
    upright = np.cos(table[:, 4])

    def rudder(rate: float, near: int) -> float:
        z = follow(np.array([u[near], v[near], np.radians(delta[near]), table[near, 4]]), rate)
        return float(np.degrees(z[2])) if z is not None else float(delta[near])

    width, height, neutral = _loop(r, delta, rudder)
    return SpiralCurve(
        rudder_deg=delta,
        yaw_rate_deg_s=np.degrees(r * upright),
        drift_deg=np.degrees(np.arctan2(-v * upright, u)),
        speed_ratio=np.hypot(u, v * upright),
        stable=rising,
        loop_width_deg=width,
        loop_height_deg_s=height,
        neutral_deg=neutral,
        name=loaded.name,
        scale=loaded.scale,
    )


def _loop(
    rate: Array, angle: Array, rudder: Callable[[float, int], float]
) -> tuple[float, float, float]:
    """Width between the folds [deg], height at their middle [deg/s], and the neutral rudder.

    A fold is a turning point of the curve; it is looked for on the curve itself between the
    points around it, because the curve may have a bend there.
    """
    from scipy.optimize import brentq, minimize_scalar

    change = np.sign(np.diff(angle))
    folds = [i for i in range(1, len(angle) - 1) if change[i - 1] * change[i] < 0]
    if len(folds) < 2:
        return 0.0, 0.0, float(np.interp(0.0, rate, angle))
    values = []
    for i in folds:
        side = change[i - 1]
        found = minimize_scalar(
            lambda r, i=i, side=side: -side * rudder(r, i),
            method="bounded",
            bounds=(rate[i - 1], rate[i + 1]),
            options={"xatol": 1e-9},
        )
        values.append(-side * found.fun)
    neutral = (max(values) + min(values)) / 2
    above = np.sign(angle - neutral)
    turns = [
        brentq(lambda r, i=i: rudder(r, i) - neutral, rate[i], rate[i + 1])
        for i in range(len(angle) - 1)
        if above[i] * above[i + 1] < 0
    ]
    height = float(np.degrees(max(turns) - min(turns))) if turns else 0.0
    return float(max(values) - min(values)), height, float(neutral)
