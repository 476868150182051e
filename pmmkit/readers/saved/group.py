"""One run in one HDF5 group: its Dataset written with h5netcdf and read back identical."""

from __future__ import annotations

import math
import re
import zlib
from collections.abc import Hashable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import CampaignError, Problem
from pmmkit.conventions import CHANNEL_UNITS
from pmmkit.files import from_json, to_json

if TYPE_CHECKING:
    import xarray as xr

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
