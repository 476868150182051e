"""Where the files of a campaign are looked for."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from pmmkit.errors import Problem, Remedy, setting
from pmmkit.files import matching

DATA_VARIABLE: Final = "PMMKIT_DATA"


@dataclass(frozen=True)
class Search:
    """Folders in which the files of a campaign are looked for.

    Parameters
    ----------
    own : Path
        That of the campaign file.
    data : Path or None
        That of the measurements.
    folder : str or None
        What the campaign file says of it.
    """

    own: Path
    data: Path | None
    folder: str | None = None

    @classmethod
    def of(cls, place: Path, data: str | Path | None) -> Search:
        """For a campaign file; the measurements are where is said, else where PMMKIT_DATA says."""
        given = data if data is not None else os.environ.get(DATA_VARIABLE) or None
        return cls(place.parent, None if given is None else Path(given).expanduser())

    def folders(self) -> list[Path]:
        """The folders, the first one first."""
        found = []
        if self.data is not None:
            found += [self.data / self.folder] if self.folder else []
            found.append(self.data)
        return [*found, self.own]

    def find(self, file: str) -> Path | None:
        """Path of a file, else of a folder of that name or of a pattern that files fit, or None."""
        names = (file, file.replace("\\", "/"))
        places = [_joined(folder, name) for name in names for folder in self.folders()]
        kinds: tuple[Callable[[Path], object], ...] = (Path.is_file, Path.is_dir, matching)
        try:
            return next((place for there in kinds for place in places if there(place)), None)
        except (OSError, ValueError):
            return None

    def withheld(self, path: Path) -> bool:
        """Whether a file lies outside of all these folders and no reader knows what it is."""
        from pmmkit.readers import recognise

        place = path.resolve()
        if any(place.is_relative_to(folder.resolve()) for folder in self.folders()):
            return False
        return recognise(next(iter(matching(path)), path)) is None

    def missing(self, file: str, entry: str, toml: str) -> Problem:
        """The problem of a file that is nowhere."""
        tried = ", ".join(str(folder) for folder in self.folders())
        remedy = None
        if self.data is None or self.folder:
            remedy = Remedy(
                f"{{}} or {DATA_VARIABLE} names the folder of the measurements.", (setting("data"),)
            )
        return Problem(
            message=f"the file {file!r} is not there. Looked in: {tried}.",
            file=toml,
            entry=entry,
            remedy=remedy,
        )


@dataclass(frozen=True)
class InArchive(Search):
    """The archive in which a campaign lies: nothing else is looked for, wherever it points.

    Parameters
    ----------
    archive : Path
        The archive.
    """

    archive: Path = Path()

    def find(self, file: str) -> Path | None:
        """The archive, by its name."""
        return self.archive if file == self.archive.name else None

    def withheld(self, path: Path) -> bool:
        """Nothing: all of it came with the campaign file."""
        del path
        return False

    def missing(self, file: str, entry: str, toml: str) -> Problem:
        """The problem of a file that the archive does not hold."""
        return Problem(message=f"the file {file!r} is not in the archive.", file=toml, entry=entry)


def _joined(folder: Path, name: str) -> Path:
    """A place seen from a folder; ``..`` leads up from one too that is still to be made."""
    path = folder / name
    return path if folder.is_dir() else Path(os.path.normpath(path))
