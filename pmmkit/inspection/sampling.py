"""Parts of a text file that is too large to be read whole."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final

LARGE: Final = 64_000_000
"""Size from which a text file is not read whole [bytes]."""
_PARTS: Final = (8_000_000, 4_000_000, 4_000_000)
"""Sizes of the beginning, the middle and the end that are read [bytes]."""


@dataclass(frozen=True, kw_only=True)
class Sample:
    """A text file, or whole lines from its beginning, middle and end.

    Parameters
    ----------
    path : Path
        The file itself, or a temporary one with the lines.
    seams : tuple of int
        Lines of it, counted from 1, with which the later parts begin; empty for the file itself.
    share : float
        Size of the file over that of the lines.
    """

    path: Path
    seams: tuple[int, ...] = ()
    share: float = 1.0

    @property
    def partial(self) -> bool:
        """Whether lines were left out."""
        return bool(self.seams)


@contextmanager
def sample_of(path: Path) -> Iterator[Sample]:
    """A file if it is small, else a sample of its lines that is deleted at the end of the block.

    Parameters
    ----------
    path : Path
        A text file whose lines end in a newline byte.

    Raises
    ------
    OSError
        If it cannot be read, or the temporary file cannot be written.
    """
    size = path.stat().st_size
    if size < LARGE:
        yield Sample(path=path)
        return
    first, middle, last = _parts(path, size)
    seams = (first.count(b"\n") + 1, first.count(b"\n") + middle.count(b"\n") + 1)
    folder = Path(tempfile.mkdtemp(prefix="pmmkit-"))
    try:
        part = folder / f"sample{path.suffix}"
        part.write_bytes(first + middle + last)
        yield Sample(path=part, seams=seams, share=size / part.stat().st_size)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _parts(path: Path, size: int) -> tuple[bytes, bytes, bytes]:
    """Whole lines of the beginning, the middle and the end."""
    with path.open("rb") as stream:
        first = stream.read(_PARTS[0])
        stream.seek(size // 2)
        middle = stream.read(_PARTS[1])
        stream.seek(size - _PARTS[2])
        last = stream.read(_PARTS[2])
    return (
        first[: first.rfind(b"\n") + 1],
        middle[middle.find(b"\n") + 1 : middle.rfind(b"\n") + 1],
        last[last.find(b"\n") + 1 :],
    )
