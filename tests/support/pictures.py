"""Reports and files without pictures."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest


def blank(*_: Any) -> str:
    """Stands for a figure."""
    return "<svg></svg>"


@contextmanager
def without_pictures() -> Iterator[None]:
    """Figures are not drawn: that takes most of the time of a report."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("pmmkit.plotting.figure.svg", blank)
        yield
