"""What `diagnose --outside` is worth: right names it flags, wrong ones it catches, sets it gives.

    python -m scripts.studies.hidden_entries [--programme full] [--first 3300] [--workers 2]

The table is made of one campaign of the virtual tank in which nothing is hidden (docs/diagnose.md)
and asked about others, with noise of their own: each effect of the tank at 1 and 0.3 of its usual
size, named by the whole catalogue and by one, with a table of its own, that has never had it.

right : named alone or first of a group, by the whole catalogue, without a flag.
wrong : named something else without a flag, since the catalogue has never had it.
set : what the answer may be, by the table of the whole catalogue.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

from pmmkit.diagnosis.captive.diagnose import captive_system, diagnose_captive
from pmmkit.diagnosis.captive.hidden_entries import OutsideCheck, digest_of
from pmmkit.diagnosis.findings import Diagnosis
from pmmkit.diagnosis.outside import SIZES, HiddenEntries, read_hidden_entries
from scripts.studies.hidden_effects import ABSORBED, tank, upper
from scripts.studies.workers import add_workers, crew, in_order


@dataclass(frozen=True)
class Job:
    """One campaign with an effect that is asked for, or is not."""

    effect: str
    size: float
    seed: int
    programme: str
    asked: bool


def table_of(programme: str, seed: int) -> HiddenEntries:
    """What entries are called that are hidden in a campaign without an effect."""
    made = tank()
    campaign = made.hidden_campaign(programme, {}, seed=seed)
    system = captive_system(campaign, made.BASE)
    found = diagnose_captive(campaign, made.BASE)
    with tempfile.TemporaryDirectory() as folder:
        check = OutsideCheck.beside(Path(folder), made=True)
        check.judged(found, system, (), made.BASE)
        return read_hidden_entries(check.file)[digest_of(system)]


def without(table: HiddenEntries, effect: str) -> HiddenEntries:
    """The table of a catalogue that has never had an effect."""
    return replace(
        table,
        families={name: x for name, x in table.families.items() if name != effect},
        ends=tuple(item for item in table.ends if item.effect != effect),
    )


@cache
def asked(programme: str) -> tuple[list[str], dict]:
    """What the runs of a programme are asked for."""
    made = tank()
    system = captive_system(made.hidden_campaign(programme, {}, seed=1), made.BASE)
    every = {x.candidate.name: x.candidate for x in system.blocks if not x.candidate.partial}
    mine = [x for x in made.INSIDE if x in every and not every[x].each_run and x not in ABSORBED]
    return mine, every


def answered(job: Job) -> Diagnosis:
    """What an effect is called."""
    made = tank()
    campaign = made.hidden_campaign(job.programme, {job.effect: job.size}, seed=job.seed)
    _, every = asked(job.programme)
    rest = [x for name, x in every.items() if job.asked or name != job.effect]
    return diagnose_captive(campaign, made.BASE, candidates=rest)


def share(title: str, hits: Sequence[bool]) -> None:
    count, total = sum(hits), len(hits)
    most = f" (at most {upper(count, total):.1f} %)" if total else ""
    print(f"{title}: {count} of {total}{most}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--programme", default="full", choices=("full", "middle", "small"))
    parser.add_argument("--first", type=int, default=3300, help="first seed")
    add_workers(parser, 2)
    o = parser.parse_args()
    begin = time.process_time()
    table = table_of(o.programme, o.first)
    print(f"{len(table.ends)} hidden entries in {time.process_time() - begin:.0f} s of processor")
    print(dict(Counter(item.end for item in table.ends)))
    for item in table.ends:
        if item.end == "named":
            print(f"  {item}: {' + '.join(item.names)}")
    print(f"a family that the catalogue has not: {100 * table.unknown_family:.1f} %")
    jobs = [
        Job(name, size, o.first + 1 + number, o.programme, inside)
        for inside in (True, False)
        for number, name in enumerate(asked(o.programme)[0])
        for size in SIZES
    ]
    with crew(o) as executor:
        plain = in_order(answered, jobs, executor)
    named = [(job, found) for job, found in zip(jobs, plain, strict=True) if found.best]
    flagged: dict[str, list[bool]] = {"right": [], "wrong": []}
    for job, before in named:
        known = table if job.asked else without(table, job.effect)
        outside = (after := before.beside(known)).outside
        if outside is None or outside.probability is None:
            continue
        if not job.asked or before.best == (job.effect,):
            flagged["right" if job.asked else "wrong"].append(bool(after.flags))
        print(
            f"  {job.effect} ({'' if job.asked else 'taken out, '}{job.size:g}): "
            f"{' + '.join(before.best)} {100 * outside.probability:.1f} %"
        )
    for word, hits in flagged.items():
        share(f"{word} names that are flagged", hits)
    for title, some in (
        ("asked for", [x for x in named if x[0].asked]),
        ("taken out", [x for x in named if not x[0].asked]),
        ("taken out, flagged", [x for x in named if not x[0].asked and x[1].flags]),
    ):
        sets = [(job, found.beside(table).outside) for job, found in some]
        held = [job.effect in x.may_be for job, x in sets if x is not None]
        names = sum(len(x.may_be) for _, x in sets if x is not None) / max(len(held), 1)
        share(f"sets of {names:.1f} names that hold the truth, {title}", held)


if __name__ == "__main__":
    main()
