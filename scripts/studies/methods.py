"""The same captive runs by every method: side by side, and over noisy replicates.

    python -m scripts.studies.methods [--replicates 100] [--data FOLDER]

Side by side: the S175 programme of `datasets/s175` at its three Froude numbers, and HMRI's tests
of the KVLCC2 where their files are (`--data`, or `PMMKIT_DATA`). Replicates: new noise, gauge and
setting errors of the S175 programme each time, through the whole reduction by every method; in how
many of them sparse regression finds each true term and takes a false one, and how often the 95 %
intervals of each method hold the truth of `datasets/s175/truth.toml`.
"""

from __future__ import annotations

import argparse
import math
import os
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pmmkit.campaigns import open_campaign
from pmmkit.files import datasets_folder
from pmmkit.reduction import Reduction, reduce_campaign
from scripts.datasets.s175_programme import campaign
from scripts.datasets.s175_truth import load_truth
from scripts.datasets.virtual_tank import SHIP, WATER

FIRST_SEED = 20_000


def side_by_side(title: str, found: Reduction, seconds: float) -> list[str]:
    """Every method beside the regression: worst difference, what is said of it, seconds."""
    lines = [f"{title}: {len(found.runs)} runs, {seconds:.1f} s in all"]
    for name, estimate in list(found.estimates.items())[1:]:
        far = found.farthest(name)
        known = int(np.isfinite(estimate.table.value).sum())
        told = "" if far is None else f"{far.derivative} {far.place}: {far.sigma:+.2f} std"
        lines.append(f"  {name:10} {known:3} values, {estimate.seconds:6.2f} s, worst {told}")
        lines += [f"      {item.sentence}" for item in found.differences if item.method == name]
        if estimate.tests is not None:
            lines += [
                f"      {channel}: NIS {test.nis:.3f} of {test.samples} innovations "
                f"({test.band[0]:.3f} to {test.band[1]:.3f}), whiteness p {test.p_white:.2f}"
                for channel, test in estimate.tests.channels.items()
            ]
    return lines


def replicate(seed: int) -> dict[str, dict[tuple[str, int], tuple[bool, float]]]:
    """By method, derivative and Froude number: whether the interval holds the truth, the error in
    standard deviations; of sparse regression the share of each term as well."""
    truth = load_truth()
    made = campaign(truth, seed, biased=True)
    reduced = reduce_campaign(made, method="all", check=False, executor=1)
    speeds = sorted({run.settings.speed for run in made})
    right = [truth.at(SHIP.froude(speed, WATER.g)) for speed in speeds]
    found: dict[str, dict[tuple[str, int], tuple[bool, float]]] = {}
    for method, estimate in reduced.estimates.items():
        table = estimate.table
        low, high = table.interval()
        own = found.setdefault(method, {})
        for row, values in enumerate(right):
            for column, name in enumerate(table.names):
                value = table.value[row, column]
                if name in values and math.isfinite(value):
                    inside = low[row, column] <= values[name] <= high[row, column]
                    error = (value - values[name]) / table.std[row, column]
                    own[name, row] = (bool(inside), float(error))
        shares = found.setdefault(f"{method} shares", {})
        for name, share in estimate.shares.items():
            for row, part in enumerate(share.tolist()):
                shares[name, row] = (bool(part >= 0.6), part)
    return found


def replicates(count: int) -> list[str]:
    """Coverage by method, and terms found and taken by sparse regression."""
    truth = set(load_truth().at(SHIP.froude(1.0, WATER.g)))
    start = time.perf_counter()
    found = []
    for number in range(count):
        found.append(replicate(FIRST_SEED + number))
        spent = time.perf_counter() - start
        print(f"\r{number + 1}/{count}  {spent:.0f} s", end="", file=sys.stderr, flush=True)
        if (number + 1) % 10 == 0 and number + 1 < count:
            print("\n".join(summary(found, truth)), file=sys.stderr, flush=True)
    print(file=sys.stderr)
    return summary(found, truth)


def summary(found: Sequence[dict], truth: set[str]) -> list[str]:
    """The replicates so far."""
    methods = [name for name in found[0] if not name.endswith("shares")]
    lines = [f"{len(found)} replicates; 95 % intervals that hold the truth, and std of the errors"]
    for method in methods:
        every = [item for one in found for item in one[method].values()]
        names = sorted({name for one in found for name, _ in one[method]})
        each = {
            name: 100
            * np.mean([x[0] for one in found for key, x in one[method].items() if key[0] == name])
            for name in names
        }
        low, high = min(each, key=each.__getitem__), max(each, key=each.__getitem__)
        lines.append(
            f"  {method:10} {100 * np.mean([hit for hit, _ in every]):5.1f} % of {len(every)}, "
            f"lowest {low} {each[low]:.1f}, highest {high} {each[high]:.1f}; "
            f"std {np.std([error for _, error in every]):.2f}"
        )
    taken: dict[str, dict[int, list[bool]]] = {}
    for one in found:
        for (name, row), (kept, _) in one["sindy shares"].items():
            taken.setdefault(name, {}).setdefault(row, []).append(kept)
    for title, names in (
        ("true terms found", [name for name in taken if name in truth]),
        ("false terms taken", [n for n in taken if n not in truth and n[1:] != "0"]),
        ("offsets taken (the programme has zero errors)", [n for n in taken if n[1:] == "0"]),
    ):
        lines.append(f"  {title}, per cent of replicates by Froude number:")
        for name in names:
            parts = [f"{100 * np.mean(hits):5.0f}" for _, hits in sorted(taken[name].items())]
            lines.append(f"    {name:8}{''.join(parts)}")
    false = [n for n in taken if n not in truth and n[1:] != "0"]
    wrong = np.mean(
        [any(one["sindy shares"][n, r][0] for n in false for r in range(3)) for one in found]
    )
    lines.append(f"  at least one false term at any speed: {100 * wrong:.0f} % of replicates")
    return lines


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--replicates", type=int, default=100)
    parser.add_argument("--data", type=Path, default=os.environ.get("PMMKIT_DATA"))
    options = parser.parse_args()
    cases = [("S175", datasets_folder() / "s175", None, "abkowitz3")]
    if options.data:
        cases.append(("KVLCC2, HMRI", datasets_folder() / "kvlcc2_hmri", options.data, "mmg"))
    for title, folder, data, structure in cases:
        opened = open_campaign(folder, data=data)
        start = time.perf_counter()
        found = reduce_campaign(opened, structure=structure, method="all", executor=1)
        print("\n".join(side_by_side(title, found, time.perf_counter() - start)), flush=True)
    if options.replicates:
        print("\n".join(replicates(options.replicates)))


if __name__ == "__main__":
    main()
