"""Workbooks as people keep them: titles, units, merged cells, dates; and workbooks that lie."""

from __future__ import annotations

import datetime as dt
import io
import re
import struct
import zipfile
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import openpyxl
import pytest
from container_files import (
    TOML,
    cells,
    check_damage,
    headers,
    little_memory,
    run_of,
    series,
    values,
)

from pmmkit import open_campaign
from pmmkit.base import CampaignError
from pmmkit.readers import READERS, Options, Request

COUNT = 30
HEADER = ["t", "X", "Y", "N"]
SHEET = "xl/worksheets/sheet1.xml"


def rows() -> list[list[Any]]:
    data = series(COUNT)
    return [[float(data[name][place]) for name in HEADER] for place in range(COUNT)]


def workbook(path: Path, lines: Sequence[Sequence[Any]], *merged: str, sheet: str = "Run") -> Path:
    book = openpyxl.Workbook()
    page = book.active
    page.title = sheet
    for line in lines:
        page.append(list(line))
    for cells_ in merged:
        page.merge_cells(cells_)
    book.save(path)
    return path


@pytest.fixture
def path(tmp_path) -> Path:
    return tmp_path / "run.xlsx"


def check(path: Path, top: str = "", factor: float = 1.0) -> None:
    """The history is the one of `series`, of which a workbook keeps 16 digits."""
    data, truth = run_of(path, top), series(COUNT)
    for name in HEADER:
        expected = truth[name] * (1.0 if name == "t" else factor)
        assert np.allclose(data[name].values, expected, rtol=1e-14, atol=0)


TITLE = [["Towing tank"], [], ["Model", "S175", "Date", dt.date(2024, 5, 1)], ["Scale", 36], []]


@pytest.mark.parametrize(
    "above",
    [[], [[]], TITLE, [["PMM tests", "of", "the", "S175"]], [["a", "b", "c", "d"], TITLE[3]]],
    ids=["none", "empty row", "title block", "title as wide as the table", "two title rows"],
)
def test_the_header_is_found_below_what_stands_above_it(path, above):
    check(workbook(path, [*above, HEADER, *rows()]))


def test_a_row_of_units_goes_into_the_names(path):
    workbook(path, [*TITLE, HEADER, ["s", "kN", "kN", "kNm"], *rows()])
    assert headers(path) == ("t [s]", "X [kN]", "Y [kN]", "N [kNm]")
    check(path, factor=1000.0)
    workbook(path, [HEADER, ["[s]", "(kN)", "[kN]", "[kNm]"], [], *rows()])
    check(path, factor=1000.0)


def test_a_logo_that_moves_the_table_to_the_right(path):
    shifted = [["", "", *line] for line in [HEADER, *rows()]]
    workbook(
        path, [["LOGO"], [None, None, "Test 12"], *[[None, None, *line[2:]] for line in shifted]]
    )
    check(path)


def test_names_over_two_merged_rows_and_groups_of_names(path):
    """t over both rows; two groups that each have X and Y."""
    lines = [
        ["t", "Fore", None, "Aft", None, "N"],
        [None, "X", "Y", "X", "Y", None],
        *([line[0], line[1], line[2], -1.0, -2.0, line[3]] for line in rows()),
    ]
    workbook(path, lines, "A1:A2", "B1:C1", "D1:E1", "F1:F2")
    assert headers(path) == ("t", "Fore X", "Fore Y", "Aft X", "Aft Y", "N")
    check(path, '[columns]\nX = "Fore X"\nY = "Fore Y"\n')


def test_a_title_merged_over_the_whole_table_is_no_header(path):
    check(workbook(path, [["Run 12"], HEADER, *rows()], "A1:D1"))


def test_a_table_of_tests_with_settings_merged_over_rows(tmp_path):
    lines = [
        ["Static drift", None, None, None],
        ["Run No.", "Speed", "beta", "Y"],
        ["-", "m/s", "deg", "N"],
        *([100 + n, None if n else 1.5, 2.0 * n, 3.0 * n] for n in range(4)),
        *([200 + n, None if n else 2.5, 2.0 * n, 5.0 * n] for n in range(2)),
    ]
    workbook(tmp_path / "tests.xlsx", lines, "B4:B7", "B8:B9", "A1:D1")
    table = '[[tables]]\nid = "SD_{Run No.}"\ntest = "static_drift"\nfile = "tests.xlsx"\n'
    table += 'columns = { speed = "Speed", drift_deg = "beta", Y = "Y" }\n'
    (tmp_path / "campaign.toml").write_text(TOML + table, encoding="utf-8")
    campaign = open_campaign(tmp_path)
    assert [run.id for run in campaign.runs] == [f"SD_{n}" for n in (100, 101, 102, 103, 200, 201)]
    assert [run.settings.speed for run in campaign.runs] == [1.5] * 4 + [2.5] * 2
    assert campaign["SD_103"].data["Y"] == 9.0


def test_texts_and_dates_of_a_table_stay_texts(path):
    day = dt.datetime(2024, 5, 1, 14, 30)
    workbook(path, [["Run", "Date", "Remark", "Y"], ["SD1", day, "calm", 1.0], ["SD2", day, "", 2]])
    table = cells(path)
    assert table.headers == ("Run", "Date", "Remark", "Y")
    assert table.rows[0] == ("SD1", "2024-05-01 14:30:00", "calm", 1.0)
    assert table.lines == (2, 3)


@pytest.mark.parametrize(
    "times",
    [
        [dt.datetime(2024, 5, 1, 23, 59, 50) + dt.timedelta(seconds=2 * n) for n in range(COUNT)],
        [dt.timedelta(seconds=2 * n) for n in range(COUNT)],
        [(dt.datetime(2024, 1, 1) + dt.timedelta(seconds=2 * n)).time() for n in range(COUNT)],
    ],
    ids=["dates", "durations", "times of day"],
)
def test_times_of_a_history_are_seconds(path, times):
    workbook(path, [HEADER, *([time, *row[1:]] for time, row in zip(times, rows(), strict=True))])
    data = run_of(path)
    assert np.allclose(data["t"].values, 2.0 * np.arange(COUNT), rtol=0, atol=1e-3)
    assert "times as seconds" in data.attrs["conversions"]


def test_formulas_give_what_was_last_computed(path):
    """openpyxl writes formulas without values; a value is put beside one as Excel does."""
    lines = rows()
    workbook(path, [HEADER, *lines])
    parts = parts_of(path)
    stored = f"<v>{lines[4][1]:.16g}</v>".encode()
    assert parts[SHEET].count(stored) == 1
    parts[SHEET] = parts[SHEET].replace(stored, b"<f>SUM(A1:A3)</f>" + stored)
    pack(path, parts)
    check(path)


def pack(path: Path, parts: dict[str, bytes]) -> None:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in parts.items():
            how = zipfile.ZIP_STORED if name == "mimetype" else zipfile.ZIP_DEFLATED
            archive.writestr(name, content, how)


def parts_of(path: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def shared(parts: dict[str, bytes], text: bytes, doctype: bytes = b"") -> dict[str, bytes]:
    """The same workbook with all its texts moved to the one that its cells share."""
    space = b"http://schemas.openxmlformats.org/"
    sst = b'<sst xmlns="%sspreadsheetml/2006/main"><si><t>%s</t></si></sst>' % (space, text)
    relation = (
        b'<Relationship Id="rIdS" Type="%sofficeDocument/2006/relationships/sharedStrings" '
        b'Target="sharedStrings.xml"/></Relationships>' % space
    )
    relations = "xl/_rels/workbook.xml.rels"
    cell = re.compile(rb't="inlineStr"><is><t>[^<]*</t></is></c>')
    return {
        **parts,
        SHEET: cell.sub(b't="s"><v>0</v></c>', parts[SHEET]),
        "xl/sharedStrings.xml": doctype + sst,
        relations: parts[relations].replace(b"</Relationships>", relation),
    }


@pytest.fixture
def two_sheets(path) -> Path:
    book = openpyxl.Workbook()
    book.active.title = "Cover"
    book.active["A1"] = "Towing tank"
    page = book.create_sheet("Run 12")
    for line in [HEADER, *rows()]:
        page.append(line)
    book.save(path)
    return path


def test_sheets_are_chosen_by_name_or_number(two_sheets):
    for sheet in ('"Run 12"', "2"):
        check(two_sheets, f"[source]\nsheet = {sheet}\n")
    with pytest.raises(CampaignError, match=r"2 sheets \(1 'Cover', 2 'Run 12'\)"):
        headers(two_sheets)
    with pytest.raises(CampaignError, match=r"no sheet 'run 12'; did you mean 'Run 12'"):
        headers(two_sheets, sheet="run 12")
    with pytest.raises(CampaignError, match=r"no sheet 3\. The workbook has 1 'Cover', 2 'Run 12'"):
        headers(two_sheets, sheet=3)


def test_where_no_row_can_be_the_header_it_is_asked_for(path):
    workbook(path, [["only one"], *rows()])
    with pytest.raises(CampaignError, match=r"numbers begin in row 2.*header = true"):
        headers(path)
    assert headers(path, header=True)[0] == "only one"
    workbook(path, rows())
    assert headers(path) == ("",) * 4
    assert values(path, header=False)[""].shape == (COUNT,)
    check(path, "[columns]\nt.column = 1\nX.column = 2\nY.column = 3\nN.column = 4\n")


def test_numbers_above_the_header_are_an_error_and_not_lost(path):
    """A table above the table: its numbers are rows of the sheet too."""
    workbook(path, [["a", "b"], [1.0, 2.0], [], HEADER, *rows()])
    with pytest.raises(CampaignError, match=r"'X' is not a number"):
        run_of(path, '[columns]\nt = "a"\nX = "b"\nY = false\nN = false\n')


def ods(path: Path, body: str) -> Path:
    """An OpenDocument sheet, as small as can be."""
    space = "urn:oasis:names:tc:opendocument:xmlns"
    content = (
        f'<?xml version="1.0" encoding="UTF-8"?><office:document-content '
        f'xmlns:office="{space}:office:1.0" xmlns:table="{space}:table:1.0" '
        f'xmlns:text="{space}:text:1.0"><office:body><office:spreadsheet>'
        f'<table:table table:name="Run">{body}</table:table>'
        f"</office:spreadsheet></office:body></office:document-content>"
    )
    mark = "application/vnd.oasis.opendocument.spreadsheet"
    manifest = (
        f'<manifest:manifest xmlns:manifest="{space}:manifest:1.0"><manifest:file-entry '
        f'manifest:full-path="/" manifest:media-type="{mark}"/></manifest:manifest>'
    )
    parts = {"mimetype": mark, "content.xml": content, "META-INF/manifest.xml": manifest}
    pack(path, {name: text.encode() for name, text in parts.items()})
    return path


def ods_row(line: Sequence[Any], repeated: int = 1) -> str:
    inside = "".join(
        f'<table:table-cell office:value-type="float" office:value="{cell!r}"><text:p>{cell}'
        "</text:p></table:table-cell>"
        if isinstance(cell, float)
        else '<table:table-cell office:value-type="string">'
        f"<text:p>{cell}</text:p></table:table-cell>"
        for cell in line
    )
    end = '<table:table-cell table:number-columns-repeated="16380"/>'
    return (
        f'<table:table-row table:number-rows-repeated="{repeated}">{inside}{end}</table:table-row>'
    )


BLANK = ods_row([], 1_048_000)


def test_a_sheet_of_libreoffice_with_its_empty_tail(tmp_path):
    path = ods(tmp_path / "run.ods", "".join(map(ods_row, [["Title"], HEADER, *rows()])) + BLANK)
    check(path)


def test_recognised_by_content(path, tmp_path):
    workbook(path, [HEADER, *rows()])
    ods(tmp_path / "run.ods", ods_row(["a"]))
    for file in (path, tmp_path / "run.ods"):
        assert READERS["excel"].recognises(file, file.read_bytes()[:65536])
    other = io.BytesIO()
    with zipfile.ZipFile(other, "w") as archive:
        archive.writestr("run.csv", "t,X\n")
    for head in (b"", b"t,X\n", other.getvalue()):
        assert not READERS["excel"].recognises(path, head)


def refused(path: Path, word: str) -> None:
    with little_memory(), pytest.raises(CampaignError, match=word):
        headers(path)


def test_a_cell_at_the_end_of_the_sheet(path):
    """Two cells in 5 kB, 17 milliards between them: the library would lay out every one."""
    workbook(path, [HEADER, *rows()])
    book = openpyxl.load_workbook(path)
    book.active["XFD1048576"] = 1
    book.save(path)
    refused(path, "549,755,813,888 bytes")
    parts = parts_of(path)
    for reference in (b'r="xfd1048576"', b"r = 'XFD1048576'", b'r="AAAAAA1"'):
        pack(path, {**parts, SHEET: parts[SHEET].replace(b'r="XFD1048576"', reference)})
        refused(path, "bytes, the file has")


def test_a_row_far_down_with_cells_that_tell_no_place(path):
    workbook(path, [HEADER, *rows()])
    parts = parts_of(path)
    far = b'<row r="1048576">' + b"<c><v>1</v></c>" * 100 + b"</row></sheetData>"
    parts[SHEET] = parts[SHEET].replace(b"</sheetData>", far)
    pack(path, parts)
    refused(path, "bytes, the file has")


@pytest.mark.slow
def test_a_long_text_shared_by_many_cells(path):
    """Each cell gets a copy of its own: 30,000 times 30,000 letters."""
    workbook(path, [["text"] * 2 for _ in range(15_000)])
    pack(path, shared(parts_of(path), b"x" * 30_000))
    refused(path, "the cells of xl/worksheets/sheet1.xml would take")


def test_cells_repeated_without_end(tmp_path):
    body = ods_row([1.0]).replace(
        "<table:table-cell office", '<table:table-cell table:number-columns-repeated="16384" office'
    )
    path = ods(tmp_path / "run.ods", body.replace('rows-repeated="1"', 'rows-repeated="1048576"'))
    refused(path, "the cells of content.xml would take")
    gap = ods_row(["a", 1.0]) + ods_row([], 1_000_000) + ods_row([1.0] * 300)
    refused(ods(tmp_path / "run.ods", gap), "the cells of content.xml would take")


def binary_sheet(*cells_: tuple[int, int]) -> bytes:
    """A sheet of an .xlsb: records of row (0) and of a number in a column (5)."""
    sheet = b""
    for row, column in cells_:
        sheet += bytes([0, 4]) + struct.pack("<I", row)
        sheet += bytes([5, 16]) + struct.pack("<IId", column, 0, 1.0)
    return sheet


def test_a_binary_sheet_that_reaches_too_far(tmp_path):
    path = tmp_path / "run.xlsb"
    pack(path, {"xl/worksheets/sheet1.bin": binary_sheet((0, 0), (1_048_575, 16_383))})
    refused(path, "549,755,813,888 bytes")
    pack(path, {"xl/worksheets/sheet1.bin": binary_sheet((0, 0), (9, 3))})
    refused(path, "cannot be read as a workbook")


def test_a_zip_that_says_how_large_it_becomes(path):
    pack(path, {"xl/worksheets/sheet1.xml": b"<c/>"})
    data = bytearray(path.read_bytes())
    struct.pack_into("<I", data, data.index(b"PK\x01\x02") + 24, 3_000_000_000)
    path.write_bytes(data)
    refused(path, "3,000,000,000 bytes")


def test_a_zip_that_lies_about_how_large_it_becomes(path):
    """64 MB of blanks that the directory gives as 100 bytes."""
    pack(path, {"xl/sharedStrings.xml": b" " * 64_000_000})
    data = bytearray(path.read_bytes())
    central = data.index(b"PK\x01\x02")
    for place in (central + 24, 22):
        struct.pack_into("<I", data, place, 100)
    for place in (central + 16, 14):
        struct.pack_into("<I", data, place, zlib.crc32(b" " * 100))
    path.write_bytes(data)
    refused(path, "is not as long as it says")


def test_entities_of_xml_are_not_expanded(path, tmp_path):
    """Neither a file of the machine nor a text that doubles itself gets into a cell."""
    secret = tmp_path / "secret.txt"
    secret.write_text("secret", encoding="utf-8")
    workbook(path, [["t", "X", "Y", "NAME"], *rows()])
    parts = parts_of(path)
    pack(path, shared(parts, b"plain"))
    assert headers(path, header=True) == ("plain",) * 4
    kind = f'<!DOCTYPE sst [<!ENTITY e SYSTEM "{secret.as_uri()}"><!ENTITY a "aaaa">]>'.encode()
    for entity in (b"&e;", b"&a;"):
        pack(path, shared(parts, entity, kind))
        try:
            found = headers(path, header=True)
        except CampaignError:
            continue
        assert not any("secret" in name or "aaaa" in name for name in found)


def test_links_inside_are_refused(path):
    workbook(path, [HEADER, *rows()])
    with zipfile.ZipFile(path, "a") as archive:
        item = zipfile.ZipInfo("xl/media/link")
        item.external_attr = 0o120777 << 16
        archive.writestr(item, "/etc/hostname")
    refused(path, "is a link")


def test_text_files_may_lack_a_time_too(tmp_path):
    path = tmp_path / "run.csv"
    path.write_text("X;Y;N\n" + "1,5;2,5;3,5\n" * 9, encoding="utf-8")
    assert run_of(path, "[source]\nsample_rate = 4.0\n")["t"][-1] == 2.0
    with pytest.raises(CampaignError, match="no column of the file is used"):
        run_of(path, "[source]\nsample_rate = 4.0\n[columns]\nX = false\nY = false\nN = false\n")


def test_damage(path):
    workbook(path, [HEADER, *rows()])
    assert check_damage(path, tuple(HEADER), 120) > 90


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04", b"t,X\n1,2\n", b"\xd0\xcf\x11\xe0" * 300])
def test_files_that_are_none(path, content):
    path.write_bytes(content)
    refused(path, r"run\.xlsx")


def test_what_stands_above_the_columns_is_told_line_by_line(path):
    """A name and what is stated of it; titles of one cell and headers of many are none."""
    above = [["Versuch 7"], ["Driftwinkel [°]", "-8,5"], ["Periode", 9.0, "s"], []]
    workbook(path, [*above, HEADER, ["s", "N", "N", "N m"], *rows()])
    request = Request(path=path, shown="run.xlsx", options=Options())
    assert READERS["excel"].cells(request).above == ("Driftwinkel [°]; -8,5", "Periode; 9; s")
