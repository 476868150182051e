"""The record of a sea trial, read and put in order."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import DataError, Problem
from pmmkit.intake import digits, position_jumps
from pmmkit.numerics import Array, unwrapped

if TYPE_CHECKING:
    from pmmkit.campaigns import Run

Bools = NDArray[np.bool_]

FEWEST: Final = 30
GAP: Final = 5.0
"""Steps of time above so many usual ones are gaps."""
SPIKE: Final = np.radians(8.0)
"""A single heading so far from its neighbours is one of averaging over 359° and 1°, or damage."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Record:
    """A free-running record without what cannot be used.

    `t`: increasing times of the record [s]. `x, y, psi`: position of midship [m]; heading
    without jumps of 2π [rad]. `others`: ``delta``, ``n``, ``sog``, ``wind_speed`` and so on, as
    far as they are there. `north`: whether x is north and y east. `step`: usual time between
    samples [s]. `grid`: spacing of the digits of the positions; 0 where it is finer than
    matters [m]. `notes`: what was left out or repaired.
    """

    t: Array
    x: Array
    y: Array
    psi: Array
    others: dict[str, Array]
    north: bool
    step: float
    grid: float = 0.0
    notes: tuple[str, ...] = ()


def read_record(run: Run) -> Record:
    """Read a run and put its samples in order.

    Samples without a time, a position or a heading, and repeated times, are left out; so are
    fixes that jump away and come back, and single headings far from their neighbours. A lasting
    step of the position is closed. Each is said in ``notes``.
    """
    data = run.data
    missing = [name for name in ("x", "y", "psi") if name not in data]
    if missing or run.kind != "history":
        raise DataError(
            Problem(
                message=f"a trial needs a history with position and heading; this run lacks "
                f"{', '.join(missing) or 'a history'}.",
                run=run.id,
                remedy="Name the columns lat and lon (or x and y), and psi.",
            )
        )
    columns = {
        str(name): np.asarray(data[name].values, float)
        for name in (*data.data_vars, "t")
        if data[name].dims == ("t",)
    }
    notes: list[str] = []
    good = np.logical_and.reduce([np.isfinite(columns[name]) for name in ("t", "x", "y", "psi")])
    order = np.flatnonzero(good)
    _, first = np.unique(columns["t"][order], return_index=True)
    order = order[first]
    if len(order) < len(good):
        notes.append(
            f"{len(good) - len(order)} of {len(good)} samples lack a value or repeat a time, and "
            f"are left out."
        )
    grid = digits(columns)
    columns = {name: values[order] for name, values in columns.items()}
    if len(order) < FEWEST:
        raise DataError(
            Problem(
                message=f"{len(order)} usable samples are too few for a trial; {FEWEST} are "
                f"needed.",
                run=run.id,
                remedy="Record a sample a second from a minute before the order on.",
            )
        )
    columns = _without_spikes(columns, notes)
    t = columns.pop("t")
    step = float(np.median(np.diff(t)))
    gaps = np.flatnonzero(np.diff(t) > GAP * step)
    if len(gaps):
        longest = float(np.diff(t).max())
        notes.append(
            f"{len(gaps)} gap{'s' if len(gaps) > 1 else ''} in the record, the longest "
            f"{longest:.4g} s from t = {t[int(np.argmax(np.diff(t)))]:.4g} s."
        )
    psi = _continued(t, columns.pop("psi"), step)
    x, y = columns.pop("x"), columns.pop("y")
    north = {"lat", "lon"} <= set(columns)
    return Record(
        t=t,
        x=x,
        y=y,
        psi=psi,
        others=columns,
        north=north,
        step=step,
        grid=grid,
        notes=tuple(notes),
    )


def _without_spikes(columns: dict[str, Array], notes: list[str]) -> dict[str, Array]:
    """Jumps of position left out or closed, single wrong headings left out."""
    t, x, y, psi = (columns[name] for name in ("t", "x", "y", "psi"))
    before = np.angle(np.exp(1j * (psi[1:-1] - psi[:-2])))
    after = np.angle(np.exp(1j * (psi[2:] - psi[1:-1])))
    away = np.minimum(np.abs(before), np.abs(after))
    turning = np.zeros(len(t), bool)
    turning[1:-1] = (
        (away > SPIKE)
        & (np.sign(before) != np.sign(after))
        & (np.abs(np.angle(np.exp(1j * (psi[2:] - psi[:-2])))) < 0.5 * away)
    )
    if turning.any():
        notes.append(f"{turning.sum()} single headings far from their neighbours are left out.")
    spikes, steps = position_jumps(t, x, y)
    if spikes.any():
        notes.append(f"{spikes.sum()} positions that jump away and come back are left out.")
    shift_x, shift_y = np.zeros_like(t), np.zeros_like(t)
    for index, step_x, step_y in steps:
        shift_x[int(index) :] += step_x
        shift_y[int(index) :] += step_y
    if len(steps):
        size = np.hypot(steps[:, 1], steps[:, 2])
        most = int(np.argmax(size))
        many = f"{len(steps)} times, the most " if len(steps) > 1 else ""
        notes.append(
            f"The position steps {many}by {size[most]:.3g} m at t = {t[int(steps[most, 0])]:.4g} "
            f"s; steps are closed with the velocity about them."
        )
    kept = ~(turning | spikes)
    out = {name: values[kept] for name, values in columns.items()}
    out["x"], out["y"] = (x - shift_x)[kept], (y - shift_y)[kept]
    return out


def _continued(t: Array, psi: Array, step: float) -> Array:
    """Heading without jumps of 2π; across a gap the yaw rate about it decides."""
    out = unwrapped(psi)
    for place in np.flatnonzero(np.diff(t) > GAP * step):
        sides = [slice(max(place - 10, 0), place + 1), slice(place + 1, place + 12)]
        rates = [np.polyfit(t[side], out[side], 1)[0] for side in sides if len(t[side]) > 3]
        if rates:
            expected = float(np.mean(rates)) * (t[place + 1] - t[place])
            change = out[place + 1] - out[place]
            out[place + 1 :] += 2 * np.pi * np.round((expected - change) / (2 * np.pi))
    return out
