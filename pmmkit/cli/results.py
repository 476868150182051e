"""The files that commands write, each set of them all or nothing."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pmmkit import figures
from pmmkit.cli.console import findings_of, json_text
from pmmkit.errors import FileExists
from pmmkit.files import atomic_folder
from pmmkit.model import Model, save_model
from pmmkit.reduction import Reduction
from pmmkit.report import Reference, Turns, write_report
from pmmkit.simulation import Track, imo_turning
from pmmkit.tables import write

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


def write_reduction(
    reduction: Reduction,
    out: Path,
    *,
    model: Model | None,
    reference: Reference | None = None,
    turns: Turns | None = None,
) -> list[str]:
    """Everything that a reduction gives, into one folder.

    Parameters
    ----------
    reduction : Reduction
        What was found.
    out : Path
        The folder.
    model : Model or None
        The model that was made of it.
    reference : Reference, optional
        Values to compare with in the report.
    turns : Turns, optional
        Turning circles with the model.

    Returns
    -------
    list of str
        Names of the files.
    """
    with atomic_folder(out) as folder:
        write(reduction.table, folder / "derivatives.csv")
        write(reduction.table, folder / "derivatives.nc")
        by_method(reduction).to_csv(folder / "derivatives_by_method.csv", index=False)
        reduction.runs_to_pandas().to_csv(folder / "runs.csv", index=False)
        (folder / "findings.json").write_text(
            json_text(findings_of(reduction.findings)) + "\n", encoding="utf-8"
        )
        if model is not None:
            save_model(model, folder / "model.toml")
        for track in turns.tracks if turns else ():
            _write_track(track, folder, f"_Fn{track.Fn:.3f}")
        if turns:
            figures.save(figures.trajectory(turns.tracks), folder / "trajectories.svg")
        for name, sweep in (turns.sweeps if turns else {}).items():
            _sweep_frame(sweep).to_csv(folder / f"sweep_{_plain(name)}.csv", index=False)
        write_report(
            reduction,
            folder / "report.html",
            reference=reference,
            turns=turns,
        )
        return sorted(file.name for file in folder.iterdir())


def by_method(reduction: Reduction) -> pd.DataFrame:
    """The derivatives by every way in one table, with the columns of ``derivatives.csv`` and run.

    Parameters
    ----------
    reduction : Reduction
        What was found.
    """
    import pandas as pd

    frames = [reduction.table.to_pandas().assign(run="")]
    frames += [table.to_pandas().assign(run="") for table in reduction.families.values()]
    frames += [table.to_pandas().assign(run=name) for name, table in reduction.single_runs.items()]
    return pd.concat([frame[frame["value"].notna()] for frame in frames], ignore_index=True)


def write_track(track: Track, out: Path) -> list[str]:
    """A simulated manoeuvre: ``track.csv``, ``metrics.json`` and figures.

    Parameters
    ----------
    track : Track
        The manoeuvre.
    out : Path
        The folder.

    Returns
    -------
    list of str
        Names of the files.
    """
    with atomic_folder(out) as folder:
        _write_track(track, folder, "")
        for name, figure in figures.manoeuvre(track).items():
            figures.save(figure, folder / f"{name}.svg")
        return sorted(file.name for file in folder.iterdir())


def _write_track(track: Track, folder: Path, ending: str) -> None:
    track.to_pandas().to_csv(folder / f"track{ending}.csv", index=False)
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


def write_sweep(sweeps: Mapping[str, xr.Dataset], out: Path) -> list[str]:
    """Measures over the Froude number: ``sweep.csv`` and a figure.

    Parameters
    ----------
    sweeps : mapping of str to Dataset
        As `froude_sweep` gives them; the first is written.
    out : Path
        The folder.

    Returns
    -------
    list of str
        Names of the files.
    """
    with atomic_folder(out) as folder:
        _sweep_frame(next(iter(sweeps.values()))).to_csv(folder / "sweep.csv", index=False)
        figures.save(figures.measures_over_froude(sweeps), folder / "sweep.svg")
        return sorted(file.name for file in folder.iterdir())


def _sweep_frame(sweep: xr.Dataset) -> pd.DataFrame:
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


def _plain(name: str) -> str:
    return "".join(letter if letter.isalnum() else "_" for letter in name.lower())
