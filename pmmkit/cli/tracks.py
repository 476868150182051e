"""The files of simulated manoeuvres, each set of them all or nothing."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pmmkit.cli.console import json_text
from pmmkit.errors import FileExists
from pmmkit.files import atomic_folder
from pmmkit.simulation.imo import imo_turning
from pmmkit.simulation.track import Track

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


def check_folder(path: Path) -> None:
    """Refuse a folder that cannot be written, before anything is computed.

    Parameters
    ----------
    path : Path
        Where results shall go.

    Raises
    ------
    FileExists
        If a file is in the way, or the place is not writable.
    """
    target = path.resolve()
    if target.exists() and not target.is_dir():
        raise FileExists(f"{path} is a file; the results need a folder. Choose another --out.")
    above = next(folder for folder in (target, *target.parents) if folder.exists())
    if not above.is_dir() or not os.access(above, os.W_OK):
        raise FileExists(f"{path} cannot be written: no permission. Choose another --out.")


def write_track(track: Track, out: Path, *, drawn: bool = True) -> list[str]:
    """A simulated manoeuvre: ``track.csv``, ``metrics.json`` and figures.

    Parameters
    ----------
    track : Track
        The manoeuvre.
    out : Path
        The folder.
    drawn : bool
        Whether to draw figures.

    Returns
    -------
    list of str
        Names of the files.
    """
    with atomic_folder(out) as folder:
        put_track(track, folder, "")
        if drawn:
            from pmmkit import figures

            for name, figure in figures.manoeuvre(track).items():
                figures.save(figure, folder / f"{name}.svg")
        return sorted(file.name for file in folder.iterdir())


def put_track(track: Track, folder: Path, ending: str) -> None:
    """Write the samples and the metrics of a track into a folder that is there."""
    (folder / f"track{ending}.csv").write_text(track.to_csv(), encoding="utf-8", newline="")
    text = json_text(metrics_of(track)) + "\n"
    (folder / f"metrics{ending}.json").write_text(text, encoding="utf-8")


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
        "imo": [asdict(verdict) for verdict in imo_turning(track)]
        if track.manoeuvre == "turning"
        else [],
    }


def write_sweep(sweep: xr.Dataset, metrics: Sequence[str], out: Path) -> list[str]:
    """Metrics over what a sweep varies: ``sweep.csv`` and a figure.

    Parameters
    ----------
    sweep : Dataset
        As `froude_sweep` or `sweep` gives it.
    metrics : sequence of str
        Those to be drawn, of which the first four are.
    out : Path
        The folder.

    Returns
    -------
    list of str
        Names of the files.
    """
    with atomic_folder(out) as folder:
        sweep_frame(sweep).to_csv(folder / "sweep.csv", index=False)
        from pmmkit import figures

        figures.save(figures.metrics_over(sweep, metrics[:4]), folder / "sweep.svg")
        return sorted(file.name for file in folder.iterdir())


def sweep_frame(sweep: xr.Dataset) -> pd.DataFrame:
    """A sweep as a table, a row per case."""
    return sweep.to_dataframe().reset_index()


def sweep_rows(sweep: xr.Dataset) -> list[dict[str, Any]]:
    """A sweep as a list of rows for JSON.

    Parameters
    ----------
    sweep : Dataset
        As `froude_sweep` gives it.
    """
    names = [str(name) for name in (*sweep.coords, *sweep.data_vars)]
    columns: Sequence[Any] = [sweep[name].values.tolist() for name in names]
    return [dict(zip(names, row, strict=True)) for row in zip(*columns, strict=True)]
