"""How often a name that stands without a flag means something that is in no catalogue.

    python -m scripts.studies.left_out_entries [--programme full] [--first 3300] [--workers 2]

Each entry of the catalogue is taken out in turn and hidden, at 1 and 0.3 of its usual size: what is
it called then? With m the share of these campaigns that end as a name without a flag, 1/N the share
of that name among N entries, and q the chance that the next cause is of a family that the catalogue
has not (Good and Turing: families of one entry over entries), a name means something outside with
the probability q m / (q m + (1 - q)/N).
"""

from __future__ import annotations

import argparse
from collections import Counter
from dataclasses import dataclass

from pmmkit.diagnosis.captive.candidate import Candidate
from pmmkit.diagnosis.captive.diagnose import captive_system, diagnose_captive
from pmmkit.diagnosis.captive.refit import eligible
from pmmkit.effects import CATALOGUE
from scripts.studies.hidden_effects import ABSORBED, tank
from scripts.studies.workers import add_workers, crew, in_order

SIZES = (1.0, 0.3)


@dataclass(frozen=True)
class Job:
    """One campaign with an effect that is not asked for."""

    effect: str
    size: float
    seed: int
    programme: str


def asked(programme: str) -> list[Candidate]:
    """What the runs of a programme are asked for."""
    made = tank()
    system = captive_system(made.hidden_campaign(programme, {}, seed=1), made.BASE)
    speeds = sorted({view.speed for view in system.views})
    held = system.base.excited(system.views)
    return [item for item in eligible(system.base, speeds) if held.issuperset(item.excites)]


def called(job: Job) -> tuple[str, str]:
    """What an effect is called that stands in no catalogue, and what that is: ``unflagged``,
    ``flagged``, or the verdict."""
    made = tank()
    rest = [item for item in asked(job.programme) if item.name != job.effect]
    campaign = made.hidden_campaign(job.programme, {job.effect: job.size}, seed=job.seed)
    found = diagnose_captive(campaign, made.BASE, candidates=rest)
    if not found.best:
        return "", found.verdict
    return " + ".join(found.best), "flagged" if found.flags else "unflagged"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--programme", default="full", choices=("full", "middle", "small"))
    parser.add_argument("--first", type=int, default=3300, help="first seed")
    add_workers(parser, 2)
    o = parser.parse_args()
    entries = asked(o.programme)
    mine = {item.name for item in entries if not item.each_run}
    hidden = [name for name in tank().INSIDE if name in mine and name not in ABSORBED]
    jobs = [
        Job(name, size, o.first + number, o.programme)
        for number, name in enumerate(hidden)
        for size in SIZES
    ]
    with crew(o) as executor:
        ends = in_order(called, jobs, executor)
    for job, (name, what) in zip(jobs, ends, strict=True):
        if what == "unflagged":
            print(f"{job.effect} ({job.size:g}): {name}")
    print(dict(Counter(what for _, what in ends)))
    families = Counter(CATALOGUE[item.name].family for item in entries)
    q = sum(count == 1 for count in families.values()) / len(entries)
    print(f"a family that the catalogue has not: {100 * q:.1f} %")
    for name, count in Counter(name for name, what in ends if what == "unflagged").most_common():
        outside = q * count / len(jobs)
        print(f"{name}: outside with {100 * outside / (outside + (1 - q) / len(entries)):.1f} %")


if __name__ == "__main__":
    main()
