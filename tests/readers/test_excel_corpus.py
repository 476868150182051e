"""One sheet, as the programs of laboratories write it: printed, filtered, with macros."""

from __future__ import annotations

import datetime as dt
from collections.abc import Callable
from pathlib import Path

import openpyxl
import pytest
from container_files import cells, headers, little_memory
from openpyxl.chart import LineChart, Reference
from openpyxl.comments import Comment
from openpyxl.formatting.rule import CellIsRule
from openpyxl.workbook.defined_name import DefinedName
from openpyxl.worksheet.datavalidation import DataValidation
from openpyxl.worksheet.table import Table
from workbooks import (
    HEADER,
    LINES,
    OFFICE,
    ROWS,
    STRICT_MAIN,
    STRICT_OFFICE,
    XML,
    Parts,
    binary_excel,
    book_of,
    cell_of,
    compound,
    excel,
    old_excel,
    packed,
    plain,
    printer_settings,
    record,
    relations,
    shared_strings,
    sheet_of,
    wide,
)

from pmmkit.base import CampaignError

Make = Callable[[Path], Path]
BOOKS: dict[str, Make] = {}


def made(suffix: str = ".xlsx") -> Callable[[Make], Make]:
    """A workbook of the corpus; its name is that of the function."""

    def register(make: Make) -> Make:
        name = make.__name__.replace("_", " ")
        BOOKS[name] = lambda folder: make(folder / f"{make.__name__}{suffix}")
        return make

    return register


def by_openpyxl(path: Path, dress: Callable[[openpyxl.Workbook], None]) -> Path:
    book = openpyxl.Workbook()
    page = book.active
    page.title = "Runs"
    for line in LINES:
        page.append(list(line))
    dress(book)
    book.save(path)
    return path


def beside(parts: Parts, **sheet_relations: str) -> Parts:
    """The parts, and what the first sheet refers to."""
    keys = [(key, *value.split(" ")) for key, value in sheet_relations.items()]
    return {**parts, "xl/worksheets/_rels/sheet1.xml.rels": relations(*keys)}


@made()
def written_by_openpyxl(path: Path) -> Path:
    return by_openpyxl(path, lambda book: None)


@made()
def written_by_pandas(path: Path) -> Path:
    import pandas as pd

    pd.DataFrame(list(ROWS), columns=list(HEADER)).to_excel(path, sheet_name="Runs", index=False)
    return path


@made()
def saved_by_excel(path: Path) -> Path:
    return packed(path, excel())


@made()
def printed_on_windows(path: Path) -> Path:
    """Every sheet that was ever printed there keeps what the driver wants."""
    setup = '<pageSetup paperSize="9" orientation="landscape" r:id="rId1"/>'
    parts = beside(
        excel(after=setup), rId1="printerSettings ../printerSettings/printerSettings1.bin"
    )
    return packed(path, {**parts, "xl/printerSettings/printerSettings1.bin": printer_settings()})


@made()
def printed_many_sheets(path: Path) -> Path:
    texts: list[str] = []
    sheets = [("Runs", sheet_of(LINES, texts)), ("Note", sheet_of([["Tank 3"]], texts))]
    parts = book_of(sheets, shared_strings(map(plain, texts)))
    for number in (1, 2):
        name = f"printerSettings{number}.bin"
        parts[f"xl/worksheets/_rels/sheet{number}.xml.rels"] = relations(
            ("rId1", "printerSettings", f"../printerSettings/{name}")
        )
        parts[f"xl/printerSettings/{name}"] = printer_settings()
    return packed(path, parts)


@made()
def filtered_and_frozen(path: Path) -> Path:
    def dress(book: openpyxl.Workbook) -> None:
        book.active.auto_filter.ref = f"A1:E{len(LINES)}"
        book.active.auto_filter.add_filter_column(0, ["SD01", "SD02"])
        book.active.freeze_panes = "B2"

    return by_openpyxl(path, dress)


@made()
def with_hidden_rows_and_columns(path: Path) -> Path:
    def dress(book: openpyxl.Workbook) -> None:
        book.active.row_dimensions[4].hidden = True
        book.active.column_dimensions["C"].hidden = True

    return by_openpyxl(path, dress)


@made()
def with_a_pivot_cache(path: Path) -> Path:
    more = [("rIdP", "pivotCacheDefinition", "pivotCache/pivotCacheDefinition1.xml")]
    texts: list[str] = []
    page = sheet_of(LINES, texts)
    parts = book_of([("Runs", page)], shared_strings(map(plain, texts)), more=more)
    cache = f'{XML}<pivotCacheRecords count="2"><r><n v="1"/><s v="a"/></r></pivotCacheRecords>'
    return packed(
        path,
        {
            **parts,
            "xl/pivotCache/pivotCacheDefinition1.xml": f"{XML}<pivotCacheDefinition/>".encode(),
            "xl/pivotCache/pivotCacheRecords1.xml": cache.encode(),
        },
    )


@made()
def with_a_chart(path: Path) -> Path:
    def dress(book: openpyxl.Workbook) -> None:
        chart = LineChart()
        chart.add_data(Reference(book.active, min_col=3, max_col=5, min_row=1, max_row=13))
        book.active.add_chart(chart, "H2")

    return by_openpyxl(path, dress)


@made()
def with_comments(path: Path) -> Path:
    def dress(book: openpyxl.Workbook) -> None:
        book.active["C3"].comment = Comment("gauge 2 was changed", "tank")

    return by_openpyxl(path, dress)


@made()
def with_images_and_embedded_objects(path: Path) -> Path:
    parts = beside(
        excel(after='<drawing r:id="rId1"/>'),
        rId1="drawing ../drawings/drawing1.xml",
        rId2="oleObject ../embeddings/oleObject1.bin",
        rId3="control ../activeX/activeX1.bin",
    )
    return packed(
        path,
        {
            **parts,
            "xl/drawings/drawing1.xml": f"{XML}<wsDr/>".encode(),
            "xl/media/image1.png": b"\x89PNG\r\n\x1a\n" + bytes(500),
            "xl/embeddings/oleObject1.bin": compound("Contents", bytes(5000)),
            "xl/activeX/activeX1.bin": printer_settings(),
        },
    )


@made()
def with_a_protected_sheet(path: Path) -> Path:
    def dress(book: openpyxl.Workbook) -> None:
        book.active.protection.sheet = True
        book.active.protection.password = "tank"

    return by_openpyxl(path, dress)


@made()
def with_defined_names_and_validation(path: Path) -> Path:
    def dress(book: openpyxl.Workbook) -> None:
        book.defined_names["forces"] = DefinedName("forces", attr_text="Runs!$C$2:$E$13")
        check = DataValidation(type="decimal", operator="between", formula1="-90", formula2="90")
        check.add("B2:B1048576")
        book.active.add_data_validation(check)
        rule = CellIsRule(operator="lessThan", formula=["0"])
        book.active.conditional_formatting.add("A1:XFD1048576", rule)

    return by_openpyxl(path, dress)


@made()
def with_a_table_object(path: Path) -> Path:
    def dress(book: openpyxl.Workbook) -> None:
        book.active.add_table(Table(displayName="Runs_1", ref=f"A1:E{len(LINES)}"))

    return by_openpyxl(path, dress)


@made(".xlsm")
def with_macros(path: Path) -> Path:
    texts: list[str] = []
    page = sheet_of(LINES, texts)
    more = [("rIdV", "vbaProject", "vbaProject.bin")]
    parts = book_of([("Runs", page)], shared_strings(map(plain, texts)), more=more)
    return packed(path, {**parts, "xl/vbaProject.bin": compound("VBA", printer_settings() * 4)})


@made(".xlsb")
def saved_binary(path: Path) -> Path:
    return packed(path, binary_excel())


@made(".xlsb")
def saved_binary_with_macros_and_printed(path: Path) -> Path:
    parts = binary_excel()
    parts["xl/_rels/workbook.bin.rels"] = relations(
        ("rId1", "worksheet", "worksheets/sheet1.bin"),
        ("rId2", "sharedStrings", "sharedStrings.bin"),
        ("rId3", "vbaProject", "vbaProject.bin"),
    )
    parts["xl/vbaProject.bin"] = compound("VBA", printer_settings() * 4)
    parts["xl/printerSettings/printerSettings1.bin"] = printer_settings()
    return packed(path, parts)


@made(".xls")
def saved_by_an_old_writer(path: Path) -> Path:
    path.write_bytes(old_excel())
    return path


@made()
def with_inline_texts(path: Path) -> Path:
    """As writers do that stream, and have no part of shared texts."""
    return packed(path, book_of([("Runs", sheet_of(LINES, None))], None))


@made()
def with_rich_texts(path: Path) -> Path:
    texts: list[str] = []
    page = sheet_of(LINES, texts)
    items = [f"<r><rPr><b/></rPr>{plain(text[:1])}</r><r>{plain(text[1:])}</r>" for text in texts]
    return packed(path, book_of([("Runs", page)], shared_strings(items)))


@made()
def with_readings_of_texts(path: Path) -> Path:
    """Japanese Excel keeps how a text is read beside it."""
    texts: list[str] = []
    page = sheet_of(LINES, texts)
    items = [f'{plain(text)}<rPh sb="0" eb="1"><t>ヨミ</t></rPh>' for text in texts]
    return packed(path, book_of([("Runs", page)], shared_strings(items)))


@made()
def with_formulas_and_what_they_gave(path: Path) -> Path:
    parts = excel()
    sheet = parts["xl/worksheets/sheet1.xml"]
    parts["xl/worksheets/sheet1.xml"] = sheet.replace(
        b"<v>-2.25</v>", b"<f>-1.25-1</f><v>-2.25</v>"
    )
    assert parts["xl/worksheets/sheet1.xml"] != sheet
    parts["xl/calcChain.xml"] = f'{XML}<calcChain><c r="XFD1048576" i="1"/></calcChain>'.encode()
    return packed(path, parts)


@made()
def saved_strict(path: Path) -> Path:
    texts: list[str] = []
    page = sheet_of(LINES, texts, main=STRICT_MAIN)
    shared = shared_strings(map(plain, texts), STRICT_MAIN)
    return packed(path, book_of([("Runs", page)], shared, main=STRICT_MAIN, office=STRICT_OFFICE))


@made()
def with_a_sheet_named_in_korean(path: Path) -> Path:
    return packed(path, excel(name="사항 시험 ⚓🚢"))


@made()
def with_absolute_targets(path: Path) -> Path:
    texts: list[str] = []
    page = sheet_of(LINES, texts)
    return packed(path, book_of([("Runs", page)], shared_strings(map(plain, texts)), absolute=True))


@made()
def with_sheets_in_a_folder_of_their_own(path: Path) -> Path:
    texts: list[str] = []
    page = sheet_of(LINES, texts)
    return packed(path, book_of([("Runs", page)], shared_strings(map(plain, texts)), folder="data"))


@made()
def with_prefixed_names(path: Path) -> Path:
    """As libraries of .NET write them."""
    texts: list[str] = []
    page = sheet_of(LINES, texts, prefix="x")
    shared = shared_strings((plain(text, "x") for text in texts), prefix="x")
    return packed(path, book_of([("Runs", page)], shared))


@made()
def with_a_byte_order_mark(path: Path) -> Path:
    parts = excel()
    mark = b"\xef\xbb\xbf"
    return packed(path, {name: mark + part for name, part in parts.items()})


@made()
def written_as_a_stream(path: Path) -> Path:
    """Lengths stand behind the parts, as writers do that do not know them before."""
    return packed(path, excel(), streamed=True)


@made()
def not_compressed(path: Path) -> Path:
    return packed(path, excel(), stored=True)


@made()
def with_entries_for_folders(path: Path) -> Path:
    return packed(path, {"xl/": b"", "xl/worksheets/": b"", **excel()})


@made()
def with_formats_down_to_the_last_row(path: Path) -> Path:
    """A column that was coloured whole: rows and cells with a format and nothing in them."""
    far = "".join(f'<row r="{row}" ht="15" customHeight="1"/>' for row in (500_000, 1_048_576))
    last = "".join(f'<c r="{column}1048575" s="1"/>' for column in ("A", "B", "XFD"))
    return packed(path, excel(more_rows=f'{far}<row r="1048575" s="1">{last}</row>'))


@made()
def with_widths_of_all_columns(path: Path) -> Path:
    return packed(path, excel(before='<cols><col min="1" max="16384" width="12"/></cols>'))


@made()
def linked_to_another_workbook(path: Path) -> Path:
    """Excel keeps the cells of the other one that it asked for."""
    parts = excel()
    link = (
        f'{XML}<externalLink><externalBook><sheetDataSet><sheetData sheetId="0"><row r="1048576">'
        '<cell r="XFD1048576"><v>1</v></cell></row></sheetData></sheetDataSet></externalBook>'
        "</externalLink>"
    )
    keys = parts["xl/_rels/workbook.xml.rels"].replace(
        b"</Relationships>",
        f'<Relationship Id="rIdL" Type="{OFFICE}/externalLink" '
        'Target="externalLinks/externalLink1.xml"/></Relationships>'.encode(),
    )
    return packed(
        path,
        {
            **parts,
            "xl/externalLinks/externalLink1.xml": link.encode(),
            "xl/_rels/workbook.xml.rels": keys,
        },
    )


@made()
def with_properties_of_the_office_in_two_bytes(path: Path) -> Path:
    label = '<?xml version="1.0" encoding="UTF-16"?><label>internal</label>'
    return packed(path, {**excel(), "customXml/item1.xml": label.encode("utf-16")})


@made()
def with_errors_and_truths_in_a_column(path: Path) -> Path:
    """A column that nobody asks for: #DIV/0! and TRUE beside the numbers."""
    parts = excel()
    sheet = parts["xl/worksheets/sheet1.xml"].replace(
        b"</row>", b'<c r="H2" t="e"><v>#DIV/0!</v></c><c r="I2" t="b"><v>1</v></c></row>', 2
    )
    head = cell_of("ok", 1, 7, None) + cell_of("kept", 1, 8, None)
    sheet = sheet.replace(
        b'<c r="H2" t="e"><v>#DIV/0!</v></c><c r="I2" t="b"><v>1</v></c>', head.encode(), 1
    )
    return packed(path, {**parts, "xl/worksheets/sheet1.xml": sheet})


@made()
def without_styles(path: Path) -> Path:
    """As MATLAB's writetable: nothing but sheet and texts."""
    parts = excel()
    del parts["xl/styles.xml"]
    return packed(path, parts)


@made(".ods")
def saved_by_libreoffice(path: Path) -> Path:
    space = "urn:oasis:names:tc:opendocument:xmlns"

    def cell(value: object) -> str:
        if isinstance(value, float):
            return f'<table:table-cell office:value-type="float" office:value="{value!r}"/>'
        return (
            f'<table:table-cell office:value-type="string"><text:p>{value}</text:p>'
            "</table:table-cell>"
        )

    rows = "".join(
        f"<table:table-row>{''.join(map(cell, line))}"
        '<table:table-cell table:number-columns-repeated="16379"/></table:table-row>'
        for line in LINES
    )
    tail = (
        '<table:table-row table:number-rows-repeated="1048563"><table:table-cell '
        'table:number-columns-repeated="16384"/></table:table-row>'
    )
    content = (
        f'<?xml version="1.0" encoding="UTF-8"?><office:document-content '
        f'xmlns:office="{space}:office:1.0" xmlns:table="{space}:table:1.0" '
        f'xmlns:text="{space}:text:1.0"><office:body><office:spreadsheet>'
        f'<table:table table:name="Runs" table:print-ranges="Runs.A1:E13">{rows}{tail}'
        "</table:table></office:spreadsheet></office:body></office:document-content>"
    )
    mark = b"application/vnd.oasis.opendocument.spreadsheet"
    return packed(
        path,
        {
            "mimetype": mark,
            "content.xml": content.encode(),
            "settings.xml": b"<office:document-settings/>",
            "META-INF/manifest.xml": (
                f'<manifest:manifest xmlns:manifest="{space}:manifest:1.0"><manifest:file-entry '
                f'manifest:full-path="/" manifest:media-type="{mark.decode()}"/>'
                "</manifest:manifest>"
            ).encode(),
        },
        stored=True,
    )


@pytest.mark.parametrize("name", BOOKS)
def test_the_cells_are_those_that_were_written(name: str, tmp_path: Path) -> None:
    path = BOOKS[name](tmp_path)
    sheet = 1 if "many sheets" in name else None
    found = cells(path, sheet=sheet)
    assert found.headers[:5] == HEADER
    assert [row[:5] for row in found.rows] == list(ROWS)
    assert found.lines == tuple(range(2, 14))


def test_the_corpus_is_large() -> None:
    assert len(BOOKS) >= 30


def test_hidden_and_empty_sheets_are_sheets(tmp_path: Path) -> None:
    texts: list[str] = []
    sheets = [
        ("Empty", sheet_of([], texts)),
        ("Runs", sheet_of(LINES, texts)),
        ("Old", sheet_of([["Run", "X [N]"], ["SD01", 1.0]], texts)),
        ("Lists", sheet_of([["deg", "N"], ["m", "s"]], texts)),
    ]
    state = {"Old": "hidden", "Lists": "veryHidden"}
    parts = book_of(sheets, shared_strings(map(plain, texts)), state=state)
    path = packed(tmp_path / "run.xlsx", parts)
    assert [row[:5] for row in cells(path, sheet="Runs").rows] == list(ROWS)
    assert cells(path, sheet="Old").rows == (("SD01", 1.0),)
    with pytest.raises(CampaignError, match="the sheet is empty"):
        headers(path, sheet="Empty")


def test_merged_cells_have_the_value_of_the_first(tmp_path: Path) -> None:
    lines = [["Run", "U [m/s]", "X [N]"], ["a", 1.5, -1.0], ["b", None, -2.0], ["c", None, -3.0]]
    merged = '<mergeCells count="1"><mergeCell ref="B2:B4"/></mergeCells>'
    path = packed(tmp_path / "run.xlsx", excel(lines, after=merged))
    assert [row[1] for row in cells(path).rows] == [1.5, 1.5, 1.5]


@pytest.mark.parametrize(("since_1904", "day"), [(False, 45_000.0), (True, 43_538.0)])
def test_dates_count_from_1900_or_1904(tmp_path: Path, since_1904: bool, day: float) -> None:
    """The same day, 2023-03-15, as Excel on Windows and as old Excel on the Macintosh count it."""
    texts: list[str] = []
    page = sheet_of([["Run", "Made", "X [N]"], ["a", day, 1.0], ["b", day + 0.5, 2.0]], texts)
    page = page.replace(b'<c r="B2">', b'<c r="B2" s="1">').replace(
        b'<c r="B3">', b'<c r="B3" s="1">'
    )
    inside = '<workbookPr date1904="1"/>' if since_1904 else ""
    parts = book_of([("Runs", page)], shared_strings(map(plain, texts)), inside=inside)
    parts["xl/styles.xml"] = (
        XML + '<styleSheet xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main">'
        '<cellXfs count="2"><xf numFmtId="0"/><xf numFmtId="22" applyNumberFormat="1"/></cellXfs>'
        "</styleSheet>"
    ).encode()
    found = cells(packed(tmp_path / "run.xlsx", parts))
    made_at = [dt.datetime.fromisoformat(str(row[1])) for row in found.rows]
    assert made_at == [dt.datetime(2023, 3, 15), dt.datetime(2023, 3, 15, 12)]


FAR = '<row r="1048576"><c r="XFD1048576"><v>1</v></c></row>'


@pytest.mark.parametrize("kind", ["worksheet", "theme", "printerSettings"])
@pytest.mark.parametrize("target", ["worksheets/sheet1.xml", "theme/page.dat"])
def test_a_sheet_that_goes_by_another_name_is_looked_at_all_the_same(
    tmp_path: Path, kind: str, target: str
) -> None:
    """The list of sheets decides what is read, not the type that a relationship claims."""
    parts = excel(more_rows=FAR)
    parts[f"xl/{target}"] = parts.pop("xl/worksheets/sheet1.xml")
    parts["xl/_rels/workbook.xml.rels"] = relations(
        ("rId1", kind, target), ("rId2", "sharedStrings", "sharedStrings.xml")
    )
    path = packed(tmp_path / "run.xlsx", parts)
    with little_memory(), pytest.raises(CampaignError, match="bytes, the file has"):
        headers(path)


@pytest.mark.parametrize("kind", ["worksheet", "vbaProject"])
def test_a_binary_sheet_that_claims_to_be_macros_is_looked_at_all_the_same(
    tmp_path: Path, kind: str
) -> None:
    parts = binary_excel()
    far = record(0, (1_048_575).to_bytes(4, "little") + bytes(13))
    far += record(5, (16_383).to_bytes(4, "little") + bytes(12))
    parts["xl/vbaProject.bin"] = parts.pop("xl/worksheets/sheet1.bin") + far
    parts["xl/_rels/workbook.bin.rels"] = relations(
        ("rId1", kind, "vbaProject.bin"), ("rId2", "sharedStrings", "sharedStrings.bin")
    )
    assert wide("rId1") in parts["xl/workbook.bin"]
    path = packed(tmp_path / "run.xlsb", parts)
    with little_memory(), pytest.raises(CampaignError, match="549,755,813,888 bytes"):
        headers(path)


def test_an_empty_row_that_hides_its_cells_from_a_glance_is_counted(tmp_path: Path) -> None:
    hidden = '<row r="1048576" spans="/>"><c r="XFD1048576"><v>1</v></c></row>'
    path = packed(tmp_path / "run.xlsx", excel(more_rows=hidden))
    with little_memory(), pytest.raises(CampaignError, match="bytes, the file has"):
        headers(path)
