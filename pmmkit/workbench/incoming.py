"""Files that were dropped on the page: kept under safe names, beside the campaign made of them."""

from __future__ import annotations

import os
import re
import uuid
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any, Final

from pmmkit.base import DataError
from pmmkit.files import CAMPAIGN, free_folder

LARGEST: Final = 256_000_000
"""Bytes of a file that is dropped."""
MOST: Final = 2000
"""Files of a set."""
LONGEST: Final = 120
"""Characters of a name."""
DEEPEST: Final = 8
"""Folders below one another: a case of OpenFOAM has six."""
PLACE: Final = "dropped"
"""Folder of the first set below that of the workbench; others have a number."""
_SET: Final = re.compile(rf"{PLACE}(-[0-9]{{1,4}})?")
_DEVICES: Final = re.compile(
    r"(con|prn|aux|nul|com[0-9¹²³]|lpt[0-9¹²³]|conin\$|conout\$)(\..*)?", re.I
)
_ODD: Final = frozenset('<>:"|?*\\/')


def safe_name(name: str) -> str:
    r"""A name that is a file's on every system, and leads to no other folder.

    Examples
    --------
    >>> safe_name("Schräg 01.csv")
    'Schräg 01.csv'
    >>> safe_name("../run.csv")
    Traceback (most recent call last):
    pmmkit.base.errors.DataError: “../run.csv” cannot be kept: it holds /. Rename it ...
    """
    odd = "".join(sorted({char for char in name if char in _ODD or not char.isprintable()}))
    if not name.strip() or len(name) > LONGEST or len(name.encode("utf-8", "replace")) > 240:
        why = f"a name has 1 to {LONGEST} characters"
    elif odd:
        why = f"it holds {odd if odd.isprintable() else 'characters that cannot be shown'}"
    elif name.startswith((".", "~$", " ")) or name.endswith((".", " ")):
        why = "it begins or ends with a point or a blank"
    elif _DEVICES.fullmatch(name):
        why = "it is the name of a device on Windows"
    else:
        return name
    shown = name if len(name) <= LONGEST else f"{name[:40]} …"
    raise DataError(f"“{shown}” cannot be kept: {why}. Rename it and drop it again.")


def safe_path(name: str) -> Path:
    r"""Where a file of a set lies, by its name and those of the folders it was dropped with.

    Examples
    --------
    >>> safe_path("drift/run 01.csv").parts
    ('drift', 'run 01.csv')
    >>> safe_path("../run.csv")
    Traceback (most recent call last):
    pmmkit.base.errors.DataError: “..” cannot be kept: it begins or ends with a point ...
    """
    parts = name.split("/")
    if len(parts) > DEEPEST or len(name) > 2 * LONGEST:
        raise DataError(
            f"“{name[:40]} …” lies too deep: at most {DEEPEST - 1} folders and {2 * LONGEST} "
            "characters are kept. Name its folder instead, then it is read where it lies."
        )
    return Path(*map(safe_name, parts))


def place_of(folder: Path, into: str) -> Path:
    """The folder of a set that is there, or of a new one where none is named."""
    if not into:
        place = free_folder(folder / PLACE)
        place.mkdir(parents=True, exist_ok=True)
        return place
    if not _SET.fullmatch(into) or not (folder / into).is_dir() or (folder / into).is_symlink():
        raise DataError(f"There is no set of files {into!r}. Drop the files again.")
    return folder / into


async def keep(place: Path, name: str, chunks: AsyncIterator[bytes]) -> int:
    """Write a file as it comes, under a temporary name until it is whole; nothing is replaced.

    `name` may lead through folders, each after a slash.
    """
    target = place / safe_path(name)
    _refuse_twice(place, target)
    part = place / f".{uuid.uuid4().hex[:12]}.part"
    size = 0
    try:
        with part.open("xb") as stream:
            async for chunk in chunks:
                size += len(chunk)
                if size > LARGEST:
                    raise DataError(
                        f"{name} is larger than {LARGEST // 1_000_000} MB: it was not kept. Name "
                        "its folder instead, then it is read where it lies."
                    )
                stream.write(chunk)
            stream.flush()
            os.fsync(stream.fileno())
        if not size:
            raise DataError(f"{name} is empty (0 bytes): it was not kept.")
        _refuse_twice(place, target)
        target.parent.mkdir(parents=True, exist_ok=True)
        # The name is taken first, and closed: Windows replaces no file that is open.
        target.open("xb").close()
        os.replace(part, target)
    except (FileExistsError, NotADirectoryError) as error:
        raise _twice(name) from error
    except OSError as error:
        raise DataError(f"{name} cannot be kept: {error.strerror}.") from error
    finally:
        part.unlink(missing_ok=True)
    return size


def sets(folder: Path) -> list[dict[str, Any]]:
    """The sets that were dropped, the last first, with their files."""
    found = [
        place
        for place in folder.glob(f"{PLACE}*")
        if place.is_dir() and not place.is_symlink() and _SET.fullmatch(place.name)
    ]
    found.sort(key=lambda place: place.stat().st_mtime_ns, reverse=True)
    return [
        {
            "into": place.name,
            "folder": str(place),
            "files": files_of(place),
            "campaign": (place / CAMPAIGN.file).is_file(),
        }
        for place in found
    ]


def files_of(place: Path) -> list[dict[str, Any]]:
    """Names and sizes of the files of a set, those of its folders too."""
    return [
        {"name": file.relative_to(place).as_posix(), "size": file.stat().st_size}
        for file in sorted(place.rglob("*"))
        if file.is_file() and not file.name.startswith(".") and file != place / CAMPAIGN.file
    ]


def _refuse_twice(place: Path, target: Path) -> None:
    beside = target.parent.iterdir() if target.parent.is_dir() else ()
    if target.name.casefold() in {file.name.casefold() for file in beside}:
        raise _twice(target.relative_to(place).as_posix())
    if sum(len(files) for _, _, files in os.walk(place)) >= MOST:
        raise DataError(f"A set has at most {MOST} files. Name their folder instead.")


def _twice(name: str) -> DataError:
    return DataError(
        f"A file called {name} is there already: it was not replaced. Rename one of them."
    )
