"""One word for all exports: what it is and in which format decide who writes."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from pmmkit.base import DataError, FileExists, Remedy, UnknownNameError, Way
from pmmkit.campaigns import Campaign, save_campaign
from pmmkit.exports.campaign_csv import write_campaign_csv
from pmmkit.exports.fmu.unit import VERSIONS, Version, model_to_fmu
from pmmkit.exports.matlab.model import model_to_mss
from pmmkit.exports.matlab.table import table_to_mss
from pmmkit.exports.shipmmg import model_to_shipmmg
from pmmkit.exports.simman.write import write_simman
from pmmkit.exports.subject import read_subject
from pmmkit.exports.track import write_track_csv, write_track_netcdf
from pmmkit.files import atomic_path, write_text
from pmmkit.models import DerivativeTable, Model, write_table
from pmmkit.simulation import Track
from pmmkit.syntax import matlab_name

if TYPE_CHECKING:
    import xarray as xr

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
