"""All derivatives together with their joint covariance, and what pushes them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pmmkit.campaigns import TypeB
from pmmkit.inference import Propagated, RunEffects
from pmmkit.numerics import Array
from pmmkit.reduction.estimate import ChannelFit
from pmmkit.reduction.observations.equations import Sensitivity


@dataclass(frozen=True, kw_only=True, eq=False)
class Push:
    """What one error of one standard deviation does to all derivatives.

    `source`: a stated uncertainty, or one of `KINDS`: what each run draws for itself. `run`:
    place of the run that draws it; None for an error of all runs. `column (P,)`: change of the
    derivatives.
    """

    source: TypeB | str
    run: int | None
    column: Array

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
    columns: dict[tuple[str, int, int | None, str], Array] = {}
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
                columns.setdefault(key, np.zeros(total))[span] += column
            for number, change in enumerate(sensitivities[run]):
                if not change.source.shared and block.covariance is None:
                    continue
                shift = change.residual(item.channel, values)[block.keep]
                own = None if change.source.shared else run
                push = columns.setdefault((_STATED, number, own, ""), np.zeros(total))
                push[span] += (gain if change.source.shared else pull) @ np.nan_to_num(shift)
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
            column=column,
        )
        for (kind, number, run, _), column in columns.items()
    )
    rest = Propagated(
        factors=tuple(push.column[None] for push in pushes),
        causes=tuple(push.common for push in pushes),
    )
    covariance = type_a + rest.covariance if pushes else type_a.copy()
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


def _kind(column: int) -> str:
    """Of a column of what a run draws; each harmonic has one."""
    return RunEffects.KINDS[min(column, len(RunEffects.KINDS) - 1)]


_DRAWN = "drawn"
_STATED = "stated"
