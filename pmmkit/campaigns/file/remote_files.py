"""The files of a campaign that stand behind URLs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Any, Final

from pmmkit.base import DataError, Problem, Remedy, setting
from pmmkit.files import Origin, Url

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
            (setting("data"),),
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
