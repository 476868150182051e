"""How well a set of effects predicts records that it was not fitted to."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.diagnosis.free_running.evidence import Basis, Point
from pmmkit.diagnosis.free_running.system import FreeSystem, Piece
from pmmkit.effects.seen import RUDDER_ZERO
from pmmkit.equations.layouts import InputField, State
from pmmkit.errors import DataError
from pmmkit.identification.filters import STEP
from pmmkit.identification.smoother import smooth
from pmmkit.numerics import Array

STARTS: Final = 4
"""Windows begin at so many places in each length of a window."""
THIN: Final = 10
"""Every so many instants of a window count for likeness."""
LOST: Final = 1e6
"""Mean square over the tolerance that a lost motion counts as."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Course:
    """A record as it is to be predicted.

    Parameters
    ----------
    truth : array (n, s)
        Smoothed states at the instants of the record.
    windows : tuple of array
        Places of the instants of each window.
    count : float
        Windows that do not overlap: the number of independent errors.
    """

    truth: Array
    windows: tuple[NDArray[np.intp], ...]
    count: float


def courses_of(system: FreeSystem, window: float, *, extrapolate: bool = False) -> list[Course]:
    """What the records of a system have to be predicted by, smoothed by their sensors.

    Parameters
    ----------
    system : FreeSystem
        Records.
    window : float
        Length of the windows [s].
    extrapolate : bool
        As for `smooth`.

    Raises
    ------
    DataError
        If fewer than two records are as long as a window.
    """
    found = []
    for piece in system.pieces:
        record = piece.record
        smoothed = smooth(
            system.model, record, sensors=system.sensors, size=0.1, extrapolate=extrapolate
        )
        t = record.t - record.t[0]
        begins = np.arange(0.0, t[-1] - window + 1e-9, window / STARTS)
        windows = tuple(
            np.flatnonzero((t >= begin - 1e-9) & (t <= begin + window + 1e-9)) for begin in begins
        )
        truth = np.stack([smoothed.motion[x] for x in piece.binding.structure.states], axis=1)
        found.append(Course(truth=truth, windows=windows, count=max(float(t[-1]) / window, 1.0)))
    if sum(bool(item.windows) for item in found) < 2:
        raise DataError(
            f"A diagnosis leaves out one record after another: give at least two that are longer "
            f"than a window of {window:g} s, or a shorter window."
        )
    return found


def off(system: FreeSystem, piece: Piece, course: Course, values: Array) -> Array:
    """Errors (n, 2) of heading [rad] and speed [m/s] at all instants of all windows."""
    record = piece.record
    moved = dict(zip(system.names, values.tolist(), strict=True))
    k = piece.binding.constants(np.array([moved[name] for name in piece.binding.names]))
    every = np.concatenate(course.windows)
    truth, first = course.truth[every], course.truth[[at[0] for at in course.windows]]
    out = np.full_like(truth, np.inf)
    if piece.functions.complete(k) == 0:
        inputs = record.inputs
        inputs[:, InputField.rudder] += moved.get(RUDDER_ZERO, 0.0)
        begins = np.cumsum([0, *(len(at) for at in course.windows)])
        piece.functions.windows(
            record.t[every],
            inputs[every],
            begins.astype(np.int64),
            first.copy(),
            k,
            STEP * system.model.ship.L / record.speed,
            out,
        )
    with np.errstate(all="ignore"):
        speed = np.hypot(out[:, State.u], out[:, State.v]) - np.hypot(
            truth[:, State.u], truth[:, State.v]
        )
        found: Array = np.stack([out[:, State.psi] - truth[:, State.psi], speed], axis=1)
    return found


def squares(system: FreeSystem, piece: Piece, course: Course, values: Array) -> Array:
    """Mean squares of the errors of heading [rad²] and speed [(m/s)²] over all windows."""
    with np.errstate(all="ignore"):
        mean = np.mean(off(system, piece, course, values) ** 2, axis=0)
    found: Array = np.nan_to_num(mean, nan=math.inf)
    return found


@dataclass(frozen=True, kw_only=True, eq=False)
class Judge:
    """Leaves out one record after another and predicts it with what the others say.

    Parameters
    ----------
    system, basis
        Records and what may move.
    courses : sequence of Course
        Of the records.
    tolerance : array (2,)
        Errors of heading [rad] and of speed over the approach that do not matter.
    wider : float
        Variance of the residuals over that of white ones.
    """

    system: FreeSystem
    basis: Basis
    courses: Sequence[Course]
    tolerance: Array
    wider: float

    def likeness(self, z: Array) -> Array:
        """Products (q, q) of what the coefficients of candidates do to the windows.

        Errors are in units of the tolerance; what the base can take over within its prior is taken
        out.
        """
        columns = []
        for piece, course in zip(self.system.pieces, self.courses, strict=True):
            if not course.windows:
                continue
            unit = self.tolerance * np.array([1.0, piece.record.speed])
            at = self.system.start + self.basis.T @ z
            here = off(self.system, piece, course, at)
            moved = [off(self.system, piece, course, at + 1e-3 * own) for own in self.basis.T.T]
            slopes = [((there - here) / unit / 1e-3)[::THIN].ravel() for there in moved]
            columns.append(np.stack(slopes, axis=1))
        G = np.nan_to_num(np.concatenate(columns), posinf=0.0, neginf=0.0)
        B, C = G[:, : self.basis.base], G[:, self.basis.base :]
        cross = B.T @ C
        found: Array = C.T @ C - cross.T @ np.linalg.solve(np.eye(B.shape[1]) + B.T @ B, cross)
        return found

    def left_out(self, here: Point, names: Sequence[str]) -> Array:
        """Mean squares (records, 2) of each record by the values that the others give."""
        used = self.basis.of(names)
        pieces, owners = self.system.pieces, here.linear.owners
        grams = np.stack([_gram(here.G[owners == j][:, used]) for j in range(len(pieces))])
        scores = np.stack(
            [here.G[owners == j][:, used].T @ here.y[owners == j] for j in range(len(pieces))]
        )
        whole, total = grams.sum(axis=0), scores.sum(axis=0)
        found = np.full((len(pieces), 2), np.nan)
        for j, (piece, course) in enumerate(zip(pieces, self.courses, strict=True)):
            if not course.windows:
                continue
            H = np.eye(len(used)) + (whole - grams[j]) / self.wider
            z = np.linalg.solve(H, (total - scores[j]) / self.wider)
            values = self.system.start + self.basis.T[:, used] @ z
            found[j] = squares(self.system, piece, course, values)
        return found

    def kept_in(self, z: Array) -> Array:
        """Mean squares (records, 2) of each record by some numbers, for all records alike."""
        values = self.system.start + self.basis.T @ z
        found = np.full((len(self.courses), 2), np.nan)
        for j, (piece, course) in enumerate(zip(self.system.pieces, self.courses, strict=True)):
            if course.windows:
                found[j] = squares(self.system, piece, course, values)
        return found

    def gain(self, without: Array, with_: Array) -> float:
        """ln of how much more probable the left-out records are with a set than without it.

        Errors are taken as normal with a variance of each record's own, one independent error of
        heading and one of speed for each length of a window; what is below the tolerance is
        counted as the tolerance.
        """
        speeds = np.array([piece.record.speed for piece in self.system.pieces])
        floor = np.stack(
            [np.full(len(speeds), self.tolerance[0]), self.tolerance[1] * speeds], axis=1
        )
        counts = np.array([course.count for course in self.courses])[:, None]
        ratio = np.log(self._over(without, floor)) - np.log(self._over(with_, floor))
        return 0.5 * float(np.nansum(counts * ratio))

    @staticmethod
    def _over(found: Array, floor: Array) -> Array:
        return np.minimum(1.0 + found / floor**2, LOST)


def _gram(G: Array) -> Array:
    found: Array = G.T @ G
    return found
