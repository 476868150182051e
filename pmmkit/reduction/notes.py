"""What the fits say, in plain words: identifiability, offsets, lack of fit."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from pmmkit.conventions import parse_derivative
from pmmkit.presentation import at_froude, counted, listed
from pmmkit.reduction.estimate import ChannelFit
from pmmkit.reduction.observations.equations import Rows
from pmmkit.reduction.solve import Solution

TOGETHER = 0.95
"""Correlation from which two derivatives are said to move together."""
INFLATED = 30.0
"""Variance inflation from which a derivative is said to be hard to tell from the others."""


@dataclass(frozen=True, kw_only=True)
class Offset:
    """Force at zero drift, yaw rate and rudder.

    `Fn`: Froude number; NaN for all speeds. `channel`: Y, N or K. `value, std`: non-dimensional
    offset and its standard uncertainty. `drift_deg`: drift angle that would give the same force
    [deg]; None where no slope is known.
    """

    Fn: float
    channel: str
    value: float
    std: float
    drift_deg: float | None

    @property
    def clear(self) -> bool:
        """Whether it is larger than twice its uncertainty."""
        return abs(self.value) > 2 * self.std


def tests_for(name: str) -> str:
    """Which tests excite a derivative.

    Examples
    --------
    >>> tests_for("Nvvr")
    'yaw with drift or circular motion with drift'
    """
    factors = parse_derivative(name).variables
    choices = (
        ({"d", "v"}, "drift with rudder"),
        ({"d", "r"}, "yaw with rudder"),
        ({"d"}, "static rudder"),
        ({"phi", "v"}, "heeled drift"),
        ({"phi"}, "static heel"),
        ({"vdot"}, "pure sway"),
        ({"rdot"}, "pure yaw"),
        ({"udot"}, "pure surge, or pure yaw at large heading"),
        ({"v", "r"}, "yaw with drift or circular motion with drift"),
        ({"v"}, "static drift or pure sway"),
        ({"r"}, "pure yaw or circular motion"),
        ({"u"}, "runs at several speeds"),
        ({"p"}, "roll decay"),
    )
    return next((test for needed, test in choices if needed <= factors), "more runs")


def offsets(solution: Solution) -> tuple[Offset, ...]:
    """The zero offsets that were fitted beside the derivatives."""
    found = []
    value = dict(zip(solution.joint.labels, solution.joint.value.tolist(), strict=True))
    std = dict(
        zip(solution.joint.labels, np.sqrt(np.diagonal(solution.joint.covariance)), strict=True)
    )
    for group, item in solution.fits:
        key = (group, f"{item.channel}0")
        if key not in value or math.isnan(value[key]):
            continue
        slope = value.get((group, f"{item.channel}v"), math.nan)
        found.append(
            Offset(
                Fn=float(solution.Fn[group]),
                channel=item.channel,
                value=value[key],
                std=float(std[key]),
                drift_deg=None
                if math.isnan(slope) or slope == 0
                else math.degrees(-value[key] / slope),
            )
        )
    return tuple(found)


def notes(solution: Solution, rows: Sequence[Rows]) -> tuple[str, ...]:
    """Sentences on what the runs do and do not determine."""
    return (
        *_not_excited(solution),
        *dict.fromkeys(_sentences(solution)),
        *_ramps(rows),
        *_smoothed(rows),
    )


def misfits(solution: Solution) -> tuple[str, ...]:
    """Those sentences of `notes` that say how far a structure is from its tests."""
    return tuple(
        _misfit(item, at_froude(solution.Fn[group]))
        for group, item in solution.fits
        if item.excessive
    )


def _misfit(item: ChannelFit, where: str) -> str:
    return (
        f"{item.channel}{where}: the misfit is {math.sqrt(item.scale):.1f} times the noise of the "
        f"records, and scatter between runs does not explain it. The structure lacks something; "
        f"the intervals are wider, but do not hold its bias."
    )


def _ramps(rows: Sequence[Rows]) -> Iterator[str]:
    """Oscillating records of which a ramp of carriage or oscillator was cut."""
    cut = [f"{item.result.run.id} {item.result.ramp}" for item in rows if item.result.ramp]
    if cut:
        yield (
            f"Carriage or oscillator start or stop within "
            f"{counted(len(cut), 'oscillating record')}; cycles count from where both are at "
            f"their size. Left out: {'; '.join(cut)}."
        )


def _smoothed(rows: Sequence[Rows]) -> Iterator[str]:
    """Oscillating records that say nothing of their noise."""
    orders = [item.result.smoothed for item in rows if item.result.smoothed is not None]
    if orders:
        yield (
            f"{counted(len(orders), 'oscillating record')} hold nothing but harmonics up to number "
            f"{max(orders)}: they were smoothed before they were handed in. They do not tell their "
            f"own noise; it is that of the records like them, and the scatter between the runs."
        )


def _not_excited(solution: Solution) -> Iterator[str]:
    """One sentence for all derivatives that lack the same tests at the same speeds."""
    missing: dict[tuple[str, str], list[int]] = {}
    for group, item in solution.fits:
        tied = {name for names in item.fit.tied for name in names}
        for column, name in enumerate(item.fit.names):
            if not item.fit.determined[column] and name not in tied:
                missing.setdefault((tests_for(name), name), []).append(group)
    alike: dict[tuple[str, tuple[int, ...]], list[str]] = {}
    for (test, name), lacking in missing.items():
        alike.setdefault((test, tuple(lacking)), []).append(name)
    for (test, groups), names in alike.items():
        where = _speeds(solution, groups)
        verb, has = ("is", "has") if len(names) == 1 else ("are", "have")
        yield f"{listed(names)}{where} {verb} not excited by these runs and {has} no value: " + (
            f"that takes {test}."
        )


def _speeds(solution: Solution, groups: Sequence[int]) -> str:
    if len(groups) == len(solution.Fn) > 1:
        return " at all Froude numbers"
    numbers = [f"{solution.Fn[group]:.3f}" for group in groups]
    return "" if math.isnan(solution.Fn[groups[0]]) else f" at Fn {listed(numbers)}"


def _sentences(solution: Solution) -> Iterator[str]:
    for group, item in solution.fits:
        where = at_froude(solution.Fn[group])
        for names in item.fit.tied:
            yield (
                f"{listed(names)}{where}: only a combination is determined, so none has a value. "
                f"Leave one out, or add {tests_for(names[-1])} at another amplitude."
            )
        yield from _together(item, where)
        yield from _signs(item, where)
        if item.excessive:
            yield _misfit(item, where)
        elif math.isnan(item.chi_square) and item.freedom == 0:
            yield (
                f"{item.channel}{where}: as many coefficients as rows and no stated noise, "
                f"so no uncertainty can be given."
            )


def _together(item: ChannelFit, where: str) -> Iterator[str]:
    gain = item.plain.gain
    covariance = gain @ gain.T
    with np.errstate(divide="ignore", invalid="ignore"):
        scale = np.sqrt(np.diagonal(covariance))
        correlation = covariance / np.outer(scale, scale)
    for first in range(len(item.fit.names)):
        for second in range(first + 1, len(item.fit.names)):
            value = correlation[first, second]
            if abs(value) > TOGETHER:
                names = f"{item.fit.names[first]} and {item.fit.names[second]}"
                yield (
                    f"{names}{where} move together (correlation {value:+.3f}): the runs fix a "
                    f"combination better than each of them."
                )
    for name, inflation in zip(item.fit.names, item.plain.inflation.tolist(), strict=True):
        if inflation > INFLATED:
            yield (
                f"{name}{where} resembles other terms in these runs: its variance is "
                f"{inflation:.0f} times what it would be alone (condition number of "
                f"{item.channel} {item.plain.condition:.0f})."
            )


def _signs(item: ChannelFit, where: str) -> Iterator[str]:
    for name, value in item.values().items():
        if name in ("Xudot", "Yvdot", "Nrdot", "Kpdot") and value > 0:
            yield (
                f"{name}{where} = {value:.3g} is positive, which no added mass is: check the "
                f"inertia and the units of the forces."
            )
        if name in ("Yv", "Nr") and value > 0:
            yield f"{name}{where} = {value:.3g} is positive: damping that drives. Check the signs."
