"""A campaign in water of several depths: a reduction of each, and how derivatives grow."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from pmmkit.base import DataError
from pmmkit.campaigns import Campaign
from pmmkit.effects import apply
from pmmkit.models import DerivativeTable, TablesByDepth
from pmmkit.numerics import Array, coverage_factor
from pmmkit.presentation import WIDE, plus_minus
from pmmkit.reduction.reduce import Reduction, reduce_campaign

TOLD: Final = ("Xuu", "Yv", "Yr", "Nv", "Nr", "Yvdot", "Nrdot")
"""Derivatives of whose growth people speak; the others are in the tables."""
ROUNDS: Final = 30
"""Steps to the line of best fit: each leaves a small part of what the step before left."""


@dataclass(frozen=True, kw_only=True)
class Growth:
    """By how much a derivative is larger than in the deepest water of a campaign.

    Parameters
    ----------
    name : str
        The derivative.
    ratio, deepest : float
        Depth of the water over the draught, here and where the factor is 1.
    factor, std : float
        Its value over that in the deepest water, one for the Froude numbers of both; and its
        standard uncertainty, the errors of two depths as independent.
    half : float
        Half of the 95 % interval.
    laws : (float, float)
        What `pmmkit.effects.shallow_water` multiplies the value of deep water by, in the deepest
        water of the tests and here; NaN where its formulas do not hold.
    """

    name: str
    ratio: float
    deepest: float
    factor: float
    std: float
    half: float
    laws: tuple[float, float]

    @classmethod
    def of(cls, tables: TablesByDepth) -> tuple[Growth, ...]:
        """How derivatives grow from the deepest water to the others, beside the formulas.

        Parameters
        ----------
        tables : TablesByDepth
            Of one ship.
        """
        return tuple(item for shallow in tables.tables[1:] for item in _grown(tables, shallow))

    @property
    def formula(self) -> float:
        """The factor by the formulas; NaN where they do not hold."""
        return self.laws[1] / self.laws[0]

    def of_share(self, share: float) -> float:
        """The factor where a share of what the formulas add is felt."""
        return (1.0 + share * (self.laws[1] - 1.0)) / (1.0 + share * (self.laws[0] - 1.0))


@dataclass(frozen=True, kw_only=True)
class Felt:
    """How much of the effect `shallow_water` the growth between two depths shows.

    Parameters
    ----------
    ratio, deepest : float
        Depths of the water over the draught.
    share, half : float
        Share of what the formulas add (0 none, 1 as they say), and half of its 95 % interval, wider
        where the derivatives do not agree on it.
    left, without : float
        Root mean square of what the growth departs from the formulas with that share, and from
        none at all, in standard uncertainties.
    """

    ratio: float
    deepest: float
    share: float
    half: float
    left: float
    without: float

    @classmethod
    def of(cls, grown: Sequence[Growth]) -> tuple[Felt, ...]:
        """The share of the formulas of shallow water that the growth to each depth shows.

        One for each depth at which the formulas hold; resistance takes no part: a ship that propels
        herself shows none.
        """
        found = []
        for ratio in dict.fromkeys(item.ratio for item in grown):
            own = [x for x in grown if x.ratio == ratio and x.name != "Xuu" and x.std > 0]
            own = [x for x in own if math.isfinite(x.formula)]
            if len(own) > 1:
                found.append(_felt(own))
        return tuple(found)

    def __str__(self) -> str:
        return (
            f"h/T {self.ratio:.4g}: of what the formulas of shallow_water add since h/T "
            f"{self.deepest:.4g} a share of {plus_minus(self.share, self.half)} is felt (0 none, 1 "
            f"as they say); growth departs from that by {self.left:.1f} standard uncertainties, "
            f"from no growth by {self.without:.1f}."
        )


def reduce_depths(campaign: Campaign, **settings: Any) -> tuple[Reduction, ...]:
    """A reduction at each depth of the water, the deepest first."""
    return tuple(reduce_campaign(part, **settings) for part in campaign.by_depth())


def _grown(tables: TablesByDepth, shallow: DerivativeTable) -> Iterator[Growth]:
    deep = tables.tables[0]
    one, other = tables.in_step(shallow)
    ship, depths = shallow.ship, (deep.water.depth or math.inf, shallow.water.depth or math.inf)
    for name in TOLD:
        if name not in one or name not in other:
            continue
        a, b = one[name], other[name]
        places = one.index(name), other.index(name)
        std = [x.std[:, place] for x, place in zip((one, other), places, strict=True)]
        dof = np.minimum(one.dof[:, places[0]], other.dof[:, places[1]])
        found = _mean_ratio(a, b, *std)
        if found is None:
            continue
        factor, error, used = found
        laws = (math.nan, math.nan)
        with suppress(DataError):  # the formulas hold down to some depth
            before, after = (
                apply({name: 1.0}, ship=ship, depth=x / ship.d * ship.d, nearly=tables.NEARLY)
                for x in depths
            )
            laws = (float(before[name]), float(after[name]))
        yield Growth(
            name=name,
            ratio=depths[1] / ship.d,
            deepest=depths[0] / ship.d,
            factor=factor,
            std=error,
            half=float(coverage_factor(dof[used].min())) * error,
            laws=laws,
        )


def _felt(own: Sequence[Growth]) -> Felt:
    from scipy.optimize import least_squares

    def away(share: float) -> Array:
        return np.array([(item.factor - item.of_share(share)) / item.std for item in own])

    fit = least_squares(lambda x: away(float(x[0])), [1.0])
    share, left = float(fit.x[0]), away(float(fit.x[0]))
    variance = 1.0 / float(np.sum(fit.jac**2))
    scatter = float(np.sum(left**2)) / (len(own) - 1)
    return Felt(
        ratio=own[0].ratio,
        deepest=own[0].deepest,
        share=share,
        half=WIDE * math.sqrt(variance * max(scatter, 1.0)),
        left=float(np.sqrt(np.mean(left**2))),
        without=float(np.sqrt(np.mean(away(0.0) ** 2))),
    )


def _mean_ratio(
    a: Array, b: Array, std_a: Array, std_b: Array
) -> tuple[float, float, Array] | None:
    """The ratio b/a that both columns fit best, its standard uncertainty, and what was used.

    A line through the origin with errors in both (York 1966); where the Froude numbers scatter
    about it by more than their errors, these are larger by that (Birge 1932).
    """
    used = np.isfinite(a) & np.isfinite(b) & np.isfinite(std_a) & np.isfinite(std_b) & (a != 0)
    if not used.any() or not np.any(np.abs(a[used]) > 2 * std_a[used]):
        return None
    a, b, std_a, std_b = (x[used] for x in (a, b, std_a, std_b))
    factor = float(a @ b / (a @ a))
    if not np.all(std_a > 0) or not np.all(std_b > 0):
        return factor, 0.0, used
    for _ in range(ROUNDS):
        spread = std_b**2 + (factor * std_a) ** 2
        settled = (a * std_b**2 + factor * b * std_a**2) / spread
        factor = float(settled @ (b / spread) / (settled @ (a / spread)))
    left = float(np.sum((b - factor * a) ** 2 / spread))
    wider = math.sqrt(max(left / max(len(a) - 1, 1), 1.0))
    return factor, wider * float(np.sum(settled**2 / spread) ** -0.5), used
