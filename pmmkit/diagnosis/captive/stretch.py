"""Several runs one after another, so that their samples are looked at together."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate, pairwise
from types import MappingProxyType
from typing import Final

import numpy as np

from pmmkit.numerics import Array
from pmmkit.observations.views import View

SAMPLES: Final = 2048
"""Samples that are looked at together: many more of them leave the processor's cache."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Stretch:
    """Views one after another.

    Parameters
    ----------
    views : tuple of View
        One or more.
    """

    views: tuple[View, ...]

    @cached_property
    def _edges(self) -> list[int]:
        return list(accumulate((len(view.motion.u) for view in self.views), initial=0))

    @property
    def size(self) -> int:
        """Number of samples."""
        return self._edges[-1]

    @property
    def samples(self) -> list[slice]:
        """Those of each view."""
        return [slice(begin, end) for begin, end in pairwise(self._edges)]

    def each(self, values: Sequence[float]) -> Array:
        """A number of each view at its samples (n,)."""
        return np.repeat(values, np.diff(self._edges))

    def means(self, history: Array) -> Array:
        """Mean of a history (n,) in each view."""
        found: Array = np.add.reduceat(history, self._edges[:-1]) / np.diff(self._edges)
        return found

    def history(self, name: str) -> Array:
        """One of the histories of the motion (n,)."""
        return np.concatenate([getattr(view.motion, name) for view in self.views])


def stretches(views: Sequence[View]) -> Iterator[Stretch]:
    """Views in their order, as many in one stretch as have `SAMPLES` samples together."""
    held: list[View] = []
    count = 0
    for view in views:
        if held and count + len(view.motion.u) > SAMPLES:
            yield Stretch(views=tuple(held))
            held, count = [], 0
        held.append(view)
        count += len(view.motion.u)
    if held:
        yield Stretch(views=tuple(held))


MOTION: Final[Mapping[str, Callable[[Stretch], Array]]] = MappingProxyType(
    {
        "u": lambda s: s.history("u"),
        "v": lambda s: s.history("v"),
        "r": lambda s: s.history("r"),
        "p": lambda s: s.history("p"),
        "phi": lambda s: s.history("phi"),
        "delta": lambda s: s.history("delta"),
        "n": lambda s: s.history("rps"),
        "U": lambda s: np.hypot(s.history("u"), s.history("v")),
        "beta": lambda s: np.arctan2(-s.history("v"), s.history("u")),
        "sinkage": lambda s: s.history("sinkage"),
        "trim": lambda s: s.history("trim"),
    }
)
"""What an effect may ask for of the motion."""
