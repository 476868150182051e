"""How wide the doors of rooms are, beside what a person takes in."""

from __future__ import annotations

NARROW = 25
"""Names at a door that a person still takes in."""
WIDE: dict[str, int] = {"models": 42, "syntax": 27}
"""Doors that are wider, and by how much they are: these numbers only fall."""
