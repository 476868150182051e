"""How often a hidden effect is found: campaigns of the virtual tank, diagnosed one after another.

    python -m scripts.studies.hidden_effects --table 1 [--only full/hard] [--seeds 10] [--none 500]
                                     [--pairs 100] [--first 0] [--workers 4] [--out DIR]
    python -m scripts.studies.hidden_effects --table 2 [--seeds 10] [--outside 10] …

Programmes, noise and sizes are those of tests/hidden_effects. The base has linear and cubic terms
and none of what is hidden. Table 1 hides effects in the catalogue's own form under four conditions,
table 2 puts them in at a physical source, and hides effects that no catalogue holds. An effect
counts where its signal at its size is large enough to be seen (`Visible.without_a_run` times the
square of the size above 12).

detected : something is named.
exact : the truth is named, alone.
best : the best set is the truth, whatever rivals stand in the group.
proven : the truth, alone or in a group from whose other sets these runs cannot tell it: the
    noise-free force of the truth, fitted with the rival, leaves expected odds below 20 to 1.
in group : one of the sets of the group is the truth.
wrong : no set of the group holds a true effect.
family : the first finding has the family of a true effect.
allowed : the truth as best set, or flagged beside helpers of its own family.
unflagged : the truth is not in the group, and nothing says that it is not the whole story.

Upper limits are of 95 % confidence (Clopper and Pearson). With --out every answer goes to
answers.csv and the confusion matrix to confusion.png.
"""

from __future__ import annotations

import argparse
import csv
import importlib
import math
import sys
import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from pmmkit.diagnosis.captive.diagnose import captive_system, diagnose_captive
from pmmkit.diagnosis.evidence import SHOWS
from pmmkit.plotting import INK, Figure, Shades
from pmmkit.reduction import View
from scripts.studies.workers import add_workers, crew, in_order

ABSORBED = ("fault_gauge_gain", "fault_moment_point", "fault_inertia")
TABLES = {
    1: (
        ("full", "standard", "catalogue"),
        ("full", "hard", "catalogue"),
        ("full", "double", "catalogue"),
        ("small", "standard", "catalogue"),
    ),
    2: (("full", "standard", "foreign"),),
}
BLUES = (
    "#f7fbff",
    "#deebf7",
    "#c6dbef",
    "#9ecae1",
    "#6baed6",
    "#4292c6",
    "#2171b5",
    "#08519c",
    "#08306b",
)
"""From none to many: Blues of ColorBrewer 2.0 (colorbrewer2.org)."""
SEPARABLE = math.log(20.0)
"""Expected ln odds from which two answers can be told from each other."""


def tank() -> Any:
    """The virtual tank, which lies with the tests."""
    sys.path.insert(0, str(Path(__file__).parents[2] / "tests" / "support"))
    return importlib.import_module("hidden_effects")


def programmes() -> Any:
    """Its programmes."""
    tank()
    return importlib.import_module("hidden_effects.programmes")


@dataclass(frozen=True)
class Job:
    """One campaign: what is hidden in it, and how it is made."""

    effects: tuple[tuple[str, float], ...]
    seed: int
    programme: str
    noise: str
    truth: str

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(sorted(name for name, _ in self.effects))

    def campaign(self, noise: str | None = None) -> Any:
        return tank().hidden_campaign(
            self.programme,
            dict(self.effects),
            seed=self.seed,
            noise=noise or self.noise,
            truth=self.truth,
        )


@dataclass(frozen=True)
class Answer:
    """What the diagnosis said, and whether the effect could be seen."""

    job: Job
    verdict: str
    group: tuple[tuple[tuple[str, ...], float], ...]
    flags: tuple[str, ...]
    chance: float
    visible: bool
    families: tuple[str, ...]
    kin: tuple[str, ...]
    twins: bool
    seconds: float
    formula: tuple[str, ...] = ()

    @property
    def sets(self) -> list[tuple[str, ...]]:
        return [tuple(sorted(names)) for names, _ in self.group]

    @property
    def best(self) -> tuple[str, ...]:
        return self.sets[0] if self.group else ()

    @property
    def detected(self) -> bool:
        return self.verdict == "missing_effect"

    @property
    def right(self) -> bool:
        return self.best == self.job.names

    @property
    def exact(self) -> bool:
        return self.sets == [self.job.names]

    @property
    def inside(self) -> bool:
        return self.job.names in self.sets

    @property
    def wrong(self) -> bool:
        return self.detected and not any(set(self.job.names) & set(x) for x in self.sets)

    @property
    def unflagged(self) -> bool:
        return self.detected and not self.inside and not self.flags

    @property
    def family(self) -> bool:
        return bool(self.families) and self.families[0] in self.kin

    @property
    def allowed(self) -> bool:
        helped = set(self.job.names) < set(self.best) and set(self.families) <= set(self.kin)
        return self.right or (bool(self.flags) and helped)


def diagnosed(job: Job) -> Answer:
    """Make a campaign and diagnose it."""
    campaign = job.campaign()
    begin = time.perf_counter()
    found = diagnose_captive(campaign, tank().BASE)
    seconds = time.perf_counter() - begin
    covered = {item.name: item for item in found.covered}
    known = [(covered[name], size) for name, size in job.effects if name in covered]
    visible = [item.without_a_run * size**2 >= SHOWS for item, size in known]
    answer = Answer(
        job=job,
        verdict=found.verdict,
        group=found.group,
        flags=found.flags,
        chance=found.chance,
        visible=bool(visible) and all(visible) and not set(job.names) & set(ABSORBED),
        families=tuple(item.family for item in found.findings),
        kin=tuple(item.family for item, _ in known),
        twins=False,
        seconds=seconds,
        formula=tuple(item.name for item in found.formula.terms) if found.formula else (),
    )
    rivals = [names for names in answer.sets if names != job.names]
    if answer.inside and rivals and job.truth == "catalogue":
        answer = replace(answer, twins=max(separations(job, campaign, rivals)) < SEPARABLE)
    return answer


def separations(job: Job, campaign: Any, rivals: Sequence[tuple[str, ...]]) -> list[float]:
    """Expected ln odds of the truth against rivals: half the squared distance that is left.

    The force of the truth is that of the tank without noise; the rival is fitted to it at each
    point of its grids, and at two neighbours together for what lies between.
    """
    system = captive_system(campaign, tank().BASE)
    with np.errstate(divide="ignore", invalid="ignore"):
        pure, empty = (
            [view.force for view in View.of(x.campaign("none")) if view.force]
            for x in (job, replace(job, effects=()))
        )
    score, square = np.zeros(len(system.normal.score)), 0.0
    for piece in system.pieces:
        c = piece.projection.channel
        force = np.concatenate([pure[i][c.name] - empty[i][c.name] for i in c.views])
        left = piece.projection.left(force[:, None])[:, 0]
        score[piece.places] += piece.columns.T @ left
        square += float(left @ left)
    found = []
    for names in rivals:
        tried = []
        options = [[b for b in system.blocks if b.candidate.name == name] for name in names]
        for step in range(max(len(own) for own in options)):
            blocks = [b for own in options for b in own[min(step, len(own) - 1) :][:2]]
            at = np.concatenate([b.places for b in blocks])
            gram = system.normal.information[np.ix_(at, at)]
            tried.append(square - score[at] @ np.linalg.lstsq(gram, score[at], rcond=1e-9)[0])
        found.append(0.5 * float(min(tried)))
    return found


def upper(count: int, total: int) -> float:
    """Upper 95 % confidence limit of a share (Clopper and Pearson), in per cent."""
    from scipy.stats import beta

    return 100.0 * float(beta.ppf(0.95, count + 1, total - count)) if count < total else 100.0


def jobs_of(how: tuple[str, str, str], o: argparse.Namespace) -> list[Job]:
    """All campaigns of one condition."""
    inside, outside = tank().INSIDE, tank().OUTSIDE
    own = [name for name in inside if name not in ABSORBED]
    rng = np.random.default_rng(o.first)
    seeds = range(o.first, o.first + o.seeds)
    if o.table == 2:
        jobs = [Job(((name, 1.0),), seed, *how) for name in own for seed in seeds]
        return jobs + [
            Job(((name, 1.0),), o.first + k, *how) for name in outside for k in range(o.outside)
        ]
    jobs = [Job((), o.first + 10_000 + k, *how) for k in range(o.none)]
    jobs += [Job(((n, size),), seed, *how) for size in o.sizes for n in inside for seed in seeds]
    return jobs + [
        Job(
            tuple((name, 1.0) for name in rng.choice(own, 2, replace=False).tolist()),
            o.first + 20_000 + k,
            *how,
        )
        for k in range(o.pairs)
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--table", type=int, default=1, choices=(1, 2))
    parser.add_argument("--only", help="one condition, as full/hard")
    parser.add_argument("--sizes", type=float, nargs="*", default=[0.3, 1.0])
    parser.add_argument("--seeds", type=int, default=10, help="seeds of each effect")
    parser.add_argument("--none", type=int, default=500, help="campaigns without an effect")
    parser.add_argument("--pairs", type=int, default=100)
    parser.add_argument("--outside", type=int, default=10, help="seeds of each outside effect")
    parser.add_argument("--first", type=int, default=0, help="first seed")
    add_workers(parser, usual=4)
    parser.add_argument("--out", type=Path, help="folder for answers.csv and confusion.png")
    o = parser.parse_args()
    every: list[Answer] = []
    with crew(o) as executor:
        for how in TABLES[o.table]:
            if o.only in (None, "/".join(how[:2])):
                answers = in_order(diagnosed, jobs_of(how, o), executor)
                print(f"\n{how[0]}, {how[1]} noise, {how[2]} truth, seeds from {o.first}")
                printed(answers, o.sizes if o.table == 1 else [1.0])
                every += answers
    confused(every)
    if o.out:
        o.out.mkdir(parents=True, exist_ok=True)
        written(every, o.out / "answers.csv")
        drawn(every, o.out / "confusion.png")


def share(answers: Sequence[Answer], of: Callable[[Answer], bool]) -> str:
    count = sum(map(of, answers))
    return f"{100 * count / max(len(answers), 1):5.1f} %"


def limited(answers: Sequence[Answer], of: Callable[[Answer], bool]) -> str:
    count = sum(map(of, answers))
    return f"{count} of {len(answers)} (at most {upper(count, max(len(answers), 1)):.1f} %)"


def printed(answers: Sequence[Answer], sizes: Sequence[float]) -> None:
    """The rows of one condition."""
    seconds = [a.seconds for a in answers]
    print(f"  {len(answers)} diagnoses of {np.median(seconds):.2f} s each (median)")
    if none := [a for a in answers if not a.job.effects]:
        print(
            f"  no effect: named in {limited(none, lambda a: a.detected)}, unexplained in "
            f"{limited(none, lambda a: a.verdict == 'unexplained')}, suspected in "
            f"{limited(none, lambda a: a.verdict == 'suspected')}"
        )
    inside = tank().INSIDE
    single = [a for a in answers if len(a.job.effects) == 1 and a.job.names[0] in inside]
    for size in sizes:
        rows(f"size {size:g}", [a for a in single if a.job.effects[0][1] == size and a.visible])
    if absorbed := [a for a in single if a.job.names[0] in ABSORBED]:
        print(f"  absorbed by the base: named in {limited(absorbed, lambda a: a.detected)}")
    rows("pairs", [a for a in answers if len(a.job.effects) == 2 and a.visible])
    if beyond := [a for a in answers if a.job.names and a.job.names[0] not in inside]:
        bare = limited(beyond, lambda a: a.detected and not a.flags)
        print(
            f"  outside the catalogue: a name without a flag in {bare}; a name in "
            f"{share(beyond, lambda a: a.detected)}, unexplained in "
            f"{share(beyond, lambda a: a.verdict == 'unexplained')}, suspected in "
            f"{share(beyond, lambda a: a.verdict == 'suspected')}"
        )


def rows(title: str, seen: Sequence[Answer]) -> None:
    """Shares of one size, over what is visible."""
    if not seen:
        return
    print(f"  {title}: {len(seen)} visible")
    for name, of in (
        ("detected", lambda a: a.detected),
        ("exact", lambda a: a.exact),
        ("best", lambda a: a.right),
        ("proven", lambda a: a.exact or a.twins),
        ("in group", lambda a: a.inside),
        ("family", lambda a: a.family),
        ("allowed", lambda a: a.allowed),
    ):
        print(f"    {name:10} {share(seen, of)}")
    print(f"    {'wrong':10} {limited(seen, lambda a: a.wrong)}")
    print(f"    {'unflagged':10} {limited(seen, lambda a: a.unflagged)}")
    print(
        f"    flagged although the truth is named: "
        f"{limited([a for a in seen if a.right], lambda a: bool(a.flags))}"
    )


def confused(answers: Sequence[Answer]) -> None:
    """The confusion matrix off its diagonal."""
    print("\nnamed otherwise than the truth alone (truth: group)")
    taken = Counter(
        (
            " + ".join(a.job.names),
            " | ".join(" + ".join(x) for x in a.sets[:3]) or a.verdict,
            "flagged" if a.flags else "",
            "twins" if a.twins else "",
        )
        for a in answers
        if a.job.effects and not a.exact and (a.visible or len(a.job.effects) == 2 or a.detected)
    )
    for (name, said, *marks), count in sorted(taken.items(), key=lambda x: (-x[1], x[0])):
        print(f"  {count:3} {name}: {said} {' '.join(filter(None, marks))}")


def written(answers: Sequence[Answer], path: Path) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        out = csv.writer(file)
        out.writerow(
            [
                "programme",
                "noise",
                "truth",
                "seed",
                "effects",
                "sizes",
                "visible",
                "verdict",
                "group",
                "odds",
                "chance",
                "flags",
                "exact",
                "best",
                "twins",
                "in_group",
                "family",
                "wrong",
                "seconds",
            ]
        )
        for a in answers:
            job = a.job
            out.writerow(
                [
                    job.programme,
                    job.noise,
                    job.truth,
                    job.seed,
                    " + ".join(name for name, _ in job.effects),
                    " + ".join(f"{size:g}" for _, size in job.effects),
                    a.visible,
                    a.verdict,
                    " | ".join(" + ".join(x) for x in a.sets),
                    " | ".join(f"{odds:.3g}" for _, odds in a.group),
                    f"{a.chance:.4f}",
                    "; ".join(a.flags),
                    a.exact,
                    a.right,
                    a.twins,
                    a.inside,
                    a.family,
                    a.wrong,
                    f"{a.seconds:.2f}",
                ]
            )


def drawn(answers: Sequence[Answer], path: Path) -> None:
    """Confusion matrix of the campaigns with one effect: the truth down, the best set across."""
    single = [a for a in answers if len(a.job.effects) == 1]
    truths = list(dict.fromkeys(a.job.names[0] for a in single))
    said = ["noise", "suspected", "unexplained", *truths, "other", "several"]

    def column(a: Answer) -> int:
        name = a.verdict if not a.best else a.best[0] if len(a.best) == 1 else "several"
        return said.index(name if name in said else "other")

    counts = np.zeros((len(truths), len(said)))
    for a in single:
        counts[truths.index(a.job.names[0]), column(a)] += 1
    figure = Figure(height=11.0, width=13.0)
    axis = figure.subplots()
    shades = Shades(levels=(0.0, float(np.sqrt(counts.max()))), colours=BLUES, smooth=True)
    axis.mosaic(np.sqrt(counts), shades, x=-0.5, y=-0.5)
    axis.set_ylim(len(truths) - 0.5, -0.5)
    axis.without_grid()
    for i, j in np.argwhere(counts > 0):
        dark = counts[i, j] > 0.4 * counts.max()
        axis.text(
            j,
            i,
            f"{counts[i, j]:.0f}",
            ha="center",
            va="center",
            fontsize=7,
            color="white" if dark else INK,
        )
    axis.set_xticks(range(len(said)), said, rotation=90, fontsize=7)
    axis.set_yticks(range(len(truths)), truths, fontsize=7)
    axis.set_xlabel("best set")
    axis.set_ylabel("hidden")
    figure.save(path)


if __name__ == "__main__":
    main()
