"""Base and effects fitted together, nonlinear parameters off the grid, with uncertainty."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from pmmkit.diagnosis.captive.base import CaptiveBase
from pmmkit.diagnosis.captive.candidate import Candidate
from pmmkit.diagnosis.captive.least_squares import Stack, effect_columns, sizes_of, solved, stacked
from pmmkit.diagnosis.captive.system import CandidateColumns, System
from pmmkit.numerics import Array
from pmmkit.reduction import View

PARAMETER: Final = "nonlinear parameter"
"""Name of what a fit moves a nonlinear parameter by, to know its uncertainty."""


@dataclass(frozen=True, kw_only=True, eq=False)
class JointFit:
    """Values of the base's derivatives and of effects, fitted to all runs at once.

    `names`: derivatives of the base, then the effects' coefficients as ``effect: coefficient``.
    `values`: fitted; NaN where the runs do not determine one. `covariance (n, n)`: with noise,
    run scatter, the smooth floor, the effects' prior sizes, and what is not known of their
    nonlinear parameters.
    """

    names: tuple[str, ...]
    values: Array
    covariance: Array

    @property
    def std(self) -> Array:
        """Standard deviations."""
        deviations: Array = np.sqrt(np.diagonal(self.covariance))
        return deviations

    def of(self, names: Sequence[str]) -> tuple[Array, Array]:
        """Values and standard deviations of some names."""
        at = [self.names.index(name) for name in names]
        return self.values[at], self.std[at]


def joint_fit(
    system: System, effects: Sequence[CandidateColumns] = (), *, floor: float
) -> JointFit:
    """Base and effects fitted to all runs at once."""
    tangents = _tangents(system, effects)
    stack = stacked(system, [*effects, *tangents], floor=floor)
    fit = solved(stack)
    inverse = np.linalg.inv(fit.R) / fit.size[:, None]
    count = len(stack.names)
    covariance = (inverse @ inverse.T)[:count, :count] * np.outer(stack.unit, stack.unit)
    values = np.where(fit.determined[:count], fit.solution[:count] * stack.unit, np.nan)
    return JointFit(names=stack.names, values=values, covariance=covariance)


def _tangents(system: System, effects: Sequence[CandidateColumns]) -> list[CandidateColumns]:
    """The change of each effect with its nonlinear parameter, as effects of their own."""
    if not any(block.candidate.continuous for block in effects):
        return []
    solution = solved(stacked(system, effects)).solution
    made = []
    at = len([name for c in system.channels for name in system.base.names[c.name]])
    for block in effects:
        width = block.count
        if block.candidate.continuous:
            sizes = solution[at : at + width] * sizes_of(block)
            made.append(_tangent(block, sizes))
        at += width
    return made


def _tangent(block: CandidateColumns, sizes: Array) -> CandidateColumns:
    c, value, step = block.candidate, block.value, 0.02 * block.value

    def together(
        views: Sequence[View], base: CaptiveBase, _: float
    ) -> Sequence[Mapping[str, Array]]:
        both = (c.along(views, base, value + step), c.along(views, base, value - step))
        return [
            {name: ((more[name] - less[name]) @ sizes / (2 * step))[:, None] for name in more}
            for more, less in zip(*both, strict=True)
        ]

    spread = 0.5 * (max(c.grid) - min(c.grid)) / len(c.grid)
    own = Candidate(
        name=c.name,
        family=c.family,
        kind=c.kind,
        summary=c.summary,
        columns=lambda view, base, grid: together([view], base, grid)[0],
        together=together,
        coefficients=(PARAMETER,),
        typical=(spread,),
    )
    return CandidateColumns(candidate=own, value=0.0, columns=slice(0, 1))


def refined(system: System, effects: Sequence[CandidateColumns]) -> tuple[CandidateColumns, ...]:
    """Effects with their nonlinear parameters off the grid, where the runs are explained best."""
    from scipy.optimize import minimize_scalar

    blocks = [_with_columns(system, block) for block in effects]
    for place, block in enumerate(effects):
        if not block.candidate.continuous:
            continue
        grid = sorted(block.candidate.grid)
        at = grid.index(block.value)
        low, high = grid[max(at - 1, 0)], grid[min(at + 1, len(grid) - 1)]
        if at == 0:
            low = max(2 * grid[0] - grid[1], 0.5 * grid[0])
        if at == len(grid) - 1:
            high = 2 * grid[-1] - grid[-2]

        def misfit(value: float, place: int = place, block: CandidateColumns = block) -> float:
            own = _with_columns(system, replace(block, value=value))
            return _misfit(stacked(system, [*blocks[:place], own, *blocks[place + 1 :]]))

        result = minimize_scalar(
            misfit, bounds=(low, high), method="bounded", options={"xatol": 0.01 * (high - low)}
        )
        blocks[place] = _with_columns(system, replace(block, value=float(result.x)))
    return tuple(
        replace(block, made=None) if block.candidate.each_run else block for block in blocks
    )


def _with_columns(system: System, block: CandidateColumns) -> CandidateColumns:
    """An effect with its columns made once for several fits."""
    return replace(block, made=effect_columns(system, replace(block, made=None)))


def _misfit(stack: Stack) -> float:
    """Squared residuals with those of the prior, at the best coefficients."""
    fit = solved(stack)
    left = stack.white[:, -1] - stack.white[:, :-1] @ fit.solution
    away = fit.solution[stack.begin :] - stack.centre
    return float(left @ left + away @ away)
