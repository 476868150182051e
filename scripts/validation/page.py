"""docs/validation.md: the list with counts on top, and what differs and why."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby, pairwise
from typing import Final

from pmmkit.bibliography import cite
from scripts.documentation.fences import table
from scripts.validation.chains import CHAINS
from scripts.validation.published import AGREES, Nature, Published

NAME: Final = "validation.md"
NATURES: Final[Mapping[Nature, str]] = {
    "measured": "measured in a tank or at sea",
    "computed": "computed, as published",
    "recomputed": "computed by another program from published values",
    "printed": "printed in formulas, rules and tables",
}
HEAD: Final = """\
# Published figures beside ours

Every published figure that we can name, with its source, ours beside it and the difference.
`python -m scripts.validation` makes this page; the tests compute each figure again and hold it to
the share that the list in `scripts/validation/` states for it.

{all}

Only figures that were *measured* say how good a prediction is. All others say whether the program
does what it is meant to: *computed* ones are other people's, as published; *recomputed* ones were
made for this list by another program from published values; *printed* are formulas, rules and
tables. Some figures stand beside two ways of computing. A difference is ours less the published
figure, over the size of that.

Ours that are "made with the measurements" take files of laboratories, which are no part of the
repository; `python -m scripts.validation --data FOLDER` makes them anew where the files are.
"""
LIST: Final = """\
## What differs by more than 5 %

Nothing here is tuned to what it is compared with. In the tables below these figures are in bold.
"""


def page() -> str:
    """The page."""
    everything = [figure for figures in CHAINS.values() for figure in figures]
    shown = [
        HEAD.format(all=summary(everything)),
        counts("chain", CHAINS),
        counts("what they are", {told: of_nature(everything, x) for x, told in NATURES.items()}),
        LIST + "\n" + differing(everything),
    ]
    for chain, figures in CHAINS.items():
        shown.append(f"## {chain}")
        shown += [one_table(title, list(rows)) for title, rows in by_table(figures)]
    return "\n\n".join(part.strip() for part in shown) + "\n"


def summary(figures: Sequence[Published]) -> str:
    """All counts in a sentence."""
    counted = [sum(x.agrees <= share for x in figures) for share in AGREES]
    told = [f"{n} within {100 * share:g} %" for n, share in zip(counted, AGREES, strict=True)]
    return f"**{len(figures)} figures: {', '.join(told)}.**"


def of_nature(figures: Iterable[Published], nature: Nature) -> tuple[Published, ...]:
    """Figures of one nature."""
    return tuple(figure for figure in figures if figure.nature == nature)


def by_table(figures: Iterable[Published]) -> Iterable[tuple[str, Iterable[Published]]]:
    """Figures in their tables, which stand together."""
    return groupby(figures, key=lambda figure: figure.table)


def counts(head: str, groups: Mapping[str, Sequence[Published]]) -> str:
    """How many figures of each group agree, and of all together."""
    shares = (*AGREES, math.inf)
    rows = [(name, *(sum(x.agrees == y for x in figures) for y in shares))
            for name, figures in groups.items()]  # fmt: skip
    rows.append(("all", *map(sum, zip(*(row[1:] for row in rows), strict=True))))
    steps = [f"{100 * share:g}" for share in AGREES]
    between = [f"{low} to {high} %" for low, high in pairwise(steps)]
    heads = (head, "figures", f"within {steps[0]} %", *between, f"more than {steps[-1]} %")
    return table(heads, ((name, str(sum(numbers)), *map(str, numbers)) for name, *numbers in rows))


def differing(figures: Iterable[Published]) -> str:
    """Tables with figures that do not agree, and why."""
    rows = []
    for title, members in by_table(figures):
        every = list(members)
        off = [figure for figure in every if figure.agrees == math.inf]
        if off:
            largest = max(off, key=lambda figure: abs(figure.off))
            reasons = " ".join(dict.fromkeys(figure.why for figure in off))
            told = f"{len(off)} of {len(every)}"
            rows.append((title, told, f"{percent(largest.off)} ({largest.name})", reasons))
    return table(("table", "figures", "largest difference", "why"), rows)


def one_table(title: str, figures: Sequence[Published]) -> str:
    """One table of the list."""
    first = figures[0]
    source = "; ".join(filter(None, [cite(*first.sources), first.place]))
    lines = [
        f"### {title}",
        f"Published ({first.nature}): {source}.  \nOurs: {first.how}.",
        table(("", "published", "ours", "difference"), map(row, figures)),
        *reasons(figures),
    ]
    return "\n\n".join(lines)


def reasons(figures: Sequence[Published]) -> Iterable[str]:
    """Why figures differ by more than the smallest share, where that is told."""
    off = [figure for figure in figures if figure.why and figure.agrees > AGREES[0]]
    for why in dict.fromkeys(figure.why for figure in off):
        whole = all(figure.why == why for figure in figures)
        names = ", ".join(figure.name for figure in off if figure.why == why)
        yield f"Why: {why}" if whole else f"Why {names}: {why}"


def row(figure: Published) -> Sequence[str]:
    """One figure."""
    published = f"{figure.value:.7g} {figure.unit}".strip()
    off = percent(figure.off)
    told = f"**{off}**" if figure.agrees == math.inf else off
    return figure.name, published, f"{figure.ours():.5g}", told


def percent(share: float) -> str:
    """A difference [%]."""
    told = f"{100 * share:+.1f} %" if abs(share) < 1 else f"{100 * share:+.0f} %"
    return "0.0 %" if told in ("+0.0 %", "-0.0 %") else told
