"""A campaign inside a zip archive: its campaign file, and where in the archive its runs lie."""

from __future__ import annotations

import posixpath
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any, Final

from pmmkit.base import CampaignError, Problem
from pmmkit.campaigns.file.search import table_of
from pmmkit.files import CAMPAIGN
from pmmkit.readers import Contents, Options, Request

if TYPE_CHECKING:
    from collections.abc import Iterator

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
    homes = _homes(contents)
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


def is_packed_campaign(path: Path) -> bool:
    """Whether a file is an archive that holds a campaign file; a damaged one does not.

    Parameters
    ----------
    path : Path
        The file.
    """
    try:
        return path.suffix.lower() == f".{FORMAT}" and bool(
            _homes(Contents.of(Request(path=path, shown=path.name)))
        )
    except CampaignError:
        return False


def _homes(contents: Contents) -> list[str]:
    return [name for name in contents.files if posixpath.basename(name) == CAMPAIGN.file]
