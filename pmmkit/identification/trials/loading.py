"""From the loading of a trial to full load: by two models of the ship, or by model tests."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from pmmkit.base import DataError
from pmmkit.campaigns import Campaign
from pmmkit.conventions import METRICS, Criterion
from pmmkit.identification.trials.evaluate import evaluate_trials
from pmmkit.identification.trials.table import Trial
from pmmkit.imo import LOADED, Verdict
from pmmkit.models import Model, Standing, load_model
from pmmkit.presentation import Grid, Group, percent
from pmmkit.simulation import simulate

SAME_LENGTH: Final = 0.01
"""Share by which the lengths of trial and models may differ."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LoadingPrediction:
    """What says how a ship does in one loading.

    Parameters
    ----------
    name : str
        Of the model or the tests.
    L, draught : float
        At its own scale [m].
    model : Model, optional
        A model at the scale of the ship, which sails as the trial did.
    tests : tuple of Trial
        Free-running model tests, whose measures in ship lengths and degrees are taken as they are.
    """

    name: str
    L: float
    draught: float
    model: Model | None = None
    tests: tuple[Trial, ...] = ()

    @classmethod
    def of(cls, source: Model | Campaign | str | Path) -> LoadingPrediction:
        """A model as a prediction, or free-running model tests.

        Parameters
        ----------
        source : Model, Campaign, str or path
            A model, its library name or file; or turning circles, zigzags and stops of a ship model
            in the loading.
        """
        if isinstance(source, Campaign):
            ship, tests = source.ship, evaluate_trials(source)
            return cls(name=source.title, L=ship.L, draught=ship.d, tests=tests)
        model = source if isinstance(source, Model) else load_model(source)
        return cls(name=model.name, L=model.ship.L, draught=model.ship.d, model=model)

    def value(self, trial: Trial, verdict: Verdict, settings: dict[str, Any]) -> float:
        """The measure of a verdict; NaN where there is none. Of several tests their mean."""
        if self.model is not None:
            return _simulated(self.model, trial, verdict, settings)
        asked = (verdict.criterion, verdict.side)
        found = [
            x.value
            for test in self.tests
            for x in test.verdicts
            if (x.criterion, x.side) == asked and math.isfinite(x.value)
        ]
        return sum(found) / len(found) if found else math.nan

    def unusable(self, speed: float) -> str:
        """Why a ratio to it is no ground for a verdict at an approach [m/s]; empty where it is."""
        return "" if self.model is None else Standing.of(self.model, speed).forced

    def to_full_load(
        self, trials: Sequence[Trial], full_load: LoadingPrediction, **settings: Any
    ) -> tuple[Corrected, ...]:
        """Every criterion of a trial at full load, by the ratio of another prediction to this one.

        Parameters
        ----------
        trials : sequence of Trial
            From `evaluate_trials`.
        full_load : LoadingPrediction
            Of the ship at full load, made by the same method as this one, of the ship in the
            condition of the trial: both models, or both model tests.
        **settings
            Of `simulate`, for models; of a stop `turns` and `reversal_s`, by default those
            measured.

        Returns
        -------
        tuple of Corrected
            Of each verdict whose measure both give, in the order of the trials. Models sail at the
            approach speed of the run with the rudder that was laid; the uncertainty of R is that of
            T times F/B, and has nothing of the predictions'. Nothing is met or failed by a ratio to
            a model that is not usable.

        Raises
        ------
        DataError
            If a model is of another length than the ship, or one is a model and the other tests.
        """
        if (self.model is None) is not (full_load.model is None):
            raise DataError(
                f"B and F are to be made by the same method: {self.name!r} and {full_load.name!r} "
                f"are a model and model tests."
            )
        for item in (self, full_load):
            others = {x.L for x in trials if abs(item.L / x.L - 1.0) > SAME_LENGTH}
            if item.model is not None and others:
                raise DataError(
                    f"Model {item.name!r} has L = {item.L:.4g} m, the ship of the trial "
                    f"{max(others):.4g} m. Carry it there first: pmmkit scale MODEL --length "
                    f"{max(others):g}."
                )
        found = []
        for trial in trials:
            unsettled = tuple(
                dict.fromkeys(
                    text for item in (self, full_load) if (text := item.unusable(trial.speed))
                )
            )
            for verdict in trial.verdicts:
                if math.isnan(verdict.value):
                    continue
                values = [item.value(trial, verdict, settings) for item in (self, full_load)]
                if all(math.isfinite(value) and value > 0.0 for value in values):
                    found.append(_corrected(trial, verdict, *values, unsettled=unsettled))
        return tuple(found)

    def notes(
        self, full_load: LoadingPrediction, *, L: float, draught: float, full_draught: float | None
    ) -> tuple[str, ...]:
        """What of the predictions is estimated, and where their draughts are not the ship's.

        Parameters
        ----------
        full_load : LoadingPrediction
            As for `to_full_load`.
        L, draught, full_draught : float, float, float or None
            Of the ship; mean draughts of the trial and of full load [m].
        """
        asked = (("as tried", self, draught), ("of full load", full_load, full_draught))
        loaded = tuple(
            f"The prediction {name} ({item.name}) is for {item.draught * L / item.L:.4g} m of "
            f"draught, the ship draws {own:.4g} m."
            for name, item, own in asked
            if own is not None and abs(item.draught * L / item.L / own - 1.0) > LOADED
        )
        models = [item.model for item in (self, full_load) if item.model is not None]
        notes = [
            stops.steps[-1].note
            for model in models
            if (stops := model.as_it_stops()) is not None and stops is not model
        ]
        return (*loaded, f"Stops of the models: {notes[0]}") if notes else loaded


@dataclass(frozen=True, kw_only=True)
class Corrected:
    """A measure of a trial carried to full load: R = T F/B.

    Parameters
    ----------
    run : str
        Id of the run.
    measured : Verdict
        T, as tried.
    tried, full : float
        B and F: the same as predicted in the condition of the trial and at full load, by one
        method.
    verdict : Verdict
        R beside its limit.

    References
    ----------
    IMO MSC/Circ.1053, Explanatory notes to the Standards for ship manoeuvrability, 2002, 3.4.1.
    """

    run: str
    measured: Verdict
    tried: float
    full: float
    verdict: Verdict

    @property
    def misses(self) -> float:
        """By how much the prediction as tried differs from what was measured, as a share of it."""
        return self.tried / self.measured.value - 1.0

    def to_dict(self) -> dict[str, Any]:
        """As plain data, by the letters of the notes."""
        return {
            "run": self.run,
            "criterion": self.measured.criterion,
            "side": self.measured.side,
            "unit": self.measured.unit,
            "T": self.measured.value,
            "B": self.tried,
            "F": self.full,
            "R": self.verdict.value,
            "B_over_T_less_1": self.misses,
            "limit": self.verdict.limit,
            "margin": self.verdict.margin,
            "passed": self.verdict.passed,
            "probability": self.verdict.probability,
        }

    @staticmethod
    def grid(found: Sequence[Corrected]) -> Grid:
        """T, B, F and R of each criterion as a table."""
        head = ["criterion", "side", "run", "T", "B", "B/T - 1", "F", "R = T F/B", "limit", ""]
        rows = [
            [
                item.measured.criterion.replace("_", " "),
                item.measured.side,
                item.run,
                f"{item.measured.value:.2f}",
                f"{item.tried:.2f}",
                percent(item.misses),
                f"{item.full:.2f}",
                f"{item.verdict.value:.2f}",
                f"{item.verdict.limit:.4g}",
                item.verdict.words,
            ]
            for item in found
        ]
        return Grid(head=head, groups=[Group(rows=rows)], texts=(1, 2))


def _simulated(model: Model, trial: Trial, verdict: Verdict, settings: dict[str, Any]) -> float:
    """The measure of a verdict by a model that sails as the trial did; NaN where it cannot."""
    criterion = next(item for _, item in METRICS.criteria if item.name == verdict.criterion)
    given = _sailed(model, trial, criterion)
    if criterion.manoeuvre == "stopping":
        stops = model.as_it_stops()
        if stops is None:
            return math.nan
        model = stops
        engine = verdict.full_astern
        if engine is not None:
            given["turns"] = engine.turns
            if engine.reversal_s > 0.0:
                given["reversal_s"] = engine.reversal_s
    track = simulate(model, criterion.manoeuvre, speed=trial.speed, **(given | settings))
    return float(track.metrics.get(verdict.metric, math.nan))


def _sailed(model: Model, trial: Trial, criterion: Criterion) -> dict[str, Any]:
    """Settings of the manoeuvre, with the rudder that was laid as far as the model has it."""
    given = dict(criterion.settings)
    if "rudder_deg" in given:
        most = model.steering.get("max_deg", math.inf)
        given["rudder_deg"] = math.copysign(min(abs(trial.rudder_deg), most), trial.rudder_deg)
    return given


def _corrected(
    trial: Trial, measured: Verdict, tried: float, full: float, *, unsettled: tuple[str, ...]
) -> Corrected:
    std = trial.std.get(measured.metric, math.nan)
    verdict = measured.carried(full / tried, std, unsettled)
    return Corrected(run=trial.run, measured=measured, tried=tried, full=full, verdict=verdict)
