"""Runs sorted by Froude number, fitted, and put into a DerivativeTable."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np

from pmmkit.campaigns import Campaign, TypeB
from pmmkit.conventions import Convention, parse_derivative
from pmmkit.inference import Propagated, Restricted, RunEffects
from pmmkit.models import DerivativeTable
from pmmkit.numerics import Array
from pmmkit.reduction.between_runs import (
    BetweenRuns,
    RunDraws,
    drawn,
    judged,
    likelihood_of,
    repeats_of,
    size_of,
    widened,
)
from pmmkit.reduction.derivatives import DerivativeNames
from pmmkit.reduction.estimate import (
    ByRecords,
    ChannelFit,
    RunBlock,
    blocks_of,
    fit_channel,
    origins_of,
    solvable,
)
from pmmkit.reduction.observations.equations import Rows, Sensitivity, residuals

# All derivatives together with their joint covariance, and what pushes them.


@dataclass(frozen=True, kw_only=True, eq=False)
class Push:
    """What one error of one standard deviation does to all derivatives.

    `source`: a stated uncertainty, or one of `KINDS`: what each run draws for itself. `run`:
    place of the run that draws it; None for an error of all runs. `changes`: of the derivatives of
    each fit that it touches, by where they begin; most errors touch one fit of many. `size`: P.
    """

    source: TypeB | str
    run: int | None
    changes: Mapping[int, Array]
    size: int

    @property
    def places(self) -> tuple[tuple[int, int], ...]:
        """Where the derivatives that it changes begin and end."""
        return tuple((start, start + len(own)) for start, own in self.changes.items())

    @property
    def column(self) -> Array:
        """Change of all derivatives, array (P,)."""
        found = np.zeros(self.size)
        for start, own in self.changes.items():
            found[start : start + len(own)] = own
        return found

    @property
    def common(self) -> str:
        """The cause that it shares with other sources; empty for none."""
        return self.source.common if isinstance(self.source, TypeB) else ""


@dataclass(frozen=True, kw_only=True, eq=False)
class Joint:
    """All channels and Froude numbers together.

    `labels`: Froude group and coefficient of each entry. `covariance (P, P)`: type A and type B
    together. `pushes`: what makes the rest of the covariance: pushes of one common cause add
    up, others are independent. `dof (P,)`: effective degrees of freedom (Welch and
    Satterthwaite).
    """

    labels: tuple[tuple[int, str], ...]
    value: Array
    covariance: Array
    type_a: Array
    pushes: tuple[Push, ...]
    dof: Array


def join(
    fits: Sequence[tuple[int, ChannelFit]],
    sensitivities: Sequence[Sequence[Sensitivity]],
    run_of: Mapping[int, Sequence[int]],
    known: Mapping[int, Mapping[str, float]],
) -> Joint:
    """Put the fits of all channels and Froude numbers together with their shared errors."""
    labels: list[tuple[int, str]] = []
    starts = []
    for group, item in fits:
        starts.append(len(labels))
        labels += [(group, name) for name in item.fit.names]
    total = len(labels)
    type_a = np.zeros((total, total))
    shares = np.zeros(total)
    unknown = np.zeros(total, dtype=bool)
    changed: dict[tuple[str, int, int | None, str], dict[int, Array]] = {}
    for (group, item), start in zip(fits, starts, strict=True):
        span = slice(start, start + len(item.fit.names))
        values = {**known.get(group, {}), **item.values()}
        drawn = np.zeros(len(item.fit.names))
        parts: list[Array] = []
        pulls = item.pulls()
        for index, (block, gain) in enumerate(zip(item.blocks, item.gains(), strict=True)):
            pull = pulls[index]
            part = pull @ item.noise.covariances[index] @ pull.T
            type_a[span, span] += part
            parts.append(np.diagonal(part))
            run = run_of[group][block.run]
            moved = pull @ item.width.columns[index]
            drawn += np.sum(moved**2, axis=1)
            for kind, column in enumerate(moved.T):
                key = (_DRAWN, kind, run, "" if _kind(kind) == "drift" else item.channel)
                own = changed.setdefault(key, {})
                own[start] = own.get(start, 0.0) + column
            changes = sensitivities[run]
            moves = residuals(changes, item.channel, values)
            for number, (change, shift) in enumerate(
                zip(changes, np.nan_to_num(moves), strict=True)
            ):
                if not change.source.shared and block.covariance is None:
                    continue
                who = None if change.source.shared else run
                own = changed.setdefault((_STATED, number, who, ""), {})
                moved_by = (gain if change.source.shared else pull) @ shift[block.keep]
                own[start] = own.get(start, 0.0) + moved_by
        variance = np.stack(parts)
        doubt = item.noise.doubt
        unknown[span] = np.any(variance[np.isinf(doubt).any(axis=1)] > 0, axis=0)
        shares[span] += (
            np.sum((np.where(np.isinf(doubt), 0.0, doubt).T @ variance) ** 2, axis=0) / 2
        )
        shares[span] += (np.diagonal(type_a)[span] + drawn) ** 2 / item.width.dof
    pushes = tuple(
        Push(
            source=_kind(number) if kind == _DRAWN else sensitivities[0][number].source,
            run=run,
            changes=own,
            size=total,
        )
        for (kind, number, run, _), own in changed.items()
    )
    covariance = type_a + _covariance(pushes, total)
    value = np.concatenate([item.fit.value for _, item in fits]) if fits else np.zeros(0)
    blank = np.isnan(value) | unknown
    covariance[blank] = math.nan
    covariance[:, blank] = math.nan
    with np.errstate(divide="ignore", invalid="ignore"):
        dof = np.where(shares > 0, np.diagonal(covariance) ** 2 / shares, math.inf)
    return Joint(
        labels=tuple(labels),
        value=value,
        covariance=covariance,
        type_a=type_a,
        pushes=pushes,
        dof=dof,
    )


def _covariance(pushes: Sequence[Push], size: int) -> Array:
    """Of the derivatives by all pushes: alike ones together, those of one cause added up."""
    alike: dict[tuple[tuple[int, int], ...], list[Array]] = {}
    for push in pushes:
        if not push.common:
            alike.setdefault(push.places, []).append(np.concatenate([*push.changes.values()]))
    found = np.zeros((size, size))
    for places, changes in alike.items():
        at = np.concatenate([np.arange(*place) for place in places])
        errors = np.stack(changes)
        found[np.ix_(at, at)] += errors.T @ errors
    shared = [push for push in pushes if push.common]
    if shared:
        found += Propagated(
            factors=tuple(push.column[None] for push in shared),
            causes=tuple(push.common for push in shared),
        ).covariance
    return found


def _kind(column: int) -> str:
    """Of a column of what a run draws; each harmonic has one."""
    return RunEffects.KINDS[min(column, len(RunEffects.KINDS) - 1)]


_DRAWN = "drawn"
_STATED = "stated"


ROUNDS = 3
"""Times that values and scatter are found in turns."""
BEGUN = 0.004
"""Error of every row, over the rms force, in the first fit."""
SPEED_GAP = 0.01
"""Runs whose speeds differ by less than this share belong to one Froude number."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Solution:
    """Fits of all channels and Froude numbers.

    `Fn (k,)`: Froude numbers; NaN for one set over all speeds. `groups`: runs (places in the
    list of rows) at each Froude number. `fits`: the fits, each with its Froude group.
    `repeatability`: its sizes by repeated runs alone; those of a usual laboratory where none
    was repeated.
    """

    Fn: Array
    groups: tuple[tuple[int, ...], ...]
    fits: tuple[tuple[int, ChannelFit], ...]
    joint: Joint
    between: BetweenRuns
    repeatability: RunEffects


def froude_groups(froude: Sequence[float]) -> list[tuple[float, tuple[int, ...]]]:
    """Sort runs by Froude number; gaps below `SPEED_GAP` do not part them.

    Examples
    --------
    >>> [runs for _, runs in froude_groups([.2, .1, .2005, .1001])]
    [(1, 3), (0, 2)]
    """
    order = np.argsort(froude, kind="stable")
    groups: list[list[int]] = []
    for place in order.tolist():
        if groups and froude[place] <= froude[groups[-1][-1]] * (1 + SPEED_GAP):
            groups[-1].append(place)
        else:
            groups.append([place])
    return [(float(np.mean([froude[i] for i in group])), tuple(sorted(group))) for group in groups]


def solve(
    rows: Sequence[Rows],
    sensitivities: Sequence[Sequence[Sensitivity]],
    columns: DerivativeNames,
    groups: Sequence[tuple[float, Sequence[int]]],
    between: BetweenRuns,
    known: Mapping[int, Mapping[str, float]] | None = None,
    *,
    intervals: bool = True,
    near: RunEffects | None = None,
) -> Solution:
    """Fit every channel at every Froude number.

    near: scatter of nearly the same runs. Where a structure lacks terms its posterior can have two
    modes, and these runs may be at the one that a usual laboratory's does not lead to.
    """
    cases = list(_cases(rows, sensitivities, columns, groups, between, known or {}))
    size = {
        channel: float(np.sqrt(np.mean([case.size**2 for case in own])))
        for channel, own in _by_channel(cases).items()
    }
    scatter = between.scatter or RunEffects.usual(size)
    begin = [scatter] if near is None else [scatter, near]
    draws: list[RunDraws] = []
    fits = [case.begun(size[case.channel]) for case in cases]
    for _ in range(ROUNDS if between.scatter is None else 1):
        draws = [
            case.drawn(found, size[case.channel]) for case, found in zip(cases, fits, strict=True)
        ]
        if between.scatter is None:
            likelihoods: dict[str, list[Restricted]] = {}
            for case, found, draw in zip(cases, fits, draws, strict=True):
                with solvable(case.channel, case.Fn):
                    likelihoods.setdefault(case.channel, []).append(likelihood_of(found, draw))
            scatter = RunEffects.of(likelihoods, size, begin)
            begin = [scatter]
        fits = [case.fit(draw, scatter) for case, draw in zip(cases, draws, strict=True)]
    repeatability = between.scatter or scatter
    if intervals and between.scatter is None:
        repeatability = _by_repeats(fits, draws, size)
    if intervals:
        fits = [
            case.judged(found, draw, scatter, repeatability)
            for case, found, draw in zip(cases, fits, draws, strict=True)
        ]
    done = tuple((case.group, found) for case, found in zip(cases, fits, strict=True))
    run_of = {number: list(members) for number, (_, members) in enumerate(groups)}
    return Solution(
        Fn=np.array([froude for froude, _ in groups]),
        groups=tuple(tuple(members) for _, members in groups),
        fits=done,
        joint=join(done, sensitivities, run_of, known or {}),
        between=replace(between, scatter=scatter),
        repeatability=repeatability,
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class _Case:
    """One channel at one Froude number."""

    group: int
    Fn: float
    channel: str
    names: Sequence[str]
    required: int
    blocks: Sequence[RunBlock]
    rows: Sequence[Rows]
    changes: Sequence[Sequence[Sensitivity]]
    between: BetweenRuns
    held: Mapping[str, float]

    @cached_property
    def records(self) -> ByRecords:
        """What the records say by their noise alone."""
        return ByRecords.of(self.blocks, self.names, self.required)

    @property
    def size(self) -> float:
        """Root mean square of the readings [N, N m]."""
        return size_of(self.blocks, self.channel, self.between)

    def begun(self, size: float) -> ChannelFit:
        """Fit with an error of usual size in every row, so that no run can speak for all."""
        error = BEGUN * size
        private = {block.run: error * np.eye(len(block.rows)) for block in self.blocks}
        return self._fitted(private)

    def drawn(self, found: ChannelFit, size: float) -> RunDraws:
        """What its runs draw for themselves, as far as a fit tells."""
        return drawn(
            self.channel,
            self.blocks,
            {**self.held, **found.values()},
            found.residual,
            self.rows,
            self.changes,
            self.between,
            size,
        )

    def fit(self, draw: RunDraws, scatter: RunEffects) -> ChannelFit:
        """Fit with the mean sizes of the scatter."""
        return self._fitted(draw.private(self.blocks, scatter.sizes(self.channel)))

    def _fitted(self, private: Mapping[int, Array]) -> ChannelFit:
        with solvable(self.channel, self.Fn):
            return fit_channel(self.channel, self.blocks, self.records, private)

    def judged(
        self, found: ChannelFit, draw: RunDraws, scatter: RunEffects, repeatability: RunEffects
    ) -> ChannelFit:
        """A fit with the intervals of the mixture over all sizes of the scatter, and its misfit."""
        with solvable(self.channel, self.Fn):
            likelihood = likelihood_of(found, draw)
            wide = widened(found, draw, scatter, likelihood)
            return judged(wide, scatter, repeatability, likelihood)


def _by_repeats(
    fits: Sequence[ChannelFit], draws: Sequence[RunDraws], size: Mapping[str, float]
) -> RunEffects:
    """Sizes by repeated runs alone; a usual laboratory's where none was repeated."""
    found: dict[str, list[Restricted]] = {channel: [] for channel in size}
    for item, draw in zip(fits, draws, strict=True):
        repeated = repeats_of(item, draw)
        if repeated is not None:
            found[item.channel].append(repeated)
    return RunEffects.of(found, size)


def _cases(
    rows: Sequence[Rows],
    sensitivities: Sequence[Sequence[Sensitivity]],
    columns: DerivativeNames,
    groups: Sequence[tuple[float, Sequence[int]]],
    between: BetweenRuns,
    known: Mapping[int, Mapping[str, float]],
) -> Iterator[_Case]:
    for number, (Fn, members) in enumerate(groups):
        held = known.get(number, {})
        chosen = [rows[place] for place in members]
        origins = origins_of(chosen)
        for channel in columns.required:
            names = [*columns.required[channel], *columns.optional[channel]]
            blocks = blocks_of(chosen, channel, names, held, origins)
            if blocks and names:
                yield _Case(
                    group=number,
                    Fn=float(Fn),
                    channel=channel,
                    names=names,
                    required=len(columns.required[channel]),
                    blocks=blocks,
                    rows=chosen,
                    changes=[sensitivities[place] for place in members],
                    between=between.of(members),
                    held=held,
                )


def _by_channel(cases: Sequence[_Case]) -> dict[str, list[_Case]]:
    found: dict[str, list[_Case]] = {}
    for case in cases:
        found.setdefault(case.channel, []).append(case)
    return found


def measured_and_fitted(
    rows: Sequence[Rows], solution: Solution
) -> dict[str, dict[str, tuple[Array, Array]]]:
    """Means and harmonics of the force, and what the fit makes of them."""
    values = np.nan_to_num(solution.joint.value).tolist()  # what the runs do not tell acts in none
    known = dict(zip(solution.joint.labels, values, strict=True))
    found: dict[str, dict[str, list[Array]]] = {}
    for group, places in enumerate(solution.groups):
        for item in (rows[place] for place in places):
            kind = item.result.run.kind_of_test.title
            for channel, names in item.names.items():
                own = [known.get((group, name), 0.0) for name in names]
                pair = np.stack([item.force[channel], item.design[channel] @ np.array(own)])
                found.setdefault(channel, {}).setdefault(kind, []).append(pair)
    return {
        channel: {
            kind: (np.concatenate([x[0] for x in pairs]), np.concatenate([x[1] for x in pairs]))
            for kind, pairs in kinds.items()
        }
        for channel, kinds in found.items()
    }


def to_table(
    solution: Solution,
    columns: DerivativeNames,
    campaign: Campaign,
    convention: Convention,
    *,
    method: str,
    notes: Sequence[str] = (),
    provenance: Mapping[str, Any] | None = None,
) -> DerivativeTable:
    """The solution as a DerivativeTable; zero offsets that nobody asked for stay out."""
    found = {name for _, name in solution.joint.labels}
    names = tuple(
        parse_derivative(name).name
        for channel in columns.required
        for name in (
            *columns.required[channel],
            *(n for n in columns.optional[channel] if n in found and n != f"{channel}0"),
        )
    )
    k, n = len(solution.Fn), len(names)
    place = {name: index for index, name in enumerate(names)}
    entries = [
        (index, group * n + place[name])
        for index, (group, name) in enumerate(solution.joint.labels)
        if name in place
    ]
    source = [index for index, _ in entries]
    target = [index for _, index in entries]
    value = np.full(k * n, math.nan)
    covariance = np.full((k * n, k * n), math.nan)
    dof = np.full(k * n, math.inf)
    value[target] = solution.joint.value[source]
    covariance[np.ix_(target, target)] = solution.joint.covariance[np.ix_(source, source)]
    dof[target] = solution.joint.dof[source]
    runs = np.zeros(k * n, dtype=np.int64)
    for group, item in solution.fits:
        for column, name in enumerate(item.fit.names):
            if name in place:
                runs[group * n + place[name]] = item.excited(column)
    text = np.where(np.isnan(value), f"{method}: not determined by these runs", method)
    return DerivativeTable(
        names=names,
        Fn=solution.Fn,
        value=value.reshape(k, n),
        covariance=covariance.reshape(k, n, k, n),
        dof=dof.reshape(k, n),
        method=text.reshape(k, n),
        runs=runs.reshape(k, n),
        convention=convention,
        ship=campaign.ship,
        water=campaign.water,
        notes=tuple(notes),
        provenance=MappingProxyType(dict(provenance or {})),
    )
