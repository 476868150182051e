"""Tables of a Word document: columns that fit, heads on every page, rows that no page breaks."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING, Any, Final

from pmmkit.presentation import ABSENT, Grid, Symbol, printable
from pmmkit.views.report.captive.columns import SIZES, TableColumns
from pmmkit.views.report.captive.document import Item
from pmmkit.views.report.captive.word.own_style import element, spacer, style_of

if TYPE_CHECKING:
    from docx.document import Document as WordFile
    from docx.text.paragraph import Paragraph

LABELS: Final = 0.42
"""Part of the width that the labels of stated items have."""
TOGETHER: Final = 6
"""Rows up to which a table stays on one page."""
START: Final = 3
"""Rows at either end of a longer table that stay together."""
LINES: Final = {"top": (6, "1B1B1B"), "bottom": (6, "1B1B1B"), "insideH": (2, "BDBDBD")}
"""Borders of a table whose document has no style for it: eighths of a point, and the colour."""
SOFT, LACKING, FAINT = "5A5A5A", "8A3A00", "F3F3F3"
GRID: Final = "Table Grid"


def items_table(file: WordFile, items: Sequence[Item], width: float, style: str | None) -> None:
    """What is stated, a row an item.

    width [cm].
    """
    columns = TableColumns(size=SIZES[0], widths=(LABELS * width, (1.0 - LABELS) * width))
    rows = [[item.what, item.text] for item in items]
    made = _new(file, rows, columns, style)
    for row, item in zip(made, items, strict=True):
        _write(row[0], item.what, columns.size, colour=SOFT)
        lacks = item.value is None
        _write(row[1], item.text, columns.size, italic=lacks, colour=LACKING if lacks else None)
    _keep(made)
    spacer(file)


def grid_table(file: WordFile, table: Grid, columns: TableColumns, style: str | None) -> None:
    """A table, without its caption."""
    kinds: list[tuple[str, Sequence[str | None]]] = (
        [("head", table.head)] if any(table.head) else []
    )
    for group in table.groups:
        kinds += [("group", [group.title])] if group.title else []
        kinds += [("row", cells) for cells in group.rows]
    if not kinds:
        return
    made = _new(file, [cells for _, cells in kinds], columns, style)
    texts = {0, *table.texts}
    for row, (kind, cells) in zip(made, kinds, strict=True):
        _fill(row, cells, kind, texts, columns.size)
    _keep(made, after=[place for place, (kind, _) in enumerate(kinds) if kind == "group"])


def _new(
    file: WordFile, rows: Sequence[Sequence[str | None]], columns: TableColumns, style: str | None
) -> list[list[Any]]:
    """A table of empty cells: the elements of each row, as many as it has cells."""
    from docx.oxml.ns import qn
    from docx.shared import Cm

    widths = [Cm(width) for width in columns.widths]
    table = file.add_table(len(rows), len(widths))
    table.style, table.autofit = style_of(file, style), False
    layout = table._tbl.tblPr.find(qn("w:tblLayout"))  # Word wants its neighbours in this order
    if style_of(file, style) is None:
        layout.addprevious(_borders("w:tblBorders", LINES))
    margins = [element(f"w:{side}", w=65, type="dxa") for side in ("left", "right")]
    layout.addnext(element("w:tblCellMar", *margins))
    for column, width in zip(table._tbl.tblGrid.gridCol_lst, widths, strict=True):
        column.w = width
    made = []
    for line, row in zip(table._tbl.tr_lst, rows, strict=True):
        line.get_or_add_trPr().append(element("w:cantSplit"))
        cells = line.tc_lst
        for cell, width in zip(cells, widths, strict=True):
            cell.width = width
        if len(row) < len(cells):
            cells[0].merge(cells[-1])
        made.append(line.tc_lst)
    return made


def _borders(name: str, lines: dict[str, tuple[int, str]]) -> Any:
    sides = (
        element(f"w:{side}", val="single", sz=size, space=0, color=colour)
        for side, (size, colour) in lines.items()
    )
    return element(name, *sides)


def _fill(
    row: Sequence[Any], cells: Sequence[str | None], kind: str, texts: Collection[int], size: float
) -> None:
    from docx.enum.text import WD_ALIGN_PARAGRAPH

    if kind == "head":
        row[0].getparent().get_or_add_trPr().append(element("w:tblHeader"))
    for place, (inside, cell) in enumerate(zip(row, cells, strict=True)):
        told = _write(inside, ABSENT if cell is None else cell, size, bold=kind != "row")
        if place not in texts:
            told.alignment = WD_ALIGN_PARAGRAPH.RIGHT
        if kind == "head":
            inside.get_or_add_tcPr().append(_borders("w:tcBorders", {"bottom": LINES["bottom"]}))
        if kind == "group":
            inside.get_or_add_tcPr().append(element("w:shd", val="clear", color="auto", fill=FAINT))


def _write(
    cell: Any,
    text: str,
    size: float,
    *,
    bold: bool = False,
    italic: bool = False,
    colour: str | None = None,
) -> Paragraph:
    """A text of a cell; a derivative with its letters set low."""
    from docx.shared import Pt, RGBColor
    from docx.text.paragraph import Paragraph

    parts = [(text, False)]
    if isinstance(text, Symbol):
        parts = [(text.letter, False), (text.below, True)]
    paragraph = Paragraph(cell.p_lst[0], cell)
    layout = paragraph.paragraph_format
    layout.space_before = layout.space_after = Pt(1)
    layout.line_spacing = 1.0
    mark = element("w:rPr", element("w:sz", val=round(2 * size)))  # else empty cells are higher
    paragraph._p.get_or_add_pPr().append(mark)
    for part, low in parts:
        run = paragraph.add_run(printable(part))
        run.font.size = Pt(size)
        run.font.subscript = low or None
        run.bold, run.italic = bold or None, italic or None
        if colour:
            run.font.color.rgb = RGBColor.from_string(colour)
    return paragraph


def _keep(made: Sequence[Sequence[Any]], after: Collection[int] = ()) -> None:
    """Rows that stay with the next: short tables, both ends of longer ones, titles of groups."""
    from docx.text.paragraph import Paragraph

    last = len(made) - 1
    edges = range(last) if last < TOGETHER else (*range(START), *range(last - START + 1, last))
    for place in {*edges, *after} - {last}:
        for cell in made[place]:
            Paragraph(cell.p_lst[0], cell).paragraph_format.keep_with_next = True
