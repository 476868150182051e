"""pmmkit: from captive ship-model tests to derivatives, a model and manoeuvres.

The public words are reached as ``pmmkit.reduce`` and so on. They are listed once, in
``__init__.pyi``, where type checkers and editors read them too; what stands behind a word is
imported when it is used.
"""

from __future__ import annotations


def _homes() -> dict[str, str]:
    """The public words, each with the module that it is imported from."""
    import ast
    import pkgutil

    stub = pkgutil.get_data(__name__, "__init__.pyi") or b""
    return {
        word.name: node.module
        for node in ast.parse(stub).body
        if isinstance(node, ast.ImportFrom) and node.module
        for word in node.names
    }


_HOMES = _homes()
__all__ = sorted(_HOMES)


def __getattr__(name: str) -> object:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return __all__
