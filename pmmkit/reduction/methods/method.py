"""What a method of reduction is, what it is given, and what it gives."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.campaigns import Campaign
from pmmkit.conventions import Convention
from pmmkit.inference import Consistency, LeastSquares, Selection
from pmmkit.models import DerivativeTable
from pmmkit.numerics import Array, projector, rms
from pmmkit.presentation import Described, Section
from pmmkit.reduction.derivatives import DerivativeNames
from pmmkit.reduction.estimate import ChannelFit, RunBlock, Width
from pmmkit.reduction.observations.equations import Rows, Sensitivity, residuals
from pmmkit.reduction.observations.histories import RunHistory
from pmmkit.reduction.observations.noise import FLOOR, whiteners
from pmmkit.reduction.solve import Solution, join, to_table

if TYPE_CHECKING:
    import pandas as pd


# One channel over time: equations of stretches with the noise and the scatter of their runs.


CALM: Final = 0.25
"""Share of the median noise power of a channel below which no record's noise is believed."""
FREE: Final = 100.0
"""Standard deviation, in sizes of the record, of a mean that is known to be wrong."""


def channels_over_time(
    solution: Solution, histories: Sequence[RunHistory], library: Mapping[str, Sequence[str]]
) -> tuple[tuple[int, OverTime], ...]:
    """Every channel at every Froude number over time, with its group."""
    found = []
    for group, item in solution.fits:
        base = determined(item)
        more = [name for name in library.get(item.channel, ()) if name not in base]
        names = (*base, *more)
        found.append((group, over_time(item, solution.groups[group], histories, names)))
    return tuple(found)


@dataclass(frozen=True, kw_only=True, eq=False)
class OverTime:
    """Equations of one channel at one Froude number, run by run.

    `base`: the global regression of the same channel and runs. `names`: columns of the designs.
    `blocks`: forces and regressors of each run's stretches; harmonics where there is no
    history. `noise (k_i, k_i)`: covariance of each block's rows without the scatter between
    runs. `private (k_i, q)`: errors that each run draws on its own, as columns per standard
    deviation. `drawn (k_i, 3)`: those of them that the regression estimated: offset, gain,
    drift setting. `whiteners (k_i, k_i)`: lower triangles that whiten each block for both, so
    that row by row they are also what is new of each sample after the earlier ones.
    """

    base: ChannelFit
    names: tuple[str, ...]
    blocks: tuple[RunBlock, ...]
    noise: tuple[Array, ...]
    private: tuple[Array | None, ...]
    drawn: tuple[Array, ...]
    whiteners: tuple[Array, ...]
    design: tuple[Array, ...]
    rows: tuple[Array, ...]

    def fitted(self, names: Sequence[str]) -> ChannelFit:
        """Generalised least squares with some of the columns."""
        chosen = tuple(self.names.index(name) for name in names)
        design, rows = np.concatenate(self.design)[:, chosen], np.concatenate(self.rows)
        found = LeastSquares.of(names, design, rows)
        values = np.nan_to_num(found.value)
        left = rows - design @ values
        return replace(
            self.base,
            fit=found,
            chosen=chosen,
            blocks=self.blocks,
            whiteners=self.whiteners,
            noise=replace(self.base.noise, covariances=self.noise),
            private=self.private,
            width=self._width(names),
            residual=tuple(block.rows - block.design[:, chosen] @ values for block in self.blocks),
            chi_square=float(left @ left),
        )

    def _width(self, names: Sequence[str]) -> Width:
        """What scatter between runs adds; terms that the regression lacks are as sure as most."""
        width, places = self.base.width, {n: i for i, n in enumerate(self.base.fit.names)}
        at = [places.get(name) for name in names]
        usual = float(np.median(width.factor)), float(np.median(width.dof))
        return Width(
            columns=self.drawn,
            factor=np.array([usual[0] if i is None else width.factor[i] for i in at]),
            dof=np.array([usual[1] if i is None else width.dof[i] for i in at]),
        )


def over_time(
    base: ChannelFit, members: Sequence[int], histories: Sequence[RunHistory], names: Sequence[str]
) -> OverTime:
    """The equations of a channel over time.

    Notes
    -----
    The noise of a stretch is what its own record shows between the harmonics. What the global
    regression knows of the noise of the run's harmonics beyond that (repeats, residuals) is added
    in their directions, and so is the scatter between runs: both are its own, mapped from
    harmonics to stretches, so that every method weighs runs alike.
    """
    channel = base.channel
    levels = [
        float(history.gamma[channel][0])
        for block in base.blocks
        if channel in (history := histories[members[block.run]]).gamma
    ]
    calm = CALM * float(np.median(levels)) if levels else 0.0
    parts = [
        _block(channel, block, noise, private, histories[members[block.run]], names, calm)
        for block, noise, private in zip(
            base.blocks, base.noise.covariances, base.private, strict=True
        )
    ]
    roots = whiteners([noise if own is None else noise + own @ own.T for _, noise, own in parts])
    blocks = tuple(block for block, _, _ in parts)
    pairs = list(zip(roots, blocks, strict=True))
    return OverTime(
        base=base,
        names=tuple(names),
        blocks=blocks,
        noise=tuple(noise for _, noise, _ in parts),
        private=tuple(own for _, _, own in parts),
        drawn=tuple(
            columns
            if channel not in (history := histories[members[block.run]]).gamma
            else history.basis[:, block.keep] @ columns
            for block, columns in zip(base.blocks, base.width.columns, strict=True)
        ),
        whiteners=tuple(roots),
        design=tuple(white @ block.design for white, block in pairs),
        rows=tuple(white @ block.rows for white, block in pairs),
    )


def _block(
    channel: str,
    block: RunBlock,
    noise: Array,
    private: Array | None,
    history: RunHistory,
    names: Sequence[str],
    calm: float,
) -> tuple[RunBlock, Array, Array | None]:
    """A run's rows over time, their noise, and the errors private to the run."""
    from scipy.linalg import toeplitz

    at = {name: column for column, name in enumerate(history.names[channel])}
    design = history.design[channel][:, [at[name] for name in names]]
    rows = history.force[channel]
    if channel not in history.gamma:
        keep = block.keep
        return replace(block, design=design[keep], rows=rows[keep]), noise, private
    gamma = history.gamma[channel]
    k, size = len(rows), rms(rows) or 1.0
    known, unknown = history.basis[:, block.keep], history.basis[:, ~block.keep]
    louder = max(1.0, calm / gamma[0]) if gamma[0] > 0 else 0.0
    covariance = louder * toeplitz(gamma)
    covariance[np.diag_indices(k)] += (calm if louder == 0.0 else 0.0) + k * (FLOOR * size) ** 2
    back = projector(known)
    covariance = covariance + known @ _positive(noise - back @ covariance @ back.T) @ known.T
    errors = [] if private is None else [known @ private]
    if unknown.shape[1]:
        errors.append(FREE * size * unknown)
    whole = replace(
        block, design=design, rows=rows, covariance=covariance, keep=np.ones(k, dtype=bool)
    )
    return whole, covariance, np.hstack(errors) if errors else None


def _positive(matrix: Array) -> Array:
    """The part of a symmetric matrix with positive eigenvalues."""
    value, vector = np.linalg.eigh((matrix + matrix.T) / 2)
    return np.asarray((vector * np.maximum(value, 0.0)) @ vector.T)


def joined(
    solution: Solution,
    fits: Iterable[tuple[int, ChannelFit]],
    sensitivities: Sequence[Sequence[Sensitivity]],
    histories: Sequence[RunHistory],
) -> Solution:
    """Fits over time as a solution, with the uncertainties that runs share."""
    found = tuple(fits)
    known: dict[int, dict[str, float]] = {}
    for group, item in solution.fits:
        known.setdefault(group, {}).update(item.values())
    group_of = {run: group for group, runs in enumerate(solution.groups) for run in runs}
    changes = [
        [_over_time(change, history, known.get(group_of.get(run, -1), {})) for change in own]
        for run, (own, history) in enumerate(zip(sensitivities, histories, strict=True))
    ]
    run_of = {group: list(runs) for group, runs in enumerate(solution.groups)}
    return replace(solution, fits=found, joint=join(found, changes, run_of, {}))


def _over_time(
    change: Sensitivity, history: RunHistory, values: Mapping[str, float]
) -> Sensitivity:
    """A change of a run's harmonics at the values of the regression, as one of its stretches."""
    moved = {
        channel: history.basis @ np.nan_to_num(residuals([change], channel, values)[0])
        for channel in change.names
    }
    return Sensitivity(
        source=change.source,
        force=moved,
        design={channel: np.zeros((len(x), 0)) for channel, x in moved.items()},
        names=dict.fromkeys(moved, ()),
    )


def determined(item: ChannelFit) -> list[str]:
    """The coefficients of a fit that have a value."""
    return [
        name
        for name, value in zip(item.fit.names, item.fit.value.tolist(), strict=True)
        if not math.isnan(value)
    ]


@dataclass(frozen=True, kw_only=True, eq=False)
class MethodInputs:
    """What every method starts from: the runs, and what the global regression knows of them.

    `convention`: meaning of the derivatives. `columns`: the derivatives asked for. `solution`:
    the global regression. Its groups, the noise of its blocks and their errors private to runs
    (`ChannelFit.noise`, `ChannelFit.private`) are those of every method. `rows`: means and
    harmonics of each run. `cycles`: whole cycles behind the harmonics of the regression over
    those behind `rows`, run by run. `sensitivities`: how the equations change with each stated
    uncertainty. `histories`: each run over time; empty where no method that was asked for needs
    them. `channels`: the equations over time, with their Froude group; the terms that the
    regression determines come first, then those of the library.
    """

    campaign: Campaign
    convention: Convention
    columns: DerivativeNames
    solution: Solution
    table: DerivativeTable
    rows: tuple[Rows, ...]
    cycles: tuple[float, ...]
    sensitivities: tuple[tuple[Sensitivity, ...], ...]
    histories: tuple[RunHistory, ...] = ()
    channels: tuple[tuple[int, OverTime], ...] = ()

    def over_time(self, fits: Iterable[tuple[int, ChannelFit]]) -> Solution:
        """Fits of `channels` as a solution, with the uncertainties that runs share."""
        return joined(self.solution, fits, self.sensitivities, self.histories)

    def tabled(
        self, solution: Solution, method: str, columns: DerivativeNames | None = None
    ) -> DerivativeTable:
        """A solution as a table."""
        return to_table(
            solution, columns or self.columns, self.campaign, self.convention, method=method
        )


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Estimate(Described):
    """Derivatives by one method.

    `table`: the derivatives with their intervals. `notes`: what the method has to say. `shares
    (k,)`: of a method that chooses terms: in which part of the bags of runs each was taken, by
    Froude number; NaN where it was not looked for. `same_terms`: of a method that chooses
    terms: what it gives with the terms of the regression. `tests`: of a filter: the tests of
    its innovations. `seconds`: it took, beside what all methods share.
    """

    method: str
    table: DerivativeTable
    notes: tuple[str, ...] = ()
    shares: Mapping[str, Array] = field(default_factory=lambda: MappingProxyType({}))
    same_terms: DerivativeTable | None = None
    tests: Consistency | None = None
    seconds: float = 0.0

    def to_pandas(self) -> pd.DataFrame:
        """The table with the shares of its terms, those left out at the end."""
        import pandas as pd

        frame = self.table.to_pandas()
        if not self.shares:
            return frame
        rows = [
            {"Fn": Fn, "derivative": name, "share": share}
            for name, own in self.shares.items()
            for Fn, share in zip(self.table.Fn.tolist(), own.tolist(), strict=True)
        ]
        whole = frame.merge(pd.DataFrame(rows), how="outer", on=["Fn", "derivative"], sort=False)
        beside = np.where(whole["share"] < Selection.SHARE, "left out", "a zero offset")
        told = [f"{self.method}: {text}" for text in beside]
        whole["method"] = whole["method"].where(whole["method"].notna(), told)
        whole["runs"] = whole["runs"].fillna(0).astype(int)
        return whole

    def _headline(self) -> str:
        return f"by {self.method}: {self.table._headline()}"

    def _sections(self) -> Sequence[Section]:
        kept = {
            name: ", ".join("–" if math.isnan(x) else f"{x:.0%}" for x in share)
            for name, share in self.shares.items()
        }
        taken = Section(
            title="Part of the bags of runs in which a term was taken",
            points=[f"{name}: {text}" for name, text in kept.items()],
        )
        return [
            Section(title="Derivatives", tables=[self.table.grid()]),
            *([taken] if kept else []),
            *([Section(title="Notes", points=self.notes)] if self.notes else []),
        ]


@dataclass(frozen=True, kw_only=True)
class Method:
    """A way from captive runs to derivatives.

    `name`: what a user asks for. `text`: what it does, in a line. `estimate`: from
    `MethodInputs` to an `Estimate`. `over_time`: whether it needs the runs over time.
    """

    name: str
    text: str
    estimate: Callable[[MethodInputs], Estimate]
    over_time: bool = False
