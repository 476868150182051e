"""Several methods of identification on the same records: values, errors on other runs, time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import DataError, ModelError, PmmkitError, Progress, UnknownNameError
from pmmkit.effects import CURRENT
from pmmkit.identification.binding import places
from pmmkit.identification.methods import METHODS, SECONDS, Identified, identify
from pmmkit.identification.prediction import Course, Prediction
from pmmkit.identification.prior import Prior, asked_names
from pmmkit.identification.record import FreeRecord
from pmmkit.identification.smoother import Smoothed
from pmmkit.models import Model
from pmmkit.numerics import Array
from pmmkit.presentation import WIDE, Described, Grid, Group, Section, counted, number, plus_minus

if TYPE_CHECKING:
    import pandas as pd

    from pmmkit.plotting import Figure


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class MethodComparison(Described):
    """What several methods make of the same records.

    Parameters
    ----------
    model : Model
        The one that was given.
    prior : Prior
        What was known before, the same for all.
    found : mapping of str to Identified
        By method.
    failed : mapping of str to str
        Methods that could not be carried through, and why.
    predictions : mapping of str to Prediction
        By method, and ``before`` for the model as it was; empty without references.
    window : float
        Length of the predicted windows [s].
    """

    BEFORE: ClassVar[str] = "before"
    """The model as it was, among the methods."""
    UNITS: ClassVar[Mapping[str, str]] = MappingProxyType(
        {
            "position": "m",
            "position_end": "m",
            "heading": "deg",
            "speed": "m/s",
            "yaw_rate": "deg/s",
        }
    )
    """Errors of a prediction and their units."""

    model: Model
    prior: Prior
    found: Mapping[str, Identified]
    failed: Mapping[str, str]
    predictions: Mapping[str, Prediction]
    window: float

    @property
    def currents(self) -> dict[str, dict[str, float]]:
        """The current that each method found; empty where none was asked for."""
        return {name: _current(item) for name, item in self.found.items()}

    def parameters(self) -> pd.DataFrame:
        """A row per parameter and method: parameter, prior, prior_std, value, std, ci_low, ci_high,
        seen, method."""
        import pandas as pd

        columns = ["prior", "prior_std", "value", "std", "ci_low", "ci_high", "seen"]
        tables = [
            item.to_pandas()[columns].reset_index().assign(method=name)
            for name, item in self.found.items()
        ]
        return pd.concat(tables, ignore_index=True)

    def errors(self) -> pd.DataFrame:
        """A row per model (``before`` and the methods) and run, ``all`` for the runs together."""
        import pandas as pd

        rows = [
            {"model": name, "run": str(run), "window": self.window, **errors}
            for name, item in self.predictions.items()
            for run, errors in (*item.errors.items(), ("all", item.pooled()))
        ]
        return pd.DataFrame(rows, columns=["model", "run", "window", *self.UNITS, "windows"])

    def plot(self) -> Figure:
        """Intervals of 95 % before and after, by method."""
        from pmmkit.identification.figures import parameters

        return parameters(list(self.found.values()), self.model.convention)

    def _headline(self) -> str:
        failed = f", FAILED: {', '.join(self.failed)}" if self.failed else ""
        names = counted(len(self.prior.names), "parameter")
        return f"{names} of {self.model.name} by {', '.join(self.found)}{failed}"

    def _sections(self) -> Sequence[Section]:
        prior = zip(
            self.prior.names, self.prior.mean.tolist(), self.prior.std.tolist(), strict=True
        )
        rows = [
            [name, plus_minus(mean, WIDE * std), *(item.cell(name) for item in self.found.values())]
            for name, mean, std in prior
        ]
        table = Grid(head=["parameter", "prior", *self.found], groups=[Group(rows=rows)])
        said = [f"{key}: {text}" for key, item in self.found.items() for text in item.remarks()]
        said += [f"{name} FAILED: {why}" for name, why in self.failed.items()]
        notes = [f"{key}: {text}" for key, item in self.found.items() for text in item.notes]
        lists = [
            Section(title="What is wrong or at a limit", points=said),
            Section(title="Predictions", tables=[self._errors()] if self.predictions else []),
            Section(title="Notes", points=notes),
        ]
        return [
            Section(
                paragraphs=[f"Prior: {self.prior.origin}. Values ± half of the 95 % interval."],
                tables=[table],
            ),
            *(section for section in lists if section.points or section.tables),
        ]

    def _errors(self) -> Grid:
        """Errors of each model over all windows together."""
        rows = []
        windows = 0.0
        for name, item in self.predictions.items():
            pooled = item.pooled()
            windows = pooled["windows"]
            time = f"{self.found[name].seconds:.2f} s" if name in self.found else ""
            rows.append([name, *(number(pooled[error], 3) for error in self.UNITS), time])
        head = [f"{error.replace('_', ' ')} [{unit}]" for error, unit in self.UNITS.items()]
        caption = (
            f"Root mean square errors over {windows:.0f} windows of {self.window:g} s with the "
            f"measured rudder:"
        )
        return Grid(head=["model", *head, "time"], groups=[Group(rows=rows)], caption=caption)

    def to_pandas(self) -> pd.DataFrame:
        """Values, standard deviations, errors on the references and seconds, a column per method.

        The index holds what a row is (``value``, ``std``, ``error``, ``seconds``) and of what; the
        column ``before`` holds the prior and the errors of the model as it was.
        """
        import pandas as pd

        columns: dict[str, dict[tuple[str, str], float]] = {
            self.BEFORE: {
                **_rows("value", self.prior.names, self.prior.mean),
                **_rows("std", self.prior.names, self.prior.std),
            }
        }
        for method, item in self.found.items():
            columns[method] = {
                **_rows("value", item.names, item.values),
                **_rows("std", item.names, item.std),
                ("seconds", ""): item.seconds,
            }
        for name, prediction in self.predictions.items():
            pooled = prediction.pooled()
            columns[name] |= {
                ("error", f"{error} [{unit}]"): pooled[error] for error, unit in self.UNITS.items()
            }
        keys = list(dict.fromkeys(key for column in columns.values() for key in column))
        order = ("value", "std", "error", "seconds")
        keys.sort(key=lambda key: order.index(key[0]))
        return pd.DataFrame(
            {name: [column.get(key, np.nan) for key in keys] for name, column in columns.items()},
            index=pd.MultiIndex.from_tuples(keys, names=["what", "of"]),
        )


def compare_methods(
    model: Model,
    records: Sequence[FreeRecord],
    names: Sequence[str] | None = None,
    *,
    methods: Sequence[str] = SECONDS,
    references: Sequence[Smoothed] = (),
    window: float = 60.0,
    prior: Prior | None = None,
    spread: float | Mapping[str, float] | None = None,
    sensors: Mapping[str, float] | None = None,
    settings: Mapping[str, Mapping[str, Any]] | None = None,
    extrapolate: bool = False,
    progress: Progress | None = None,
) -> MethodComparison:
    """Identify the same parameters from the same records by several methods.

    Parameters
    ----------
    model : Model
        Complete; what is not named is held at its values.
    records : sequence of FreeRecord
        To identify from.
    names : sequence of str, optional
        As for `identify`.
    methods : sequence of str
        Of ``ekf``, ``ukf``, ``trajectory``, ``regression``, ``sindy``, and ``posterior``, which is
        left out where none are named since it takes minutes.
    references : sequence of Smoothed, optional
        Records that were not used, from `reference`; without them nothing is predicted.
    window : float
        Length of the predicted windows [s].
    prior, spread, sensors, extrapolate
        As for `identify`.
    settings : mapping of str to mapping, optional
        Further settings by method.
    progress : callable, optional
        Told what is being done.

    Returns
    -------
    MethodComparison
        A method that fails is named with the reason in `failed`.

    Raises
    ------
    UnknownNameError
        If there is no such method.
    DataError
        If a method that is asked for alone fails, or all of several do.

    Notes
    -----
    The sparse regression has a library of derivatives: other parameters are held at their prior
    in it. It knows no prior.

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
    >>> found = compare_methods(start, [record], ["Nv", "Nr"], methods=("ekf", "trajectory"),
    ...                         sensors={"x": 0.01, "y": 0.01, "psi": 0.001})
    >>> found.to_pandas().loc["value"].round(3)
        before    ekf  trajectory
    of
    Nv  -0.120 -0.137      -0.137
    Nr  -0.055 -0.049      -0.049
    """
    unknown = [name for name in methods if name not in METHODS]
    if unknown or not methods:
        raise UnknownNameError(
            f"There is no method {', '.join(unknown) or '(none was named)'}; there are: "
            f"{', '.join(METHODS)}."
        )
    if not records:
        raise DataError("There is no record to identify from.")
    asked = asked_names(model, names)
    before = prior or Prior.of(
        model, asked, records[0].speed, spread=spread, extrapolate=extrapolate
    )
    total = len(methods) + 1
    found: dict[str, Identified] = {}
    failed: dict[str, str] = {}
    for place, method in enumerate(dict.fromkeys(methods), start=1):
        if progress is not None:
            progress(place, total, f"identify by {method}")
        told = None if progress is None else _inside(progress, place, total, method)
        own = _derivatives(model, before) if method == "sindy" else before
        try:
            found[method] = _one(
                model,
                records,
                method,
                own,
                sensors=sensors,
                extrapolate=extrapolate,
                settings=(settings or {}).get(method, {}),
                progress=told,
            )
        except (PmmkitError, np.linalg.LinAlgError) as error:
            if len(methods) == 1:
                raise
            failed[method] = str(error)
    if not found:
        raise DataError(
            [f"{method}: {why}" for method, why in failed.items()], title="No method succeeded"
        )
    if progress is not None:
        progress(total, total, "predict")
    predictions = {}
    if references:
        predictions[MethodComparison.BEFORE] = Prediction.of(
            model, references, window=window, extrapolate=extrapolate
        )
        for name, item in found.items():
            seen = Smoothed.corrected(
                model, references, _current(item), sensors=sensors, extrapolate=extrapolate
            )
            predictions[name] = Prediction.of(
                item.model, seen, window=window, extrapolate=extrapolate
            )
    return MethodComparison(
        model=model,
        prior=before,
        found=MappingProxyType(found),
        failed=MappingProxyType(failed),
        predictions=MappingProxyType(predictions),
        window=window,
    )


def _inside(progress: Progress, place: int, total: int, method: str) -> Progress:
    """What a method tells, as a part of the whole."""

    def tell(done: int, of: int, what: str) -> None:
        progress(place, total, f"{method}, {done} of at most {of}: {what}")

    return tell


def _rows(what: str, names: Sequence[str], values: Array) -> dict[tuple[str, str], float]:
    return {(what, name): float(x) for name, x in zip(names, values, strict=True)}


def _one(
    model: Model,
    records: Sequence[FreeRecord],
    method: str,
    prior: Prior,
    *,
    sensors: Mapping[str, float] | None,
    extrapolate: bool,
    settings: Mapping[str, Any],
    progress: Progress | None,
) -> Identified:
    if not prior.names:
        raise DataError("The sparse regression looks for derivatives, and none was named.")
    try:
        return identify(
            model,
            records,
            prior.names,
            method=method,
            prior=prior,
            sensors=sensors,
            extrapolate=extrapolate,
            progress=progress,
            **settings,
        )
    except ModelError as error:
        remedy = "Say how well it is known with a narrower prior, or hold it: do not name it."
        raise DataError(
            [*error.problems, remedy], title=f"{method} leads to values that cannot be"
        ) from error


def _derivatives(model: Model, prior: Prior) -> Prior:
    """The part of a prior that belongs to derivatives."""
    own = [name for name in prior.names if name not in CURRENT]
    homes = dict(zip(own, places(model, own), strict=True))
    at = [
        i
        for i, name in enumerate(prior.names)
        if name in homes and homes[name][0] in model.derivative_parts and "." not in name
    ]
    return Prior(
        names=tuple(prior.names[i] for i in at),
        mean=prior.mean[at],
        covariance=prior.covariance[np.ix_(at, at)],
        origin=prior.origin,
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class PredictedWindow:
    """A window of a record, measured and as models sail it.

    Parameters
    ----------
    name : str
        Of the record.
    t : array (n,)
        Instants [s], of the record.
    delta : array (n,)
        Measured rudder [rad].
    measured : mapping of str to array (n,)
        x, y [m], psi [rad], u, v [m/s], r [rad/s], smoothed.
    predicted : mapping of str to mapping of str to array (n,)
        The same by model.
    L : float
        Length of the ship [m].
    """

    name: str
    t: Array
    delta: Array
    measured: Mapping[str, Array]
    predicted: Mapping[str, Mapping[str, Array]]
    L: float

    @classmethod
    def of(
        cls,
        models: Mapping[str, Model],
        references: Sequence[Smoothed],
        *,
        window: float = 60.0,
        extrapolate: bool = False,
        currents: Mapping[str, Mapping[str, float]] = MappingProxyType({}),
    ) -> PredictedWindow:
        """The window in which the ship turned most, as models sail it with the measured rudder.

        Parameters
        ----------
        models : mapping of str to Model
            By name.
        references : sequence of Smoothed
            From `reference`.
        window : float
            Its length [s].
        extrapolate : bool
            Allow a speed outside the range of the models' values.
        currents : mapping of str to mapping of str to float
            By name of a model the current that was found with it, as `MethodComparison.currents`.

        Raises
        ------
        DataError
            If no record is as long as a window.
        """
        found = [
            (float(np.ptp(item.motion["psi"][at])), item, at)
            for item in references
            for at in _windows(item.t, window)
        ]
        if not found:
            raise DataError(f"No record is as long as a window of {window:g} s.")
        _, item, at = max(found, key=lambda entry: entry[0])
        names = ("x", "y", "psi", "u", "v", "r")
        own = {
            name: Smoothed.corrected(
                model, [item], currents.get(name, {}), extrapolate=extrapolate
            )[0]
            for name, model in models.items()
        }
        # Where a log tells the speed through the water, the track is smooth only in the current.
        best = list(own.values())[-1]
        return cls(
            name=item.name,
            t=item.t[at],
            delta=item.record.delta[at],
            measured=MappingProxyType({name: best.motion[name][at] for name in names}),
            predicted=MappingProxyType(
                {name: _sailed(model, own[name], at, extrapolate) for name, model in models.items()}
            ),
            L=next(iter(models.values())).ship.L,
        )


def _windows(t: Array, window: float) -> list[NDArray[np.intp]]:
    """Instants of the windows, which begin four times in each length."""
    begins = np.arange(t[0], t[-1] - window + 1e-9, window / 4)
    rows = [np.flatnonzero((t >= at - 1e-9) & (t <= at + window + 1e-9)) for at in begins]
    return [at for at in rows if len(at) > 2]


def _current(item: Identified) -> dict[str, float]:
    """The current that was identified with a model; empty where none was asked for."""
    values = zip(item.names, item.values.tolist(), strict=True)
    return {place: value for place, value in values if place in CURRENT}


def _sailed(
    model: Model, item: Smoothed, at: NDArray[np.intp], extrapolate: bool
) -> Mapping[str, Array]:
    """Motion of a model from the first state of a window."""
    course = Course.of(model, item.record, extrapolate=extrapolate)
    (out,) = course.sail(at, course.states_of(item)[at[:1]])
    return MappingProxyType(dict(zip(course.states, out.T, strict=True)))
