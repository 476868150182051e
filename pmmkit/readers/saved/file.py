"""The file of a saved campaign: opened, checked, and the data of one run of it."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, cast

import numpy as np

from pmmkit.base import CampaignError, ModelError, PmmkitError, Problem, __version__
from pmmkit.files import from_json, read_toml, refuse_other, to_json
from pmmkit.readers.base import first_line
from pmmkit.readers.hdf5.datasets import LIBRARY_FAULTS
from pmmkit.readers.saved.group import (
    attribute,
    read_group,
    safe_names,
    text_of,
    unfit,
    write_group,
)

if TYPE_CHECKING:
    import xarray as xr

SCHEMA: Final = 1
"""Version of the layout; a file with a higher one is refused."""
FORMAT: Final = "pmmkit campaign"


@contextmanager
def saved_index(path: Path) -> Iterator[dict[str, Any]]:
    """Campaign and runs of a saved file; each run with the `loader` of its data.

    Parameters
    ----------
    path : Path
        The HDF5 file.

    Raises
    ------
    CampaignError
        If the file is missing, damaged, not a campaign or of a newer schema; of what is read
        inside the context too.
    """
    with opened(path) as file:
        index = read_index(file, path)
        for item in (*index["runs"], *index["excluded"]):
            item["run"]["loader"] = loader_of(item, path)
        yield index


def read_run(path: str | Path, run_id: str) -> xr.Dataset:
    """The data of one run of a saved campaign, without opening the campaign."""
    path = Path(path)
    with opened(path) as file:
        _check_schema(file, path)
        group = file.get(f"runs/{safe_names([run_id], 'run')[0]}")
        if group is None or text_of(group.attrs, "id") != run_id:
            return loader_of(_find(read_index(file, path), run_id, path), path)()
        return read_group(group, file=path.name)


@dataclass(frozen=True)
class _Loader:
    """Reads one group; the file is opened and closed at each call."""

    path: Path
    group: str

    def __call__(self) -> xr.Dataset:
        with opened(self.path) as file:
            return read_group(file[f"runs/{self.group}"], file=self.path.name)


@dataclass(frozen=True)
class _NotKept:
    """Stands for the data of an excluded run that could not be read when it was saved."""

    file: str
    run: str
    why: str

    def __call__(self) -> xr.Dataset:
        raise CampaignError(
            f"its data could not be read when the campaign was saved: {self.why}",
            file=self.file,
            run=self.run,
        )


@contextmanager
def opened(path: Path) -> Iterator[Any]:
    """The file for reading; every fault of the library becomes a CampaignError."""
    import h5py

    if path.is_dir() or path.suffix.lower() == ".toml":
        _refuse_toml(path)
    if not path.is_file():
        raise CampaignError("there is no such file.", file=str(path))
    try:
        with h5py.File(path, "r", locking="best-effort") as file:
            yield file
    except PmmkitError:
        raise
    except LIBRARY_FAULTS as error:
        raise CampaignError(
            f"cannot be read as a campaign: damaged, cut short or not HDF5 ({first_line(error)}).",
            file=str(path),
            remedy="Copy it again or save the campaign again from its source.",
        ) from error


def _refuse_toml(path: Path) -> None:
    """Refuse a campaign that is not saved but described, and other TOML files by their name."""
    file = path / "campaign.toml" if path.is_dir() else path
    try:
        content = read_toml(file)
    except ModelError:
        return
    refuse_other(content, None, str(file), CampaignError)


def _check_schema(file: Any, path: Path) -> None:
    if text_of(file.attrs, "format") != FORMAT:
        raise CampaignError(
            "this HDF5 file is not a campaign saved by pmmkit.",
            file=str(path),
            remedy="Describe it in a campaign.toml and open that instead.",
        )
    schema = int(np.asarray(file.attrs["schema"]).item())
    if schema > SCHEMA:
        raise CampaignError(
            f"the file has schema {schema}, written by pmmkit "
            f"{text_of(file.attrs, 'pmmkit')}; this is pmmkit {__version__}, which reads "
            f"schemas up to {SCHEMA}.",
            file=str(path),
            remedy="Update pmmkit.",
        )


def read_index(file: Any, path: Path) -> dict[str, Any]:
    """Campaign and runs of an opened file, its schema and checksum looked at."""
    _check_schema(file, path)
    text = text_of(file.attrs, "index")
    if text_of(file.attrs, "index_crc32") != checksum(text):
        raise CampaignError(
            "the index does not match its checksum: the file is damaged or was edited.",
            file=str(path),
            remedy="Save the campaign again from its source.",
        )
    return cast("dict[str, Any]", from_json(text))


def checksum(text: str) -> str:
    """CRC-32 of a text, as eight hexadecimal digits."""
    return f"{zlib.crc32(text.encode()):08x}"


def _find(index: Mapping[str, Any], run_id: str, path: Path) -> Mapping[str, Any]:
    items = [*index["runs"], *index["excluded"]]
    ids = [item["run"]["id"] for item in items]
    groups = [item["group"] for item in items]
    for known in (ids, groups):
        if run_id in known:
            return cast("Mapping[str, Any]", items[known.index(run_id)])
    raise CampaignError(
        f"the file has no run {run_id!r}; it has "
        f"{', '.join(ids[:12])}{' …' if len(ids) > 12 else ''}.",
        file=str(path),
    )


def loader_of(item: Mapping[str, Any], path: Path) -> Callable[[], xr.Dataset]:
    """What reads the data of an entry of the index, or says why they were not kept."""
    if "unreadable" in item:
        return _NotKept(path.name, item["run"]["id"], item["unreadable"])
    return _Loader(path.absolute(), item["group"])


@dataclass(frozen=True)
class CampaignWriter:
    """Writes runs into an open HDF5 file, then what is known of the campaign.

    Parameters
    ----------
    file : h5netcdf.File
        New and empty.
    """

    file: Any

    def add(self, entry: Mapping[str, Any], data: xr.Dataset, *, dry: bool) -> list[Problem]:
        """Write a run, or with `dry` only say what is wrong with it.

        Parameters
        ----------
        entry : mapping
            The `group` it is written to, and the `run` itself as JSON.
        data : Dataset
            Its data.
        dry : bool
            Whether nothing is written.
        """
        problems = unfit(data, entry["run"]["id"])
        if not (problems or dry):
            write_group(self.file.create_group(f"runs/{entry['group']}"), entry["run"], data)
        return problems

    def finish(self, title: str, content: Mapping[str, Any]) -> None:
        """Write the index: campaign, runs and excluded ones."""
        index = to_json(content)
        self.file.attrs["format"] = attribute(FORMAT)
        self.file.attrs["schema"] = SCHEMA
        self.file.attrs["pmmkit"] = attribute(__version__)
        self.file.attrs["title"] = attribute(title)
        self.file.attrs["index"] = attribute(index)
        self.file.attrs["index_crc32"] = attribute(checksum(index))
