"""The steady part of a record: found, not assumed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from pmmkit.numerics import Array
from pmmkit.signals.noise import (
    FEWEST,
    as_record,
    autoregressive_noise,
    cell_means,
    mean_variance,
    time_weights,
)

CELLS: Final = 128
CORE: Final = 0.3
"""Part of the record from which the noise is judged, at least."""
LEAST: Final = 0.15
"""Smallest part of the record that can be called its steady part."""
SURE: Final = 5e-5
"""Chance at which a part is found to differ, one cell and channel looked at."""
CLEAN: Final = 0.1
"""The same for what is still left out next to a part that surely differs."""
NEGLIGIBLE: Final = 1e-4
"""Changes below this fraction of a channel's size are of no interest."""


@dataclass(frozen=True)
class Window:
    """The samples [start, stop) of a record that are steady, and why.

    Attributes
    ----------
    start, stop : int
        First sample kept, and the one after the last.
    reason : str
        A sentence for a person.
    steady : bool
        False where nothing steady was found and the last part was taken instead.
    """

    start: int
    stop: int
    reason: str
    steady: bool = True


@dataclass(frozen=True)
class _Core:
    """A part of the cells that looks steady, and its noise."""

    mean: Array
    filters: Array
    innovation: Array
    part_variance: Array
    mean_variance: Array
    dof: Array


def steady_window(t: ArrayLike, y: ArrayLike) -> Window:
    """The steady part of a record, common to all its channels.

    Parameters
    ----------
    t : (n,) array
        Time, increasing; steps may differ [s].
    y : (c, n) array
        Channels.

    Returns
    -------
    Window
        Nearly all of the record if it is steady; without a carriage ramp or the start-up of a
        computation, and without a deceleration at the end.

    Raises
    ------
    DataError
        If the record is too short or not finite, or if time does not increase.

    Notes
    -----
    On at most 128 means over equal stretches of time, the part with the smallest squared
    standard error of its mean is taken, at both ends and over all channels together (the
    marginal standard error rule, White 1997). What it leaves out is left out only if a test
    confirms that it differs in mean or in strength from the part, given the autocorrelated noise
    of that part; the cut is then moved on until a transient that decays as it did before the cut
    no longer matters.

    Examples
    --------
    >>> import numpy as np
    >>> t = np.arange(0.0, 60.0, 0.05)
    >>> force = 8.0 + 0.3 * np.random.default_rng(2).normal(size=t.size)
    >>> force = np.where(t < 12.0, force * t / 12.0, force)
    >>> window = steady_window(t, force)
    >>> bool(12.0 <= t[window.start] < 18.0), window.stop == t.size
    (True, True)
    """
    time, values = as_record(t, y, least=FEWEST)
    cells, floor = _condensed(time, values)
    m = cells.shape[-1]
    if not cells.shape[0]:
        return Window(0, time.size, "kept all: no channel changes")
    first, last, steady = _steady_cells(cells, floor)
    edge = np.insert(np.cumsum(time_weights(time)), 0, 0.0)
    grid = edge[-1] * np.array([first, last]) / m
    start, stop = np.searchsorted(edge, grid - 1e-9 * edge[-1])
    stop = min(int(stop), time.size)
    return Window(int(start), stop, _reason(time, int(start), stop, steady), steady)


def calmest_part(t: ArrayLike, y: ArrayLike) -> tuple[int, int]:
    """The samples [start, stop) whose mean has the smallest squared standard error.

    A first guess of the steady part: at least 0.3 of the record, over all channels together.
    """
    time, values = as_record(t, y, least=FEWEST)
    cells, floor = _condensed(time, values)
    if not cells.shape[0]:
        return 0, time.size
    ends = np.array(_least_error(cells, floor)) / cells.shape[-1]
    start, stop = np.round(time.size * ends).astype(int)
    return int(start), int(stop)


def _steady_cells(cells: Array, floor: Array) -> tuple[int, int, bool]:
    """The steady part [first, last) of the cells, or their last part and False."""
    m = cells.shape[-1]
    least = int(np.ceil(LEAST * m))
    i, j = _least_error(cells, floor)
    core = _core(cells[:, i:j], floor)
    first = _cut(cells[:, :i], j - i, core)
    last = m - _cut(cells[:, : j - m - 1 : -1], j - i, core) if j < m else m
    if last - first >= least and not _drifts(cells[:, first:last], floor, SURE):
        return first, last, True
    for part in (0.75, 0.6, 0.5, 0.4, 0.3, LEAST):
        i = max(first, last - int(part * m))
        if last - i >= least and not _drifts(cells[:, i:last], floor, CLEAN):
            return i, last, True
    return m - least, m, False


def _reason(time: Array, start: int, stop: int, steady: bool) -> str:
    if not steady:
        return (
            "nothing steady was found: the record still changes at its end; "
            f"took the last part, {time[start]:.4g} to {time[stop - 1]:.4g} s"
        )
    parts = []
    if start > 0:
        parts.append(f"{time[0]:.4g} to {time[start]:.4g} s (start-up)")
    if stop < time.size:
        parts.append(f"{time[stop]:.4g} to {time[-1]:.4g} s (change at the end)")
    return "left out " + " and ".join(parts) if parts else "kept all: steady from start to end"


def _condensed(time: Array, values: Array) -> tuple[Array, Array]:
    """Cell means of the channels that change, in units of their spread, and their noise floor."""
    centre = np.median(values, axis=-1, keepdims=True)
    away = np.abs(values - centre)
    spread = 1.4826 * np.median(away, axis=-1, keepdims=True)
    spread = np.where(spread > 0, spread, away.mean(axis=-1, keepdims=True))
    size = np.abs(centre) + spread
    changes = (spread > 1e-12 * size)[:, 0]
    spread, centre, size = spread[changes], centre[changes], size[changes]
    scaled = np.clip((values[changes] - centre) / spread, -30.0, 30.0)
    return cell_means(time, scaled, CELLS), NEGLIGIBLE * (size / spread)[:, 0]


def _least_error(cells: Array, floor: Array) -> tuple[int, int]:
    """The part [i, j) whose mean has the smallest squared standard error."""
    c, m = cells.shape
    width = max(4, m // 10)
    parts = cells[:, : m // width * width].reshape(c, -1, width)
    noise = np.median(parts.var(axis=-1), axis=-1) + floor**2
    total = np.insert(np.cumsum(cells, axis=-1), 0, 0.0, axis=-1)
    square = np.insert(np.cumsum(cells**2, axis=-1), 0, 0.0, axis=-1)
    i, j = np.triu_indices(m + 1, int(np.ceil(CORE * m)))
    count = j - i
    error = square[:, j] - square[:, i] - (total[:, j] - total[:, i]) ** 2 / count
    score = ((error / noise[:, None]).sum(axis=0) + c) / count**2
    best = int(np.argmin(score))
    return int(i[best]), int(j[best])


def _core(part: Array, floor: Array) -> _Core:
    """Mean and noise of a part; the floor stands for noise where there is none."""
    mean = part.mean(axis=-1)
    filters, innovation, gamma, dof = autoregressive_noise(_with_noise(part, floor), 4)
    lags = np.arange(CELLS)
    padded = np.zeros((gamma.shape[0], CELLS))
    padded[:, : gamma.shape[-1]] = gamma
    inner = np.cumsum(padded, axis=-1)
    moment = np.cumsum(lags * padded, axis=-1)
    part_variance = (2.0 * (inner - moment / (lags + 1.0)) - padded[:, :1]) / (lags + 1.0)
    return _Core(
        mean=mean,
        filters=filters,
        innovation=innovation,
        part_variance=part_variance + floor[:, None] ** 2,
        mean_variance=mean_variance(gamma) + floor**2,
        dof=dof,
    )


def _with_noise(part: Array, floor: Array) -> Array:
    """The part without its mean; where it hardly varies, noise as large as the floor."""
    rest = part - part.mean(axis=-1, keepdims=True)
    quiet = np.mean(rest**2, axis=-1, keepdims=True) <= floor[:, None] ** 2
    white = np.random.default_rng(0).normal(size=part.shape[-1])
    return np.where(quiet, floor[:, None] * white, rest)


def _cut(outside: Array, inside: int, core: _Core) -> int:
    """Cells to leave out at the start of `outside` and of the `inside` cells that follow it."""
    from scipy.special import stdtrit

    n = outside.shape[-1]
    if n == 0:
        return 0
    away = outside - core.mean[:, None]
    total = np.insert(np.cumsum(away, axis=-1), 0, 0.0, axis=-1)
    i, j = np.triu_indices(n + 1, 1)
    length = j - i
    variance = core.part_variance[:, length - 1] + core.mean_variance[:, None]
    shift = np.abs(total[:, j] - total[:, i]) / length / np.sqrt(variance)
    order = core.filters.shape[-1] - 1
    padded = np.pad(away, ((0, 0), (order, 0)), mode="edge")
    white = sum(
        core.filters[:, k, None] * padded[:, order - k : order - k + n] for k in range(order + 1)
    )
    energy = np.insert(np.cumsum(white**2, axis=-1), 0, 0.0, axis=-1) / core.innovation[:, None]
    power = (energy[:, j] - energy[:, i]) / length
    strength = (np.cbrt(power) - 1.0 + 2.0 / (9.0 * length)) / np.sqrt(2.0 / (9.0 * length))
    c = outside.shape[0]
    dof = core.dof[:, None]
    sure = stdtrit(dof, 1.0 - 0.5 * SURE / c)
    clean = stdtrit(dof, 1.0 - 0.5 * CLEAN / c)
    if not np.any((shift > sure) | (strength > sure)):
        return 0
    differs = np.zeros(n, dtype=bool)
    np.logical_or.at(differs, i, np.any((shift > clean) | (strength > clean), axis=0))
    first = int(np.flatnonzero(differs)[-1]) + 1 if differs.all() else int(np.argmin(differs))
    return first + _still_decaying(away, first, inside + n - first, core)


def _still_decaying(away: Array, first: int, left: int, core: _Core) -> int:
    """Cells to leave out beyond `first`, so that a decay going on as before does not matter."""
    more = 0
    for channel, row in enumerate(away):
        for width in range(1, first // 2 + 1):
            noise = np.sqrt(core.part_variance[channel, width - 1])
            near = abs(row[first - width : first].mean())
            far = abs(row[first - 2 * width : first - width].mean())
            if far > 4.0 * noise:
                ratio = min(max(near, noise) / far, 0.95)
                bias = max(near, noise) * width * ratio / (1.0 - ratio) / left
                allowed = 0.1 * np.sqrt(core.mean_variance[channel])
                if bias > allowed:
                    more = max(more, int(np.ceil(width * np.log(bias / allowed) / -np.log(ratio))))
                break
    return min(more, 2 * left // 5)


def _drifts(part: Array, floor: Array, chance: float) -> bool:
    """Whether a straight line through the part rises by more than its noise explains."""
    from scipy.special import stdtrit

    c, m = part.shape
    line = np.linspace(-0.5, 0.5, m)
    rise = part @ line / (line @ line)
    _, _, gamma, dof = autoregressive_noise(_with_noise(part - rise[:, None] * line, floor), 4)
    shape = np.fft.irfft(np.abs(np.fft.rfft(line, 2 * m)) ** 2, 2 * m)[:m]
    variance = (2.0 * gamma @ shape - gamma[:, 0] * shape[0]) / (line @ line) ** 2
    limit = stdtrit(dof, 1.0 - 0.5 * chance / c) * np.sqrt(variance + floor**2)
    return bool(np.any(np.abs(rise) > limit))
