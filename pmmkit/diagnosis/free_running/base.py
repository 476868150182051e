"""What is known of a model's values before free-running records are asked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from pmmkit.effects import CATALOGUE
from pmmkit.identification import FreeRecord, Prior
from pmmkit.models import Model, Part, Sailing
from pmmkit.numerics import Array

SPREAD: Final = 0.15
"""Largest share of their usual sizes by which the values of a model may be off."""
STEPS: Final = (0.0, 0.03, 0.1, 0.3, 1.0)
"""Shares of the spread that are weighed against each other, none of it among them."""
JITTER: Final = 1e-9


@dataclass(frozen=True, kw_only=True, eq=False)
class FreeBase:
    """Values that may move, and by how much.

    `names`: values of the model. `sizes (b,)`: usual size of each. `known (b + g, b + g)`:
    covariance that holds whatever the spread is, over the sizes; after the values, that of the
    coefficients of effects that the base has. `spreads (s,)`: standard deviations over the
    sizes that are weighed against each other, beside it.
    """

    names: tuple[str, ...]
    sizes: Array
    known: Array
    spreads: Array

    def within(self, count: int) -> FreeBase:
        """The same with the first, smallest spreads alone; the first is none."""
        return replace(self, spreads=self.spreads[:count])

    def having(self, coefficients: int) -> FreeBase:
        """The same with effects of so many coefficients, each as wide as a candidate's."""
        width = len(self.known)
        known = np.eye(width + coefficients)
        known[:width, :width] = self.known
        return replace(self, known=known)

    def root(self, spread: float) -> Array:
        """Root (b + g, m) of the covariance at a spread, with a column for each of the m numbers
        that may move."""
        whole = self.known.copy()
        values = np.arange(len(self.sizes))
        whole[values, values] += spread**2
        moves = np.diagonal(whole) > 0.0
        scale = np.sqrt(np.diagonal(whole)[moves])
        correlation = whole[np.ix_(moves, moves)] / np.outer(scale, scale)
        covariance_root = np.zeros((len(whole), len(scale)))
        covariance_root[moves] = scale[:, None] * np.linalg.cholesky(
            correlation + JITTER * np.eye(len(scale))
        )
        return covariance_root


def idle(part: Part) -> bool:
    """Whether all that is uncertain of a part with a candidate of its own is zero."""
    own = [part.values.get(item.name) for item in part.known.parameters if item.uncertain]
    return "waves" in part.known.roles and not any(own)


def movable(model: Model) -> tuple[str, ...]:
    """Derivatives of hull, rudder and added mass, and the uncertain values of other parts.

    A table of wave drift whose factors are zero waits to be asked for: it does not act, and no base
    moves it.
    """
    others = [
        f"{part.effect}.{item.name}"
        for part in model.parts.values()
        for item in part.known.parameters
        if item.uncertain and item.name in part.values and not idle(part)
    ]
    return (*model.derivatives, *others)


def base_of(
    model: Model, speed: float, *, spread: float = SPREAD, extrapolate: bool = False
) -> FreeBase:
    """The values of a model, its covariance, and a spread that the records have to tell.

    speed [m/s].

    Examples
    --------
    >>> from pmmkit.models import load_model
    >>> found = base_of(load_model("kvlcc2-l7"), 1.179)
    >>> len(found.names), found.spreads.tolist()
    (25, [0.0, 0.0045, 0.015, 0.045, 0.15])
    """
    names = movable(model)
    own = Prior.of(model, names, speed, spread=dict.fromkeys(names, 1.0), extrapolate=extrapolate)
    usual = usual_sizes(model, speed)
    sizes = np.array(
        [max(size, usual.get(name, 0.0)) for name, size in zip(names, own.std, strict=True)]
    )
    stated = Prior.of(model, names, speed, spread=None, extrapolate=extrapolate)
    there = np.isin(names, model.covariance_names)
    known = np.where(np.outer(there, there), stated.covariance, 0.0) / np.outer(sizes, sizes)
    return FreeBase(
        names=names, sizes=sizes, known=known, spreads=np.round(spread * np.array(STEPS), 12)
    )


def stated_base(prior: Prior) -> FreeBase:
    """A base that is known as it is stated, and no further."""
    sizes = prior.std
    return FreeBase(
        names=prior.names,
        sizes=sizes,
        known=prior.covariance / np.outer(sizes, sizes),
        spreads=np.zeros(1),
    )


def usual_sizes(model: Model, speed: float) -> dict[str, float]:
    """Usual sizes of values by name, as the effects of the catalogue have them.

    A value of a model may be far smaller than it usually is, and be off by more than itself.
    """
    vessel = Sailing(model, speed)
    sizes: dict[str, float] = {}
    for effect in CATALOGUE.values():
        asked = effect.kind in ("terms", "freed") and effect.frees in ("", *model.parts)
        if not asked or effect.varies_with_speed:
            continue
        for move in vessel.moves(effect).values():
            for name, share in move.values.items():
                sizes[name] = max(sizes.get(name, 0.0), abs(share * move.typical))
    return sizes


def known_faults(model: Model, records: Sequence[FreeRecord]) -> tuple[str, ...]:
    """Names of the faults that a model's steps tell of records, each once."""
    titles = dict.fromkeys(record.campaign for record in records)
    return tuple(dict.fromkeys(name for x in titles for name in model.faults_of(x)))
