"""One content, four writers: text, HTML, Word and the page's JSON tell the same."""

from __future__ import annotations

import html
import io
import json
import re
import zipfile

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pmmkit.plotting import Figure
from pmmkit.presentation import Grid, Group, Picture, Section, Symbol, aligned, text_of
from pmmkit.views.pages.sections import told_page
from pmmkit.views.report.captive.build import html_of
from pmmkit.views.report.captive.document import Chapter, Document

SECTION = Section(
    title="Derivatives",
    paragraphs=["Cycles < 3 & more were left out."],
    points=["One run says little."],
    findings=[
        {
            "severity": "warning",
            "check": "signs",
            "message": "Y turns.",
            "runs": "SD_4",
            "remedy": "Look at the gauge.",
        }
    ],
    tables=[
        Grid(
            head=["name", "Fn 0.2"],
            groups=[Group(title="Yaw", rows=[[Symbol("N′", "vvr"), "-49.9 ± 1.0"], ["Nr", None]])],
            caption="All values times 10³.",
        )
    ],
    figures=[Picture(figure=Figure(), caption="Values over the speed.", alt="Four lines.")],
)
TOLD = (
    *("Derivatives", "Cycles < 3 & more were left out.", "One run says little."),
    *("warning", "signs", "Y turns.", "SD_4", "Look at the gauge."),
    *("name", "Fn 0.2", "Yaw", "N′vvr", "-49.9 ± 1.0", "Nr", "–", "All values times 10³."),
    "Values over the speed.",
)


def as_text():
    return text_of([SECTION])


def as_html():
    return html.unescape(re.sub(r"<[^>]*>|\u2060", "", SECTION.html()))


def as_report():
    """The report's HTML: tables are framed, and the rest is the same."""
    chapter = Chapter(title="Results", sections=[SECTION])
    page = html_of(Document(title="T", subtitle="", items=[], basis=[], chapters=[chapter]))
    return html.unescape(re.sub(r"<[^>]*>|\u2060", "", page))


def as_word():
    pytest.importorskip("docx")
    from pmmkit.views.report.captive.word.build import word_bytes

    chapter = Chapter(title="Results", sections=[SECTION])
    made = word_bytes(Document(title="T", subtitle="", items=[], basis=[], chapters=[chapter]))
    with zipfile.ZipFile(io.BytesIO(made)) as parts:
        return html.unescape(re.sub(r"<[^>]*>", "", parts.read("word/document.xml").decode()))


def as_page():
    """A derivative comes in its two parts, and None is drawn as a dash by the page."""
    found = json.dumps(told_page(after=[SECTION]), ensure_ascii=False)
    return found.replace('{"letter": "N′", "below": "vvr"}', "N′vvr").replace("null", "–")


@pytest.mark.parametrize("written", [as_text, as_html, as_report, as_word, as_page])
def test_every_writer_tells_all_that_a_section_holds(written):
    page = written()
    assert [text for text in TOLD if text not in page] == []


CELLS = st.text(st.characters(blacklist_categories=("Cs", "Cc")), max_size=6)


@given(st.lists(st.lists(CELLS, min_size=2, max_size=2), min_size=1, max_size=4))
def test_no_text_of_a_cell_becomes_an_element(rows):
    made = Grid(head=["", ""], groups=[Group(rows=rows)]).html()
    kinds = set(re.findall(r"</?(\w+)", made))
    assert kinds <= {"table", "tbody", "tr", "td"}


def test_columns_stand_below_each_other_on_a_terminal():
    """A dot above a letter takes no place of its own, a letter of Japanese two."""
    lines = aligned(["", "Y"], [["Y′v\u0307", "-7.1"], ["Y′v", "-11.6"], ["横力", "2"]]).split("\n")
    assert lines == ["          Y", "Y′v\u0307    -7.1", "Y′v   -11.6", "横力      2"]
