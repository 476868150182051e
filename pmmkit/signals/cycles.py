"""Whole cycles of an oscillating record, and its frequency."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pmmkit.errors import DataError
from pmmkit.signals.harmonics import cycle_count, design_matrix
from pmmkit.signals.periodic import TURN
from pmmkit.signals.record import as_record

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Cycles:
    """The samples [start, stop) that span whole cycles without transient, and why.

    Attributes
    ----------
    start, stop : int
        First sample kept, and the one after the last.
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
    t: Array, theta: Array, y: Array, *, cycles: int | tuple[int, int] | None = None
) -> Cycles:
    """Whole cycles of an oscillating record, without those that are transient.

    Parameters
    ----------
    t : (n,) array
        Time, increasing [s].
    theta : (n,) array
        Phase of the motion, increasing by 2π a cycle; need not start at 0 [rad].
    y : (c, n) array
        Channels.
    cycles : int or (int, int), optional
        3 takes the third cycle only, (3, 6) the third to the sixth; counted from 1 at the start
        of the record. Default: all whole cycles that a test does not find to be transient.

    Returns
    -------
    Cycles

    Raises
    ------
    DataError
        If the record has too few whole cycles, with the numbers.
    """
    as_record(t, y)
    phase, _ = as_record(theta, y, name="theta")
    total = cycle_count(phase)
    covered = (phase[-1] - phase[0]) / TURN
    if total < 1:
        raise DataError(f"The record covers {covered:.2f} cycles; at least one is needed.")
    first, last = 0, total
    if cycles is not None:
        low, high = (cycles, cycles) if isinstance(cycles, int) else cycles
        if not 1 <= low <= high <= total:
            raise DataError(
                f"Cycles {low} to {high} were asked for; the record has {total} whole cycles "
                f"({covered:.2f} covered)."
            )
        first, last = low - 1, high
    step = float(np.median(np.diff(phase)))
    edges = np.searchsorted(phase, phase[0] + TURN * np.array([first, last]) - 0.25 * step)
    return Cycles(
        int(edges[0]),
        int(edges[1]),
        last - first,
        first,
        f"cycles {first + 1} to {last} of {total}",
    )


def estimate_frequency(t: Array, y: Array, omega: float) -> tuple[float, float]:
    """Angular frequency of the record near the nominal one, with its std [rad/s]."""
    time, values = as_record(t, y)
    middle = 0.5 * (time[0] + time[-1])
    w = float(omega)
    error = 0.0
    for _ in range(20):
        basis = design_matrix((time - middle) * w, 3)
        fitted = np.linalg.lstsq(basis, values.T, rcond=None)[0]
        n = np.arange(1, 4)
        slope = (time - middle)[:, None] * (
            (basis[:, 2::2] * -n) @ fitted[1::2] + (basis[:, 1::2] * n) @ fitted[2::2]
        )
        q, _ = np.linalg.qr(basis)
        slope = slope - q @ (q.T @ slope)
        rest = values.T - basis @ fitted
        variance = np.maximum(np.mean(rest**2, axis=0), 1e-300)
        information = float(np.sum(slope**2 / variance))
        if information <= 0:
            return float(omega), np.inf
        move = float(np.sum(slope * rest / variance)) / information
        error = information**-0.5
        w += float(np.clip(move, -0.02 * omega, 0.02 * omega))
        if abs(move) < 1e-12 * omega:
            break
    return w, error
