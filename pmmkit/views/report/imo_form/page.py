"""The form as a page to print: one sheet of A4 without scripts, which needs nothing else."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Final

from pmmkit.base import __version__
from pmmkit.presentation import Cell, Grid, html_text
from pmmkit.simulation import UNSETTLED
from pmmkit.views.report.bare_page import bare_page
from pmmkit.views.report.imo_form.form import (
    ABSENT,
    BASES,
    STRUCTURE,
    TITLE,
    FormField,
    ImoForm,
    conditions_grid,
    results_grids,
)

STYLE: Final = Path(__file__).with_name("form.css")
PAGE: Final = "imo_form.html"
"""Name of the page; those for machines are called the same."""
CELL: Final = '<{kind} class="{names}">{text}</{kind}>'
SHADES: Final = {
    "met": "met",
    "NOT met": "failed",
    "not judged": "open",
    "not shown": "open",
    UNSETTLED: "open",
}
"""Class of a cell that says a verdict."""


def form_files(form: ImoForm) -> Iterator[tuple[str, Any]]:
    """The form with the names of its files: to print, and for machines.

    Parameters
    ----------
    form : ImoForm
        The form.
    """
    name = Path(PAGE).stem
    yield PAGE, form_html(form)
    yield f"{name}.csv", form.to_pandas()
    yield f"{name}.json", form.to_dict()


def form_html(form: ImoForm) -> str:
    """The form as HTML."""
    style = STYLE.read_text("utf-8")
    return bare_page(f"{TITLE}: {form.name}", style, f"<main>\n{_body(form)}</main>\n")


def _body(form: ImoForm) -> str:
    heads = [group for heading, group in form.groups if not heading]
    blocks = [
        f"<section><h2>{html_text(heading)}</h2>{_fields(group)}</section>"
        for heading, group in form.groups
        if heading
    ]
    parts = [
        f"<header><h1>{html_text(TITLE)}: {html_text(form.name)}</h1>"
        f'<p class="structure">{html_text(STRUCTURE)}</p>'
        + "".join(_fields(group) for group in heads)
        + "</header>",
        f'<div class="blocks">{"".join(blocks)}</div>',
        f"<section><h2>Conditions</h2>{_table(conditions_grid(form.conditions))}</section>",
        f"<section><h2>Results, {html_text(BASES[form.basis])}</h2>"
        f'<p class="verdict">{html_text(_sentence(form.verdict))}</p>'
        + "".join(map(_table, results_grids(form.lines)))
        + "".join(f'<p class="assumed">{html_text(text)}</p>' for text in form.assumptions)
        + "</section>",
    ]
    if form.corrections is not None:
        parts.append(
            "<section><h2>Correction to full load</h2>"
            "<p>T as measured, B and F as predicted in the condition of the trial and at full "
            f"load.</p>{_table(form.corrections)}</section>"
        )
    if form.remarks:
        points = "".join(f"<li>{html_text(text)}</li>" for text in form.remarks)
        parts.append(f"<section><h2>Remarks</h2><ul>{points}</ul></section>")
    missing = html_text("; ".join(form.not_supplied) or "nothing")
    parts.append(f'<section><h2>Not supplied</h2><p class="absent">{missing}</p></section>')
    scale = f"Scale: {html_text(form.scale)}. " if form.scale else ""
    parts.append(f"<footer>{scale}Made by pmmkit {__version__}.</footer>")
    return "\n".join(parts) + "\n"


def _sentence(text: str) -> str:
    return f"{text[:1].upper()}{text[1:]}."


def _fields(entries: tuple[FormField, ...]) -> str:
    rows = "".join(
        f"<div><dt>{html_text(item.title)}</dt>{_cell('dd', item.shown)}</div>" for item in entries
    )
    return f"<dl>{rows}</dl>"


def _table(grid: Grid) -> str:
    left = {0, *grid.texts}

    def cells(kind: str, row: Sequence[Cell]) -> str:
        return "".join(_cell(kind, cell, left=place in left) for place, cell in enumerate(row))

    body = "".join(f"<tr>{cells('td', row)}</tr>" for group in grid.groups for row in group.rows)
    return f"<table><thead><tr>{cells('th', grid.head)}</tr></thead><tbody>{body}</tbody></table>"


def _cell(kind: str, text: Cell, *, left: bool = False) -> str:
    """A cell, with a class for where it stands and for what verdict it says."""
    names = ["left"] if left else []
    if text == ABSENT:
        names.append("absent")
    elif text in SHADES:
        names.append(SHADES[text])
    return CELL.format(kind=kind, names=" ".join(names), text=html_text(text or ""))
