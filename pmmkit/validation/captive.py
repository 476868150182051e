"""Captive tests beside a model: forces predicted on the measured motion."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pmmkit.base import DataError, ExtrapolationError, Progress
from pmmkit.campaigns import Campaign, Rig, TypeB
from pmmkit.conventions import CHANNELS
from pmmkit.effects import CATALOGUE
from pmmkit.inference import COVERAGE
from pmmkit.models import Model, Step
from pmmkit.numerics import Array
from pmmkit.presentation import listed
from pmmkit.reduction import RunViews, View, idle
from pmmkit.simulation import Spread
from pmmkit.validation.prediction import Forces, Predictor, in_the_tank
from pmmkit.validation.statistics import ChannelError
from pmmkit.validation.uncertainty import (
    OF_MEASUREMENT,
    SHARES,
    Share,
    model_share,
    rms_of,
    scales,
    sources_of,
    stated_share,
    stated_spread,
)

# What the faults of a laboratory, as a model's steps tell them, do to captive runs.


def sizes_told(steps: Mapping[str, Step]) -> dict[str, tuple[float, ...]]:
    """Sizes of the faults that steps tell, as the coefficients of the effects stand."""
    sizes = {}
    for name, step in steps.items():
        effect = CATALOGUE[name]
        labels = [item.name for item in effect.coefficients]
        if effect.acts is not None and not effect.each_run and set(labels) <= {*step.coefficients}:
            sizes[name] = tuple(float(step.coefficients[x]) for x in labels)  # type: ignore[arg-type]
    return sizes


def shown_too_much(view: View, predictor: Predictor, steps: Mapping[str, Step]) -> dict[str, Array]:
    """Harmonics that a run shows beside the forces of the water, by channel [N, N m]."""
    seen = RunViews(views=(view,), base=predictor)
    beside: dict[str, Array] = {}
    for name, sizes in sizes_told(steps).items():
        effect = CATALOGUE[name]
        at = {effect.nonlinear.name: steps[name].value or 0.0} if effect.nonlinear else {}
        shown = effect.slopes(seen, at, list(effect.typical))
        for channel, columns in shown.items():
            for size, column in zip(sizes, columns, strict=True):
                beside[channel] = beside.get(channel, 0.0) + size * column
    return beside


@dataclass(frozen=True, kw_only=True, eq=False)
class CaptiveRun:
    """One captive run, measured and predicted.

    Parameters
    ----------
    view : View
        What was measured: a mean, or the harmonics of the cycles that a reduction would take.
    Fn : float
        Froude number.
    predicted : mapping of channel to array (m,)
        Harmonics of the forces of the water that the model predicts on the same motion [N, N m].
    history : mapping of channel to array (n,)
        The prediction at the samples of the view.
    shares : mapping of str to mapping of channel to array (m,)
        What the validation uncertainty is made of, as standard uncertainties: `SHARES`.
    """

    view: View
    Fn: float
    predicted: Share
    history: Share
    shares: Mapping[str, Share]

    @property
    def channels(self) -> tuple[str, ...]:
        """Channels that are compared."""
        return tuple(self.predicted)

    def error(self, channel: str) -> Array:
        """Comparison error of each harmonic, predicted less measured [N, N m]."""
        found: Array = self.predicted[channel] - self.view.force[channel]
        return found

    def errors(self, channel: str) -> ChannelError:
        """The comparison error over a cycle."""
        return ChannelError.of_harmonics(
            self.error(channel),
            self.view.force[channel],
            self.uncertainty(channel),
            self.view.labels,
        )

    def uncertainty(self, channel: str) -> Array:
        """Expanded validation uncertainty of each harmonic (k = 2) [N, N m]."""
        return self._expanded(channel, SHARES)

    def measurement_uncertainty(self, channel: str) -> Array:
        """The measurement's own part of it, U_D: noise, scatter, stated, numerical [N, N m]."""
        return self._expanded(channel, OF_MEASUREMENT)

    def _expanded(self, channel: str, shares: Sequence[str]) -> Array:
        squares = [self.shares[name][channel] ** 2 for name in shares]
        found: Array = COVERAGE * np.sqrt(np.sum(squares, axis=0))
        return found

    def rms(self, harmonics: Array) -> float:
        """Root mean square over a cycle of what harmonics of this run describe."""
        return rms_of(harmonics, self.view.labels)

    def residual(self, rig: Rig) -> dict[str, Array]:
        """The record in time: t [s], and by channel measured and predicted force [N, N m].

        Parameters
        ----------
        rig : Rig
            Of the campaign, from `rig_of`.
        """
        view, run = self.view, self.view.run
        if run.kind != "history":
            raise DataError(f"Run {run.id} is a row of a table: it has no record in time.")
        data = run.data
        times = np.asarray(data["t"].values, float)
        cut = np.searchsorted(times - times[0], view.t - 1e-9)
        force = rig.force_of_water(
            {name: np.asarray(data[name].values, float)[cut] for name in CHANNELS if name in data},
            run,
            view.motion,
        )
        return {"t": view.t} | {
            key: values
            for name in self.channels
            for key, values in (
                (f"{name}_measured", force[name]),
                (f"{name}_predicted", self.history[name]),
            )
        }


def observed(campaign: Campaign) -> tuple[View, ...]:
    """What captive tests say, whichever model stands beside them.

    Parameters
    ----------
    campaign : Campaign
        The captive tests.
    """
    return View.of(campaign, unknown_noise=True, pieces=False)


def compare_captive(
    model: Model,
    campaign: Campaign,
    *,
    floor: float,
    extrapolate: bool = False,
    views: Sequence[View] | None = None,
    progress: Progress | None = None,
) -> tuple[tuple[CaptiveRun, ...], tuple[str, ...]]:
    """Every captive run beside a model."""
    predictor = in_the_tank(model, campaign, extrapolate=extrapolate)
    rig = campaign.rig
    views = observed(campaign) if views is None else views
    notes = [
        *predictor.notes,
        *idle(campaign.uncertainty, [(view.run, tuple(view.force)) for view in views]),
    ]
    faults = model.faults_of(campaign.title or campaign.ship.name)
    sizes = sizes_told(faults)
    if sizes:
        notes.append(
            f"The prediction holds what the model's steps tell of these tests: "
            f"{listed(list(sizes))}."
        )
    if left := [name for name in faults if name not in sizes]:
        notes.append(
            f"Not in the prediction, for no size is told that holds for every run: {listed(left)}."
        )
    scale = scales(views)
    known: dict[float, Spread | None] = {}
    compared: list[CaptiveRun] = []
    outside: list[str] = []
    for number, view in enumerate(views, start=1):
        if progress is not None:
            progress(number, len(views), f"compare {view.run.id}")
        try:
            forces = predictor.forces(view)
        except ExtrapolationError:
            outside.append(view.run.id)
            continue
        beside = shown_too_much(view, predictor, faults)
        if view.speed not in known:
            known[view.speed] = stated_spread(predictor, view.speed)
        compared.append(
            _compared(
                view, forces, beside, predictor, campaign, rig, scale, floor, known[view.speed]
            )
        )
    if outside:
        notes.append(
            f"Outside the speeds of the model and left out: {', '.join(outside)}. Extrapolation "
            f"is not allowed unless it is asked for."
        )
    compared, more = _judged(compared, predictor.model)
    if not compared:
        raise DataError(
            ["No run is left to compare.", *notes, *more], title="Nothing can be compared"
        )
    return tuple(compared), (*notes, *more)


def _compared(
    view: View,
    forces: Forces,
    beside: Mapping[str, Array],
    predictor: Predictor,
    campaign: Campaign,
    rig: Rig,
    scale: Mapping[str, float],
    floor: float,
    known: Spread | None,
) -> CaptiveRun:
    model = model_share(view, predictor, known)
    history = {
        name: x for name, x in forces(view.motion, view.instants).items() if name in view.force
    }
    if not predictor.model.rolls:
        history.pop("K", None)
    predicted = {name: view.project(x) + beside.get(name, 0.0) for name, x in history.items()}
    sources = sources_of(campaign, repeated=bool(view.repeated))
    own = measured_shares(view, campaign, rig, sources, forces, predicted)
    least = {name: np.full(view.rows, floor * scale[name] * view.speed**2) for name in predicted}
    return CaptiveRun(
        view=view,
        Fn=campaign.froude(view.run),
        predicted=predicted,
        history=history,
        shares={**own, "model": model, "floor": least},
    )


def measured_shares(
    view: View,
    campaign: Campaign,
    rig: Rig,
    sources: Sequence[TypeB],
    forces: Forces,
    predicted: Mapping[str, Array],
) -> dict[str, Share]:
    """Standard uncertainties of a run's harmonics that are the measurement's: `OF_MEASUREMENT`."""
    noise = {name: np.sqrt(np.diagonal(view.covariance[name])) for name in predicted}
    again = {
        name: np.full(view.rows, _beyond(view.repeated.get(name, 0.0), noise[name]))
        for name in predicted
    }
    told = {name for name in predicted if view.noise.get(name) == "stated"}
    stated = stated_share(
        view,
        rig,
        forces,
        [item for item in sources if item.kind.channel not in told],
        campaign.water.rho,
        predicted,
    )
    numerical = {
        name: np.full(
            view.rows,
            0.0 if view.noise.get(name) == "numerical" else campaign.numerical.get(name, 0.0),
        )
        for name in predicted
    }
    return {"noise": noise, "scatter": again, "stated": stated, "numerical": numerical}


def _beyond(scatter: float, noise: Array) -> float:
    """Scatter of repeats beyond what noise explains."""
    return math.sqrt(max(scatter**2 - float(np.mean(noise**2)), 0.0))


def _judged(found: Sequence[CaptiveRun], model: Model) -> tuple[list[CaptiveRun], list[str]]:
    """Notes on what the comparison rests on; a surge force without its resistance is taken out."""
    notes = []
    kept = list(found)
    if model.convention.surge == "delta-u":
        notes.append(
            "The model's surge force is that of the loss of speed under power, which towing tests "
            "do not measure: X is left out."
        )
        kept = [_without(item, "X") for item in found]
        kept = [item for item in kept if item.channels]
    unknown = sorted({name for item in kept for name in item.channels if not item.view.known(name)})
    if unknown:
        notes.append(
            f"Nothing is known of the noise of {', '.join(unknown)} in tables without repeats, "
            f"[uncertainty] or U_SN: their uncertainty holds only the floor and what else is named."
        )
    elsewhere = {origin for item in kept for origin in item.view.noise.values()} - {"unknown"}
    if elsewhere:
        words = {"repeats": "repeats", "stated": "[uncertainty]", "numerical": "U_SN"}
        notes.append(
            f"The noise of runs that are rows of tables is that of "
            f"{' and '.join(words[origin] for origin in sorted(elsewhere))}."
        )
    return kept, notes


def _without(item: CaptiveRun, channel: str) -> CaptiveRun:
    return replace(
        item,
        predicted={name: x for name, x in item.predicted.items() if name != channel},
        history={name: x for name, x in item.history.items() if name != channel},
    )
