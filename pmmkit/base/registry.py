"""Entries of pmmkit's registries that other installed packages bring, by entry point."""

from __future__ import annotations

import warnings
from collections.abc import Container
from importlib.metadata import EntryPoint, entry_points
from typing import Protocol, TypeVar


class Named(Protocol):
    """An entry of a registry."""

    @property
    def name(self) -> str:
        """Its name, once in the registry."""


Entry = TypeVar("Entry", bound=Named)


def offered(group: str, kind: type[Entry], taken: Container[str] = ()) -> dict[str, Entry]:
    """What installed packages bring to a registry, by name.

    An entry point names an entry, several in a list or tuple, or a class that makes one without
    arguments. What cannot be used is left out with a warning: a package of somebody else must not
    stop pmmkit.

    Parameters
    ----------
    group : str
        Entry point group, such as ``pmmkit.readers``.
    kind : type
        What an entry is.
    taken : container of str
        Names that there are already.

    Examples
    --------
    >>> from pmmkit.conventions import Ship
    >>> offered("pmmkit.nothing", Ship)
    {}
    """
    found: dict[str, Entry] = {}
    for point in sorted(entry_points(group=group), key=lambda point: point.name):
        try:
            for item in _loaded(point, kind):
                if item.name in taken or item.name in found:
                    raise ValueError(f"the name {item.name!r} is taken")
                found[item.name] = item
        except Exception as error:
            package = "a package" if point.dist is None else point.dist.name
            warnings.warn(f"{group} {point.name!r} of {package} is left out: {error}", stacklevel=2)
    return found


def _loaded(point: EntryPoint, kind: type[Entry]) -> tuple[Entry, ...]:
    given = point.load()
    if isinstance(given, type):
        given = given()
    items = (given,) if isinstance(given, kind) else tuple(given)
    for item in items:
        if not isinstance(item, kind):
            raise TypeError(f"{item!r:.60} is no {kind.__name__}")
    return items
