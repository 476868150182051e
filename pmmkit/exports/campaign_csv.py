"""A campaign as CSV files, one a history, with the campaign file that reads them back."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from pmmkit.base import CampaignError, DataError, FileExists, Problem
from pmmkit.campaigns import Campaign, Run, open_campaign
from pmmkit.conventions import CHANNEL_UNITS, FORCE_CHANNELS
from pmmkit.exports.campaign_toml import campaign_text
from pmmkit.files import CAMPAIGN, atomic_folder
from pmmkit.numerics import ABSURD
from pmmkit.presentation import safe_cell
from pmmkit.readers import safe_names
from pmmkit.syntax import plain

if TYPE_CHECKING:
    import xarray as xr

_ROW: Final = "No."
"""Column of a table that numbers its rows."""
LONGEST: Final = 80
"""Letters of a run's id in the name of its file."""
_REMEDY: Final = "Export the campaign as netcdf, which keeps everything."


def write_campaign_csv(campaign: Campaign, folder: str | Path) -> list[str]:
    """Write ``campaign.toml`` and CSV files with ``name [unit]`` headers, all or nothing."""
    if (Path(folder) / CAMPAIGN.file).exists():
        raise FileExists(f"{folder} holds a {CAMPAIGN.file} already. Choose another folder.")
    campaign = campaign.with_open_water()
    with atomic_folder(folder) as part:
        entries = _write_runs(campaign, part)
        text = campaign_text(campaign, entries)
        (part / CAMPAIGN.file).write_text(text, encoding="utf-8", newline="\n")
        _compare(campaign, part, set(entries))
        return sorted(file.name for file in part.iterdir())


def _write_runs(campaign: Campaign, part: Path) -> dict[str, dict[str, Any]]:
    """Write the data; gives what the campaign file says of each run's file."""
    every = [*campaign.runs, *(run for run, _ in campaign.excluded)]
    left = {run.id for run, _ in campaign.excluded}
    digits = len(str(len(every)))
    names = safe_names((run.id for run in every), "run")
    entries: dict[str, dict[str, Any]] = {}
    tables: dict[tuple[str, ...], list[tuple[Run, list[float]]]] = {}
    problems: list[Problem] = []
    for count, (run, name) in enumerate(zip(every, names, strict=True), start=1):
        try:
            data = run.data
        except DataError as error:
            problems += [] if run.id in left else list(error.problems)
            continue
        found = _unfit(run, data)
        problems += found
        if found:
            continue
        if run.kind != "history":
            columns, values = _row(data, run.kind)
            tables.setdefault((run.kind, *columns), []).append((run, values))
            entries[run.id] = {}
            continue
        file = f"{count:0{digits}}_{name[:LONGEST]}.csv"
        if not problems:
            _history(data, part / file)
        wanted = campaign.REQUIRED[campaign.kind]
        absent: dict[str, Any] = {item: False for item in wanted if item not in data}
        entries[run.id] = {"file": file, "rows": data.sizes["t"]}
        entries[run.id] |= {"columns": absent} if absent else {}
    if problems:
        raise CampaignError(problems, title=f"{campaign.title!r} cannot be written as CSV")
    for file, (_, *columns), rows in _numbered(tables):
        _table(part / file, columns, rows)
        taken = {
            _bare(title): _bare(title) for title in columns if not _taken_unasked(_bare(title))
        }
        for place, (run, _) in enumerate(rows, start=1):
            entries[run.id] = {"file": file, "rows": len(rows), "row": {_ROW: place}}
            if taken:
                entries[run.id]["columns"] = taken
    return {run.id: entries[run.id] for run in every if run.id in entries}


def _numbered(
    tables: Mapping[tuple[str, ...], list[tuple[Run, list[float]]]],
) -> Iterator[tuple[str, tuple[str, ...], list[tuple[Run, list[float]]]]]:
    """Tables with a file name each: ``means.csv``, ``means_2.csv`` …"""
    count: dict[str, int] = {}
    for key, rows in tables.items():
        kind = key[0]
        count[kind] = count.get(kind, 0) + 1
        yield f"{kind}{f'_{count[kind]}' if count[kind] > 1 else ''}.csv", key, rows


def _unfit(run: Run, data: xr.Dataset) -> list[Problem]:
    """What of a run's data cannot stand in a CSV file and be read back."""
    dimension = {"history": ("t",), "means": (), "harmonics": ("harmonic",)}[run.kind]
    problems = []
    if not _is_text(run.id):
        problems.append(Problem(message="its name is no text in UTF-8.", run=ascii(run.id)))
    for name, variable in data.variables.items():
        why = None
        if name == "harmonic":
            continue
        if _unit(str(name), run.kind) is None:
            why = "pmmkit knows no channel of that name"
        elif variable.dims not in (dimension, ()):
            why = f"it stands over {', '.join(map(str, variable.dims))}"
        elif variable.dtype.kind not in "iuf":
            why = f"it holds values of type {variable.dtype}"
        elif run.kind != "harmonics" and not np.isfinite(variable.values).all():
            why = "it has samples without a value"
        elif np.nanmax(np.abs(variable.values), initial=0.0) > ABSURD:
            why = f"it has values beyond {ABSURD:g}"
        if why is not None:
            problems.append(
                Problem(message=f"{why}.", run=run.id, column=str(name), remedy=_REMEDY)
            )
    if run.kind == "history" and "t" not in data.variables:
        problems.append(Problem(message="it has no times.", run=run.id, remedy=_REMEDY))
    return problems


def _is_text(name: str) -> bool:
    try:
        name.encode()
    except UnicodeEncodeError:
        return False
    return True


def _unit(name: str, kind: str) -> str | None:
    """Unit of a variable; None where no file of that kind can hold it."""
    suffixes = {"history": (), "means": ("_std",), "harmonics": ("_cos", "_sin")}[kind]
    for suffix in suffixes:
        name = name.removesuffix(suffix)
    return CHANNEL_UNITS.get(name)


def _history(data: xr.Dataset, path: Path) -> None:
    import pandas as pd

    names = ["t", *(str(name) for name in data.data_vars)]
    size = data.sizes["t"]
    columns = {
        f"{name} [{CHANNEL_UNITS[name]}]": np.broadcast_to(
            np.asarray(data[name].values, dtype=float), (size,)
        )
        for name in names
    }
    pd.DataFrame(columns).to_csv(path, index=False, encoding="utf-8", lineterminator="\n")


def _row(data: xr.Dataset, kind: str) -> tuple[list[str], list[float]]:
    """Headers and numbers of a row of means or harmonics."""
    headers, values = [], []
    for name, variable in data.data_vars.items():
        channel, _, part = str(name).rpartition("_")
        if part not in ("cos", "sin"):
            headers.append(f"{name} [{_unit(str(name), kind)}]")
            values.append(float(variable.values))
            continue
        for order, value in enumerate(np.asarray(variable.values, float).tolist()):
            if math.isnan(value) or (part == "sin" and order == 0):
                continue
            label = f"{channel}_{part}{order}" if order else f"{channel}_mean"
            headers.append(f"{label} [{_unit(str(name), kind)}]")
            values.append(value)
    return headers, values


def _table(path: Path, columns: list[str], rows: list[tuple[Run, list[float]]]) -> None:
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([_ROW, "run", *columns])
    for place, (run, values) in enumerate(rows, start=1):
        writer.writerow([place, safe_cell(plain(run.id)), *map(repr, values)])
    path.write_text(text.getvalue(), encoding="utf-8", newline="\n")


def _bare(title: str) -> str:
    return title.split(" [")[0]


def _taken_unasked(name: str) -> bool:
    """Whether a column of a table is taken for what its name says without being mapped."""
    channel = name.rpartition("_")[0] or name
    return name in (*FORCE_CHANNELS, "n", "sinkage", "trim") or channel in FORCE_CHANNELS


def _compare(campaign: Campaign, part: Path, written: set[str]) -> None:
    """Read what was written and refuse it where it is not the same."""
    again = open_campaign(part, data=part)
    back = {run.id: run for run in (*again.runs, *(run for run, _ in again.excluded))}
    problems = []
    for run in (*campaign.runs, *(run for run, _ in campaign.excluded)):
        if run.id in written and not _same(run.data, back[run.id].data):
            problems.append(
                Problem(
                    message="what CSV gives back is not what was written.",
                    run=run.id,
                    remedy=_REMEDY,
                )
            )
    if problems:
        raise CampaignError(problems, title=f"{campaign.title!r} cannot be written as CSV")


def _same(one: xr.Dataset, other: xr.Dataset) -> bool:
    if set(one.variables) != set(other.variables):
        return False
    return all(
        np.array_equal(
            np.broadcast_to(one[name].values, other[name].shape), other[name].values, equal_nan=True
        )
        for name in one.variables
    )
