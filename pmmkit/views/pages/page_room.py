"""What a page in one file has room for: 3 MB, the runs with the largest errors first."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from typing import Any, Final

MOST: Final = 2_700_000
"""Bytes of data: with the scripts a file stays below 3 MB."""
BUCKETS: Final = (200, 100, 50, 25)
"""Pieces of a record, as many as the file has room for."""
MAP_SHARE: Final = 0.5
"""Part of the data that one map of runs may take."""
DRAWN_SHARE: Final = 0.3
"""Part that candidates drawn over runs may take."""

Answers = dict[str, Any]
"""What the page asks, by the words it asks with."""


def asked_of(asked: str, of: int) -> str:
    """The words by which a page asks of a campaign; of the first it asks as if there were one.

    Parameters
    ----------
    asked : str
        The words without it.
    of : int
        Its place.
    """
    return f"{asked} {of}" if of else asked


def with_runs(
    answers: Answers,
    rows: Iterable[str],
    give: Callable[[str, int], Any],
    asked: Callable[[str], str],
    *,
    share: float = 1.0,
) -> Answers:
    """The answers with runs and their histories, as finely as there is room for."""
    runs = list(rows)
    room = share * (MOST - size_of(answers))
    fits = (x for x in BUCKETS if runs and size_of(give(runs[0], x)) * len(runs) <= room)
    buckets = next(fits, BUCKETS[-1])
    kept: Answers = {}
    for name in runs:
        page = give(name, buckets)
        room -= size_of(page)
        if room < 0:
            break
        kept[asked(name)] = page
    return {**answers, **kept}


def with_histories(
    answers: Answers, steps: int, campaigns: int, give: Callable[..., Any]
) -> Answers:
    """The answers that have room in a file, with the runs of each campaign, the worst first.

    Parameters
    ----------
    answers : dict
        What is known besides, a map of the runs with the model after each step among it.
    steps, campaigns : int
        How many there are.
    give : callable
        The page of a run of a campaign: its name, the `buckets` of its record and the place `of`
        the campaign.
    """
    found = fitted(answers)
    for of in range(campaigns):
        found = with_runs(
            found,
            worst_first(found[asked_of(f"misfit {steps}", of)]),
            partial(_given, give, of),
            partial(_asks_run, steps, of),
            share=1.0 / (campaigns - of),
        )
    return found


def _given(give: Callable[..., Any], of: int, run: str, buckets: int) -> Any:
    return give(run, buckets=buckets, of=of)


def _asks_run(steps: int, of: int, run: str) -> str:
    return asked_of(f"run {run} {steps}", of)


def worst_first(misfit: Mapping[str, Any]) -> list[str]:
    """The runs of a map, the one with the largest error over its uncertainty first."""
    rows = [row for group in misfit["groups"] for row in group["rows"]]
    return [row["run"] for row in sorted(rows, key=_size, reverse=True)]


def _size(row: Mapping[str, Any]) -> float:
    return max((cell["ratio"] or 0.0 for cell in row["cells"].values()), default=0.0)


def fitted(answers: Answers) -> Answers:
    """The answers, without what a file of 3 MB has no room for; each place says what it lacks."""
    own = {
        name: _shorter(page) if name.startswith("misfit ") else page
        for name, page in answers.items()
    }
    if own.get("missing") and size_of(own) > MOST:
        own["missing"] = _drawn_over_fewer(own["missing"], answers)
    places = [name for name in own if name.startswith("told ")]
    sizes = sorted(
        (len(item["svg"]) for name in places for item in _figures(own[name])), reverse=True
    )
    over = size_of(own) - MOST
    largest = float("inf")
    for size in sizes:
        if over <= 0:
            break
        largest, over = size, over - size
    if largest < float("inf"):
        own |= {name: _without_pictures(own[name], largest) for name in places}
    return own


def _figures(told: Mapping[str, Any]) -> list[dict[str, Any]]:
    return [
        item for part in ("before", "after", "folded") for x in told[part] for item in x["figures"]
    ]


def _without_pictures(told: Mapping[str, Any], largest: float) -> dict[str, Any]:
    """A place without the pictures of this size and above."""
    return {
        name: part
        if name == "facts"
        else [
            {
                **section,
                "figures": [
                    {**item, "svg": ""} if len(item["svg"]) >= largest else item
                    for item in section["figures"]
                ],
            }
            for section in part
        ]
        for name, part in told.items()
    }


def _shorter(misfit: Mapping[str, Any]) -> Mapping[str, Any]:
    """A map of so many rows as have room."""
    whole = size_of(misfit)
    if whole <= MAP_SHARE * MOST:
        return misfit
    runs = worst_first(misfit)
    kept = set(runs[: int(len(runs) * MAP_SHARE * MOST / whole)])
    groups = [
        {**group, "rows": [row for row in group["rows"] if row["run"] in kept]}
        for group in misfit["groups"]
    ]
    return {
        **misfit,
        "groups": [group for group in groups if group["rows"]],
        "left_out": len(runs) - len(kept),
    }


def _drawn_over_fewer(missing: Mapping[str, Any], answers: Answers) -> Mapping[str, Any]:
    """A diagnosis with candidates drawn over so many runs of each campaign as have room."""
    several = missing.get("drawn")
    tables = several or [missing]
    room = DRAWN_SHARE * MOST / len(tables)
    maps = [answers.get(asked_of("misfit 0", of)) for of in range(len(tables))]
    fewer = [
        _within(table, worst_first(own), room) if own else table
        for table, own in zip(tables, maps, strict=True)
    ]
    return {**missing, "drawn": fewer} if several else fewer[0]


def _within(table: Mapping[str, Any], runs: Sequence[str], room: float) -> Mapping[str, Any]:
    overlays = table.get("overlays") or {}
    kept: set[str] = set()
    for run in runs:
        room -= sum(size_of(own[run]) for own in overlays.values() if run in own)
        if room < 0:
            break
        kept.add(run)
    if room >= 0:
        return table
    return {
        **table,
        "overlays": {
            name: {run: values for run, values in own.items() if run in kept}
            for name, own in overlays.items()
        },
    }


def size_of(content: Any) -> int:
    """Bytes of what is held, to a few per cent."""
    return len(json.dumps(content, separators=(",", ":"), default=str))
