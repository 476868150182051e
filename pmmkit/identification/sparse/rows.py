"""Equations of a sparse regression: what a library of terms says of measured forces, run by run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

import numpy as np

from pmmkit.base import DataError
from pmmkit.conventions import parse_derivative
from pmmkit.effects import HULL, INERTIA
from pmmkit.equations import Conditions, Prepared, prepare
from pmmkit.identification.binding import PartValues, Place, replaced
from pmmkit.identification.forces import ForceRecord
from pmmkit.models import Model
from pmmkit.numerics import Array

WEAK_SHARE: Final = 20
"""A test function spans this part of a run where its length is not stated."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RunRows:
    """Equations of one run.

    `channels (n, m)`: by channel what each term gives per unit of its derivative, and what is
    left of the measured force without the terms, both over the standard deviation of the force.
    Rows without a finite number are left out.
    """

    run: str
    channels: Mapping[str, tuple[Array, Array]]


def check_records(records: Sequence[ForceRecord]) -> None:
    """Refuse records that cannot be used, all faults at once."""
    wrong = []
    names = [record.name for record in records]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        wrong.append(f"Several records are named {', '.join(twice)}: give each its own name.")
    for record in records:
        sizes = {len(values) for values in (*record.motion.values(), *record.forces.values())}
        if len(sizes) != 1 or 0 in sizes:
            wrong.append(
                f"Record {record.name}: motion and forces must have the same number of samples, "
                f"at least one; they have {', '.join(map(str, sorted(sizes))) or 'none'}."
            )
        bad = [
            c
            for c, std in record.std.items()
            if not np.all(np.isfinite(std) & (np.asarray(std) > 0))
        ]
        if bad:
            wrong.append(
                f"Record {record.name}: the standard deviation of {', '.join(bad)} must be "
                f"positive. Take the scatter of the gauge where nothing better is known."
            )
    if wrong:
        raise DataError(wrong, title="Records not usable")


def measured(record: ForceRecord) -> tuple[str, ...]:
    """Channels of a record that have a finite force and its standard deviation."""
    return tuple(
        channel
        for channel, values in record.forces.items()
        if channel in record.std and np.isfinite(values).any()
    )


def homes(model: Model, names: Sequence[str]) -> tuple[Place, ...]:
    """The part of a model in which each derivative stands, or would stand."""
    found = []
    for name in names:
        there = [own for own, part in model.derivative_parts.items() if name in part.values]
        factors = parse_derivative(name).factors
        new = INERTIA if any(f.endswith("dot") for f in factors) else HULL
        found.append((there[0] if there else new, name))
    return tuple(found)


def emptied(model: Model, at: Sequence[Place]) -> Model:
    """The model with the derivatives at these places zero, added where they were not there."""
    made = model
    wanted = {name for _, name in at}
    for effect in dict.fromkeys((*model.derivative_parts, *(part for part, _ in at))):
        own = {name for part, name in at if part == effect}
        if effect in model.parts:
            own |= wanted & set(model.parts[effect].values)
        if own:
            made = made.with_values(effect, **dict.fromkeys(sorted(own), 0.0))
    return made


def equations(
    model: Model,
    records: Sequence[ForceRecord],
    names: Sequence[str],
    channels: Sequence[str],
    *,
    weak: bool | int = False,
    extrapolate: bool = False,
) -> list[RunRows]:
    """Design and target of every run.

    Forces are linear in derivatives, so the column of a term is what the equations of motion give
    for its derivative at one less what they give for it at zero: the regression sees the term as
    the simulator does, with its non-dimensional system, the depth, and the Coriolis terms that an
    added mass brings to other channels.
    """
    at = homes(model, names)
    blank = emptied(model, at)
    constants: dict[tuple[float, Conditions], list[Prepared]] = {}
    rows = []
    for record in records:
        key = (record.speed, record.conditions)
        if key not in constants:
            numbers = blank.values_at(record.speed, extrapolate=extrapolate)
            constants[key] = _constants(blank, numbers, at, record)
        base, *ones = (item.water_forces(record.motion) for item in constants[key])
        own = {}
        for channel in channels:
            if channel not in measured(record):
                continue
            force = np.asarray(record.forces[channel], float)
            design = np.stack([one[channel] - base[channel] for one in ones], axis=1)
            spread = np.reshape(record.std[channel], (-1, 1))
            both = np.column_stack([design, force - base[channel]]) / spread
            if weak is not False:
                length = -(-len(both) // WEAK_SHARE) if weak is True else weak
                both = averaged(both, length)
            kept = both[np.isfinite(both).all(axis=1)]
            own[channel] = (kept[:, :-1], kept[:, -1])
        rows.append(RunRows(run=record.name, channels=MappingProxyType(own)))
    return rows


def _constants(
    blank: Model, numbers: PartValues, at: Sequence[Place], record: ForceRecord
) -> list[Prepared]:
    """The equations without the terms, and with each of them at one."""
    one = np.ones(1)
    return [
        prepare(blank, record.speed, values=values, conditions=record.conditions, heeled=True)
        for values in (numbers, *(replaced(numbers, [place], one) for place in at))
    ]


def averaged(rows: Array, length: int) -> Array:
    """Multiply the columns with test functions of compact support and sum over time.

    The test functions are bumps (1 - s²)² of `length` samples that overlap by half, each of unit
    length as a vector: white noise keeps its standard deviation, while what varies slowly grows
    by about the square root of 0.7 `length`. The map is linear and the same for design
    and target, so exact equations stay exact however strongly a bump smooths the motion. A gap
    takes with it the test functions that touch it.

    rows (n, c).

    Examples
    --------
    >>> averaged(np.ones((9, 1)), 5).round(3).ravel()
    array([2.047, 2.047, 2.047])
    """
    width = max(1, min(length, len(rows)))
    s = (2 * np.arange(width) - (width - 1)) / (width + 1)
    bump = (1 - s**2) ** 2
    bump /= np.linalg.norm(bump)
    last = len(rows) - width
    starts = np.unique([*range(0, last, max(1, width // 2)), last])
    views = np.lib.stride_tricks.sliding_window_view(rows, width, axis=0)[starts]
    return np.asarray(views @ bump)
