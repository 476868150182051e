"""Base and effects fitted together, and how well they predict conditions that were left out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, Literal

import numpy as np
from numpy.typing import NDArray

from pmmkit.diagnosis.base import Base
from pmmkit.diagnosis.build import TRANSIENT_FAULT, prior_sizes
from pmmkit.diagnosis.candidate import Candidate
from pmmkit.diagnosis.rows import Places
from pmmkit.diagnosis.system import (
    TYPICAL_TRANSIENT,
    WIDER,
    Block,
    System,
    candidate_columns,
    floor_features,
    transient_columns,
)
from pmmkit.diagnosis.views import View
from pmmkit.diagnosis.whitening import whitened
from pmmkit.runs.run import Run

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]
ALONE: Final = 1e-6
"""A condition whose rows have less than this to do with all others cannot be predicted."""

PARAMETER: Final = "nonlinear parameter"
"""Name of what a fit moves a nonlinear parameter by, to know its uncertainty."""
CHANGED: Final = 0.02
"""Share by which an error must change to count as changed."""
DEPENDENT: Final = 1e-10
"""A column with less than this that others do not explain is left out."""


@dataclass(frozen=True, kw_only=True, eq=False)
class JointFit:
    """Values of the base's derivatives and of effects, fitted to all runs at once.

    Parameters
    ----------
    names : tuple of str
        Derivatives of the base, then the effects' coefficients as ``effect: coefficient``.
    values : array (n,)
        Fitted; NaN where the runs do not determine one.
    covariance : array (n, n)
        With noise, run scatter, the smooth floor, the effects' prior sizes, and what is not known
        of their nonlinear parameters.
    """

    names: tuple[str, ...]
    values: Array
    covariance: Array

    @property
    def std(self) -> Array:
        """Standard deviations."""
        found: Array = np.sqrt(np.diagonal(self.covariance))
        return found

    def of(self, names: Sequence[str]) -> tuple[Array, Array]:
        """Values and standard deviations of some names."""
        at = [self.names.index(name) for name in names]
        return self.values[at], self.std[at]


@dataclass(frozen=True, kw_only=True, eq=False)
class HeldOut:
    """Errors of predictions of conditions that a fit had not seen.

    Parameters
    ----------
    conditions : tuple of str
        What was left out, one after another: runs of one setting together.
    tests : tuple of str
        Test type of each.
    channels : tuple of str
        Columns of the arrays.
    error, force : array (conditions, channels)
        Root mean square of the error and of the measured force over a cycle [N, N m]; NaN where a
        condition has no such channel or the other conditions do not determine it.
    """

    conditions: tuple[str, ...]
    tests: tuple[str, ...]
    channels: tuple[str, ...]
    error: Array
    force: Array

    def of_channel(
        self, test: str | None = None, *, kind: Literal["error", "force"] = "error"
    ) -> dict[str, float]:
        """Root mean square of error or force by channel [N, N m], of one test type or of all."""
        at = [i for i, name in enumerate(self.tests) if test in (None, name)]
        values = self.error if kind == "error" else self.force
        return dict(zip(self.channels, _rms(values[at]).tolist(), strict=True))

    def share(self, test: str | None = None) -> float:
        """Errors of one test type or of all over the channels' rms forces, over the channels."""
        at = [i for i, name in enumerate(self.tests) if test in (None, name)]
        return float(_rms((_rms(self.error[at]) / _rms(self.force))[:, None])[0])

    def better_than(self, other: HeldOut) -> float:
        """Share of conditions and channels with a smaller error, of those that change at all."""
        known = np.isfinite(self.error) & np.isfinite(other.error)
        new, old = self.error[known], other.error[known]
        changed = np.abs(new - old) > CHANGED * old
        return float(np.mean(new[changed] < old[changed])) if changed.any() else 0.0

    def to_pandas(self) -> pd.DataFrame:
        """A row per condition and channel: condition, test, channel, error, force."""
        import pandas as pd

        return pd.DataFrame(
            [
                {"condition": name, "test": test, "channel": channel,
                 "error": self.error[i, j], "force": self.force[i, j]}
                for i, (name, test) in enumerate(zip(self.conditions, self.tests, strict=True))
                for j, channel in enumerate(self.channels)
            ]
        )  # fmt: skip


def _rms(values: Array) -> Array:
    """Root mean square down the columns, over what is known; NaN where nothing is."""
    known = np.isfinite(values)
    count = known.sum(axis=0)
    total = np.where(known, values, 0.0) ** 2
    with np.errstate(invalid="ignore"):
        found: Array = np.sqrt(total.sum(axis=0) / np.where(count > 0, count, np.nan))
    return found


@dataclass(frozen=True, kw_only=True, eq=False)
class _Stack:
    """All channels below each other: base, effects and, where asked for, the floor's features.

    `plain` has the rows as they are, `white` over the root of their covariance, both with the data
    as the last column; `places` are the rows of each channel. Columns from `begin` on have a unit
    prior about `centre`; `unit` gives the values of `names` back.
    """

    plain: Array
    white: Array
    places: Mapping[str, slice]
    names: tuple[str, ...]
    unit: Array
    centre: Array
    begin: int


def _stack(system: System, effects: Sequence[Block], *, floor: float = 0.0) -> _Stack:
    base, views, channels = system.base, system.views, system.channels
    predicted = {
        c.name: c.design @ [base.values[name] for name in base.names[c.name]] for c in channels
    }
    own = {piece.projection.channel.name: piece.projection.own for piece in system.pieces}
    known = [name for c in channels for name in base.names[c.name]]
    parts = [_columns(block, system, predicted) for block in effects]
    features = {c.name: floor * floor_features(c, views, base) for c in channels if floor > 0}
    widths = [next(iter(part.values())).shape[1] for part in parts]
    total = len(known) + sum(widths) + sum(x.shape[1] for x in features.values())
    plain, white, places, row = [], [], {}, 0
    for number, c in enumerate(channels):
        block = np.zeros((len(c.y), total + 1))
        first = sum(len(base.names[x.name]) for x in channels[:number])
        block[:, first : first + c.design.shape[1]] = c.design
        at = len(known)
        for part, width in zip(parts, widths, strict=True):
            if c.name in part:
                block[:, at : at + width] = part[c.name]
            at += width
        for name, feature in features.items():
            if name == c.name:
                block[:, at : at + feature.shape[1]] = feature
            at += feature.shape[1]
        block[:, -1] = c.y
        plain.append(block)
        white.append(whitened(c, block, own[c.name], system.scatter))
        places[c.name] = slice(row, row + len(c.y))
        row += len(c.y)
    names = [*known, *(label for block in effects for label in _labels(block))]
    unit = np.concatenate([np.ones(len(known)), *(_sizes(block) for block in effects)])
    centre = np.zeros(total - len(known))
    expected = [x for block in effects for x in _expected(block)]
    centre[: len(expected)] = expected / unit[len(known) :]
    return _Stack(
        plain=np.concatenate(plain), white=np.concatenate(white), places=places,
        names=tuple(names), unit=unit, centre=centre, begin=len(known),
    )  # fmt: skip


def _columns(
    block: Block, system: System, predicted: Mapping[str, Array]
) -> Mapping[str, Array]:  # fmt: skip
    """Columns of an effect in units of its prior."""
    if block.candidate is not TRANSIENT_FAULT:
        found = candidate_columns(
            block.candidate, block.value, system.channels, system.views, system.base
        )
        return {name: x * prior_sizes(block.candidate) for name, x in found.items()}
    parts = {
        c.name: transient_columns(c, system.views, system.base, predicted[c.name], block.value)
        for c in system.channels
    }
    edges = np.cumsum([0, *(x.shape[1] for x in parts.values())])
    whole = {}
    for (name, own), begin in zip(parts.items(), edges, strict=False):
        whole[name] = np.zeros((len(own), edges[-1]))
        whole[name][:, begin : begin + own.shape[1]] = WIDER * TYPICAL_TRANSIENT * own
    return whole


def _labels(block: Block) -> list[str]:
    c = block.candidate
    if c is TRANSIENT_FAULT:
        return [f"{c.name}: share {number + 1} [-]" for number in range(len(block.places))]
    return labels(c)


def labels(candidate: Candidate) -> list[str]:
    """Names of an effect's coefficients in a joint fit."""
    return [f"{candidate.name}: {name}" for name in candidate.coefficients]


def _sizes(block: Block) -> Array:
    if block.candidate is TRANSIENT_FAULT:
        return np.full(len(block.places), WIDER * TYPICAL_TRANSIENT)
    return prior_sizes(block.candidate)


def _expected(block: Block) -> tuple[float, ...]:
    """Values about which the coefficients are expected."""
    return block.candidate.centre or (0.0,) * len(block.places)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Solved:
    """Least squares by QR with a unit prior on the later columns: Q of the rows, R, solution."""

    Q: Array
    R: Array
    solution: Array
    size: Array


def _solved(stack: _Stack) -> _Solved:
    count = stack.white.shape[1] - 1
    free = count - stack.begin
    below = np.zeros((free, count + 1))
    below[:, stack.begin : count] = np.eye(free)
    below[:, -1] = stack.centre
    whole = np.vstack([stack.white, below])
    size = np.linalg.norm(whole[:, :-1], axis=0)
    size = np.where(size > 0, size, 1.0)
    Q, R = np.linalg.qr(whole[:, :-1] / size)
    pivots = np.abs(np.diagonal(R))
    R = R + np.diag(np.where(pivots > DEPENDENT, 0.0, 1.0 / DEPENDENT))
    return _Solved(
        Q=Q[: len(stack.white)], R=R, size=size,
        solution=np.linalg.solve(R, Q.T @ whole[:, -1]) / size,
    )  # fmt: skip


def joint_fit(system: System, effects: Sequence[Block] = (), *, floor: float) -> JointFit:
    """Base and effects fitted to all runs at once.

    Parameters
    ----------
    system : System
        Runs with the estimated scatter.
    effects : sequence of Block
        Effects at a value of their nonlinear parameter.
    floor : float
        Size of what is smooth and does not matter; it widens the uncertainty.

    Returns
    -------
    JointFit
    """
    tangents = _tangents(system, effects)
    stack = _stack(system, [*effects, *tangents], floor=floor)
    found = _solved(stack)
    inverse = np.linalg.inv(found.R) / found.size[:, None]
    count = len(stack.names)
    lost = np.diagonal(found.R)[:count] > 0.5 / DEPENDENT
    covariance = (inverse @ inverse.T)[:count, :count] * np.outer(stack.unit, stack.unit)
    values = np.where(lost, np.nan, found.solution[:count] * stack.unit)
    return JointFit(names=stack.names, values=values, covariance=covariance)


def _tangents(system: System, effects: Sequence[Block]) -> list[Block]:
    """The change of each effect with its nonlinear parameter, as effects of their own."""
    if not any(block.candidate.continuous for block in effects):
        return []
    solution = _solved(_stack(system, effects)).solution
    made = []
    at = len([name for c in system.channels for name in system.base.names[c.name]])
    for block in effects:
        width = len(block.places)
        if block.candidate.continuous:
            sizes = solution[at : at + width] * _sizes(block)
            made.append(_tangent(block, sizes))
        at += width
    return made


def _tangent(block: Block, sizes: Array) -> Block:
    c, value, step = block.candidate, block.value, 0.02 * block.value

    def columns(view: View, base: Base, _: float) -> Mapping[str, Array]:
        more, less = c.columns(view, base, value + step), c.columns(view, base, value - step)
        return {
            name: ((more[name] - less[name]) @ sizes / (2 * step))[:, None] for name in more
        }  # fmt: skip

    spread = 0.5 * (max(c.grid) - min(c.grid)) / len(c.grid)
    own = Candidate(
        name=c.name, family=c.family, kind=c.kind, summary=c.summary, columns=columns,
        coefficients=(PARAMETER,), typical=(spread,),
    )  # fmt: skip
    return Block(candidate=own, value=0.0, columns=slice(0, 1))


def refined(system: System, effects: Sequence[Block]) -> tuple[Block, ...]:
    """Effects with their nonlinear parameters off the grid, where the runs are explained best.

    Parameters
    ----------
    system : System
        Runs with the estimated scatter.
    effects : sequence of Block
        Effects at points of their grids.

    Returns
    -------
    tuple of Block
        One parameter after another, each searched between the neighbours of its grid point.
    """
    from scipy.optimize import minimize_scalar

    found = list(effects)
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

        def misfit(value: float, place: int = place, block: Block = block) -> float:
            others = [*found[:place], replace(block, value=value), *found[place + 1 :]]
            return _misfit(_stack(system, others))

        result = minimize_scalar(
            misfit, bounds=(low, high), method="bounded", options={"xatol": 0.01 * (high - low)}
        )
        found[place] = replace(block, value=float(result.x))
    return tuple(found)


def _misfit(stack: _Stack) -> float:
    """Squared residuals with those of the prior, at the best coefficients."""
    found = _solved(stack)
    left = stack.white[:, -1] - stack.white[:, :-1] @ found.solution
    away = found.solution[stack.begin :] - stack.centre
    return float(left @ left + away @ away)


def held_out(system: System, effects: Sequence[Block] = ()) -> HeldOut:
    """Errors of base and effects on each condition, fitted to all other conditions.

    Parameters
    ----------
    system : System
        Runs with the estimated scatter.
    effects : sequence of Block
        Effects at a value of their nonlinear parameter.

    Returns
    -------
    HeldOut
        Runs of one setting are left out together: repeats know each other.

    Notes
    -----
    Weighted least squares without the smooth floor. With the rows of a condition k, e their
    residuals and H the hat matrix, the residuals of a fit without them are (I - H_kk)⁻¹ e; one
    decomposition serves all.
    """
    stack = _stack(system, effects)
    found = _solved(stack)
    residual = stack.white[:, -1] - stack.white[:, :-1] @ found.solution
    groups = _groups(system, stack)
    channels = tuple(stack.places)
    shape = (len(groups), len(channels))
    error, force = np.full(shape, np.nan), np.full(shape, np.nan)
    for number, own in enumerate(groups.values()):
        rows = np.concatenate([at for _, _, at in own])
        Q = found.Q[rows]
        inner = np.eye(len(rows)) - Q @ Q.T
        if np.linalg.eigvalsh(inner)[0] < ALONE:
            continue
        change = np.linalg.solve(found.R, Q.T @ np.linalg.solve(inner, residual[rows])) / found.size
        solution = found.solution - change
        for place, channel in enumerate(channels):
            mine = [(view, at) for name, view, at in own if name == channel and not view.early]
            if mine:
                left = [
                    _mean_square(stack.plain[at, -1] - stack.plain[at, :-1] @ solution)
                    for _, at in mine
                ]
                error[number, place] = np.sqrt(np.mean(left))
                force[number, place] = np.sqrt(
                    np.mean([_mean_square(stack.plain[at, -1]) for _, at in mine])
                )
    return HeldOut(
        conditions=tuple(groups), channels=channels, error=error, force=force,
        tests=tuple(own[0][1].run.test for own in groups.values()),
    )  # fmt: skip


def _mean_square(harmonics: Array) -> float:
    """Mean square over a cycle of a history with these harmonics."""
    return float(harmonics[0] ** 2 + 0.5 * np.sum(harmonics[1:] ** 2))


def _groups(system: System, stack: _Stack) -> dict[str, list[tuple[str, View, Places]]]:
    """Channel, view and rows by condition."""
    found: dict[str, list[tuple[str, View, Places]]] = {}
    for c in system.channels:
        for i, rows in zip(c.views, c.rows, strict=True):
            view = system.views[i]
            begin = stack.places[c.name].start
            at = np.arange(begin + rows.start, begin + rows.stop)
            found.setdefault(condition(view.run), []).append((c.name, view, at))
    return found


def condition(run: Run) -> str:
    """The setting of a run in words: runs with one setting repeat each other.

    Parameters
    ----------
    run : Run
        A captive run.
    """
    s = run.settings
    parts = [run.test.replace("_", " "), f"{s.speed:.3g} m/s"]
    for name, value, unit in (
        ("drift", np.degrees(s.drift), "°"), ("heel", np.degrees(s.heel), "°"),
        ("rudder", np.degrees(s.rudder), "°"),
        ("yaw", np.degrees(s.yaw_amplitude or 0.0), "°"),
        ("sway", s.amplitude or 0.0, " m"), ("period", s.period or 0.0, " s"),
        ("yaw rate", np.degrees(s.yaw_rate or 0.0), "°/s"),
        ("propeller", s.propeller_rps or 0.0, "/s"),
    ):  # fmt: skip
        if value:
            parts.append(f"{name} {value:.3g}{unit}")
    return ", ".join(parts)
