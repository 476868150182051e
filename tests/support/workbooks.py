"""Workbooks as programs write them, made part by part: the same sheet in many dresses."""

from __future__ import annotations

import struct
import zipfile
from collections.abc import Iterable, Sequence
from pathlib import Path
from xml.sax.saxutils import escape

Value = str | float | None
HEADER = ("Run", "beta [deg]", "X [N]", "Y [N]", "N [Nm]")
ROWS: tuple[tuple[Value, ...], ...] = tuple(
    (f"SD{place:02d}", 2.0 * place, -1.25 - place, 3.5 * place, -0.75 * place)
    for place in range(1, 13)
)
LINES: tuple[tuple[Value, ...], ...] = (HEADER, *ROWS)
MAIN = "http://schemas.openxmlformats.org/spreadsheetml/2006/main"
OFFICE = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"
STRICT_MAIN = "http://purl.oclc.org/ooxml/spreadsheetml/main"
STRICT_OFFICE = "http://purl.oclc.org/ooxml/officeDocument/relationships"
PACKAGE = "http://schemas.openxmlformats.org/package/2006"
XML = '<?xml version="1.0" encoding="UTF-8" standalone="yes"?>\n'
Parts = dict[str, bytes]


def letters(place: int) -> str:
    """The name of a column, counted from 0."""
    return (letters(place // 26 - 1) if place >= 26 else "") + chr(65 + place % 26)


def cell_of(value: Value, row: int, place: int, texts: list[str] | None, x: str = "") -> str:
    """A cell; its text shared where `texts` is a list, else in the cell."""
    at = f'r="{letters(place)}{row}"'
    if value is None:
        return f'<{x}c {at} s="1"/>'
    if isinstance(value, float):
        return f"<{x}c {at}><{x}v>{value!r}</{x}v></{x}c>"
    if texts is None:
        return f'<{x}c {at} t="inlineStr"><{x}is><{x}t>{escape(value)}</{x}t></{x}is></{x}c>'
    if value not in texts:
        texts.append(value)
    return f'<{x}c {at} t="s"><{x}v>{texts.index(value)}</{x}v></{x}c>'


def sheet_of(
    lines: Iterable[Sequence[Value]],
    texts: list[str] | None,
    *,
    main: str = MAIN,
    before: str = "",
    after: str = "",
    more_rows: str = "",
    prefix: str = "",
) -> bytes:
    """The part of a sheet."""
    x = f"{prefix}:" if prefix else ""
    rows = "".join(
        f'<{x}row r="{row}">'
        + "".join(cell_of(value, row, place, texts, x) for place, value in enumerate(line))
        + f"</{x}row>"
        for row, line in enumerate(lines, start=1)
    )
    space = f'xmlns{":" + prefix if prefix else ""}="{main}"'
    return (
        f'{XML}<{x}worksheet {space} xmlns:r="{OFFICE}">{before}<{x}sheetData>{rows}{more_rows}'
        f"</{x}sheetData>{after}</{x}worksheet>"
    ).encode()


def shared_strings(items: Iterable[str], main: str = MAIN, prefix: str = "") -> bytes:
    """The part of shared texts; each item is the inside of an ``si``."""
    x = f"{prefix}:" if prefix else ""
    inside = "".join(f"<{x}si>{item}</{x}si>" for item in items)
    space = f'xmlns{":" + prefix if prefix else ""}="{main}"'
    return f"{XML}<{x}sst {space}>{inside}</{x}sst>".encode()


def plain(text: str, prefix: str = "") -> str:
    x = f"{prefix}:" if prefix else ""
    return f'<{x}t xml:space="preserve">{escape(text)}</{x}t>'


def relations(*items: tuple[str, str, str], office: str = OFFICE) -> bytes:
    """A part of relationships: key, last word of the type, target."""
    inside = "".join(
        f'<Relationship Id="{key}" Type="{office}/{kind}" Target="{target}"/>'
        for key, kind, target in items
    )
    return f'{XML}<Relationships xmlns="{PACKAGE}/relationships">{inside}</Relationships>'.encode()


def book_of(
    sheets: Sequence[tuple[str, bytes]],
    texts: bytes | None,
    *,
    main: str = MAIN,
    office: str = OFFICE,
    folder: str = "worksheets",
    absolute: bool = False,
    state: dict[str, str] | None = None,
    inside: str = "",
    more: Sequence[tuple[str, str, str]] = (),
) -> Parts:
    """All parts of a workbook from those of its sheets."""
    root = "/xl/" if absolute else ""
    names = [f"{folder}/sheet{number}.xml" for number in range(1, len(sheets) + 1)]
    listed = "".join(
        f'<sheet name="{escape(name)}" sheetId="{number}" r:id="rId{number}"'
        + (f' state="{(state or {})[name]}"' if name in (state or {}) else "")
        + "/>"
        for number, (name, _) in enumerate(sheets, start=1)
    )
    keys = [
        (f"rId{number}", "worksheet", root + name) for number, name in enumerate(names, start=1)
    ]
    keys += [("rIdT", "sharedStrings", f"{root}sharedStrings.xml")] if texts is not None else []
    parts = {
        "[Content_Types].xml": (
            f'{XML}<Types xmlns="{PACKAGE}/content-types"><Default Extension="xml" '
            'ContentType="application/xml"/></Types>'
        ).encode(),
        "_rels/.rels": relations(("rId1", "officeDocument", "xl/workbook.xml"), office=office),
        "xl/workbook.xml": (
            f'{XML}<workbook xmlns="{main}" xmlns:r="{office}">{inside}<sheets>{listed}</sheets>'
            "</workbook>"
        ).encode(),
        "xl/_rels/workbook.xml.rels": relations(*keys, *more, office=office),
        "xl/styles.xml": f'{XML}<styleSheet xmlns="{main}"/>'.encode(),
    }
    parts |= {f"xl/{name}": sheet for name, (_, sheet) in zip(names, sheets, strict=True)}
    return parts | ({"xl/sharedStrings.xml": texts} if texts is not None else {})


def excel(lines: Sequence[Sequence[Value]] = LINES, *, name: str = "Runs", **sheet: str) -> Parts:
    """As Excel saves it: texts shared."""
    texts: list[str] = []
    page = sheet_of(lines, texts, **sheet)  # type: ignore[arg-type]
    return book_of([(name, page)], shared_strings(map(plain, texts)))


def packed(path: Path, parts: Parts, *, stored: bool = False, streamed: bool = False) -> Path:
    """The parts as a file; streamed as by a program that does not yet know how long they are."""
    how = zipfile.ZIP_STORED if stored else zipfile.ZIP_DEFLATED
    with path.open("wb") as file:
        target = _NoSeek(file) if streamed else file
        with zipfile.ZipFile(target, "w", how) as archive:  # type: ignore[call-overload]
            for name, part in parts.items():
                archive.writestr(name, part)
    return path


class _NoSeek:
    """A file that cannot go back: lengths follow what they belong to."""

    def __init__(self, file: object) -> None:
        self.write = file.write  # type: ignore[attr-defined]
        self.flush = file.flush  # type: ignore[attr-defined]


def printer_settings() -> bytes:
    """What a driver keeps: device names as two bytes a letter, then numbers of its own."""
    names = "\\\\server\\HP LaserJet 4250".encode("utf-16-le").ljust(64, b"\0")
    return (
        names
        + bytes(struct.pack("<4H8I", 0x0401, 0xDC, 0x5F4, 0x3, *range(9000, 9008)))
        + (
            bytes([5, 16])
            + struct.pack("<IId", 16_000, 0, 1.0)
            + bytes([0, 4])
            + struct.pack("<I", 1_000_000)
        )
        * 50
    )


def record(kind: int, content: bytes) -> bytes:
    """A record of a binary workbook (.xlsb)."""
    head = bytes([kind]) if kind < 128 else bytes([kind & 0x7F | 0x80, kind >> 7])
    size, length = b"", len(content)
    while True:
        size += bytes([length & 0x7F | (0x80 if length > 127 else 0)])
        length >>= 7
        if not length:
            return head + size + content


def wide(text: str) -> bytes:
    return struct.pack("<I", len(text)) + text.encode("utf-16-le")


def binary_excel(lines: Sequence[Sequence[Value]] = LINES) -> Parts:
    """As Excel saves a binary workbook (.xlsb)."""
    texts = list(dict.fromkeys(x for line in lines for x in line if isinstance(x, str)))
    sheet = record(129, b"") + record(148, struct.pack("<4I", 0, len(lines) - 1, 0, 4))
    sheet += record(145, b"")
    for row, line in enumerate(lines):
        sheet += record(0, struct.pack("<I", row) + bytes(13))
        for place, value in enumerate(line):
            head = struct.pack("<II", place, 0)
            if isinstance(value, str):
                sheet += record(7, head + struct.pack("<I", texts.index(value)))
            elif value is not None:
                sheet += record(5, head + struct.pack("<d", value))
    sheet += record(146, b"") + record(130, b"")
    book = record(131, b"") + record(143, b"")
    book += record(156, struct.pack("<II", 0, 1) + wide("rId1") + wide("Runs"))
    book += record(144, b"") + record(132, b"")
    shared = record(159, struct.pack("<II", len(texts), len(texts)))
    shared += b"".join(record(19, b"\0" + wide(text)) for text in texts) + record(160, b"")
    return {
        "[Content_Types].xml": b"<Types/>",
        "_rels/.rels": relations(("rId1", "officeDocument", "xl/workbook.bin")),
        "xl/workbook.bin": book,
        "xl/_rels/workbook.bin.rels": relations(
            ("rId1", "worksheet", "worksheets/sheet1.bin"),
            ("rId2", "sharedStrings", "sharedStrings.bin"),
        ),
        "xl/worksheets/sheet1.bin": sheet,
        "xl/sharedStrings.bin": shared,
    }


def old_excel(lines: Sequence[Sequence[Value]] = LINES) -> bytes:
    """As Excel 97 and the writers of .xls save it: records in a stream of a compound file."""

    def biff(kind: int, content: bytes = b"") -> bytes:
        return struct.pack("<HH", kind, len(content)) + content

    begin = struct.pack("<HHHHII", 0x0600, 0, 0x0DBB, 0x07CC, 0, 6)
    texts = list(dict.fromkeys(x for line in lines for x in line if isinstance(x, str)))
    shared = struct.pack("<II", len(texts), len(texts)) + b"".join(
        struct.pack("<HB", len(text), 1) + text.encode("utf-16-le") for text in texts
    )
    sheet = biff(0x0809, begin[:2] + struct.pack("<H", 0x10) + begin[4:])
    sheet += biff(0x0200, struct.pack("<IIHHH", 0, len(lines), 0, 5, 0))
    for row, line in enumerate(lines):
        for place, value in enumerate(line):
            head = struct.pack("<HHH", row, place, 0)
            if isinstance(value, str):
                sheet += biff(0x00FD, head + struct.pack("<I", texts.index(value)))
            elif value is not None:
                sheet += biff(0x0203, head + struct.pack("<d", value))
    sheet += biff(0x000A)

    def globals_(place: int) -> bytes:
        bound = struct.pack("<IHB", place, 0, 4) + b"\0Runs"
        return (
            biff(0x0809, begin[:2] + struct.pack("<H", 0x05) + begin[4:])
            + biff(0x0042, struct.pack("<H", 1200))
            + biff(0x0085, bound)
            + biff(0x00FC, shared)
            + biff(0x000A)
        )

    return compound("Workbook", globals_(len(globals_(0))) + sheet)


def compound(name: str, stream: bytes) -> bytes:
    """A compound file with one stream."""
    size = max(4096, len(stream))
    stream = stream.ljust(-(-size // 512) * 512, b"\0")
    count = len(stream) // 512
    chain = [0xFFFFFFFD, 0xFFFFFFFE, *(place + 1 for place in range(2, count + 1)), 0xFFFFFFFE]
    table = struct.pack(f"<{len(chain)}I", *chain).ljust(512, b"\xff")
    assert len(table) == 512

    def entry(label: str, kind: int, child: int, first: int, length: int) -> bytes:
        text = (label + "\0").encode("utf-16-le")
        return (
            text.ljust(64, b"\0")
            + struct.pack("<HBB3I", len(text), kind, 1, 0xFFFFFFFF, 0xFFFFFFFF, child)
            + bytes(36)
            + struct.pack("<IQ", first, length)
        )

    folder = entry("Root Entry", 5, 1, 0xFFFFFFFE, 0) + entry(name, 2, 0xFFFFFFFF, 2, size)
    head = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(16)
    head += struct.pack("<5H6x", 0x3E, 3, 0xFFFE, 9, 6)
    head += struct.pack("<9I", 0, 1, 1, 0, 4096, 0xFFFFFFFE, 0, 0xFFFFFFFE, 0)
    head += struct.pack("<I", 0) + b"\xff" * 432
    return head + table + folder.ljust(512, b"\0") + stream
