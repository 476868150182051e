"""Tracks of manoeuvres as files: CSV with units in the headers, NetCDF with what belongs to it."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pmmkit.base import CampaignError
from pmmkit.campaigns import Campaign, read_columns
from pmmkit.conventions import CHANNEL_UNITS
from pmmkit.files import atomic_path
from pmmkit.presentation import printable
from pmmkit.readers import Options, Request
from pmmkit.simulation import Track

if TYPE_CHECKING:
    import xarray as xr


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
