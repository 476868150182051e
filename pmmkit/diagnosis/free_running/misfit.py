"""Whether records that were left out are missed by more than their noise level."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from pmmkit.diagnosis.captive.verdict import CHANCE
from pmmkit.diagnosis.free_running.fits import SetFit
from pmmkit.diagnosis.free_running.information import Forces
from pmmkit.diagnosis.free_running.left_out import ERRORS, of_others, pushed
from pmmkit.diagnosis.free_running.settling import agile
from pmmkit.diagnosis.free_running.slopes import Sheet
from pmmkit.numerics import Array


@dataclass(frozen=True, kw_only=True)
class LeftOutMisfit:
    """How far errors of records that were left out are from their noise level.

    `where`: the error that is furthest. `ratio`: its root mean square over what noise gives.
    `chance`: probability that noise gives one so large.
    """

    where: str
    ratio: float
    chance: float

    def __str__(self) -> str:
        return (
            f"errors of {self.where.replace('_', ' ')} in records left out stay at "
            f"{self.ratio:.1f} times what noise gives"
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class LeftOutSquares:
    """Sums of squares of the errors over the windows of records that were left out in turn.

    `names`: errors, as in `ERRORS`. `total (n, e)`: of each record. `traces (n, e, 3)`: of the
    covariance that the noise level gives these errors, of its square, and of its cube.
    """

    names: tuple[str, ...]
    total: Array
    traces: Array

    @property
    def mean(self) -> Array:
        """What the noise level gives (n, e)."""
        return self.traces[:, :, 0]

    @property
    def misfit(self) -> LeftOutMisfit:
        """The error that is furthest from its noise level.

        A sum of squares of dependent normal variables is a χ² of its mean, its variance and its
        skewness (Imhof 1961): a few starts make most of it, and by mean and variance alone one in
        a hundred would be too rare. Records have the values of the others in common: each is asked
        alone, and the least probability is multiplied by their number (Bonferroni).
        """
        from scipy.special import chdtrc

        known = self.mean > 0.0
        mean, square, cube = np.where(known, np.moveaxis(self.traces, -1, 0), 1.0)
        ratio, free = self.total / mean, square**3 / cube**2
        beyond = (self.total - mean) * np.sqrt(free / square) + free
        chances = np.where(known, chdtrc(free, np.maximum(beyond, 0.0)), 1.0)
        # Where no float is small enough for a chance the largest ratio decides.
        place = int(np.lexsort((-ratio.ravel(), chances.ravel()))[0])
        return LeftOutMisfit(
            where=self.names[place % len(self.names)],
            ratio=math.sqrt(float(ratio.flat[place])),
            chance=min(1.0, int(known.sum()) * float(chances.flat[place])),
        )

    def falls_from(self, other: LeftOutSquares) -> bool:
        """Whether less lies above the noise than of another fit, if anything does of that.

        What one finds, the other may take for noise: both are beside the noise level of this one.
        """
        before = replace(self, total=other.total)
        if before.misfit.chance >= CHANCE:
            return True
        return self._above < before._above

    @property
    def _above(self) -> float:
        """Mean over records and errors of ln of the squares over their noise level, where above it.

        Every record counts alike: of a sum over records one that is missed by far decides alone, by
        values that the others cannot tell (`random_4/1` of the Esso Osaka, docs/cases.md).
        """
        known = self.mean > 0.0
        share = self.total[known] / self.mean[known]
        return float(np.mean(np.log(np.maximum(share, 1.0))))


def left_out_squares(fit: SetFit) -> LeftOutSquares:
    """Errors of records left out one after another, beside what noise, starts, what the others
    leave unknown of the values, and unknown forces that do not matter give."""
    question = fit.place.question
    forces = Forces(shares=question.least, memory=fit.forces.memory)
    T = question.numbers.T
    made = []
    for record, sheets in enumerate(fit.place.sheets):
        z, covariance = of_others(fit, (record,))
        change, root = T @ (z - fit.place.z), T @ _root(covariance)
        stretch = question.stretches[record]
        sigma = np.array([question.sensors[name] for name in stretch.channels])
        groups = {
            name: [stretch.channels.index(x) for x in channels if x in stretch.channels]
            for name, (channels, _) in ERRORS.items()
        }
        made.append(_of_record(sheets, sigma, agile(stretch), forces, change, root, groups))
    total, traces = (np.stack(own) for own in zip(*made, strict=True))
    return LeftOutSquares(names=tuple(ERRORS), total=total, traces=traces)


def _root(covariance: Array) -> Array:
    """A root (q, k) of a covariance (q, q)."""
    values, vectors = np.linalg.eigh(covariance)
    good = values > 0.0
    found: Array = vectors[:, good] * np.sqrt(values[good])
    return found


def _of_record(
    sheets: list[Sheet],
    sigma: Array,
    follows: Forces,
    forces: Forces,
    change: Array,
    root: Array,
    groups: Mapping[str, list[int]],
) -> tuple[Array, Array]:
    """Sums (e,) of squares by error over the windows of a record, and traces (e, 3) of the powers
    of their covariance.

    Its blocks on the diagonal are D + M M', all others M M', M by values that are uncertain.
    """
    total, traces = np.zeros(len(groups)), np.zeros((len(groups), 3))
    powers = np.zeros((3, len(groups), root.shape[1], root.shape[1]))
    for sheet in sheets:
        noise = sigma[sheet.channels] / np.sqrt(sheet.counts)
        left = _start_taken(sheet, follows, noise)
        flat = sheet.forces.reshape(len(sheet.errors), -1)
        e = left @ (sheet.errors + flat @ sheet.along.ravel() - sheet.values @ change)
        own = np.concatenate([left * noise, left @ pushed(sheet, forces)], axis=1)
        values = left @ sheet.values @ root
        for k, channels in enumerate(groups.values()):
            at = np.isin(sheet.channels, channels)
            weight = np.sqrt(sheet.counts[at])[:, None]
            total[k] += float(np.sum((weight[:, 0] * e[at]) ** 2))
            rows, moved = weight * own[at], weight * values[at]
            D = rows @ rows.T
            by = D @ moved
            traces[k] += np.trace(D), np.sum(D**2), np.sum((D @ D) * D)
            powers[:, k] += moved.T @ moved, moved.T @ by, by.T @ by
    G, H, J = powers
    traces[:, 0] += np.trace(G, axis1=1, axis2=2)
    traces[:, 1] += np.trace(2.0 * H + G @ G, axis1=1, axis2=2)
    traces[:, 2] += np.trace(3.0 * J + 3.0 * H @ G + G @ G @ G, axis1=1, axis2=2)
    return total, traces


def _start_taken(sheet: Sheet, follows: Forces, noise: Array) -> Array:
    """What is left of rows (b, b) beside the start that the sensors tell of a window."""
    by = pushed(sheet, follows)
    size = np.maximum(np.linalg.norm(sheet.starts, axis=0), 1e-300)
    starts = sheet.starts / size
    told = np.linalg.solve(np.diag(noise**2) + by @ by.T, starts)
    start = np.linalg.pinv(starts.T @ told, hermitian=True) @ told.T
    found: Array = np.eye(len(starts)) - starts @ start
    return found
