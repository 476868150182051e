"""The file of a saved campaign: opened, checked, and the data of one run of it."""

from __future__ import annotations

import math
import re
import zlib
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, cast

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import CampaignError, ModelError, PmmkitError, Problem, __version__
from pmmkit.conventions import CHANNEL_UNITS
from pmmkit.files import from_json, read_toml, refuse_other, to_json
from pmmkit.readers.base import first_line
from pmmkit.readers.hdf5.datasets import LIBRARY_FAULTS

if TYPE_CHECKING:
    import xarray as xr


# One run in one HDF5 group: its Dataset written with h5netcdf and read back identical.


SMALL: Final = 4096
"""Bytes below which compression costs more than it saves."""
CHUNK: Final = 2**20
"""Bytes of a chunk: a usual channel is one chunk, so it is read in one go."""

_MEANINGS: Final[dict[str, str]] = {
    "t": "time",
    "X": "surge force on the hull",
    "Y": "sway force on the hull",
    "N": "yaw moment on the hull",
    "K": "roll moment on the hull",
    "u": "surge velocity",
    "v": "sway velocity",
    "r": "yaw rate",
    "p": "roll rate",
    "phi": "heel, positive to starboard",
    "psi": "heading, positive to starboard",
    "x": "position along the tank, or north",
    "y": "position across the tank, or east",
    "udot": "surge acceleration in ship axes",
    "vdot": "sway acceleration in ship axes",
    "rdot": "yaw acceleration",
    "pdot": "roll acceleration",
    "xdot": "earth-fixed velocity along x",
    "ydot": "earth-fixed velocity along y",
    "delta": "rudder angle, positive turns to starboard",
    "n": "propeller revolutions per second",
    "T": "propeller thrust",
    "Q": "propeller torque",
    "FX_rudder": "rudder force along x",
    "FY_rudder": "rudder force along y",
    "sinkage": "sinkage, positive down",
    "trim": "trim, positive bow up",
    "wind_speed": "relative wind speed at midship",
    "wind_direction": "where the relative wind comes from, off the bow to starboard",
    "lat": "latitude",
    "lon": "longitude, east positive",
    "sog": "speed over ground",
    "cog": "course over ground",
    "harmonic": "order of the harmonic",
    "speed": "speed of the carriage",
    "U_carriage": "speed of the carriage along its rails",
    "Y_forward": "side force on the forward gauge",
    "Y_aft": "side force on the aft gauge",
    "y_forward": "position of the forward strut across the tank",
    "y_aft": "position of the aft strut across the tank",
}
_PARTS: Final = {
    "cos": "{}, cosine harmonics (in phase with the velocity)",
    "sin": "{}, sine harmonics (in phase with the displacement)",
    "std": "{}, standard uncertainty",
}


def described(name: str) -> tuple[str, str]:
    """Unit and long name of a channel; ``unknown`` and the name itself where it is not known.

    Examples
    --------
    >>> described("N_sin")
    ('N m', 'yaw moment on the hull, sine harmonics (in phase with the displacement)')
    """
    if name in _MEANINGS:
        return CHANNEL_UNITS.get(name, "1"), _MEANINGS[name]
    base, _, part = name.rpartition("_")
    unit, label = described(base) if base and part in _PARTS else ("unknown", name)
    return unit, _PARTS[part].format(label) if unit != "unknown" else name


def safe_names(names: Iterable[str], stem: str) -> list[str]:
    """Names that HDF5, NetCDF and MATLAB accept, each once, in the order given.

    Parameters
    ----------
    names : iterable of str
        Any names.
    stem : str
        What a name begins with that has no letter or digit to begin with.

    Examples
    --------
    >>> safe_names(["SD_b+08", "PS 1/2", "PS_1:2", "."], "run")
    ['SD_b+08', 'PS_1_2', 'PS_1_2_2', 'run_.']
    """
    taken: dict[str, None] = {}
    for name in names:
        plain = re.sub(r"[^A-Za-z0-9_.+-]", "_", name)
        plain = plain if re.match(r"[A-Za-z0-9_]", plain) else f"{stem}_{plain}"
        number, unique = 1, plain
        while unique in taken:
            number += 1
            unique = f"{plain}_{number}"
        taken[unique] = None
    return list(taken)


def unfit(data: xr.Dataset, run_id: str) -> list[Problem]:
    """What keeps a Dataset from being stored and read back as it is."""
    problems = [
        Problem(message=f"the dimension {dim} has no samples.", run=run_id, column=str(dim))
        for dim, size in data.sizes.items()
        if size == 0
    ]
    for name, variable in data.variables.items():
        kind, size = variable.dtype.kind, variable.dtype.itemsize
        plain = kind in "biuU" or (kind == "f" and size in (4, 8))
        if kind == "O":
            plain = all(isinstance(item, str) for item in np.ravel(variable.values))
        if not (plain and isinstance(name, str)):
            problems.append(
                Problem(
                    message=f"values of type {variable.dtype} cannot be stored.",
                    run=run_id,
                    column=str(name),
                    remedy="Use numbers (time as seconds) or text.",
                )
            )
    try:
        to_json(_description(data, {name: str(name) for name in data.variables}))
    except CampaignError as error:
        problems += [Problem(message=str(error), run=run_id, column="attributes")]
    return problems


def write_group(group: Any, entry: Mapping[str, Any], data: xr.Dataset) -> None:
    """Write a run's Dataset and what is known of the run into an empty h5netcdf group."""
    names = dict(zip(data.variables, safe_names(map(str, data.variables), "v"), strict=True))
    dims = {dim: names.get(dim, f"dim_{number}") for number, dim in enumerate(data.sizes)}
    group.dimensions = {dims[dim]: size for dim, size in data.sizes.items()}
    contents = []
    for name, variable in data.variables.items():
        stored = _stored(np.asarray(variable.values))
        target = group.create_variable(
            names[name], tuple(dims[dim] for dim in variable.dims), **_storage(stored)
        )
        target[...] = stored
        unit, label = described(str(name))
        target.attrs["units"] = _plain_text(variable.attrs.get("units", unit))
        target.attrs["long_name"] = _plain_text(variable.attrs.get("long_name", label))
        if variable.dtype.kind == "b":
            target.attrs["dtype"] = "bool"
        if stored.dtype.kind != "O":
            contents.append(stored.tobytes())
    if beside := [names[name] for name in data.coords if name not in data.sizes]:
        group.attrs["coordinates"] = " ".join(beside)
    texts = (to_json(entry), to_json(_description(data, names)))
    group.attrs["id"] = attribute(entry["id"])
    group.attrs["run"], group.attrs["variables"] = map(attribute, texts)
    group.attrs["crc32"] = attribute(_checksum(texts, contents))


def read_group(group: Any, *, file: str) -> xr.Dataset:
    """The Dataset of an h5py group that `write_group` wrote."""
    import xarray as xr

    texts = (text_of(group.attrs, "run"), text_of(group.attrs, "variables"))
    description = from_json(texts[1])
    holders: dict[bool, dict[Hashable, Any]] = {True: {}, False: {}}
    contents = []
    for name, entry in description["variables"].items():
        dtype = np.dtype(entry["dtype"])
        if "text" in entry:
            values = np.array(entry["text"], dtype=dtype)
        else:
            stored = np.asarray(group[entry["stored_as"]][()])
            contents.append(stored.tobytes())
            values = stored.astype(dtype, copy=False)
        holders[entry["coordinate"]][name] = (entry["dims"], values, entry["attributes"])
    if text_of(group.attrs, "crc32") != _checksum(texts, contents):
        raise CampaignError(
            "the data do not match their checksum: the file is damaged or was edited.",
            file=file,
            run=text_of(group.attrs, "id"),
            remedy="Save the campaign again from its source.",
        )
    return xr.Dataset(holders[False], holders[True], description["attributes"])


def attribute(value: object) -> NDArray[Any]:
    """Text as an attribute of fixed length.

    Variable-length text lies in HDF5's global heap, which has no checksum and on which the library
    can loop for ever when it is damaged; what pmmkit reads back is kept out of it.
    """
    import h5py

    content = _plain_text(value).encode()
    return np.array(content, dtype=h5py.string_dtype("utf-8", max(len(content), 1)))


def text_of(attributes: Mapping[str, Any], name: str) -> str:
    """An attribute's text; empty where there is none."""
    value = attributes.get(name, b"")
    return value.decode("utf-8") if isinstance(value, bytes) else str(value)


def _plain_text(value: object) -> str:
    return str(value).replace("\0", "").encode("utf-8", "replace").decode()


def _description(data: xr.Dataset, names: Mapping[Hashable, str]) -> dict[str, Any]:
    return {
        "attributes": data.attrs,
        "variables": {
            name: {
                "stored_as": names[name],
                "dims": list(variable.dims),
                "dtype": variable.dtype.str,
                "coordinate": name in data.coords,
                "attributes": variable.attrs,
                **({"text": variable.values.tolist()} if variable.dtype.kind in "OU" else {}),
            }
            for name, variable in data.variables.items()
        },
    }


def _stored(values: NDArray[Any]) -> NDArray[Any]:
    if values.dtype.kind == "b":
        return values.astype(np.int8)
    return values.astype(object) if values.dtype.kind == "U" else values


def _storage(values: NDArray[Any]) -> dict[str, Any]:
    import h5py

    if values.dtype.kind == "O":
        return {"dtype": h5py.string_dtype()}
    if values.nbytes < SMALL:
        return {"dtype": values.dtype}
    row = values.itemsize * math.prod(values.shape[1:])
    return {
        "dtype": values.dtype,
        "chunks": (min(len(values), max(1, CHUNK // row)), *values.shape[1:]),
        "compression": "gzip",
        "compression_opts": 4,
        "shuffle": True,
    }


def _checksum(texts: Sequence[str], contents: Iterable[bytes]) -> str:
    total = 0
    for part in (*(text.encode() for text in texts), *contents):
        total = zlib.crc32(part, total)
    return f"{total:08x}"


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
        for item in (*index["runs"], *index["excluded"], *index.get("check_loads", ())):
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
    items = [*index["runs"], *index["excluded"], *index.get("check_loads", ())]
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
