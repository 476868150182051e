"""What check loads tell of a balance: the gain of each gauge, and the point of its moments."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from pmmkit.base import CampaignError, DataError, Problem
from pmmkit.campaigns.run import Run
from pmmkit.campaigns.setting import LENGTH
from pmmkit.campaigns.test_kinds.check_load import LOADS
from pmmkit.numerics import Array, coverage_factor
from pmmkit.signals import steady_mean

PULLEY: Final = 0.005
"""Standard uncertainty of a load, over the load: weights are known far better, but a wire that is
5° off its direction lacks 0.4 %, and a pulley of good bearings takes as much."""
CLEAR: Final = 0.01
"""Smallest singular value, of columns of unit length, from which gain, zero and point are told
apart: below, the uncertainty of each is a hundred times that of one reading."""
TELLS: Final = 0.1
"""Half interval of a gain up to which it says something of the scale: another unit, factor or sign
is off by more."""
SWAY: Final = "sway_load"


@dataclass(frozen=True, kw_only=True)
class GaugeCheck:
    """One gauge by its check loads.

    Parameters
    ----------
    channel : str
        X, Y, N or K.
    gain, std, dof : float
        What the gauge reads over what was applied, its standard uncertainty, and the degrees of
        freedom of that.
    zero : float
        What it reads without load [N, N m].
    largest : float
        The largest load, by its size [N, N m].
    runs : tuple of str
        The check loads.
    point, point_std : float
        Of N: the point about which it is stated, forward of midship [m], and its standard
        uncertainty; NaN where side loads do not tell it.
    """

    channel: str
    gain: float
    std: float
    dof: float
    zero: float
    largest: float
    runs: tuple[str, ...]
    point: float = math.nan
    point_std: float = math.nan

    @property
    def factor(self) -> float:
        """Half of a 95 % interval over the standard uncertainty."""
        return float(coverage_factor(self.dof))

    @property
    def half(self) -> float:
        """Half of the 95 % interval of the gain."""
        return self.factor * self.std

    @property
    def holds(self) -> bool:
        """Whether the interval of the gain holds 1."""
        return abs(self.gain - 1.0) <= self.half

    @property
    def agrees(self) -> bool:
        """Whether the gain is 1, and well enough known that another unit would show."""
        return self.holds and self.half <= TELLS

    @property
    def felt(self) -> bool:
        """Whether the gauge feels the loads at all: its gain is clear of zero."""
        return abs(self.gain) > self.half

    def at(self, x: float) -> bool:
        """Whether the loads say that N is stated about a point, forward of midship [m]."""
        return abs(self.point - x) <= self.factor * self.point_std


def gauge_checks(loads: Sequence[Run], moment_x: float) -> tuple[GaugeCheck, ...]:
    """What check loads tell of each gauge; of gauges that none of them loads nothing.

    Readings are a straight line over the loads, whose slope is the gain. N is that of the side
    load about the stated point, moment_x [m]; where side loads at several stations tell the point
    too, it is fitted beside the gain.
    """
    if not loads:
        return ()
    readings: list[_Reading] = []
    problems: list[Problem] = []
    for run in loads:
        try:
            readings.append((run, _read(run)))
        except DataError as error:
            problems += error.problems
    if problems:
        raise CampaignError(problems, title="Some check loads cannot be read")
    found = (_check(item.along, item.name, readings, moment_x) for item in LOADS)
    return tuple(item for item in found if item is not None)


_Reading = tuple[Run, dict[str, tuple[float, float]]]
"""A check load, and what the gauges show: mean and standard uncertainty by channel."""


def _read(run: Run) -> dict[str, tuple[float, float]]:
    data = run.data
    names = [item.along for item in LOADS if item.along in data]
    if not names:
        raise CampaignError("holds none of the channels X, Y, N, K.", run=run.id)
    if run.kind == "history":
        record = np.stack([np.asarray(data[name].values, float) for name in names])
        try:
            mean = steady_mean(np.asarray(data["t"].values, float), record)
        except DataError as error:
            raise CampaignError(
                [Problem(message=item.message, run=run.id) for item in error.problems]
            ) from error
        pairs = zip(mean.value.tolist(), mean.std.tolist(), strict=True)
        return dict(zip(names, pairs, strict=True))
    stds = {name: float(data[f"{name}_std"]) if f"{name}_std" in data else 0.0 for name in names}
    return {name: (float(data[name]), stds[name]) for name in names}


def _check(
    channel: str, load: str, readings: Sequence[_Reading], moment_x: float
) -> GaugeCheck | None:
    own = [(run, told[channel]) for run, told in readings if channel in told]
    if channel == "N":
        own = [(run, told) for run, told in own if _arm_known(run)]
    if not own:
        return None
    shown = np.array([value for _, (value, _) in own])
    noise = math.sqrt(float(np.mean([std**2 for _, (_, std) in own])))
    side = np.array([_value(run, SWAY) if channel == "N" else 0.0 for run, _ in own])
    arm = np.array([_value(run, "load_arm") for run, _ in own])
    plain = np.array([_value(run, load) for run, _ in own])
    about = plain + side * (arm - moment_x)
    if not about.any():
        return None
    one = np.ones_like(about)
    point = std = math.nan
    fit = _fitted([plain + side * arm, -side, one], shown, noise) if side.any() else None
    if fit is not None:
        (gain, moved, zero), covariance, dof = fit
        if gain:
            point = moved / gain
            slope = np.array([-point, 1.0]) / gain
            pulled = PULLEY * float(np.sqrt(np.mean((arm[side != 0] - point) ** 2)))
            std = math.hypot(math.sqrt(slope @ covariance[:2, :2] @ slope), LENGTH[0], pulled)
    else:
        fit = _fitted([about, one], shown, noise) or _fitted([about], shown, noise)
        if fit is None:
            return None
        values, covariance, dof = fit
        gain, zero = float(values[0]), float(values[1]) if len(values) > 1 else 0.0
    own_std = math.sqrt(covariance[0, 0])
    whole = math.hypot(own_std, PULLEY * abs(gain))
    return GaugeCheck(
        channel=channel,
        gain=float(gain),
        std=whole,
        dof=dof * (whole / own_std) ** 4 if own_std > 0 else math.inf,
        zero=float(zero),
        largest=float(np.abs(about).max()),
        runs=tuple(run.id for run, _ in own),
        point=float(point),
        point_std=float(std),
    )


def _value(run: Run, name: str) -> float:
    return run.settings.value(name) or 0.0


def _arm_known(run: Run) -> bool:
    """Whether the moment of a side load is known."""
    return not _value(run, SWAY) or run.settings.value("load_arm") is not None


def _fitted(
    columns: Sequence[Array], shown: Array, noise: float
) -> tuple[Array, Array, float] | None:
    """Coefficients, their covariance and degrees of freedom; None where they are not determined."""
    design = np.stack(columns, axis=1)
    size = np.linalg.norm(design, axis=0)
    if len(shown) < design.shape[1] or not np.all(size > 0):
        return None
    basis, singular, turn = np.linalg.svd(design / size, full_matrices=False)
    if singular[-1] < CLEAR:
        return None
    solve = (turn.T / singular) @ basis.T / size[:, None]
    values = solve @ shown
    left, dof = shown - design @ values, len(shown) - design.shape[1]
    scatter = math.sqrt(float(left @ left) / dof) if dof else 0.0
    return values, max(scatter, noise) ** 2 * solve @ solve.T, dof if scatter > noise else math.inf
