"""Exports of Simcenter STAR-CCM+."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from pmmkit.readers.base import Choose, Columns, Reader, Request


class StarCcm(Reader):
    """Exports of monitors and plots of Simcenter STAR-CCM+: one file, or several of one run."""

    name = "star-ccm+"
    words = "STAR-CCM+ export"
    reads = "Exports of monitors and plots, one file or several of one run."
    computed = True
    keys = ("skip_rows", "encoding", "delimiter", "decimal", "comment", "order", "missing")

    def recognises(self, path: Path, head: bytes) -> bool:
        """Whether a file begins with a header of monitors, or a folder holds such a file."""
        from pmmkit.readers.starccm import reader as exports

        return exports.recognises(path, head)

    def names(self, request: Request) -> tuple[str, ...]:
        """Headers of all files, each once."""
        from pmmkit.readers.starccm import reader

        return reader.names(request)

    def columns(self, request: Request, choose: Choose) -> Columns:
        """Some columns of one export or of several, merged on time."""
        from pmmkit.readers.starccm import reader

        return reader.columns(request, choose)

    def usual(self, headers: Sequence[str]) -> Mapping[str, str]:
        """Channels of columns whose own names leave no doubt."""
        from pmmkit.readers.starccm import reader

        return reader.usual(headers)

    def files(self, request: Request) -> Sequence[Path]:
        """The file itself, those that a pattern fits, or the .csv files of a folder."""
        from pmmkit.readers.starccm import reader as exports

        return exports.files(request)

    def is_one_run(self, folder: Path) -> bool:
        """Whether its exports differ in their columns, or one begins well after another."""
        from pmmkit.readers.starccm import reader as exports

        return exports.are_one_run(folder)
