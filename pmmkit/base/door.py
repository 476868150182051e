"""The door of a room: what stands behind a name is imported when the name is used."""

from __future__ import annotations

import ast
import importlib.abc
import sys


def lazy(room: str) -> None:
    """Let a package give the names that it imports for type checkers alone, when they are asked.

    A door is written as type checkers, editors and people read it: imports under
    ``if TYPE_CHECKING``, and ``__all__``. Nothing is listed a second time for the interpreter.

    Parameters
    ----------
    room : str
        Name of the package, ``__name__``.

    Examples
    --------
    >>> import pmmkit.conventions
    >>> "Ship" in dir(pmmkit.conventions), pmmkit.conventions.Ship.__name__
    (True, 'Ship')
    """
    package = sys.modules[room]
    places: dict[str, tuple[str, str]] = {}

    def give(name: str) -> object:  # kept nowhere: a test may put another in its place
        if not places:
            places.update(_places(room))
        if name not in places:
            raise AttributeError(f"module {room!r} has no attribute {name!r}")
        module, inner = places[name]
        return getattr(importlib.import_module(module), inner)

    setattr(package, "__getattr__", give)  # noqa: B010, mypy must not take any name as known
    setattr(package, "__dir__", lambda: sorted(package.__all__))  # noqa: B010, the same


def _places(room: str) -> dict[str, tuple[str, str]]:
    """The module and the name there of each name that a door lists."""
    spec = sys.modules[room].__spec__
    assert spec is not None
    assert isinstance(spec.loader, importlib.abc.InspectLoader)
    source = spec.loader.get_source(room)
    assert source is not None, f"{room} must be installed with its source"
    return {
        item.asname or item.name: (node.module, item.name)
        for block in ast.parse(source).body
        if isinstance(block, ast.If)
        for node in block.body
        if isinstance(node, ast.ImportFrom) and node.module
        for item in node.names
    }
