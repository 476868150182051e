"""How often intervals hold the truth when runs scatter between each other as in any laboratory.

    python -m scripts.studies.run_scatter [--programme small] [--replicates 200] [--gain 0.004]
                                     [--offset 0.0025] [--law normal] [--jobs 2] [--first 0]

The water is that of tests/support/hidden_effects, which shares no formula with the package. Each
run draws a gain and an offset of every gauge: normal, of Student's t with 4 degrees of freedom
(scaled to the same standard deviation), none, or normal with one bad run whose side force is 3 %
too large. Records have white noise of 1 % of the channel's scale. Nothing of it is told to the
reduction. Offsets are shares of the channel's scale.

pooled : share of 95 % intervals that hold the truth, over derivatives and replicates.
lowest, highest : of one derivative.
distance : mean of the squared Mahalanobis distance over the number of derivatives, one where the
    covariance is right, and its 95th percentile.
found : one bad run named; false: another run named.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial

import numpy as np

from pmmkit.campaigns.run import Campaign, Run
from pmmkit.reduction import reduce_campaign
from tests.support.hidden_effects import BASE, hidden_campaign
from tests.support.hidden_effects.hull import TRUTH
from tests.support.hidden_effects.sizes import CHANNELS, scale

RECORD = 0.01
"""Noise of a record, white, over the channel's scale."""
BAD = 0.03
"""Gain error of the bad run's side force."""
Law = Callable[[np.random.Generator], float]
LAWS: dict[str, Law] = {
    "none": lambda _: 0.0,
    "normal": lambda rng: float(rng.standard_normal()),
    "t": lambda rng: float(rng.standard_t(4) / np.sqrt(2.0)),
    "bad": lambda rng: float(rng.standard_normal()),
}


@dataclass(frozen=True)
class Answer:
    """One replicate: by derivative whether the truth is held, distance, runs named, the bad one."""

    names: tuple[str, ...]
    held: np.ndarray
    distance: float
    named: tuple[str, ...]
    bad: str


def measured(run: Run, seed: int, gain: float, offset: float, law: str, bad: bool) -> Run:
    """A run of noise-free water as a laboratory would record it."""
    rng = np.random.default_rng([seed, *run.id.encode()])
    changed = {}
    for name in CHANNELS:
        force = run.data[name]
        factor = 1.0 + gain * LAWS[law](rng)
        if bad and name == "Y":
            factor += BAD
        zero = offset * scale(name) * LAWS[law](rng)
        noise = RECORD * scale(name) * rng.standard_normal(force.size)
        changed[name] = ("t", force.to_numpy() * factor + zero + noise)
    data = run.data.assign(changed)
    return run.with_(loader=lambda: data)


def campaign(
    programme: str, seed: int, gain: float, offset: float, law: str
) -> tuple[Campaign, str]:
    """A campaign, and the run that is bad."""
    clean = hidden_campaign(programme, noise="none", seed=seed)
    ids = [run.id for run in clean]
    bad = ids[seed % len(ids)] if law == "bad" else ""
    return clean.with_(
        runs=tuple(measured(run, seed, gain, offset, law, run.id == bad) for run in clean)
    ), bad


def one(seed: int, programme: str, gain: float, offset: float, law: str) -> Answer:
    """Reduce one replicate."""
    made, bad = campaign(programme, seed, gain, offset, law)
    found = reduce_campaign(
        made, structure=[*BASE, "Xdd", "Yd", "Nd"], fn="pooled", check=False, jobs=1
    )
    table = found.table
    names = tuple(name for name in table.names if name in TRUTH)
    columns = [table.index(name) for name in names]
    truth = np.array([TRUTH[name] for name in names])
    low, high = table.interval()
    gap = table.value[0, columns] - truth
    unit = table.std[0, columns]
    correlation = table.covariance[0, columns][:, 0, columns] / np.outer(unit, unit)
    return Answer(
        names=names,
        held=(low[0, columns] <= truth) & (truth <= high[0, columns]),
        distance=float(gap / unit @ np.linalg.solve(correlation, gap / unit)) / len(names),
        named=tuple(dict.fromkeys(item.run for item in found.influences.odd)),
        bad=bad,
    )


def report(found: list[Answer]) -> str:
    """The figures of a study."""
    held = np.array([item.held for item in found])
    distance = np.array([item.distance for item in found])
    each = 100 * held.mean(axis=0)
    names = found[0].names
    lines = [
        f"pooled {100 * held.mean():.1f} %, lowest {each.min():.1f} % ({names[each.argmin()]}), "
        f"highest {each.max():.1f} % ({names[each.argmax()]}), {len(found)} replicates of "
        f"{len(names)} derivatives",
        f"distance {distance.mean():.2f}, 95th percentile {np.quantile(distance, 0.95):.2f}",
    ]
    if found[0].bad:
        right = np.mean([item.bad in item.named for item in found])
        lines.append(f"bad run found {100 * right:.0f} %")
    wrong = np.mean([any(name != item.bad for name in item.named) for item in found])
    lines.append(f"another run named {100 * wrong:.1f} %")
    lines.append("  ".join(f"{n} {x:.0f}" for n, x in zip(names, each, strict=True)))
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--programme", default="small")
    parser.add_argument("--replicates", type=int, default=200)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--gain", type=float, default=0.004)
    parser.add_argument("--offset", type=float, default=0.0025)
    parser.add_argument("--law", choices=sorted(LAWS), default="normal")
    parser.add_argument("--jobs", type=int, default=2)
    o = parser.parse_args()
    start = time.perf_counter()
    work = partial(one, programme=o.programme, gain=o.gain, offset=o.offset, law=o.law)
    seeds = range(o.first, o.first + o.replicates)
    with ProcessPoolExecutor(o.jobs) as pool:
        found = list(pool.map(work, seeds, chunksize=4))
    print(f"{o.programme}, {o.law}, gain {100 * o.gain:g} %, offset {100 * o.offset:g} %")
    print(report(found), f"\n{time.perf_counter() - start:.0f} s")


if __name__ == "__main__":
    main()
