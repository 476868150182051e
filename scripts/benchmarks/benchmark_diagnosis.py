"""The time of one diagnosis, and how it grows with runs and effects, on one core.

    python -m scripts.benchmarks.benchmark_diagnosis [--runs 48 100 300 1000] [--effects 31 100] \
        [--rounds 3]

Campaigns are those of the virtual tank that lies with the tests: the full programme, and for more
runs the same at other speeds. More effects than the catalogue holds are polynomials that nothing
asks for. Histories are in memory; reading files is not counted. Times are those of the processor.
Each line has a process of its own, whose memory is the most that it held, libraries and histories
with it.
"""

from __future__ import annotations

import argparse
import itertools
import resource
import statistics
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context

from pmmkit.campaigns import Campaign
from pmmkit.diagnosis.captive.candidate import Candidate
from pmmkit.diagnosis.captive.diagnose import captive_system, diagnose_captive
from pmmkit.diagnosis.captive.refit import captive_candidates
from pmmkit.diagnosis.captive.verdict import answer
from pmmkit.reduction import View
from scripts.studies.hidden_effects import programmes, tank
from tests.support.term_candidates import polynomial


def campaign(runs: int) -> Campaign:
    """The full programme with two effects hidden, again at other speeds for more runs."""
    plans = programmes().plans("full")
    copies = [
        replace(
            plan,
            id=f"{plan.id}_{number}",
            speed=plan.speed * (1 + 0.01 * number),
            omega=plan.omega * (1 + 0.01 * number),
            repeat_of=None,
        )
        for number in range(-(-runs // len(plans)))
        for plan in plans
    ]
    hidden = {"yaw_sway_coupling": 1.0, "fault_misalignment": 1.0}
    made: Campaign = tank().hidden_campaign(copies[:runs], hidden, seed=1)
    return made


def eligible(count: int, speeds: Sequence[float]) -> list[Candidate]:
    """The catalogue, cut or filled up with polynomials."""
    known = captive_candidates(tuple(speeds))
    factors = ("v", "r", "|v|", "|r|")
    products = (
        "".join(sorted(product, key=factors.index))
        for order in (4, 5, 6)
        for product in itertools.combinations_with_replacement(factors, order)
    )
    more = (
        polynomial(f"own_{x}", "own", "A product.", {f"Y{x}": 0.02, f"N{x}": 0.01})
        for x in products
    )
    return [*known, *itertools.islice(more, max(count - len(known), 0))][:count]


def line(runs: int, effects: int, rounds: int) -> str:
    """Seconds of the processor for views, system and answer, and the most memory of the process."""
    diagnose_captive(campaign(13), tank().BASE)
    made = campaign(runs)
    speeds = sorted({round(run.settings.speed, 6) for run in made.runs})[:3]
    candidates = eligible(effects, speeds)
    times = []
    for _ in range(rounds if runs <= 100 else 1):
        start = time.process_time()
        View.of(made)
        viewed = time.process_time()
        system = captive_system(made, tank().BASE, candidates=candidates)
        built = time.process_time()
        answer(system, floor=0.005)
        times.append(
            (viewed - start, built - viewed - (viewed - start), time.process_time() - built)
        )
    views, system_time, answered = (statistics.median(x) for x in zip(*times, strict=True))
    used = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return (
        f"{runs:4}  {effects:7}  {views:9.2f}  {system_time:10.2f}  {answered:10.2f}  "
        f"{views + system_time + answered:7.2f}  {used:11.0f}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, nargs="*", default=[48, 100, 300, 1000])
    parser.add_argument("--effects", type=int, nargs="*", default=[31, 100])
    parser.add_argument("--rounds", type=int, default=3)
    o = parser.parse_args()
    print("runs  effects  views [s]  system [s]  answer [s]  all [s]  memory [MB]")
    for runs, effects in itertools.product(o.runs, o.effects):
        with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as own:
            print(own.submit(line, runs, effects, o.rounds).result(), flush=True)


if __name__ == "__main__":
    main()
