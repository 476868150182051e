"""What starts, unknown forces and values do to what the records of a stretch show."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import SimulationError
from pmmkit.diagnosis.free_running.windows import (
    RUDDER_ZERO,
    RecordWindows,
    by_piece,
    constants,
    inputs,
    piece_begins,
    sailed,
    shown,
)
from pmmkit.effects import CURRENT, OUTSIDE
from pmmkit.numerics import Array

SMALL: Final = 1e-5
"""Step of a state for its slope, over its size: forward differences lose half of the digits."""
PUSH: Final = 1e-3
"""Step of a force for its slope, over ½ρLdU² and ½ρL²dU²."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Sheet:
    """The linear rows of a window: averages over blocks, in the units of the channels.

    `starts (b, s)`: slopes over the first states of the ship. `forces (b, p, f)`: over the unknown
    force of each channel in each piece, over ½ρLdU² (½ρL²dU²). `values (b, m)`: over the values
    that may move. `errors (b,)`: measured less shown, along the path about which it is made linear.
    `along (p, f)`: unknown forces on that path. `channels (b,)`: of the stretch's channels, the
    one that a row belongs to. `blocks (b,)`: number of the block of each row. `counts (b,)`:
    samples that are averaged in a row. `spacing`: length of the pieces in ship lengths over
    the speed. `begun (s,)`: the first states. `loose (s,)`: what is known of them before anything
    is measured, as standard deviations about zero; infinite of all that is measured.
    """

    starts: Array
    forces: Array
    values: Array
    errors: Array
    along: Array
    channels: NDArray[np.int64]
    blocks: NDArray[np.int64]
    counts: Array
    spacing: float
    begun: Array
    loose: Array


def sheets_of(
    stretch: RecordWindows, change: Array, steps: Mapping[int, float] | None = None
) -> list[Sheet]:
    """The linear problem of each window of a stretch about a change of the values.

    change (m,).
    """
    here = sailed(stretch, change)
    if not np.all(np.isfinite(here)):
        raise SimulationError(f"The simulated motion of record {stretch.record.name!r} is lost.")
    now = shown(stretch, here, change)
    asked = steps or {}
    measured = np.stack([stretch.record.measured[name] for name in stretch.channels], axis=1)
    slopes = _observed(stretch, here, change) @ _carried(stretch, change, here, asked)
    rows = np.concatenate([slopes, (measured - now)[:, :, None]], axis=2)
    size, first = len(stretch.states), rows.shape[2] - 1 - len(asked)
    for j, (value, step) in enumerate(asked.items(), start=first):
        # What is shown in another way, whatever the ship does.
        if stretch.names[value] in (*CURRENT, *OUTSIDE):
            moved = shown(stretch, here, _further(change, value, step))
            rows[:, :, j] += (moved - now) / step
    means, channels, blocks, counts = _averaged(stretch, rows)
    values = np.zeros((len(means), len(change)))
    values[:, [*asked]] = means[:, first:-1]
    forces = means[:, size:first].reshape(len(means), -1, len(stretch.units))
    begins = piece_begins(stretch)
    along = by_piece(stretch, stretch.forces)
    edges = np.searchsorted(begins, stretch.begins[:-1])
    last = np.append(edges[1:], len(begins))
    loose = _loose(stretch)
    of_windows = np.searchsorted(stretch.begins, blocks, side="right") - 1
    ends = np.searchsorted(of_windows, np.arange(len(edges) + 1))
    return [
        Sheet(
            starts=means[a:b, : stretch.own],
            forces=forces[a:b, : end - begin],
            values=values[a:b],
            errors=means[a:b, -1],
            along=along[begin:end],
            channels=channels[a:b],
            blocks=stretch.blocks[blocks[a:b]],
            counts=stretch.samples * counts[a:b],
            spacing=float(spacing),
            begun=begun,
            loose=loose,
        )
        for a, b, begin, end, spacing, begun in zip(
            ends[:-1].tolist(),
            ends[1:].tolist(),
            edges.tolist(),
            last.tolist(),
            stretch.spacing,
            stretch.starts[:, : stretch.own],
            strict=True,
        )
    ]


_HEEL: Final = 0.1
"""Usual size of a heel that is not measured [rad], and of its rate over U/L."""


def _loose(stretch: RecordWindows) -> Array:
    """How far first states of roll may lie from zero, where nothing measures it: the forces alone
    would tell a ship that lies on her side."""
    heels = {"phi": _HEEL, "p": _HEEL * stretch.pace}
    free = not {"phi", "p"} & {*stretch.channels}
    sizes = [heels.get(name, math.inf) if free else math.inf for name in stretch.states]
    return np.array(sizes[: stretch.own])


def _averaged(
    stretch: RecordWindows, rows: Array
) -> tuple[Array, NDArray[np.int64], NDArray[np.int64], Array]:
    """Means of rows (n, c, q), errors last, over the instants of a block that measured a channel;
    with the channel of each mean, the first instant of its block, and of how many it is."""
    there = np.isfinite(rows[:, :, -1])
    new = np.diff(stretch.blocks, prepend=-1) != 0
    new[stretch.begins[:-1]] = True
    edges = np.flatnonzero(new)
    counts = np.add.reduceat(there.astype(float), edges, axis=0)
    total = np.add.reduceat(
        rows if there.all() else np.where(there[:, :, None], rows, 0.0), edges, axis=0
    )
    measured = counts > 0
    blocks, channels = np.nonzero(measured)
    return total[measured] / counts[measured][:, None], channels, edges[blocks], counts[measured]


def _observed(stretch: RecordWindows, states: Array, change: Array) -> Array:
    """Slopes (n, c, s) of what the channels show over the states."""
    now = shown(stretch, states, change)
    slopes = np.empty((*now.shape, states.shape[1]))
    for j, step in enumerate(state_steps(stretch).tolist()):
        moved = states.copy()
        moved[:, j] += step
        slopes[:, :, j] = (shown(stretch, moved, change) - now) / step
    return slopes


def state_steps(stretch: RecordWindows) -> Array:
    """Steps (s,) of the states for slopes."""
    speed = stretch.record.speed
    L = speed / stretch.pace
    sizes = {"u": speed, "v": speed, "r": stretch.pace, "p": stretch.pace, "x": L, "y": L}
    return np.array([SMALL * sizes.get(name, 1.0) for name in stretch.states])


def _further(change: Array, j: int, step: float) -> Array:
    """A change of the values with a step more of one of them."""
    moved = change.copy()
    moved[j] += step
    return moved


def _carried(
    stretch: RecordWindows, change: Array, here: Array, steps: Mapping[int, float]
) -> Array:
    """Slopes (n, s, s + p f + m) of the states along a path over the first ones of the windows,
    unknown forces in pieces, and some values: all in one integration."""
    k = constants(stretch, change)
    if k is None:
        raise SimulationError("No ship has such a mass matrix.")
    given, (count, size) = inputs(stretch, change), here.shape
    moved, turned = np.tile(k, (len(steps), 1)), np.zeros(len(steps))
    for place, (value, step) in enumerate(steps.items()):
        further = _further(change, value, step)
        own = constants(stretch, further)
        if own is None:
            raise SimulationError("No ship has such a mass matrix.")
        moved[place] = own
        turned[place] = step if stretch.names[value] == RUDDER_ZERO else 0.0
    forced = size + (int(stretch.pieces.max()) + 1) * len(stretch.units)
    found = np.empty((count, size, forced + len(steps)))
    stretch.functions.tangents(
        stretch.record.t,
        given,
        np.ascontiguousarray(stretch.forces * stretch.units),
        stretch.begins,
        stretch.pieces,
        here,
        k,
        moved,
        turned,
        (turned != 0.0) | np.any(moved != k, axis=1),
        np.concatenate([state_steps(stretch), PUSH * stretch.units, [*steps.values()]]),
        found,
    )
    found[:, :, size:forced] *= np.resize(stretch.units, forced - size)
    return found


def channels_of(stretches: Sequence[RecordWindows]) -> tuple[str, ...]:
    """All channels of stretches, each once."""
    return tuple(dict.fromkeys(name for item in stretches for name in item.channels))
