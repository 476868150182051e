"""How often what is hidden in free-running records is found: campaigns diagnosed one by one.

    python -m scripts.studies.free_hidden [--cases none roll …] [--sizes 1 0.3] [--runs 6 3]
                                          [--seeds 5] [--first 0] [--ship s175] [--follow]
                                          [--workers 2]
    python -m scripts.studies.free_hidden --folder DIR      # campaigns that lie there
    python -m scripts.studies.free_hidden … --write DIR     # only make them

The campaigns are those of tests/support/free_tank, which shares no code with the package, or those
of a folder with a ``truth.json`` of the same form. The model of each is the library ship that its
truth names; sets are judged by the names that the truth accepts.

alone : the truth is the only set of the group.
group : the truth is in a group of at most three sets.
wide : the truth is in a larger group.
beside : a set of the group holds the truth, with something beside it.
wrong : no set of the group holds the truth; where nothing is hidden, something is named.
silent : nothing is named; where nothing is hidden, that is right.
failed : the diagnosis ended in an error.

Right, in the table, is alone, group, and silent where nothing is hidden; held, of the coefficients
of effects that were rightly named and have the form of the catalogue, those within their 95 %
intervals. Seconds are those of the processor, of a diagnosis with its children. ``--follow`` types
what a diagnosis advises, and counts what ends well.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import itertools
import json
import os
import tempfile
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import pmmkit as pk
from pmmkit.cli import main as pmmkit
from pmmkit.diagnosis import Diagnosis
from pmmkit.effects import CATALOGUE
from pmmkit.intake import examine
from pmmkit.presentation import WIDE, aligned
from scripts.studies.workers import add_workers, as_done, crew
from tests.support.free_tank.campaigns import SHIPS, Setup, write, write_all
from tests.support.free_tank.cases import CASES

OUTCOMES = ("alone", "group", "wide", "beside", "wrong", "silent", "failed")
SMALL = 3
"""Sets in a group that still says something."""


@dataclass(frozen=True, kw_only=True)
class Job:
    """A campaign to diagnose: one to be made, or one that lies in a folder; whether the advice is
    followed."""

    truth: Mapping[str, Any]
    setup: Setup | None = None
    folder: Path | None = None
    follow: bool = False

    @property
    def title(self) -> str:
        if self.setup is None:
            return f"{self.truth['case']} ({self.folder.name if self.folder else '-'})"
        own = self.setup
        return f"{own.case} {own.size:g}, {own.runs} runs, seed {own.seed}"

    @property
    def row(self) -> tuple[str, str, str]:
        """Of the table: case, size, runs."""
        case, size, runs = (str(self.truth.get(name, "-")) for name in ("case", "size", "runs"))
        return case, size, runs


@dataclass(frozen=True, kw_only=True)
class Answer:
    """What the diagnosis said of one campaign.

    `sizes`: of each coefficient whose truth is known, by effect: how far it is from the truth over
    half of its 95 % interval, and that half over the truth. `advised`: how the advised command
    ended, empty where there was none or it was not followed.
    """

    job: Job
    verdict: str
    sets: tuple[tuple[str, ...], ...] = ()
    odds: tuple[float, ...] = ()
    log_evidence: float = float("nan")
    flags: tuple[str, ...] = ()
    checks: tuple[str, ...] = ()
    sizes: tuple[tuple[str, float, float], ...] = ()
    advised: str = ""
    seconds: float = float("nan")
    error: str = ""

    @property
    def outcome(self) -> str:
        """One of `OUTCOMES`."""
        expect = self.job.truth["expect"]
        if self.error:
            return "failed"
        if not self.sets:
            return "silent"
        if not expect:
            return "wrong"
        if any(says(names, expect) for names in self.sets):
            size = len(self.sets)
            return "alone" if size == 1 else "group" if size <= SMALL else "wide"
        return "beside" if any(holds(names, expect) for names in self.sets) else "wrong"

    @property
    def right(self) -> bool:
        """Whether the verdict is one of those accepted, and the name with it."""
        good = ("alone", "group") if self.job.truth["expect"] else ("silent",)
        return self.verdict in self.job.truth["verdict"] and self.outcome in good

    @property
    def held(self) -> tuple[int, int]:
        """Coefficients within their intervals, of those that an effect rightly named has."""
        known = self.sizes if self.outcome in ("alone", "group") else ()
        return sum(abs(away) <= 1.0 for _, away, _ in known), len(known)

    def __str__(self) -> str:
        group = "; ".join(
            f"{' + '.join(names)} {odds:.2g}"
            for names, odds in zip(self.sets, self.odds, strict=True)
        )
        checks = f", checks: {' '.join(self.checks)}" if self.checks else ""
        flags = f", flags: {' | '.join(self.flags)}" if self.flags else ""
        missed = [f"{name} {away:+.1f}" for name, away, _ in self.sizes if abs(away) > 1.0]
        outside = f", beyond the interval: {' '.join(missed)}" if missed else ""
        advised = f", advised: {self.advised}" if self.advised else ""
        return (
            f"{self.job.title}: {self.outcome}, {self.verdict}, {group or '-'}, "
            f"ln evidence {self.log_evidence:.1f}, {self.seconds:.0f} s"
            f"{checks}{flags}{outside}{advised}{self.error and f', {self.error}'}"
        )


def says(names: Sequence[str], expect: Sequence[Sequence[str]]) -> bool:
    """Whether a set is the truth: one of the accepted names for each effect, and no other.

    Examples
    --------
    >>> says(["wind"], [["wind"]]), says(["wind", "current"], [["wind"]])
    (True, False)
    """
    return len(names) == len(expect) and any(
        all(name in accepted for name, accepted in zip(order, expect, strict=True))
        for order in itertools.permutations(names)
    )


def holds(names: Sequence[str], expect: Sequence[Sequence[str]]) -> bool:
    """Whether a part of a set is the truth.

    Examples
    --------
    >>> holds(["wind", "current"], [["wind"]])
    True
    """
    return any(says(part, expect) for part in itertools.combinations(names, len(expect)))


def answered(job: Job) -> Answer:
    """Make a campaign, or open it, and diagnose it."""
    if job.setup is not None:
        with tempfile.TemporaryDirectory() as place:
            return asked(job, write(job.setup, Path(place)))
    assert job.folder is not None
    return asked(job, job.folder)


def asked(job: Job, folder: Path) -> Answer:
    """The diagnosis of the campaign in a folder."""
    campaign = pk.open_campaign(folder)
    checks = tuple(item.check for item in examine(campaign) if item.severity != "info")
    began = processor()
    try:
        found = pk.diagnose(pk.load_model(job.truth["model"]), campaign)
    except Exception as error:  # one that fails is counted: hours of others are not lost for it
        said = f"{type(error).__name__}: {error}"
        return Answer(job=job, verdict="-", checks=checks, seconds=processor() - began, error=said)
    best = next((item for item in found.entries if item.names == found.best), None)
    return Answer(
        job=job,
        verdict=found.verdict,
        sets=tuple(names for names, _ in found.group),
        odds=tuple(odds for _, odds in found.group),
        log_evidence=best.log_evidence if best else 0.0,
        flags=tuple(found.flags),
        checks=checks,
        sizes=tuple(sizes_of(found, job.truth.get("coefficients", {}))),
        seconds=processor() - began,
        advised=followed(job, found, folder) if job.follow and found.proposed else "",
    )


def sizes_of(
    found: Diagnosis, truth: Mapping[str, Mapping[str, float]]
) -> Iterator[tuple[str, float, float]]:
    """How well coefficients are told, as `Answer.sizes` has it."""
    for item in found.findings:
        for name, true in truth.get(item.effect, {}).items():
            if name in item.coefficients:
                half = WIDE * item.std[name]
                yield name, (item.coefficients[name] - true) / half, half / (abs(true) or np.nan)


def followed(job: Job, found: Diagnosis, folder: Path) -> str:
    """How the command ends that a diagnosis advises."""
    said = io.StringIO()
    with tempfile.TemporaryDirectory() as place:
        model = Path(place) / "model2.toml"
        effects = [item.effect for item in found.proposed]
        line = ["add", job.truth["model"], *effects, "--fit", str(folder), "-o", str(model)]
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            status = pmmkit(line)
        if status == 0 and model.is_file():
            return "well"
    return f"status {status}: {said.getvalue().strip().splitlines()[-1]}"


def processor() -> float:
    """Seconds of the processor for this process and its children that have ended."""
    return sum(os.times()[:4])


def jobs_of(o: argparse.Namespace) -> list[Job]:
    """All campaigns that were asked for."""
    if o.folder is not None:
        truths = json.loads((o.folder / "truth.json").read_text(encoding="utf-8"))
        return [
            Job(truth=truth, folder=o.folder / name, follow=o.follow)
            for name, truth in truths.items()
            if o.cases is None or truth["case"] in o.cases
        ]
    return [Job(truth=setup.truth, setup=setup, follow=o.follow) for setup in setups_of(o)]


def setups_of(o: argparse.Namespace) -> Iterator[Setup]:
    """Campaigns of the tank: where nothing is hidden there is one size."""
    cases = [name for name, case in CASES.items() if o.ship in case.make]
    for runs, name in itertools.product(o.runs, o.cases or cases):
        sizes = o.sizes if CASES[name].expect else o.sizes[:1]
        for size, seed in itertools.product(sizes, range(o.first, o.first + o.seeds)):
            yield Setup(case=name, size=size, runs=runs, seed=seed, ship=o.ship)


def table(answers: Sequence[Answer]) -> str:
    """Outcomes by case, size and number of runs."""
    rows = []
    for key in dict.fromkeys(item.job.row for item in answers):
        own = [item for item in answers if item.job.row == key]
        counts = Counter(item.outcome for item in own)
        rows.append([*key, *_counted(own, counts)])
    every = Counter(item.outcome for item in answers)
    times = ["s (median)", "s (most)"]
    head = ["case", "size", "runs", "campaigns", "right", *OUTCOMES, "flagged", "held", *times]
    return aligned(head, [*rows, ["all", "", "", *_counted(answers, every)]])


def _counted(answers: Sequence[Answer], counts: Mapping[str, int]) -> list[str]:
    seconds = [item.seconds for item in answers]
    right = sum(item.right for item in answers)
    flagged = sum(bool(item.flags) for item in answers)
    held, known = np.sum([item.held for item in answers], axis=0)
    return [
        str(len(answers)),
        str(right),
        *(str(counts[name]) if counts[name] else "" for name in OUTCOMES),
        str(flagged) if flagged else "",
        f"{held} of {known}" if known else "",
        f"{np.median(seconds):.0f}",
        f"{max(seconds):.0f}",
    ]


def told_sizes(answers: Sequence[Answer]) -> Iterator[str]:
    """How intervals of all coefficients hold, and how the advised commands ended."""
    held, known = np.sum([item.held for item in answers], axis=0)
    if known:
        halves = [half for item in answers for _, _, half in item.sizes if np.isfinite(half)]
        yield (
            f"Coefficients in their 95 % intervals: {held} of {known} ({held / known:.1%}); half "
            f"of the interval over the truth: {np.median(halves):.1%} (median), "
            f"{min(halves):.2%} the least."
        )
    ends = Counter(item.advised for item in answers if item.advised)
    for end, count in ends.most_common():
        yield f"Advised commands that ended {end}: {count} of {sum(ends.values())}."


def unknown(jobs: Sequence[Job]) -> list[str]:
    """Cases of whose accepted names the catalogue knows none."""
    known = set(CATALOGUE)
    return [
        f"{case}: {' or '.join(names)}"
        for case, names in dict.fromkeys(
            (job.truth["case"], tuple(names)) for job in jobs for names in job.truth["expect"]
        )
        if not known & set(names)
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--folder", type=Path, help="campaigns with a truth.json, in place of ours")
    parser.add_argument("--write", type=Path, help="write the campaigns here, and end")
    parser.add_argument("--ship", choices=SHIPS, default=SHIPS[0])
    parser.add_argument("--cases", nargs="+", help=f"of {', '.join(CASES)}, or of the folder")
    parser.add_argument("--sizes", type=float, nargs="+", default=[1.0, 0.3])
    parser.add_argument("--runs", type=int, nargs="+", default=[6, 3], choices=(3, 6))
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--follow", action="store_true", help="type the command that is advised")
    add_workers(parser, usual=2)
    o = parser.parse_args()
    jobs = jobs_of(o)
    if o.write is not None:
        write_all([job.setup for job in jobs if job.setup], o.write)
        return
    for line in unknown(jobs):
        print(f"not in the catalogue, {line}")
    answers = []
    with crew(o) as executor:
        for place, answer in as_done(answered, jobs, executor):
            answers.append((place, answer))
            print(answer, flush=True)
    found = [answer for _, answer in sorted(answers, key=lambda item: item[0])]
    print()
    print(table(found))
    for line in told_sizes(found):
        print(line)


if __name__ == "__main__":
    main()
