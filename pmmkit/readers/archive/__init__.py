"""Text files inside a zip archive, as workshops and laboratories hand them on."""

from __future__ import annotations

from pathlib import Path

from pmmkit.readers.base import Cells, Choose, Columns, Reader, Request
from pmmkit.readers.text import DelimitedText


class Archive(Reader):
    """Text files of columns inside a zip archive, read without unpacking it."""

    name = "zip"
    words = "zip archive"
    reads = "Text of columns inside a zip archive; `group` names the file, with its folder."
    suffixes = (".zip",)
    binary = True
    keys = ("group", *DelimitedText.keys)

    def recognises(self, path: Path, head: bytes) -> bool:
        """Whether a file is an archive and no workbook, by its first bytes and its directory."""
        from pmmkit.readers.archive.members import holds_files

        return holds_files(path, head)

    def names(self, request: Request) -> tuple[str, ...]:
        """Headers of the file inside, empty strings where it has none."""
        from pmmkit.readers.archive.members import taken_out

        with taken_out(request) as inside:
            return DelimitedText().names(inside)

    def columns(self, request: Request, choose: Choose) -> Columns:
        """Some columns of the file inside as numbers."""
        from pmmkit.readers.archive.members import taken_out

        with taken_out(request) as inside:
            return DelimitedText().columns(inside, choose)

    def cells(self, request: Request) -> Cells:
        """All cells of a small file inside as text."""
        from pmmkit.readers.archive.members import taken_out

        with taken_out(request) as inside:
            return DelimitedText().cells(inside)
