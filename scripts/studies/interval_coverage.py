"""How often the 95 % intervals hold the truth: replicates of the S175 programme.

    python -m scripts.studies.interval_coverage [--replicates 1000] [--workers 4] [--unbiased]

Each replicate draws new noise, new gauge and setting errors (as stated in the campaign) and goes
through the whole reduction, steady windows and cycle tests included. The truth is that of
datasets/s175/truth.toml.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from concurrent.futures import Executor
from functools import partial

import numpy as np

from pmmkit.reduction import reduce_campaign
from scripts.datasets.s175_programme import campaign
from scripts.datasets.s175_truth import load_truth
from scripts.datasets.virtual_tank import SHIP, WATER
from scripts.studies.workers import add_workers, as_done, crew

FIRST_SEED = 10_000


def one(seed: int, biased: bool) -> tuple[tuple[str, ...], np.ndarray, np.ndarray]:
    """Names, whether each interval holds the truth, and the errors in standard deviations."""
    truth = load_truth()
    made = campaign(truth, seed, biased=biased)
    if not biased:
        made = made.with_(uncertainty=())
    table = reduce_campaign(made, check=False, executor=1).table
    speeds = sorted({run.settings.speed for run in made})
    rows = [truth.at(SHIP.froude(speed, WATER.g)) for speed in speeds]
    right = np.array([[row[name] for name in table.names] for row in rows])
    low, high = table.interval()
    return table.names, (low <= right) & (right <= high), (table.value - right) / table.std


def study(
    replicates: int, executor: Executor | int | None, *, biased: bool
) -> dict[str, np.ndarray]:
    """Coverage by derivative and Froude number; names, hits (n, k, p) and errors (n, k, p)."""
    seeds = range(FIRST_SEED, FIRST_SEED + replicates)
    found = {}
    start = time.perf_counter()
    for place, item in as_done(partial(one, biased=biased), seeds, executor):
        found[place] = item
        if len(found) % 25 == 0 or len(found) == replicates:
            spent = time.perf_counter() - start
            print(f"\r{len(found)}/{replicates}  {spent:.0f} s", end="", file=sys.stderr)
    print(file=sys.stderr)
    names, hits, errors = zip(*(found[place] for place in sorted(found)), strict=True)
    return {"names": np.array(names[0]), "hits": np.array(hits), "errors": np.array(errors)}


def report(found: dict[str, np.ndarray]) -> str:
    """The table of coverages in per cent."""
    hits, errors = found["hits"], found["errors"]
    each = 100 * hits.mean(axis=0)
    lines = [f"{'':8}" + "".join(f"  Fn {row + 1}" for row in range(each.shape[0])) + "    std"]
    for column, name in enumerate(found["names"]):
        spread = errors[:, :, column].std()
        cells = "".join(f"{value:6.1f}" for value in each[:, column])
        lines.append(f"{name:8}{cells}{spread:7.2f}")
    lines.append(
        f"pooled {100 * hits.mean():.2f} %, each derivative and Fn {each.min():.1f} to "
        f"{each.max():.1f} %, {len(hits)} replicates, {hits[0].size} intervals each"
    )
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--replicates", type=int, default=1000)
    add_workers(parser, usual=os.cpu_count() or 1)
    parser.add_argument("--unbiased", action="store_true", help="noise only, no stated biases")
    options = parser.parse_args()
    with crew(options) as executor:
        found = study(options.replicates, executor, biased=not options.unbiased)
    print(report(found))


if __name__ == "__main__":
    main()
