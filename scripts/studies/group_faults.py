"""What is said of runs that were measured otherwise than the rest: fifteen faults of groups.

    python -m scripts.studies.group_faults [--programmes full small] [--first 9700]

Nothing is hidden in the campaigns of the virtual tank but one fault of a group of runs, at one seed
each: a second balance for yaw tests, moments about another point, a gauge that drifts through the
day, and so on. Programmes, noise and base are those of `hidden_effects`.

told : a group of runs is said to disagree, or the fault of the catalogue that it is is named.
reduced : `reduce` warns of a group, or of runs.
"""

from __future__ import annotations

import argparse
import warnings
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from pmmkit.campaigns import Campaign, Run
from pmmkit.diagnosis.captive.diagnose import diagnose_captive
from pmmkit.reduction import reduce_campaign
from scripts.studies.false_alarms import RUDDER
from scripts.studies.hidden_effects import tank

Chosen = Callable[[Run, float], bool]
"""Whether a run is of the group, by its place in the day (0 to 1)."""
Read = Callable[[Any, float], Any]
"""What its record shows."""


def gain(share: float, *channels: str) -> Read:
    """Channels that read a share more."""
    return lambda data, _: data.assign({name: (1.0 + share) * data[name] for name in channels})


def about(x: float) -> Read:
    """Moments about a point so many lengths off."""
    length = tank().SHIP.L
    return lambda data, _: data.assign(N=data["N"] + x * length * data["Y"])


def in_test(*tests: str) -> Chosen:
    """Runs of some kinds."""
    return lambda run, _: run.test in tests


def at_speed(speed: float) -> Chosen:
    """Runs of one speed [m/s]."""
    return lambda run, _: abs(run.settings.speed - speed) < 0.01


def from_on(part: float) -> Chosen:
    """Runs of the later day."""
    return lambda _, day: day >= part


def every(_run: Run, _day: float) -> bool:
    """All runs."""
    return True


YAW = ("pure_yaw", "yaw_drift", "sway_yaw")


def faults() -> dict[str, tuple[Chosen, Read]]:
    """The faults by their words."""
    return {
        "yaw runs: Y +3 %": (in_test(*YAW), gain(0.03, "Y")),
        "yaw runs: moments about 0.01 L": (in_test(*YAW), about(0.01)),
        "second half: moments about 0.01 L": (from_on(0.5), about(0.01)),
        "second half: Y +3 %": (from_on(0.5), gain(0.03, "Y")),
        "last third: N -4 %": (from_on(2.0 / 3.0), gain(-0.04, "N")),
        "gain of Y drifts by 3 %": (every, lambda d, day: gain(0.03 * day, "Y")(d, day)),
        "zero of Y drifts by 4 N": (every, lambda d, day: d.assign(Y=d["Y"] + 4.0 * day)),
        "2 m/s was 2 % faster": (at_speed(2.0), gain(0.04, "X", "Y", "N")),
        "static drift: X reads 3 % of Y": (
            in_test("static_drift"),
            lambda d, _: d.assign(X=d["X"] + 0.03 * d["Y"]),
        ),
        "port side: Y +4 %": (lambda run, _: run.settings.drift < 0.0, gain(0.04, "Y")),
        "pure sway: 1 N in Y": (in_test("pure_sway"), lambda d, _: d.assign(Y=d["Y"] + 1.0)),
        "steady runs: N +4 %": (lambda run, _: not run.dynamic, gain(0.04, "N")),
        "rudder runs: N +4 %": (lambda run, _: "rudder" in run.test, gain(0.04, "N")),
        "1 m/s: Y +5 %": (at_speed(1.0), gain(0.05, "Y")),
        "pure yaw from 1.5 m/s on: N +4 %": (
            lambda run, _: run.test == "pure_yaw" and run.settings.speed > 1.4,
            gain(0.04, "N"),
        ),
    }


def misread(campaign: Campaign, chosen: Chosen, read: Read) -> Campaign:
    """A campaign in which the records of a group show something else."""
    last = len(campaign.runs) - 1

    def of(run: Run, day: float) -> Run:
        if not chosen(run, day):
            return run
        shown = read(run.data, day)
        return replace(run, loader=lambda: shown)

    return campaign.with_(runs=tuple(of(run, k / last) for k, run in enumerate(campaign.runs)))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--programmes", nargs="+", default=["full", "small"])
    parser.add_argument("--first", type=int, default=9700, help="first seed")
    o = parser.parse_args()
    for programme in o.programmes:
        told = warned = 0
        for number, (words, fault) in enumerate(faults().items()):
            clean = tank().hidden_campaign(programme, {}, seed=o.first + number)
            campaign = misread(clean, *fault)
            found = diagnose_captive(campaign, tank().BASE)
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                reduced = reduce_campaign(campaign, structure=(*tank().BASE, *RUDDER))
            warned += any(x.check in ("odd_group", "odd_run") for x in reduced.findings)
            named = " and ".join(found.best) or found.verdict
            told += bool(found.disagreements) or found.best == ("fault_gauge_drift_of_the_day",)
            print(f"{programme:7}{words:36}{named}")
            for reason in found.flags[1:]:
                print(f"{'':11}{reason}")
            for reason in reduced.verdict.reasons:
                print(f"{'':11}reduce: {reason}")
        print(f"{programme:7}told: {told} of {len(faults())}, reduced: {warned}")


if __name__ == "__main__":
    main()
