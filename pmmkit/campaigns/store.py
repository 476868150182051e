"""A campaign in one HDF5 file: NetCDF4 layout, a group a run, one index at the root.

The root carries the attributes ``format``, ``schema``, ``pmmkit`` (the version that wrote it),
``title`` and ``index`` (JSON: campaign, runs, provenance) with its checksum. Each run is a group
``runs/<name>``, the name being the run's id with everything but letters, digits and ``_ . + -``
replaced by ``_``. The group holds a variable per channel and the attributes ``id``, ``run`` (JSON:
settings, corrections …), ``variables`` (JSON: dimensions, types and attributes as they were) and
``crc32`` over both texts and all samples. Nothing in the file says when or where it was written.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, fields, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, TypeVar, cast

from pmmkit.base import CampaignError, DataError, Problem, __version__
from pmmkit.campaigns.campaign import Campaign
from pmmkit.campaigns.run import Run
from pmmkit.campaigns.run_settings import RUN_SETTINGS
from pmmkit.campaigns.settings import Settings
from pmmkit.campaigns.stated_run import Correction
from pmmkit.campaigns.uncertainty import TypeB
from pmmkit.conventions import Ship, Water
from pmmkit.files import atomic_path, to_json
from pmmkit.readers import CampaignWriter, safe_names, saved_index

_LIBVER: Final = ("v108", "v108")
"""Readable since HDF5 1.8 (2008): headers have checksums, attributes may exceed 64 kB."""
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
        reason, without data; an open-water curve that lies in a file of its own is kept itself.
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
            _write(CampaignWriter(file), campaign.with_open_water())
    except OSError as error:
        raise CampaignError(f"cannot be written: {error}.", file=str(path)) from error


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
    with saved_index(path) as index:
        entry = {
            **index["campaign"],
            "runs": tuple(_build(Run, item["run"], _RUN) for item in index["runs"]),
            "excluded": tuple(
                (_build(Run, item["run"], _RUN), item["reason"]) for item in index["excluded"]
            ),
            "check_loads": tuple(
                _build(Run, item["run"], _RUN) for item in index.get("check_loads", ())
            ),
            "folder": path.parent,
        }
        return _build(Campaign, entry, _CAMPAIGN)


def _write(file: CampaignWriter, campaign: Campaign) -> None:
    used = [(run, None) for run in (*campaign.runs, *campaign.check_loads)]
    groups = safe_names([run.id for run, _ in (*used, *campaign.excluded)], "run")
    entries: list[dict[str, Any]] = []
    problems: list[Problem] = []
    for (run, reason), group in zip((*used, *campaign.excluded), groups, strict=True):
        entry: dict[str, Any] = {"group": group, "run": _plain(run, skip=("loader",))}
        entries.append(entry if reason is None else {**entry, "reason": reason})
        try:
            to_json(entry)
            problems += file.add(entry, run.data, dry=bool(problems))
        except DataError as error:
            if reason is None:
                problems += _problems_of(error, run)
            else:
                entries[-1]["unreadable"] = str(error)
    if problems:
        raise CampaignError(problems, title=f"{campaign.title!r} is not saved")
    loads = entries[len(campaign.runs) : len(used)]
    file.finish(
        campaign.title,
        {
            "campaign": _plain(campaign, skip=("runs", "excluded", "check_loads", "folder")),
            "runs": entries[: len(campaign.runs)],
            **({"check_loads": loads} if loads else {}),
            "excluded": [entry for entry in entries if "reason" in entry],
        },
    )


def _problems_of(error: DataError, run: Run) -> list[Problem]:
    return [replace(problem, run=problem.run or run.id) for problem in error.problems]


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


def _settings(value: Mapping[str, Any]) -> Settings:
    """Settings, those that kinds of test bring along among them."""
    more = {item.name for item in RUN_SETTINGS.brought}
    further = tuple((name, float(number)) for name, number in value.items() if name in more)
    plain = {name: number for name, number in value.items() if name not in more}
    return replace(_build(Settings, plain), further=further)


_RUN: Final[Convert] = {
    "settings": lambda value: _settings(value),
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
        if isinstance(value, Settings):
            plain[name] = value.plain()
        elif isinstance(value, (Ship, Water)):
            plain[name] = asdict(value)
        elif isinstance(value, tuple):
            plain[name] = [
                _plain(each) if isinstance(each, (Correction, TypeB)) else each for each in value
            ]
    return plain
