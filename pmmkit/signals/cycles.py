"""Whole cycles of an oscillating record, without those that are transient."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pmmkit.base import DataError, Remedy, Way
from pmmkit.numerics import Array
from pmmkit.signals.fourier import (
    CycleSums,
    FourierBasis,
    basis_of,
    cycle_count,
    cycle_edges,
    design_matrix,
)
from pmmkit.signals.noise import as_record
from pmmkit.signals.periodic import TURN, fit_noise, phase_cells, weighted_covariance

Ints = NDArray[np.intp]

COMPARED: Final = 3
"""Highest harmonic whose change from cycle to cycle is looked at."""
REMOVED: Final = 5
"""Highest harmonic taken out before the noise is judged."""
CHANCE: Final = 0.01
"""Chance at which a cycle of a steady record is called transient."""
NEGLIGIBLE: Final = 1e-6
"""Changes below this fraction of a channel's fluctuation are of no interest."""


@dataclass(frozen=True)
class Cycles:
    """The samples [start, stop) that span whole cycles, and why these.

    Attributes
    ----------
    start, stop : int
        First sample kept, and the one after the last; the sample that would close the last cycle
        is not among them.
    count : int
        Whole cycles kept.
    first : int
        Index of the first cycle kept; 0 is the one that starts with the record.
    reason : str
        A sentence for a person.
    """

    start: int
    stop: int
    count: int
    first: int
    reason: str


def whole_cycles(
    t: ArrayLike,
    theta: ArrayLike | FourierBasis,
    y: ArrayLike,
    *,
    cycles: int | tuple[int, int] | None = None,
    sums: CycleSums | None = None,
) -> Cycles:
    """Whole cycles of an oscillating record, without those that are transient.

    Parameters
    ----------
    t : (n,) array
        Time, increasing [s].
    theta : (n,) array or FourierBasis
        Phase of the motion, increasing by 2π a cycle; steps may differ, and it need not start
        at 0 [rad]. A basis that is there already saves its computation.
    y : (c, n) array
        Channels.
    cycles : int or (int, int), optional
        3 takes the third cycle only, (3, 6) the third to the sixth, counted from 1 at the start
        of the record. Default: all whole cycles that are not found to be transient.
    sums : CycleSums, optional
        Over all whole cycles of the record, of harmonics 0 to 5 or above, where they are there
        already.

    Returns
    -------
    Cycles

    Raises
    ------
    DataError
        If the record has too few whole cycles, with the numbers, or is damaged.

    Notes
    -----
    Harmonics 0 to 3 of the first cycle are compared with the mean of those of the later ones by
    Hotelling's statistic; the covariance is that of the autocorrelated noise found between the
    harmonics of the last two thirds of the cycles. A cycle that differs in any channel is left
    out and the next one is tried; then the last cycle is tested in the same way. At least one
    is kept.

    Examples
    --------
    >>> import numpy as np
    >>> t = np.arange(0.0, 50.0, 0.1)
    >>> theta = 2 * np.pi * t / 10.0
    >>> noise = 0.01 * np.random.default_rng(4).normal(size=t.size)
    >>> kept = whole_cycles(t, theta, np.cos(theta) + noise + np.exp(-t / 3.0))
    >>> kept.first, kept.count, kept.start
    (2, 3, 200)
    >>> whole_cycles(t, theta, np.cos(theta), cycles=3).reason
    'took cycle 3 of 5, as asked'
    """
    time, values = as_record(t, y)
    given = theta.phase if isinstance(theta, FourierBasis) else theta
    phase, values = as_record(given, values, name="theta")
    total = cycle_count(phase)
    covered = (phase[-1] - phase[0]) / TURN
    if total < 1:
        raise DataError(
            f"The record covers {covered:.2f} cycles ({time[-1] - time[0]:.4g} s): "
            "at least one whole cycle is needed."
        )
    edges = cycle_edges(phase, total)
    if cycles is not None:
        first, last = _asked(cycles, total, covered)
        reason = f"took {_cycles(first, last)} of {total}, as asked"
    else:
        if np.diff(edges).min() < 2 * REMOVED + 2:
            raise DataError(
                f"A cycle has only {np.diff(edges).min()} samples: at least {2 * REMOVED + 2} "
                "are needed to compare cycles.",
                remedy=_ASKED,
            )
        basis = basis_of(phase, theta, REMOVED)
        known = sums or CycleSums.of(values, basis.rows, edges)
        first, last = _settled(basis, values, known.up_to(REMOVED))
        reason = _reason(first, last, total, covered)
    return Cycles(int(edges[first]), int(edges[last]), last - first, first, reason)


_ASKED: Final = Remedy(
    "Reduce with {}, which takes these cycles as they are, or leave the run out.",
    (Way("cycles=(2, 3)", "--cycles 2-3"),),
)


def _asked(cycles: int | tuple[int, int], total: int, covered: float) -> tuple[int, int]:
    low, high = (cycles, cycles) if isinstance(cycles, int) else cycles
    if not 1 <= low <= high:
        raise DataError(f"Cycles {low} to {high} were asked for: count from 1, first to last.")
    if high > total:
        raise DataError(
            f"{_cycles(low - 1, high).capitalize()} asked for, but the record has {total} whole "
            f"({covered:.2f} covered). Ask for cycles up to {total}."
        )
    return low - 1, high


def _cycles(first: int, last: int) -> str:
    return f"cycle {last}" if last == first + 1 else f"cycles {first + 1} to {last}"


def _reason(first: int, last: int, total: int, covered: float) -> str:
    parts = []
    if first > 0:
        parts.append(f"{_cycles(0, first)} (transient)")
    if last < total:
        parts.append(f"{_cycles(last, total)} (changed at the end)")
    if covered - total > 0.02:
        parts.append(f"the last {covered - total:.2f} of a cycle (incomplete)")
    if not parts:
        return f"kept all {total} cycles" if total > 1 else "kept the only cycle"
    return f"kept {_cycles(first, last)} of {total}; left out {' and '.join(parts)}"


def _settled(basis: FourierBasis, values: Array, sums: CycleSums) -> tuple[int, int]:
    """The cycles [first, last) that agree with one another."""
    record = _Record(basis, values, sums)
    single = sums.single[:, :, : 2 * COMPARED + 1]
    last = len(single)
    first = _first_settled(record, single)
    if last - first >= 3:
        before = np.arange(first, last - 1)
        noise = _noise(record, first, last - 1, last - first)
        if _differs(single[last - 1], single[before], noise, after=False):
            last -= 1
            first = _first_settled(record, single[:last])
    return first, last


@dataclass(frozen=True)
class _Record:
    """Channels (c, n) with the Fourier basis at their samples and the sums over their cycles."""

    basis: FourierBasis
    values: Array
    sums: CycleSums


@dataclass(frozen=True)
class _Noise:
    gamma: Array
    dof: Array
    floor: Array
    a_cycle: int
    chance: float


def _first_settled(record: _Record, single: Array) -> int:
    last = len(single)
    half = last - max(2, math.ceil(2 * last / 3))
    noise = None
    for first in range(last - 1):
        if noise is None or first + 1 > half:
            noise = _noise(record, max(half, first + 1), last, last - first)
        if not _differs(single[first], single[first + 1 :], noise, after=True):
            return first
    return last - 1


def _noise(record: _Record, first: int, last: int, longest: int) -> _Noise:
    """Noise of the cycles [first, last), with autocovariances over `longest` cycles."""
    count = last - first
    part = slice(record.sums.edges[first], record.sums.edges[last])
    inside = record.values[:, part]
    rest = inside - record.sums.together(first, last) @ record.basis.rows[:, part]
    start, a_cycle = phase_cells(record.basis.phase[part], count)
    cells = np.add.reduceat(rest, start, axis=-1) / np.diff(start, append=rest.shape[-1])
    cells = cells[:, : a_cycle * count]
    cells = np.pad(cells, ((0, 0), (0, a_cycle * count - cells.shape[-1])))
    swing = np.sqrt(np.mean((inside - inside.mean(axis=-1, keepdims=True)) ** 2, axis=-1))
    floor = NEGLIGIBLE * swing + 1e-12 * np.max(np.abs(inside), axis=-1) + 1e-150
    size = np.sqrt(np.mean(cells**2, axis=-1))
    quiet = size <= floor
    sign = np.where(np.arange(cells.shape[-1]) % 2, 1.0, -1.0)
    unit = np.where(quiet[:, None], sign, cells / np.maximum(size, floor)[:, None])
    gamma, dof = fit_noise(unit, count, REMOVED, longest * a_cycle)
    scale = np.where(quiet, 0.0, size)
    chance = CHANCE if count > 1 else CHANCE / 10.0
    return _Noise(scale[:, None] ** 2 * gamma, dof, floor, a_cycle, chance)


def _differs(one: Array, others: Array, noise: _Noise, *, after: bool) -> bool:
    """Whether one cycle's harmonics (c, p) differ from those of the others (k, c, p)."""
    from scipy.special import fdtrc

    p = one.shape[-1]
    many = others.shape[0]
    phase = TURN * (np.arange(noise.a_cycle) + 0.5) / noise.a_cycle
    own = design_matrix(phase, COMPARED).T * (2.0 / noise.a_cycle)
    own[0] *= 0.5
    parts = [own] + [-own / many] * many
    weights = np.concatenate(parts if after else parts[::-1], axis=-1)
    covariance = weighted_covariance(weights, noise.gamma[:, : weights.shape[-1]])
    covariance = covariance + noise.floor[:, None, None] ** 2 * np.eye(p)
    change = one - others.mean(axis=0)
    dof = np.maximum(noise.dof, 0.2)
    steady = fdtrc(1, dof[:, 0], change[:, 0] ** 2 / covariance[:, 0, 0])
    swing = change[:, 1:, None]
    statistic = np.sum(swing * np.linalg.solve(covariance[:, 1:, 1:], swing), axis=(1, 2))
    pooled = COMPARED / np.sum(1.0 / dof[:, 1 : COMPARED + 1], axis=-1)
    waving = fdtrc(p - 1, pooled, statistic / (p - 1))
    return bool(np.minimum(steady, waving).min() < noise.chance / (2 * one.shape[0]))
