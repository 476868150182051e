"""What a file holds: numbers where it has some, tables of pages, texts by line."""

from __future__ import annotations

import csv
import html
import io
import json
import re
import tomllib
import zipfile
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from scripts.golden.job import masked
from scripts.golden.values import column, digest, text

SKIPPED = (".png", ".svg", ".nc", ".h5", ".docx", ".pdf", ".so", ".dll")
"""Pictures, and files whose numbers stand in another one beside them."""
CODE = (".m", ".py", ".c", ".h", ".xml")
"""Generated programs, of which a digest is kept."""


def content(path: Path, folder: Path) -> Any:
    """What a file holds.

    Parameters
    ----------
    path : Path
        The file.
    folder : Path
        Whose name is masked in it.
    """
    suffix = path.suffix.lower()
    if suffix in SKIPPED:
        return "there"
    if suffix == ".xlsx":
        return _sheets(path)
    if suffix in (".zip", ".fmu"):
        return _packed(path, folder)
    told = masked(path.read_text(encoding="utf-8"), folder)
    if suffix == ".json":
        return json.loads(told)
    if suffix == ".toml":
        return tomllib.loads(told)
    if suffix == ".csv":
        return columns_of(told)
    if suffix in (".html", ".htm"):
        return tables_of(told)
    return digest(told) if suffix in CODE else text(told)


def columns_of(told: str) -> dict[str, Any]:
    """The columns of a CSV file, numbers as numbers; those below no name by their place."""
    rows = [row for row in csv.reader(io.StringIO(told)) if row]
    width = max(map(len, rows), default=0)
    names = [f"{k} {rows[0][k] if k < len(rows[0]) else ''}" for k in range(width)]
    return {
        name: column([_number(row[k]) if k < len(row) else "" for row in rows[1:]])
        for k, name in enumerate(names)
    }


def tables_of(page: str) -> dict[str, Any]:
    """The rows of the tables of a page, and a digest of all its words."""
    page = re.sub(r"<(style|script|svg)\b.*?</\1>", "", page, flags=re.DOTALL)
    rows = re.findall(r"<tr\b.*?</tr>", page, flags=re.DOTALL)
    cells = [re.findall(r"<t[hd]\b[^>]*>(.*?)</t[hd]>", row, flags=re.DOTALL) for row in rows]
    words = "\n".join(x for x in map(str.strip, _words(page).splitlines()) if x)
    return {
        "tables": [" | ".join(" ".join(_words(x).split()) for x in row) for row in cells],
        "words": digest(words),
    }


def _words(page: str) -> str:
    return html.unescape(re.sub(r"<[^>]+>", "\n", page))


def _packed(path: Path, folder: Path) -> dict[str, Any]:
    """The files of an archive."""
    with TemporaryDirectory() as place, zipfile.ZipFile(path) as archive:
        archive.extractall(place)
        inside = Path(place)
        return {
            item.relative_to(inside).as_posix(): content(item, folder)
            for item in sorted(inside.rglob("*"))
            if item.is_file()
        }


def _sheets(path: Path) -> dict[str, Any]:
    """The cells of a workbook, sheet by sheet."""
    import openpyxl

    book = openpyxl.load_workbook(path, read_only=True, data_only=True)
    found = {
        sheet.title: [[_cell(x) for x in row] for row in sheet.iter_rows(values_only=True)]
        for sheet in book.worksheets
    }
    book.close()
    return found


def _cell(value: Any) -> Any:
    return value if isinstance(value, (int, float, bool)) or value is None else masked(str(value))


def _number(told: str) -> Any:
    try:
        return float(told)
    except ValueError:
        return told
