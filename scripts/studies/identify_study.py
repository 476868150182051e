"""Identification from simulated records, over and over: coverage, and what it predicts.

    python -m scripts.studies.identify_study [--replicates 200] [--methods ekf] [--workers 4] \
        [--seed 0]

Two ships at full scale, KVLCC2 and the 170 m bulk carrier of the library. Each replicate
draws a start model (every value off by 20 %, one standard deviation), sails zigzags 10/10 and
20/20 and a pull-out with the true model, and samples what a ship has: position (1 m, 1 Hz), heading
(0.1°), yaw rate (0.02°/s), speed log ahead (0.05 m/s). The model identified from them turns with
35° of rudder, a manoeuvre that was not used. Intervals of 95 % are counted over all parameters and
over those that the records determine.
"""

from __future__ import annotations

import argparse
import math
import time
from dataclasses import replace

import numpy as np

import pmmkit as pk
from pmmkit.identification import FreeRecord, Prior, identify
from pmmkit.models import Model
from scripts.studies.bulk_carrier import NAME, TRIAL
from scripts.studies.workers import add_workers, crew, in_order
from tests.support.recorded import recorded

SENSORS = {"x": 1.0, "y": 1.0, "psi": math.radians(0.1), "r": math.radians(0.02), "u": 0.05}
NAMES = {
    "kvlcc2": (
        "Xuu",
        "Xvr",
        "Yv",
        "Yr",
        "Yvvv",
        "Yvvr",
        "Yvrr",
        "Nv",
        "Nr",
        "Nvvv",
        "Nvvr",
        "Nvrr",
        "Nrrr",
        "rudder_mmg.aH",
    ),
    "bulk carrier": (
        "Xuu",
        "Xvr",
        "Yv",
        "Yr",
        "Nv",
        "Nr",
        "crossflow_drag.CD",
        "rudder_mmg.aH",
        "rudder_mmg.epsilon",
    ),
}
SPREAD = 0.2
MANOEUVRES = (
    ("zigzag", {"rudder_deg": 10.0, "switch_deg": 10.0}),
    ("zigzag", {"rudder_deg": 20.0, "switch_deg": 20.0}),
    ("zigzag", {"rudder_deg": -20.0, "switch_deg": 20.0}),
    ("pull_out", {"rudder_deg": 25.0}),
)


def ship_of(name: str) -> tuple[Model, float]:
    """The true model, revolutions as an input, and its speed."""
    if name == "kvlcc2":
        return pk.load_model("kvlcc2"), 7.97
    return pk.load_model(NAME), TRIAL


def record(model: Model, speed: float, number: int, rng: np.random.Generator) -> FreeRecord:
    """One sampled manoeuvre."""
    manoeuvre, settings = MANOEUVRES[number]
    track = pk.simulate(model, manoeuvre, speed=speed, dt=1.0, **settings)
    return recorded(track, SENSORS, rng, name=f"{manoeuvre} {number}", speed=speed)


def replicate(asked: tuple[str, str, int]) -> dict[str, object]:
    """One campaign, one identification, one turn."""
    name, method, seed = asked
    rng = np.random.default_rng([seed, len(name)])
    truth, speed = ship_of(name)
    prior = Prior.of(truth, NAMES[name], speed, spread=SPREAD)
    true = prior.mean
    prior = replace(prior, mean=true + prior.std * rng.normal(size=len(true)))
    records = [record(truth, speed, number, rng) for number in range(len(MANOEUVRES))]
    began = time.perf_counter()
    found = identify(truth, records, NAMES[name], method=method, prior=prior, sensors=SENSORS)
    seconds = time.perf_counter() - began
    seen = np.array([item not in found.unseen for item in found.names])
    held = np.abs(found.values - true) <= 1.96 * found.std
    turns = [pk.simulate(m, "turning", speed=speed).metrics for m in (truth, found.model)]
    off = {key: turns[1][key] / turns[0][key] - 1.0 for key in ("tactical_diameter", "advance")}
    return {
        "held": held,
        "seen": seen,
        "off": off,
        "seconds": seconds,
        "method": method,
        "share": found.std / prior.std,
        "samples": sum(len(item) for item in records),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--replicates", type=int, default=200)
    parser.add_argument("--methods", nargs="+", default=["ekf"])
    add_workers(parser, usual=4)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    for name in NAMES:
        for method in options.methods:
            replicate((name, method, options.seed))
            asked = [(name, method, options.seed + i) for i in range(options.replicates)]
            with crew(options) as executor:
                told(name, method, in_order(replicate, asked, executor))


def told(name: str, method: str, found: list[dict]) -> None:
    held, seen = (np.stack([item[key] for item in found]) for key in ("held", "seen"))
    print(f"\n{name}, {method}, {len(found)} replicates, {found[0]['samples']} samples each")
    print(
        f"  95 % intervals hold the truth: all {100 * held.mean():.1f} %, "
        f"determined ones {100 * held[seen].mean():.1f} %"
    )
    for key in ("tactical_diameter", "advance"):
        off = 100 * np.abs([item["off"][key] for item in found])
        print(
            f"  {key:18} off by {off.mean():.2f} % on average, {np.median(off):.2f} % median, "
            f"{np.quantile(off, 0.95):.2f} % in 95 of 100"
        )
    share = np.median([item["share"] for item in found], axis=0)
    per = held.mean(axis=0)
    for item, ratio, kept in zip(NAMES[name], share, per, strict=True):
        print(f"    {item:22} std over prior {ratio:.3f}, held {100 * kept:.1f} %")
    print(f"  seconds: median {np.median([item['seconds'] for item in found]):.2f}")


if __name__ == "__main__":
    main()
