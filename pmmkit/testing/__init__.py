"""Contracts: what every entry of a registry must hold; run them over your own."""

from __future__ import annotations

from collections.abc import Iterable


def hold(entry: str, faults: Iterable[str]) -> None:
    """Refuse an entry with everything that does not hold."""
    if found := list(faults):
        raise AssertionError("\n- ".join([f"{entry}:", *found]))
