"""What ``pmmkit identify`` works on: records, parameters, and what was known before."""

from __future__ import annotations

import fnmatch
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, Literal

import numpy as np

from pmmkit.api import hull_table
from pmmkit.campaigns.run import Campaign, Run
from pmmkit.campaigns.segments import Cut, usable
from pmmkit.conventions import canonical
from pmmkit.errors import DataError, Problem, UnknownNameError
from pmmkit.identification.binding import AROUND
from pmmkit.identification.from_run import free_records
from pmmkit.identification.parameters import places
from pmmkit.identification.prior import Prior, prior_of
from pmmkit.identification.record import FreeRecord
from pmmkit.models import Model, load_model
from pmmkit.models.model import DERIVATIVE_PARTS
from pmmkit.tables import DerivativeTable, converted, interpolate, read_table

SAME_LENGTH: Final = 0.02
"""Share by which the lengths of model and campaign may differ."""
TABLES: Final = (".csv", ".nc", ".h5", ".xlsx")


@dataclass(frozen=True, kw_only=True, eq=False)
class Chosen:
    """Records of some runs, and what was cut from them.

    Parameters
    ----------
    runs : tuple of str
        Ids.
    records : tuple of FreeRecord
        Their usable segments.
    cuts : tuple of (str, Cut)
        What was left out, by run.
    """

    runs: tuple[str, ...]
    records: tuple[FreeRecord, ...]
    cuts: tuple[tuple[str, Cut], ...]

    @property
    def seconds(self) -> float:
        """Length of all records together [s]."""
        return float(sum(item.t[-1] - item.t[0] for item in self.records))

    def content(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "runs": list(self.runs),
            "records": [
                {
                    "name": item.name,
                    "samples": len(item),
                    "seconds": item.t[-1] - item.t[0],
                    "speed": item.speed,
                    "channels": list(item.measured),
                    "wind": item.wind_speed is not None,
                }
                for item in self.records
            ],
            "cuts": [
                {"run": run, "t_start": cut.t_start, "t_stop": cut.t_stop, "reason": cut.reason}
                for run, cut in self.cuts
            ],
        }

    def words(self, head: str, most: int = 6) -> list[str]:
        """For people: how many records, what was measured, what was cut."""
        channels = list(dict.fromkeys(name for item in self.records for name in item.measured))
        wind = any(item.wind_speed is not None for item in self.records)
        lines = [
            f"{head}: {len(self.records)} records from {len(self.runs)} runs "
            f"({', '.join(self.runs)}), {sum(map(len, self.records))} samples, "
            f"{self.seconds:.0f} s; {', '.join(channels)}{' and wind' if wind else ''}"
        ]
        empty = [
            run for run in self.runs if not any(_is_of(item.name, run) for item in self.records)
        ]
        if empty:
            lines.append(f"  no segment was long enough in {', '.join(empty)}")
        lines += [f"  cut from {run}: {cut}" for run, cut in self.cuts[:most]]
        if len(self.cuts) > most:
            lines.append(f"  and {len(self.cuts) - most} more cuts, in identified.json")
        return lines

    def long_enough(self, window: float) -> tuple[FreeRecord, ...]:
        """The records that hold a window [s].

        Raises
        ------
        DataError
            If none does.
        """
        found = tuple(item for item in self.records if item.t[-1] - item.t[0] >= window)
        if not found:
            longest = max(item.t[-1] - item.t[0] for item in self.records)
            raise DataError(
                f"No record is as long as a window of {window:g} s; the longest has "
                f"{longest:.1f} s. Choose a shorter --window."
            )
        return found


def _is_of(record: str, run: str) -> bool:
    """Whether a record is a run or one of its segments."""
    return record == run or record.rpartition("/")[0] == run


def chosen_records(
    campaign: Campaign,
    model: Model,
    *,
    runs: Sequence[str] | None,
    test_runs: Sequence[str] | None,
    channels: Sequence[str] | None,
    rudder: Literal["auto", "measured", "ordered"],
    wind: bool,
    shortest: float | None = None,
) -> tuple[Chosen, Chosen | None]:
    """Records to identify from, and those held out.

    Parameters
    ----------
    campaign : Campaign
        Free-running runs.
    model : Model
        Of the ship as tested.
    runs, test_runs : sequence of str, optional
        Patterns of ids.
    channels, rudder, wind, shortest
        As for `free_records`.

    Returns
    -------
    Chosen, Chosen or None
        A run that is held out is never identified from.

    Raises
    ------
    DataError
        If the campaign is captive or of another ship, or no record is left.
    UnknownNameError
        If a pattern fits no run.
    """
    if campaign.kind != "free-running":
        raise DataError(
            f"Campaign {campaign.title!r} is {campaign.kind}: identify takes free-running records. "
            f"Captive tests go into `pmmkit reduce`."
        )
    if abs(model.ship.L / campaign.ship.L - 1.0) > SAME_LENGTH:
        raise DataError(
            f"Model {model.name!r} is of a ship of {model.ship.L:g} m, the records of one of "
            f"{campaign.ship.L:g} m. Bring the model to that length: pmmkit scale {model.name} "
            f"--length {campaign.ship.L:g} --froude-only."
        )
    held = _matching(campaign, test_runs) if test_runs else []
    asked = _matching(campaign, runs) if runs else list(campaign.runs)
    train = [run for run in asked if run not in held]
    if not train:
        raise DataError("Every run is held out: none is left to identify from.")

    def records(chosen: Sequence[Run]) -> Chosen:
        return _records(
            chosen, model, channels=channels, rudder=rudder, wind=wind, shortest=shortest
        )

    return records(train), records(held) if held else None


def _matching(campaign: Campaign, patterns: Sequence[str]) -> list[Run]:
    """Runs whose id fits one of the patterns."""
    lost = [
        pattern
        for pattern in patterns
        if not any(fnmatch.fnmatchcase(run.id, pattern) for run in campaign)
    ]
    if lost:
        raise UnknownNameError(
            f"No run is called {', '.join(lost)}; there are "
            f"{', '.join(run.id for run in campaign)}."
        )
    return [
        run for run in campaign if any(fnmatch.fnmatchcase(run.id, pattern) for pattern in patterns)
    ]


def _records(
    runs: Sequence[Run],
    model: Model,
    *,
    channels: Sequence[str] | None,
    rudder: Literal["auto", "measured", "ordered"],
    wind: bool,
    shortest: float | None,
) -> Chosen:
    """Usable segments of runs; every run that cannot be used at all is named at once."""
    records: list[FreeRecord] = []
    cuts: list[tuple[str, Cut]] = []
    problems: list[Problem | str] = []
    for run in runs:
        least = shortest or 10.0 * model.ship.L / max(run.settings.speed, 1e-9)
        data = run.data
        loaded = run.with_(loader=lambda data=data: data)
        cuts += [(run.id, cut) for cut in usable(loaded, shortest=least).cuts]
        try:
            records += free_records(
                loaded, model, rudder=rudder, channels=channels, wind=wind, shortest=least
            )
        except DataError as error:
            problems += error.problems
    if problems:
        raise DataError(problems, title="Not identified")
    if not records:
        told = [Problem(message=f"{cut}.", run=run) for run, cut in cuts]
        raise DataError(
            told or "The runs hold no samples.",
            title="No record is long enough after the cuts (ten ship lengths, or --shortest)",
        )
    return Chosen(runs=tuple(run.id for run in runs), records=tuple(records), cuts=tuple(cuts))


def parameters_of(model: Model, asked: Sequence[str] | None) -> tuple[str, ...]:
    """What is identified: what was asked for, or all derivatives of the hull.

    Parameters
    ----------
    model : Model
        Has their start values.
    asked : sequence of str, optional
        Derivatives (factors in any order), parameters with their effect, currents.

    Returns
    -------
    tuple of str
        Each once.

    Raises
    ------
    UnknownNameError
        With all names that the model does not have, and those that it has.

    Examples
    --------
    >>> parameters_of(load_model("kvlcc2-l7"), ["Yrvv", "rudder_mmg.aH"])
    ('Yvvr', 'rudder_mmg.aH')
    """
    if asked is None:
        return tuple(model.part("hull_polynomial", "identification").values)
    if not asked:
        raise DataError("Name at least one parameter, such as --derivatives 'Yv Yr Nv Nr'.")
    there = _fittable(model)
    found = [_spelt(name) for name in asked]
    lost = [name for name in found if name not in there]
    if lost:
        raise UnknownNameError(
            f"Model {model.name!r} has no {', '.join(lost)} to identify; it has {', '.join(there)}."
        )
    return tuple(dict.fromkeys(found))


def _spelt(name: str) -> str:
    if "." in name or name in AROUND:
        return name
    try:
        return canonical(name)
    except UnknownNameError:
        return name


def _fittable(model: Model) -> tuple[str, ...]:
    """Every name that may be identified."""
    names = []
    for effect, part in model.parts.items():
        known = part.known
        single = [item.name for item in known.parameters if not item.table]
        if effect in DERIVATIVE_PARTS:
            names += [name for name in part.values if name not in single]
        names += [f"{effect}.{name}" for name in single if name in part.values]
    return (*names, *AROUND)


def known_before(
    model: Model,
    names: Sequence[str],
    speed: float,
    *,
    prior: str | None,
    spread: float | None,
    extrapolate: bool,
) -> Prior:
    """The prior: of the model, or of another model or a derivative table.

    Parameters
    ----------
    model : Model
        Gives what `prior` does not have.
    names : sequence of str
        Parameters.
    speed : float
        Of the approach [m/s].
    prior : str, optional
        Library ship, model file or table file.
    spread : float, optional
        Relative standard deviation; it counts before a covariance.
    extrapolate : bool
        Allow a speed outside the range of values.

    Returns
    -------
    Prior
        Its origin says what came from where.
    """
    own = prior_of(model, names, speed, spread=spread, extrapolate=extrapolate)
    if prior is None:
        return replace(own, origin=f"{model.name}, {own.origin}")
    if Path(prior).suffix.lower() in TABLES:
        return _from_table(own, read_table(prior), model, speed, prior, spread, extrapolate)
    other = load_model(prior)
    if other.convention != model.convention:
        table = _with_covariance(hull_table(other), other)
        return _from_table(own, table, model, speed, prior, spread, extrapolate)
    shared = [name for name in names if name in AROUND or _has(other, name)]
    if not shared:
        raise UnknownNameError(f"{prior} has none of {', '.join(names)}.")
    given = prior_of(other, shared, speed, spread=spread, extrapolate=extrapolate)
    return _joined(own, given, f"{prior}, {given.origin}")


def _has(model: Model, name: str) -> bool:
    try:
        places(model, [name])
    except UnknownNameError:
        return False
    return True


def _with_covariance(table: DerivativeTable, model: Model) -> DerivativeTable:
    """The derivatives of a model with the covariance that it carries."""
    if model.covariance is None:
        return table
    shared = [name for name in table.names if name in model.covariance_names]
    at = [table.names.index(name) for name in shared]
    of = [model.covariance_names.index(name) for name in shared]
    k, size = len(table.Fn), len(model.covariance_names)
    full = model.covariance.reshape(k, size, k, size)
    covariance = np.full_like(table.covariance, np.nan)
    for i, a in zip(at, of, strict=True):
        for j, b in zip(at, of, strict=True):
            covariance[:, i, :, j] = full[:, a, :, b]
    return table.with_(covariance=covariance)


def _from_table(
    own: Prior,
    table: DerivativeTable,
    model: Model,
    speed: float,
    source: str,
    spread: float | None,
    extrapolate: bool,
) -> Prior:
    """Values and covariance of a table at the speed, in the convention of the model."""
    same = table if table.convention == model.convention else converted(table, model.convention)
    froude = model.ship.froude(speed, model.water.g)
    at = interpolate(same, froude, extrapolate=extrapolate)
    known = [name for name in own.names if name in at.names and np.isfinite(at[name][0])]
    if not known:
        raise UnknownNameError(
            f"{source} has none of {', '.join(own.names)}; it has {', '.join(at.names)}."
        )
    columns = [at.index(name) for name in known]
    mean = at.value[0, columns]
    covariance = at.covariance[0][:, 0][np.ix_(columns, columns)].copy()
    sure = np.isfinite(np.diagonal(covariance)) & (np.diagonal(covariance) > 0) & (spread is None)
    sizes = np.where(mean != 0.0, np.abs(mean), 0.0)
    fallback = np.array([own.std[own.names.index(name)] for name in known])
    relative = np.where(sizes > 0.0, (spread or 0.3) * sizes, fallback)
    covariance = np.where(np.outer(sure, sure) & np.isfinite(covariance), covariance, 0.0)
    covariance[np.diag_indices_from(covariance)] += np.where(sure, 0.0, relative**2)
    told = f"the covariance of {source} for {int(sure.sum())} of {len(known)}"
    if not sure.all():
        told += f", else {100 * (spread or 0.3):g} % of each value"
    given = Prior(names=tuple(known), mean=mean, covariance=covariance, origin=told)
    return _joined(own, given, told)


def _joined(own: Prior, given: Prior, told: str) -> Prior:
    """What is given where it is, the model's own elsewhere."""
    mean, covariance = own.mean.copy(), own.covariance.copy()
    at = [own.names.index(name) for name in given.names]
    covariance[at, :] = 0.0
    covariance[:, at] = 0.0
    covariance[np.ix_(at, at)] = given.covariance
    mean[at] = given.mean
    rest = [name for name in own.names if name not in given.names]
    more = f"; of the model itself: {', '.join(rest)}" if rest else ""
    return Prior(names=own.names, mean=mean, covariance=covariance, origin=told + more)
