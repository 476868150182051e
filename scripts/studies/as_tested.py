"""The user's sentence for each thing that tests may hide: compare, diagnose, add, compare again.

    python -m scripts.studies.as_tested [--kind captive records] [--only NAME …] [--seed 2]
                                        [--sizes 1 .5 .3] [--runs 3 6] [--nothing 10] [--workers 2]

Everything is typed, in an empty folder; the second model is the one that the line ``Next:`` of the
diagnosis makes. Tests come from the virtual tanks of the tests, which share no code with the
package; the model at the beginning is the tank's own ship, so that nothing but what is hidden lies
between them. Captive tests hide a fault, records an effect, a fault or a surrounding.

before, after : root mean square errors by `pmmkit compare`, of position and heading over whole
    records, or of Y and N.
level : the same with nothing hidden, which is what a true model leaves.
within : channels within their uncertainty, before and after.

Of records also, where the tank's hidden numbers are coefficients of the catalogue:

inside : coefficients whose interval of 95 % holds what is hidden, of those that are told.

With --nothing the true ship stands beside tests that hide nothing: the share within, by channel.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import math
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pmmkit.campaigns import save_campaign
from pmmkit.presentation import WIDE
from scripts.studies.hidden_effects import ABSORBED, tank
from scripts.studies.loops import COUPLING, SHIP, SURGE, added, diagnosis_in, told
from scripts.studies.workers import add_workers, as_done, crew, in_order
from tests.support.free_tank.campaigns import Setup, hidden_in, write
from tests.support.free_tank.cases import CASES
from tests.support.free_tank.hidden import Hidden

RECORDS_SHIP = "kvlcc2-l7"
SHOWN = {"captive": ("Y", "N"), "records": ("position", "heading")}
WHOLE = {COUPLING: 1.0, SURGE: 1.0}
"""What the tank's hull has to have to be Son and Nomoto's."""
TRUTHS: Mapping[str, Callable[[Hidden], Mapping[str, float]]] = {
    "flow_straightening": lambda h: {
        "gamma_positive": h.straightening, "gamma_negative": h.straightening, "lR": h.crossing,
    },
    "rudder_hull_interaction": lambda h: {
        "aH": h.hull_share, "xH": h.hull_point, "tR": h.steering_drag,
    },
    "wake_in_drift": lambda h: {"C2_positive": h.drift_wake, "C2_negative": h.drift_wake},
    "propeller_load": lambda h: {"wp": h.wake, "t": h.deduction},
    "yaw_sway_coupling": lambda h: {
        "Yvvr": h.vvr[0], "Yvrr": h.vrr[0], "Nvvr": h.vvr[1], "Nvrr": h.vrr[1],
    },
    "surge_yaw_coupling": lambda h: {"Xvr": h.vr},
    "asymmetry": lambda h: {"Y0": h.side, "N0": h.turn},
    "fault_rudder_zero": lambda h: {"angle": math.degrees(h.rudder_zero)},
    "fault_clock_lag": lambda h: {"clock_lag": h.late_positions},
    "fault_antenna": lambda h: {"antenna_x": h.antenna, "antenna_y": 0.0},
    "fault_heading_offset": lambda h: {"heading_offset": math.degrees(h.heading_offset)},
    "fault_log": lambda h: {"log_gain": h.log_gain},
}  # fmt: skip
"""What a finding's coefficients are where they are numbers of the tank."""


@dataclass(frozen=True, kw_only=True)
class Job:
    """Tests that hide something, or nothing."""

    kind: str
    hidden: str
    seed: int
    size: float = 1.0
    runs: int = 3

    @property
    def ship(self) -> str:
        return SHIP if self.kind == "captive" else RECORDS_SHIP

    def setup(self, hidden: str) -> Setup:
        """Records of the virtual tank."""
        return Setup(case=hidden, size=self.size, runs=self.runs, seed=self.seed, ship=self.ship)

    def truths(self, effect: str) -> Mapping[str, float]:
        """What the coefficients of an effect should be, where the tank has them."""
        known = TRUTHS.get(effect)
        return known(hidden_in(self.setup(self.hidden))) if known else {}

    def write(self, hidden: str) -> str:
        """The tests, in this folder; how they are typed."""
        if self.kind == "records":
            write(self.setup(hidden), Path()).rename(f"with-{hidden}")
            return f"with-{hidden}"
        effects = WHOLE if hidden == "none" else {**WHOLE, hidden: 1.0}
        made = tank().hidden_campaign("full", effects, seed=self.seed)
        # The tank's rudder is a polynomial, that of the model is not.
        towed = tuple(run for run in made.runs if not run.settings.rudder)
        save_campaign(made.with_(runs=towed), f"with-{hidden}.h5")
        return f"with-{hidden}.h5"


@dataclass(frozen=True, kw_only=True)
class Answer:
    """What the comparisons say before and after; each size with its deviation and its truth."""

    job: Job
    named: str
    sizes: Sequence[tuple[str, float, float, float]]
    before: Sequence[Mapping[str, Any]]
    after: Sequence[Mapping[str, Any]]
    level: Sequence[Mapping[str, Any]]


def answered(job: Job) -> Answer:
    """Compare, diagnose, add, compare again."""
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        tests, quiet = job.write(job.hidden), job.write("none")
        before, level = rows(job.ship, tests, "before"), rows(job.ship, quiet, "level")
        said = told(f"diagnose {job.ship} {tests} --no-figures --out found")
        found = diagnosis_in("found")
        named = " + ".join(found["proposed"]) or found["verdict"]
        try:
            model = added(said) or job.ship
        except RuntimeError as refused:
            model, named = job.ship, f"{named}, but Next: {refused}"
        sizes = told_beside(job, found) if job.kind == "records" else []
        after = rows(model, tests, "after")
    return Answer(job=job, named=named, sizes=sizes, before=before, after=after, level=level)


def told_beside(job: Job, found: Mapping[str, Any]) -> list[tuple[str, float, float, float]]:
    """Sizes of what is proposed, where it is what is hidden: name, value, deviation, truth."""
    return [
        (f"{item['effect']}.{name}", value, item["std"][name], truths[name])
        for item in found["findings"]
        if item["effect"] in found["proposed"]
        and (truths := job.truths(item["effect"]))
        and any(truths.values())
        for name, value in item["coefficients"].items()
        if name in truths
    ]


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
    parser.add_argument("--sizes", type=float, nargs="+", default=[1.0], help="of records")
    parser.add_argument("--runs", type=int, nargs="+", default=[3], choices=(3, 6))
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
            several = kind == "records"
            jobs = [
                Job(kind=kind, hidden=x, seed=o.seed, size=size, runs=runs)
                for runs in (o.runs if several else [3])
                for size in (o.sizes if several else [1.0])
                for x in hidden[kind]
                if not o.only or x in o.only
            ]
            _tell(kind, as_done(answered, jobs, executor))


def _tell_nothing(kind: str, found: Sequence[Sequence[Mapping[str, Any]]]) -> None:
    every = [row for own in found for row in own]
    print(f"{kind}: {len(found)} campaigns with nothing hidden, {within(every)} within")
    for channel in dict.fromkeys(row["channel"] for row in every):
        print(f"  {channel:10} {within([row for row in every if row['channel'] == channel])}")


def _tell(kind: str, answers: Iterable[tuple[int, Answer]]) -> None:
    names = SHOWN[kind]
    print(f"{kind}: {', '.join(names)} before > after (level)")
    sizes: list[tuple[str, float, float, float]] = []
    for _, x in answers:
        cells = [
            "{:8.3g} > {:8.3g} ({:.3g})".format(
                *(error(own, name) for own in (x.before, x.after, x.level))
            )
            for name in names
        ]
        share = f"{within(x.before)} > {within(x.after)} ({within(x.level)})"
        what = f"{x.job.hidden} {x.job.size:g}, {x.job.runs} runs"
        print(f"  {what:28} {'  '.join(cells)}  {share:26} {x.named}", flush=True)
        for name, value, deviation, truth in x.sizes:
            print(f"    {name} {value:.4g} ± {WIDE * deviation:.2g} for {truth:.4g}")
        sizes += x.sizes
    inside = sum(abs(value - truth) < WIDE * std for _, value, std, truth in sizes)
    print(f"  {inside} of {len(sizes)} sizes inside 95 %, {sum(not x[1] for x in sizes)} are zero")


if __name__ == "__main__":
    main()
