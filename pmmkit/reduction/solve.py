"""Runs sorted by Froude number, fitted, and put into a DerivativeTable."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from pmmkit.campaigns.run import Campaign
from pmmkit.conventions import Convention, canonical
from pmmkit.numerics import Array
from pmmkit.observations.equations import Rows, Sensitivity
from pmmkit.reduction.derivatives import Columns
from pmmkit.reduction.estimate import Block, ChannelFit, Joint, blocks_of, fit_channel, join
from pmmkit.tables import DerivativeTable

SPEED_GAP = 0.01
"""Runs whose speeds differ by less than this share belong to one Froude number."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Solution:
    """Fits of all channels and Froude numbers.

    Parameters
    ----------
    Fn : array (k,)
        Froude numbers; NaN for one set over all speeds.
    groups : tuple of tuple of int
        Runs (places in the list of rows) at each Froude number.
    fits : tuple of (int, ChannelFit)
        The fits, each with its Froude group.
    joint : Joint
        Values and covariance.
    """

    Fn: Array
    groups: tuple[tuple[int, ...], ...]
    fits: tuple[tuple[int, ChannelFit], ...]
    joint: Joint


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
    columns: Columns,
    groups: Sequence[tuple[float, Sequence[int]]],
    known: Mapping[int, Mapping[str, float]] | None = None,
) -> Solution:
    """Fit every channel at every Froude number.

    Parameters
    ----------
    rows : sequence of Rows
        What each run says; its designs have the columns `all_names`.
    sensitivities : sequence of sequence of Sensitivity
        How each run's equations change with each source of uncertainty.
    columns : Columns
        Derivatives to be fitted, a choice of the designs' columns.
    groups : sequence of (Fn, runs)
        Froude numbers and their runs.
    known : mapping of group to values, optional
        Derivatives that are held at known values.
    """
    fits: list[tuple[int, ChannelFit]] = []
    for number, (_, members) in enumerate(groups):
        held = (known or {}).get(number, {})
        chosen = [rows[place] for place in members]
        for channel in columns.required:
            names = [*columns.required[channel], *columns.optional[channel]]
            blocks = blocks_of(chosen, channel, names, held)
            if not blocks or not names:
                continue
            changes = [sensitivities[place] for place in members]
            fits.append(
                (
                    number,
                    _fit(channel, blocks, names, len(columns.required[channel]), changes, held),
                )
            )
    run_of = {number: list(members) for number, (_, members) in enumerate(groups)}
    return Solution(
        Fn=np.array([froude for froude, _ in groups]),
        groups=tuple(tuple(members) for _, members in groups),
        fits=tuple(fits),
        joint=join(fits, sensitivities, run_of, known or {}),
    )


def _fit(
    channel: str,
    blocks: Sequence[Block],
    names: Sequence[str],
    required: int,
    changes: Sequence[Sequence[Sensitivity]],
    held: Mapping[str, float],
) -> ChannelFit:
    """Fit once by the records' noise, and again with the scatter of each run's settings."""
    first = fit_channel(channel, blocks, names, required, {})
    values = {**held, **first.values()}
    scatter = {
        block.run: np.stack(own, axis=1)
        for block in blocks
        if (
            own := [
                change.residual(channel, values)[block.keep]
                for change in changes[block.run]
                if not change.source.shared
            ]
        )
    }
    return fit_channel(channel, blocks, names, required, scatter) if scatter else first


def to_table(
    solution: Solution,
    columns: Columns,
    campaign: Campaign,
    convention: Convention,
    *,
    method: str,
    notes: Sequence[str] = (),
    provenance: Mapping[str, Any] | None = None,
) -> DerivativeTable:
    """The solution as a DerivativeTable; zero offsets that nobody asked for stay out.

    Parameters
    ----------
    solution : Solution
        The fits.
    columns : Columns
        What was asked for.
    campaign : Campaign
        Ship and water of the table.
    convention : Convention
        Meaning of the derivatives.
    method : str
        Name of the method.
    notes, provenance
        As in DerivativeTable.
    """
    found = {name for _, name in solution.joint.labels}
    names = tuple(
        canonical(name)
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
