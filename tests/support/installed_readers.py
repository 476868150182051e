"""Readers as if other installed packages brought them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from types import SimpleNamespace
from unittest import mock

from pmmkit.readers import READERS, Reader


@contextmanager
def installed(*classes: type[Reader]) -> Iterator[None]:
    """The entry points of pmmkit are these classes, inside the block."""
    entries = [
        SimpleNamespace(
            name=one.__name__, value=one.__qualname__, dist=None, load=lambda one=one: one
        )
        for one in classes
    ]
    READERS.reload()
    with mock.patch("importlib.metadata.entry_points", return_value=entries):
        yield
    READERS.reload()
