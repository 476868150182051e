"""Each derivative from the tests made for it: curve fits of means, balance of harmonics."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.campaigns import TEST_KINDS, TestKind
from pmmkit.conventions import parse_derivative
from pmmkit.inference import LeastSquares
from pmmkit.numerics import Array
from pmmkit.reduction.estimate import ChannelFit, RunBlock, blocks_of, origins_of
from pmmkit.reduction.methods.method import Estimate, MethodInputs
from pmmkit.reduction.observations.equations import Rows
from pmmkit.reduction.solve import join

TITLE: Final = "harmonics"


@dataclass(frozen=True, kw_only=True, eq=False)
class _Stacked:
    """Rows of all runs of a channel, over U².

    `tests`: kind of test of each row. `scale`: U⁻² of each row's run.
    """

    blocks: tuple[RunBlock, ...]
    tests: NDArray[np.str_]
    scale: Array
    design: Array

    @property
    def rows(self) -> Array:
        """Means and harmonics [N, N m]."""
        return np.concatenate([block.rows for block in self.blocks])


def by_harmonics(evidence: MethodInputs) -> Estimate:
    """Derivatives by the classical steps, one kind of test after another.

    Notes
    -----
    Static tests come before oscillating ones and simple motions before coupled ones. Each step
    fits, by ordinary least squares on the means or Fourier coefficients over U², what its tests
    can tell (`TestKind.fit`) and no earlier step has told; what earlier steps have told is held.
    So sway derivatives come from static drift where there is any, added masses from pure sway and
    pure yaw, coupled derivatives from yaw with drift. The whole is one linear map from the
    harmonics, through which their noise, the scatter between runs and the stated uncertainties go
    as they do in the global regression. No run is weighted by its noise.
    """
    solution = evidence.solution
    found = [
        (group, *_channel(item, [evidence.rows[place] for place in solution.groups[group]]))
        for group, item in solution.fits
    ]
    fits = [
        (group, _as_fit(item, stacked, gain, [evidence.cycles[p] for p in solution.groups[group]]))
        for (group, stacked, gain, _), (_, item) in zip(found, solution.fits, strict=True)
    ]
    run_of = {group: list(runs) for group, runs in enumerate(solution.groups)}
    joint = join(fits, evidence.sensitivities, run_of, {})
    table = evidence.tabled(replace(solution, fits=tuple(fits), joint=joint), TITLE)
    steps = dict.fromkeys(step for *_, told in found for step in told)
    return Estimate(method=TITLE, table=table, notes=tuple(steps))


def steps() -> list[TestKind]:
    """Kinds of test that tell derivatives by themselves, static and simple ones first.

    Examples
    --------
    >>> [kind.name for kind in steps() if kind.oscillates][-1]
    'yaw_drift'
    """
    found = [kind for kind in TEST_KINDS.values() if kind.captive and kind.fit is not None]
    return sorted(
        found, key=lambda kind: (kind.oscillates, len(kind.fit.factors if kind.fit else ()))
    )


def _channel(item: ChannelFit, rows: Sequence[Rows]) -> tuple[_Stacked, Array, list[str]]:
    """Rows of one channel, their map to its coefficients, and what each step told."""
    names = item.fit.names
    stacked = _stacked(item, rows)
    gain = np.zeros((len(names), len(stacked.scale)))
    done = np.zeros(len(names), dtype=bool)
    told = []
    for kind in steps():
        way = kind.fit
        assert way is not None
        at = np.flatnonzero(np.isin(stacked.tests, (kind.name, *way.beside)))
        new = [i for i in np.flatnonzero(~done).tolist() if _factors(names[i]) <= set(way.factors)]
        if not new or kind.name not in stacked.tests:
            continue
        own = stacked.design[at]
        found = LeastSquares.of([names[i] for i in new], own[:, new], np.zeros(len(at)))
        rest = -own[:, done] @ gain[done]
        rest[np.arange(len(at)), at] += stacked.scale[at]
        gain[new] = found.gain @ rest
        fresh = [i for i, there in zip(new, found.determined.tolist(), strict=True) if there]
        done[fresh] = True
        if fresh:
            told.append(f"{', '.join(names[i] for i in fresh)} from {kind.title}.")
    return stacked, gain, told


def _stacked(item: ChannelFit, rows: Sequence[Rows]) -> _Stacked:
    blocks = blocks_of(rows, item.channel, item.fit.names, {}, origins_of(rows))
    runs = [rows[block.run].result.run for block in blocks]
    size = [len(block.rows) for block in blocks]
    scale = np.repeat([run.settings.speed**-2 for run in runs], size)
    return _Stacked(
        blocks=tuple(blocks),
        tests=np.repeat([run.test for run in runs], size),
        scale=scale,
        design=np.concatenate([block.design for block in blocks]) * scale[:, None],
    )


def _factors(name: str) -> frozenset[str]:
    """Variables of a derivative; none of a constant."""
    return parse_derivative(name).variables - {"0"}


def _as_fit(
    item: ChannelFit, stacked: _Stacked, gain: Array, cycles: Sequence[float]
) -> ChannelFit:
    """A fit with the noise and the scatter of the regression; fewer cycles have more noise."""
    there = np.asarray(gain.any(axis=1), bool)
    value = np.where(there, gain @ stacked.rows, math.nan)
    design = [block.design for block in stacked.blocks]
    return replace(
        item,
        fit=LeastSquares(
            names=item.fit.names,
            value=value,
            gain=gain,
            determined=there,
            condition=math.nan,
            inflation=np.full(len(value), math.nan),
            tied=(),
        ),
        chosen=tuple(range(len(value))),
        blocks=stacked.blocks,
        whiteners=tuple(np.eye(len(own)) for own in design),
        noise=replace(
            item.noise,
            covariances=tuple(
                cycles[block.run] * noise
                for block, noise in zip(item.blocks, item.noise.covariances, strict=True)
            ),
        ),
        residual=tuple(
            block.rows - block.design @ np.nan_to_num(value) for block in stacked.blocks
        ),
        chi_square=math.nan,
    )
