"""From the rows of many runs to derivatives with their joint covariance."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import CampaignError, Problem
from pmmkit.campaigns import Run, Settings
from pmmkit.inference import LeastSquares
from pmmkit.numerics import Array
from pmmkit.presentation import at_froude
from pmmkit.reduction.observations.equations import Rows
from pmmkit.reduction.observations.noise import FLOOR, KIN, Noise, moderated, whiteners

ROUNDS = 6
"""Times that values and the noise of runs that state none are found in turns."""
QUIETEST = 0.1
"""A record's standard deviation below this share of the median of its gauge is not believed."""
BIRGE_P = 0.001
"""Chance below which residuals are larger than the noise: a campaign asks in each of its channels
at each Froude number, a dozen times."""


@contextmanager
def solvable(channel: str, Fn: float) -> Iterator[None]:
    """Equations that have no solution in numbers are an error of the data that says which."""
    try:
        yield
    except np.linalg.LinAlgError as error:
        raise CampaignError(
            Problem(
                message=f"{channel}{at_froude(Fn)}: these runs have no solution in numbers "
                f"({error}): the noise of their records comes out as zero or without bound.",
                remedy="Records that were fitted or smoothed before they were written do that: "
                "reduce those of the gauges, state the noise under [uncertainty], or leave runs "
                "of one kind out.",
            )
        ) from error


@dataclass(frozen=True, kw_only=True, eq=False)
class RunBlock:
    """The usable rows of one run in one channel.

    Runs of one kin, the same speed and frequency within a tenth, have like noise a second; the
    rows are means over `duration` seconds. Runs of one origin repeat each other.
    """

    run: int
    dynamic: bool
    kin: tuple[int, int]
    origin: str
    design: Array
    rows: Array
    covariance: Array | None
    dof: float
    duration: float
    keep: NDArray[np.bool_]


@dataclass(frozen=True, kw_only=True, eq=False)
class Width:
    """What scatter between runs adds to the uncertainty of a fit of p coefficients.

    `columns (m_i, 3 + m_i)`: what each block draws for itself, per standard deviation: offset,
    gain, drift setting, each harmonic. `factor (p,)`: by which the standard uncertainties grow,
    since the sizes are not known exactly. `dof (p,)`: degrees of freedom that stand for that.
    """

    columns: tuple[Array, ...]
    factor: Array
    dof: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class ChannelFit:
    """One channel at one Froude number.

    `fit`: coefficients; the gain acts on whitened rows. `plain`: the same by the noise of the
    records alone: how far the tests part the coefficients, which an error that all rows of a
    run share says nothing about. `chosen`: columns of the blocks' designs that were fitted.
    `blocks`: the rows that were fitted. `whiteners`: what whitens each block's rows. `noise`:
    covariance of each block's rows by its record [N², (N m)²], and how well it is known.
    `private (m_i, q)`: errors that each block's run drew on its own, as columns per standard
    deviation: the scatter between runs, for whatever else is estimated from the same runs.
    `residual`: rows minus fit, block by block [N, N m]. `chi_square`: squared residuals over
    noise and scatter between runs; NaN before it was judged. `scale`: the same a degree of
    freedom, by the scatter that repeats show or a usual laboratory has. `excessive`: whether
    that is larger than chance allows. `width`: what scatter between runs adds.
    """

    channel: str
    fit: LeastSquares
    plain: LeastSquares
    chosen: tuple[int, ...]
    blocks: tuple[RunBlock, ...]
    whiteners: tuple[Array, ...]
    noise: Noise
    private: tuple[Array | None, ...]
    residual: tuple[Array, ...]
    chi_square: float
    scale: float
    excessive: bool
    width: Width

    @property
    def freedom(self) -> int:
        """Rows minus coefficients."""
        return _freedom(self.fit, sum(len(rows) for rows in self.residual))

    @property
    def left(self) -> float:
        """What the fit leaves of the forces, over their size [-]."""
        rows = np.concatenate([block.rows for block in self.blocks])
        size = float(np.linalg.norm(rows))
        return float(np.linalg.norm(np.concatenate(self.residual))) / size if size else 0.0

    def values(self) -> dict[str, float]:
        """The determined coefficients by name."""
        return {
            name: float(value)
            for name, value in zip(self.fit.names, self.fit.value, strict=True)
            if not math.isnan(value)
        }

    def excited(self, column: int) -> int:
        """How many runs say something about a coefficient."""
        reach = [
            float(np.linalg.norm(white @ block.design[:, self.chosen[column]]))
            for white, block in zip(self.whiteners, self.blocks, strict=True)
        ]
        return sum(size > 1e-6 * max(reach) for size in reach) if max(reach) > 0 else 0

    def gains(self) -> list[Array]:
        """Maps from each block's rows to the coefficients, arrays (p, m_i)."""
        parts = np.split(
            self.fit.gain, np.cumsum([len(block.rows) for block in self.blocks])[:-1], axis=1
        )
        return [part @ white for part, white in zip(parts, self.whiteners, strict=True)]

    def pulls(self) -> list[Array]:
        """The same, larger by what the sizes of the scatter are not known."""
        return [self.width.factor[:, None] * gain for gain in self.gains()]


def origins_of(rows: Sequence[Rows]) -> list[str]:
    """The first of the runs that each run repeats, itself among them (`repeats`)."""
    runs = [item.result.run for item in rows]
    first = {run.id: group[0].id for group in Run.repeats(runs) for run in group}
    return [first[run.id] for run in runs]


def blocks_of(
    rows: Sequence[Rows],
    channel: str,
    names: Sequence[str],
    held: Mapping[str, float],
    origins: Sequence[str],
) -> list[RunBlock]:
    """The usable rows of a channel, run by run."""
    blocks = []
    for place, item in enumerate(rows):
        run = item.result.run
        if channel not in item.force or channel not in item.design:
            continue
        at = {name: column for column, name in enumerate(item.names[channel])}
        design = item.design[channel][:, [at[name] for name in names]]
        fixed = [name for name in held if name in at and name not in names]
        rest = item.force[channel] - item.design[channel][:, [at[name] for name in fixed]] @ [
            held[name] for name in fixed
        ]
        keep = np.isfinite(rest) & np.isfinite(design).all(axis=1)
        if not keep.any():
            continue
        covariance = item.result.covariance.get(channel)
        blocks.append(
            RunBlock(
                run=place,
                dynamic=run.dynamic,
                kin=_kin(run.settings),
                origin=origins[place],
                design=design[keep],
                rows=rest[keep],
                covariance=None if covariance is None else covariance[np.ix_(keep, keep)],
                dof=item.result.dof.get(channel, math.inf),
                duration=item.result.duration,
                keep=keep,
            )
        )
    return blocks


def _kin(settings: Settings) -> tuple[int, int]:
    frequency = settings.omega
    tenths = math.log(1.1)
    return (
        round(math.log(settings.speed) / tenths),
        round(math.log(frequency) / tenths) if frequency else -(10**6),
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class ByRecords:
    """What a channel's records say by their noise alone, whatever runs draw for themselves.

    `noise`: of each block. `chosen`, `plain`: columns that can be fitted, and their fit by it.
    """

    noise: Noise
    chosen: tuple[int, ...]
    plain: LeastSquares

    @classmethod
    def of(cls, blocks: Sequence[RunBlock], names: Sequence[str], required: int) -> ByRecords:
        """Of blocks whose first columns have to be fitted, the others where they can."""
        noise = stated_noise(blocks)
        design, rows = _white(blocks, _whiteners(noise, [None] * len(blocks)))
        optional = optional_columns(design[:, :required], names[required:], design[:, required:])
        chosen = (*range(required), *(required + place for place in optional))
        plain = LeastSquares.of([names[place] for place in chosen], design[:, chosen], rows)
        return cls(noise=noise, chosen=chosen, plain=plain)


def fit_channel(
    channel: str, blocks: Sequence[RunBlock], records: ByRecords, private: Mapping[int, Array]
) -> ChannelFit:
    """Fit the derivatives of one channel to the rows of one Froude number.

    private (m_i, q).
    """
    scatter = [
        private[block.run] if block.run in private and block.covariance is not None else None
        for block in blocks
    ]
    noise, chosen, columns = records.noise, records.chosen, records.plain.names
    whiteners = _whiteners(noise, scatter)
    design, rows = _white(blocks, whiteners)
    found = LeastSquares.of(columns, design[:, chosen], rows)
    silent = any(block.covariance is None for block in blocks)
    for _ in range(ROUNDS if silent else 0):
        noise = _noise_from_residuals(blocks, noise, whiteners, found, design[:, chosen])
        whiteners = _whiteners(noise, scatter)
        design, rows = _white(blocks, whiteners)
        found = LeastSquares.of(columns, design[:, chosen], rows)
    values = np.nan_to_num(found.value)
    return ChannelFit(
        channel=channel,
        fit=found,
        plain=records.plain,
        chosen=chosen,
        blocks=tuple(blocks),
        whiteners=tuple(whiteners),
        noise=noise,
        private=tuple(scatter),
        residual=tuple(block.rows - block.design[:, chosen] @ values for block in blocks),
        chi_square=math.nan,
        scale=1.0,
        excessive=False,
        width=Width(
            columns=tuple(np.zeros((len(block.rows), 0)) for block in blocks),
            factor=np.ones(len(columns)),
            dof=np.full(len(columns), math.inf),
        ),
    )


def optional_columns(
    required: Array, candidates: Sequence[str], columns: Array, *, limit: float = 100.0
) -> list[int]:
    """Which optional columns can be added without spoiling what the others determine.

    required (m, p), columns (m, q): weighted alike. A column is left out if its variance inflation
    would exceed the limit; the first count most.
    """
    kept: list[int] = []
    base = required[:, np.linalg.norm(required, axis=0) > 0]
    for index in range(len(candidates)):
        column = columns[:, index]
        length = np.linalg.norm(column)
        if length == 0:
            continue
        others = np.column_stack([base, *(columns[:, other] for other in kept)])
        if others.shape[1]:
            unit = others / np.linalg.norm(others, axis=0)
            solution, *_ = np.linalg.lstsq(unit, column / length, rcond=1e-10)
            remainder = np.linalg.norm(column / length - unit @ solution)
            if remainder**2 * limit < 1.0:
                continue
        kept.append(index)
    return kept


def _freedom(found: LeastSquares, rows: int) -> int:
    return max(rows - int(np.sum(np.any(found.gain != 0, axis=1))), 0)


def stated_noise(blocks: Sequence[RunBlock]) -> Noise:
    """Moderated noise of the runs that state one; equal noise for the rest."""
    rows = np.concatenate([block.rows for block in blocks])
    size = float(np.sqrt(np.mean(rows**2))) or 1.0
    covariances: list[Array] = [np.eye(len(block.rows)) * size**2 for block in blocks]
    doubts: list[Array] = []
    for members, kin in _alike(blocks):
        found = moderated(
            [
                covariance
                for place in members
                if (covariance := blocks[place].covariance) is not None
            ],
            [blocks[place].dof for place in members],
            size,
            [blocks[place].duration for place in members],
            spectrum=kin,
        )
        for place, covariance in zip(members, found.covariances, strict=True):
            covariances[place] = covariance
        doubt = np.zeros((len(blocks), found.doubt.shape[1]))
        doubt[members] = found.doubt
        doubts.append(doubt)
    doubt = np.concatenate([np.zeros((len(blocks), 0)), *doubts], axis=1)
    return Noise(covariances=tuple(_believed(covariances, blocks)), doubt=doubt)


def _alike(blocks: Sequence[RunBlock]) -> list[tuple[list[int], bool]]:
    """Places of runs with like noise, of those that state one, and whether they are of one kin.

    Static or oscillating runs without enough kin are held to be alike in their noise a second.
    """
    kins: dict[tuple[bool, tuple[int, int]], list[int]] = {}
    for place, block in enumerate(blocks):
        if block.covariance is not None:
            kins.setdefault((block.dynamic, block.kin), []).append(place)
    lonely: dict[bool, list[int]] = {}
    for (dynamic, _), members in kins.items():
        if len(members) < KIN:
            lonely.setdefault(dynamic, []).extend(members)
    return [
        *((members, True) for members in kins.values() if len(members) >= KIN),
        *((sorted(members), False) for members in lonely.values()),
    ]


def _believed(noise: Sequence[Array], blocks: Sequence[RunBlock]) -> list[Array]:
    """Noise of a run far quieter than the others of its gauge, such as a dead one, drawn up."""
    stated = [place for place, block in enumerate(blocks) if block.covariance is not None]
    levels = {place: float(np.trace(noise[place])) / len(noise[place]) for place in stated}
    least = QUIETEST**2 * float(np.median(list(levels.values()))) if levels else 0.0
    return [
        covariance + (least - levels[place]) * np.eye(len(covariance))
        if levels.get(place, math.inf) < least
        else covariance
        for place, covariance in enumerate(noise)
    ]


def _whiteners(noise: Noise, scatter: Sequence[Array | None]) -> list[Array]:
    return whiteners(
        [
            covariance if part is None else covariance + part @ part.T
            for covariance, part in zip(noise.covariances, scatter, strict=True)
        ]
    )


def _white(blocks: Sequence[RunBlock], whiteners: Sequence[Array]) -> tuple[Array, Array]:
    pairs = list(zip(whiteners, blocks, strict=True))
    design = np.concatenate([white @ block.design for white, block in pairs])
    rows = np.concatenate([white @ block.rows for white, block in pairs])
    return design, rows


def _noise_from_residuals(
    blocks: Sequence[RunBlock],
    noise: Noise,
    whiteners: Sequence[Array],
    found: LeastSquares,
    design: Array,
) -> Noise:
    """Noise of runs that state none: mean square residual of static and of oscillating runs."""
    rows = np.concatenate(
        [white @ block.rows for white, block in zip(whiteners, blocks, strict=True)]
    )
    misfit = rows - design @ (found.gain @ rows)
    slack = 1 - np.einsum("ij,ji->i", design, found.gain)
    ends = np.cumsum([len(block.rows) for block in blocks])
    largest = max(float(np.abs(block.rows).max()) for block in blocks)
    fresh = list(noise.covariances)
    doubt = noise.doubt.copy()
    for dynamic in (False, True):
        silent = [
            place
            for place, block in enumerate(blocks)
            if block.covariance is None and block.dynamic == dynamic
        ]
        if not silent:
            continue
        index = np.concatenate(
            [np.arange(ends[place] - len(blocks[place].rows), ends[place]) for place in silent]
        )
        level = float(fresh[silent[0]][0, 0])
        freedom = float(np.sum(slack[index]))
        if freedom > 0.5:
            level *= float(np.sum(misfit[index] ** 2)) / freedom
        for place in silent:
            size = len(blocks[place].rows)
            fresh[place] = np.eye(size) * (level + (FLOOR * largest) ** 2)
        common = np.zeros(len(blocks))
        common[silent] = math.sqrt(2 / freedom) if freedom > 0.5 else math.inf
        doubt[silent] = 0.0
        doubt = np.column_stack([doubt, common])
    return Noise(covariances=tuple(fresh), doubt=doubt[:, doubt.any(axis=0)])
