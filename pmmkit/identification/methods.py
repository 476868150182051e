"""One call for every way to identify a model from free-running records."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np

from pmmkit.base import DataError, ModelError, Progress, Registry
from pmmkit.effects import CURRENT
from pmmkit.identification.forces import ForceRecord, fit_to_forces
from pmmkit.identification.lack import FEWEST
from pmmkit.identification.prior import Prior, RidgeBias, asked_names
from pmmkit.identification.record import FreeRecord
from pmmkit.identification.restarts import filtered
from pmmkit.identification.smoother import Smoothed
from pmmkit.identification.trajectory import fit_trajectories
from pmmkit.models import Model, Step
from pmmkit.numerics import Array
from pmmkit.presentation import WIDE, Described, Grid, Group, Section, counted, plus_minus

if TYPE_CHECKING:
    import pandas as pd

    from pmmkit.plotting import Figure

FAR: Final = 4.0
"""Standard deviations from the prior from which a value is pointed at."""
POINTED_AT: Final = 3.0
"""The same of a report."""
WHITE: Final = 1.5
"""Variance of the residuals over that of white ones up to which they count as white."""
UNSEEN: Final = 0.9
"""A standard deviation above this share of the prior's: the records say nothing of a value."""


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Identified(Described):
    """Parameters of a model, identified.

    `values, std (m,)`: their values and standard deviations. `prior`: what was known before.
    `unseen`: parameters of which the records say nothing; the model keeps their prior. `model`:
    with the new values and, where it has one set of them for all speeds, their covariance.
    `notes`: what the method has to say: convergence, process noise, how far from white.
    `detail`: the result of the method itself.
    """

    method: str
    names: tuple[str, ...]
    values: Array
    std: Array
    covariance: Array
    prior: Prior
    unseen: tuple[str, ...]
    model: Model
    seconds: float
    notes: tuple[str, ...]
    detail: Any

    @property
    def current(self) -> tuple[float, float]:
        """The current to north and east [m/s], zero where it was not looked for."""
        found = dict(zip(self.names, self.values.tolist(), strict=True))
        return found.get("current_x", 0.0), found.get("current_y", 0.0)

    @property
    def left_out(self) -> tuple[str, ...]:
        """Terms that a sparse regression found absent."""
        return tuple(name for name in getattr(self.detail, "left_out", ()) if name in self.names)

    @property
    def missing(self) -> tuple[str, ...]:
        """What says that the model lacks something, in words; nothing where nothing does."""
        lack = getattr(self.detail, "lack", None)
        return () if lack is None else lack.words()

    @property
    def far(self) -> tuple[str, ...]:
        """Parameters that ended far from what was known before."""
        away = np.abs(self.values - self.prior.mean) / self.prior.std
        gone = {*self.left_out, *self.unseen}
        return tuple(
            name
            for name, ratio in zip(self.names, away.tolist(), strict=True)
            if ratio > POINTED_AT and name not in gone
        )

    @property
    def drawn(self) -> tuple[RidgeBias, ...]:
        """Values with more bias, by the prior, than noise; none where no method says its own."""
        lack = getattr(self.detail, "lack", None)
        return () if lack is None else self.prior.ridge_biases(lack.alone)

    def scaled(self) -> tuple[Array, Array]:
        """Values less their prior means, and half of their 95 % intervals, over the prior's std."""
        std = self.prior.std
        return (self.values - self.prior.mean) / std, WIDE * self.std / std

    def plot(self) -> Figure:
        """Intervals of 95 % before and after."""
        from pmmkit.identification.figures import parameters

        return parameters([self], self.model.convention)

    def cell(self, name: str) -> str:
        """A value with half of its 95 % interval, or why there is none."""
        if name not in self.names:
            return "held"
        if name in self.left_out:
            return "left out"
        if name in self.unseen:
            return "not determined"
        i = self.names.index(name)
        return plus_minus(float(self.values[i]), WIDE * float(self.std[i]))

    def remarks(self) -> list[str]:
        """What is wrong or at a limit."""
        said = [*getattr(self.detail, "unconverged", ())]
        said += [f"{text[0].upper()}{text[1:]}." for text in self.missing]
        if self.unseen:
            said.append(
                f"The records do not determine {', '.join(self.unseen)}; the model keeps what was "
                f"known before."
            )
        if self.drawn:
            said.append(
                f"Drawn to what was known before (a ridge): {'; '.join(map(_bias, self.drawn))}. "
                f"The share of bias is right if the prior is."
            )
        if self.far:
            said.append(
                f"More than {POINTED_AT:g} standard deviations from what was known before: "
                f"{', '.join(self.far)}. Either the prior is wrong, or these take up what the "
                f"model lacks."
            )
        if self.left_out:
            said.append(
                f"Left out, since the records do not need them: {', '.join(self.left_out)}."
            )
        return said

    def _headline(self) -> str:
        unseen = f", {len(self.unseen)} not determined" if self.unseen else ""
        doubt = ", NOT converged" if getattr(self.detail, "unconverged", ()) else ""
        names = counted(len(self.names), "parameter")
        return f"{names} of {self.model.name} by {self.method}{doubt}{unseen}, {self.seconds:.2f} s"

    def _sections(self) -> Sequence[Section]:
        rows = [
            [name, plus_minus(mean, WIDE * std), self.cell(name)]
            for name, mean, std in zip(
                self.names, self.prior.mean.tolist(), self.prior.std.tolist(), strict=True
            )
        ]
        table = Grid(head=["parameter", "prior", self.method], groups=[Group(rows=rows)])
        return [
            Section(
                paragraphs=[f"Prior: {self.prior.origin}. Values ± half of the 95 % interval."],
                tables=[table],
            ),
            Section(title="Notes", points=[*self.remarks(), *self.notes]),
        ]

    def to_pandas(self) -> pd.DataFrame:
        """A row per parameter: prior, value, interval, and what the records added."""
        import pandas as pd

        return pd.DataFrame(
            {
                "prior": self.prior.mean,
                "prior_std": self.prior.std,
                "value": self.values,
                "std": self.std,
                "ci_low": self.values - WIDE * self.std,
                "ci_high": self.values + WIDE * self.std,
                "std_over_prior": self.std / self.prior.std,
                "seen": [name not in self.unseen for name in self.names],
            },
            index=pd.Index(self.names, name="parameter"),
        )


def identify(
    model: Model,
    records: Sequence[FreeRecord],
    names: Sequence[str] | None = None,
    *,
    method: str = "ekf",
    prior: Prior | None = None,
    spread: float | Mapping[str, float] | None = None,
    sensors: Mapping[str, float] | None = None,
    extrapolate: bool = False,
    progress: Progress | None = None,
    **settings: Any,
) -> Identified:
    """Identify derivatives and other parameters from free-running records.

    Parameters
    ----------
    model : Model
        Complete; what is not named is held at its values.
    records : sequence of FreeRecord
        From `free_records`, or made by hand.
    names : sequence of str, optional
        Derivatives (``Yv``), parameters with their effect (``rudder_mmg.aH``), ``current_x`` and
        ``current_y``; by default all derivatives of the hull.
    method : {"ekf", "ukf", "trajectory", "regression", "sindy", "posterior"}
        Kalman filters; a fit through the simulator; regression of the forces that the smoother
        implies; the same with terms left out that the records do not need; draws from the
        posterior, which take minutes where the others take seconds.
    prior : Prior, optional
        What is known before; by default from the model's covariance, or `spread`.
    spread : float or mapping, optional
        Relative standard deviation of the values before (0.3 where nothing is known).
    sensors : mapping of str to float, optional
        Standard deviations of channels, SI and radians; told from the records where absent.
    extrapolate : bool
        Allow a speed outside the range of the model's values.
    progress : callable, optional
        Told what the method does: passes, steps, records.
    **settings
        Of the method: `roughness`, `iterations` (filters), `window` (trajectory), `memory`
        (regression), or those of `sparse_regression` and `sample_posterior`.

    Returns
    -------
    Identified

    Raises
    ------
    UnknownNameError
        If there is no such method, or the model lacks a name.
    DataError
        If there is no record.

    Examples
    --------
    >>> from pmmkit.models import load_model
    >>> from pmmkit.simulation import simulate
    >>> ship = load_model("kvlcc2-l7")
    >>> track = simulate(ship, "zigzag", speed=1.179, rudder_deg=20, switch_deg=20, dt=0.2)
    >>> record = FreeRecord(
    ...     name="zigzag", t=track.t, delta=track.delta, turns=track.n, speed=1.179,
    ...     measured={"x": track.x, "y": track.y, "psi": track.psi})
    >>> start = ship.with_values("hull_polynomial", Nv=-0.12, Nr=-0.055)
    >>> found = identify(start, [record], ["Nv", "Nr"], method="trajectory",
    ...                  sensors={"x": 0.01, "y": 0.01, "psi": 0.001})
    >>> found.values.round(3)
    array([-0.137, -0.049])
    """
    chosen = METHODS[method]
    if not records:
        raise DataError("There is no record to identify from.")
    given = [record.name for record in records]
    twice = sorted({name for name in given if given.count(name) > 1})
    if twice:
        raise DataError(f"Several records are named {', '.join(twice)}: give each its own name.")
    started = time.perf_counter()
    records = [record.measured_once for record in records]
    speed = records[0].speed
    asked = asked_names(model, names)
    before = prior or Prior.of(model, asked, speed, spread=spread, extrapolate=extrapolate)
    shared: dict[str, Any] = {"sensors": sensors, "extrapolate": extrapolate, "progress": progress}
    if chosen.selects:
        shared["library"] = [name for name in asked if "." not in name and name not in CURRENT]
    found, notes = chosen.fit(model, records, before, **shared, **settings)
    if chosen.selects:
        return _sparse(found, before, started)
    seconds = time.perf_counter() - started
    return _told(model, method, before, found, notes, seconds, FreeRecord.title_of(records))


def _bias(item: RidgeBias) -> str:
    """A value that its prior draws to itself, why, and what would end it."""
    like = f", rows like those of {item.like} (cosine {item.cosine:.2f})" if item.like else ""
    ends = (
        "however long such records were"
        if math.isinf(item.longer)
        else f"until they are {item.longer:.2g} times as long"
    )
    return f"{item.name} ({100.0 * item.share:.0f} % of its variance is bias{like}, {ends})"


MethodResult = tuple[Any, tuple[str, ...]]
"""The result of a method, and what it has to say."""


@dataclass(frozen=True, kw_only=True)
class IdentificationMethod:
    """A way to identify a model from records.

    `fit`: given the model, the records, the prior, and by name ``sensors``, ``extrapolate``,
    ``progress`` and its own settings. `seconds`: whether it takes seconds, and not minutes.
    `selects`: whether it chooses among the terms of a library.
    """

    name: str
    fit: Callable[..., MethodResult]
    seconds: bool = True
    selects: bool = False


def _by_filter(method: Literal["ekf", "ukf"]) -> Callable[..., MethodResult]:
    """A Kalman filter."""

    def fit(
        model: Model, records: Sequence[FreeRecord], prior: Prior, **settings: Any
    ) -> MethodResult:
        found, tried = filtered(model, records, prior, method=method, **settings)
        return found, (
            f"{found.iterations} passes, {'settled' if found.converged else 'NOT settled'}",
            f"process noise {found.roughness:g} U²/L over the root of L/U",
            *_lost(tried),
        )

    return fit


def _by_trajectories(
    model: Model, records: Sequence[FreeRecord], prior: Prior, **settings: Any
) -> MethodResult:
    """A fit through the simulator."""
    found = fit_trajectories(model, records, prior, **settings)
    return found, (
        f"{found.windows} windows, {found.iterations} steps, "
        f"{'settled' if found.converged else 'NOT settled'}",
        f"variance widened {found.inflation:.3g} times: residuals are not white"
        if found.inflation > WHITE
        else "residuals as white as the sensors'",
        *_lost(found.tried),
    )


def _by_draws(
    model: Model, records: Sequence[FreeRecord], prior: Prior, **settings: Any
) -> MethodResult:
    """Draws from the posterior."""
    from pmmkit.identification.posterior.posterior import sample_posterior

    found = sample_posterior(model, records, prior, **settings)
    return found, (*found.notes(), *_lost(found.tried))


def _implied(
    model: Model,
    records: Sequence[FreeRecord],
    *,
    progress: Progress | None,
    memory: Mapping[str, Any],
    **shared: Any,
) -> list[ForceRecord]:
    """The forces that the smoother implies, of each record."""
    forces = []
    for number, record in enumerate(records):
        if progress is not None:
            progress(number, len(records), f"forces that {record.name} implies")
        kept = Smoothed.of(model, record, **shared, **memory)
        forces.append(kept.implied_forces(model, **memory))
    return forces


def _by_regression(
    model: Model,
    records: Sequence[FreeRecord],
    prior: Prior,
    *,
    sensors: Mapping[str, float] | None,
    extrapolate: bool,
    progress: Progress | None,
    **settings: Any,
) -> MethodResult:
    """A regression of the forces that the smoother implies."""
    memory, _ = _with_memory(settings)
    shared: dict[str, Any] = {"sensors": sensors, "extrapolate": extrapolate}
    forces = _implied(model, records, progress=progress, memory=memory, **shared)
    found = fit_to_forces(
        model, forces, prior.names, prior=prior, extrapolate=extrapolate, progress=progress
    )
    alone = len(records) < FEWEST
    return found, (
        "forces implied by the smoother",
        f"intervals have no allowance for what lasts through a record: that needs {FEWEST} records"
        if alone
        else f"intervals allow for what lasts through a record, by the jackknife over "
        f"{len(records)} records",
    )


def _by_selection(
    model: Model,
    records: Sequence[FreeRecord],
    _prior: Prior,
    *,
    sensors: Mapping[str, float] | None,
    extrapolate: bool,
    progress: Progress | None,
    **settings: Any,
) -> MethodResult:
    """The same with terms left out that the records do not need."""
    from pmmkit.identification.sparse.regression import sparse_regression

    memory, rest = _with_memory(settings)
    shared: dict[str, Any] = {"sensors": sensors, "extrapolate": extrapolate}
    forces = _implied(model, records, progress=progress, memory=memory, **shared)
    return sparse_regression(model, forces, **rest), ()


def _with_memory(settings: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """The memory of the smoother, where it is given, and the other settings."""
    memory = {name: value for name, value in settings.items() if name == "memory"}
    return memory, {name: value for name, value in settings.items() if name != "memory"}


METHODS: Final = Registry(
    IdentificationMethod,
    lambda: (
        IdentificationMethod(name="ekf", fit=_by_filter("ekf")),
        IdentificationMethod(name="ukf", fit=_by_filter("ukf")),
        IdentificationMethod(name="trajectory", fit=_by_trajectories),
        IdentificationMethod(name="regression", fit=_by_regression),
        IdentificationMethod(name="sindy", fit=_by_selection, selects=True),
        IdentificationMethod(name="posterior", fit=_by_draws, seconds=False),
    ),
    what="method",
    unknown="There is no method {name!r}; there are: {names}.",
)
SECONDS: Final = tuple(method.name for method in METHODS.values() if method.seconds)
"""Those that take seconds and are set side by side where nothing else is asked for."""


def _lost(tried: Sequence[str]) -> tuple[str, ...]:
    """What had to be tried before the motion was not lost."""
    return (f"the motion was lost at first; tried: {'; '.join(tried)}",) if tried else ()


def _told(
    model: Model,
    method: str,
    prior: Prior,
    found: Any,
    notes: tuple[str, ...],
    seconds: float,
    campaign: str,
) -> Identified:
    covariance = np.array(found.covariance)
    std = np.sqrt(np.diagonal(covariance))
    # Intervals that allow for what the model lacks may be wider than before the records; what these
    # show is the question of the model alone.
    lack = getattr(found, "lack", None)
    told = std if lack is None else np.sqrt(np.diagonal(lack.alone))
    unseen = tuple(
        name
        for name, ratio in zip(prior.names, told / prior.std, strict=True)
        if not ratio < UNSEEN
    )
    kept = np.array(
        [prior.mean[i] if name in unseen else found.values[i] for i, name in enumerate(prior.names)]
    )
    try:
        known = replace(prior, mean=kept, covariance=covariance)
        made = known.carried_by(model, f"{method} on free-running records")
        made = made.stepped(*_current_step(prior.names, kept, method, campaign))
    except ModelError as error:
        raise DataError(
            f"The records drive a value out of its range: {error} Narrow the prior of that value, "
            f"or hold it (leave it out of the names)."
        ) from error
    away = (np.array(found.values) - prior.mean) / prior.std
    far = [
        f"{name} {abs(x):.0f}"
        for name, x in zip(prior.names, away.tolist(), strict=True)
        if abs(x) > FAR
    ]
    if far:
        notes += (
            f"far from what was known before, in its standard deviations: {', '.join(far)}; check "
            f"signs, prior and sensors",
        )
    return Identified(
        method=method,
        names=prior.names,
        values=np.array(found.values),
        std=std,
        covariance=covariance,
        prior=prior,
        unseen=unseen,
        model=made,
        seconds=seconds,
        notes=notes,
        detail=found,
    )


def _current_step(
    names: Sequence[str], values: Array, method: str, campaign: str
) -> tuple[Step, ...]:
    """The step that tells of the current of these tests; none where it was not looked for."""
    found = {name: x for name, x in zip(names, values.tolist(), strict=True) if name in CURRENT}
    if not any(found.values()):
        return ()
    step = Step(
        action="fault_corrected",
        effect="current",
        coefficients=dict.fromkeys(CURRENT, 0.0) | found,
        campaign=campaign,
        method=method,
        source="identified",
    )
    return (step,)


def _sparse(found: Any, prior: Prior, started: float) -> Identified:
    """The result of the sparse regression as that of any other method.

    What it does not look for (parameters of effects) or no record excites keeps its prior.
    """
    table = found.table.select([name for name in found.table.names if name in prior.names])
    at = [prior.names.index(name) for name in table.names]
    absent = [prior.names.index(name) for name in found.left_out if name in prior.names]
    held = {*prior.names} - {*table.names, *found.left_out}
    values, covariance = prior.mean.copy(), prior.covariance.copy()
    values[at], values[absent] = table.value[0], 0.0
    covariance[[*at, *absent], :] = covariance[:, [*at, *absent]] = 0.0
    covariance[np.ix_(at, at)] = table.covariance[0, :, 0]
    return Identified(
        method="sindy",
        names=prior.names,
        values=values,
        std=np.sqrt(np.diagonal(covariance)),
        covariance=covariance,
        prior=prior,
        unseen=tuple(name for name in prior.names if name in held),
        model=found.model,
        seconds=time.perf_counter() - started,
        notes=tuple(found.warnings),
        detail=found,
    )
