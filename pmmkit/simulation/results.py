"""What is kept of simulated manoeuvres: tables and numbers for files and programs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, Final

from pmmkit.metrics import in_lengths
from pmmkit.simulation.imo import imo_turning
from pmmkit.simulation.sweeps import SHARES
from pmmkit.simulation.track import Track

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

MOST: Final = 5
"""Metrics in a table for the screen."""


def track_files(track: Track, ending: str = "") -> Iterator[tuple[str, Any]]:
    """Samples and metrics of a track with the names of their files."""
    yield f"track{ending}.csv", track.to_csv()
    yield f"metrics{ending}.json", metrics_of(track)


def metrics_of(track: Track) -> dict[str, Any]:
    """The numbers of a manoeuvre, what they belong to, and the IMO limits beside them.

    Parameters
    ----------
    track : Track
        The manoeuvre.
    """
    return {
        **track.metrics,
        "name": track.name,
        "manoeuvre": track.manoeuvre,
        "rudder_deg": track.rudder_deg,
        "speed": track.speed,
        "Fn": track.Fn,
        "L": track.L,
        "scale": track.scale,
        "notes": list(track.notes),
        "standing": track.standing.to_dict(),
        "tested_range": track.tested.numbers if track.tested else None,
        "imo": [verdict.to_dict() for verdict in imo_turning(track)]
        if track.manoeuvre == "turning"
        else [],
    }


def told_metrics(sweep: xr.Dataset) -> list[str]:
    """The metrics worth a column: in ship lengths where they are, without those that stay empty."""
    names = [str(name) for name in sweep.data_vars if not str(name).endswith(("_low", "_high"))]
    metrics = [name for name in in_lengths(names) if name not in SHARES]
    return [name for name in metrics if sweep[name].notnull().any()][:MOST]


def told_metric(row: Mapping[str, Any], name: str) -> str:
    """A metric of a row of a sweep, with its interval where it has one."""
    text = f"{row[name]:.4g}"
    if f"{name}_low" not in row:
        return text
    return f"{text} ({row[f'{name}_low']:.4g} to {row[f'{name}_high']:.4g})"


def sweep_frame(sweep: xr.Dataset) -> pd.DataFrame:
    """A sweep as a table, a row per case."""
    return sweep.to_dataframe().reset_index()
