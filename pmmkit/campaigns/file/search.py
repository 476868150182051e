"""Where the files of a campaign are looked for."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path, PurePosixPath
from typing import Any, Final

from pmmkit.base import CampaignError, DataError, Problem, Remedy, setting
from pmmkit.campaigns.file.faults import Faults
from pmmkit.campaigns.file.remote_files import RemoteFiles
from pmmkit.campaigns.run import at_hand
from pmmkit.files import CAMPAIGN, Origin, Url, matching
from pmmkit.readers import Request, reader_for, to_number

DATA_VARIABLE: Final = "PMMKIT_DATA"


@dataclass(frozen=True)
class Search:
    """Folders in which the files of a campaign are looked for.

    `own`: that of the campaign file. `data`: that of the measurements. `folder`: what the
    campaign file says of it. `remote`: where they are looked for behind URLs.
    """

    own: Path
    data: Path | None
    folder: str | None = None
    remote: RemoteFiles = field(default_factory=RemoteFiles)

    @classmethod
    def of(cls, place: Path, data: str | Path | None, own: Url | None = None) -> Search:
        """For a campaign file; the measurements are where is said, else where PMMKIT_DATA says."""
        given = data if data is not None else os.environ.get(DATA_VARIABLE) or None
        url = None if given is None else Url.of(given)
        here = None if given is None or url is not None else Path(given).expanduser()
        return cls(place.parent, here, remote=RemoteFiles(own=own, data=url))

    def within(self, folder: str | None) -> Search:
        """The same search in what the campaign file says of the measurements."""
        return replace(self, folder=folder, remote=replace(self.remote, folder=folder, _seen={}))

    def folders(self) -> list[Path]:
        """The folders, the first one first."""
        found = []
        if self.data is not None:
            own = self.remote.own
            if self.folder and (own is None or own.joined(self.folder) is not None):
                found.append(self.data / self.folder)
            found.append(self.data)
        return found if self.remote.own else [*found, self.own]

    def find(self, file: str) -> Request | None:
        """What is read for a name in the campaign file, here or behind a URL, or None."""
        path = self._path(file) if self.remote.own else None
        origin = None if path is not None else self.remote.find(file)
        if origin is not None:
            freely = self.remote.is_named_freely(file) and not self.remote.own
            return Request(
                path=Path(origin.shown), shown=Url(file).shown, origin=origin, withheld=freely
            )
        path = path or self._path(file)
        if path is None:
            return None
        return Request(path=path, shown=file, withheld=self._withheld(path))

    def _path(self, file: str) -> Path | None:
        """Path of a file, else of a folder of that name or of a pattern that files fit, or None."""
        if Url.of(file) is not None or (self.remote.own and self.remote.own.joined(file) is None):
            return None
        names = (file, file.replace("\\", "/"))
        places = [_joined(folder, name) for name in names for folder in self.folders()]
        kinds: tuple[Callable[[Path], object], ...] = (Path.is_file, Path.is_dir, matching)
        try:
            return next((place for there in kinds for place in places if there(place)), None)
        except (OSError, ValueError):
            return None

    def _withheld(self, path: Path) -> bool:
        """Whether a file lies outside of all these folders and no reader knows what it is."""
        from pmmkit.readers import recognise

        place = path.resolve()
        if any(place.is_relative_to(folder.resolve()) for folder in self.folders()):
            return False
        return recognise(next(iter(matching(path)), path)) is None

    def missing(self, file: str, entry: str, toml: str) -> Problem:
        """The problem of a file that is nowhere."""
        afar = self.remote.missing(file, entry, toml)
        if afar is not None:
            return afar
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

    `origin`: what stands behind its URL, if it has one.
    """

    archive: Path = Path()
    origin: Origin | None = None

    def within(self, folder: str | None) -> Search:
        """The same: nothing that the campaign file says leads elsewhere."""
        del folder
        return self

    def find(self, file: str) -> Request | None:
        """The archive, by its name; all of it came with the campaign file."""
        if file != self.archive.name:
            return None
        return Request(path=self.archive, shown=file, origin=self.origin)

    def missing(self, file: str, entry: str, toml: str) -> Problem:
        """The problem of a file that the archive does not hold."""
        return Problem(message=f"the file {file!r} is not in the archive.", file=toml, entry=entry)


def _joined(folder: Path, name: str) -> Path:
    """A place seen from a folder; ``..`` leads up from one too that is still to be made."""
    path = folder / name
    return path if folder.is_dir() else Path(os.path.normpath(path))


# A campaign that stands behind a URL: its file, its name, and the curve of its propeller.


def origin_of(path: str | Path, files: Sequence[str]) -> Origin | None:
    """The campaign file behind a URL; None for a path of this machine."""
    given = Url.of(path)
    if given is None:
        return None
    url = given.checked()
    if not url.shown.lower().endswith(tuple(files)):
        url = url.joined(CAMPAIGN.file) or url
    origin = Origin.of(url)
    if origin is None:
        raise CampaignError(
            "there is nothing behind this URL.",
            file=url.shown,
            remedy=f"Name a folder with {CAMPAIGN.file}, or a file that ends in one of "
            f"{', '.join(files)}.",
        )
    return origin


def folder_of(origin: Origin | None) -> Url | None:
    """URL of the folder of a campaign file; None for one of this machine."""
    return None if origin is None else Url(origin.shown.rpartition("/")[0])


def folder_name(place: Path, origin: Origin | None) -> str:
    """Name of the folder of a campaign file."""
    return (
        place.absolute().parent.name if origin is None else PurePosixPath(origin.shown).parent.name
    )


def with_curve(propeller: Mapping[str, Any], search: Search, out: Faults) -> dict[str, Any]:
    """What a campaign file says of the propeller, with the curve that stands behind a URL."""
    curve = propeller.get("open_water")
    if not isinstance(curve, str) or not (search.remote.own or Url.of(curve)):
        return dict(propeller)
    found = search.find(curve)
    if found is None:
        out.problems.append(search.missing(curve, "[propeller], key 'open_water'", out.file))
        return dict(propeller)
    try:
        table = table_of(at_hand(found))
    except DataError as error:
        out.problems += error.problems
        return dict(propeller)
    return {**propeller, "open_water": table}


def table_of(request: Request) -> dict[str, list[float | None]]:
    """The columns of a table of numbers by their titles, such as an open-water curve."""
    cells = reader_for(request).cells(request)
    columns = zip(*cells.rows, strict=True)
    return {
        title: [to_number(cell, cells.decimal) for cell in column]
        for title, column in zip(cells.headers, columns, strict=True)
    }
