"""From a reduction to the test report, in the order of a standard, and its files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from types import MappingProxyType
from typing import Final

from pmmkit.base import DataError, UnknownNameError, did_you_mean
from pmmkit.campaigns import Campaign
from pmmkit.conventions import cite
from pmmkit.files import atomic_path, write_text
from pmmkit.presentation import Grid
from pmmkit.reduction import Reduction
from pmmkit.views.pages.page_file import bare_page
from pmmkit.views.report.captive import campaign_chapters, result_chapters
from pmmkit.views.report.captive.columns import columns_for
from pmmkit.views.report.captive.document import Document, Item, of_report
from pmmkit.views.report.captive.result_chapters import repeatability

# A test report as one HTML file that opens and prints by itself, on A4 with running heads.


STYLE: Final = Path(__file__).with_name("style.css")
MANY: Final = 6
"""Columns from which on a table has small letters."""
UPRIGHT: Final = 17.4 * 0.56 / 0.64
"""Width of an upright page [cm], less what these letters are wider than those of `columns_of`."""


def html_of(document: Document) -> str:
    """A report as HTML."""
    from markupsafe import Markup

    return bare_page(
        "captive/report.html",
        title=document.title,
        style=STYLE.read_text("utf-8") + _pages(document),
        pictures=True,
        document=document,
        told=lambda section: Markup(section.html(_table)),
    )


def _table(grid: Grid) -> str:
    """A table that is scrolled on a narrow screen, and printed across where its numbers need it."""
    look = "wide" if columns_for(grid, UPRIGHT).fits else "wide across"
    frame = {"class": look, "tabindex": "0"}
    return grid.html("dense" if len(grid.head) >= MANY else "", frame=frame)


def _pages(document: Document) -> str:
    """Size of the pages and what stands in their margins; the cover has none."""
    number = next((item.value for item in document.items if item.key == "number"), None)
    return (
        "@page { size: A4; margin: 22mm 18mm 20mm; "
        f"@top-left {{ content: {_css(document.title)}; font: 8pt sans-serif; color: #5a5a5a; }} "
        f"@top-right {{ content: {_css(number or '')}; font: 8pt sans-serif; color: #5a5a5a; }} "
        '@bottom-right { content: counter(page) " / " counter(pages); font: 8pt sans-serif; } }\n'
        "@page across { size: A4 landscape; }\n"
        '@page :first { @top-left { content: ""; } @top-right { content: ""; } '
        '@bottom-right { content: ""; } }\n'
    )


def _css(text: str) -> str:
    """A text as a string of CSS that cannot end: all but letters, digits and blanks by number."""
    return '"' + "".join(x if x.isalnum() or x == " " else f"\\{ord(x):x} " for x in text) + '"'


# A test report as a file, by its ending.


FORMATS: Final = ("html", "docx")
"""Endings of the files that can be written."""


def check_target(path: str | Path, template: str | Path | None = None) -> str:
    """How a report would be written, before it is made.

    Parameters
    ----------
    path, template : path
        As for `write_report`.

    Returns
    -------
    str
        One of `FORMATS`.

    Raises
    ------
    DataError
        As `write_report`, but for what only filling a template shows.
    """
    name = Path(path).name
    ending = Path(path).suffix.lower().lstrip(".")
    if ending not in FORMATS:
        raise DataError(f"{name}: a report is written as .{' or .'.join(FORMATS)}.")
    if ending == "html" and template is not None:
        raise DataError("A template is a Word document: name an output that ends in .docx.")
    if template is not None and not Path(template).is_file():
        raise DataError(f"There is no template {template}.")
    if ending == "docx":
        try:
            import_module("docxtpl")
        except ImportError as error:
            raise DataError(
                "A document for Word needs docxtpl, which is not installed: pip install "
                "'pmmkit[word]'."
            ) from error
    return ending


def write_document(document: Document, target: Path, *, template: str | Path | None = None) -> None:
    """Write a report, all or nothing; the ending of the name says how.

    template: the laboratory's own document (``.docx``), which is filled.
    """
    if check_target(target, template) == "html":
        write_text(target, html_of(document))
        return
    from pmmkit.views.report.captive.word.build import word_bytes

    content = word_bytes(document, template)
    with atomic_path(target) as part:
        part.write_bytes(content)


STANDARDS: Final[Mapping[str, tuple[Sequence[str], Sequence[str]]]] = MappingProxyType(
    {
        "ittc": (
            ("ittc_7.5-02-06-02", "ittc_7.5-02-06-04"),
            (
                "This report is structured after what the ITTC's recommended procedure "
                "7.5-02-06-02, captive model test, asks a report to document (contents of the "
                "revision of 2017), with uncertainty as 7.5-02-06-04 treats it. It does not claim "
                "to comply with them: who signs it reads the texts in force and compares.",
                "What the campaign file does not say is printed as not supplied, and listed at "
                "the end.",
            ),
        )
    }
)
"""What a report can be structured after, by name.

Keys of the bibliography, the first the one whose order it has, and what the report says of it.
"""
COVER: Final = (
    "number",
    "revision",
    "issued",
    "customer",
    "laboratory",
    "authors",
    "approved_by",
    "tested",
)
"""Keys of ``[report]`` that stand on the cover."""


def captive_document(reduction: Reduction, *, standard: str = "ittc") -> Document:
    """The test report of captive tests.

    Parameters
    ----------
    reduction : Reduction
        As `reduce_campaign` gives it.
    standard : str
        What it is structured after, of `STANDARDS`.

    Returns
    -------
    Document
        Everything that is printed, as data; `write_report` writes it.

    Raises
    ------
    UnknownNameError
        If there is no such standard.
    """
    if standard not in STANDARDS:
        raise UnknownNameError(
            f"There is no standard {standard!r}{did_you_mean(standard, STANDARDS) or '.'} "
            f"There are {', '.join(STANDARDS)}."
        )
    (sources, basis), campaign = STANDARDS[standard], reduction.campaign
    made: Sequence[Item] = [
        Item(what="Analysed with", value=cite("pmmkit")),
        Item(what="Structured after", value=cite(sources[0])),
    ]
    return Document(
        title=campaign.title or campaign.ship.name,
        subtitle="Report of captive model tests",
        items=[*(_dated(item, campaign) for item in of_report(campaign, *COVER)), *made],
        basis=basis,
        chapters=[
            campaign_chapters.technique(reduction),
            campaign_chapters.ship_model(reduction),
            campaign_chapters.facility(reduction),
            campaign_chapters.mount(reduction),
            campaign_chapters.measured(reduction),
            campaign_chapters.programme(reduction),
            campaign_chapters.procedure(reduction),
            repeatability(reduction),
            result_chapters.analysis(reduction),
            result_chapters.derivatives(reduction),
            result_chapters.uncertainty(reduction),
            result_chapters.checks(reduction),
            result_chapters.use(reduction),
            result_chapters.runs(reduction),
            result_chapters.origin(reduction, sources),
        ],
    )


def _dated(item: Item, campaign: Campaign) -> Item:
    """When the tests were made, by the starts of the runs where the report does not say it."""
    days = sorted(run.started[:10] for run in campaign.runs if run.started)
    if item.key != "tested" or item.value is not None or not days:
        return item
    return replace(item, value=days[0] if days[0] == days[-1] else f"{days[0]} to {days[-1]}")
