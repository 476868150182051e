"""Whether the manoeuvre that is advised tells rivals apart, and whether it gains what is expected.

    python -m scripts.studies.next_manoeuvre [--cases sway_drag coupling …] [--sizes 0.3 0.5]
                                             [--seeds 4] [--first 1] [--ship kvlcc2-l7]
                                             [--samples 150]

Campaigns of three short records of the tank of free-running ships, which shares no code with the
package, are diagnosed. Where the answer is a group that holds the truth, the best and the last
turn or zigzag of the advice are made in the tank, and the records are asked again with each.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pmmkit.diagnosis import Advice, Diagnosis, next_runs
from pmmkit.diagnosis.free_running.diagnose import FreeSystem, answer, free_system
from pmmkit.diagnosis.planning.ranking import NextRun
from pmmkit.identification import FreeRecord
from pmmkit.models import load_model
from pmmkit.numerics import Array
from pmmkit.presentation import aligned
from tests.support.free_tank.campaigns import SHIPS, Setup, hidden_in, programme
from tests.support.free_tank.cases import CASES
from tests.support.free_tank.sailing import Order, Sailed, sail
from tests.support.free_tank.sensors import recorded

TANK = ("straight", "turning", "zigzag")
"""Manoeuvres that the tank makes."""
CALM = ("sway_drag", "cross_flow", "yaw_drag", "coupling", "straightening", "hull_rudder",
        "drift_wake", "stall", "asymmetry", "rudder_zero", "resistance", "propulsion")  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Trial:
    """A manoeuvre that was made: what was expected of it, what came, what is named then."""

    run: NextRun
    came: float
    after: Diagnosis


@dataclass(frozen=True, kw_only=True)
class Loop:
    """A campaign: its diagnosis, the advice, the manoeuvres that were made."""

    setup: Setup
    before: Diagnosis
    advice: Advice | None = None
    trials: tuple[Trial, ...] = ()


def ordered(setup: Setup, samples: int) -> list[Order]:
    """The programme of a campaign in a calm, its records of so many samples."""
    return [
        Order(
            rudder=np.radians(plan.rudder),
            switch=None if plan.switch is None else np.radians(plan.switch),
            speed=plan.speed,
            seconds=samples * setup.fleet.interval,
        )
        for plan in programme(setup)
    ]


def made(setup: Setup, orders: Sequence[Order], seed: int) -> list[FreeRecord]:
    """Records of manoeuvres of the tank, with its sensors' noise."""
    fleet, hidden = setup.fleet, hidden_in(setup)
    runs = sail(fleet.build(hidden), orders, fleet.step)
    rng = np.random.default_rng([setup.seed, seed])
    every = round(fleet.interval / fleet.step)
    return [
        _record(f"{seed}/{number}", run, recorded(run, hidden, fleet.noise, every, rng))
        for number, run in enumerate(runs)
    ]


def _record(name: str, run: Sailed, columns: dict[str, np.ndarray]) -> FreeRecord:
    seen: dict[str, Array] = {key: columns[key] for key in ("x", "y", "psi", "u", "v", "r")}
    return FreeRecord(
        name=name,
        t=columns["t"],
        delta=columns["delta"],
        turns=columns["n"],
        measured=seen,
        speed=run.order.speed,
    )


def looped(setup: Setup, samples: int, candidates: Sequence[str] | None = None) -> Loop:
    """Diagnose, make the advised manoeuvre and the one that is thought least of, diagnose again.

    The whole catalogue takes part unless candidates are given.
    """
    model = load_model(setup.known.start or setup.fleet.model)
    records = made(setup, ordered(setup, samples), 0)
    system = free_system(model, records, candidates=candidates)
    before = answer(system)
    expected = {name for names in setup.known.expect for name in names[:1]}
    truth = next((names for names, _ in before.group if expected & set(names)), None)
    if len(before.group) < 2 or truth is None:
        return Loop(setup=setup, before=before)
    advice = next_runs(model, records, before, most=1000, candidates=candidates)
    runs = [item for item in advice.runs if item.option.test in TANK]
    trials = tuple(_tried(setup, system, before, truth, run) for run in (*runs[:1], *runs[1:][-1:]))
    return Loop(setup=setup, before=before, advice=advice, trials=trials)


def _tried(
    setup: Setup, system: FreeSystem, before: Diagnosis, truth: tuple[str, ...], run: NextRun
) -> Trial:
    settings, interval = run.option.settings, setup.fleet.interval
    order = Order(
        rudder=settings.rudder,
        switch=settings.switch,
        speed=settings.speed,
        seconds=round(run.option.record / interval) * interval,
    )
    more = made(setup, [order] * run.repeats, 1)
    everyone = tuple(item.name for item in system.every)
    again = free_system(system.model, [*system.records, *more], candidates=everyone)

    def ahead(asked: FreeSystem) -> float:
        mine = asked.fit(truth).log_probability
        return mine - max(
            asked.fit(names).log_probability for names, _ in before.group if names != truth
        )

    return Trial(run=run, came=ahead(again) - ahead(system), after=answer(again))


def _rows(loop: Loop) -> list[list[str]]:
    group = ", ".join(" and ".join(names) for names, _ in loop.before.group)
    head = [loop.setup.case, f"{loop.setup.size:g}", f"{loop.setup.seed}", group or "-"]
    rows = [
        [*head, trial.run.option.id, f"{trial.run.gain:.1f}", f"{trial.came:.1f}",
         ", ".join(" and ".join(names) for names, _ in trial.after.group) or "-"]
        for trial in loop.trials
    ]  # fmt: skip
    return rows or [[*head, "-", "-", "-", "-"]]


def main() -> None:
    """Make the loops that are asked for, and print a row for each manoeuvre."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--cases", nargs="+", default=list(CALM), choices=sorted(CASES))
    parser.add_argument("--sizes", nargs="+", type=float, default=[0.2, 0.3, 0.5])
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--ship", default="kvlcc2-l7", choices=SHIPS)
    parser.add_argument("--samples", type=int, default=150)
    asked = parser.parse_args()
    loops = []
    for case in asked.cases:
        for size in asked.sizes:
            for seed in range(asked.first, asked.first + asked.seeds):
                setup = Setup(case=case, size=size, runs=3, seed=seed, ship=asked.ship)
                loops.append(looped(setup, asked.samples))
                print("  ".join(_rows(loops[-1])[0]), flush=True)
    head = ["case", "size", "seed", "group", "manoeuvre", "expected", "came", "group then"]
    print(aligned(head, [row for loop in loops for row in _rows(loop)]))
    asked_for = [loop for loop in loops if len(loop.trials) > 1]
    for word, place in (("best", 0), ("last", -1)):
        trials = [loop.trials[place] for loop in asked_for]
        pairs = np.array([[trial.run.gain, trial.came] for trial in trials]).reshape(-1, 2)
        alone = sum(len(trial.after.group) == 1 for trial in trials)
        expected = sum(trial.run.resolves for trial in trials)
        print(
            f"{word}: {len(trials)} manoeuvres, median gain in ln odds {np.median(pairs, axis=0)} "
            f"(expected, came), one set alone then {alone} ({expected:.1f} expected)"
        )


if __name__ == "__main__":
    main()
