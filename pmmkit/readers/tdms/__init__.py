"""Files of LabVIEW."""

from __future__ import annotations

from pathlib import Path

from pmmkit.readers.base import Cells, Choose, Columns, Reader, Request


class Tdms(Reader):
    """LabVIEW files, by npTDMS."""

    name = "tdms"
    words = "TDMS (LabVIEW)"
    reads = "LabVIEW files; the time is counted from `wf_increment`."
    suffixes = (".tdms",)
    binary = True
    keys = ("group", "sample_rate", "missing")

    def recognises(self, path: Path, head: bytes) -> bool:  # noqa: ARG002
        """Whether a file is TDMS, by its first bytes."""
        from pmmkit.readers.tdms.reader import TAG

        return head.startswith(TAG)

    def names(self, request: Request) -> tuple[str, ...]:
        """Headers of the channels, and of the time where their sampling is stated."""
        from pmmkit.readers.tdms import reader

        return reader.names(request)

    def columns(self, request: Request, choose: Choose) -> Columns:
        """Some channels as numbers, scaled as the file says."""
        from pmmkit.readers.tdms import reader

        return reader.columns(request, choose)

    def cells(self, request: Request) -> Cells:
        """Channels of the main length as a table, those of texts among them."""
        from pmmkit.readers.tdms import reader

        return reader.cells(request)
