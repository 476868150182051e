"""A Kalman filter through the force histories, with the derivatives as states."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from pmmkit.inference import Consistency, InformationRoot, Innovations
from pmmkit.numerics import Array
from pmmkit.reduction.estimate import ChannelFit
from pmmkit.reduction.methods.method import Estimate, MethodInputs, OverTime, determined

TITLE: Final = "Kalman filter"
VAGUE: Final = 100.0
"""Standard deviation of each state before the first run, in forces of the size of the record."""
TABLES: Final = "means and harmonics"
"""Record of the runs without a history, one after the other."""
LEARNING: Final = 2.0
"""Variance of an innovation over its noise above which it tells of the prior, not of the filter."""


def by_filter(evidence: MethodInputs) -> Estimate:
    """Derivatives as the states of a Kalman filter that runs through the histories.

    Notes
    -----
    States are the derivatives that the global regression determines, constant and at first
    vague. Slow noise of a record and the errors of its run (`OverTime.private`) begin anew with
    each run. Forces are linear in all of them along the recorded motion, so linearising costs
    nothing and the extended filter is the exact recursion. A run is one update: the lower
    Cholesky factor of the covariance of its samples gives the innovations sample by sample as
    updates by single samples would (prediction error decomposition; Harvey 1989), without a loop
    over samples. Where only means and harmonics are known, they are the samples.
    """
    fits: list[tuple[int, ChannelFit]] = []
    seen: dict[str, dict[str, Array]] = {}
    for group, channel in evidence.channels:
        names = determined(channel.base)
        if not names:
            continue
        known, innovations = filtered(channel, names)
        found = channel.fitted(names)
        fits.append((group, replace(found, fit=replace(found.fit, value=known.mean))))
        for block, values in zip(channel.blocks, innovations, strict=True):
            run = evidence.rows[evidence.solution.groups[group][block.run]].result.run
            own = seen.setdefault(run.id if run.kind == "history" else TABLES, {})
            before = own.get(channel.base.channel, np.zeros(0))
            own[channel.base.channel] = np.concatenate([before, values])
    table = evidence.tabled(evidence.over_time(fits), TITLE)
    tests = Consistency.of({run: _innovations(own) for run, own in seen.items()})
    return Estimate(method=TITLE, table=table, notes=tests.words(), tests=tests)


def filtered(channel: OverTime, names: Sequence[str]) -> tuple[InformationRoot, list[Array]]:
    """What is known after the blocks of a channel in their order, and innovations (k_i,) of each.

    An innovation is a sample less what the samples before it predict, over the standard deviation
    that the filter gave it; NaN while it learns.

    Notes
    -----
    A square-root information filter; a block is one update.
    """
    at = [channel.names.index(name) for name in names]
    whole, rows = np.concatenate(channel.design)[:, at], np.concatenate(channel.rows)
    size = np.sqrt(np.mean(whole**2, axis=0)) / (VAGUE * np.sqrt(np.mean(rows**2)))
    known = InformationRoot.of(np.zeros(len(size)), 1.0 / np.where(size > 0, size, 1.0))
    innovations = []
    for design, y in zip(channel.design, channel.rows, strict=True):
        new, variance = known.innovations(design[:, at], y)
        innovations.append(np.where(variance <= LEARNING, new, np.nan))
        known = known.with_rows(design[:, at], y)
    return known, innovations


def _innovations(own: Mapping[str, Array]) -> Innovations:
    """Normalised innovations of a run, channels side by side."""
    values = np.full((max(map(len, own.values())), len(own)), np.nan)
    for column, channel in enumerate(own.values()):
        values[: len(channel), column] = channel
    return Innovations(names=tuple(own), residuals=values, variances=np.ones_like(values))
