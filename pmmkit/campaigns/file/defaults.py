"""What runs have in common, stated once: ``[defaults]`` and a table of it for a kind of test."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any, Final

from pmmkit.campaigns.file.faults import Faults
from pmmkit.campaigns.file.schema import DefaultsEntry, read_entry
from pmmkit.campaigns.run_settings import settings_by_key, ways_to_state
from pmmkit.campaigns.setting import ANY
from pmmkit.campaigns.test_kinds.kind import TestKind
from pmmkit.campaigns.test_kinds.registry import TEST_KINDS

_NESTED: Final = ("source", "columns", "cfd")
_NO_KINDS: Final = (*_NESTED, "tare")


@dataclass(frozen=True, kw_only=True)
class Defaults:
    """Keys of runs that state nothing else.

    `every`: for runs of all kinds. `of_kind`: for runs of one kind, before those for all.
    """

    every: Mapping[str, Any] = field(default_factory=dict)
    of_kind: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)


def read_defaults(raw: Any, out: Faults) -> Defaults:
    """``[defaults]``, validated; keys that are wrong are left out and added to `out`."""
    if not isinstance(raw, Mapping):
        out.report("must be a table.", "[defaults]")
        return Defaults()
    tables = {
        name: item
        for name, item in raw.items()
        if isinstance(item, Mapping) and name not in _NO_KINDS
    }
    for name in tables:
        if name not in TEST_KINDS:
            out.report(TEST_KINDS.unknown(name), f"[defaults.{name}]")
    return Defaults(
        every=_valid(
            {name: item for name, item in raw.items() if name not in tables}, "[defaults]", out
        ),
        of_kind={
            name: _valid(item, f"[defaults.{name}]", out)
            for name, item in tables.items()
            if name in TEST_KINDS
        },
    )


def _valid(raw: Mapping[str, Any], entry: str, out: Faults) -> dict[str, Any]:
    return {
        name: item
        for name, item in raw.items()
        if read_entry(DefaultsEntry, {name: item}, entry, out)
    }


def with_defaults(
    raw: Any, defaults: Defaults, mapped: Collection[str] = (), *, histories: bool = True
) -> Any:
    """An entry of ``[[runs]]``, ``[[tables]]`` or ``[[matrix]]`` with what it does not state.

    What a run states counts before what its kind has by default, and that before what all have;
    ``source``, ``columns`` and ``cfd`` are completed key by key. Of what all have a run takes only
    what its kind of test uses.

    Examples
    --------
    >>> common = Defaults(every={"speed": 1.5, "period": 9.0},
    ...                   of_kind={"pure_yaw": {"period": 12.0}})
    >>> with_defaults({"test": "pure_yaw"}, common)
    {'test': 'pure_yaw', 'period': 12.0, 'speed': 1.5}
    >>> with_defaults({"test": "static_drift", "speed": 1.0}, common)
    {'test': 'static_drift', 'speed': 1.0}
    >>> with_defaults({"test": "pure_sway", "frequency_hz": 0.1}, common)
    {'test': 'pure_sway', 'frequency_hz': 0.1, 'speed': 1.5}
    """
    test = raw.get("test") if isinstance(raw, Mapping) else None
    if not isinstance(test, str) or test not in TEST_KINDS:
        return raw
    kind = TEST_KINDS[test]
    found = dict(raw)
    rows = "row" in raw or not histories
    used = {name: item for name, item in defaults.every.items() if _uses(kind, name)}
    for common in (defaults.of_kind.get(test, {}), used):
        stated = {*found, *mapped}
        for name, item in common.items():
            if name == "tare" and rows:
                continue
            if name in _NESTED:
                own = found.get(name, {})
                found[name] = {**item, **own} if isinstance(own, Mapping) else own
            elif name not in found and not _others(name) & stated:
                found[name] = item
    return found


def _others(name: str) -> frozenset[str]:
    """Settings of which one stands for the others: a run that states one takes none by default."""
    item = settings_by_key().get(name)
    if item is None:
        return frozenset()
    ways = (ways_to_state(stated) for stated in (item.name, *item.states))
    return frozenset().union(*ways) - {name}


def _uses(kind: TestKind, name: str) -> bool:
    """Whether a setting means anything in tests of a kind."""
    item = settings_by_key().get(name)
    if item is None:
        return True
    if item.of_swing == ANY:
        return kind.oscillates
    swung = {swing.velocity or swing.displacement for swing in kind.swings}
    if item.of_swing:
        return bool(swung & set(item.of_swing)) and not swung & set(item.without)
    needed = {item.name, *item.states} & {*kind.needs, *kind.takes}
    return bool(needed) or not item.where_needed
