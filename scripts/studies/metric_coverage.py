"""How often the Monte Carlo interval of a metric holds the truth: replicates of the S175 programme.

    python -m scripts.studies.metric_coverage [--replicates 200] [--ships 2000] [--workers 4]

Each replicate draws new noise, new gauge and setting errors, goes through the whole reduction to a
model, and turns so many ships with derivatives drawn from its covariance at each tested speed. The
truth is the turn of the derivatives that made the forces, on the same propeller and rudder.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from functools import partial

import numpy as np

import pmmkit as pk
from scripts.datasets.s175_programme import campaign
from scripts.datasets.s175_truth import load_truth
from scripts.studies.workers import add_workers, as_done, crew

FIRST_SEED = 50_000
SPEEDS = (6.0, 9.0, 12.0)
METRICS = ("advance_L", "transfer_L", "tactical_diameter_L", "steady_diameter_L")


def truth() -> np.ndarray:
    """Metrics of the true derivatives, (speeds, metrics)."""
    library = pk.load_model("s175-3dof")
    values = load_truth()
    rows = []
    for speed in SPEEDS:
        froude = library.ship.froude(speed, library.water.g)
        table = pk.from_values(values.at(froude), ship=library.ship, water=library.water)
        found = pk.simulate(pk.to_model(table, library), speed=speed, rudder_deg=35).metrics
        rows.append([found[name] for name in METRICS])
    return np.array(rows)


def one(seed: int, ships: int) -> np.ndarray:
    """Low and high end of the intervals, (speeds, metrics, 2)."""
    table = pk.reduce_campaign(
        campaign(load_truth(), seed, biased=True), check=False, executor=1
    ).table
    model = pk.to_model(table, "s175-3dof")
    rows = []
    for speed in SPEEDS:
        many = pk.monte_carlo(
            model, "turning", rudder_deg=35, speed=speed, n=ships, seed=seed, executor=1
        )
        rows.append([many.interval(name) for name in METRICS])
    return np.array(rows)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--replicates", type=int, default=200)
    parser.add_argument("--ships", type=int, default=2000)
    add_workers(parser, usual=os.cpu_count() or 1)
    options = parser.parse_args()
    right, start = truth(), time.perf_counter()
    seeds = range(FIRST_SEED, FIRST_SEED + options.replicates)
    answers = {}
    with crew(options) as executor:
        for place, item in as_done(partial(one, ships=options.ships), seeds, executor):
            answers[place] = item
            spent = time.perf_counter() - start
            print(f"\r{len(answers)}/{options.replicates}  {spent:.0f} s", end="", file=sys.stderr)
    print(file=sys.stderr)
    low, high = np.moveaxis(np.array([answers[place] for place in sorted(answers)]), -1, 0)
    held = (low <= right) & (right <= high)
    print(f"{options.replicates} repeated reductions, {options.ships} ships each")
    print(f"{'speed':>8}" + "".join(f"{name:>34}" for name in METRICS))
    for row, speed in enumerate(SPEEDS):
        cells = "".join(
            f"{right[row, c]:10.3f} ± {0.5 * np.mean(high - low, axis=0)[row, c]:.3f}, held "
            f"{100 * held[:, row, c].mean():5.1f} %"
            for c in range(len(METRICS))
        )
        print(f"{speed:8.1f}{cells}")
    print(f"all metrics and speeds: {100 * held.mean():.2f} %")


if __name__ == "__main__":
    main()
