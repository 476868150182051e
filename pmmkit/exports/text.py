"""What files written for other programs have alike."""

from __future__ import annotations

import zipfile
from collections.abc import Iterable
from pathlib import Path
from typing import BinaryIO, Final

from pmmkit.base import Remedy, Way, __version__
from pmmkit.syntax import comment

# Zip archives that are the same to the bit whenever they are made.


DATE: Final = (1980, 1, 1, 0, 0, 0)
"""Time of each entry: the first that the format knows."""


def write_archive(target: Path | BinaryIO, files: Iterable[tuple[str, bytes]]) -> None:
    """Write a zip archive without times and owners.

    Examples
    --------
    >>> import io
    >>> one, two = io.BytesIO(), io.BytesIO()
    >>> for room in (one, two):
    ...     write_archive(room, [("a/b.txt", b"1 2 3")])
    >>> one.getvalue() == two.getvalue(), zipfile.ZipFile(one).namelist()
    (True, ['a/b.txt'])
    """
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files:
            entry = zipfile.ZipInfo(name, DATE)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, content)


WHICH_SPEED: Final = Remedy("Say at which speed [m/s], such as {}.", (Way.setting("speed", 8),))
"""Where values depend on the speed and none was given."""


def written_by(sign: str = "%") -> list[str]:
    """Lines of a comment that say which program wrote a file."""
    return comment(f"Written by pmmkit {__version__}.", sign)
