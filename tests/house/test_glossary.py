"""The words of the glossary are in use, and in order."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "glossary.md"
ROWS = re.findall(r"^\| ([\w ]+) \| (.+) \| (.+) \|$", PAGE.read_text(encoding="utf-8"), re.M)[1:]
TEXT = "\n".join(
    path.read_text(encoding="utf-8")
    for path in (*(ROOT / "pmmkit").rglob("*.py"), *(ROOT / "docs").glob("*.md"))
    if path != PAGE
)


@pytest.mark.parametrize("word", [word for word, _, _ in ROWS])
def test_a_word_is_used(word):
    """Whole, or with an ending: mimic, mimics; floor, --floor, floor_share."""
    assert re.search(rf"(?<![A-Za-z]){word}(?:s|ed|_\w+)?(?![A-Za-z])", TEXT)


def test_words_stand_once_and_in_order():
    words = [word for word, _, _ in ROWS]
    assert len(words) > 20
    assert words == sorted(set(words))
