"""Looks at a workbook before it is read: how far it expands, how far its cells reach.

The library that reads workbooks lays a sheet out from its first to its last cell, and gives every
cell a copy of its text. A few kilobytes can say that there are 17 milliards of cells, or a million
cells with one long text; no memory is enough for that.
"""

from __future__ import annotations

import hashlib
import html
import posixpath
import re
import zipfile
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Final

import numpy as np

from pmmkit.base import CampaignError
from pmmkit.readers.base import Options, Request
from pmmkit.readers.bounds import (
    ZIP,
    check_length,
    content_of,
    damage_told,
    limit_of,
    members_of,
    too_large,
)

# Which parts of a workbook hold cells and texts: those that its relationships say.
#
# A workbook is an archive of many parts: styles, drawings, caches of pivot tables, settings of the
# printer, macros. Only sheets and the texts that they share become cells.


_RELATIONSHIP: Final = re.compile(rb"<(?:\w+:)?Relationship\s([^>]*)>")
_ATTRIBUTE: Final = re.compile(rb"""([\w:]+)\s*=\s*(?:"([^"]*)"|'([^']*)')""")
_SHEET: Final = re.compile(rb"<(?:\w+:)?sheet\s([^>]*)>")
_HOLDING: Final = ("worksheet", "sharedStrings")
"""Last words of the types of relationships to parts with cells or texts, of either dialect."""
_TAKEN_BY_NAME: Final = ("xl/sharedstrings.xml", "xl/sharedstrings.bin", "content.xml")
"""Parts that the library reads wherever they stand, whatever refers to them."""


def parts_with_cells(members: Mapping[str, zipfile.ZipInfo], data: bytes) -> frozenset[str]:
    """Names of the parts of a workbook that hold cells or shared texts.

    A relationship counts that says so, and one that the list of sheets refers to, whatever it
    says: the library goes by that list. Where no part refers to a sheet all of them count.
    """
    found = {
        place
        for name, item in members.items()
        if name.endswith(".rels")
        for place in _targets(name, content_of(data, item), members, data)
    }
    names = {name for name in members if name.lower().replace("\\", "/").lstrip("/") in found}
    if not names:
        return frozenset(name for name in members if name.endswith((".xml", ".bin")))
    return frozenset(names | {name for name in members if name.lower().endswith(_TAKEN_BY_NAME)})


def _targets(
    name: str, relations: bytes, members: Mapping[str, zipfile.ZipInfo], data: bytes
) -> Iterator[str]:
    """Where the parts stand that a part calls sheets or texts, in lower case."""
    folder, _, own = name.rpartition("/")
    source = posixpath.join(posixpath.dirname(folder), own.removesuffix(".rels"))
    there = members.get(source)
    part = b"" if there is None else content_of(data, there)
    listed = {value for found in _SHEET.finditer(part) for value in _values(found[1]).values()}
    for found in _RELATIONSHIP.finditer(relations):
        stated = _values(found[1])
        key = stated.get("Id", "")
        # a binary workbook names its sheets by these keys, as text of two bytes a letter
        named = key in listed or (key != "" and key.encode("utf-16-le") in part)
        if named or stated.get("Type", "").rpartition("/")[2] in _HOLDING:
            yield from _places(stated.get("Target", ""), posixpath.dirname(source))


def _values(attributes: bytes) -> dict[str, str]:
    return {
        found[1].decode("latin-1"): html.unescape(
            (found[2] or found[3] or b"").decode("utf-8", "replace")
        )
        for found in _ATTRIBUTE.finditer(attributes)
    }


def _places(target: str, folder: str) -> Iterator[str]:
    """Names that a target may mean: from the root, from its folder, or with it written twice."""
    plain = target.replace("\\", "/").lower()
    yield plain.lstrip("/")
    yield posixpath.normpath(posixpath.join(folder.lower(), plain)).lstrip("/")


CFB: Final = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"
_CELL: Final = 32
"""Bytes that the library takes for a cell."""
_XML: Final = re.compile(rb"(?:\xef\xbb\xbf)?\s*<[^\0]")
_CELLS_OR_TEXTS: Final = re.compile(rb"sheetData|<(?:\w+:)?si\b|table:table-row")
_CELL_TAG: Final = re.compile(rb"<(?:\w+:)?c[ >]")
_REFERENCE: Final = re.compile(rb"""\br\s*=\s*["']([A-Za-z]{1,9})[0-9]""")
_ROW_NUMBER: Final = re.compile(rb"""\br\s*=\s*["'][A-Za-z]{0,9}([0-9]{1,10})["']""")
_ATTRIBUTES: Final = rb'(?:\s+[\w:.]+="[^"<>/]*")*\s*'
_EMPTY_CELL: Final = re.compile(rb"<(\w+:)?c" + _ATTRIBUTES + rb"/>")
_EMPTY_ROW: Final = re.compile(rb"<(\w+:)?row" + _ATTRIBUTES + rb"(?:/>|>\s*</(\w+:)?row>)")
"""Cells and rows that have a format and nothing in them; the library passes them over."""
_SHARED: Final = re.compile(rb"""\bt\s*=\s*["']s["'][^>]*>\s*<(?:\w+:)?v[^>]*>\s*([0-9]{1,9})""")
_ITEM: Final = re.compile(rb"<(?:\w+:)?si\b")
_ODS_ROW: Final = re.compile(
    rb"<table:table-row\b([^>]*?)(?:/>|>(.*?)</table:table-row>)", re.DOTALL
)
_ODS_CELL: Final = re.compile(
    rb"<table:(?:covered-)?table-cell\b([^>]*?)(?:/>|>(.*?)</table:(?:covered-)?table-cell>)",
    re.DOTALL,
)
_REPEATED: Final = re.compile(rb"""number-(?:columns|rows)-repeated=["']([0-9]{1,9})["']""")


def check_workbook(request: Request) -> None:
    """Refuse a workbook that would expand to far more than its size.

    A workbook of many sheets is asked for sheet by sheet: one whose bytes were found to be good
    is not gone through again.
    """
    data = request.path.read_bytes()
    if not data.startswith(ZIP):
        return
    bare = replace(request, shown="", run=None, options=Options())
    try:
        _check(bare, hashlib.sha256(data).digest())
    except CampaignError as error:
        told = [replace(item, file=request.shown, run=request.run) for item in error.problems]
        raise request.error(*told) from error


@lru_cache(maxsize=32)
def _check(request: Request, digest: bytes) -> None:
    """Go through the bytes of a workbook that have this digest; an error is not remembered."""
    data = request.path.read_bytes()
    if hashlib.sha256(data).digest() != digest:
        raise _damaged(request, "it changes while it is read")
    with damage_told(lambda what: _damaged(request, what)):
        parts = dict(_parts(data, request))
    for name, cells in _extents(parts):
        if cells * _CELL > limit_of(len(data)):
            raise too_large(request, cells * _CELL, len(data), f"the cells of {name}")


def _parts(data: bytes, request: Request) -> Iterator[tuple[str, bytes]]:
    """The parts that hold cells and texts, every part having been unpacked once to count."""
    members = members_of(data)
    declared = sum(item.file_size for item in members)
    if declared > limit_of(len(data)):
        raise too_large(request, declared, len(data), "the workbook unpacked")
    for item in members:
        check_length(data, item)
    held = parts_with_cells({item.filename: item for item in members}, data)
    for item in members:
        if item.filename not in held:
            continue
        part = content_of(data, item)
        if not item.filename.endswith(".bin") and _XML.match(part) is None:
            raise _damaged(request, f"{item.filename} is not UTF-8")
        if _CELLS_OR_TEXTS.search(part) or item.filename.endswith(".bin"):
            yield item.filename, part


def _extents(parts: dict[str, bytes]) -> Iterator[tuple[str, int]]:
    """Cells that each sheet spans; long texts count as so many cells."""
    texts = [part for part in parts.values() if _ITEM.search(part)]
    for name, part in parts.items():
        if name.endswith(".bin"):
            yield name, _xlsb_cells(part)
        elif b"table:table-row" in part:
            yield name, _ods_cells(part)
        else:
            shared = max((_shared_texts(part, each) for each in texts), default=0)
            yield name, _xlsx_cells(part) + shared


def _xlsx_cells(sheet: bytes) -> int:
    sheet = _EMPTY_ROW.sub(b"", _EMPTY_CELL.sub(b"", sheet))
    placed = Counter(found[1] for found in _REFERENCE.finditer(sheet))
    rows = Counter(found[1] for found in _ROW_NUMBER.finditer(sheet))
    unplaced = sum(1 for _ in _CELL_TAG.finditer(sheet)) - placed.total()
    widest = max(map(_column, placed), default=1) + max(0, unplaced)
    return widest * max(map(int, rows), default=1)


def _column(letters: bytes) -> int:
    """Number of a column, counted from 1.

    Examples
    --------
    >>> _column(b"A"), _column(b"XFD")
    (1, 16384)
    """
    number = 0
    for letter in letters.upper():
        number = number * 26 + letter - 64
    return number


def _shared_texts(sheet: bytes, texts: bytes) -> int:
    """Cells' worth of memory that the texts take which a sheet shares."""
    starts = np.array([found.start() for found in _ITEM.finditer(texts)] + [len(texts)])
    lengths = np.diff(starts)
    used = np.fromiter((int(found[1]) for found in _SHARED.finditer(sheet)), dtype=np.int64)
    used = used[used < len(lengths)]
    return int(lengths[used].sum()) // _CELL


def _xlsb_cells(sheet: bytes) -> int:
    """Cells that a binary sheet spans: records are a number, a length and so many bytes."""
    place, row, column = 0, 0, 0
    while place < len(sheet):
        kind, place = _packed_number(sheet, place, 2)
        size, place = _packed_number(sheet, place, 4)
        if kind <= 11 and size >= 4:
            number = int.from_bytes(sheet[place : place + 4], "little")
            row, column = (max(row, number), column) if kind == 0 else (row, max(column, number))
        place += size
    return (row + 1) * (column + 1)


def _packed_number(data: bytes, place: int, most: int) -> tuple[int, int]:
    number = 0
    for step in range(most):
        byte = data[place + step] if place + step < len(data) else 0
        number |= (byte & 0x7F) << (7 * step)
        if byte < 0x80:
            return number, place + step + 1
    return number, place + most


def _ods_cells(content: bytes) -> int:
    """Cells that the sheets of an ODS file span, repeated ones counted as often as they stand."""
    rows = columns = copied = blank = 0
    for found in _ODS_ROW.finditer(content):
        times = _times(found[1])
        across = last = 0
        for cell in _ODS_CELL.finditer(found[2] or b""):
            wide = _times(cell[1])
            across += wide
            if cell[2] or b"office:value" in cell[1]:
                last = across
                copied += times * wide * (len(cell[0]) // _CELL)
        columns = max(columns, last)
        rows, blank = (rows + blank + times, 0) if last else (rows, blank + times)
    return rows * columns + copied


def _times(attributes: bytes) -> int:
    found = _REPEATED.search(attributes)
    return int(found[1]) if found else 1


def _damaged(request: Request, what: str) -> CampaignError:
    return request.error(
        f"the workbook is damaged or cut short ({what}).", remedy="Copy or save it again."
    )
