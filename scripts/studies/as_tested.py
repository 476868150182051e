"""The user's sentence for each thing that tests may hide: compare, diagnose, add, compare again.

    python -m scripts.studies.as_tested [--kind captive records] [--only NAME …] [--seed 2]
                                        [--nothing 10] [--workers 2]

Everything is typed, in an empty folder; the second model is the one that the line ``Next:`` of the
diagnosis makes. Tests come from the virtual tanks of the tests, which share no code with the
package; the model at the beginning is the tank's own ship, so that nothing but what is hidden lies
between them. Captive tests hide a fault, records an effect, a fault or a surrounding.

before, after : root mean square errors by `pmmkit compare`, of position and heading over whole
    records, or of Y and N.
level : the same with nothing hidden, which is what a true model leaves.
within : channels within their uncertainty, before and after.

With --nothing the true ship stands beside tests that hide nothing: the share within, by channel.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pmmkit.campaigns.store import save_campaign
from scripts.studies.hidden_effects import ABSORBED, tank
from scripts.studies.loops import COUPLING, SHIP, SURGE, added, diagnosis_in, told
from scripts.studies.workers import add_workers, crew, in_order
from tests.support.free_tank.campaigns import Setup, write
from tests.support.free_tank.cases import CASES

RECORDS_SHIP = "kvlcc2-l7"
SHOWN = {"captive": ("Y", "N"), "records": ("position", "heading")}
WHOLE = {COUPLING: 1.0, SURGE: 1.0}
"""What the tank's hull has to have to be Son and Nomoto's."""


@dataclass(frozen=True, kw_only=True)
class Job:
    """Tests that hide something, or nothing."""

    kind: str
    hidden: str
    seed: int

    @property
    def ship(self) -> str:
        return SHIP if self.kind == "captive" else RECORDS_SHIP

    def write(self, hidden: str) -> str:
        """The tests, in this folder; how they are typed."""
        if self.kind == "records":
            write(Setup(case=hidden, runs=3, seed=self.seed, ship=self.ship), Path()).rename(
                f"with-{hidden}"
            )
            return f"with-{hidden}"
        effects = WHOLE if hidden == "none" else {**WHOLE, hidden: 1.0}
        made = tank().hidden_campaign("full", effects, seed=self.seed)
        # The tank's rudder is a polynomial, that of the model is not.
        towed = tuple(run for run in made.runs if not run.settings.rudder)
        save_campaign(made.with_(runs=towed), f"with-{hidden}.h5")
        return f"with-{hidden}.h5"


@dataclass(frozen=True, kw_only=True)
class Answer:
    """What the comparisons say before and after."""

    job: Job
    named: str
    before: Sequence[Mapping[str, Any]]
    after: Sequence[Mapping[str, Any]]
    level: Sequence[Mapping[str, Any]]


def answered(job: Job) -> Answer:
    """Compare, diagnose, add, compare again."""
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        tests, quiet = job.write(job.hidden), job.write("none")
        before, level = rows(job.ship, tests, "before"), rows(job.ship, quiet, "level")
        model = added(told(f"diagnose {job.ship} {tests} --no-figures --out found")) or job.ship
        found = diagnosis_in("found")
        named = " + ".join(found["proposed"]) or found["verdict"]
        after = rows(model, tests, "after")
    return Answer(job=job, named=named, before=before, after=after, level=level)


def rows(model: str, tests: str, out: str) -> list[dict[str, Any]]:
    """What a comparison writes of each run and channel."""
    told(f"compare {model} {tests} --no-figures --out {out}")
    content = json.loads(Path(out, "comparison.json").read_text(encoding="utf-8"))
    found: list[dict[str, Any]] = content["runs"]
    return found


def nothing(job: Job) -> list[dict[str, Any]]:
    """The true ship beside tests that hide nothing."""
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        return rows(job.ship, job.write("none"), "level")


def error(of: Sequence[Mapping[str, Any]], channel: str) -> float:
    """Root mean square over the runs."""
    own = [row["error"] for row in of if row["channel"] == channel]
    return float(np.sqrt(np.mean(np.square(own))))


def within(of: Sequence[Mapping[str, Any]]) -> str:
    """How many channels are within their uncertainty."""
    return f"{sum(row['within'] for row in of)}/{len(of)}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kind", nargs="*", choices=list(SHOWN), default=list(SHOWN))
    parser.add_argument("--only", nargs="*", help="what is hidden")
    parser.add_argument("--seed", type=int, default=2)
    parser.add_argument("--nothing", type=int, default=0, help="campaigns that hide nothing")
    add_workers(parser, usual=2)
    o = parser.parse_args()
    hidden = {
        "captive": [
            x
            for x in tank().INSIDE
            if (x.startswith("fault_") or x == "current") and x not in ABSORBED
        ],
        "records": [x for x, case in CASES.items() if x != "none" and case.start is None],
    }
    with crew(o) as executor:
        for kind in o.kind:
            if o.nothing:
                jobs = [Job(kind=kind, hidden="none", seed=o.seed + k) for k in range(o.nothing)]
                _tell_nothing(kind, in_order(nothing, jobs, executor))
                continue
            jobs = [
                Job(kind=kind, hidden=x, seed=o.seed)
                for x in hidden[kind]
                if not o.only or x in o.only
            ]
            _tell(kind, in_order(answered, jobs, executor))


def _tell_nothing(kind: str, found: Sequence[Sequence[Mapping[str, Any]]]) -> None:
    every = [row for own in found for row in own]
    print(f"{kind}: {len(found)} campaigns with nothing hidden, {within(every)} within")
    for channel in dict.fromkeys(row["channel"] for row in every):
        print(f"  {channel:10} {within([row for row in every if row['channel'] == channel])}")


def _tell(kind: str, answers: Sequence[Answer]) -> None:
    names = SHOWN[kind]
    print(f"{kind}: {', '.join(names)} before > after (level)")
    for x in answers:
        cells = [
            "{:8.3g} > {:8.3g} ({:.3g})".format(
                *(error(own, name) for own in (x.before, x.after, x.level))
            )
            for name in names
        ]
        share = f"{within(x.before)} > {within(x.after)} ({within(x.level)})"
        print(f"  {x.job.hidden:22} {'  '.join(cells)}  {share:26} {x.named}", flush=True)


if __name__ == "__main__":
    main()
