"""How often a sound campaign carries a doubt: nothing is hidden, and nothing is wrong.

    python -m scripts.studies.false_alarms [--count 200] [--first 2000] [--programme full]
                                           [--noise standard] [--workers 2]

Campaigns of the virtual tank are checked, reduced by the structure that they are made of, diagnosed
about it, and compared with the model of the table. A doubt is what speaks against the table, a
name, something unexplained, or a group of runs that is said to disagree.
"""

from __future__ import annotations

import argparse
import warnings
from collections import Counter
from dataclasses import dataclass

from pmmkit.diagnosis.captive.diagnose import diagnose_captive
from pmmkit.intake import examine
from pmmkit.models import to_model
from pmmkit.reduction import reduce_campaign
from pmmkit.validation import compare
from scripts.studies.hidden_effects import tank, upper
from scripts.studies.workers import add_workers, crew, in_order

RUDDER = ("Xdd", "Yd", "Nd")
"""Derivatives of the tank's rudder, which a diagnosis adds by itself."""


@dataclass(frozen=True)
class Job:
    """One sound campaign."""

    programme: str
    noise: str
    seed: int


def doubts(job: Job) -> tuple[str, ...]:
    """What is said against a sound campaign, by the part that says it."""
    made = tank()
    campaign = made.hidden_campaign(job.programme, {}, seed=job.seed, noise=job.noise)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        table = reduce_campaign(campaign, structure=(*made.BASE, *RUDDER)).table
        found = diagnose_captive(campaign, made.BASE)
        groups = compare(to_model(table, force=True, missing="zero"), campaign).disagreements
    said = [f"reduce: {text}" for text in table.verdict.reasons]
    said += [f"check: {x.message}" for x in examine(campaign) if x.cause == "odd_group"]
    said += [f"compare: {item}" for item in groups]
    if found.verdict != "noise":
        said.append(f"diagnose: {found.verdict} {' '.join(found.best)}")
    return (*said, *(f"flag: {text}" for text in found.flags[1:]))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=200, help="campaigns")
    parser.add_argument("--first", type=int, default=2000, help="first seed")
    parser.add_argument("--programme", default="full", choices=("full", "middle", "small"))
    parser.add_argument("--noise", default="standard", choices=("standard", "hard", "double"))
    add_workers(parser, 2)
    o = parser.parse_args()
    jobs = [Job(o.programme, o.noise, seed) for seed in range(o.first, o.first + o.count)]
    kinds: Counter[str] = Counter()
    doubted = named = 0
    with crew(o) as executor:
        found = in_order(doubts, jobs, executor)
    for job, said in zip(jobs, found, strict=True):
        if said:
            print(job.seed, *said, sep="\n    ")
        doubted += bool(said)
        named += any(text.startswith("diagnose: missing_effect") for text in said)
        kinds.update({text.split(":")[0] for text in said})
    print(
        f"{o.programme}, {o.noise}: {doubted} of {o.count} sound campaigns carry a doubt (at most "
        f"{upper(doubted, o.count):.1f} %), {named} a name; {dict(kinds)}"
    )


if __name__ == "__main__":
    main()
