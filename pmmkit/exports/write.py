"""All exports: what a path stands for and its format decide who writes; tracks as CSV."""

from __future__ import annotations

import csv
import json
import math
import tomllib
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from pmmkit.base import CampaignError, DataError, FileExists, Remedy, UnknownNameError, Way
from pmmkit.campaigns import Campaign, open_campaign, read_columns, save_campaign
from pmmkit.conventions import CHANNEL_UNITS
from pmmkit.exports.campaign_csv import write_campaign_csv
from pmmkit.exports.fmu.unit import VERSIONS, Version, model_to_fmu
from pmmkit.exports.matlab.hull import table_to_mss
from pmmkit.exports.matlab.model import model_to_mss
from pmmkit.exports.shipmmg import model_to_shipmmg
from pmmkit.exports.simman.write import write_simman
from pmmkit.files import CAMPAIGN, Url, atomic_path, write_text
from pmmkit.models import DerivativeTable, Model, load_model, read_table, ships, write_table
from pmmkit.presentation import printable
from pmmkit.readers import Options, Request, recognise
from pmmkit.simulation import Track
from pmmkit.syntax import matlab_name

if TYPE_CHECKING:
    import xarray as xr


# Tracks of manoeuvres as files: CSV with units in the headers, NetCDF with what belongs to it.


def read_track(path: str | Path) -> xr.Dataset:
    """A ``track.csv`` that a simulation wrote, with the metrics beside it."""
    file = Path(path)
    request = Request(path=file, shown=file.name, options=Options(format="csv"))
    read, picked, _ = read_columns(request, {}, Campaign.REQUIRED["free-running"])
    values = {
        column.name: column.apply(numbers)
        for column, numbers in zip(picked, read.values, strict=True)
    }
    taken = {column.position for column in picked}
    left = [title for place, title in enumerate(read.headers) if place not in taken]
    beside = file.with_name(file.name.replace("track", "metrics", 1)).with_suffix(".json")
    attributes = _metrics(beside) if beside != file else {}
    return _dataset(values, attributes | ({"left_out": "; ".join(left)} if left else {}))


def write_track_csv(track: xr.Dataset, path: str | Path) -> None:
    """Write a track as CSV with ``name [unit]`` headers, all or nothing."""
    import pandas as pd

    names = ["t", *(str(name) for name in track.data_vars)]
    frame = pd.DataFrame({f"{name} [{CHANNEL_UNITS[name]}]": track[name].values for name in names})
    with atomic_path(path) as part:
        frame.to_csv(part, index=False, encoding="utf-8", lineterminator="\n")


def write_track_netcdf(track: xr.Dataset, path: str | Path) -> None:
    """Write a track as NetCDF4, all or nothing; metrics are attributes."""
    from pmmkit.base import __version__

    named = track.assign_attrs(Conventions="CF-1.8", pmmkit=__version__)
    with atomic_path(path) as part:
        named.to_netcdf(part, engine="h5netcdf")


def _dataset(values: dict[str, Any], attributes: dict[str, Any]) -> xr.Dataset:
    import xarray as xr

    def described(name: str) -> dict[str, str]:
        unit, text = Track.CHANNELS.get(name, (CHANNEL_UNITS[name], name))
        return {"units": unit, "long_name": text}

    times = values.pop("t")
    return xr.Dataset(
        {name: ("t", numbers, described(name)) for name, numbers in values.items()},
        coords={"t": ("t", times, {"units": "s", "long_name": "time from the rudder order"})},
        attrs=attributes,
    )


def _metrics(path: Path) -> dict[str, Any]:
    """Numbers and texts of the metrics file; none where it is not there."""
    if not path.is_file():
        return {}
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise CampaignError(
            f"cannot be read as JSON: {error}.",
            file=path.name,
            remedy="Simulate again, or take it away to export the track without metrics.",
        ) from error
    if not isinstance(content, dict):
        return {}
    content = {name: value for name, value in content.items() if name.isidentifier()}
    if isinstance(content.get("standing"), dict):
        content["standing"] = content["standing"].get("sentences")
    texts = {
        name: printable("; ".join(value))
        for name, value in content.items()
        if isinstance(value, list) and value and all(isinstance(item, str) for item in value)
    }
    numbers = {
        name: math.nan if value is None else printable(value) if isinstance(value, str) else value
        for name, value in content.items()
        if value is None or (isinstance(value, str | int | float) and not isinstance(value, bool))
    }
    return numbers | texts


# What a name or a path stands for: a model, a table, a campaign or a track.


_HDF5: Final = (".h5", ".hdf5", ".nc")
_REMEDY: Final = (
    "Name a library ship (pmmkit ships), a model file, a campaign, a derivative table or the "
    "track.csv of a simulation."
)


def read_subject(
    what: str | Path, *, data: str | Path | None = None
) -> Model | DerivativeTable | Campaign | xr.Dataset:
    """Read what is to be exported, whatever it is.

    Parameters
    ----------
    what : str or path
        A library ship; a model file; a folder with ``campaign.toml``, such a file, a saved or
        a packed campaign, or the URL of one; a derivative table (``.csv``, ``.nc``, ``.h5``,
        ``.xlsx``); a ``track.csv``.
    data : path, optional
        Of a campaign, as for `open_campaign`.

    Returns
    -------
    Model, DerivativeTable, Campaign or Dataset
        A Dataset is a track.

    Raises
    ------
    DataError
        If it is nothing of these, or damaged.

    Examples
    --------
    >>> read_subject("kvlcc2-l7").name
    'kvlcc2-l7'
    """
    if Url.of(what) is not None:
        return open_campaign(what, data=data)
    path = Path(what).expanduser()
    if not path.exists():
        if str(what) in ships():
            return load_model(str(what))
        if path.parts[:1] != ("datasets",):
            raise DataError(
                "there is no such file, folder or library ship.", file=str(what), remedy=_REMEDY
            )
    suffix = path.suffix.lower()
    if path.is_file() and suffix == ".csv":
        return read_track(path) if _is_track(path) else read_table(path)
    if path.is_file() and suffix == ".xlsx":
        return read_table(path)
    if path.is_file() and suffix in _HDF5 and recognise(path) != "pmmkit":
        return read_table(path)
    if path.is_file() and suffix == ".toml" and _is_model(path):
        return load_model(path)
    if path.is_file() and suffix not in (".toml", ".zip", *_HDF5):
        raise DataError("is nothing that can be exported.", file=str(what), remedy=_REMEDY)
    return open_campaign(path, data=data)


def _is_track(path: Path) -> bool:
    """Whether a CSV file has a column of times and none of derivatives."""
    with path.open(encoding="utf-8-sig", errors="replace", newline="") as stream:
        titles = next(csv.reader([stream.readline(65536)]), [])
    names = {title.split("[")[0].strip() for title in titles}
    return "t" in names and "derivative" not in names


def _is_model(path: Path) -> bool:
    """Whether a TOML file has what only model files have; the rest are campaign files."""
    if path.name == CAMPAIGN.file:
        return False
    try:
        content = tomllib.loads(path.read_bytes().decode("utf-8-sig"))
    except (OSError, ValueError, RecursionError):
        return True
    return "campaign" not in content


FORMATS: Final[Mapping[str, tuple[str, ...]]] = MappingProxyType(
    {
        "model": ("mss", "shipmmg", "fmu"),
        "table": ("mss", "csv", "excel", "latex", "netcdf"),
        "campaign": ("csv", "netcdf", "simman"),
        "track": ("csv", "netcdf"),
    }
)
"""What can be exported, and to which formats."""
ENDINGS: Final[Mapping[str, str]] = MappingProxyType(
    {
        "mss": ".m",
        "shipmmg": ".py",
        "fmu": ".fmu",
        "csv": ".csv",
        "excel": ".xlsx",
        "latex": ".tex",
        "netcdf": ".nc",
        "simman": ".zip",
    }
)
"""Ending of the files of each format."""

AS_TABLE: Final = Remedy(
    "A model's derivatives as a table: {}.", (Way("pmmkit.hull_table", "pmmkit model show MODEL"),)
)


def export(
    obj: Model | DerivativeTable | Campaign | Track | xr.Dataset | str | Path,
    path: str | Path,
    to: str | None = None,
    *,
    speed: float | None = None,
    data: str | Path | None = None,
    fmi: Version | None = None,
    compile: bool = False,
) -> list[Path]:
    """Write a model, a table, a campaign or a track for other programs.

    Parameters
    ----------
    obj : Model, DerivativeTable, Campaign, Track, Dataset, str or path
        What to write, or where it is: a library ship, a model file, a table, a campaign, the
        ``track.csv`` of a simulation.
    path : path
        File to write; for a campaign as ``csv`` a folder. A file that is there is replaced, all or
        nothing.
    to : str, optional
        ``mss`` (function file for MATLAB and Octave), ``shipmmg`` (Python), ``fmu`` (Simulink,
        OpenModelica and others), ``csv``, ``excel``, ``latex``, ``netcdf``, ``simman`` (archive of
        model tests); by default the one that the ending of `path` names.
    speed : float, optional
        For models: speed [m/s] at whose Froude number the values are taken; of an FMU also that
        of the start.
    data : path, optional
        For a campaign that is named by its path: folder of its measurements.
    fmi : {3, 2}, optional
        For an FMU: version of the interface, 3 by default.
    compile : bool
        For an FMU: put a library for this machine into it, made by its C compiler.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    DataError
        If the format does not suit, or cannot say all that there is; with every reason.
    FileExists
        If `path` is the very file or folder that is to be exported, or cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> folder = Path(tempfile.mkdtemp())
    >>> [file.name for file in export("kvlcc2-l7", folder / "kvlcc2.m", speed=1.179)]
    ['kvlcc2.m']
    """
    target = Path(path)
    if isinstance(obj, str | Path) and _meets(Path(obj), target):
        raise FileExists(f"{path} is what is to be exported. Choose another file.")
    subject = read_subject(obj, data=data) if isinstance(obj, str | Path) else obj
    kind = kind_of(subject)
    chosen = _format(kind, target, to)
    if chosen != "fmu" and (fmi is not None or compile):
        raise DataError(
            f"{chosen} has no version of FMI and is not compiled.",
            remedy=Remedy("Say {}, or leave that out.", (Way.setting("to", "fmu"),)),
        )
    try:
        return _written(
            subject, kind, chosen, target, speed=speed, fmi=fmi or VERSIONS[0], compile=compile
        )
    except OSError as error:
        if isinstance(error, FileExists):
            raise
        raise FileExists(f"{path} cannot be written: {error.strerror or error}.") from error


def _written(
    subject: Any,
    kind: str,
    to: str,
    target: Path,
    *,
    speed: float | None,
    fmi: Version,
    compile: bool,
) -> list[Path]:
    """Write by whom the kind and the format name."""
    if isinstance(subject, Track):
        subject = subject.to_xarray()
    match kind, to:
        case "model", "mss":
            write_text(target, model_to_mss(subject, name=target.stem, speed=speed))
        case "model", "shipmmg":
            write_text(target, model_to_shipmmg(subject, speed=speed))
        case "model", "fmu":
            if target.suffix.lower() != ENDINGS["fmu"]:
                raise DataError(f"{target}: programs know an FMU by its ending {ENDINGS['fmu']}.")
            content = model_to_fmu(subject, speed=speed, fmi=fmi, compile=compile)
            with atomic_path(target) as part:
                part.write_bytes(content)
        case "table", "mss":
            write_text(target, table_to_mss(subject, name=target.stem))
        case "campaign", "csv":
            return [target / name for name in write_campaign_csv(subject, target)]
        case "campaign", "netcdf":
            save_campaign(subject, target)
        case "campaign", "simman":
            write_simman(subject, target)
        case "track", "csv":
            write_track_csv(subject, target)
        case "track", "netcdf":
            write_track_netcdf(subject, target)
        case _:  # by the room of the tables, which goes by the ending
            if target.suffix.lower() not in (ENDINGS[to], *((".h5",) if to == "netcdf" else ())):
                raise DataError(f"{target}: a table as {to} needs the ending {ENDINGS[to]}.")
            write_table(subject, target)
    return [target, target.with_suffix(".json")] if (kind, to) == ("table", "csv") else [target]


def kind_of(subject: object) -> str:
    """What something is in words: ``model``, ``table``, ``campaign``, ``track``."""
    kinds: tuple[tuple[type, str], ...] = (
        (Model, "model"),
        (DerivativeTable, "table"),
        (Campaign, "campaign"),
        (Track, "track"),
    )
    for kind, word in kinds:
        if isinstance(subject, kind):
            return word
    if {"t", "x", "y", "psi"} <= set(getattr(subject, "variables", ())):
        return "track"
    raise UnknownNameError(
        f"A {type(subject).__name__} cannot be exported: give a model, a derivative table, a "
        f"campaign or a track."
    )


def file_name(subject: Any, stem: str, to: str) -> str:
    """Name of a file or folder where none is chosen.

    Parameters
    ----------
    subject : Model, DerivativeTable, Campaign or Dataset
        What is to be exported.
    stem : str
        Name of its file or folder without the ending.
    to : str
        The format.

    Examples
    --------
    >>> from pmmkit.models import load_model
    >>> file_name(load_model("kvlcc2-l7"), "kvlcc2-l7", "mss")
    'kvlcc2_l7.m'
    """
    if isinstance(subject, Campaign) and to == "csv":
        return f"{stem}-csv"
    return (matlab_name(stem) if to in ("mss", "shipmmg") else stem) + ENDINGS[to]


def _format(kind: str, target: Path, to: str | None) -> str:
    """The format that is asked for, checked against what there is."""
    by_ending = {ending: name for name, ending in ENDINGS.items()} | {".h5": "netcdf"}
    chosen = to if to is not None else by_ending.get(target.suffix.lower())
    if chosen is None and kind == "campaign" and not target.suffix:
        chosen = "csv"
    if chosen is None or chosen not in ENDINGS:
        raise UnknownNameError(
            f"Which format? {target.name!r} has no ending that says it: {', '.join(ENDINGS)}."
            if to is None
            else f"Format {to!r} is not known: {', '.join(ENDINGS)}."
        )
    if chosen not in FORMATS[kind]:
        raise DataError(
            f"A {kind} is not written as {chosen}: {', '.join(FORMATS[kind])}.",
            remedy=AS_TABLE if kind == "model" else None,
        )
    return chosen


def _meets(source: Path, target: Path) -> bool:
    """Whether a path to be written is one to be read."""
    if not source.exists():
        return False
    places = {source.resolve()} | ({source.resolve().parent} if source.suffix == ".toml" else set())
    return target.resolve() in places
