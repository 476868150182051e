"""What a page from disk holds: the answers to all that it asks."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

HELD = re.compile(r'<script type="application/json" id="frozen">(.*?)</script>', re.S)


def answers_in(page: Path | str) -> dict[str, Any]:
    """The answers of a page, which is a file or its text."""
    text = page if isinstance(page, str) else page.read_text(encoding="utf-8")
    (held,) = HELD.findall(text)
    answers: dict[str, Any] = json.loads(held)["answers"]
    return answers


def texts_in(content: Any) -> str:
    """All texts that are held, in one."""
    return " ".join(_texts(content))


def _texts(content: Any) -> Iterator[str]:
    if isinstance(content, str):
        yield content
    elif isinstance(content, dict):
        for item in content.values():
            yield from _texts(item)
    elif isinstance(content, list):
        for item in content:
            yield from _texts(item)
