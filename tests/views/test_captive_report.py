"""The test report of captive tests: what it states, what it says is missing, how it is written."""

from __future__ import annotations

import json
import re
import sys
import tomllib
import zipfile
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import get_args

import pytest

import pmmkit as pk
from pmmkit import save_campaign
from pmmkit.actions.jobs import report as command
from pmmkit.base import CampaignError, DataError, UnknownNameError
from pmmkit.campaigns import CampaignFile, campaign_of
from pmmkit.cli import main
from pmmkit.exports.campaign_csv import campaign_text
from pmmkit.plotting import Figure
from pmmkit.presentation import Grid, Group, Section, Symbol
from pmmkit.views import captive_document, write_report
from pmmkit.views.figures.captions import drawn
from pmmkit.views.report.captive.build import FORMATS, STANDARDS, html_of
from pmmkit.views.report.captive.columns import columns_of
from pmmkit.views.report.captive.document import NOT_SUPPLIED, Chapter, Document, Item

HOSTILE = '"; } @import url(x)</style></title><script>alert(1)</script>{{ 7*7 }}{% raise %}&'
"""A text that would end a string, a style, an element, or be a field of a template."""


@pytest.fixture(scope="module")
def drift():
    """Static drift of the S175 at one speed, of which the campaign file says little."""
    tests = pk.open_campaign("datasets/s175")
    runs = tests.select("static_drift").runs
    return tests.with_(runs=tuple(run for run in runs if run.settings.speed == 1.5))


@pytest.fixture(scope="module")
def reduced(drift):
    wanted = ["Xuu", "Xvv", "Yv", "Yvvv", "Nv", "Nvvv"]
    return pk.reduce_campaign(drift, structure=wanted, executor=1)


@pytest.fixture(scope="module")
def told(reduced):
    return captive_document(reduced)


@pytest.fixture
def small():
    """A report by hand: a cover, a table with a derivative, a figure."""
    figure = Figure(height=1.0, width=2.0)
    figure.subplots().plot([0.0, 1.0], [0.0, 1.0], color="#000000")
    table = Grid(
        head=["", "Fn 0.2"],
        groups=[Group(title="Yaw", rows=[[Symbol("N′", "vvr"), "-49.9 ± 1.0"], ["Nr", None]])],
        caption="Values",
    )
    finding = {"severity": "warning", "check": "signs", "message": "m", "runs": "", "remedy": ""}
    return Document(
        title=HOSTILE,
        subtitle="Captive tests",
        items=[
            Item(what="Customer", value=HOSTILE, table="report", key="customer"),
            Item(what="Number", value=None, table="report", key="number"),
        ],
        basis=["Structured after something."],
        chapters=[
            Chapter(
                title="Derivatives",
                sections=[
                    Section(
                        paragraphs=[HOSTILE],
                        findings=[finding],
                        tables=[table],
                        figures=[drawn(figure, "A line")],
                    )
                ],
            ),
            Chapter(title="Runs", appendix=True),
        ],
    )


def items_of(document):
    return [*document.items, *(item for chapter in document.chapters for item in chapter.items)]


class Read(HTMLParser):
    """Elements that were opened and not closed, and all texts."""

    def __init__(self, text):
        super().__init__()
        self.open, self.seen, self.texts = [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.seen.append((tag, dict(attrs)))
        if tag not in ("meta", "img", "br"):
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open[-1:] != ["style"]:
            self.texts.append(data)


@pytest.mark.slow
def test_every_key_of_the_table_report_is_printed_in_one_place(told):
    printed = [item.key for item in items_of(told) if item.table == "report"]
    assert sorted([*printed, "gauges"]) == sorted(CampaignFile.keys_of("report"))
    assert sum(item.table == "report.gauges.NAME" for item in items_of(told)) == 1


@pytest.mark.slow
def test_what_the_campaign_does_not_say_is_printed_and_listed_with_its_key(told):
    (lacks,) = (x for _, x in told.numbered if x.title == "What was not supplied")
    (table,) = lacks.sections[0].tables
    listed = [tuple(row) for group in table.groups for row in group.rows]
    silent = [item for item in items_of(told) if item.text == NOT_SUPPLIED]
    assert listed == [(item.what, item.supply) for item in silent]
    assert all(item.supply for item in silent)
    assert "[water] nu" in dict(listed).values()
    assert "[uncertainty] mass" in dict(listed).values()
    assert "[uncertainty] drift_deg" not in dict(listed).values()  # it is stated
    assert "[uncertainty] amplitude_m" not in dict(listed).values()  # nothing oscillates


@pytest.mark.slow
def test_what_is_supplied_stands_in_the_report_and_leaves_the_list(reduced):
    report = {"customer": "A yard", "scale": 36.0, "authors": ["A", "B"], "propeller_fitted": "no"}
    gauge = {"gauges": {"Y1": {"capacity": "500 N", "calibrated": "2026-05-04"}}}
    first, second, *others = reduced.campaign.runs
    timed = (
        first.with_(started="2026-05-04T09:00:00"),
        second.with_(started="2026-05-05T09:20:00"),
    )
    campaign = reduced.campaign.with_(report=report | gauge, runs=(*timed, *others))
    document = captive_document(replace(reduced, campaign=campaign))
    values = {item.supply: item.value for item in items_of(document)}
    assert values["[report] customer"] == "A yard"
    assert values["[report] scale"] == "36"
    assert values["[report] authors"] == "A, B"
    assert values["[report.gauges.Y1] calibrated"] == "2026-05-04"
    assert values["[report.gauges.Y1] certificate"] is None
    assert values["[report] tested"] == "2026-05-04 to 2026-05-05"
    assert values["[[runs]] started"] == "87600 at least, median 87600"
    assert "[propeller]" not in values  # none is fitted: no particulars are asked for
    assert values["[rudder]"] is None


@pytest.mark.slow
def test_chapters_stand_in_the_order_of_the_procedure_and_claim_no_compliance(told):
    assert [chapter.title for _, chapter in told.numbered][:5] == [
        "Experimental technique",
        "Ship model",
        "Facility",
        "Carriage and mount",
        "Measured data",
    ]
    basis = " ".join(told.basis)
    assert "structured after" in basis
    assert "does not claim to comply" in basis
    assert "complies" not in str(told)


@pytest.mark.slow
def test_the_budget_adds_up_by_source_and_by_test(told):
    (chapter,) = (x for x in told.chapters if x.title == "Uncertainty")
    (section,) = (x for x in chapter.sections if x.title == "Where the uncertainty comes from")
    by_source, by_test = section.tables
    for table in (by_source, by_test):
        shares, (together, *_) = table.groups[0].rows, table.groups[1].rows
        assert set(together[3:]) == {"100.0 %"}
        for column in range(3, len(together)):
            whole = sum(float(row[column].removesuffix(" %")) for row in shares)
            assert whole == pytest.approx(100.0, abs=0.05 * len(shares))
    assert ["noise, repeats and misfit", "A", "precision"] in [
        list(row[:3]) for row in by_source.groups[0].rows
    ]
    assert ["static drift", "A, B", "precision"] in [list(x[:3]) for x in by_test.groups[0].rows]
    assert "Not stated, so not in the budget: " in section.paragraphs[1]


def test_a_page_prints_what_is_there_and_lets_nothing_run_or_load(small):
    page = html_of(small)
    read = Read(page)
    assert read.open == []
    tags = {tag for tag, _ in read.seen}
    assert not tags & {"script", "link", "iframe", "object", "svg"}
    assert "".join(read.texts).count(HOSTILE) == 4  # title, heading, customer, paragraph
    style = page[page.index("<style>") : page.index("</style>")]
    assert "@import" not in style
    (policy,) = (x["content"] for _, x in read.seen if "http-equiv" in x)
    assert policy.startswith("default-src 'none'; style-src 'sha256-")
    (picture,) = (x for tag, x in read.seen if tag == "img")
    assert picture["src"].startswith("data:image/svg+xml;base64,")
    assert picture["alt"]
    assert "N′\N{WORD JOINER}<sub>vvr</sub>" in page
    assert f'class="text lack">{NOT_SUPPLIED}' in page


def test_the_same_report_gives_the_same_page(small):
    assert html_of(small) == html_of(small)


def campaign_with(report):
    text = Path("datasets/s175/campaign.toml").read_text(encoding="utf-8")
    raw = tomllib.loads(text)
    entries = tomllib.loads(report)
    place = Path("datasets/s175/campaign.toml").absolute()
    return campaign_of(raw | entries | {"runs": raw["runs"][:1]}, place)


def test_dates_are_written_with_quotes_or_without():
    text = '[report]\nissued = 2026-05-04\ntested = "in May"\nauthors = "A"\n[report.gauges.Y]\n'
    campaign = campaign_with(f"{text}calibrated = 2026-04-01\n")
    assert dict(campaign.report) == {
        "issued": "2026-05-04",
        "tested": "in May",
        "authors": ["A"],
        "gauges": {"Y": {"calibrated": "2026-04-01"}},
    }


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('[report]\ncustomr = "A"', "customer"),
        ("[report]\nscale = -36.0", "greater than 0"),
        ('[report.gauges.Y]\ncapcity = "5 N"', "capacity"),
    ],
)
def test_a_mistyped_key_is_answered_with_the_nearest(text, said):
    with pytest.raises(CampaignError, match=said):
        campaign_with(text)


def test_what_is_stated_survives_saving_and_exporting(tmp_path):
    campaign = campaign_with('[report]\ncustomer = "A"\n[report.gauges.Y]\ncapacity = "5 N"')
    save_campaign(campaign, tmp_path / "saved.h5")
    assert pk.open_campaign(tmp_path / "saved.h5").report == campaign.report
    written = tomllib.loads(campaign_text(campaign, {}))
    assert written["report"] == {"customer": "A", "gauges": {"Y": {"capacity": "5 N"}}}


def test_the_command_names_the_standards_and_formats_that_there_are():
    assert set(get_args(command.Standard)) == set(STANDARDS)
    assert set(get_args(command.Format)) == set(FORMATS)
    with pytest.raises(UnknownNameError, match="ittc"):
        captive_document(None, standard="itcc")


@pytest.mark.slow
def test_a_report_is_written_by_one_command(drift, tmp_path, capsys):
    save_campaign(drift.with_(title="Drift"), tmp_path / "drift.h5")
    file = tmp_path / "out.html"
    asked = ["report", str(tmp_path / "drift.h5"), "--workers", "1", "--json", "-o", str(file)]
    assert main([*asked, "--structure", "Xuu Xvv Yv Yvvv Nv Nvvv"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["file"] == str(file)
    assert {"chapter": "Cover", "item": "Customer", "key": "[report] customer"} in told[
        "not_supplied"
    ]
    assert Read(file.read_text(encoding="utf-8")).open == []


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["-o", "report.pdf"], "written as .html or .docx"),
        (["-o", "report.html", "--template", "lab.docx"], "A template is a Word document"),
        (["--template", "absent.docx"], "There is no template absent.docx"),
        (["--to", "docx"], r"pip install 'pmmkit\[word\]'"),
    ],
)
def test_what_cannot_be_written_is_said_before_the_tests_are_reduced(
    options, said, tmp_path, monkeypatch, capsys
):
    monkeypatch.setitem(sys.modules, "docxtpl", None)
    campaign = str(Path("datasets/s175").absolute())
    monkeypatch.chdir(tmp_path)
    assert main(["report", campaign, *options]) == 1
    assert re.search(said, capsys.readouterr().err)
    assert not list(tmp_path.iterdir())


def test_free_running_records_have_another_report(tmp_path, capsys, drift):
    sailed = drift.with_(kind="free-running", runs=drift.runs[:1])
    save_campaign(sailed, tmp_path / "sailed.h5")
    assert main(["report", str(tmp_path / "sailed.h5"), "-o", str(tmp_path / "x.html")]) == 1
    assert "pmmkit trial" in capsys.readouterr().err


def words_of(path):
    """The text of a Word document, and the names of its parts."""
    docx = pytest.importorskip("docx")
    file = docx.Document(path)
    cells = [cell.text for table in file.tables for row in table.rows for cell in row.cells]
    return [*(item.text for item in file.paragraphs), *cells], file


@pytest.mark.slow
def test_word_holds_the_same_and_the_same_bytes_twice(small, tmp_path):
    pytest.importorskip("docxtpl", reason="docxtpl is not installed")
    first, second = tmp_path / "a.docx", tmp_path / "b.docx"
    write_report(small, first)
    write_report(small, second)
    assert first.read_bytes() == second.read_bytes()
    told, file = words_of(first)
    for text in (HOSTILE, "1 Derivatives", "A Runs", "N′vvr", NOT_SUPPLIED, "Figure 1. A line"):
        assert text in told
    assert len(file.inline_shapes) == 1
    assert "w:tblHeader" in zipfile.ZipFile(first).read("word/document.xml").decode()


@pytest.mark.slow
def test_tables_that_are_too_wide_lie_across_and_the_next_page_is_upright(small, tmp_path):
    pytest.importorskip("docxtpl", reason="docxtpl is not installed")
    row = ["Yvvv", *["-21.87 ± 0.71"] * 15]
    wide = Grid(head=["", *["Fn 0.200"] * 15], groups=[Group(rows=[row] * 40)], caption="Wide")
    (first, *others) = small.chapters
    tables = [wide, replace(wide, caption="Another"), first.sections[0].tables[0]]
    section = replace(first.sections[0], tables=tables)
    document = replace(small, chapters=[replace(first, sections=[section]), *others])
    write_report(document, tmp_path / "out.docx")
    assert html_of(document).count('class="wide across"') == 2
    _, file = words_of(tmp_path / "out.docx")
    across = [page.page_width > page.page_height for page in file.sections]
    assert across == [False, True, False]
    whole = file.sections[1].page_width - 2 * file.sections[1].left_margin
    assert sum(column.width for column in file.tables[1].columns) <= whole


def test_columns_keep_numbers_whole_and_break_texts_between_words():
    long = "value for value a copy of run 279 at beta = 12; the run at beta = 16 is not there " * 3
    rows = [["YD_279_b16", "-1234.5 ± 0.9", long]]
    found = columns_of(["Run", "Y [N]", "Because"], rows, texts={0, 2}, width=16.5)
    assert found.fits
    assert sum(found.widths) == pytest.approx(16.5)
    for text, width in zip(rows[0][:2], found.widths, strict=False):
        assert width > len(text) * 0.3 * found.size * 2.54 / 72


@pytest.mark.slow
def test_a_laboratory_s_template_is_filled_and_nothing_of_the_campaign_is_a_field(small, tmp_path):
    pytest.importorskip("docxtpl", reason="docxtpl is not installed")
    import docx

    template = docx.Document()
    template.add_paragraph("For {{ report.customer }}, number {{ report.number }}")
    template.add_paragraph("{{ body }}")
    template.add_paragraph("Signed")
    template.save(tmp_path / "lab.docx")
    write_report(small, tmp_path / "out.docx", template=tmp_path / "lab.docx")
    told, _ = words_of(tmp_path / "out.docx")
    assert told[0] == f"For {HOSTILE}, number {NOT_SUPPLIED}"
    assert told.index("1 Derivatives") < told.index("Signed")


@pytest.mark.slow
def test_a_template_that_is_damaged_or_asks_for_more_is_refused(small, tmp_path):
    pytest.importorskip("docxtpl", reason="docxtpl is not installed")
    import docx

    damaged, curious = tmp_path / "damaged.docx", tmp_path / "curious.docx"
    damaged.write_bytes(b"PK\x03\x04 no document")
    asking = docx.Document()
    asking.add_paragraph("{{ title.__class__.__mro__[1].__subclasses__() }}")
    asking.save(curious)
    for template in (damaged, curious):
        with pytest.raises(DataError, match="cannot be filled"):
            write_report(small, tmp_path / "out.docx", template=template)
    assert not (tmp_path / "out.docx").exists()
