"""What becomes of campaigns that somebody spoiled, and of clean ones.

    python -m scripts.studies.spoiled [--programme small full] [--only Y] [--clean 200] \
        [--workers 2] [--out FILE]

Each way of `tests/support/spoiled.py` is put into a campaign of the virtual tank, in one run of
each kind of test and in all runs. What the user meets is one of

refused : the checks find a contradiction, nothing is fitted.
named : a warning names the right cause.
other : a warning, or a refusal, that names another cause.
noted : nothing is said of this campaign, but a note of its table says that the property cannot
    be checked by these runs, and what would check it.
harmless : nothing is said, and no derivative has moved by more than 2 of its standard
    uncertainties.
wrong : nothing is said, and one has.

A refusal that names the right cause counts as refused, one that does not as other. Clean
campaigns count the share in which anything is said above a remark.
"""

from __future__ import annotations

import argparse
import csv
import importlib
import re
import sys
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from pmmkit.base import DataError
from pmmkit.intake import CheckFinding, examine
from pmmkit.models import DerivativeTable
from pmmkit.reduction import reduce_campaign
from scripts.studies.workers import add_workers, crew, in_order

CLASSES = ("refused", "named", "other", "noted", "harmless", "wrong")
MOVED = 2.0


def ways() -> Any:
    """The ways to spoil, which lie with the tests."""
    sys.path.insert(0, str(Path(__file__).parents[2]))
    return importlib.import_module("tests.support.spoiled")


@dataclass(frozen=True)
class Answer:
    """What became of one campaign."""

    name: str
    scope: str
    programme: str
    told: bool
    verdict: str
    worst: str
    moved: float
    said: tuple[str, ...]


def answered(case: Any) -> Answer:
    """Spoil a campaign, look at it, and see how far the table moves."""
    loud = said_of(case.spoiled())
    worst, moved = ("", np.nan) if loud else shift(case)
    right = any(re.search(case.way.cause, text) for _, text in loud)
    if any(severity == "error" for severity, _ in loud):
        verdict = "refused" if right else "other"
    elif loud:
        verdict = "named" if right else "other"
    else:
        verdict = "wrong" if moved > MOVED else "harmless"
        if verdict == "wrong" and any(re.search(case.way.cause, note) for note in notes(case)):
            verdict = "noted"
    return Answer(
        case.name,
        case.scope,
        case.programme,
        case.way.told,
        verdict,
        worst,
        moved,
        tuple(f"{severity}: {text}" for severity, text in loud),
    )


def notes(case: Any) -> list[str]:
    """What the notes of the table say that these runs do not check."""
    told = table(case.spoiled()).notes
    return [note for note in told if note.startswith("Not ")] if case.scope == "all" else []


def said_of(campaign: Any) -> list[tuple[str, str]]:
    """Errors and warnings of a campaign, in words."""
    try:
        found: Sequence[CheckFinding] = examine(campaign)
    except DataError as error:
        return [("error", str(error))]
    return [(item.severity, f"{item} {item.remedy}") for item in found if item.severity != "info"]


def shift(case: Any) -> tuple[str, float]:
    """The derivative that moves most against the clean campaign, and by how many of its std."""
    before = clean_table(case.programme, case.seed, case.way.base)
    try:
        after = table(case.spoiled())
    except DataError:
        return "no table", np.inf
    except (ValueError, ArithmeticError) as error:
        return f"crash: {error}", np.inf
    z = np.abs(after.value - before.value) / before.std
    if not np.isfinite(z).any():
        return "no table", np.inf
    place = np.unravel_index(int(np.nanargmax(z)), z.shape)
    return before.names[place[1]], float(z[place])


def table(campaign: Any) -> DerivativeTable:
    """The derivatives of a campaign, whatever the checks say."""
    return reduce_campaign(campaign, structure="abkowitz3", check=False).table


@cache
def clean_table(programme: str, seed: int, base: str) -> DerivativeTable:
    """The derivatives before anything was spoiled."""
    return table(ways().clean(programme, seed, base))


def alarm(job: tuple[str, int, str]) -> list[str]:
    """What is said of a clean campaign."""
    return [text for _, text in said_of(ways().clean(*job))]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--programme", nargs="*", default=["small", "full"])
    parser.add_argument("--only", default="", help="ways whose name holds this")
    parser.add_argument("--clean", type=int, default=200, help="clean campaigns of each kind")
    parser.add_argument("--base", nargs="*", default=["plain"], help="kinds of clean campaigns")
    parser.add_argument("--first", type=int, default=0, help="first seed")
    add_workers(parser, usual=2)
    parser.add_argument("--out", type=Path, help="file for all answers")
    o = parser.parse_args()
    every: list[Answer] = []
    begin = time.perf_counter()
    with crew(o) as executor:
        for programme in o.programme:
            asked = [case for case in ways().cases(programme, o.first) if o.only in case.way.name]
            names = [(case.way.name, case.scope, case.test, programme, o.first) for case in asked]
            every += in_order(answered_by_name, names, executor)
            counted(programme, [item for item in every if item.programme == programme])
            for base in o.base if o.clean else ():
                jobs = [(programme, o.first + k, base) for k in range(o.clean)]
                alarms = [said for said in in_order(alarm, jobs, executor) if said]
                print(f"  clean, {base}: an alarm in {len(alarms)} of {o.clean}")
                for text, count in Counter(x[:150] for said in alarms for x in said).most_common(8):
                    print(f"    {count} {text}")
    print(f"{time.perf_counter() - begin:.0f} s")
    if o.out:
        written(every, o.out)


def answered_by_name(key: tuple[str, str, str, str, int]) -> Answer:
    """`answered`, where a process is told only names."""
    name, scope, test, programme, seed = key
    case = next(
        item
        for item in ways().cases(programme, seed)
        if (item.way.name, item.scope, item.test) == (name, scope, test)
    )
    return answered(case)


def counted(programme: str, answers: Sequence[Answer]) -> None:
    """The table of a programme, and what is not as it should be."""
    print(f"\n{programme} programme, {len(answers)} spoiled campaigns")
    print("  " + " " * 10 + "".join(f"{name:>10}" for name in CLASSES))
    for scope in ("one", "all"):
        own = Counter(item.verdict for item in answers if item.scope == scope)
        print(f"  {scope:10}" + "".join(f"{own[name]:10}" for name in CLASSES))
    for item in answers:
        if item.verdict in ("wrong", "other"):
            far = f"{item.worst} by {item.moved:.0f} std, nothing said"
            said = item.said[0][:300] if item.said else far
            mark = "" if item.told else " (cannot be told)"
            print(f"  {item.verdict}: {item.name}{mark}: {said}")


def written(answers: Sequence[Answer], path: Path) -> None:
    """All answers as CSV."""
    with path.open("w", newline="", encoding="utf-8") as file:
        out = csv.writer(file)
        out.writerow(["programme", "scope", "case", "told", "verdict", "derivative", "z", "said"])
        for x in answers:
            row = [x.programme, x.scope, x.name, x.told, x.verdict, x.worst, f"{x.moved:.3g}"]
            out.writerow([*row, " | ".join(x.said)])


if __name__ == "__main__":
    main()
