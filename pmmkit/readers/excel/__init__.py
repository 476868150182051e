"""Workbooks."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from pmmkit.readers.base import Cells, Choose, Columns, Reader, Request

_PARTS: Final = (b"xl/", b"[Content_Types].xml", b"opendocument.spreadsheet")


class Workbook(Reader):
    """Workbooks, by calamine: the values that were last computed."""

    name = "excel"
    words = "workbook"
    reads = "Workbooks: the values that were last computed."
    suffixes = (".xls", ".xlsx", ".xlsm", ".xlsb", ".ods")
    binary = True
    keys = ("skip_rows", "last_row", "header", "sheet", "missing")

    def recognises(self, path: Path, head: bytes) -> bool:  # noqa: ARG002
        """Whether a file is a workbook, by its first bytes."""
        from pmmkit.readers.bounds import ZIP
        from pmmkit.readers.excel.guard import CFB

        if head.startswith(ZIP):
            return any(part in head for part in _PARTS)
        return head.startswith(CFB)

    def names(self, request: Request) -> tuple[str, ...]:
        """Headers of the sheet."""
        return self.cells(request).headers

    def columns(self, request: Request, choose: Choose) -> Columns:
        """Some columns of the sheet as numbers; times of day and dates as seconds."""
        from pmmkit.readers.excel import reader

        return reader.columns(request, choose)

    def cells(self, request: Request) -> Cells:
        """All cells below the header; dates as text."""
        from pmmkit.readers.excel import reader

        return reader.cells(request)

    def sheets(self, request: Request) -> tuple[str, ...]:
        """Names of the sheets."""
        from pmmkit.readers.excel import reader

        return reader.sheets(request)
