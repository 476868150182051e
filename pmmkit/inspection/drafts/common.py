"""What the runs of a draft have in common, to be stated once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

from pmmkit.inspection.drafts.draft import RunDraft
from pmmkit.inspection.drafts.settle import Setting

_ASKED_ONCE: Final = ("speed", "period")
"""Settings that whole programmes share: where no run knows them they are asked for once."""


@dataclass(frozen=True, kw_only=True)
class Common:
    """Runs and what they share.

    Parameters
    ----------
    every : tuple of Setting
        What all runs have.
    of_kind : mapping of str to tuple of Setting
        What all runs of a kind of test have.
    runs, tables : tuple of RunDraft
        With what is left of their settings.
    """

    every: tuple[Setting, ...]
    of_kind: Mapping[str, tuple[Setting, ...]]
    runs: tuple[RunDraft, ...]
    tables: tuple[RunDraft, ...]


def in_common(runs: Sequence[RunDraft], tables: Sequence[RunDraft]) -> Common:
    """The settings that all runs, or all of a kind, have alike, taken out of them.

    Parameters
    ----------
    runs, tables : sequence of RunDraft
        Of a draft.
    """
    entries = [*runs, *tables]
    shared = _shared(entries)
    every = tuple(item for item in shared if item.key == "speed")
    entries = _without(entries, every)
    tests = dict.fromkeys(entry.test for entry in entries if entry.test is not None)
    of_kind = {}
    for test in tests:
        own = _shared([entry for entry in entries if entry.test == test])
        if own:
            of_kind[test] = own
            entries = _without(entries, own, test)
    return Common(
        every=every,
        of_kind=of_kind,
        runs=tuple(entries[: len(runs)]),
        tables=tuple(entries[len(runs) :]),
    )


def _shared(entries: Sequence[RunDraft]) -> tuple[Setting, ...]:
    """Settings that two or more entries have, and all that have them alike."""
    found: dict[str, list[Setting]] = {}
    for entry in entries:
        for item in entry.settings:
            found.setdefault(item.key, []).append(item)
    return tuple(
        _one(items)
        for key, items in found.items()
        if len(items) > 1
        and len({(item.value, item.todo, item.active) for item in items}) == 1
        and ((items[0].active and not items[0].todo) or (key in _ASKED_ONCE and not items[0].value))
    )


def _one(items: Sequence[Setting]) -> Setting:
    """The setting of all, with the reasons of the first few."""
    reasons = list(dict.fromkeys(item.reason for item in items if item.reason))
    more = f" and {len(reasons) - 1} more" if len(reasons) > 1 else ""
    return replace(items[0], reason=f"{reasons[0]}{more}" if reasons else "")


def _without(
    entries: Sequence[RunDraft], items: Sequence[Setting], test: str | None = None
) -> list[RunDraft]:
    keys = {item.key for item in items}
    return [
        replace(entry, settings=tuple(item for item in entry.settings if item.key not in keys))
        if test in (None, entry.test)
        else entry
        for entry in entries
    ]
