"""Many ships at once: what the uncertainty of the derivatives does to a manoeuvre."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise, product
from pathlib import Path
from statistics import NormalDist
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np

from pmmkit.base import DataError, Progress, Workers, each, opened
from pmmkit.conventions import METRICS, Metric
from pmmkit.equations import (
    Conditions,
    DenseHistory,
    EquationStructure,
    Gear,
    Plan,
    Prepared,
    Revolutions,
    Status,
    packed_following,
    run_plan,
    run_ships,
)
from pmmkit.models import Model, Standing, load_model, with_open_couplings
from pmmkit.numerics import Array
from pmmkit.presentation import Described, Grid, Group, Section, counted, number
from pmmkit.simulation.froude import Follow, FroudeRange, froude_range, prepared
from pmmkit.simulation.kinds.catalogue import manoeuvre_of
from pmmkit.simulation.kinds.manoeuvre import Manoeuvre, Setting
from pmmkit.simulation.single import ENVIRONMENT, RudderLaw, check_request, gear_of, ship_for
from pmmkit.simulation.spread import CHUNK, Draws, Spread, drawn_of, in_kind

if TYPE_CHECKING:
    import pandas as pd

    from pmmkit.plotting import Figure

Sailed = tuple[dict[str, Array], Array]
"""Metrics (n,) by name, and the status (n,) of each ship."""
SENT: Final = 2500
"""Ships that are sent at a time, some 0.1 s of work."""
STRATA: Final = 10
"""Equal shares of the ships, each with one value of a setting that nobody states."""
ROUNDING: Final = 1e-12
"""Differences of a metric, in whatever unit, below which they are of arithmetic."""


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Ensemble(Described):
    """A manoeuvre of many ships that differ in their derivatives.

    Parameters
    ----------
    metrics : mapping of str to array (n,)
        As of a Track; NaN where a ship does not come that far or cannot be simulated.
    nominal : mapping of str to float
        The same for the model as it stands.
    names : tuple of str
        Derivatives, values of other parts and settings that differ.
    failed : int
        Ships whose motion grows without bound or whose mass matrix is not positive.
    speed, Fn : float
        Approach speed [m/s] and its Froude number.
    seed : int
        Of the draws.
    origin : str
        Where the differences come from.
    name, manoeuvre, scale : str
        Of the model and the manoeuvre.
    units : mapping of str to str
        Of the metrics.
    tested : FroudeRange, optional
        Of the model as it stands, where derivatives follow the Froude number of the moment.
    standing : Standing
        What the numbers of the model stand on.
    """

    metrics: Mapping[str, Array]
    nominal: Mapping[str, float]
    names: tuple[str, ...]
    failed: int
    speed: float
    Fn: float
    seed: int
    origin: str
    name: str
    manoeuvre: str
    scale: str
    units: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))
    tested: FroudeRange | None = None
    standing: Standing = field(default_factory=Standing)
    SHOWN: ClassVar[int] = 3
    """Metrics that are drawn as distributions where none are named."""

    def __len__(self) -> int:
        return len(next(iter(self.metrics.values())))

    def interval(self, metric: str, level: float = 0.95) -> tuple[float, float]:
        """Central interval of a metric, by quantiles of the ships that have it."""
        values = self.metrics[metric][np.isfinite(self.metrics[metric])]
        if not len(values):
            return np.nan, np.nan
        low, high = np.quantile(values, [0.5 - level / 2, 0.5 + level / 2])
        return float(low), float(high)

    def probability(self, metric: str, limit: float) -> float:
        """Share of ships whose metric is at most a limit; ships without it count as above."""
        return float(np.mean(self.metrics[metric] <= limit))

    def summary(self, level: float = 0.95) -> pd.DataFrame:
        """Nominal value, mean, standard deviation, interval and count of each metric."""
        import pandas as pd

        rows = []
        for name, values in self.metrics.items():
            there = values[np.isfinite(values)]
            low, high = self.interval(name, level)
            rows.append(
                {
                    "metric": name,
                    "nominal": self.nominal[name],
                    "mean": float(there.mean()) if len(there) else np.nan,
                    "std": float(there.std(ddof=1)) if len(there) > 1 else np.nan,
                    "low": low,
                    "high": high,
                    "ships": len(there),
                }
            )
        return pd.DataFrame(rows).set_index("metric")

    def to_pandas(self) -> pd.DataFrame:
        """A row per ship, a column per metric."""
        import pandas as pd

        return pd.DataFrame(dict(self.metrics))

    def plot(self, metrics: Sequence[str] | None = None) -> Figure:
        """How metrics are distributed, with the model as it stands and IMO limits nearby.

        Parameters
        ----------
        metrics : sequence of str, optional
            Up to four; the main one and those after it by default.
        """
        from pmmkit.simulation.figures import distributions

        chosen = list(metrics or self.varying()[: self.SHOWN])
        return distributions(
            {name: self.metrics[name] for name in chosen},
            self.nominal,
            {name: self.interval(name) for name in chosen},
            self.units,
        )

    def varying(self) -> list[str]:
        """The metrics that differ between the ships, the main one first."""
        first = METRICS.main(self.metrics)
        names = [first, *(name for name in METRICS.in_lengths(self.metrics) if name != first)]
        return [name for name in names if name == first or _differs(self.metrics[name])]

    def _headline(self) -> str:
        return (
            f"{counted(len(self), 'ship')} like {self.name}, {self.manoeuvre.replace('_', ' ')} at "
            f"{self.speed:.2f} m/s: {self.failed} could not be simulated"
        )

    def _sections(self) -> Sequence[Section]:
        rows = []
        for name in METRICS.in_lengths(self.metrics):
            values = self.metrics[name][np.isfinite(self.metrics[name])]
            std = float(values.std(ddof=1)) if len(values) > 1 else np.nan
            numbers = (self.nominal[name], std, *self.interval(name))
            unit = self.units.get(name, "")
            rows.append([name, *(number(x) for x in numbers), unit, str(len(values))])
        head = ["metric", "as it is", "std", "2.5 %", "97.5 %", "unit", "ships"]
        return [
            Section(
                paragraphs=[
                    f"Fn {self.Fn:.3f}; {self.scale}",
                    f"{counted(len(self.names), in_kind(self.names))} drawn from {self.origin}, "
                    f"seed {self.seed}",
                    *([self.tested.words] if self.tested else []),
                    *self.standing.sentences,
                ]
            ),
            Section(title="Metrics", tables=[Grid(head=head, groups=[Group(rows=rows)])]),
        ]


def _differs(values: Array) -> bool:
    there = values[np.isfinite(values)]
    return len(there) > 1 and float(np.ptp(there)) > ROUNDING


@dataclass(frozen=True, kw_only=True, eq=False)
class Batch:
    """One manoeuvre of one model, to be run with other values of its derivatives.

    `model`: everything that does not differ. `gear`: how the controls follow. `speed, rtol`:
    approach speed [m/s], relative tolerance. `revolutions`: of the approach [1/s].
    `extrapolate`: allow a speed outside the range of the model's values.
    """

    model: Model
    plan: Plan
    gear: Gear
    speed: float
    rtol: float = Prepared.RTOL
    conditions: Conditions = field(default_factory=Conditions)
    revolutions: Revolutions = None
    extrapolate: bool = False
    fn: Follow = "approach"

    def run(
        self,
        names: Sequence[str],
        values: Array,
        *,
        executor: Executor | int | None = None,
        advance: Callable[[int], object] | None = None,
    ) -> Sailed:
        """Metrics (n,) by name, and the status of each ship.

        For values (n, len(names)) at the approach; where derivatives follow the speed, for those
        at all `Model.known_speeds`, (n, speeds len(names)). A number of threads, or an executor as
        `opened` gives it.
        """
        if isinstance(executor, Executor):
            pieces = [values[first : first + SENT] for first in range(0, len(values), SENT)]
            called = [f"ships {SENT * i} to {SENT * i + len(x) - 1}" for i, x in enumerate(pieces)]
            work = partial(Batch.run, self, names, executor=1)
            done = dict(each(work, pieces, executor, names=called))
            parts = [done[place] for place in range(len(pieces))]
            joined = {x: np.concatenate([own[x] for own, _ in parts]) for x in parts[0][0]}
            return joined, np.concatenate([status for _, status in parts])
        structure, k = self._packed(names, values)
        results, status = run_ships(
            structure,
            k,
            len(values),
            self.plan,
            self.gear,
            speed=self.speed,
            rtol=self.rtol,
            revolutions=self.revolutions,
            jobs=executor,
            advance=advance,
        )
        with np.errstate(all="ignore"):
            metrics = {
                name: np.ascontiguousarray(x) for name, x in self.plan.metrics_of(results).items()
            }
        return metrics, status

    def nominal_range(self) -> FroudeRange | None:
        """Which Froude numbers the model as it stands has in the manoeuvre, where that counts."""
        if self.fn == "approach":
            return None
        ready = prepared(
            self.model,
            self.speed,
            self.fn,
            conditions=self.conditions,
            extrapolate=self.extrapolate,
        )
        return froude_range(self.model, self.history(ready, fast=True))

    def history(self, ready: Prepared, *, fast: bool | None) -> DenseHistory:
        """One ship of it, sailed."""
        return run_plan(
            ready, self.plan, self.gear, rtol=self.rtol, fast=fast, revolutions=self.revolutions
        )

    def ship(self, names: Sequence[str], values: Array) -> Prepared:
        """One ship with values of its own, as of one row of `run`, ready to be integrated."""
        structure, k = self._packed(names, values[None])
        return Prepared(
            structure=structure,
            k=tuple(float(np.asarray(x).item()) for x in k),
            speed=self.speed,
            name=self.model.name,
        )

    def _packed(self, names: Sequence[str], values: Array) -> tuple[EquationStructure, list[Any]]:
        speeds = self.model.known_speeds(self.speed) if self.fn == "instant" else ()
        if not speeds:
            given = self._given(self.speed, names, values)
            return packed_following(self.model, given, (), (), self.speed, self.conditions)
        by_speed = values.reshape(len(values), len(speeds), len(names))
        share = [np.interp(self.speed, speeds, row) for row in np.eye(len(speeds))]
        at_approach = np.einsum("isj,s->ij", by_speed, share)
        return packed_following(
            self.model,
            self._given(self.speed, names, at_approach),
            speeds,
            [self._given(each, names, by_speed[:, i]) for i, each in enumerate(speeds)],
            self.speed,
            self.conditions,
        )

    def _given(
        self, speed: float, names: Sequence[str], values: Array
    ) -> Mapping[str, Mapping[str, Any]]:
        """Values of the parts at a speed, with those of the ships in their places."""
        given = self.model.values_at(speed, extrapolate=self.extrapolate)
        for column, name in enumerate(names):
            effect, dot, own = name.rpartition(".")
            for home in (effect,) if dot else self.model.derivative_parts:
                if own in given.get(home, {}):
                    given[home][own] = values[:, column]
                    break
        return given


def batch_of(
    model: Model | str | Path,
    manoeuvre: str | Manoeuvre,
    *,
    speed: float,
    fn: Follow = "approach",
    rtol: float = Prepared.RTOL,
    rudder_rate_deg: float | None = None,
    rudder_law: RudderLaw = "ramp",
    rudder_lag: float = 1.0,
    revolutions: Revolutions = None,
    extrapolate: bool = False,
    **settings: Any,
) -> Batch:
    """A batch of a manoeuvre; arguments as for `simulate`."""
    loaded = model if isinstance(model, Model) else load_model(model)
    around = {name: x for name, x in settings.items() if name in ENVIRONMENT}
    settings = {name: x for name, x in settings.items() if name not in ENVIRONMENT}
    chosen = manoeuvre_of(manoeuvre)
    check_request(
        chosen,
        settings,
        around,
        speed=speed,
        fn=fn,
        rudder_rate_deg=rudder_rate_deg,
        rtol=rtol,
        rudder_law=rudder_law,
        rudder_lag=rudder_lag,
        revolutions=None if revolutions == "speed" else revolutions,
    )
    loaded = with_open_couplings(ship_for(chosen, loaded, speed, settings, extrapolate=extrapolate))
    conditions = Conditions(**around)
    pace = speed / loaded.ship.L
    plan = chosen.plan(
        pace, speed=speed, wind=conditions.wind_speed > 0.0, bucket=loaded.has_bucket, **settings
    )
    return Batch(
        model=loaded,
        plan=plan,
        gear=gear_of(
            loaded, plan, pace, rudder_rate_deg, rudder_lag if rudder_law == "lag" else 0.0
        ),
        speed=speed,
        rtol=rtol,
        conditions=conditions,
        revolutions=revolutions,
        extrapolate=extrapolate,
        fn=fn,
    )


def monte_carlo(
    model: Model | str | Path,
    manoeuvre: str | Manoeuvre = "turning",
    *,
    speed: float,
    n: int = 10_000,
    spread: float | Draws | None = None,
    seed: int = 0,
    executor: Workers = None,
    progress: Progress | None = None,
    **settings: Any,
) -> Ensemble:
    """A manoeuvre with derivatives drawn from their covariance.

    Parameters
    ----------
    model : Model, str or path
        A model, a library name or a file.
    manoeuvre : str or Manoeuvre
        As for `simulate`.
    speed : float
        Approach speed [m/s].
    n : int
        Number of ships.
    spread : float or Draws, optional
        Relative standard deviation of each derivative where the model has no covariance, or in
        its place; or draws of values, as those of a posterior.
    seed : int
        Of the draws: the same seed gives the same ships, bit for bit.
    executor : int, str or concurrent.futures.Executor, optional
        Who sails the ships: so many threads of this process, by default as many as there are
        processors; an executor, or a cluster by the address of its dask scheduler (``tcp://…``).
        The results do not depend on it.
    progress : Progress, optional
        Is told how many ships are done.
    **settings
        As for `simulate`, without `dt` and `compiled`.

    Returns
    -------
    Ensemble

    Raises
    ------
    ModelError
        If the model has no covariance and `spread` is not given.
    DataError
        If an argument makes no sense.

    Examples
    --------
    >>> many = monte_carlo("kvlcc2", "turning", rudder_deg=35, speed=7.97, n=200, spread=0.05)
    >>> low, high = many.interval("tactical_diameter_L")
    >>> low < many.nominal["tactical_diameter_L"] < high
    True
    """
    if not (isinstance(n, int) and n > 0):
        raise DataError(f"n = {n} must be a positive whole number.")
    batch = batch_of(model, manoeuvre, speed=speed, **settings)
    loaded = batch.model
    differ = tuple(item.name for item in unstated(manoeuvre_of(manoeuvre), settings))
    batches = strata(model, manoeuvre, speed=speed, **settings) if differ else [batch]
    drawn = drawn_of(
        loaded, speed, spread, extrapolate=batch.extrapolate, fn=batch.fn, beside=differ
    )
    nominal, _ = batch.run(drawn.names, drawn.mean[None], executor=1)
    found = {name: np.empty(n) for name in nominal}
    failed, done = 0, 0

    def advance(size: int) -> None:
        nonlocal done
        done += size
        if progress is not None:
            progress(done, n, f"{batch.plan.name}, {loaded.name}")

    with opened(executor) as ready:
        sent = isinstance(ready, Executor)
        size = SENT if sent else CHUNK
        pieces = [
            (own, start, min(size, first + count - start))
            for own, first, count in shared_out(batches, n)
            for start in range(first, first + count, size)
        ]
        sail = partial(_drawn, drawn, seed)
        for place, (metrics, status) in each(
            partial(sail, executor=1),
            pieces,
            ready if sent else None,
            names=[f"ships {first} to {first + count - 1}" for _, first, count in pieces],
            here=partial(sail, executor=1 if sent else ready, advance=None if sent else advance),
        ):
            _, first, count = pieces[place]
            failed += int(np.count_nonzero(status != Status.done))
            for name, values in metrics.items():
                found[name][first : first + count] = values
            if sent:
                advance(count)
    return Ensemble(
        metrics=MappingProxyType(found),
        nominal=MappingProxyType({name: float(x[0]) for name, x in nominal.items()}),
        names=(*drawn.names, *differ),
        failed=failed,
        speed=speed,
        Fn=loaded.ship.froude(speed, loaded.water.g),
        seed=seed,
        origin=drawn.origin,
        name=loaded.name,
        manoeuvre=batch.plan.name,
        scale=loaded.scale,
        units=MappingProxyType(
            {name: Metric.of(name, batch.plan.metrics).unit_of(name) for name in nominal}
        ),
        tested=batch.nominal_range(),
        standing=Standing.of(loaded, speed),
    )


def unstated(manoeuvre: Manoeuvre, settings: Mapping[str, Any]) -> list[Setting]:
    """Settings in which ships differ and that nobody states."""
    return [item for item in manoeuvre.settings if item.std and settings.get(item.name) is None]


def strata(
    model: Model | str | Path, manoeuvre: str | Manoeuvre, *, speed: float, **settings: Any
) -> list[Batch]:
    """Batches of ships that differ in what nobody states: each at the middle of an equal share."""
    free = {
        item.name: NormalDist(item.default or 0.0, item.std)
        for item in unstated(manoeuvre_of(manoeuvre), settings)
    }
    shares = [(place + 0.5) / STRATA for place in range(STRATA)]
    values = product(*([own.inv_cdf(share) for share in shares] for own in free.values()))
    return [
        batch_of(model, manoeuvre, speed=speed, **(settings | dict(zip(free, row, strict=True))))
        for row in values
    ]


def shared_out(batches: Sequence[Batch], n: int) -> list[tuple[Batch, int, int]]:
    """Each batch with the number of its first ship and of its ships, of n in all."""
    ends = [place * n // len(batches) for place in range(len(batches) + 1)]
    return [
        (own, first, end - first) for own, (first, end) in zip(batches, pairwise(ends), strict=True)
    ]


def _drawn(drawn: Spread | Draws, seed: int, piece: tuple[Batch, int, int], **how: Any) -> Sailed:
    """The ships of a batch from some number on, so many."""
    batch, first, count = piece
    return batch.run(drawn.names, drawn.draw(seed, first, count), **how)
