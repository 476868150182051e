"""What is told in sentences, tables and figures, as the page reads it, beside what it draws."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

from pmmkit.presentation import Grid, Picture, Section, Symbol


def told_page(
    *,
    facts: Mapping[str, str] = MappingProxyType({}),
    before: Sequence[Section] = (),
    after: Sequence[Section] = (),
    folded: Sequence[Section] = (),
) -> dict[str, Any]:
    """What a place of the page tells beside what it draws, as the page reads it.

    facts: the largest numbers, by what they are. before, after: above and below what is drawn.
    folded: below that, as the command line tells it.
    """
    return {
        "facts": [{"name": name, "value": value} for name, value in facts.items()],
        "before": [_section(item) for item in before],
        "after": [_section(item) for item in after],
        "folded": [_section(item) for item in folded],
    }


def _section(section: Section) -> dict[str, Any]:
    return {
        "title": section.title,
        "paragraphs": list(section.paragraphs),
        "points": list(section.points),
        "findings": [dict(item) for item in section.findings],
        "tables": [_table(item) for item in section.tables],
        "figures": [_figure(item) for item in section.figures],
    }


def _table(table: Grid) -> dict[str, Any]:
    return {
        "head": [_cell(name) for name in table.head],
        "groups": [
            {"title": group.title, "rows": [[_cell(cell) for cell in row] for row in group.rows]}
            for group in table.groups
        ],
        "caption": table.caption,
        "texts": list(table.texts),
    }


def _cell(cell: str | None) -> Any:
    if isinstance(cell, Symbol):
        return {"letter": cell.letter, "below": cell.below}
    return None if cell is None else str(cell)


def _figure(figure: Picture) -> dict[str, Any]:
    return {
        "svg": figure.svg,
        "caption": figure.caption,
        "narrow": figure.narrow,
        "alt": figure.alt or figure.caption,
        "file": f"{figure.file}.svg" if figure.file else "",
    }
