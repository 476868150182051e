"""Intervals of a model of the wrong structure, before the loop and after it.

    python -m scripts.studies.wrong_structure [--seeds 5] [--cases roll stall wind kvlcc2-stall]

A ship rolls, has a rudder that stalls, or sails in wind; the model knows nothing of it, and its
derivatives are off by 20 % (one standard deviation). They are identified; then `diagnose` is asked
what is missing (the whole catalogue), what it names is put in, and they are identified again
together with the values of what was named. Counted is how many 95 % intervals of the derivatives
that the model had from the beginning hold the truth.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

import numpy as np

import pmmkit as pk
from pmmkit.base import DataError
from pmmkit.diagnosis.free_running.diagnose import diagnose_free
from pmmkit.diagnosis.free_running.hypotheses import WIDER, candidates_for
from pmmkit.effects import OUTSIDE
from pmmkit.identification import FreeRecord, Prior, identify, places
from pmmkit.identification.binding import with_parameters
from pmmkit.identification.from_run import measured_roll
from pmmkit.models import Model, Part
from tests.support.recorded import recorded

METHODS = ("ekf", "ukf", "trajectory", "regression")
SPREAD = 0.2
LARGE = {
    "x": 0.3,
    "y": 0.3,
    "psi": math.radians(0.1),
    "u": 0.02,
    "v": 0.02,
    "r": math.radians(0.01),
}
SMALL = {"x": 0.02, "y": 0.02, "psi": math.radians(0.1), "r": math.radians(0.05), "u": 0.01}
HEEL = math.radians(0.1)
WIND = {"wind_speed": 12.0, "wind_direction_deg": 40.0}
LARGE_RUNS = (
    ("turning", 7.0, 25.0),
    ("turning", 7.0, -35.0),
    ("zigzag", 7.0, 15.0),
    ("zigzag", 7.0, -25.0),
    ("zigzag", 10.0, 10.0),
    ("turning", 10.0, 20.0),
)
SMALL_RUNS = (
    ("turning", 1.179, 35.0),
    ("turning", 1.179, -35.0),
    ("zigzag", 1.179, 20.0),
    ("zigzag", 1.179, -10.0),
)
SMALL_NAMES = (
    *("Xvr", "Yv", "Yr", "Yvvv", "Yvvr", "Yvrr"),
    *("Nv", "Nr", "Nvvv", "Nvvr", "Nvrr", "Nrrr"),
)


@dataclass(frozen=True)
class Case:
    """A true ship, the model that knows less, and how the ship is tested."""

    truth: Model
    model: Model
    names: tuple[str, ...]
    sensors: Mapping[str, float]
    runs: Sequence[tuple[str, float, float]]
    duration: float
    dt: float
    wind: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))


def stalling(model: Model) -> Model:
    """The model with a rudder that stalls at 18° and loses 40 % of its force."""
    rudder = model.parts["rudder_mmg"]
    made = replace(
        rudder,
        options=MappingProxyType({**rudder.options, "stall": "smooth"}),
        values=MappingProxyType({**rudder.values, "stall_deg": 18.0, "stall_loss": 0.4}),
    )
    return replace(model, parts=MappingProxyType({**model.parts, "rudder_mmg": made}))


def in_wind(model: Model) -> Model:
    """The model with a superstructure."""
    values = {"AF": 500.0, "AL": 2000.0, "cx": 0.7, "cy": 0.8, "cn": 0.1}
    part = Part(effect="wind", source="study", values=MappingProxyType(values))
    return replace(model, parts=MappingProxyType({**model.parts, "wind": part}))


def case_of(name: str) -> Case:
    """A case by name."""
    if name.startswith("kvlcc2"):
        tanker = pk.load_model("kvlcc2-l7")
        truth = stalling(tanker) if name.endswith("stall") else tanker
        return Case(truth, tanker, SMALL_NAMES, SMALL, SMALL_RUNS, 150.0, 0.4)
    flat = pk.load_model("s175-3dof")
    truths = {"right": flat, "roll": pk.load_model("s175"), "stall": stalling(flat)}
    truth = in_wind(flat) if name == "wind" else truths[name]
    hull = tuple(flat.parts["hull_polynomial"].values)
    around = MappingProxyType(WIND) if name == "wind" else MappingProxyType({})
    return Case(truth, flat, hull, LARGE, LARGE_RUNS, 600.0, 1.0, around)


def record(case: Case, number: int, seed: int) -> FreeRecord:
    """One manoeuvre of the true ship as its sensors see it, with heel and wind."""
    kind, speed, angle = case.runs[number]
    settings: dict[str, Any] = (
        {"switch_deg": abs(angle)} if kind == "zigzag" else {"duration": case.duration}
    )
    track = pk.simulate(
        case.truth, kind, speed=speed, rudder_deg=angle, dt=case.dt, **settings, **case.wind
    )
    rng = np.random.default_rng([seed, number])
    record = recorded(track, case.sensors, rng, name=f"{kind} {number}", speed=speed)
    inputs: dict[str, Any] = {}
    if case.truth.rolls:
        seen = track.phi + HEEL * rng.normal(size=len(track))
        inputs["roll"], inputs["roll_rate"], inputs["roll_acceleration"] = measured_roll(
            track.t, seen
        )
    if case.wind:
        inputs["wind_speed"] = np.full(len(track), case.wind["wind_speed"])
        angle_of_wind = math.radians(case.wind["wind_direction_deg"])
        inputs["wind_direction"] = np.full(len(track), angle_of_wind)
    return replace(record, **inputs)


def extended(
    model: Model, prior: Prior, records: Sequence[FreeRecord], effects: Sequence[str], better: Model
) -> tuple[Model, Prior]:
    """Model and prior with the values of effects, begun where the diagnosis found them.

    Each is known no better than its usual size tells.
    """
    every = {item.name: item for item in candidates_for(model, records)}
    std: dict[str, float] = {}
    for effect in effects:
        item = every[effect]
        model = item.added_to(model)
        for label, moved in item.moves.items():
            for name, share in moved.items():
                if name not in prior.names and name not in OUTSIDE:
                    size = WIDER * abs(share) * item.typical[label]
                    std[name] = math.hypot(std.get(name, 0.0), size)
    numbers = better.values_at(records[0].speed, extrapolate=True)
    found = np.array([float(numbers[home][own]) for home, own in places(better, list(std))])
    model = with_parameters(model, places(model, list(std)), found)
    whole = np.zeros((len(prior.names) + len(std),) * 2)
    whole[: len(prior.names), : len(prior.names)] = prior.covariance
    for place, size in enumerate(std.values(), start=len(prior.names)):
        whole[place, place] = size**2
    return model, Prior(
        names=(*prior.names, *std), mean=np.concatenate([prior.mean, found]), covariance=whole
    )


def held(
    model: Model, records: Sequence[FreeRecord], prior: Prior, case: Case, true: np.ndarray
) -> dict[str, float]:
    """Share of the intervals of the derivatives that hold the truth, by method; NaN where one
    refuses."""
    found = {}
    for method in METHODS:
        found |= {method: math.nan, f"{method} width": math.nan}
        try:
            item = identify(
                model, records, prior.names, method=method, prior=prior, sensors=case.sensors
            )
        except DataError as error:
            print(f"    {method} refuses: {error}", flush=True)
            continue
        count = len(case.names)
        inside = np.abs(item.values[:count] - true) < 1.96 * item.std[:count]
        found[method] = float(np.mean(inside))
        found[f"{method} width"] = float(np.median(item.std[:count] / prior.std[:count]))
    return found


def play(name: str, seed: int) -> tuple[dict[str, float], dict[str, float], list[str]]:
    """Coverage before and after the loop, and what was named."""
    case = case_of(name)
    records = [record(case, number, seed) for number in range(len(case.runs))]
    prior = Prior.of(case.model, case.names, case.runs[0][1], spread=SPREAD)
    true = prior.mean
    off = np.random.default_rng(seed + 100).normal(size=len(true))
    prior = replace(prior, mean=true + prior.std * off)
    start = with_parameters(case.model, places(case.model, prior.names), prior.mean)
    blind = [
        item.calm().with_(roll=None, roll_rate=None, roll_acceleration=None) for item in records
    ]
    before = held(start, blind, prior, case, true)
    began = time.process_time()
    found = diagnose_free(start, records, prior=prior, sensors=case.sensors)
    seconds = time.process_time() - began
    named = [item.effect for item in found.findings]
    turned = found.corrections.get("rudder_zero", 0.0)
    corrected = [item.with_(delta=item.delta + turned) for item in records]
    model, wider = extended(start, prior, records, named, found.model or start)
    after = held(model, corrected if named else blind, wider, case, true)
    print(
        f"  {name} {seed}: {found.verdict} {named} {found.flags} {seconds:.0f} s\n    "
        + "  ".join(f"{key} {100 * before[key]:.0f} -> {100 * after[key]:.0f}" for key in METHODS),
        flush=True,
    )
    return before, after, named


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--cases", nargs="+", default=["roll", "stall", "wind", "kvlcc2-stall"])
    options = parser.parse_args()
    for name in options.cases:
        rows = [play(name, seed) for seed in range(options.seeds)]
        print(name, "95 % intervals that hold the truth, before and after; std over the prior's")
        for key in METHODS:
            shares = [np.nanmean([row[i][key] for row in rows]) for i in (0, 1)]
            widths = [np.nanmedian([row[i][f"{key} width"] for row in rows]) for i in (0, 1)]
            print(
                f"  {key:12} {100 * shares[0]:3.0f} % {100 * shares[1]:3.0f} %   "
                f"{widths[0]:.2f} {widths[1]:.2f}",
                flush=True,
            )


if __name__ == "__main__":
    main()
