"""What starts, unknown forces and values do to what the records of a stretch show."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import SimulationError
from pmmkit.diagnosis.free_running.windows import (
    RecordWindows,
    by_piece,
    constants,
    inputs,
    piece_begins,
    sailed,
    shown,
)
from pmmkit.numerics import Array

SMALL: Final = 1e-5
"""Step of a state for its slope, over its size: forward differences lose half of the digits."""
PUSH: Final = 1e-3
"""Step of a force for its slope, over ½ρLdU² and ½ρL²dU²."""
JOBS: Final = 4


@dataclass(frozen=True, kw_only=True, eq=False)
class Sheet:
    """The linear rows of a window: averages over blocks, in the units of the channels.

    `starts (b, s)`: slopes over the first states. `forces (b, p, f)`: over the unknown force of
    each channel in each piece, over ½ρLdU² (½ρL²dU²). `values (b, m)`: over the values that may
    move. `errors (b,)`: measured less shown, along the path about which it is made linear.
    `along (p, f)`: unknown forces on that path. `channels (b,)`: of the stretch's channels, the
    one that a row belongs to. `blocks (b,)`: number of the block of each row. `counts (b,)`:
    samples that are averaged in a row. `spacing`: length of the pieces in ship lengths over
    the speed.
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

    def column(j: int) -> Array:
        moved = change.copy()
        moved[j] += asked[j]
        slope: Array = (shown(stretch, sailed(stretch, moved), moved) - now) / asked[j]
        return slope

    slopes = np.zeros((*now.shape, len(change)))
    with ThreadPoolExecutor(JOBS) as pool:
        for j, values in zip(asked, pool.map(column, asked), strict=True):
            slopes[:, :, j] = values
        states, forces = _carried(stretch, change, here, pool)
    observed = _observed(stretch, here, change)
    measured = np.stack([stretch.record.measured[name] for name in stretch.channels], axis=1)
    pieces = np.split(
        by_piece(stretch, stretch.forces),
        np.searchsorted(piece_begins(stretch), stretch.begins[1:-1]),
    )
    return [
        _sheet(stretch, w, observed, states[w], forces[w], slopes, measured - now, pieces[w])
        for w in range(len(stretch.begins) - 1)
    ]


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


def _carried(
    stretch: RecordWindows, change: Array, here: Array, pool: ThreadPoolExecutor
) -> tuple[list[Array], list[Array]]:
    """Slopes of the states of each window over its start (n, s, s) and its forces (n, s, p, f).

    Each piece is sailed alone, a little off in each state and with a little force, and what comes
    of it is carried on through the pieces that follow.
    """
    begins = np.append(piece_begins(stretch), len(stretch.record))
    last = np.isin(begins[1:], stretch.begins)
    rows = [
        np.arange(a, b + (0 if end else 1))
        for a, b, end in zip(begins[:-1], begins[1:], last, strict=True)
    ]
    every = np.concatenate(rows)
    edges = np.cumsum([0, *(len(item) for item in rows)]).astype(np.int64)
    t, given = stretch.record.t[every], inputs(stretch, change)[every]
    first = here[begins[:-1]]
    # The last instant of a piece is the first of the next one, whose force is another.
    whole = np.repeat(by_piece(stretch, stretch.forces), np.diff(edges), axis=0)

    def run(starts: Array, forces: Array) -> Array:
        k = constants(stretch, change)
        if k is None:
            raise SimulationError("No ship has such a mass matrix.")
        out = np.empty((len(t), starts.shape[1]))
        stretch.functions.pushed(
            t,
            given,
            np.ascontiguousarray(forces * stretch.units),
            edges,
            np.ascontiguousarray(starts),
            k,
            stretch.longest,
            out,
        )
        return out

    now = run(first, whole)

    def off(j: int) -> Array:
        step = state_steps(stretch)[j]
        moved = first.copy()
        moved[:, j] += step
        slope: Array = (run(moved, whole) - now) / step
        return slope

    def pushed(j: int) -> Array:
        more = whole.copy()
        more[:, j] += PUSH
        slope: Array = (run(first, more) - now) / PUSH
        return slope

    state = np.stack(list(pool.map(off, range(first.shape[1]))), axis=-1)
    force = np.stack(list(pool.map(pushed, range(len(stretch.units)))), axis=-1)
    return _joined(stretch, begins, edges, state, force)


def _joined(
    stretch: RecordWindows,
    begins: NDArray[np.int64],
    edges: NDArray[np.int64],
    state: Array,
    force: Array,
) -> tuple[list[Array], list[Array]]:
    """The slopes of pieces carried through their windows."""
    size, channels = state.shape[1], force.shape[2]
    over_start, over_forces = [], []
    for begin, end in zip(stretch.begins[:-1].tolist(), stretch.begins[1:].tolist(), strict=True):
        first, count = int(np.searchsorted(begins, begin)), int(stretch.pieces[end - 1]) + 1
        start = np.empty((end - begin, size, size))
        own = np.zeros((end - begin, size, count * channels))
        S, F = np.eye(size), np.zeros((size, count * channels))
        for q in range(count):
            at, to = int(edges[first + q]), int(edges[first + q + 1])
            length = int(begins[first + q + 1] - begins[first + q])
            row = int(begins[first + q]) - begin
            rows = slice(row, row + length)
            here = slice(q * channels, (q + 1) * channels)
            start[rows] = state[at : at + length] @ S
            own[rows] = state[at : at + length] @ F
            own[rows, :, here] += force[at : at + length]
            S, F = state[to - 1] @ S, state[to - 1] @ F
            F[:, here] += force[to - 1]
        over_start.append(start)
        over_forces.append(own.reshape(end - begin, size, count, channels))
    return over_start, over_forces


def _sheet(
    stretch: RecordWindows,
    w: int,
    observed: Array,
    states: Array,
    forces: Array,
    slopes: Array,
    errors: Array,
    along: Array,
) -> Sheet:
    """The rows of a window: averages over the instants of a block that measured a channel."""
    rows = slice(stretch.begins[w], stretch.begins[w + 1])
    there = np.isfinite(errors[rows])
    edges = np.flatnonzero(np.diff(stretch.blocks[rows], prepend=-1))
    counts = np.add.reduceat(there.astype(float), edges, axis=0)
    measured = counts > 0
    blocks, channels_of_rows = np.nonzero(measured)

    def averaged(x: Array) -> Array:
        total = np.add.reduceat(np.where(there[:, :, None], x, 0.0), edges, axis=0)
        means: Array = total[measured] / counts[measured][:, None]
        return means

    H = observed[rows]
    pieces, channels = forces.shape[2:]
    flat = averaged(H @ forces.reshape(*forces.shape[:2], -1))
    return Sheet(
        starts=averaged(H @ states),
        forces=flat.reshape(len(flat), pieces, channels),
        values=averaged(slopes[rows]),
        errors=averaged(errors[rows][:, :, None])[:, 0],
        along=along,
        channels=channels_of_rows,
        blocks=blocks,
        counts=stretch.samples * counts[measured],
        spacing=float(stretch.spacing[w]),
    )


def channels_of(stretches: Sequence[RecordWindows]) -> tuple[str, ...]:
    """All channels of stretches, each once."""
    return tuple(dict.fromkeys(name for item in stretches for name in item.channels))
