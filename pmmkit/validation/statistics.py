"""What is told of an error: one list for console, files, reports and pages."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from pmmkit.numerics import Array, rms


@dataclass(frozen=True, kw_only=True, eq=False)
class ChannelError:
    """The error of one run in one channel, over its harmonics or its samples.

    `error`: predicted less measured, in the unit of the channel; a position has two parts, x
    and y. `measured`: what was measured of it: a force, or how far a motion went from its
    start. `uncertainty`: expanded (k = 2), of the error. `squares, mean`: weights of squares
    that give a mean square over time, and of values that give a mean.
    """

    error: Array
    measured: Array
    uncertainty: Array
    squares: Array
    mean: Array

    @classmethod
    def of_harmonics(
        cls, error: Array, measured: Array, uncertainty: Array, labels: Sequence[str]
    ) -> ChannelError:
        """Of harmonics C0, C1, S1 …, of which the first is the mean."""
        return cls(
            error=error,
            measured=measured,
            uncertainty=uncertainty,
            squares=squares_of(labels),
            mean=np.array([float(label == "C0") for label in labels]),
        )

    @classmethod
    def of_samples(cls, error: Array, measured: Array, uncertainty: Array) -> ChannelError:
        """Of samples that count alike."""
        each = np.full(error.shape[-1], 1.0 / error.shape[-1])
        return cls(error=error, measured=measured, uncertainty=uncertainty, squares=each, mean=each)

    def rms(self, values: Array) -> float:
        """Root mean square over the time that is known, of all parts together; infinite where a
        square is."""
        known = np.isfinite(values)
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            square = np.where(known, values, 0.0) ** 2 @ self.squares
            return math.sqrt(float(np.sum(square / (known @ self.squares))) * self.squares.sum())

    @property
    def bias(self) -> float:
        """Mean error; of a position the length of it."""
        with np.errstate(over="ignore", invalid="ignore"):
            mean = self.error @ self.mean
            return float(mean if self.error.ndim == 1 else np.hypot(*mean))


def squares_of(labels: Sequence[str]) -> Array:
    """Weights (n,) of the squares of harmonics C0, C1, S1 … that give a mean square over time."""
    return np.array([1.0 if label == "C0" else 0.5 for label in labels])


@dataclass(frozen=True, kw_only=True)
class Statistic:
    """A number that is told of the error in each channel, in its unit.

    `name, title`: in files; above a column. `of`: from the error of a run. `together`: from its
    values in several runs.
    """

    name: str
    title: str
    of: Callable[[ChannelError], float]
    together: Callable[[Array], float] = rms


STATISTICS: Final = (
    Statistic(name="error", title="error", of=lambda x: x.rms(x.error)),
    Statistic(
        name="bias", title="mean error", of=lambda x: x.bias, together=lambda x: float(np.mean(x))
    ),
    Statistic(name="measured", title="measured", of=lambda x: x.rms(x.measured)),
    Statistic(name="uncertainty", title="uncertainty", of=lambda x: x.rms(x.uncertainty)),
)
"""Root mean squares over time and the mean error, as files, tables and pages tell them."""


def statistics(error: ChannelError) -> dict[str, Any]:
    """`STATISTICS` of a run in a channel, and what they come to: ``relative`` (error over
    measured), ``ratio`` (error over uncertainty) and ``within`` (whether it is less)."""
    found = {item.name: item.of(error) for item in STATISTICS}
    return {
        **found,
        "relative": _over(found, "measured"),
        "ratio": _over(found, "uncertainty"),
        "within": bool(found["error"] < found["uncertainty"]),
    }


def together(rows: Iterable[Mapping[str, Any]]) -> dict[str, Any]:
    """`STATISTICS` of several runs in a channel, ``relative``, ``ratio`` (root mean square of
    theirs: a run that may differ by much hides no other), and how many of them are ``within``."""
    listed = list(rows)
    found = {
        item.name: item.together(np.array([row[item.name] for row in listed], float))
        for item in STATISTICS
    }
    return {
        **found,
        "relative": _over(found, "measured"),
        "ratio": rms([row["ratio"] for row in listed]),
        "within": sum(row["within"] for row in listed),
    }


def _over(found: Mapping[str, float], name: str) -> float:
    """The error over another statistic."""
    return found["error"] / found[name] if found[name] else math.nan
