"""What a sparse regression found: table, model, and what a reader must know."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.identification.sparse.collinear import Collinearity
from pmmkit.identification.sparse.request import SparseRequest
from pmmkit.identification.sparse.rows import homes
from pmmkit.inference import Equations, Selection, ThresholdPath
from pmmkit.models import DerivativeTable, Model, Part, Step
from pmmkit.numerics import Array

FEW: Final = 8
"""Runs below which intervals are called rough."""
FEWEST_BEHIND: Final = 3
"""Runs below which a term is said to rest on few."""
MISFIT: Final = 2.0
"""Residual over the stated standard deviation from which it is named."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SparseRegression:
    """What a sparse regression found.

    `model`: with the terms that stay, without those left out; simulate it like any other.
    `table`: the terms that stay: least squares on all runs with these terms alone; their
    covariance is that of the regression, with rows worth what errors shared by a run leave of
    them, and of the choice. Channels that share no term are independent. `names`: the terms
    that were looked for. `share`: part of the bags in which each term stays, of the bags that
    determine it. `coefficients (bags, terms)`: values in each bag, columns as `names`; zero
    where left out, NaN where the runs of the bag do not determine the term. `paths`: thresholds
    tried and what held-out runs say of them, by channels solved together. `held_out`: by run
    and channel: rms error over the standard deviation of the force, of a fit to other runs (of
    weak equations, over that of their noise). `collinearity`: terms that move together.
    `groups`: terms that entered or left together. `left_out, undetermined, held`: terms found
    absent; terms that no run excites, which keep the model's values; derivatives of the model
    that were not looked for. `warnings`: what a reader must know.
    """

    model: Model
    table: DerivativeTable
    names: tuple[str, ...]
    share: Mapping[str, float]
    coefficients: Array
    paths: tuple[ThresholdPath, ...]
    held_out: Mapping[str, Mapping[str, float]]
    collinearity: Collinearity
    groups: Mapping[str, tuple[str, ...]]
    left_out: tuple[str, ...]
    undetermined: tuple[str, ...]
    held: tuple[str, ...]
    warnings: tuple[str, ...]

    @property
    def thresholds(self) -> dict[str, float]:
        """Thresholds taken, by channel, in standard deviations of a sample."""
        return {channel: path.chosen for path in self.paths for channel in path.channels}


def assembled(
    model: Model,
    asked: SparseRequest,
    selection: Selection,
    *,
    covariance: Array,
    paths: Sequence[ThresholdPath],
    errors: Mapping[str, Mapping[str, float]],
) -> SparseRegression:
    """Put the result together from the bags and the held-out errors.

    covariance (s, s).
    """
    stays = selection.stays
    value, misfit = _values(asked, stays)
    table = _table(model, asked, covariance, value, stays)
    names = np.array(asked.names)
    left_out = tuple(str(name) for name in names[~stays])
    held = tuple(
        name
        for name in model.derivatives
        if name not in (*asked.names, *asked.undetermined, *asked.unmeasured)
    )
    return SparseRegression(
        model=_with_terms(model, table, left_out),
        table=table,
        names=asked.names,
        share=MappingProxyType(dict(zip(asked.names, selection.shares.tolist(), strict=True))),
        coefficients=selection.coefficients,
        paths=tuple(paths),
        held_out=MappingProxyType({run: MappingProxyType(own) for run, own in errors.items()}),
        collinearity=asked.collinearity,
        groups=MappingProxyType(dict(asked.groups)),
        left_out=left_out,
        undetermined=asked.undetermined,
        held=held,
        warnings=(
            *asked.collinearity.warnings,
            *_doubts(asked, selection, left_out, errors, misfit),
            *_assumed(asked, [name for name in held if name not in asked.fixed]),
        ),
    )


def _values(asked: SparseRequest, stays: NDArray[np.bool_]) -> tuple[Array, dict[str, float]]:
    """Least squares on all runs with the terms that stay; rms of what is left, by channel."""
    value = np.zeros(len(asked.names))
    misfit: dict[str, float] = {}
    for problem, runs in zip(asked.problems, asked.runs, strict=True):
        columns = list(problem.columns)
        whole = Equations.joined(runs)
        value[columns] = whole.least_squares(stays[columns])
        left = np.sqrt(whole.squares(value[columns]) / whole.rows)
        misfit.update(zip(problem.channels, left.tolist(), strict=True))
    return value, misfit


def _table(
    model: Model, asked: SparseRequest, covariance: Array, value: Array, stays: NDArray[np.bool_]
) -> DerivativeTable:
    """The terms that stay, pooled over speeds."""
    n = int(stays.sum())
    runs = asked.exciting()[stays]
    return DerivativeTable(
        names=tuple(name for name, stay in zip(asked.names, stays, strict=True) if stay),
        Fn=np.array([np.nan]),
        value=value[None, stays],
        covariance=covariance.reshape(1, n, 1, n),
        dof=np.maximum(runs - 1, 1).astype(float)[None, :],
        method=np.full((1, n), "sparse regression"),
        runs=runs[None, :],
        convention=model.convention,
        ship=model.ship,
        water=model.water,
        notes=("Standard deviations hold errors shared by a run and the choice of terms.",),
    )


def _with_terms(model: Model, table: DerivativeTable, left_out: Sequence[str]) -> Model:
    """The model with the values of a table and without the terms left out."""
    values = table.at()
    gone = {*values, *left_out}
    parts: dict[str, Part] = {}
    for name, part in model.parts.items():
        kept = {key: x for key, x in part.values.items() if key not in gone}
        sources = {key: text for key, text in part.sources.items() if key not in gone}
        parts[name] = replace(
            part, values=MappingProxyType(kept), sources=MappingProxyType(sources)
        )
    source = "measured: sparse regression of forces"
    for effect, name in homes(model, table.names):
        part = parts[effect]
        parts[effect] = replace(
            part,
            values=MappingProxyType({**part.values, name: values[name]}),
            sources=MappingProxyType({**part.sources, name: source}),
        )
    names, covariance = _joint_covariance(model, table, gone)
    step = Step(action="terms_selected", names=table.names, left_out=tuple(left_out))
    return model.with_(
        parts=MappingProxyType(parts),
        covariance=covariance,
        covariance_names=names,
        steps=(*model.steps, step),
    )


def _joint_covariance(
    model: Model, table: DerivativeTable, gone: set[str]
) -> tuple[tuple[str, ...], Array]:
    """Covariance of the model's other derivatives beside that of the table, at all speeds."""
    k, n = max(len(model.Fn), 1), len(table.names)
    others = [name for name in model.covariance_names if name not in gone]
    size = len(others) + n
    full = np.zeros((k, size, k, size))
    if model.covariance is not None and others:
        m = len(model.covariance_names)
        places = [model.covariance_names.index(name) for name in others]
        old = model.covariance.reshape(k, m, k, m)[:, places][:, :, :, places]
        full[:, : len(others), :, : len(others)] = old
    full[:, len(others) :, :, len(others) :] = table.covariance
    flat = full.reshape(k * size, k * size)
    return (*others, *table.names), (flat + flat.T) / 2


def _doubts(
    asked: SparseRequest,
    selection: Selection,
    left_out: Sequence[str],
    errors: Mapping[str, Mapping[str, float]],
    misfit: Mapping[str, float],
) -> list[str]:
    """What of the result rests on little, in words."""
    said = []
    if len(errors) < FEW:
        said.append(f"Intervals from {len(errors)} runs are rough.")
    said += [
        f"{name} rests on {number} of {len(errors)} runs: a bag without "
        f"{'it' if number == 1 else 'them'} says nothing of the term."
        for name, number in zip(asked.names, asked.exciting().tolist(), strict=True)
        if number < min(FEWEST_BEHIND, len(errors))
    ]
    said += [
        f"{name} stays in {part:.0%} of the bags: these runs do not decide on it."
        for name, part, open_ in zip(
            asked.names, selection.shares.tolist(), selection.undecided, strict=True
        )
        if open_
    ]
    said += [
        f"{channel}: what is left is {size:.3g} times the stated standard deviation. A term is "
        f"missing from the library, or the standard deviation is too small."
        for channel, size in misfit.items()
        if size > MISFIT
    ]
    basic = [name for name in left_out if name in Model.needed()]
    if basic:
        said.append(f"Left out although every simulation needs it: {', '.join(basic)}.")
    return said


def _assumed(asked: SparseRequest, held: Sequence[str]) -> list[str]:
    """What was taken from the model without being asked for, in words."""
    said = []
    beside = [name for name in held if name[0] in asked.channels]
    if beside:
        said.append(
            f"Held at the model's values, because the library does not name them: "
            f"{', '.join(beside)}. Name those that are known as fixed."
        )
    if asked.undetermined:
        said.append(f"No run excites {', '.join(asked.undetermined)}: the model's values stay.")
    if asked.unmeasured:
        said.append(
            f"Not looked for, because no record has their force with a standard deviation: "
            f"{', '.join(asked.unmeasured)}."
        )
    return said
