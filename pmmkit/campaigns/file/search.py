"""Where the files of a campaign are looked for."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any, Final

from pmmkit.base import CampaignError, DataError, Problem, Remedy, Way
from pmmkit.campaigns.run import at_hand
from pmmkit.files import CAMPAIGN, Origin, Url, matching
from pmmkit.readers import Contents, Options, Request, reader_for, to_number

if TYPE_CHECKING:
    from collections.abc import Iterator

    from pmmkit.campaigns.file.single_tables import Faults


# The files of a campaign that stand behind URLs.


AT_ONCE: Final = 16
"""Files that are looked for side by side, as each look waits for its store."""
_FOLDERS: Final = "Files behind URLs are read one by one: a folder or pattern is copied first."


@dataclass(frozen=True, kw_only=True)
class RemoteFiles:
    """Where the files of a campaign are looked for behind URLs.

    A campaign that was opened by a URL names files below its own folder, and nowhere else.

    `own`: URL of the folder of the campaign file; None where it lies on this machine. `data`:
    URL of the measurements that somebody asked for, or None. `folder`: what the campaign file
    says of them.
    """

    own: Url | None = None
    data: Url | None = None
    folder: str | None = None
    _seen: dict[str, Origin | Problem | None] = field(default_factory=dict, repr=False)

    def find(self, file: str) -> Origin | None:
        """What stands behind the URL of a file, or None; each is looked for once."""
        if file not in self._seen:
            self._seen[file] = self._looked(file)
        found = self._seen[file]
        return found if isinstance(found, Origin) else None

    def find_all(self, files: Iterable[str]) -> None:
        """Look for several files side by side."""
        new = [file for file in dict.fromkeys(files) if self._concerns(file)]
        if new:
            with ThreadPoolExecutor(min(AT_ONCE, len(new))) as pool:
                list(pool.map(self.find, new))

    def missing(self, file: str, entry: str, toml: str) -> Problem | None:
        """The problem of a file that is behind none of the URLs; None where there are none."""
        if not self._concerns(file):
            return None
        found = self._seen.get(file)
        if isinstance(found, Problem):
            return Problem(message=found.message, file=toml, entry=entry, remedy=found.remedy)
        tried = ", ".join(url.shown for url in self._places(file))
        remedy = _FOLDERS if "*" in file else None
        return Problem(
            message=f"the file {Url(file).shown!r} is not there. Looked at: {tried}.",
            file=toml,
            entry=entry,
            remedy=remedy,
        )

    def is_named_freely(self, file: str) -> bool:
        """Whether nothing but the campaign file says that a file is to be read."""
        return Url.of(file) is not None or Url.of(self.folder or "") is not None

    def _concerns(self, file: str) -> bool:
        return bool(self.own or self.data or Url.of(file) or Url.of(self.folder or ""))

    def _looked(self, file: str) -> Origin | Problem | None:
        try:
            places = list(self._places(file)) if self._concerns(file) else []
            return next((found for url in places if (found := Origin.of(url))), None)
        except DataError as error:
            item = error.problems[0]
            return Problem(
                message=f"{item.file or Url(file).shown}: {item.message}", remedy=item.remedy
            )

    def _places(self, file: str) -> Iterator[Url]:
        """URLs behind which a file may be, the first one first."""
        given = Url.of(file)
        if given is not None:
            yield self._allowed(given.checked())
            return
        if self.own and self.own.joined(file) is None:
            raise _outside(f"{file!r} leads out of the folder of the campaign.")
        folder = Url.of(self.folder or "")
        if folder is not None:
            yield from _below(self._allowed(folder.checked()), file)
        if self.data:
            inside = self.data.joined(self.folder) if self.folder and folder is None else None
            yield from _below(inside, file)
            yield from _below(self.data.checked(), file)
        if self.own:
            yield from _below(self.own, file)

    def _allowed(self, url: Url) -> Url:
        """A URL that the campaign file names, if it may."""
        roots = [Url(f"{root.rstrip('/')}/") for root in (self.own, self.data) if root]
        inside = any(url.startswith(root) and root.joined(url[len(root) :]) for root in roots)
        if self.own and not inside:
            raise _outside(f"{url.shown} is not below the folder of the campaign.")
        return url


def _below(folder: Url | None, file: str) -> Iterator[Url]:
    url = None if folder is None else folder.joined(file)
    if url is not None:
        yield url


def _outside(message: str) -> DataError:
    return DataError(
        message,
        remedy=Remedy(
            "A campaign behind a URL names files below its own folder; {} may name another one "
            "besides.",
            (Way.setting("data"),),
        ),
    )


def names_in(raw: Mapping[str, Any]) -> list[str]:
    """The files that a campaign file names.

    Examples
    --------
    >>> names_in({"runs": [{"file": "a.csv"}, {"file": "b.csv", "motion": "c.csv"}]})
    ['a.csv', 'b.csv', 'c.csv']
    """
    listed = [raw.get(name) for name in ("runs", "tables", "matrix")]
    entries = [item for entry in listed if isinstance(entry, list) for item in entry]
    named = [
        item.get(key) for item in entries if isinstance(item, Mapping) for key in ("file", "motion")
    ]
    return [name for name in named if isinstance(name, str)]


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
                f"{{}} or {DATA_VARIABLE} names the folder of the measurements.",
                (Way.setting("data"),),
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


# A campaign inside a zip archive: its campaign file, and where in the archive its runs lie.


FORMAT: Final = "zip"
"""Format of the runs' files."""
_TEXT: Final = (None, "csv", FORMAT)
_UNPACK: Final = "Unpack it and open the folder."


@dataclass(frozen=True, kw_only=True)
class Packed:
    """The campaign file of an archive.

    `name`: the campaign file inside.
    """

    archive: Path
    contents: Contents
    name: str

    @property
    def place(self) -> Path:
        """Where the campaign file lies, the archive taken for a folder."""
        return self.archive / PurePosixPath(self.name)

    def text(self) -> bytes:
        """The campaign file."""
        return self.contents.read(self.name)

    def pointed(self, raw: Mapping[str, Any]) -> dict[str, Any]:
        """The content of the campaign file with every file named by its place in the archive."""
        problems = list(self._unfit(raw))
        if problems:
            raise CampaignError(problems)
        found = {
            name: [self._entry(item) for item in value]
            if name in ("runs", "tables") and isinstance(value, list)
            else value
            for name, value in raw.items()
        }
        propeller = raw.get("propeller")
        curve = propeller.get("open_water") if isinstance(propeller, Mapping) else None
        if isinstance(propeller, Mapping) and isinstance(curve, str):
            found["propeller"] = {**propeller, "open_water": self._table(curve)}
        return found

    def _unfit(self, raw: Mapping[str, Any]) -> Iterator[Problem]:
        if "matrix" in raw:
            yield self._problem("[[matrix]]", "tests of a matrix are not read out of an archive.")
        sources = {"[source]": raw, "[defaults]": raw.get("defaults")}
        for name in ("runs", "tables"):
            listed = raw.get(name)
            for place, item in enumerate(listed if isinstance(listed, list) else [], start=1):
                sources[f"[[{name}]] #{place}"] = item
                if isinstance(item, Mapping) and "motion" in item:
                    yield self._problem(
                        f"[[{name}]] #{place}",
                        "a file of the motion is not read out of an archive.",
                    )
        for entry, item in sources.items():
            source = item.get("source") if isinstance(item, Mapping) else None
            stated = source.get("format") if isinstance(source, Mapping) else None
            if stated not in _TEXT:
                yield self._problem(
                    entry, f"files of the format {stated!r} are not read out of an archive."
                )

    def _problem(self, entry: str, message: str) -> Problem:
        return Problem(message=message, file=self.archive.name, entry=entry, remedy=_UNPACK)

    def _entry(self, item: Any) -> Any:
        """A run or table with the archive for its file, and what it named for the file inside."""
        if not isinstance(item, Mapping) or not isinstance(item.get("file"), str):
            return item
        source = item.get("source", {})
        if not isinstance(source, Mapping):
            return item
        inside = {**source, "format": FORMAT, "group": self._inside(item["file"])}
        return {**item, "file": self.archive.name, "source": inside}

    def _inside(self, file: str) -> str:
        return self.contents.beside(self.name, file)

    def _table(self, file: str) -> dict[str, list[float | None]]:
        """The columns of a table of numbers, such as an open-water curve."""
        request = Request(
            path=self.archive,
            shown=self.archive.name,
            options=Options(format=FORMAT, group=self._inside(file)),
        )
        return table_of(request)


def packed_campaign(archive: Path) -> Packed:
    """The campaign file inside an archive, wherever it lies in it."""
    contents = Contents.of(Request(path=archive, shown=archive.name))
    homes = contents.named(CAMPAIGN.file)
    if len(homes) != 1:
        listed = ", ".join(list(contents.files)[:8]) or "nothing"
        raise CampaignError(
            f"the archive holds {len(homes)} files {CAMPAIGN.file}, not one."
            if homes
            else f"the archive holds no {CAMPAIGN.file}; it has {listed}.",
            file=archive.name,
            remedy=_UNPACK
            if homes
            else f"Write a {CAMPAIGN.file} beside it whose runs have file = {archive.name!r} "
            "and source = { group = … }, the name of the file inside.",
        )
    return Packed(archive=archive, contents=contents, name=homes[0])
