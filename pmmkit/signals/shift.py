"""Channels that are late, or early, by whole samples from some sample on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from pmmkit.numerics import Array, coefficients, projector
from pmmkit.signals.fourier import FourierBasis, Ints, basis_of, cycle_count, cycle_edges
from pmmkit.signals.noise import as_record
from pmmkit.signals.periodic import fit_noise, phase_cells, weighted_covariance

MOST: Final = 3
"""Samples by which a channel may be late or early."""
ORDER: Final = 5
"""Highest harmonic of the wave that is shifted."""
COMPARED: Final = 3
"""Highest harmonic that may not change but by the shift."""
CYCLES: Final = 3
"""Whole cycles that a record needs: one on each side of the shift, and one to look for it."""
A_CYCLE: Final = 16
"""Samples of a cycle, at least."""
CERTAIN: Final = 36.0
"""Squared size of a shift over its variance from which it is certain. By the study
`scripts.studies.late_channels` none of 1600 sound records reaches it and has nothing else against
it, of 14,400 that change otherwise 38, most of them with a phase that swings by itself."""
SUSPECT: Final = 16.0
"""And from which the exact wave is tried, as its tangent tells large shifts badly."""
QUICK: Final = 9.0
"""And from which its noise is asked for closely, by the variance that noise would give it whose
neighbours alone are alike: a certain shift may have four times less."""
SIGMAS: Final = 2.6
"""Standard deviations that half a sample must have, for the number of samples to be known."""
CHANCE: Final = 0.01
"""Chance at which something else than the shift is found to change where nothing does."""
SHARE: Final = 0.1
"""Parts of a sample, and of the shift's own effect, below which other changes are none."""
NEGLIGIBLE: Final = 1e-9
"""Noise over what a sample adds below which there is none, as of a computation."""
BLOCKS: Final = 12
"""Parts of a record, whole cycles in a short one, that are held against each other."""


@dataclass(frozen=True)
class Shift:
    """Samples by which a channel is late from some sample on.

    Attributes
    ----------
    samples : int
        Whole samples; negative where the channel is early.
    start : int
        The first sample that is shifted.
    sigmas : float
        The shift over its standard uncertainty.
    """

    samples: int
    start: int
    sigmas: float


def shifts_within(theta: ArrayLike | FourierBasis, y: ArrayLike) -> tuple[Shift | None, ...]:
    """By how many samples each channel is late or early from some sample on.

    Parameters
    ----------
    theta : (n,) array or FourierBasis
        Phase of the motion, increasing by 2π a cycle; steps may differ [rad].
    y : (c, n) array
        Channels.

    Returns
    -------
    tuple of Shift or None
        Of each channel; None where its wave stays in step with the motion, where it changes in
        another way (in size, in form, little by little, by parts of a sample), and where noise,
        too few cycles or too few samples hide what there may be.

    Raises
    ------
    DataError
        If values are not finite or the phase does not increase.

    Notes
    -----
    The wave of the record is fitted by its harmonics. A shift from some sample on adds their
    slope from there on, by which the record is regressed for each place between the first and the
    last cycle; the variance is that of noise with the autocovariances found between the harmonics.
    Where that is certain, the wave itself is shifted by 1 to 3 samples either way; the place and
    the number that leave least are taken. A step of the harmonics, or a shift that grows, beside
    the whole samples refutes them. What is late throughout shows in no record alone: it is a phase
    like that of damping and added mass.

    Examples
    --------
    >>> import numpy as np
    >>> theta = 2 * np.pi * np.arange(600) / 100
    >>> wave = np.cos(theta) + 0.2 * np.sin(3 * theta)
    >>> wave += 0.01 * np.random.default_rng(0).normal(size=wave.size)
    >>> late = np.append(wave[:300], wave[298:-2])
    >>> none, found = shifts_within(theta, [wave, late])
    >>> none, found.samples, abs(found.start - 300) < 3
    (None, 2, True)
    """
    given = theta.phase if isinstance(theta, FourierBasis) else theta
    phase, values = as_record(given, y, name="theta")
    count = cycle_count(phase)
    edges = cycle_edges(phase, max(count, 1))
    if count < CYCLES or np.diff(edges).min() < A_CYCLE:
        return (None,) * len(values)
    whole = slice(int(edges[-1]))
    record = _Record.of(basis_of(phase, theta, ORDER).within(whole), count)
    return tuple(_shift(record, own) for own in values[:, whole])


@dataclass(frozen=True, kw_only=True, eq=False)
class _Record:
    """Whole cycles, and the equal stretches of phase over which noise is judged.

    `basis`: harmonics of the motion at the samples. `step (n,)`: phase of a sample. `starts (m,)`:
    first sample of each stretch, of which a cycle has `a_cycle`. `places`: the stretches from which
    a shift may begin.
    """

    basis: FourierBasis
    step: Array
    count: int
    starts: Ints
    a_cycle: int
    places: Ints

    @classmethod
    def of(cls, basis: FourierBasis, count: int) -> _Record:
        starts, a_cycle = phase_cells(basis.phase, count)
        places = np.arange(a_cycle, starts.size - a_cycle, max(1, a_cycle // 12))
        step = np.gradient(basis.phase)
        return cls(
            basis=basis, step=step, count=count, starts=starts, a_cycle=a_cycle, places=places
        )

    def means(self, rows: Array) -> Array:
        """Of each stretch."""
        width = np.diff(self.starts, append=self.step.size)
        return np.asarray(np.add.reduceat(rows, self.starts, axis=-1) / width)

    def late(self, samples: int) -> Array:
        """The harmonics that a channel shows that is late by some samples."""
        at = np.arange(self.step.size) - samples
        inside = np.clip(at, 0, at.size - 1)
        phase = self.basis.phase[inside] + (at - inside) * self.step[inside]
        return FourierBasis.at(phase, ORDER).rows


@dataclass(frozen=True, kw_only=True, eq=False)
class _Look:
    """What regressions of a channel beside its harmonics tell.

    `rest (m,)`: what the harmonics leave, as means of the stretches. `slope (m,)`: what a sample
    adds by which the channel is late. `rows, frame (p, m)`: the harmonics, and orthonormal ones.
    """

    rest: Array
    slope: Array
    rows: Array
    frame: Array

    @classmethod
    def at(cls, record: _Record, basis: Array, values: Array) -> _Look:
        """Of the values, by harmonics (p, n) at the samples."""
        rows = record.means(basis)
        means = record.means(values)
        (found,) = coefficients(rows.T, means[None])
        n = np.arange(1, ORDER + 1)
        turned = np.zeros_like(found)
        turned[1::2], turned[2::2] = -n * found[2::2], n * found[1::2]
        slope = record.means(record.step * (turned @ basis))
        frame = np.linalg.qr(rows.T)[0].T
        return cls(rest=means - found @ rows, slope=slope, rows=rows, frame=frame)

    def beside(self, columns: Array) -> Array:
        """Columns (k, m) less what the harmonics hold of them."""
        return np.asarray(columns - (columns @ self.frame.T) @ self.frame)

    def from_(self, places: Ints) -> Array:
        """What a sample adds from each place on, beside the harmonics."""
        return self.beside(self.slope * (np.arange(self.slope.size) >= places[:, None]))

    def noise(self, record: _Record, columns: Array) -> Array:
        """Autocovariances (m,) of what the harmonics and some columns (k, m) leave."""
        left = self.rest - columns.T @ np.linalg.lstsq(columns.T, self.rest)[0]
        m, whole = left.size, record.a_cycle * record.count
        cells = np.pad(left[:whole], (0, max(whole - m, 0)))
        size = float(np.sqrt(np.mean(cells**2)))
        floor = NEGLIGIBLE * float(np.abs(self.slope).max()) + 1e-150
        if size <= floor:
            return np.asarray(floor**2 * np.eye(1, m)[0])
        gamma, _ = fit_noise(cells[None] / size, record.count, ORDER, m)
        return np.asarray(size**2 * gamma[0])


def _suspect(record: _Record, values: Array) -> tuple[int, int] | None:
    """To which side a channel may be shifted, and from where."""
    look = _Look.at(record, record.basis.rows, values)
    columns = look.from_(record.places)
    power = np.maximum(np.vecdot(columns, columns), 1e-300)
    sizes = columns @ look.rest / power
    best = int(np.argmax(sizes**2 * power))
    size, column = float(sizes[best]), columns[best : best + 1]
    left = look.rest - size * column[0]
    square = float(left @ left)
    alike = float(np.clip(left[1:] @ left[:-1] / max(square, 1e-300), 0.0, 0.95))
    variance = square / left.size * (1 + alike) / (1 - alike) / power[best]
    # Most records end here: to ask for all autocovariances of their noise takes longest.
    if abs(size) < 0.5 or size**2 < QUICK * variance:
        return None
    _, ((variance,),) = _sizes(column, look.rest, look.noise(record, column))
    if size**2 < SUSPECT * variance:
        return None
    return int(np.sign(size)), int(record.starts[record.places[best]])


def _shift(record: _Record, values: Array) -> Shift | None:
    """The shift that leaves least of a channel, where one is certain."""
    asked = _suspect(record, values)
    if asked is None:
        return None
    side, start = asked
    _, samples, start = min(_exact(record, values, side * k, start) for k in range(1, MOST + 1))
    return _judged(record, values, samples, start)


def _exact(record: _Record, values: Array, samples: int, start: int) -> tuple[float, int, int]:
    """What the wave leaves that is shifted by so many samples, and from where it leaves least."""
    before, after = record.basis.rows, record.late(samples)
    first, last = (int(record.starts[record.places[k]]) for k in (0, -1))
    left = 0.0
    for _ in range(2):
        rows = np.where(np.arange(values.size) >= start, after, before)
        (found,) = coefficients(rows.T, values[None])
        early, late = (values - found @ before) ** 2, (values - found @ after) ** 2
        gained = np.cumsum(early - late)  # by what comes before it being in step
        start = first + int(np.argmin(gained[first - 1 : last - 1]))
        left = float(late.sum() + gained[start - 1])
    return left, samples, start


def _judged(record: _Record, values: Array, samples: int, start: int) -> Shift | None:
    """The shift where it is certain, and where nothing beside it changes."""
    shifted = np.arange(values.size) >= start
    look = _Look.at(record, np.where(shifted, record.late(samples), record.basis.rows), values)
    cells = np.arange(look.slope.size)
    after = cells >= np.searchsorted(record.starts, start)
    step = look.beside((look.slope * after)[None])
    form = _without(look.beside(look.rows[1 : 2 * COMPARED + 1] * after), step)
    blocks = cells * min(record.count, BLOCKS) // cells.size
    single = look.slope * (blocks == np.arange(1, blocks[-1])[:, None])
    creep = look.slope * np.linspace(-0.5, 0.5, cells.size)
    wander, creep = (_without(look.beside(np.atleast_2d(x)), step) for x in (single, creep))
    # Of a short record the columns of other changes take much of the noise with them.
    (more,), ((variance,),) = _sizes(step, look.rest, look.noise(record, step))
    if (samples + more) ** 2 < CERTAIN * variance or SIGMAS * np.sqrt(variance) > 0.5:
        return None
    effect = float(np.sqrt(2 * np.mean(look.slope**2))) * abs(samples)
    gamma = look.noise(record, np.vstack([step, form, wander]))
    sizes = ((step, 1.0), (creep, 1.0), (wander, 1.0), (form, effect))
    if any(_is_there(columns, look.rest, gamma, SHARE * size) for columns, size in sizes):
        return None
    return Shift(samples, start, abs(samples) / float(np.sqrt(variance)))


def _without(columns: Array, step: Array) -> Array:
    """Columns (k, m) less what they have of the step (1, m)."""
    return np.asarray(columns - (columns @ step.T) / (step @ step.T) * step)


def _sizes(columns: Array, rest: Array, gamma: Array) -> tuple[Array, Array]:
    """Sizes of columns (k, m) in the rest, and their covariance."""
    weights = projector(columns.T)
    return weights @ rest, weighted_covariance(weights, gamma[None])[0]


def _is_there(columns: Array, rest: Array, gamma: Array, least: float) -> bool:
    """Whether columns are in the rest, beyond its noise and a size of no interest."""
    from scipy.special import chdtrc

    sizes, covariance = _sizes(columns, rest, gamma)
    covariance = covariance + least**2 * np.eye(len(sizes))
    return bool(chdtrc(len(sizes), sizes @ np.linalg.solve(covariance, sizes)) < CHANCE)
