"""Parts of a page that the program writes, between two marks."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

DOCS = Path(__file__).parents[2] / "docs"


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table of a page."""
    rule = "|" + "---|" * len(head)
    lines = [f"| {' | '.join(_cell(text) for text in cells)} |" for cells in (head, *rows)]
    return "\n".join([lines[0], rule, *lines[1:]])


def _cell(text: str) -> str:
    """A text with its bars escaped, which would end the cell."""
    return text.replace("|", r"\|")


def page(name: str, made: Mapping[str, Callable[[], str]]) -> str:
    """A page of docs/ with what is made between its marks, by the word of each mark."""
    text = (DOCS / name).read_text(encoding="utf-8")
    for mark, make in made.items():
        fence = re.compile(rf"(<!-- {mark}:.*? -->\n).*?(<!-- end of {mark} -->)", re.S)
        text, count = fence.subn(lambda found, make=make: f"{found[1]}{make()}\n{found[2]}", text)
        assert count == 1, f"docs/{name} has no place for {mark}"
    return text
