"""What decides a metric: local sensitivities, shares of the variance, Sobol indices."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from pmmkit.base import (
    DataError,
    Problem,
    Remedy,
    UnknownNameError,
    Way,
    Workers,
    did_you_mean,
    opened,
)
from pmmkit.conventions import METRICS, Metric
from pmmkit.inference import Propagated, Stencil
from pmmkit.models import Model
from pmmkit.numerics import Array
from pmmkit.presentation import Described, Grid, Group, Section, counted, number
from pmmkit.simulation.ensemble import Batch, batch_of, unstated
from pmmkit.simulation.kinds.catalogue import manoeuvre_of
from pmmkit.simulation.kinds.manoeuvre import Manoeuvre, Setting
from pmmkit.simulation.spread import Spread, in_kind

if TYPE_CHECKING:
    import pandas as pd

    from pmmkit.plotting import Figure

STEP: Final = 1e-3
"""Step of the differences over the size of a derivative."""
LISTED: Final = 10
"""Derivatives that a report lists."""
TIGHT: Final = 1e-11
"""Tolerance of the integration for the differences."""


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Sensitivities(Described):
    """Slopes of the metrics of a manoeuvre over the derivatives of its model.

    Parameters
    ----------
    names : tuple of str
        Derivatives, values of other parts as ``rudder_mmg.aH``, and `settings`.
    values : array (m,)
        Their values.
    slopes : mapping of str to array (m,)
        Change of each metric per unit of each derivative.
    nominal : mapping of str to float
        The metrics.
    covariance : array (m, m) or None
        Of the derivatives, where the model or a spread gives it.
    units : mapping of str to str
        Of the metrics.
    settings : tuple of str
        Those of the names that are settings of the manoeuvre which nobody states.
    """

    names: tuple[str, ...]
    values: Array
    slopes: Mapping[str, Array]
    nominal: Mapping[str, float]
    covariance: Array | None
    units: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))
    settings: tuple[str, ...] = ()

    def relative(self, metric: str) -> Array:
        """Change of a metric in per cent per per cent of each derivative."""
        return self._slopes(metric) * self.values / self.nominal[metric]

    def propagated(self, *metrics: str) -> Propagated:
        """What the errors of the names do to metrics, a source each."""
        return Propagated.of(np.array([self._slopes(x) for x in metrics]), self._covariance())

    def std(self, metric: str) -> float:
        """Standard deviation of a metric to first order.

        Raises
        ------
        DataError
            If there is no covariance.
        """
        return float(self.propagated(metric).std[0])

    def shares(self, metric: str) -> Array:
        """Share of each derivative in the variance of a metric to first order, as `Propagated`."""
        found: Array = self.propagated(metric).shares[:, 0]
        return found

    def table(self, metric: str) -> pd.DataFrame:
        """A row per derivative, the most important first."""
        import pandas as pd

        frame = pd.DataFrame(
            {
                "derivative": self.names,
                "value": self.values,
                "slope": self._slopes(metric),
                "per_cent_per_per_cent": self.relative(metric),
            }
        ).set_index("derivative")
        if self.covariance is None:
            return frame.sort_values("per_cent_per_per_cent", key=abs, ascending=False)
        frame["std"] = np.sqrt(np.diagonal(self.covariance))
        frame["share_of_variance"] = self.shares(metric)
        return frame.sort_values("share_of_variance", key=abs, ascending=False)

    def plot(self, metric: str | None = None) -> Figure:
        """Which derivatives decide a metric, the main one by default."""
        from pmmkit.simulation.figures import importance

        chosen = metric or METRICS.main(self.slopes)
        shares = self.covariance is not None
        table = self.table(chosen)
        column = "share_of_variance" if shares else "per_cent_per_per_cent"
        return importance(list(table.index), table[column].to_numpy(), chosen, shares=shares)

    def describe(self, metric: str, most: int = LISTED) -> Section:
        """What decides a metric, as a section of a report.

        Parameters
        ----------
        metric : str
            Name of the metric.
        most : int
            Derivatives that are listed.
        """
        rows = [
            [
                str(name),
                *([f"{100 * row['share_of_variance']:.1f} %"] if "std" in row else []),
                f"{row['per_cent_per_per_cent']:+.2f}",
            ]
            for name, row in self.table(metric).head(most).iterrows()
        ]
        shares = ["share of the variance"] if self.covariance is not None else []
        unit = self.units.get(metric, "").removeprefix("-")
        return Section(
            title=f"What decides {metric}, which is {number(self.nominal[metric])} {unit}".rstrip(),
            tables=[
                Grid(
                    head=[in_kind(self.names), *shares, "% per %"],
                    groups=[Group(rows=rows)],
                    caption=_listed(len(rows), self.names),
                )
            ],
        )

    def _headline(self) -> str:
        return (
            f"{counted(len(self.slopes), 'metric')} over "
            f"{counted(len(self.names), in_kind(self.names))}"
        )

    def _sections(self) -> Sequence[Section]:
        return [
            self.describe(METRICS.main(self.slopes)),
            Section(title="Metrics", paragraphs=[", ".join(METRICS.in_lengths(self.slopes))]),
        ]

    def _slopes(self, metric: str) -> Array:
        if metric not in self.slopes:
            raise UnknownNameError(
                f"There is no metric {metric!r}{did_you_mean(metric, self.slopes) or '.'} There "
                f"are: {', '.join(self.slopes)}."
            )
        return self.slopes[metric]

    def _covariance(self) -> Array:
        if self.covariance is None:
            raise DataError(
                Problem(
                    message="The model has no covariance.",
                    remedy=Remedy(
                        "Give the relative standard deviation of its derivatives ({}).",
                        (Way.setting("spread", 0.05),),
                    ),
                )
            )
        return self.covariance


def _listed(shown: int, known: Sequence[str]) -> str:
    """What a table leaves out."""
    count = counted(len(known), in_kind(known))
    return "" if shown == len(known) else f"The first {shown} of {count}."


def sensitivities(
    model: Model | str | Path,
    manoeuvre: str | Manoeuvre = "turning",
    *,
    speed: float,
    spread: float | None = None,
    names: Sequence[str] | None = None,
    executor: Workers = None,
    **settings: Any,
) -> Sensitivities:
    """Slopes of every metric over every derivative, and over what else is uncertain of a model.

    Parameters
    ----------
    model, manoeuvre, speed, spread
        As for `monte_carlo`; without covariance and spread there are slopes but no shares.
    names : sequence of str, optional
        Derivatives, and values of other parts as ``rudder_mmg.aH``; by default those of the
        covariance and those with an uncertainty of their own, or all derivatives.
    executor : int, str or concurrent.futures.Executor, optional
        As for `monte_carlo`.
    **settings
        As for `monte_carlo`, with ``fn="approach"`` alone.

    Returns
    -------
    Sensitivities

    Notes
    -----
    Central differences of fourth order, integrated to a relative tolerance of 1e-11: their own
    error is about 1e-8 of the slope.

    Examples
    --------
    >>> found = sensitivities("s175-3dof", "turning", speed=6.0, spread=0.05)
    >>> found.table("steady_diameter_L").index[0]
    'Nr'
    """
    settings = {"rtol": TIGHT, **settings}
    batch = _of_the_approach(batch_of(model, manoeuvre, speed=speed, **settings))
    loaded = batch.model
    free = unstated(manoeuvre_of(manoeuvre), settings) if names is None else []
    spreads = spread is not None or loaded.is_uncertain or bool(free)
    drawn = Spread.of(
        loaded,
        speed,
        spread if spreads else 0.5,
        extrapolate=True,
        beside=[item.name for item in free],
    )
    given = loaded.values_at(speed, extrapolate=batch.extrapolate)
    chosen = tuple(names) if names is not None else drawn.names
    known = {
        loaded.parts[part].place(name): x for part, own in given.items() for name, x in own.items()
    }
    lost = [name for name in chosen if name not in known]
    if lost:
        raise UnknownNameError(f"Model {loaded.name!r} has no {', '.join(lost)}.")
    mean = np.array([known[name] for name in chosen])
    sizes = _sizes(chosen, mean)
    values = np.vstack([Stencil(4).points(mean, STEP * np.diag(sizes)), mean])
    with opened(executor) as ready:
        metrics, _ = batch.run(chosen, values, executor=ready)
    slopes = {
        name: Stencil(4).differences(column[:-1]) / (STEP * sizes)
        for name, column in metrics.items()
    }
    for item in free:
        own = _of_a_setting(item, model, manoeuvre, speed=speed, **settings)
        slopes = {name: np.append(column, own[name]) for name, column in slopes.items()}
    covariance = None
    if spreads:
        covariance = np.diag([*np.zeros(len(chosen)), *(item.std**2 for item in free)])
        at = [i for i, name in enumerate(chosen) if name in drawn.names]
        of = [drawn.names.index(chosen[i]) for i in at]
        covariance[np.ix_(at, at)] = drawn.covariance[np.ix_(of, of)]
    return Sensitivities(
        names=(*chosen, *(item.name for item in free)),
        values=np.append(mean, [item.default or 0.0 for item in free]),
        slopes=MappingProxyType(slopes),
        nominal=MappingProxyType({name: float(x[-1]) for name, x in metrics.items()}),
        covariance=covariance,
        units=MappingProxyType(
            {name: Metric.of(name, batch.plan.metrics).unit_of(name) for name in slopes}
        ),
        settings=tuple(item.name for item in free),
    )


def _of_a_setting(
    item: Setting, model: Model | str | Path, manoeuvre: str | Manoeuvre, **settings: Any
) -> dict[str, float]:
    """Slopes of the metrics over a setting of a manoeuvre, by differences as of the values."""
    step = STEP * (abs(item.default or 0.0) or item.std)
    found: list[dict[str, float]] = []
    for (x,) in Stencil(4).points(np.array([item.default or 0.0]), np.array([[step]])):
        batch = batch_of(model, manoeuvre, **(settings | {item.name: float(x)}))
        metrics, _ = batch.run((), np.zeros((1, 0)), executor=1)
        found.append({name: float(own[0]) for name, own in metrics.items()})
    return {
        name: float(Stencil(4).differences(np.array([own[name] for own in found]))[0]) / step
        for name in found[0]
    }


def _of_the_approach(batch: Batch) -> Batch:
    """The batch, if each derivative has one value in it."""
    if batch.fn != "approach":
        raise DataError(
            "Which derivative decides a metric is asked of its value at the approach: leave "
            f"fn={batch.fn!r} out. Intervals with it come from monte_carlo."
        )
    return batch


def _sizes(names: Sequence[str], values: Array) -> Array:
    """A size for each derivative: its value, or for a zero the least of its channel."""
    sizes = np.abs(values)
    for i, name in enumerate(names):
        if sizes[i] == 0.0:
            others = [
                size
                for size, other in zip(sizes, names, strict=True)
                if other[0] == name[0] and size > 0
            ]
            sizes[i] = min(others, default=1e-4)
    return sizes


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class SobolIndices(Described):
    """Shares of the variance of each metric, of each derivative alone and with all others.

    first, total (m,).
    """

    names: tuple[str, ...]
    first: Mapping[str, Array]
    total: Mapping[str, Array]
    ships: int

    def table(self, metric: str) -> pd.DataFrame:
        """A row per derivative, the most important first."""
        import pandas as pd

        frame = pd.DataFrame(
            {"derivative": self.names, "first": self.first[metric], "total": self.total[metric]}
        )
        return frame.set_index("derivative").sort_values("total", ascending=False)

    def _headline(self) -> str:
        return (
            f"{counted(len(self.total), 'metric')} over "
            f"{counted(len(self.names), in_kind(self.names))}, "
            f"from {counted(self.ships, 'ship')}"
        )

    def _sections(self) -> Sequence[Section]:
        metric = METRICS.main(self.total)
        rows = [
            [str(name), f"{100 * row['first']:.1f} %", f"{100 * row['total']:.1f} %"]
            for name, row in self.table(metric).head(LISTED).iterrows()
        ]
        head = [in_kind(self.names), "alone", "with all others"]
        return [
            Section(
                title=f"Shares of the variance of {metric}",
                tables=[
                    Grid(
                        head=head, groups=[Group(rows=rows)], caption=_listed(len(rows), self.names)
                    )
                ],
            ),
            Section(title="Metrics", paragraphs=[", ".join(METRICS.in_lengths(self.total))]),
        ]


def sobol(
    model: Model | str | Path,
    manoeuvre: str | Manoeuvre = "turning",
    *,
    speed: float,
    spread: float | None = None,
    n: int = 1024,
    seed: int = 0,
    executor: Workers = None,
    **settings: Any,
) -> SobolIndices:
    """Sobol indices of every metric.

    Parameters
    ----------
    model, manoeuvre, speed, spread
        As for `monte_carlo`; of a covariance only the standard deviations count, because the
        indices are defined for independent inputs.
    n : int
        Base samples, a power of two; n (m + 2) ships are simulated.
    seed : int
        Of the scrambled Sobol sequence.
    executor : int, str or concurrent.futures.Executor, optional
        As for `monte_carlo`.
    **settings
        As for `monte_carlo`, with ``fn="approach"`` alone.

    Returns
    -------
    SobolIndices

    Notes
    -----
    Estimators of Saltelli et al. (2010): first order after Saltelli, total after Jansen.

    Examples
    --------
    >>> found = sobol("s175-3dof", "turning", speed=6.0, spread=0.05, n=128)
    >>> found.table("steady_diameter_L").index[0]
    'Nr'
    """
    from scipy.special import ndtri
    from scipy.stats import qmc

    if n < 2 or n & (n - 1):
        raise DataError(f"n = {n} must be a power of two.")
    batch = _of_the_approach(batch_of(model, manoeuvre, speed=speed, **settings))
    drawn = Spread.of(batch.model, speed, spread, extrapolate=batch.extrapolate)
    count = len(drawn.names)
    sequence = qmc.Sobol(2 * count, scramble=True, rng=np.random.default_rng(seed))
    normal = ndtri(np.clip(sequence.random(n), 1e-12, 1 - 1e-12))
    alone = drawn.independent
    a, b = alone.of_normal(normal[:, :count]), alone.of_normal(normal[:, count:])
    mixed = np.tile(a, (count, 1, 1))
    for i in range(count):
        mixed[i, :, i] = b[:, i]
    values = np.concatenate([a, b, mixed.reshape(-1, count)])
    with opened(executor) as ready:
        metrics, _ = batch.run(drawn.names, values, executor=ready)
    first, total = {}, {}
    for name, column in metrics.items():
        at_a, at_b, at_mixed = column[:n], column[n : 2 * n], column[2 * n :].reshape(count, n)
        there = np.isfinite(at_a) & np.isfinite(at_b) & np.isfinite(at_mixed).all(axis=0)
        if there.sum() < 2:
            first[name] = total[name] = np.full(count, np.nan)
            continue
        at_a, at_b, at_mixed = at_a[there], at_b[there], at_mixed[:, there]
        both = np.concatenate([at_a, at_b])
        middle, variance = both.mean(), both.var()
        with np.errstate(all="ignore"):
            first[name] = np.mean((at_b - middle) * (at_mixed - at_a), axis=1) / variance
            total[name] = 0.5 * np.mean((at_a - at_mixed) ** 2, axis=1) / variance
    return SobolIndices(
        names=drawn.names,
        first=MappingProxyType(first),
        total=MappingProxyType(total),
        ships=len(values),
    )
