"""docs/validation*.md: our predictions beside measurements, and what stands behind them."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby, pairwise
from typing import Final

import numpy as np

from pmmkit.conventions import cite
from scripts.documentation.fences import table
from scripts.validation.chains import CHAINS
from scripts.validation.published import AGREES, Nature, Part, Published

NAMES: Final[Mapping[Part, str]] = {
    "prediction": "validation.md",
    "program": "validation_programs.md",
    "literature": "validation_literature.md",
}
COLUMNS: Final[Mapping[Part, tuple[str, str]]] = {
    "prediction": ("measured", "ours"),
    "program": ("published", "ours"),
    "literature": ("one party", "the other"),
}
"""What the two numbers of a row are called."""
NATURES: Final[Mapping[Nature, str]] = {
    "computed": "computed, as published",
    "recomputed": "computed by another program from published values",
    "printed": "printed in formulas, rules and tables",
}
SHARES: Final = (0.05, 0.1)
"""Shares within which predictions are counted."""
STATED: Final = "within twice the stated uncertainty"
FRONT: Final = """\
# Our predictions beside measurements

{counts}

A difference is ours less the measured figure, over the size of that; below, more than 5 % is in
bold. The last column stands where pmmkit states a standard uncertainty for its own figure: that of
the formulas, and 0.04 of the wave and of its slope for motions by strip theory. Both were found
from ships of this very table, so that the column is no independent check.

No model is tuned to what it stands beside; but others identified nine derivatives of the bulk
carrier from her trials. Some measured figures stand here more than once: HSVA's overshoots beside
two models, the added resistance beside three methods.

Two pages stand behind this one, and are not counted here:

- [Our program beside other programs](validation_programs.md), formulas and rules: {programs}
  figures, which say whether it does what it is meant to.
- [Two other parties beside one another](validation_literature.md): {others} figures, none of them
  a prediction of ours.

This page and the two others are generated from the list in `scripts/validation/` by
`python -m scripts.validation`, and the tests hold each figure to the share that it states. Ours
that are "made with the measurements" take files of laboratories, which are no part of the
repository; `--data FOLDER` makes them anew where they are.
"""
PROGRAMS: Final = """\
# Our program beside other programs

Figures that other programs, formulas, rules and tables give, with their source, ours beside them
and the difference. They say whether the program does what it is meant to. Only
[measurements](validation.md) say how good a prediction is. This page is generated from the list in
`scripts/validation/` by `python -m scripts.validation`.

{all}

*Computed* figures are other people's, as published; *recomputed* ones were made for this list by
another program from published values; *printed* are formulas, rules and tables. A difference is
ours less the published figure, over the size of that.

{chains}

{natures}

## What differs by more than 5 %

In the tables below these figures are in bold.

{differing}
"""
LITERATURE: Final = """\
# Two other parties beside one another

Neither number of a row is a prediction of ours, so none is counted: two laboratories, each with its
own model. pmmkit reduced the forces of the other; what its reduction is worth stands on
[the page of programs](validation_programs.md). A difference is the other party's less the first's,
over the size of that; what is more than 5 % off is in bold. This page is generated from the list in
`scripts/validation/` by `python -m scripts.validation`.
"""


def pages() -> Mapping[str, str]:
    """The three pages, by name."""
    made = {"prediction": front(), "program": programs(), "literature": literature()}
    return {name: made[part] for part, name in NAMES.items()}


def of_part(part: Part) -> Mapping[str, Sequence[Published]]:
    """Figures of one page, by chain."""
    found = {name: [x for x in figures if x.part == part] for name, figures in CHAINS.items()}
    return {name: figures for name, figures in found.items() if figures}


def every(part: Part) -> Sequence[Published]:
    """Figures of one page."""
    return [figure for figures in of_part(part).values() for figure in figures]


def front() -> str:
    """Our predictions, their counts first."""
    predictions = every("prediction")
    head = FRONT.format(
        counts=standing(predictions),
        programs=len(every("program")),
        others=len(every("literature")),
    )
    return joined(head, *tables(predictions, "##"))


def programs() -> str:
    """Our program beside others."""
    chains, figures = of_part("program"), every("program")
    natures = {told: [x for x in figures if x.nature == name] for name, told in NATURES.items()}
    head = PROGRAMS.format(
        all=summary(figures),
        chains=counts("chain", chains),
        natures=counts("what they are", natures),
        differing=differing(figures),
    )
    shown = [part for name, of in chains.items() for part in (f"## {name}", *tables(of, "###"))]
    return joined(head, *shown)


def literature() -> str:
    """Other parties, of whom nothing is counted."""
    return joined(LITERATURE, *tables(every("literature"), "##"))


def joined(*parts: str) -> str:
    """A page of its parts."""
    return "\n\n".join(part.strip() for part in parts) + "\n"


def standing(figures: Sequence[Published]) -> str:
    """How far predictions are off, table by table and together."""
    near = [f"within {100 * share:g} %" for share in SHARES]
    head = ("ship and test", "figures", "median difference", "nine in ten within", *near, STATED)
    rows = [(f"[{title}](#{anchor(title)})", *stood(list(of))) for title, of in by_table(figures)]
    return table(head, [*rows, ("**all**", *stood(figures))])


def stood(figures: Sequence[Published]) -> Sequence[str]:
    """How many predictions there are, how far they are off and how many are near."""
    sizes = np.abs([figure.off for figure in figures])
    middle, most = np.quantile(sizes, (0.5, 0.9), method="inverted_cdf")
    stated = [figure.expected for figure in figures if figure.std]
    near = [str(np.count_nonzero(sizes <= share)) for share in SHARES]
    told = f"{sum(stated)} of {len(stated)}" if stated else "–"
    return str(len(sizes)), f"{100 * middle:.1f} %", f"{100 * most:.1f} %", *near, told


def anchor(heading: str) -> str:
    """Where a link finds a heading."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def summary(figures: Sequence[Published]) -> str:
    """All counts in a sentence."""
    counted = [sum(x.agrees <= share for x in figures) for share in AGREES]
    told = [f"{n} within {100 * share:g} %" for n, share in zip(counted, AGREES, strict=True)]
    return f"**{len(figures)} figures: {', '.join(told)}.**"


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
        together = list(members)
        off = [figure for figure in together if figure.agrees == math.inf]
        if off:
            largest = max(off, key=lambda figure: abs(figure.off))
            reasons = " ".join(dict.fromkeys(figure.why for figure in off))
            told = f"{len(off)} of {len(together)}"
            rows.append((title, told, f"{percent(largest.off)} ({largest.name})", reasons))
    return table(("table", "figures", "largest difference", "why"), rows)


def tables(figures: Iterable[Published], level: str) -> Iterable[str]:
    """Each table under its heading: where both numbers come from, why they differ, and the rows."""
    for title, members in by_table(figures):
        together = list(members)
        first = together[0]
        one, other = COLUMNS[first.part]
        kind = f" ({first.nature})" if first.part == "program" else ""
        source = "; ".join(filter(None, [cite(*first.sources), first.place]))
        told = [
            f"{one.capitalize()}{kind}: {source}.",
            f"{other.capitalize()}: {first.how}.",
            *reasons(together),
        ]
        yield f"{level} {title}"
        yield "  \n".join(told)
        yield table(("", one, other, "difference"), map(row, together))


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
