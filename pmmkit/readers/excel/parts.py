"""Which parts of a workbook hold cells and texts: those that its relationships say.

A workbook is an archive of many parts: styles, drawings, caches of pivot tables, settings of the
printer, macros. Only sheets and the texts that they share become cells.
"""

from __future__ import annotations

import html
import posixpath
import re
import zipfile
from collections.abc import Iterator, Mapping
from typing import Final

from pmmkit.readers.zipped import content_of

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

    Parameters
    ----------
    members : mapping of str to ZipInfo
        The parts by name.
    data : bytes
        The workbook.
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
