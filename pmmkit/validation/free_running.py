"""Free-running records beside a model: motion with the measured rudder, forces, manoeuvres."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from pmmkit.base import DataError, PmmkitError, Progress
from pmmkit.campaigns import Campaign, Run
from pmmkit.conventions import Metric
from pmmkit.identification import (
    Binding,
    FreeRecord,
    PredictedWindow,
    Prediction,
    RecordOffsets,
    Smoothed,
    Trial,
    evaluate_trials,
    free_records,
    sea_notes,
)
from pmmkit.inference import COVERAGE
from pmmkit.models import Model
from pmmkit.numerics import Array, rms
from pmmkit.presentation import WIDE, counted, listed
from pmmkit.reduction import idle
from pmmkit.simulation import Manoeuvre as Orders
from pmmkit.simulation import Track, executed_at, simulate
from pmmkit.validation.prediction import at_the_scale_of
from pmmkit.validation.statistics import ChannelError

# Manoeuvres beside measured ones: turning circles, zigzags, stops.


@dataclass(frozen=True, kw_only=True, eq=False)
class ManoeuvreComparison:
    """One manoeuvre of a trial beside the same one predicted.

    Parameters
    ----------
    run : Run
        The run.
    trial : Trial
        Measured.
    track : Track
        Predicted: simulated by a model with the ship's own steering, or the trial of a submission.
    executed : Track, optional
        Simulated with each execute of a zigzag at the heading of the run, late as it was.
    """

    run: Run
    trial: Trial
    track: Track
    executed: Track | None = None

    @property
    def submitted_run(self) -> str:
        """Id of the run of a submission; empty of a model."""
        return self.track.run if isinstance(self.track, Trial) else ""

    def rows(self) -> list[dict[str, Any]]:
        """A row a measure that both have: measured, predicted, error (predicted less measured),
        expanded uncertainty (of the measured, and of what is submitted)."""
        found = []
        for name, measured in self.trial.metrics.items():
            predicted = self.track.metrics.get(name, math.nan)
            if math.isnan(measured) or math.isnan(predicted):
                continue
            doubt = COVERAGE * math.hypot(self.trial.std.get(name, math.nan), self._std(name))
            error = predicted - measured
            late = math.nan if self.executed is None else self.executed.metrics.get(name, math.nan)
            found.append(
                {
                    "run": self.run.id,
                    "test": self.run.test,
                    "speed": self.run.settings.speed,
                    "measure": name,
                    "unit": Metric.of(name).unit_of(name),
                    "measured": measured,
                    "predicted": predicted,
                    "error": error,
                    "relative": error / measured if measured else math.nan,
                    "uncertainty": doubt,
                    "ratio": abs(error) / doubt if doubt else math.nan,
                    "as_executed": late,
                    "error_as_executed": late - measured,
                }
            )
        return found

    def _std(self, name: str) -> float:
        """Standard uncertainty of a predicted measure: a model states none."""
        return self.track.std.get(name, math.nan) if isinstance(self.track, Trial) else 0.0


GEAR: Final = 0.1
"""Share by which a steering gear may differ from the model's before it is said."""
DRIFTS: Final = 3.0
"""Standard uncertainties from which a drift of turning circles is told."""
WINDOW: Final = 15.0
"""Length of the windows that are predicted, in ship lengths over the speed of the approach."""
MOTIONS: Final[Mapping[str, str]] = {
    "position": "m",
    "heading": "deg",
    "speed": "m/s",
    "yaw_rate": "deg/s",
}
"""Errors of the motion and their units."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FreeRun:
    """One free-running record, measured and simulated with the measured rudder and revolutions.

    Parameters
    ----------
    run : Run
        The run it is of.
    name : str
        Of the record.
    Fn : float
        Froude number of the approach.
    t, delta : array (n,)
        Instants [s], measured rudder [rad].
    measured, std : mapping of str to array (n,)
        Smoothed x, y [m], psi [rad], u, v [m/s], r [rad/s], and their standard uncertainties.
    predicted, predicted_std : mapping of str to array (n,)
        The same as simulated from the measured start to the end of the record, and how uncertain
        it is by that start and by what the model states of its values.
    force, force_std : mapping of channel to array (n,)
        What the water must have exerted by the smoothed motion [N, N m], and its standard
        uncertainty.
    force_predicted : mapping of channel to array (n,)
        What the model says along the same motion.
    window : float
        Length of the windows that are predicted too [s]; NaN for a record shorter than that.
    window_errors : mapping of str to float
        Root mean square errors over the windows, as `Prediction.errors`.
    """

    run: Run
    name: str
    Fn: float
    t: Array
    delta: Array
    measured: Mapping[str, Array]
    std: Mapping[str, Array]
    predicted: Mapping[str, Array]
    predicted_std: Mapping[str, Array]
    force: Mapping[str, Array]
    force_std: Mapping[str, Array]
    force_predicted: Mapping[str, Array]
    window: float
    window_errors: Mapping[str, float]

    def errors(self, floor: float = 0.0) -> dict[str, ChannelError]:
        """By channel: of the forces, and of `MOTIONS` over the whole record.

        Parameters
        ----------
        floor : float
            Share of the measured rms force that counts as uncertain whatever else is known.
        """
        return {
            **{name: self._force_error(name, floor) for name in self.force},
            **{name: self._motion_error(name) for name in MOTIONS},
        }

    def doubt(self, name: str) -> Array:
        """Expanded uncertainty of a motion as predicted less as measured, array (n,) [SI].

        Parameters
        ----------
        name : str
            Key of `measured`.
        """
        return COVERAGE * np.hypot(self.std[name], self.predicted_std[name])

    def _force_error(self, name: str, floor: float) -> ChannelError:
        force = self.force[name]
        return ChannelError.of_samples(
            self.force_predicted[name] - force,
            force,
            COVERAGE * np.hypot(self.force_std[name], floor * rms(force)),
        )

    def _motion_error(self, name: str) -> ChannelError:
        m, p, doubt = self.measured, self.predicted, self.doubt
        if name == "position":
            error = np.stack([p[x] - m[x] for x in "xy"])
            gone = np.stack([m[x] - m[x][0] for x in "xy"])
            return ChannelError.of_samples(error, gone, np.stack([doubt("x"), doubt("y")]))
        if name == "speed":
            speed, simulated = np.hypot(m["u"], m["v"]), np.hypot(p["u"], p["v"])
            own = np.hypot(_of_speed(m, self.std), _of_speed(p, self.predicted_std))
            return ChannelError.of_samples(simulated - speed, speed, COVERAGE * own)
        angle = {"heading": "psi", "yaw_rate": "r"}[name]
        turned = m["psi"] - m["psi"][0] if angle == "psi" else m["r"]
        degrees = math.degrees(1.0)
        return ChannelError.of_samples(
            degrees * (p[angle] - m[angle]), degrees * turned, degrees * doubt(angle)
        )


def _of_speed(motion: Mapping[str, Array], std: Mapping[str, Array]) -> Array:
    """Standard uncertainty of √(u² + v²), whose slopes are u and v over itself."""
    course = np.arctan2(motion["v"], motion["u"])
    found: Array = np.hypot(np.cos(course) * std["u"], np.sin(course) * std["v"])
    return found


def compare_free(
    model: Model,
    campaign: Campaign,
    *,
    window: float | None = None,
    extrapolate: bool = False,
    progress: Progress | None = None,
) -> tuple[tuple[FreeRun, ...], tuple[ManoeuvreComparison, ...], tuple[str, ...]]:
    """Every free-running record beside a model.

    window [s].
    """
    made, notes = as_tested(model, campaign)
    notes += idle(campaign.uncertainty, ())
    known = RecordOffsets.of(made, campaign.title)
    campaign = known.taken_off(campaign)
    runs: list[FreeRun] = []
    manoeuvres: list[ManoeuvreComparison] = []
    lost: dict[str, list[str]] = {}
    used: list[FreeRecord] = []
    apart: list[str] = []
    reckoned = 0
    for number, run in enumerate(campaign, start=1):
        if progress is not None:
            progress(number, len(campaign), f"compare {run.id}")
        data = run.data
        held = run.with_(loader=lambda data=data: data)
        try:
            found = [
                record.with_(current=known.current)
                for record in free_records(
                    held, made, depth=campaign.depth_of(run), campaign=campaign.title
                )
            ]
            records = Smoothed.references(made, found, extrapolate=extrapolate)
            runs += [_compared(made, held, item, window, extrapolate) for item in records]
            used += found
            apart += [item.name for item in records if item.disagrees]
            reckoned += any(item.reckoned for item in found)
        except PmmkitError as error:
            lost.setdefault(_beside_run(error), []).append(run.id)
            continue
        if run.kind_of_test.of_standard:
            try:
                manoeuvres.append(_sailed(made, held, campaign, known, extrapolate))
            except PmmkitError as error:
                notes.append(f"{run.id} has no measures: {error}")
    reasons = [
        f"{listed(ids)} {'is' if len(ids) == 1 else 'are'} left out: {why}"
        for why, ids in lost.items()
    ]
    if not runs:
        raise DataError(reasons or ["There is no run."], title="Nothing can be compared")
    notes += sea_notes(made, used)
    if apart:
        notes.append(
            f"In {len(apart)} of {counted(len(runs), 'record')} the sensors disagree: positions "
            "are not where heading and velocities lead. Each channel is compared with its own "
            "sensor."
        )
    if reckoned:
        notes.append(
            f"{counted(reckoned, 'record')} without positions: the track is dead reckoning from "
            "the measured velocities."
        )
    if known.values:
        notes.append(f"The records are taken as the model's steps say: {known.words}.")
    if "rate_deg_s" not in campaign.rudder:
        notes += _steering_gear(made, manoeuvres)
    if not any(known.current):
        notes += _drifting(manoeuvres)
    return tuple(runs), tuple(manoeuvres), (*notes, *reasons)


def _beside_run(error: PmmkitError) -> str:
    """What an error says but for the run, so that many runs with one reason are one sentence."""
    if not isinstance(error, DataError):
        return str(error)
    return str(DataError([replace(x, run=None) for x in error.problems], title=error.title))


def _steering_gear(model: Model, manoeuvres: Sequence[ManoeuvreComparison]) -> list[str]:
    """What is to be said where the rudder of the records is not as fast as the model's."""
    rates = [item.trial.rudder_rate_deg for item in manoeuvres]
    measured = float(np.median([rate for rate in rates if math.isfinite(rate)] or [math.nan]))
    own = float(model.steering.get("rate_deg_s", math.nan))
    if not abs(measured / own - 1.0) > GEAR:
        return []
    return [
        f"The rudder moves at {measured:.2g} deg/s in the records and at {own:.2g} deg/s in the "
        "model: manoeuvres are simulated with the former."
    ]


def _drifting(manoeuvres: Sequence[ManoeuvreComparison]) -> list[str]:
    """What turning circles tell of a current that the tracks are not sailed in."""
    found = Trial.mean_current(
        item.trial for item in manoeuvres if abs(item.trial.turned_deg) >= 360.0
    )
    if found is None or found.speed < DRIFTS * found.speed_std:
        return []
    return [
        f"Circles drift at {found.speed:.2g} ± {WIDE * found.speed_std:.1g} m/s to "
        f"{found.direction_deg:03.0f}° ({found.origin}): their measures are through the water, but "
        "tracks are compared in still water. pmmkit diagnose tells whether it is a current; once "
        "added, the comparison sails in it."
    ]


def as_tested(model: Model, campaign: Campaign) -> tuple[Model, list[str]]:
    """A model at the scale of free-running tests, with their mass, inertia and water.

    Parameters
    ----------
    model : Model
        The model.
    campaign : Campaign
        The tests.

    Returns
    -------
    Model, list of str
        The model as it is tested, and what was changed, in words.
    """
    made, notes = at_the_scale_of(model, campaign.ship)
    own, theirs = made.ship, campaign.ship
    given = {
        name: getattr(theirs, name)
        for name in ("mass", "Izz", "xG", "volume", "zG", "GM", "Ixx")
        if getattr(theirs, name) is not None
    }
    if abs(theirs.mass / own.mass - 1.0) > 1e-3 or abs(theirs.Izz / own.Izz - 1.0) > 1e-3:
        notes.append(
            f"Mass, inertia and centre of gravity are those of the tests: {theirs.mass:.5g} kg and "
            f"{theirs.Izz:.5g} kg m² (the model has {own.mass:.5g} and {own.Izz:.5g})."
        )
    return replace(made, ship=replace(own, **given), water=campaign.water), notes


def _compared(
    model: Model, run: Run, smoothed: Smoothed, window: float | None, extrapolate: bool
) -> FreeRun:
    record = smoothed.record
    length = window or WINDOW * model.ship.L / record.speed
    whole = PredictedWindow.of(
        {"model": model},
        [smoothed],
        window=float(record.t[-1] - record.t[0]),
        extrapolate=extrapolate,
    )
    errors: Mapping[str, float] = {}
    if record.t[-1] - record.t[0] >= length:
        errors = Prediction.of(model, [smoothed], window=length, extrapolate=extrapolate).errors[
            record.name
        ]
    implied = Smoothed.of(model, record, extrapolate=extrapolate).implied_forces(model)
    held = Binding.of(
        model, (), record.speed, conditions=record.conditions, extrapolate=extrapolate
    )
    said = held.equations.water_forces(implied.motion)
    names = tuple(whole.measured)
    return FreeRun(
        run=run,
        name=record.name,
        Fn=model.ship.froude(record.speed, model.water.g),
        t=whole.t,
        delta=whole.delta,
        measured=whole.measured,
        predicted=whole.predicted["model"],
        predicted_std=MappingProxyType(
            Prediction.std(model, smoothed, np.arange(len(whole.t)), extrapolate=extrapolate)
        ),
        std=MappingProxyType({name: smoothed.motion_std[name] for name in names}),
        force=implied.forces,
        force_std=MappingProxyType({name: np.asarray(x, float) for name, x in implied.std.items()}),
        force_predicted=MappingProxyType({name: said[name] for name in implied.forces}),
        window=length if errors else math.nan,
        window_errors=errors,
    )


def _sailed(
    model: Model, run: Run, campaign: Campaign, known: RecordOffsets, extrapolate: bool
) -> ManoeuvreComparison:
    """A manoeuvre measured, and simulated with the ship's own steering and revolutions held."""
    settings = run.settings
    flow = known.current
    (trial,) = evaluate_trials(campaign, runs=[run.id], current=flow if any(flow) else None)
    asked: dict[str, Any] = {}
    if run.kind_of_test.turns_rudder:
        asked["rudder_deg"] = math.degrees(settings.rudder)
    if run.kind_of_test.switches:
        switch = settings.rudder if settings.switch is None else settings.switch
        asked |= {"switch_deg": abs(math.degrees(switch)), "executes": max(len(trial.orders), 3)}
    stated = campaign.rudder.get("rate_deg_s")
    rate = trial.rudder_rate_deg if stated is None else float(stated)

    def sailed(manoeuvre: str | Orders) -> Track:
        return simulate(
            model,
            manoeuvre,
            speed=settings.speed,
            depth=campaign.depth_of(run) if model.feels("depth") else None,
            extrapolate=extrapolate,
            rudder_rate_deg=rate if math.isfinite(rate) else None,
            **asked,
        )

    executed = None
    if run.kind_of_test.switches and len(trial.orders) > 1:
        executed = sailed(executed_at(trial.reversals))
    return ManoeuvreComparison(run=run, trial=trial, track=sailed(run.test), executed=executed)
