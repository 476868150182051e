"""How often intervals hold the truth when runs scatter between each other as in any laboratory.

    python -m scripts.studies.run_scatter [--tank first second] [--programme small speeds]
                                     [--law none normal t bad] [--share 1.0] [--workers 2]

The water is that of tests/support/hidden_effects (a container ship, forces of the water) and of
tests/support/second_tank (a tanker, raw balance), which share no formula with the package or with
each other. Each run draws a gain and an offset of every gauge: none, normal, of Student's t with 4
degrees of freedom (scaled to the same standard deviation), or normal with one bad run whose side
force is 3 % too large. Nothing of it is told to the reduction. `CASES` has the sizes and the
numbers of replicates; --share takes a part of them.

pooled : share of 95 % intervals that hold the truth, over derivatives and replicates.
lowest, highest : of one derivative (at one Froude number).
distance : mean of the squared Mahalanobis distance over the number of derivatives, and the share
    of replicates in which it is above the 95 % quantile of F; its degrees of freedom are the
    median of the table's.
turn : share of intervals of the tactical diameter (500 ships) that hold that of the true hull.
found : the bad run named; false: another run named. After it is excluded: pooled, without it.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import product

import numpy as np

import pmmkit as pk
from pmmkit.campaigns import Campaign, Run
from pmmkit.models import DerivativeTable
from pmmkit.reduction import Reduction, reduce_campaign
from scripts.studies.workers import add_workers, crew, in_order
from tests.support import second_tank, spoiled
from tests.support.hidden_effects import hidden_campaign
from tests.support.hidden_effects.sizes import CHANNELS, scale

RECORD = 0.01
"""Noise of a record of the first tank, white, over the channel's scale."""
BAD = 0.03
"""Gain error of the bad run's side force."""
SHIPS = 500
Law = Callable[[np.random.Generator], float]
LAWS: dict[str, Law] = {
    "none": lambda _: 0.0,
    "normal": lambda rng: float(rng.standard_normal()),
    "t": lambda rng: float(rng.standard_t(4) / np.sqrt(2.0)),
    "bad": lambda rng: float(rng.standard_normal()),
}


@dataclass(frozen=True, kw_only=True)
class Case:
    """A law of the errors, sizes of gain and offset, replicates by programme."""

    law: str
    gain: float
    offset: float
    replicates: dict[str, int]


LARGE, SOME, FEW = ({"small": s, "speeds": m} for s, m in ((1000, 300), (300, 100), (100, 30)))
CASES = (
    Case(law="none", gain=0.0, offset=0.0, replicates=LARGE),
    Case(law="normal", gain=0.004, offset=0.0025, replicates=LARGE),
    Case(law="normal", gain=0.0015, offset=0.001, replicates=FEW),
    Case(law="normal", gain=0.01, offset=0.006, replicates=FEW),
    Case(law="t", gain=0.004, offset=0.0025, replicates=SOME),
    Case(law="bad", gain=0.004, offset=0.0025, replicates=SOME),
)


@dataclass(frozen=True, kw_only=True)
class Answer:
    """One replicate: names of its intervals, whether each holds the truth, and the rest."""

    names: tuple[str, ...]
    held: np.ndarray
    distance: float
    beyond: bool
    turn: bool | None
    named: tuple[str, ...]
    bad: str
    without: np.ndarray | None


def first(programme: str, seed: int, case: Case) -> tuple[Campaign, str]:
    """A campaign of the first tank, and the run that is bad."""
    which = "full" if programme == "speeds" else programme
    clean = hidden_campaign(which, spoiled.COUPLED, noise="none", seed=seed)
    clean = spoiled.each(clean, clean.runs, spoiled.keep_without_roll)
    ids = [run.id for run in clean]
    bad = ids[seed % len(ids)] if case.law == "bad" else ""
    return clean.with_(
        runs=tuple(measured(run, seed, case, bad=run.id == bad) for run in clean)
    ), bad


def measured(run: Run, seed: int, case: Case, *, bad: bool) -> Run:
    """A run of noise-free water as a laboratory would record it."""
    rng = np.random.default_rng([seed, *run.id.encode()])
    changed = {}
    for name in CHANNELS:
        force = run.data[name]
        factor = 1.0 + case.gain * LAWS[case.law](rng) + (BAD if bad and name == "Y" else 0.0)
        zero = case.offset * scale(name) * LAWS[case.law](rng)
        noise = RECORD * scale(name) * rng.standard_normal(force.size)
        changed[name] = ("t", force.to_numpy() * factor + zero + noise)
    data = run.data.assign(changed)
    return run.with_(loader=lambda: data)


def second(programme: str, seed: int, case: Case) -> tuple[Campaign, str]:
    """A campaign of the second tank, and the run that is bad."""
    ids = [plan.id for plan in second_tank.plans(programme)]
    bad = seed % len(ids) if case.law == "bad" else None
    made = second_tank.campaign(
        programme, seed, case.gain, case.offset, LAWS[case.law], bad=bad, bad_gain=BAD
    )
    return made, "" if bad is None else ids[bad]


@dataclass(frozen=True, kw_only=True)
class Tank:
    """A tank: campaigns, derivatives to be fitted, true ones at a Froude number, parts to turn."""

    make: Callable[[str, int, Case], tuple[Campaign, str]]
    structure: tuple[str, ...]
    fn: str
    truth: Callable[[float], dict[str, float]]
    parts: str
    speed: float

    def turn(self) -> float:
        """Tactical diameter of the true hull over its length."""
        campaign, _ = self.make("small", 0, CASES[0])
        ship, water = campaign.ship, campaign.water
        values = self.truth(ship.froude(self.speed, water.g))
        table = pk.from_values(
            {name: x for name, x in values.items() if "d" not in name.replace("dot", "")},
            ship=ship,
            water=water,
        )
        model = pk.to_model(table, self.parts)
        found = pk.simulate(model, speed=self.speed, rudder_deg=35).metrics
        return float(found["tactical_diameter_L"])


TANKS = {
    "first": Tank(
        make=first,
        structure=tuple(spoiled.truth()),
        fn="pooled",
        truth=lambda _: spoiled.truth(),
        parts="s175-3dof",
        speed=1.5,
    ),
    "second": Tank(
        make=second,
        structure=tuple(second_tank.CENTRAL),
        fn="each",
        truth=second_tank.truth,
        parts="kvlcc2-l7",
        speed=1.177,
    ),
}


def one(seed: int, tank: str, programme: str, case: Case, turn: float) -> Answer:
    """Reduce one replicate."""
    own = TANKS[tank]
    campaign, bad = own.make(programme, seed, case)
    found = _reduced(own, campaign)
    names, held, distance, beyond = judged(own, found.table)
    named = tuple(dict.fromkeys(item.run for item in found.influences.odd))
    without = None
    if bad and bad in named:
        kept = tuple(run for run in campaign if run.id != bad)
        without = judged(own, _reduced(own, campaign.with_(runs=kept)).table)[1]
    return Answer(
        names=names,
        held=held,
        distance=distance,
        beyond=beyond,
        turn=turned(own, found.table, turn, seed),
        named=named,
        bad=bad,
        without=without,
    )


def _reduced(tank: Tank, campaign: Campaign) -> Reduction:
    return reduce_campaign(campaign, structure=tank.structure, fn=tank.fn, check=False, executor=1)


def judged(tank: Tank, table: DerivativeTable) -> tuple[tuple[str, ...], np.ndarray, float, bool]:
    """Names of the intervals, whether they hold the truth, distance, and whether F forbids it."""
    from scipy.special import fdtrc

    low, high = table.interval()
    names, held, squares, many = [], [], [], []
    for row, Fn in enumerate(table.Fn):
        truth = tank.truth(float(Fn))
        columns = [table.index(name) for name in table.names if name in truth]
        own = [table.names[column] for column in columns]
        right = np.array([truth[name] for name in own])
        names += own if table.pooled else [f"{name} at Fn {Fn:.3f}" for name in own]
        held.append((low[row, columns] <= right) & (right <= high[row, columns]))
        unit = table.std[row, columns]
        gap = (table.value[row, columns] - right) / unit
        covariance = table.covariance[row][np.ix_(columns, [row], columns)][:, 0]
        squares.append(float(gap @ np.linalg.solve(covariance / np.outer(unit, unit), gap)))
        many.append(float(np.median(table.dof[row, columns])))
    count = len(names)
    distance = sum(squares) / count
    beyond = float(fdtrc(count, min(float(np.median(many)), 1e6), distance)) < 0.05
    return tuple(names), np.concatenate(held), distance, beyond


def turned(tank: Tank, table: DerivativeTable, truth: float, seed: int) -> bool | None:
    """Whether the interval of the tactical diameter holds that of the true hull."""
    try:
        model = pk.to_model(table, tank.parts)
    except pk.PmmkitError:
        return None
    many = pk.monte_carlo(
        model, "turning", rudder_deg=35, speed=tank.speed, n=SHIPS, seed=seed, executor=1
    )
    low, high = many.interval("tactical_diameter_L")
    return bool(low <= truth <= high)


def report(found: list[Answer]) -> Iterator[str]:
    """The figures of a case."""
    held = np.array([item.held for item in found])
    distance = np.array([item.distance for item in found])
    turns = [item.turn for item in found if item.turn is not None]
    each = 100 * held.mean(axis=0)
    names = found[0].names
    yield (
        f"  pooled {100 * held.mean():.1f} %, lowest {each.min():.1f} ({names[each.argmin()]}), "
        f"highest {each.max():.1f} ({names[each.argmax()]}); {len(found)} replicates of "
        f"{len(names)} intervals"
    )
    yield (
        f"  distance {distance.mean():.2f}, beyond the 95 % quantile of F in "
        f"{100 * np.mean([item.beyond for item in found]):.1f} %; tactical diameter held in "
        f"{100 * np.mean(turns):.1f} % of {len(turns)}"
    )
    wrong = np.mean([any(name != item.bad for name in item.named) for item in found])
    if found[0].bad:
        right = np.mean([item.bad in item.named for item in found])
        yield f"  bad run found {100 * right:.0f} %, another named {100 * wrong:.1f} %"
        without = [item.without for item in found if item.without is not None]
        if without:
            yield f"  after it is excluded: pooled {100 * np.concatenate(without).mean():.1f} %"
    else:
        yield f"  a run named though none is bad {100 * wrong:.1f} %"
    low = sorted(zip(each, names, strict=True))[:5]
    yield "  lowest: " + ", ".join(f"{name} {share:.1f}" for share, name in low)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--tank", nargs="*", default=list(TANKS), choices=list(TANKS))
    parser.add_argument("--programme", nargs="*", default=list(LARGE), choices=list(LARGE))
    parser.add_argument("--law", nargs="*", default=list(LAWS), choices=list(LAWS))
    parser.add_argument("--share", type=float, default=1.0, help="part of the replicates")
    parser.add_argument("--first", type=int, default=0, help="first seed")
    add_workers(parser, usual=2)
    o = parser.parse_args()
    began = time.perf_counter()
    with crew(o) as executor:
        for tank, programme in product(o.tank, o.programme):
            turn = TANKS[tank].turn()
            for case in (case for case in CASES if case.law in o.law):
                count = math.ceil(o.share * case.replicates[programme])
                work = partial(one, tank=tank, programme=programme, case=case, turn=turn)
                found = in_order(work, range(o.first, o.first + count), executor)
                print(
                    f"{tank} tank, {programme}, {case.law}, gain {100 * case.gain:g} %, offset "
                    f"{100 * case.offset:g} %:\n" + "\n".join(report(found)),
                    flush=True,
                )
                print(f"{time.perf_counter() - began:.0f} s", file=sys.stderr)


if __name__ == "__main__":
    main()
