"""The steady part of a record: found, not assumed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pmmkit.signals.noise import as_record, cell_means

Array = NDArray[np.float64]


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


def steady_window(t: Array, y: Array) -> Window:
    """The steady part of a record.

    Parameters
    ----------
    t : (n,) array
        Time, increasing; steps may differ [s].
    y : (c, n) array
        Channels; the window is common to all of them.

    Returns
    -------
    Window

    Raises
    ------
    DataError
        If the record is too short, not finite or not increasing in time.
    """
    time, values = as_record(t, y, least=8)
    centre = np.median(values, axis=-1, keepdims=True)
    spread = 1.4826 * np.median(np.abs(values - centre), axis=-1, keepdims=True)
    clipped = np.clip(values, centre - 20 * spread, centre + 20 * spread)
    cells = cell_means(time, clipped / np.where(spread > 0, spread, 1.0), 100)
    m = cells.shape[-1]
    total = np.concatenate((np.zeros((cells.shape[0], 1)), np.cumsum(cells, axis=-1)), axis=-1)
    square = np.concatenate((np.zeros((cells.shape[0], 1)), np.cumsum(cells**2, axis=-1)), axis=-1)
    i, j = np.arange(m + 1)[:, None], np.arange(m + 1)[None, :]
    count = np.maximum(j - i, 1)
    part = total[:, None, :] - total[:, :, None]
    error = np.sum(square[:, None, :] - square[:, :, None] - part**2 / count, axis=0)
    score = np.where(j - i >= m // 3, error / count**2, np.inf)
    first, last = np.unravel_index(np.argmin(score), score.shape)
    start, stop = int(first * time.size // m), int(last * time.size // m)
    parts = []
    if start > 0:
        parts.append(f"{time[0]:.4g} to {time[start]:.4g} s (start-up)")
    if stop < time.size:
        parts.append(f"{time[stop]:.4g} to {time[-1]:.4g} s (end)")
    reason = "left out " + " and ".join(parts) if parts else "the whole record is steady"
    return Window(start, stop, reason)
