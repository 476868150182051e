"""What is said of truths that stand in no catalogue: campaigns of the virtual tank.

    python -m scripts.studies.beyond_catalogue [--seeds 6] [--first 7000] [--programme full]
                                               [--noise standard] [--size 1] [--of beyond]

Eight kinds of truth, unlike those of which `hidden_effects` counts the answers, are hidden one at a
time (twelve others with ``--of outside``, six that no rule was tried on with ``--of unseen``);
programmes, noise and base are those of that study. The only wrong answer is a name without
a flag: nobody adds an effect that is called the nearest relative of something else.

unflagged : an effect is named, and nothing says that it is not the whole story.
flagged : an effect is named, as the nearest relative.
unexplained : nothing is named, and something is said to be missing.
suspected : nothing is named but what one run alone shows, with the run to repeat.
silent : nothing is said to be missing.
formula : products of the motion are offered in its place, or beside what is named.

With --outside those truths take part too that table 2 of `hidden_effects` counts.
"""

from __future__ import annotations

import argparse
from collections import Counter

from scripts.studies.hidden_effects import Answer, Job, diagnosed, tank, upper

SAID = ("unflagged", "flagged", "unexplained", "suspected", "silent")


def said(answer: Answer) -> str:
    """The answer in one of the words above."""
    if answer.detected:
        return "flagged" if answer.flags else "unflagged"
    return "silent" if answer.verdict == "noise" else answer.verdict


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=6, help="seeds of each kind")
    parser.add_argument("--first", type=int, default=7000, help="first seed")
    parser.add_argument("--programme", default="full", choices=("full", "middle", "small"))
    parser.add_argument("--noise", default="standard", choices=("standard", "hard", "double"))
    parser.add_argument("--size", type=float, default=1.0)
    parser.add_argument("--of", default="beyond", choices=("beyond", "outside", "unseen"))
    o = parser.parse_args()
    print(
        f"{'':24}"
        + "".join(f"{word:>13}" for word in (*SAID, "formula"))
        + "  best sets | formulas"
    )
    every: Counter[str] = Counter()
    for name in getattr(tank(), o.of.upper()):
        answers = [
            diagnosed(Job(((name, o.size),), seed, o.programme, o.noise, "catalogue"))
            for seed in range(o.first, o.first + o.seeds)
        ]
        counts = Counter(said(answer) for answer in answers)
        best = Counter(" + ".join(answer.best) for answer in answers if answer.best)
        formulas = Counter(" + ".join(x.formula) for x in answers if x.formula)
        print(
            f"{name.removeprefix(f'{o.of}_'):24}"
            + "".join(f"{counts[word]:13}" for word in SAID)
            + "  "
            + " | ".join(
                ", ".join(f"{names} {count}" for names, count in found.most_common())
                for found in (best, formulas)
            ),
            flush=True,
        )
        every += counts
    total = every.total()
    print(f"{'all':24}" + "".join(f"{every[word]:13}" for word in SAID))
    limit = upper(every["unflagged"], total)
    print(f"names without a flag: {every['unflagged']} of {total} (at most {limit:.1f} %)")


if __name__ == "__main__":
    main()
