"""From the rows of many runs to derivatives with their joint covariance."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pmmkit.campaigns.settings import Settings
from pmmkit.errors import CampaignError, Problem
from pmmkit.numerics import Array
from pmmkit.observations.channels import Scatter
from pmmkit.observations.equations import Rows
from pmmkit.observations.noise import FLOOR, KIN, Noise, moderated, repeat_scatter, whiteners
from pmmkit.presentation import at_froude
from pmmkit.reduction.fit import Fit, fit, optional_columns

ROUNDS = 6
SETTING = Scatter.names().index("drift")
"""What a run draws once for all its channels."""
QUIETEST = 0.1
"""A record's standard deviation below this share of the median of its gauge is not believed."""
STATED = 5.0
"""Degrees of freedom that the noise stated by the records counts for beside the residuals."""
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
class Block:
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

    Parameters
    ----------
    columns : tuple of array (m_i, 3)
        What each block draws for itself, per standard deviation: offset, gain, drift setting.
    factor : array (p,)
        By which the standard uncertainties grow, since the sizes are not known exactly.
    dof : array (p,)
        Degrees of freedom that stand for that.
    """

    columns: tuple[Array, ...]
    factor: Array
    dof: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class ChannelFit:
    """One channel at one Froude number.

    Parameters
    ----------
    channel : str
        The channel.
    fit : Fit
        Coefficients; the gain acts on whitened rows.
    plain : Fit
        The same by the noise of the records alone: how far the tests part the coefficients, which
        an error that all rows of a run share says nothing about.
    chosen : tuple of int
        Columns of the blocks' designs that were fitted.
    blocks : tuple of Block
        The rows that were fitted.
    whiteners : tuple of array
        What whitens each block's rows.
    noise : Noise
        Type A covariance of each block's rows [N², (N m)²], and how well it is known.
    private : tuple of array (m_i, q) or None
        Errors that each block's run drew on its own, as columns per standard deviation: the
        scatter between runs, for whatever else is estimated from the same runs.
    residual : tuple of array
        Rows minus fit, block by block [N, N m].
    chi_square : float
        Squared residuals over the noise; NaN where the noise was taken from the residuals.
    scale : float
        Factor by which the residuals correct the variances that the records state.
    excessive : bool
        Whether the misfit is larger than the noise allows.
    width : Width
        What scatter between runs adds.
    """

    channel: str
    fit: Fit
    plain: Fit
    chosen: tuple[int, ...]
    blocks: tuple[Block, ...]
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
    """The run that each run repeats: as the campaign says, else the first one set like it.

    Parameters
    ----------
    rows : sequence of Rows
        What each run says.
    """
    first: dict[tuple[str, Settings], str] = {}
    found = []
    for run in (item.result.run for item in rows):
        same = first.setdefault((run.test, replace(run.settings, repeat_of=None)), run.id)
        found.append(run.settings.repeat_of or same)
    return found


def blocks_of(
    rows: Sequence[Rows],
    channel: str,
    names: Sequence[str],
    held: Mapping[str, float],
    origins: Sequence[str],
) -> list[Block]:
    """The usable rows of a channel, run by run.

    Parameters
    ----------
    rows : sequence of Rows
        What each run says.
    channel : str
        The channel.
    names : sequence of str
        The columns wanted.
    held : mapping of str to float
        Derivatives held at known values, taken off the rows.
    origins : sequence of str
        Of `origins_of` the runs.
    """
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
            Block(
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


def fit_channel(
    channel: str,
    blocks: Sequence[Block],
    names: Sequence[str],
    required: int,
    private: Mapping[int, Array],
    inflation: float = 1.0,
    *,
    stated: Noise | None = None,
) -> ChannelFit:
    """Fit the derivatives of one channel to the rows of one Froude number.

    Parameters
    ----------
    channel : str
        X, Y, N or K.
    blocks : sequence of Block
        Rows, a block a run.
    names : sequence of str
        Columns of the blocks' designs: the required ones first, then those that are taken only
        if they do not spoil the others.
    required : int
        How many are required.
    private : mapping of run to array (m_i, q)
        Errors that each run draws on its own, as columns per standard deviation.
    inflation : float
        Factor of the variances that the records state, as far as an earlier fit found one.
    stated : Noise, optional
        Of `stated_noise`, where it is there already.
    """
    scatter = [
        private[block.run] if block.run in private and block.covariance is not None else None
        for block in blocks
    ]
    noise = _inflated(stated or stated_noise(blocks), blocks, inflation)
    for dynamic in (False, True):
        noise = _with_repeat_scatter(dynamic, blocks, noise, scatter)
    design, rows = _white(blocks, _whiteners(noise, [None] * len(blocks)))
    optional = optional_columns(design[:, :required], names[required:], design[:, required:])
    chosen = [*range(required), *(required + place for place in optional)]
    columns = [names[place] for place in chosen]
    plain = fit(columns, design[:, chosen], rows)
    whiteners = _whiteners(noise, scatter)
    design, rows = _white(blocks, whiteners)
    found = fit(columns, design[:, chosen], rows)
    from_residuals = any(block.covariance is None for block in blocks)
    for _ in range(ROUNDS if from_residuals else 0):
        noise = _noise_from_residuals(blocks, noise, whiteners, found, design[:, chosen])
        whiteners = _whiteners(noise, scatter)
        design, rows = _white(blocks, whiteners)
        found = fit(columns, design[:, chosen], rows)
    misfit = rows - design[:, chosen] @ (found.gain @ rows)
    scale = (
        _Scale(math.nan, 1.0, False, noise)
        if from_residuals
        else _scale(misfit, _freedom(found, len(rows)), noise)
    )
    values = np.nan_to_num(found.value)
    return ChannelFit(
        channel=channel,
        fit=found,
        plain=plain,
        chosen=tuple(chosen),
        blocks=tuple(blocks),
        whiteners=tuple(whiteners),
        noise=scale.noise,
        private=tuple(scatter),
        residual=tuple(block.rows - block.design[:, chosen] @ values for block in blocks),
        chi_square=scale.chi_square,
        scale=inflation * scale.factor,
        excessive=scale.excessive,
        width=Width(
            columns=tuple(np.zeros((len(block.rows), 0)) for block in blocks),
            factor=np.ones(len(columns)),
            dof=np.full(len(columns), math.inf),
        ),
    )


def _freedom(found: Fit, rows: int) -> int:
    return max(rows - int(np.sum(np.any(found.gain != 0, axis=1))), 0)


def stated_noise(blocks: Sequence[Block]) -> Noise:
    """Moderated noise of the runs that state one; equal noise for the rest.

    Parameters
    ----------
    blocks : sequence of Block
        Rows, a block a run.
    """
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


def _inflated(noise: Noise, blocks: Sequence[Block], factor: float) -> Noise:
    """The noise that runs state, larger by a factor."""
    if factor == 1.0:
        return noise
    return Noise(
        covariances=tuple(
            covariance if block.covariance is None else factor * covariance
            for covariance, block in zip(noise.covariances, blocks, strict=True)
        ),
        doubt=noise.doubt,
    )


def _alike(blocks: Sequence[Block]) -> list[tuple[list[int], bool]]:
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


def _believed(noise: Sequence[Array], blocks: Sequence[Block]) -> list[Array]:
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


def _with_repeat_scatter(
    dynamic: bool, blocks: Sequence[Block], noise: Noise, scatter: Sequence[Array | None]
) -> Noise:
    """Noise of static or of oscillating runs with what repeats scatter beyond it and their own."""
    known = [
        place
        for place, block in enumerate(blocks)
        if block.dynamic == dynamic and block.covariance is not None
    ]

    def known_of(place: int) -> Array:
        part, own = scatter[place], noise.covariances[place]
        return own if part is None else own + part @ part.T

    conditions: dict[str, list[int]] = {}
    for place in known:
        conditions.setdefault(blocks[place].origin, []).append(place)
    repeated = [places for places in conditions.values() if len(places) > 1]
    extra, freedom = repeat_scatter(
        [[blocks[place].rows for place in places] for places in repeated],
        [[known_of(place) for place in places] for places in repeated],
    )
    if extra <= 0:
        return noise
    wide = list(noise.covariances)
    share = np.ones(len(blocks))
    for place in known:
        own = float(np.mean(np.diagonal(wide[place])))
        wide[place] = wide[place] + extra * np.eye(len(wide[place]))
        share[place] = own / (own + extra)
    common = (1 - share) * math.sqrt(2 / freedom)
    return Noise(
        covariances=tuple(wide), doubt=np.column_stack([share[:, None] * noise.doubt, common])
    )


def _whiteners(noise: Noise, scatter: Sequence[Array | None]) -> list[Array]:
    return whiteners(
        [
            covariance if part is None else covariance + part @ part.T
            for covariance, part in zip(noise.covariances, scatter, strict=True)
        ]
    )


def _white(blocks: Sequence[Block], whiteners: Sequence[Array]) -> tuple[Array, Array]:
    pairs = list(zip(whiteners, blocks, strict=True))
    design = np.concatenate([white @ block.design for white, block in pairs])
    rows = np.concatenate([white @ block.rows for white, block in pairs])
    return design, rows


def _noise_from_residuals(
    blocks: Sequence[Block], noise: Noise, whiteners: Sequence[Array], found: Fit, design: Array
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


@dataclass(frozen=True)
class _Scale:
    """How the residuals correct the noise that the records state."""

    chi_square: float
    factor: float
    excessive: bool
    noise: Noise


def _scale(misfit: Array, freedom: int, noise: Noise) -> _Scale:
    """The stated noise and the residuals weighed by their degrees of freedom.

    A short autocorrelated record understates its slow noise a little; the residuals of many runs
    see it. `excessive` says that the misfit is larger than chance allows (F test). What the
    levels have in common the residuals know better.
    """
    from scipy.special import fdtrc

    chi_square = float(misfit @ misfit)
    strength = float(np.clip(np.median(noise.dof), 3.0, 1e6))
    prior = min(strength, STATED)
    factor = (prior + chi_square) / (prior + freedom)
    excessive = freedom > 0 and fdtrc(freedom, strength, chi_square / freedom) <= BIRGE_P
    known = freedom / (prior + freedom)
    left = noise.doubt - known * noise.doubt.mean(axis=0)
    common = np.full(len(left), math.sqrt(2 * freedom) / (prior + freedom))
    return _Scale(
        chi_square,
        factor,
        bool(excessive),
        Noise(
            covariances=tuple(factor * covariance for covariance in noise.covariances),
            doubt=np.column_stack([left, common]),
        ),
    )
