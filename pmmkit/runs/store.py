"""A campaign in one HDF5 file: NetCDF4 layout, a group a run, one index at the root.

The root carries the attributes ``format``, ``schema``, ``pmmkit`` (the version that wrote it),
``title`` and ``index`` (JSON: campaign, runs, provenance) with its checksum. Each run is a group
``runs/<name>``, the name being the run's id with everything but letters, digits and ``_ . + -``
replaced by ``_``. The group holds a variable per channel and the attributes ``id``, ``run`` (JSON:
settings, corrections …), ``variables`` (JSON: dimensions, types and attributes as they were) and
``crc32`` over both texts and all samples. Nothing in the file says when or where it was written.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, TypeVar, cast

import numpy as np

from pmmkit import __version__
from pmmkit.errors import CampaignError, DataError, PmmkitError, Problem
from pmmkit.files import atomic_path
from pmmkit.runs.group import attribute, read_group, safe_names, text_of, unfit, write_group
from pmmkit.runs.json_text import from_json, to_json
from pmmkit.runs.run import Campaign, Correction, Run, Settings, TypeB
from pmmkit.ship import Ship, Water

if TYPE_CHECKING:
    import xarray as xr

SCHEMA: Final = 1
"""Version of the layout; a file with a higher one is refused."""
FORMAT: Final = "pmmkit campaign"

_LIBVER: Final = ("v108", "v108")
"""Readable since HDF5 1.8 (2008): headers have checksums, attributes may exceed 64 kB."""
_LIBRARY_FAULTS: Final = (
    OSError, RuntimeError, LookupError, ValueError, TypeError, AttributeError, ArithmeticError,
    MemoryError, AssertionError,
)  # fmt: skip

T = TypeVar("T")
Convert = Mapping[str, Callable[[Any], Any]]


def save_campaign(campaign: Campaign, path: str | Path) -> None:
    """Save a campaign to one HDF5 file (NetCDF4 layout).

    Runs are read and written one after the other, so memory holds one run at a time. The same
    campaign gives the same bytes. The file appears only when it is complete.

    Parameters
    ----------
    campaign : Campaign
        Captive or free-running. An excluded run whose data cannot be read is kept with the
        reason, without data.
    path : path
        File to write, usually ``.h5`` or ``.nc``. May be the file that the campaign was loaded
        from.

    Raises
    ------
    CampaignError
        If runs cannot be read or hold what the file cannot keep (all of them are listed), or if
        the file cannot be written. Nothing is left behind then.

    Examples
    --------
    >>> import tempfile
    >>> import xarray as xr
    >>> data = xr.Dataset({"Y": ("t", [0.0, 12.5, 12.4])}, coords={"t": [0.0, 0.1, 0.2]})
    >>> run = Run(id="SD b+08", test="static_drift", kind="history",
    ...           settings=Settings(speed=1.0, drift=0.14), loader=lambda: data)
    >>> ship = Ship(name="box", L=4.0, B=1.0, d=.25, volume=.5, mass=500., Izz=500.)
    >>> campaign = Campaign(title="Box", ship=ship, water=Water(), runs=(run,))
    >>> file = Path(tempfile.mkdtemp()) / "box.h5"
    >>> save_campaign(campaign, file)
    >>> load_campaign(file)["SD b+08"].data["Y"].values
    array([ 0. , 12.5, 12.4])
    """
    import h5netcdf

    try:
        with atomic_path(path) as part, h5netcdf.File(str(part), "w", libver=_LIBVER) as file:
            _write(file, campaign)
    except OSError as error:
        raise CampaignError(
            Problem(message=f"cannot be written: {error}.", file=str(path))
        ) from error


def load_campaign(path: str | Path) -> Campaign:
    """Open a campaign saved by `save_campaign`; samples are read only when a run is asked for.

    Parameters
    ----------
    path : path
        The HDF5 file.

    Returns
    -------
    Campaign
        As saved, except that `folder` is the folder of the file. Each `Run.data` opens the file,
        reads its own group and closes it again; this may be done from several threads.

    Raises
    ------
    CampaignError
        If the file is missing, damaged, not a campaign or of a newer schema.
    """
    path = Path(path)
    with _opened(path) as file:
        index = _read_index(file, path)
        entry = {
            **index["campaign"],
            "runs": tuple(_run(item, path) for item in index["runs"]),
            "excluded": tuple((_run(item, path), item["reason"]) for item in index["excluded"]),
            "folder": path.parent,
        }
        return _build(Campaign, entry, _CAMPAIGN)


def read_run(path: str | Path, run_id: str) -> xr.Dataset:
    """The data of one run of a saved campaign, without opening the campaign.

    Parameters
    ----------
    path : path
        The HDF5 file.
    run_id : str
        Id of the run, or the name of its group.

    Raises
    ------
    CampaignError
        If the file is missing, damaged or not a campaign, or has no such run.
    """
    path = Path(path)
    with _opened(path) as file:
        _check_schema(file, path)
        group = file.get(f"runs/{safe_names([run_id], 'run')[0]}")
        if group is None or text_of(group.attrs, "id") != run_id:
            return _run(_find(_read_index(file, path), run_id, path), path).data
        return read_group(group, file=path.name)


@dataclass(frozen=True)
class _Loader:
    """Reads one group; the file is opened and closed at each call."""

    path: Path
    group: str

    def __call__(self) -> xr.Dataset:
        with _opened(self.path) as file:
            return read_group(file[f"runs/{self.group}"], file=self.path.name)


@dataclass(frozen=True)
class _NotKept:
    """Stands for the data of an excluded run that could not be read when it was saved."""

    file: str
    run: str
    why: str

    def __call__(self) -> xr.Dataset:
        raise CampaignError(
            Problem(
                message=f"its data could not be read when the campaign was saved: {self.why}",
                file=self.file,
                run=self.run,
            )
        )


def _write(file: Any, campaign: Campaign) -> None:
    used = [(run, None) for run in campaign.runs]
    groups = safe_names([run.id for run, _ in (*used, *campaign.excluded)], "run")
    entries: list[dict[str, Any]] = []
    problems: list[Problem] = []
    for (run, reason), group in zip((*used, *campaign.excluded), groups, strict=True):
        entry: dict[str, Any] = {"group": group, "run": _plain(run, skip=("loader",))}
        entries.append(entry if reason is None else {**entry, "reason": reason})
        try:
            problems += _write_run(file, entry, run, dry=bool(problems))
        except DataError as error:
            if reason is None:
                problems += _problems_of(error, run)
            else:
                entries[-1]["unreadable"] = str(error)
    if problems:
        raise CampaignError(problems, title=f"{campaign.title!r} is not saved")
    index = to_json(
        {
            "campaign": _plain(campaign, skip=("runs", "excluded", "folder")),
            "runs": [entry for entry in entries if "reason" not in entry],
            "excluded": [entry for entry in entries if "reason" in entry],
        }
    )
    file.attrs["format"] = attribute(FORMAT)
    file.attrs["schema"] = SCHEMA
    file.attrs["pmmkit"] = attribute(__version__)
    file.attrs["title"] = attribute(campaign.title)
    file.attrs["index"] = attribute(index)
    file.attrs["index_crc32"] = attribute(_crc(index))


def _write_run(file: Any, entry: Mapping[str, Any], run: Run, *, dry: bool) -> list[Problem]:
    """Write one run, or with `dry` only say what is wrong with it."""
    to_json(entry)
    data = run.data
    problems = unfit(data, run.id)
    if not (problems or dry):
        write_group(file.create_group(f"runs/{entry['group']}"), entry["run"], data)
    return problems


def _problems_of(error: DataError, run: Run) -> list[Problem]:
    return [replace(problem, run=problem.run or run.id) for problem in error.problems]


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    """The file for reading; every fault of the library becomes a CampaignError."""
    import h5py

    if not path.is_file():
        raise CampaignError(Problem(message="there is no such file.", file=str(path)))
    try:
        with h5py.File(path, "r", locking="best-effort") as file:
            yield file
    except PmmkitError:
        raise
    except _LIBRARY_FAULTS as error:
        detail = (str(error).strip().splitlines() or [type(error).__name__])[0][:200]
        raise CampaignError(
            Problem(
                message=f"cannot be read as a campaign: damaged, cut short or not HDF5 ({detail}).",
                file=str(path),
                remedy="Copy it again or save the campaign again from its source.",
            )
        ) from error


def _check_schema(file: Any, path: Path) -> None:
    if text_of(file.attrs, "format") != FORMAT:
        raise CampaignError(
            Problem(
                message="this HDF5 file is not a campaign saved by pmmkit.",
                file=str(path),
                remedy="Describe it in a campaign.toml and open that instead.",
            )
        )
    schema = int(np.asarray(file.attrs["schema"]).item())
    if schema > SCHEMA:
        raise CampaignError(
            Problem(
                message=f"the file has schema {schema}, written by pmmkit "
                f"{text_of(file.attrs, 'pmmkit')}; this is pmmkit {__version__}, which reads "
                f"schemas up to {SCHEMA}.",
                file=str(path),
                remedy="Update pmmkit.",
            )
        )


def _read_index(file: Any, path: Path) -> dict[str, Any]:
    _check_schema(file, path)
    text = text_of(file.attrs, "index")
    if text_of(file.attrs, "index_crc32") != _crc(text):
        raise CampaignError(
            Problem(
                message="the index does not match its checksum: the file is damaged or was edited.",
                file=str(path),
                remedy="Save the campaign again from its source.",
            )
        )
    return cast("dict[str, Any]", from_json(text))


def _crc(text: str) -> str:
    return f"{zlib.crc32(text.encode()):08x}"


def _find(index: Mapping[str, Any], run_id: str, path: Path) -> Mapping[str, Any]:
    items = [*index["runs"], *index["excluded"]]
    ids = [item["run"]["id"] for item in items]
    groups = [item["group"] for item in items]
    for known in (ids, groups):
        if run_id in known:
            return cast("Mapping[str, Any]", items[known.index(run_id)])
    raise CampaignError(
        Problem(
            message=f"the file has no run {run_id!r}; it has "
            f"{', '.join(ids[:12])}{' …' if len(ids) > 12 else ''}.",
            file=str(path),
        )
    )


def _run(item: Mapping[str, Any], path: Path) -> Run:
    loader: Callable[[], xr.Dataset] = _Loader(path.absolute(), item["group"])
    if "unreadable" in item:
        loader = _NotKept(path.name, item["run"]["id"], item["unreadable"])
    return _build(Run, {**item["run"], "loader": loader}, _RUN)


def _build(cls: type[T], entry: Mapping[str, Any], convert: Convert | None = None) -> T:
    """A dataclass of the contracts from its JSON object; mappings become read-only."""
    known = {field.name for field in fields(cast("Any", cls))}
    if unknown := sorted(set(entry) - known):
        raise CampaignError(
            f"The file states {', '.join(unknown)} of a {cls.__name__}, which pmmkit {__version__} "
            f"does not know. Update pmmkit."
        )
    values = {
        name: MappingProxyType(value) if isinstance(value, dict) else value
        for name, value in entry.items()
    }
    values |= {name: turn(entry[name]) for name, turn in (convert or {}).items() if name in entry}
    return cls(**values)


_RUN: Final[Convert] = {
    "settings": lambda value: _build(Settings, value),
    "corrections": lambda value: tuple(_build(Correction, item, {"runs": tuple}) for item in value),
}
_CAMPAIGN: Final[Convert] = {
    "ship": lambda value: _build(Ship, value),
    "water": lambda value: _build(Water, value),
    "free": tuple,
    "uncertainty": lambda value: tuple(_build(TypeB, item) for item in value),
}


def _plain(item: Any, *, skip: Iterable[str] = ()) -> dict[str, Any]:
    """A dataclass of the contracts as a JSON object; its tuples become plain lists."""
    plain = {
        field.name: getattr(item, field.name) for field in fields(item) if field.name not in skip
    }
    for name, value in plain.items():
        if isinstance(value, (Settings, Ship, Water)):
            plain[name] = asdict(value)
        elif isinstance(value, tuple):
            plain[name] = [
                _plain(each) if isinstance(each, (Correction, TypeB)) else each for each in value
            ]
    return plain
