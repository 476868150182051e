"""How far a model may be off where it sails records that were left out."""

from __future__ import annotations

import numpy as np

from pmmkit.diagnosis.free_running.fits import Fit
from pmmkit.diagnosis.free_running.information import Forces
from pmmkit.diagnosis.free_running.left_out import of_others
from pmmkit.diagnosis.free_running.settling import agile
from pmmkit.diagnosis.free_running.slopes import Sheet, sheets_of
from pmmkit.diagnosis.free_running.windows import Stretch
from pmmkit.numerics import Array


def band(fit: Fit, record: int) -> Array:
    """Standard deviation (n, c) of what the channels of a record show that was left out.

    It is that of the values, as well as the other records determine them, of the unknown forces of
    the fit, and of the starts of the windows, as well as the sensors tell them.

    Parameters
    ----------
    fit : Fit
        Whose set is fitted to the others.
    record : int
        The record that is left out.
    """
    question, numbers = fit.followed, fit.place.question.numbers
    z, covariance = of_others(fit, (record,))
    change, steps = numbers.T @ z, numbers.steps(numbers.used(fit.names))
    stretch = question.stretches[record].free
    whole = numbers.T @ covariance @ numbers.T.T
    sigma = np.array([question.sensors[name] for name in stretch.channels])
    sheets = sheets_of(stretch, change, steps)
    return np.concatenate(
        [
            _of_window(
                stretch,
                w,
                sheet,
                _of_start(sheet, agile(stretch), sigma) + _variances(sheet, whole, fit.forces),
            )
            for w, sheet in enumerate(sheets)
        ]
    )


def _pushed(sheet: Sheet, forces: Forces) -> Array:
    """What unknown forces that are standard normal do to the rows (b, p f)."""
    root = forces.root(np.array([sheet.spacing]), sheet.forces.shape[1])[0]
    found: Array = sheet.forces.reshape(len(sheet.forces), -1) @ root
    return found


def _variances(sheet: Sheet, values: Array, forces: Forces) -> Array:
    """Variance (b,) of each row by values and unknown forces."""
    moved = np.einsum("bi,ij,bj->b", sheet.values, values, sheet.values)
    found: Array = np.maximum(moved, 0.0) + np.sum(_pushed(sheet, forces) ** 2, axis=1)
    return found


def _of_start(sheet: Sheet, forces: Forces, sigma: Array) -> Array:
    """Variance (b,) of each row by the start, told by the sensors along a path that such unknown
    forces may bend."""
    pushed = _pushed(sheet, forces)
    noise = sigma[sheet.channels] ** 2 / sheet.counts
    told = np.linalg.solve(np.diag(noise) + pushed @ pushed.T, sheet.starts)
    size = np.sqrt(np.maximum(np.einsum("bi,bi->i", sheet.starts, told), 1e-300))
    # Columns of one length: positions and rates differ by orders of magnitude.
    known = np.linalg.pinv(sheet.starts.T @ told / np.outer(size, size), hermitian=True)
    begun: Array = np.einsum("bi,ij,bj->b", sheet.starts / size, known, sheet.starts / size)
    return np.maximum(begun, 0.0)


def _of_window(stretch: Stretch, w: int, sheet: Sheet, variances: Array) -> Array:
    """Standard deviations (n, c) at the instants of a window, straight lines between its blocks."""
    rows = slice(stretch.begins[w], stretch.begins[w + 1])
    t, blocks = stretch.record.t[rows], stretch.blocks[rows]
    middles = {int(block): float(np.mean(t[blocks == block])) for block in np.unique(blocks)}

    def along(channel: int) -> Array:
        own = sheet.channels == channel
        at = [middles[int(block)] for block in sheet.blocks[own]]
        std: Array = np.interp(t, at, np.sqrt(variances[own]))
        return std

    return np.stack([along(channel) for channel in range(len(stretch.channels))], axis=1)
