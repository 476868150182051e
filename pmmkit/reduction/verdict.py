"""Whether a table can be used: one line, with the doubts that belong to it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from pmmkit.checks import CheckFinding
from pmmkit.presentation import at_froude, listed
from pmmkit.reduction.influence import Influences
from pmmkit.reduction.solve import Solution
from pmmkit.tables import DerivativeTable

Use = Literal["usable", "usable with doubts", "not usable"]
LOST: Final = 0.25
"""Share of the rms force that a fit leaves from which it fits nothing."""
DECIDES: Final = 3.0
"""Half intervals by which one run may move a derivative before it is said aloud."""
NEGATIVE: Final = ("Xudot", "Yvdot", "Nrdot", "Kpdot", "Yv", "Nr", "Xuu")
"""Derivatives that are negative for every hull."""
TOLD: Final = 4
"""Names that a sentence lists."""


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """Whether a derivative table can be used.

    Parameters
    ----------
    use : {"usable", "usable with doubts", "not usable"}
        The verdict.
    reasons : tuple of str
        What stands against it, the gravest first.

    Examples
    --------
    >>> print(Verdict(use="usable with doubts", reasons=("Y: misfit.",)))
    Usable with the 1 doubt above.
    """

    use: Use
    reasons: tuple[str, ...]

    def __str__(self) -> str:
        if self.use == "usable":
            return "Usable: nothing speaks against these derivatives."
        count = f"{len(self.reasons)} {'doubt' if len(self.reasons) == 1 else 'doubts'}"
        if self.use == "usable with doubts":
            return f"Usable with the {count} above."
        return f"Not usable: {self.reasons[0]}"


def verdict(
    table: DerivativeTable,
    families: Mapping[str, DerivativeTable],
    solution: Solution,
    influences: Influences,
    findings: Sequence[CheckFinding],
) -> Verdict:
    """Judge a reduction by everything that it found.

    Parameters
    ----------
    table, families
        All runs together, and by family of tests.
    solution : Solution
        The fits behind the table.
    influences : Influences
        What each run does.
    findings : sequence of CheckFinding
        What the checks found.
    """
    fatal = [
        *(str(item) for item in findings if item.severity == "error"),
        *_lost(solution),
        *_nothing(table),
    ]
    doubts = [
        *_misfit(solution),
        *_disagreeing(table, families),
        *_odd(influences),
        *_signs(table),
        *_alone(influences),
        *(
            f"The checks warn: {item.message}"
            for item in findings
            if item.severity == "warning" and item.check != "odd_run"
        ),
    ]
    use: Use = "not usable" if fatal else "usable with doubts" if doubts else "usable"
    return Verdict(use=use, reasons=(*fatal, *doubts))


def _nothing(table: DerivativeTable) -> Iterator[str]:
    if not np.isfinite(table.value).any():
        yield "these runs determine none of the derivatives."


def _lost(solution: Solution) -> Iterator[str]:
    for group, item in solution.fits:
        if item.excessive and item.left > LOST:
            yield (
                f"{item.channel}{at_froude(solution.Fn[group])}: the fit leaves "
                f"{100 * item.left:.0f} % of the force, {math.sqrt(item.scale):.0f} times the "
                f"noise. Its intervals are none."
            )


def _misfit(solution: Solution) -> Iterator[str]:
    for group, item in solution.fits:
        if item.excessive and item.left <= LOST:
            yield (
                f"{item.channel}{at_froude(solution.Fn[group])}: the misfit is "
                f"{math.sqrt(item.scale):.1f} times the noise ({100 * item.left:.1f} % of the "
                f"force), and scatter between runs does not explain it. The structure lacks "
                f"something: diagnose names it. Intervals are wider, but do not hold its bias."
            )


def _disagreeing(table: DerivativeTable, families: Mapping[str, DerivativeTable]) -> Iterator[str]:
    """Families of tests whose intervals do not touch those of all tests together."""
    low, high = table.interval()
    for title, own in families.items():
        below, above = own.interval()
        told = []
        for row, Fn in enumerate(own.Fn):
            at = 0 if table.pooled else int(np.argmin(np.abs(table.Fn - Fn)))
            for name in (name for name in own.names if name in table):
                here, there = own.index(name), table.index(name)
                if below[row, here] > high[at, there] or above[row, here] < low[at, there]:
                    told.append(name)
        if told:
            yield (
                f"{title.capitalize()} alone gives other values of "
                f"{_list(list(dict.fromkeys(told)))} than all tests together: the intervals do "
                f"not touch."
            )


def _odd(found: Influences) -> Iterator[str]:
    for run in dict.fromkeys(one.run for one in found.odd):
        channels = [one.channel for one in found.odd if one.run == run]
        yield f"Run {run} is at odds with the others in {_list(list(dict.fromkeys(channels)))}."


def _alone(found: Influences) -> Iterator[str]:
    odd = {one.run for one in found.odd}
    strong = [(one, name, share) for one, name, share in found.strong() if one.run not in odd]
    grave = [entry for entry in strong if abs(entry[2]) > DECIDES]
    if grave:
        one, name, share = grave[0]
        yield (
            f"Run {one.run} alone moves {name}{at_froude(one.Fn)} by {abs(share):.1f} times half "
            f"of its interval: repeat it before anything hangs on that."
        )


def _signs(table: DerivativeTable) -> Iterator[str]:
    """Added masses and damping of a sign that no hull has, beyond their intervals."""
    low, _ = table.interval()
    for name in table.names:
        if name in NEGATIVE and np.any(low[:, table.index(name)] > 0):
            yield f"{name} is positive, which no hull has: check signs, units and inertia."


def _list(names: Sequence[str]) -> str:
    """The first names, and how many more there are."""
    more = len(names) - TOLD
    return f"{', '.join(names[:TOLD])} and {more} more" if more > 0 else listed(names)
