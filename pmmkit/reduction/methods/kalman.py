"""A Kalman filter through the force histories, with the derivatives as states."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from pmmkit.estimation.innovations import Innovations, innovation_tests
from pmmkit.numerics import Array
from pmmkit.reduction.estimate import ChannelFit
from pmmkit.reduction.methods.method import Estimate, Evidence
from pmmkit.reduction.methods.over_time import OverTime, determined

TITLE: Final = "Kalman filter"
VAGUE: Final = 100.0
"""Standard deviation of each state before the first run, in forces of the size of the record."""
TABLES: Final = "means and harmonics"
"""Record of the runs without a history, one after the other."""
LEARNING: Final = 2.0
"""Variance of an innovation over its noise above which it tells of the prior, not of the filter."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Passed:
    """What a filter made of one channel.

    Parameters
    ----------
    value : array (p,)
        States at the end.
    covariance : array (p, p)
        Their covariance.
    innovations : tuple of array (k_i,)
        By block: each sample less what the samples before it predict, over the standard
        deviation that the filter gave it; NaN while it learns.
    """

    value: Array
    covariance: Array
    innovations: tuple[Array, ...]


def by_filter(evidence: Evidence) -> Estimate:
    """Derivatives as the states of a Kalman filter that runs through the histories.

    Parameters
    ----------
    evidence : Evidence
        With the runs over time.

    Notes
    -----
    States are the derivatives that the global regression determines, constant and at first
    vague. Slow noise of a record and the errors of its run (`OverTime.private`) begin anew with
    each run. Forces are linear in all of them along the recorded motion, so linearising costs
    nothing and the extended filter is the exact recursion. A run is one update: the lower
    Cholesky factor of the covariance of its samples gives the innovations sample by sample as
    updates by single samples would (prediction error decomposition; Harvey 1989, section 3.4),
    without a loop over samples.
    """
    fits: list[tuple[int, ChannelFit]] = []
    seen: dict[str, dict[str, Array]] = {}
    for group, channel in evidence.channels:
        names = determined(channel.base)
        if not names:
            continue
        passed = filtered(channel, names)
        found = channel.fitted(names)
        fits.append((group, replace(found, fit=replace(found.fit, value=passed.value))))
        for block, values in zip(channel.blocks, passed.innovations, strict=True):
            run = evidence.rows[evidence.solution.groups[group][block.run]].result.run
            own = seen.setdefault(run.id if run.kind == "history" else TABLES, {})
            before = own.get(channel.base.channel, np.zeros(0))
            own[channel.base.channel] = np.concatenate([before, values])
    table = evidence.tabled(evidence.over_time(fits), TITLE)
    tests = innovation_tests({run: _innovations(own) for run, own in seen.items()})
    return Estimate(method=TITLE, table=table, notes=tests.words(), tests=tests)


def filtered(channel: OverTime, names: Sequence[str]) -> Passed:
    """Run the filter through the blocks of a channel in their order.

    Parameters
    ----------
    channel : OverTime
        Equations, whitened block by block.
    names : sequence of str
        The states, columns of the equations.

    Notes
    -----
    After whitening, the covariance of a block's rows is 1 + X P X'. With its Cholesky factor C
    the innovations are C⁻¹(y - Xθ); states and covariance follow from A = C⁻¹ X P.
    """
    at = [channel.names.index(name) for name in names]
    design, rows = np.concatenate(channel.design)[:, at], np.concatenate(channel.rows)
    size = np.sqrt(np.mean(design**2, axis=0))
    spread = VAGUE * np.sqrt(np.mean(rows**2)) / np.where(size > 0, size, 1.0)
    value, covariance = np.zeros(len(size)), np.diag(spread**2)
    innovations = []
    for X, y in zip(channel.design, channel.rows, strict=True):
        own = X[:, at]
        lower = np.linalg.cholesky(np.eye(len(y)) + own @ covariance @ own.T)
        solved = np.linalg.solve(lower, np.column_stack([y - own @ value, own @ covariance]))
        new, gain = solved[:, 0], solved[:, 1:]
        value = value + gain.T @ new
        covariance = covariance - gain.T @ gain
        covariance = (covariance + covariance.T) / 2
        learnt = np.diagonal(lower) ** 2 <= LEARNING
        innovations.append(np.where(learnt, new, np.nan))
    return Passed(value=value, covariance=covariance, innovations=tuple(innovations))


def _innovations(own: Mapping[str, Array]) -> Innovations:
    """Normalised innovations of a run, channels side by side."""
    values = np.full((max(map(len, own.values())), len(own)), np.nan)
    for column, channel in enumerate(own.values()):
        values[: len(channel), column] = channel
    return Innovations(
        names=tuple(own),
        residuals=values,
        variances=np.ones_like(values),
        gated=np.zeros(values.shape, dtype=bool),
    )
