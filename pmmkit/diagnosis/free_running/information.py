"""What records say of values when their starts are free and unknown forces act.

Rows of a window are e = S s + F f + V z + noise: a start s of any size and unknown forces
f ~ N(0, LL') are integrated out; what is left are products over the values z and ln of a
determinant.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pmmkit.diagnosis.evidence import integrated_out
from pmmkit.diagnosis.free_running.slopes import Sheet
from pmmkit.inference import Normal
from pmmkit.numerics import Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Forces:
    """Unknown forces: Ornstein-Uhlenbeck processes, one for each channel.

    `shares (f,)`: their standard deviations over ½ρLdU² (moments over ½ρL²dU²). `memory`: time
    over which they hang together, in ship lengths over the speed.
    """

    shares: Array
    memory: float

    def root(self, spacing: Array, pieces: int) -> Array:
        """Roots (w, p f, p f) of their covariance in windows of pieces of some length."""
        rho = np.exp(-spacing / self.memory)[:, None, None]
        i = np.arange(pieces)
        apart = (i[:, None] - i[None])[None]
        lower = np.where(apart >= 0, rho ** np.maximum(apart, 0), 0.0)
        fresh = np.where(i[None, None] == 0, 1.0, np.sqrt(1.0 - rho**2))
        roots: Array = np.einsum("wij,kl->wikjl", lower * fresh, np.diag(self.shares)).reshape(
            len(spacing), pieces * len(self.shares), -1
        )
        return roots


@dataclass(frozen=True, kw_only=True, eq=False)
class _Alike:
    """Windows of one number of pieces: products of their whitened rows, the starts taken out."""

    owners: NDArray[np.int64]
    spacing: Array
    pieces: int
    forces: Array
    cross: Array
    values: Array

    def at_memory(self, memory: float) -> _Alike:
        """For unknown forces of size 1 that hang together so long."""
        channels = self.forces.shape[1] // self.pieces
        own = Forces(shares=np.ones(channels), memory=memory)
        root = own.root(self.spacing, self.pieces)
        turned = np.swapaxes(root, 1, 2)
        return replace(self, forces=turned @ self.forces @ root, cross=turned @ self.cross)


@dataclass(frozen=True, kw_only=True, eq=False)
class Information:
    """All windows of all records, made small: products of slopes and errors.

    `alike`: windows by their number of pieces. `memory`: that of the unknown forces whose products
    these are; None for forces that do not hang together.
    """

    alike: tuple[_Alike, ...]
    records: int
    memory: float | None = None

    def under(self, forces: Forces) -> WindowInformation:
        """What is known of the values where unknown forces are of some size."""
        return self.windows(forces).by(self.records)

    def windows(self, forces: Forces) -> WindowInformation:
        """The same of every window."""
        products, volumes, owners = [], [], []
        mine = self if self.memory == forces.memory else self.at_memory(forces.memory)
        for item in mine.alike:
            size = np.tile(forces.shares, item.pieces)
            own, volume = integrated_out(
                item.forces * np.outer(size, size), item.cross * size[:, None], item.values
            )
            products.append(own)
            volumes.append(volume)
            owners.append(item.owners)
        return WindowInformation(
            products=np.concatenate(products),
            volumes=np.concatenate(volumes),
            owners=np.concatenate(owners),
        )

    def at_memory(self, memory: float) -> Information:
        """The same for unknown forces that hang together so long, whose sizes are varied."""
        return replace(
            self, alike=tuple(item.at_memory(memory) for item in self.alike), memory=memory
        )

    def only(self, columns: NDArray[np.intp]) -> Information:
        """With some of the values, the others held."""
        kept = np.append(columns, -1)
        return replace(
            self,
            alike=tuple(
                replace(
                    item, cross=item.cross[:, :, kept], values=item.values[:, kept[:, None], kept]
                )
                for item in self.alike
            ),
        )

    def at(self, z: Array) -> Information:
        """With nothing but what some numbers leave."""
        return self._times(np.append(-z, 1.0)[:, None])

    def of_columns(self, T: Array) -> Information:
        """In other numbers: ``values = T numbers``."""
        wide = np.zeros((T.shape[0] + 1, T.shape[1] + 1))
        wide[:-1, :-1], wide[-1, -1] = T, 1.0
        return self._times(wide)

    def with_pushes(self, patterns: Sequence[Sequence[Array]]) -> Information:
        """With further values before all others: pushes of given patterns (p, f, k) over the pieces
        of each window of each record, which act like the unknown forces."""
        by: dict[int, list[Array]] = {}
        for window in (x for own in patterns for x in own):
            by.setdefault(len(window), []).append(window.reshape(-1, window.shape[2]))
        made = []
        for item in self.alike:
            pushed = np.stack(by[item.pieces])
            turned = np.swapaxes(pushed, 1, 2)
            cross = item.forces @ pushed
            beside = turned @ item.cross
            values = np.block([[turned @ cross, beside], [np.swapaxes(beside, 1, 2), item.values]])
            made.append(
                replace(item, cross=np.concatenate([cross, item.cross], axis=2), values=values)
            )
        return replace(self, alike=tuple(made))

    def _times(self, wide: Array) -> Information:
        """The slopes and errors of all rows times a matrix."""
        return replace(
            self,
            alike=tuple(
                replace(item, cross=item.cross @ wide, values=wide.T @ item.values @ wide)
                for item in self.alike
            ),
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class WindowInformation:
    """What windows or records say of the values.

    `products (w, m + 1, m + 1)`: of slopes and, last, of what would be left if no value were
    moved; whitened. `volumes (w,)`: ln of the determinant of the covariance, up to what no
    unknown force changes.
    """

    products: Array
    volumes: Array
    owners: NDArray[np.int64]

    def by(self, records: int) -> WindowInformation:
        """Summed over the windows of each record."""
        mine = (np.arange(records)[:, None] == self.owners).astype(float)
        products = np.tensordot(mine, self.products, axes=1)
        return WindowInformation(
            products=products, volumes=mine @ self.volumes, owners=np.arange(records)
        )

    def without(self, left_out: Sequence[int]) -> WindowInformation:
        """Without some records."""
        kept = ~np.isin(self.owners, left_out)
        return WindowInformation(
            products=self.products[kept], volumes=self.volumes[kept], owners=self.owners[kept]
        )

    def over(self, wider: float) -> WindowInformation:
        """With all variances larger by a factor."""
        return replace(self, products=self.products / wider)

    @cached_property
    def normal(self) -> Normal:
        """What they say together."""
        return Normal.of_products(self.products.sum(axis=0), float(self.volumes.sum()))


def information_of(
    sheets: Sequence[Sequence[Sheet]],
    names: Sequence[Sequence[str]],
    sensors: Mapping[str, float],
    change: Array,
) -> Information:
    """The information of the windows of records.

    change (m,).
    """
    by: dict[int, list[tuple[int, float, Array, Array, Array]]] = {}
    for owner, (own, channels) in enumerate(zip(sheets, names, strict=True)):
        sigma = np.array([sensors[name] for name in channels])
        for sheet in own:
            pieces = sheet.forces.shape[1]
            rows = whitened(sheet, sigma)
            size = sheet.starts.shape[1]
            split = pieces * sheet.forces.shape[2]
            asked = np.flatnonzero(sheet.values.any(axis=0))  # of the others no slopes are made
            kept = np.r_[: size + split, size + split + asked, rows.shape[1] - 1]
            rest = np.asarray(np.linalg.qr(scaled(rows[:, kept], size), mode="r"))[size:, size:]
            F, G = rest[:, :split], np.zeros((len(rest), len(change) + 1))
            G[:, [*asked, -1]] = rest[:, split:]
            G[:, -1] += G[:, :-1] @ change + F @ sheet.along.ravel()
            by.setdefault(pieces, []).append((owner, sheet.spacing, F.T @ F, F.T @ G, G.T @ G))
    return Information(
        alike=tuple(
            _Alike(
                owners=np.array([item[0] for item in found]),
                spacing=np.array([item[1] for item in found]),
                pieces=pieces,
                forces=np.stack([item[2] for item in found]),
                cross=np.stack([item[3] for item in found]),
                values=np.stack([item[4] for item in found]),
            )
            for pieces, found in by.items()
        ),
        records=len(sheets),
    )


def whitened(sheet: Sheet, sigma: Array) -> Array:
    """Slopes over starts, forces and values, and errors, side by side, over the sensors' noise."""
    rows = np.concatenate(
        [
            sheet.starts,
            sheet.forces.reshape(len(sheet.errors), -1),
            sheet.values,
            sheet.errors[:, None],
        ],
        axis=1,
    )
    white: Array = rows * (np.sqrt(sheet.counts) / sigma[sheet.channels])[:, None]
    return white


def scaled(rows: Array, size: int) -> Array:
    """Rows with the columns of the starts of one length, so that none is lost beside others."""
    length = np.maximum(np.linalg.norm(rows[:, :size], axis=0), 1e-300)
    return np.concatenate([rows[:, :size] / length, rows[:, size:]], axis=1)
