"""Text files of columns."""

from __future__ import annotations

from pathlib import Path

from pmmkit.readers.base import Cells, Choose, Columns, Reader, Request


class DelimitedText(Reader):
    """Text files of columns; what no other reader knows is taken for one."""

    name = "csv"
    words = "text of columns"
    reads = "Text of columns: comma, semicolon, tab, blanks, or columns of fixed width."
    suffixes = (".csv",)
    general = True
    fallback = "file"
    keys = (
        "skip_rows",
        "encoding",
        "delimiter",
        "decimal",
        "header",
        "units_row",
        "comment",
        "widths",
        "where",
        "missing",
    )

    def recognises(self, path: Path, head: bytes) -> bool:  # noqa: ARG002
        """Whether the text holds rows of numbers in columns."""
        from pmmkit.readers.text.layout import TextLayout

        return TextLayout.of(head) is not None

    def names(self, request: Request) -> tuple[str, ...]:
        """Headers of the file, empty strings where it has none."""
        from pmmkit.readers.text import csv

        return csv.names(request)

    def columns(self, request: Request, choose: Choose) -> Columns:
        """Some columns as numbers."""
        from pmmkit.readers.text import csv

        return csv.columns(request, choose)

    def cells(self, request: Request) -> Cells:
        """All cells of a small file as text."""
        from pmmkit.readers.text import csv

        return csv.cells(request)
