"""How well a model knows its values by itself."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from pmmkit.diagnosis.free_running.base import Base
from pmmkit.models import Model
from pmmkit.models.model import place_name
from pmmkit.numerics import Array

EXACT: Final = 1e-3
"""What a value that is stated without uncertainty is known to, over its usual size."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Stated:
    """Values of a model as it knows them.

    Parameters
    ----------
    names : tuple of str
        Those of the base first, then others that state an uncertainty.
    sizes : array (n,)
        Usual size of each; of the others their standard uncertainty.
    covariance, held : array (n, n)
        Over these; without what values of the base state alone.
    sure : frozenset of str
        Values of which an uncertainty is stated.
    """

    names: tuple[str, ...]
    sizes: Array
    covariance: Array
    held: Array
    sure: frozenset[str]


def stated_values(model: Model, base: Base) -> Stated:
    """The covariance of a model, and what single values state."""
    std = {
        place_name(effect, name): x
        for effect, part in model.parts.items()
        for name, x in part.std.items()
        if x > 0.0
    }
    b = len(base.names)
    more = tuple(name for name in std if name not in base.names)
    sizes = np.concatenate([base.sizes, [std[name] for name in more]])
    covariance = np.eye(b + len(more))
    covariance[:b, :b] = base.known[:b, :b]
    alone = np.array([std.get(name, 0.0) for name in base.names]) / base.sizes
    exact = EXACT**2 * np.eye(len(sizes))
    held = covariance + exact
    own = np.arange(b)
    covariance[own, own] += np.where(covariance[own, own] == 0.0, alone**2, 0.0)
    names = (*base.names, *more)
    known = np.diagonal(covariance) > 0.0
    return Stated(
        names=names,
        sizes=sizes,
        covariance=covariance + exact,
        held=held,
        sure=frozenset(name for name, there in zip(names, known.tolist(), strict=True) if there),
    )
