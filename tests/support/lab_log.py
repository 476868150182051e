"""The reader of a laboratory's own logs, as a user writes it: one file."""

from __future__ import annotations

from pmmkit.readers import Cells, Reader
from pmmkit.readers.base import columns_of


class Log(Reader):
    """A line LOG, a line of names, rows of numbers between bars, a line END."""

    name = "lab log"
    words = "log of the laboratory"
    reads = "Logs: rows of numbers between bars."
    suffixes = (".log",)
    keys = ("missing",)

    def recognises(self, path, head):
        return head.startswith(b"LOG\n")

    def cells(self, request):
        try:
            lines = request.path.read_text(encoding="ascii").splitlines()
        except (OSError, UnicodeDecodeError) as error:
            raise request.error(f"cannot be read: {error}.") from error
        if len(lines) < 4 or lines[0] != "LOG" or lines[-1] != "END":
            raise request.error("it does not go from LOG to END.")
        headers, *rows = (tuple(line.split("|")) for line in lines[1:-1])
        odd = [place for place, row in enumerate(rows, 3) if len(row) != len(headers)]
        if odd:
            raise request.error(*(request.problem("too many or few fields.", row=x) for x in odd))
        return Cells(headers=headers, rows=tuple(rows), lines=tuple(range(3, len(rows) + 3)))

    def columns(self, request, choose):
        cells = self.cells(request)
        return columns_of(cells, choose(cells.headers, len(cells.headers)), request)
