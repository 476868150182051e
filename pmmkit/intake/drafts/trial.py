"""A draft tried before a person has completed it, to ask its runs what they say together."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final, TypeVar

from pmmkit.base import DataError
from pmmkit.campaigns import Campaign, Run, campaign_of
from pmmkit.intake.checks.reading import summarise
from pmmkit.intake.checks.summary import Summary
from pmmkit.intake.file import LARGE

Item = TypeVar("Item")

_SHIP: Final[Mapping[str, Any]] = {
    "name": "stand-in",
    "L": 4.0,
    "B": 0.6,
    "d": 0.25,
    "volume": 0.4,
    "mass": 400.0,
    "Izz": 400.0,
}
"""A ship for drafts that name none: it scales forces and changes no sign."""
_WATER: Final[Mapping[str, Any]] = {"rho": 1000.0}
_SPEED: Final = 1.0
"""Speed [m/s] where nobody knows it; the same for all runs, so that it changes no sign."""
_MOST: Final = 12
"""Runs of a kind of test that are read, evenly among them: enough for every sign."""


def trial_campaign(text: str, target: Path, source: Mapping[str, str]) -> Campaign | None:
    """The runs of a campaign file that are complete, with stand-ins for ship, water and speed."""
    raw: dict[str, Any] = tomllib.loads(text)
    if "name" not in raw.get("ship", {}):
        raw["ship"] = {**_SHIP, **raw.get("ship", {})}
    raw["water"] = {**_WATER, **raw.get("water", {})}
    stated = raw.get("defaults", {})
    raw["defaults"] = {"speed": _SPEED, **stated, "source": {**source, **stated.get("source", {})}}
    found = [campaign for part in _parts(raw) if (campaign := _opened(part, target)) is not None]
    if not found:
        return None
    return found[0].with_(runs=tuple(run for campaign in found for run in campaign.runs))


def knows_speed(text: str) -> bool:
    """Whether a draft states the speed of all of its runs."""
    raw = tomllib.loads(text)
    entries = [entry for name in ("runs", "tables", "matrix") for entry in raw.get(name, [])]
    shared = raw.get("columns", {}) if "tables" in raw and "runs" not in raw else {}
    return "speed" in raw.get("defaults", {}) or all(
        "speed" in entry or {"speed", "u"} & {*shared, *entry.get("columns", {})}
        for entry in entries
    )


def summaries_of(campaign: Campaign) -> tuple[Summary, ...]:
    """What the runs say, of some runs of each kind of test; those that cannot be read left out."""
    kinds: dict[str, list[Run]] = {}
    for run in campaign:
        kinds.setdefault(run.test, []).append(run)
    found = []
    for runs in kinds.values():
        for run in _some(runs):
            try:
                if not _large(run):
                    found.append(summarise(run, campaign))
            except DataError:
                continue
    return tuple(found)


def _parts(raw: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """The file with one run, table or matrix each: what is wrong with one leaves the others.

    Of many runs of a kind of test some are taken, evenly among them.
    """
    names = ("runs", "tables", "matrix")
    rest = {name: item for name, item in raw.items() if name not in names}
    for name in names:
        kinds: dict[Any, list[Any]] = {}
        for entry in raw.get(name, []):
            kinds.setdefault(entry.get("test"), []).append(entry)
        for entries in kinds.values():
            for entry in _some(entries) if name == "runs" else entries:
                yield {**rest, name: [entry]}


def _some(items: Sequence[Item]) -> Sequence[Item]:
    return items[:: -(-len(items) // _MOST)]


def _opened(raw: Mapping[str, Any], target: Path) -> Campaign | None:
    try:
        return campaign_of(raw, target)
    except DataError:
        return None


def _large(run: Run) -> bool:
    path = getattr(run.loader, "path", None)
    return path is not None and path.is_file() and path.stat().st_size > LARGE
