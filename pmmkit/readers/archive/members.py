"""The files inside an archive, found by name and taken out one at a time."""

from __future__ import annotations

import mmap
import posixpath
import tempfile
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from pmmkit.base import CampaignError, did_you_mean
from pmmkit.readers.base import Request
from pmmkit.readers.bounds import (
    ZIP,
    check_length,
    content_of,
    damage_told,
    limit_of,
    members_of,
    too_large,
)

_WORKBOOK: Final = ("[Content_Types].xml", "mimetype")
_SHOWN: Final = 8


@dataclass(frozen=True, kw_only=True)
class Contents:
    """The files of an archive, by their names with ``/`` between folders.

    Parameters
    ----------
    data : mmap
        The archive, of which only what is asked for is read.
    files : mapping of str to ZipInfo
        Its entries, without folders.
    request : Request
        Where it lies, for messages.
    """

    data: mmap.mmap
    files: Mapping[str, zipfile.ZipInfo]
    request: Request

    @classmethod
    def of(cls, request: Request) -> Contents:
        """The files of an archive.

        Parameters
        ----------
        request : Request
            The archive.

        Raises
        ------
        CampaignError
            If it cannot be read, is damaged, or would expand to far more than its size.
        """
        with damage_told(lambda what: _damaged(request, what)):
            try:
                with request.path.open("rb") as file:
                    data = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
            except OSError as error:
                raise request.unreadable(error) from error
            members = members_of(data)
        declared = sum(item.file_size for item in members)
        if declared > limit_of(len(data)):
            raise too_large(request, declared, len(data), "the archive unpacked")
        files = {_tidy(item.filename): item for item in members if not item.is_dir()}
        return cls(data=data, files=files, request=request)

    def named(self, name: str) -> list[str]:
        """Files of a name, wherever they lie in it."""
        return [file for file in self.files if posixpath.basename(file) == name]

    @staticmethod
    def beside(name: str, other: str) -> str:
        """Name of a file that another one of the archive names, seen from the folder of that.

        Examples
        --------
        >>> Contents.beside("tests/campaign.toml", "records/01.csv")
        'tests/records/01.csv'
        >>> Contents.beside("tests/campaign.toml", "../static_means.csv")
        'static_means.csv'
        """
        return posixpath.normpath(posixpath.join(posixpath.dirname(name), _tidy(other)))

    def read(self, name: str) -> bytes:
        """The bytes of a file, which is as long as it says.

        Raises
        ------
        CampaignError
            If it is damaged.
        """
        item = self.files[name]
        with damage_told(lambda what: _damaged(self.request, what)):
            check_length(self.data, item)
            content = content_of(self.data, item)
        if zlib.crc32(content) != item.CRC:
            raise _damaged(self.request, f"{name} does not match its checksum")
        return content


def _tidy(name: str) -> str:
    return name.replace("\\", "/")


@contextmanager
def taken_out(request: Request) -> Iterator[Request]:
    """The file of an archive that is meant, alone in a folder that goes when it was read."""
    contents = Contents.of(request)
    name = _meant(contents, request)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "inside.csv"
        path.write_bytes(contents.read(name))
        options = replace(request.options, format=None, group=None)
        yield replace(request, path=path, shown=f"{request.shown}/{name}", options=options)


def _meant(contents: Contents, request: Request) -> str:
    names = list(contents.files)
    group = request.options.group
    if group is None and len(names) == 1:
        return names[0]
    if group is not None and _tidy(group) in contents.files:
        return _tidy(group)
    shown = ", ".join(names[:_SHOWN]) + (" …" if len(names) > _SHOWN else "")
    if group is None:
        raise request.error(
            f"the archive holds {len(names)} files: {shown or 'none'}.",
            remedy="Name one in [source]: group = …; an archive with a campaign.toml is "
            "opened as a campaign itself.",
        )
    raise request.error(
        f"the archive has no file {group!r}{did_you_mean(group, names) or '.'} It has "
        f"{shown or 'none'}."
    )


def holds_files(path: Path, head: bytes) -> bool:
    """Whether a file is an archive with files in it, and no workbook."""
    if not head.startswith(ZIP) or not zipfile.is_zipfile(path):
        return False
    try:
        with zipfile.ZipFile(path) as archive:
            names = archive.namelist()
    except (OSError, ValueError, NotImplementedError, zipfile.BadZipFile):
        return False
    return bool(names) and not any(name in _WORKBOOK for name in names)


def _damaged(request: Request, what: str) -> CampaignError:
    return request.error(
        f"the archive is damaged or cut short ({what}).", remedy="Copy or pack it again."
    )
