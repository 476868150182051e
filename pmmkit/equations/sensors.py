"""What sensors should show of a motion.

As `intervals`, this file is written into a module of one structure's equations; `kinds` says what
each column of `measured` is: the place of a state, or one of `OverGround`.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pmmkit.equations.layouts import Constant, OverGround, State
from pmmkit.equations.stand_ins import NS

Array = NDArray[np.float64]
Places = NDArray[np.int64]


def upright(z: Array, k: Array) -> float:
    """Cosine of the heel: of the state of a ship that rolls, else of the one that was measured."""
    return math.cos(z[State.phi] if k[Constant.rolls] > 0.0 else k[Constant.roll])


def expected(kind: int, z: Array, k: Array, h: Array) -> float:
    """What a channel should show, and its slopes over the states."""
    for i in range(len(h)):
        h[i] = 0.0
    if kind < NS:
        h[kind] = 1.0
        return float(z[kind])
    ahead, aside, level = math.cos(z[State.psi]), math.sin(z[State.psi]), upright(z, k)
    sway = z[State.v] * level
    north = z[State.u] * ahead - sway * aside + k[Constant.current_x]
    east = z[State.u] * aside + sway * ahead + k[Constant.current_y]
    to_north, to_east, size, shown = 1.0, 0.0, 1.0, north
    if kind == OverGround.east:
        to_north, to_east, shown = 0.0, 1.0, east
    elif kind == OverGround.size:
        to_north, to_east = north, east
        size = max(math.sqrt(north * north + east * east), 1e-9)
        shown = size
    across = (to_east * ahead - to_north * aside) / size
    h[State.u] = (to_north * ahead + to_east * aside) / size
    h[State.v] = across * level
    h[State.psi] = (
        to_north * (k[Constant.current_y] - east) + to_east * (north - k[Constant.current_x])
    ) / size
    if k[Constant.rolls] > 0.0:
        h[State.phi] = -across * z[State.v] * math.sin(z[State.phi])
    return float(shown)


def drifted(z: Array, k: Array, h: Array, starts: Places, places: Places, slopes: Array) -> None:
    """Slopes of a velocity over ground over the parameters that are a current: it adds to it."""
    ahead, aside = math.cos(z[State.psi]), math.sin(z[State.psi])
    across = h[State.v] / upright(z, k)
    north, east = h[State.u] * ahead - across * aside, h[State.u] * aside + across * ahead
    for j in range(len(starts) - 1):
        for s in range(starts[j], starts[j + 1]):
            if places[s] == Constant.current_x:
                h[NS + j] += slopes[s] * north
            elif places[s] == Constant.current_y:
                h[NS + j] += slopes[s] * east


def turned_back(residual: float, kind: int) -> float:
    """A residual of the heading taken the short way round."""
    if kind != State.psi:
        return residual
    return residual - 2.0 * math.pi * math.floor(residual / (2.0 * math.pi) + 0.5)
