"""Runs that are copies of one another."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.campaigns import RUN_SETTINGS
from pmmkit.intake.checks.finding import Check, CheckFinding, figure

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign, Settings
    from pmmkit.intake.checks.finding import Summary

NEARLY: Final = 1e-4
_BLOCK: Final = 256


def examine_copies(_campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """Runs whose forces are the same numbers.

    With different settings one of them must be wrong: an error. With the same settings it is one
    measurement listed twice, which counts it double: worth knowing. Forces that agree to 1e-4
    without being the same are suspicious where the settings differ.
    """
    yield from _same_name(summaries)
    groups: dict[str, list[Summary]] = {}
    for item in summaries:
        if item.digest:
            groups.setdefault(item.digest, []).append(item)
    shared: list[tuple[str, ...]] = []
    for group in groups.values():
        if len(group) < 2:
            continue
        ids = tuple(item.run.id for item in group)
        differ = _differences([item.run.settings for item in group])
        if differ:
            yield CheckFinding(
                check="copies",
                severity="error",
                message=f"The forces are the same numbers, value for value, although the runs are "
                f"to differ in {differ}: at most one of them was measured.",
                runs=ids,
                remedy="Find out which is the original and leave the copy out "
                '(action = "exclude", with the reason).',
                numbers={"runs": float(len(ids))},
            )
        else:
            shared.append(ids)
    if shared:
        pairs = "; ".join(" = ".join(ids) for ids in shared[:6])
        more = f" and {len(shared) - 6} more" if len(shared) > 6 else ""
        yield CheckFinding(
            check="copies",
            severity="info",
            message=f"{len(shared)} measurements are listed more than once with the same settings: "
            f"{pairs}{more}.",
            runs=tuple(name for ids in shared for name in ids),
            remedy="A measurement listed twice counts twice in a fit; leave one of each out.",
            numbers={"measurements": float(len(shared))},
        )
    yield from _nearly(summaries)


def _same_name(summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    seen: dict[str, list[Summary]] = {}
    for item in summaries:
        seen.setdefault(item.run.id, []).append(item)
    for name, group in seen.items():
        if len(group) > 1:
            differ = _differences([item.run.settings for item in group])
            yield CheckFinding(
                check="copies",
                severity="error",
                message=f"{len(group)} runs are called {name}"
                + (f"; they differ in {differ}." if differ else "."),
                runs=(name,),
                remedy="Give each run a name of its own, or leave one out.",
                numbers={"runs": float(len(group))},
            )


def _nearly(summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    sizes: dict[int, list[Summary]] = {}
    for item in summaries:
        if item.sketch.size and float(item.sketch @ item.sketch) > 0:
            sizes.setdefault(item.sketch.size, []).append(item)
    for group in sizes.values():
        sketches = np.stack([item.sketch for item in group])
        power = np.einsum("ij,ij->i", sketches, sketches)
        for start in range(0, len(group), _BLOCK):
            block = sketches[start : start + _BLOCK]
            nearness = power[start : start + _BLOCK, None] + power - 2 * block @ sketches.T
            rows, columns = np.nonzero(nearness < (3 * NEARLY) ** 2 * power)
            for row, column in zip(rows + start, columns, strict=True):
                if row < column:
                    yield from _pair(group[row], group[column])


def _pair(one: Summary, other: Summary) -> Iterator[CheckFinding]:
    distance = float(np.linalg.norm(one.sketch - other.sketch) / np.linalg.norm(other.sketch))
    differ = _differences([one.run.settings, other.run.settings])
    if one.digest == other.digest or not differ or distance > NEARLY:
        return
    yield CheckFinding(
        check="copies",
        severity="warning",
        message=f"The forces agree to {figure(distance)} of their size, closer than a repeat of a "
        f"test does, although the runs are to differ in {differ}.",
        runs=(one.run.id, other.run.id),
        remedy="Find out whether one was made from the other.",
        numbers={"distance": distance},
    )


def _differences(settings: Sequence[Settings]) -> str:
    """The settings that differ, with their values, in words."""
    words = []
    for setting in RUN_SETTINGS.values():
        if not setting.word:
            continue
        unit, factor = ("°", 180 / math.pi) if setting.angle else (setting.unit, 1.0)
        values = [item.value(setting.name) for item in settings]
        if any(_unlike(one, other) for one, other in combinations(values, 2)):
            shown = " and ".join(
                dict.fromkeys("none" if v is None else f"{v * factor:.4g} {unit}" for v in values)
            )
            words.append(f"{setting.word} ({shown})")
    return ", ".join(words)


def _unlike(one: float | None, other: float | None) -> bool:
    if one is None or other is None:
        return one is not other
    return not math.isclose(one, other, rel_tol=1e-9, abs_tol=1e-12)


CHECKS = (
    Check(
        "copies", "runs whose forces are the same numbers, and names given twice", examine_copies
    ),
)
