"""Straight-line stability: the linear equations, criterion C, levers, Nomoto's constants."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.equations import Conditions, prepare
from pmmkit.models import Model, load_model
from pmmkit.numerics import Array
from pmmkit.presentation import Described, Grid, Group, Section, number

Complex = NDArray[np.complex128]
STEP: Final = 1e-5
"""Step of the central differences over the size of each velocity."""
BENT: Final = 2e-3
"""Difference between the slopes of both sides, over the largest, from which there is a bend."""


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Stability(Described):
    """A ship running straight ahead at a speed, made linear, everything included that acts on it.

    `eigenvalues`: of sway and yaw (and roll), over U/L; the ship is stable if all have negative
    real parts. `C`: yv Nr - Nv (Yr - m'), of the whole ship in the prime system; positive where
    stable. `lever_sway, lever_yaw`: nv/Yv and Nr/(Yr - m'), over L from midship. `K, T`:
    nomoto's gain and time, in units of U/L and L/U; negative for an unstable ship. `T1, T2,
    T3`: times of the second-order equation [L/U]. `rudder`: yδ and Nδ of the whole ship in the
    prime system. `stable`: whether it keeps its course without a rudder. `side`: ``both``; or,
    where the equations have a bend at straight running (flow straightening that differs by
    side), the side of the turn to which all of the above belongs, which is the less stable one.
    """

    speed: float
    eigenvalues: Complex
    C: float
    lever_sway: float
    lever_yaw: float
    K: float
    T: float
    T1: float
    T2: float
    T3: float
    rudder: tuple[float, float]
    stable: bool
    side: str
    name: str

    def constants(self) -> dict[str, float]:
        """The numbers of the prime system by name."""
        names = ("C", "lever_sway", "lever_yaw", "K", "T", "T1", "T2", "T3")
        Ydelta, Ndelta = self.rudder
        return {name: getattr(self, name) for name in names} | {"Ydelta": Ydelta, "Ndelta": Ndelta}

    def _headline(self) -> str:
        word = "stable" if self.stable else "UNSTABLE"
        side = f", turning to {self.side}, the less stable side" if self.side != "both" else ""
        return f"{self.name} at {self.speed:g} m/s is straight-line {word}{side}"

    def _sections(self) -> Sequence[Section]:
        rows = [[name, number(value)] for name, value in self.constants().items()]
        roots = ", ".join(f"{x:.4g}" for x in self.eigenvalues.tolist())
        table = Grid(head=["number (prime system)", "value"], groups=[Group(rows=rows)])
        return [Section(tables=[table]), Section(paragraphs=[f"Eigenvalues [U/L]: {roots}"])]


def stability(
    model: Model | str | Path,
    speed: float,
    *,
    depth: float | None = None,
    extrapolate: bool = False,
) -> Stability:
    """Straight-line stability of a model at a speed.

    Parameters
    ----------
    model : Model, str or path
        A model, a library name or a file.
    speed : float
        [m/s], with the revolutions of self-propulsion.
    depth : float, optional
        Depth of the water [m], for models with a part ``shallow_water``.
    extrapolate : bool
        Allow a speed outside the range of the model's values.

    Returns
    -------
    Stability

    Notes
    -----
    Sway and yaw at constant surge: M x' = N x + b δ. With Nomoto's equation
    T1 T2 r'' + (T1 + T2) r' + r = K (δ + T3 δ'), T = T1 + T2 - T3 (Nomoto et al. 1957). The
    eigenvalues are those of all degrees of freedom but surge; C, the levers and Nomoto's constants
    are of sway and yaw alone, upright.

    Examples
    --------
    >>> found = stability("s175-3dof", 7.0)
    >>> found.stable, found.C > 0, found.lever_yaw > found.lever_sway
    (True, True, True)
    >>> stability("esso190k", 8.23).stable
    False
    """
    loaded = model if isinstance(model, Model) else load_model(model)
    ready = prepare(loaded, speed, conditions=Conditions(depth=depth), extrapolate=extrapolate)
    n, L = ready.self_propulsion(), ready.L
    rolls = ready.rolls
    size = np.array([speed, speed / L, speed / L, 1.0])
    unit = np.array([speed**2 / L, (speed / L) ** 2, (speed / L) ** 2])

    def rates(v: float, r: float, p: float, phi: float, delta: float) -> Array:
        _, vdot, rdot, pdot = ready.accelerations(speed, v, r, p, phi, delta, n)
        found: Array = np.array([vdot, rdot, pdot]) / unit
        return found

    def slopes(turn: float) -> Array:
        """Change of the accelerations with v, r, p, phi and the rudder, non-dimensional."""
        steps = STEP * np.diag([*size, 1.0])
        middle = 2.0 * STEP * turn * np.array([-size[0], size[1], 0.0, 0.0, 0.0])
        change: Array = np.column_stack(
            [(rates(*(middle + step)) - rates(*(middle - step))) / (2.0 * STEP) for step in steps]
        )
        return change

    columns, side = _least_stable({turn: slopes(turn) for turn in (-1.0, 1.0)}, slopes(0.0), rolls)
    mass = ready.mass_matrix
    degrees = 3 if rolls else 2
    forces = mass @ columns[:degrees]
    upright = np.linalg.inv(mass[:2, :2])
    plane, force = upright @ forces[:2, :2], upright @ forces[:2, 4]
    eigenvalues = _eigenvalues(columns, rolls)
    Y = forces[:2, :2]
    a, b = -np.trace(plane), np.linalg.det(plane)
    top = plane[1, 0] * force[0] - plane[0, 0] * force[1]
    roots = np.linalg.eigvals(plane)
    times = sorted((float((-1.0 / root).real) for root in roots), key=abs, reverse=True)
    K, T3 = top / b, force[1] / top
    return Stability(
        speed=speed,
        eigenvalues=eigenvalues,
        C=float(Y[0, 0] * Y[1, 1] - Y[1, 0] * Y[0, 1]),
        lever_sway=float(Y[1, 0] / Y[0, 0]),
        lever_yaw=float(Y[1, 1] / Y[0, 1]),
        K=float(K),
        T=float(a / b - T3),
        T1=times[0],
        T2=times[1],
        T3=float(T3),
        rudder=(float(forces[0, 4]), float(forces[1, 4])),
        stable=bool(np.all(eigenvalues.real < 0.0)),
        side=side,
        name=loaded.name,
    )


def _least_stable(sides: Mapping[float, Array], both: Array, rolls: bool) -> tuple[Array, str]:
    """The slopes that decide: of both sides at once, or where they differ of the worse one."""
    port, starboard = sides[-1.0], sides[1.0]
    if np.max(np.abs(port - starboard)) <= BENT * np.max(np.abs(both)):
        return both, "both"
    worst = max(sides, key=lambda turn: _eigenvalues(sides[turn], rolls).real.max())
    return sides[worst], "starboard" if worst > 0 else "port"


def _eigenvalues(columns: Array, rolls: bool) -> Complex:
    """Of sway and yaw, and of roll and heel where the ship rolls."""
    if not rolls:
        return np.linalg.eigvals(columns[:2, :2]).astype(complex)
    whole = np.vstack([columns[:3, :4], [0.0, 0.0, 1.0, 0.0]])
    return np.linalg.eigvals(whole).astype(complex)
