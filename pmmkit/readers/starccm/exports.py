"""Which files are exports, and which of them belong to one run."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Final

from pmmkit.files import matching
from pmmkit.readers.base import Request, head_of

_QUOTED: Final = re.compile(r'"[^"]*(?: Monitor[":\s]|: Residual")|"Physical Time')
_FEW: Final = 40
"""Lines from which the beginning of an export is told."""


def recognises(path: Path, head: bytes) -> bool:
    """Whether a file begins with a header of monitors, or a folder holds such a file."""
    if not head and path.is_dir():
        return any(recognises(file, _head(file)) for file in _exports_in(path)[:20])
    line = head.removeprefix(b"\xef\xbb\xbf").lstrip().split(b"\n", 1)[0].decode("utf-8", "replace")
    return line.startswith('"') and _QUOTED.search(line) is not None


def files(request: Request) -> list[Path]:
    """The file itself, those that a pattern fits, or the .csv files of a folder.

    Raises
    ------
    CampaignError
        If a folder holds none.
    """
    path = request.path
    found = _exports_in(path) if path.is_dir() else list(matching(path))
    if path.is_dir() and not found:
        raise request.error(request.problem("the folder holds no .csv file."))
    return found or [path]


def are_one_run(folder: Path) -> bool:
    """Whether the exports of a folder differ in their columns, or one begins well after another."""
    heads = [_head(file).split(b"\n") for file in _exports_in(folder)]
    tops = {lines[0] for lines in heads}
    return len(heads) > 1 and (len(tops) == len(heads) or _follow(heads))


def _follow(heads: Sequence[Sequence[bytes]]) -> bool:
    """Whether files with the same columns begin at different times, as restarts do."""
    if len({lines[0] for lines in heads}) > 1:
        return False
    try:
        times = [[float(line.split(b",")[0]) for line in lines[1:_FEW]] for lines in heads]
    except ValueError:
        return False
    begins = sorted(own[0] for own in times if own)
    usual = max((own[-1] - own[0] for own in times if own), default=0.0)
    return len(begins) == len(heads) and all(b - a > usual for a, b in pairwise(begins))


def _exports_in(folder: Path) -> list[Path]:
    try:
        return sorted(
            file for file in folder.iterdir() if file.suffix.lower() == ".csv" and file.is_file()
        )
    except OSError:
        return []


def _head(file: Path) -> bytes:
    try:
        return head_of(file)
    except OSError:
        return b""
