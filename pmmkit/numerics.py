"""Small numerical tools that several rooms share."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray
from threadpoolctl import threadpool_limits

Array = NDArray[np.float64]

ABSURD = 1e30
"""Numbers beyond this are taken for damage."""
WELL = 1e-6
"""Reciprocal condition of the normal equations from which they lose nothing that matters."""


def rms(values: ArrayLike) -> float:
    """Root mean square of what is known; NaN where nothing is, infinite where a square is.

    Examples
    --------
    >>> rms([1.0, -7.0, float("nan")])
    5.0
    """
    known = np.asarray(values, dtype=float)
    known = known[np.isfinite(known)]
    with np.errstate(over="ignore"):
        return float(np.sqrt(np.mean(np.square(known)))) if known.size else float("nan")


def stretches(flags: NDArray[np.bool_]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Where stretches that are true begin, and the first place after each.

    Examples
    --------
    >>> starts, stops = stretches(np.array([True, False, True, True]))
    >>> starts.tolist(), stops.tolist()
    ([0, 2], [1, 4])
    """
    edges = np.flatnonzero(np.diff(np.concatenate(([0], flags.astype(np.int8), [0]))))
    return edges[::2], edges[1::2]


def coverage_factor(dof: ArrayLike, confidence: float = 0.95) -> Array:
    """Half width of an interval over the standard uncertainty, by Student's t (JCGM 100:2008, G.3).

    Examples
    --------
    >>> coverage_factor([1.0, 10.0, np.inf]).round(2)
    array([12.71,  2.23,  1.96])
    """
    from scipy.special import stdtrit

    freedom = np.where(np.isinf(dof), 1e9, dof)  # known: within 1e-9 of the normal
    return np.asarray(stdtrit(freedom, (1 + confidence) / 2), dtype=np.float64)


def projector(basis: Array, gram: Array | None = None) -> Array:
    """The least-squares map from samples to the coefficients of a basis.

    The normal equations serve where the basis is close to orthogonal (Fourier series over whole
    cycles), which is many times faster than a factorisation of a long record; otherwise singular
    values of columns scaled to one length.

    basis (n, m); gram (m, m).

    Examples
    --------
    >>> t = np.arange(8) * (np.pi / 4)
    >>> basis = np.stack([np.ones(8), np.sin(t)], axis=1)
    >>> np.round(projector(basis) @ (1 + 2 * np.sin(t)), 12)
    array([1., 2.])
    """
    well = _scaled(basis.T @ basis if gram is None else gram)
    if well is not None:
        unit, scale = well
        return (np.linalg.inv(unit) / scale / scale[:, None]) @ basis.T
    length = _lengths(basis)
    return np.asarray(np.linalg.pinv(basis / length) / length[:, None], dtype=np.float64)


def coefficients(basis: Array, rows: Array, gram: Array | None = None) -> Array:
    """Least-squares coefficients of each row of samples on a basis.

    basis (n, m); rows (c, n); gram (m, m).

    Examples
    --------
    >>> basis = np.stack([np.ones(4), np.arange(4.0)], axis=1)
    >>> coefficients(basis, np.array([[1.0, 3.0, 5.0, 7.0]]))
    array([[1., 2.]])
    """
    well = _scaled(basis.T @ basis if gram is None else gram)
    if well is not None:
        unit, scale = well
        return np.linalg.solve(unit, (rows @ basis / scale).T).T / scale
    length = _lengths(basis)
    found = np.linalg.lstsq(basis / length, rows.T, rcond=None)[0].T / length
    return np.asarray(found, dtype=np.float64)


def _lengths(basis: Array) -> Array:
    """Lengths of the columns (m,), one of a column of zeros."""
    length = np.linalg.norm(basis, axis=0)
    return np.where(length > 0, length, 1.0)


def _scaled(gram: Array) -> tuple[Array, Array] | None:
    """Scaled normal matrix and the columns' lengths; None where it is ill-conditioned."""
    scale = np.sqrt(np.diagonal(gram))
    if not np.all(scale > 0):
        return None
    unit = gram / np.outer(scale, scale)
    values = np.linalg.eigvalsh(unit)
    return (unit, scale) if values[0] > WELL * values[-1] else None


def root_of(covariance: Array) -> Array:
    """A lower root of a covariance whose numbers may differ by orders of magnitude.

    Examples
    --------
    >>> root_of(np.array([[4.0, 2e-6], [2e-6, 2e-12]])).round(7)
    array([[2.e+00, 0.e+00],
           [1.e-06, 1.e-06]])
    """
    scale = np.sqrt(np.diagonal(covariance))
    root: Array = scale[:, None] * np.linalg.cholesky(covariance / np.outer(scale, scale))
    return root


def precision_over(covariance: Array, scale: Array) -> Array:
    """Inverse of a covariance (m, m) of numbers that are counted in units `scale` (m,).

    Examples
    --------
    >>> precision_over(np.diag([4e-12, 9.0]), np.array([1e-6, 3.0]))
    array([[0.25, 0.  ],
           [0.  , 1.  ]])
    """
    return np.linalg.inv(covariance / np.outer(scale, scale)).astype(float)


def unwrapped(psi: Array) -> Array:
    """An angle without jumps of 2π [rad]; what is not known stays NaN and is passed over.

    Examples
    --------
    >>> unwrapped(np.radians([350.0, np.nan, 10.0, 30.0])) * 180.0 / np.pi
    array([350.,  nan, 370., 390.])
    """
    there = np.isfinite(psi)
    found: Array = np.array(psi, float)
    found[there] = np.unwrap(found[there])
    return found


_FINEST: Final = 1e-12
"""Resolution of binary numbers over the largest of them: what is left of sums of harmonics."""
_DECIMAL_PLACES: Final = 12


def resolution(values: ArrayLike) -> Array:
    """The decimal step of which all numbers of each channel are multiples.

    values (c, n).

    Examples
    --------
    >>> resolution([[0.25, 1.5, -0.75], [1 / 3, 0.1, 2.0]])
    array([1.e-02, 2.e-12])
    """
    x = np.asarray(values, float)
    largest = np.max(np.abs(x), axis=1)
    found = _FINEST * np.where(largest > 0, largest, 1.0)
    open_ = np.ones(len(x), bool)
    for decimals in range(_DECIMAL_PLACES + 1):
        step = 10.0**-decimals
        steps = x / step
        # A decimal number is stored to the last bit, not exactly.
        near = np.abs(steps - np.rint(steps)) <= 4 * np.finfo(float).eps * np.abs(steps)
        whole = open_ & near.all(axis=1) & (step > found)
        found[whole], open_[whole] = step, False
    return found


def last_digits(values: Array) -> Array:
    """What the last digit of each number is worth: as many decimals in all, or as many digits.

    values (n,), finite. 0 where numbers have more than six digits.

    Examples
    --------
    >>> last_digits(np.array([1.5, 20.25, 300.75])), last_digits(np.array([2.55e3, 9.85, 0.0125]))
    (array([0.01, 0.01, 0.01]), array([1.e+01, 1.e-02, 1.e-04]))
    """
    size = np.abs(values)
    largest = float(size.max(initial=0.0))
    if not largest:
        return np.zeros(len(values))
    (decimal,) = resolution(values[None])
    powers = 10.0 ** np.floor(np.log10(np.where(size > 0, size, largest)))
    for digits in range(_MOST_DIGITS):
        own: Array = powers / 10.0**digits
        if np.max(np.abs(values / own - np.rint(values / own))) < _WHOLE:
            # Fewer digits in all count: 0, 1 … 100 have no decimals, and two digits but for 100.
            if np.mean(np.log10(own)) > math.log10(decimal):
                return own
            break
    coarse = decimal > largest * 10.0**-_MOST_DIGITS
    return np.full(len(values), decimal if coarse else 0.0)


_MOST_DIGITS: Final = 6
_WHOLE: Final = 1e-6
"""What binary numbers may miss whole multiples of their last digit by."""


_FEWEST_STAMPS: Final = 16
_DECIMALS: Final = 0.6
_DIGITS: Final = 1.0
"""What stamps may miss the clock by, over the worth of their last digit. Rounded ones miss by half
of it; those of MARIN's turns of the KVLCC2, with three digits, by 0.5 to 0.8."""
_ROUNDING: Final = 0.5 + 1e-6
"""What rounding alone makes stamps miss their clock by, over the worth of their last digit."""
_OFTEN: Final = 0.1
"""Share of steps that are nought, at least: a row that was written twice tells no rounding."""


def even_clock(times: Array) -> Array | None:
    """The even clock of stamps some of which stand twice, since they have too few digits.

    times (n,). None where none stand twice, and where no even clock agrees with them to their last
    digit: of numbers as 1.22E+02, or of as many decimals each.

    Examples
    --------
    >>> np.diff(even_clock(np.round(np.arange(200) / 8, 0))).round(3)[:3]
    array([0.125, 0.125, 0.125])
    >>> even_clock(np.arange(40) / 10) is None
    True
    """
    steps = np.diff(times)
    if len(times) < _FEWEST_STAMPS or not np.all(np.isfinite(times)) or steps.min() < 0:
        return None
    if np.mean(steps == 0) < _OFTEN or not steps.any():
        return None
    finest = float(steps[steps > 0].min())
    lines = np.stack([np.ones(len(times)), np.arange(len(times))], axis=1)
    coarse = np.maximum(last_digits(times), 1e-3 * finest)
    for last, within in ((np.full(len(times), finest), _DECIMALS), (coarse, _DIGITS)):
        clock: Array = lines @ np.linalg.lstsq(lines / last[:, None], times / last, rcond=None)[0]
        if np.max(np.abs(times - clock) / last) < within:
            return clock
    # Least squares miss a clock whose stamps were all rounded to one side over a stretch.
    clock, miss = _nearest_clock(times, coarse)
    return clock if miss < _ROUNDING else None


def _nearest_clock(times: Array, last: Array) -> tuple[Array, float]:
    """The even clock that misses no stamp by more than it must, over the worth of its last digit,
    and by how much."""
    from scipy.optimize import linprog

    lines = np.stack([np.ones(len(times)), np.arange(len(times))], axis=1) / last[:, None]
    most = -np.ones((len(times), 1))
    found = linprog(
        [0.0, 0.0, 1.0],
        A_ub=np.block([[lines, most], [-lines, most]]),
        b_ub=np.concatenate([times / last, -times / last]),
        bounds=[(None, None), (None, None), (0.0, None)],
    )
    if not found.success:
        return times, math.inf
    clock: Array = last * (lines @ found.x[:2])
    return clock, float(np.max(np.abs(times - clock) / last))


def dead_reckoned(
    t: Array, velocity: Sequence[Array], rate: Array | None = None, psi: Array | None = None
) -> tuple[Array, Array, Array]:
    """Place and heading from the velocity along the ship and to starboard, by trapezoids.

    t [s]; velocity: u and v [m/s]; rate of turn [rad/s], asked where there is no heading [rad].

    Examples
    --------
    >>> t = np.linspace(0.0, 5.0, 1001)
    >>> x, y, psi = dead_reckoned(t, (0 * t + 2.0, 0 * t), rate=0 * t + np.pi / 10)
    >>> [round(float(end[-1]), 3) for end in (x, y, psi)]
    [6.366, 6.366, 1.571]
    """
    from scipy.integrate import cumulative_trapezoid

    if psi is None:
        psi = cumulative_trapezoid(np.zeros(len(t)) if rate is None else rate, t, initial=0.0)
    u, v = velocity
    north, east = u * np.cos(psi) - v * np.sin(psi), u * np.sin(psi) + v * np.cos(psi)
    x: Array = cumulative_trapezoid(north, t, initial=0.0)
    y: Array = cumulative_trapezoid(east, t, initial=0.0)
    return x, y, psi


def turned(psi: Array) -> Array:
    """Change of heading in the sense of the turn as a whole, never going back [rad].

    Examples
    --------
    >>> turned(np.array([0.1, 0.2, 0.5, 0.4, 1.0])).round(1).tolist()
    [0.0, 0.1, 0.4, 0.4, 0.9]
    """
    change = np.unwrap(psi) - psi[0]
    found: Array = np.maximum.accumulate(change * (1.0 if change[-1] >= 0 else -1.0))
    return found


@contextmanager
def one_thread() -> Iterator[None]:
    """Linear algebra by one thread for a while, whatever the process takes else: the last digits of
    a result hang on their number.

    Examples
    --------
    >>> with one_thread():
    ...     bool(np.linalg.det(np.eye(2)) == 1.0)
    True
    """
    with threadpool_limits(1):
        yield
