"""The form as a page to print: one sheet of A4 without scripts, which needs nothing else."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

from pmmkit.simulation import UNSETTLED
from pmmkit.views.report.bare_page import bare_page
from pmmkit.views.report.imo_form.form import (
    ABSENT,
    BASES,
    STRUCTURE,
    TITLE,
    ImoForm,
    conditions_grid,
    results_grids,
)

STYLE: Final = Path(__file__).with_name("form.css")
PAGE: Final = "imo_form.html"
"""Name of the page; those for machines are called the same."""
SHADES: Final = {
    ABSENT: "absent",
    "met": "met",
    "NOT met": "failed",
    "not judged": "open",
    "not shown": "open",
    UNSETTLED: "open",
}
"""Class of a cell that says a verdict, or that nobody said it."""


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
    return bare_page(
        "imo_form/form.html",
        title=f"{TITLE}: {form.name}",
        style=STYLE.read_text("utf-8"),
        form=form,
        heading=TITLE,
        structure=STRUCTURE,
        basis=BASES[form.basis],
        conditions=conditions_grid(form.conditions),
        results=results_grids(form.lines),
        shades=SHADES,
    )
