"""The sign ± has one meaning wherever the program tells a number: half of the 95 % interval."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FILES = [path for folder in ("pmmkit", "scripts") for path in sorted((ROOT / folder).rglob("*.py"))]
AFTER = re.compile(r'±[^{}\n]{0,2}"?\s*(?:f")?\{([^}]*)\}')
WIDE = re.compile(r"WIDE|half|high|limit")


def halves(text: str) -> list[str]:
    """What stands after ± in the f-strings of a text."""
    return AFTER.findall(text)


@pytest.mark.parametrize(
    "path",
    [
        path
        for path in FILES
        if "±" in path.read_text("utf-8") and path.name != "numbers.py"  # is given halves
    ],
    ids=lambda path: path.name,
)
def test_what_stands_after_the_sign_is_half_of_an_interval(path):
    found = halves(path.read_text("utf-8"))
    assert [item for item in found if not WIDE.search(item)] == []


def test_a_standard_deviation_after_the_sign_is_seen():
    assert halves('f"x ± {std:.2f} m"') == ["std:.2f"]
    assert halves('f"{x} ± "\n    f"{figure(std, 2)} m"') == ["figure(std, 2)"]
