"""How often a hidden effect is found: campaigns of the virtual tank, diagnosed one after another.

    python scripts/hidden_effects.py [--programme full] [--noise standard] [--truth catalogue]
                                     [--sizes 0.3 1] [--seeds 10] [--none 500] [--pairs 100]
                                     [--first 0] [--jobs 4]

Programmes, noise and sizes are those of tests/hidden_effects. The base has linear and cubic terms
and none of what is hidden. An effect counts as visible where its signal at that size is large
enough (`Visible.signal` times the square of the size above 12). Prints how many campaigns without
any effect get a name, with the upper 95 % confidence limit; of each size how many are detected,
named exactly (a group of one), named in the group, named wrongly; the confusion matrix off its
diagonal.
"""

from __future__ import annotations

import argparse
import importlib
import sys
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pmmkit.diagnosis import diagnose_captive
from pmmkit.diagnosis.coverage import SHOWS

BASE = ("Xudot", "Xuu", "Xvv", "Xrr", "Yv", "Yr", "Yvvv", "Yrrr", "Yvdot", "Yrdot", "Nv", "Nr",
        "Nvvv", "Nrrr", "Nvdot", "Nrdot")  # fmt: skip
ABSORBED = ("fault_gauge_gain", "fault_moment_point", "fault_inertia")


def tank() -> Any:
    """The virtual tank, which lies with the tests."""
    sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
    return importlib.import_module("hidden_effects")


@dataclass(frozen=True)
class Job:
    """One campaign: what is hidden in it, and how it is made."""

    effects: tuple[tuple[str, float], ...]
    seed: int
    programme: str
    noise: str
    truth: str


@dataclass(frozen=True)
class Answer:
    """What the diagnosis said, and how visible the effects are at their usual size."""

    job: Job
    verdict: str
    group: tuple[tuple[str, ...], ...]
    flagged: bool
    signal: dict[str, float]


def diagnosed(job: Job) -> Answer:
    """Make a campaign and diagnose it."""
    campaign = tank().hidden_campaign(
        job.programme, dict(job.effects), seed=job.seed, noise=job.noise, truth=job.truth
    )
    found = diagnose_captive(campaign, BASE)
    return Answer(
        job=job, verdict=found.verdict, group=tuple(names for names, _ in found.group),
        flagged=bool(found.flags), signal={item.name: item.signal for item in found.covered},
    )  # fmt: skip


def upper(count: int, total: int) -> float:
    """Upper 95 % confidence limit of a share (Clopper and Pearson), in per cent."""
    from scipy.stats import beta

    return 100.0 * float(beta.ppf(0.95, count + 1, total - count)) if count < total else 100.0


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--programme", default="full")
    parser.add_argument("--noise", default="standard")
    parser.add_argument("--truth", default="catalogue")
    parser.add_argument("--sizes", type=float, nargs="*", default=[0.3, 1.0])
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--none", type=int, default=500)
    parser.add_argument("--pairs", type=int, default=100)
    parser.add_argument("--outside", type=int, default=0)
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--jobs", type=int, default=4)
    o = parser.parse_args()
    how = (o.programme, o.noise, o.truth)
    inside, outside = tank().INSIDE, tank().OUTSIDE
    rng = np.random.default_rng(o.first)
    visible = [name for name in inside if name not in ABSORBED]
    jobs = [Job((), o.first + 10_000 + k, *how) for k in range(o.none)]
    jobs += [Job(((name, size),), o.first + k, *how)
             for size in o.sizes for name in inside for k in range(o.seeds)]  # fmt: skip
    jobs += [
        Job(tuple((name, 1.0) for name in rng.choice(visible, 2, replace=False).tolist()),
            o.first + 20_000 + k, *how)
        for k in range(o.pairs)
    ]  # fmt: skip
    jobs += [Job(((name, 1.0),), o.first + k, *how) for name in outside for k in range(o.outside)]
    with ProcessPoolExecutor(o.jobs) as pool:
        answers = list(pool.map(diagnosed, jobs, chunksize=4))
    print(f"programme {o.programme}, noise {o.noise}, truth {o.truth}, seeds from {o.first}")
    none = [a for a in answers if not a.job.effects]
    if none:
        named = sum(a.verdict == "missing_effect" for a in none)
        other = sum(a.verdict == "unexplained" for a in none)
        print(f"no effect: {named} of {len(none)} named (at most {upper(named, len(none)):.1f} %), "
              f"{other} called unexplained")  # fmt: skip
    for size in o.sizes:
        singles(
            [a for a in answers if len(a.job.effects) == 1 and a.job.effects[0][0] in inside
             and a.job.effects[0][1] == size],
            size,
        )  # fmt: skip
    pairs = [a for a in answers if len(a.job.effects) == 2]
    if pairs:
        exact = sum(bool(a.group) and set(a.group[0]) == truth(a) for a in pairs)
        grouped = sum(any(set(g) == truth(a) for g in a.group) for a in pairs)
        print(f"pairs: exact {share(exact, len(pairs))}, in the group {share(grouped, len(pairs))}")
    beyond = [a for a in answers if a.job.effects and a.job.effects[0][0] in outside]
    if beyond:
        bare = sum(a.verdict == "missing_effect" and not a.flagged for a in beyond)
        print(f"outside the catalogue: {bare} of {len(beyond)} given a name without a flag "
              f"(at most {upper(bare, len(beyond)):.0f} %)")  # fmt: skip


def truth(answer: Answer) -> set[str]:
    return {name for name, _ in answer.job.effects}


def share(count: int, total: int) -> str:
    return f"{100 * count / max(total, 1):.0f} % ({count} of {total})"


def singles(answers: list[Answer], size: float) -> None:
    """Detected, exact, in the group, wrong, over what is visible; and what was taken for what."""
    seen = [
        a for a in answers
        if a.job.effects[0][0] not in ABSORBED
        and a.signal.get(a.job.effects[0][0], 0.0) * size**2 >= SHOWS
    ]  # fmt: skip
    detected = [a for a in seen if a.verdict == "missing_effect"]
    exact = [a for a in detected if len(a.group) == 1 and set(a.group[0]) == truth(a)]
    inside = [a for a in detected if any(set(g) == truth(a) for g in a.group)]
    wrong = [a for a in detected if not any(truth(a) & set(g) for g in a.group)]
    print(f"size {size:g}: {len(seen)} of {len(answers)} visible; detected "
          f"{share(len(detected), len(seen))}, exact {share(len(exact), len(seen))}, in the group "
          f"{share(len(inside), len(seen))}, wrong {share(len(wrong), len(seen))} "
          f"(at most {upper(len(wrong), max(len(seen), 1)):.1f} %)")  # fmt: skip
    absorbed = [a for a in answers if a.job.effects[0][0] in ABSORBED]
    print(f"  absorbed: {sum(a.verdict != 'noise' for a in absorbed)} of {len(absorbed)} not noise")
    taken = Counter(
        (next(iter(truth(a))), " | ".join(" + ".join(g) for g in a.group[:3]))
        for a in seen if a not in exact
    )  # fmt: skip
    for (name, said), count in taken.most_common(25):
        print(f"    {count:3} {name}: {said or 'noise'}")


if __name__ == "__main__":
    main()
