"""The files of a reduction, all or nothing."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from pmmkit import figures
from pmmkit.cli.console import json_text
from pmmkit.cli.findings import findings_of
from pmmkit.cli.tracks import put_track, sweep_frame
from pmmkit.files import atomic_folder
from pmmkit.models import Model, save_model
from pmmkit.reduction import Reduction
from pmmkit.report import Loop, Reference, Turns, write_report
from pmmkit.tables import write_table

if TYPE_CHECKING:
    import pandas as pd


def write_reduction(
    reduction: Reduction,
    out: Path,
    *,
    model: Model | None,
    reference: Reference | None = None,
    turns: Turns | None = None,
    loop: Loop | None = None,
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
    loop : Loop, optional
        What a simpler model lacks.

    Returns
    -------
    list of str
        Names of the files.
    """
    with atomic_folder(out) as folder:
        write_table(reduction.table, folder / "derivatives.csv")
        write_table(reduction.table, folder / "derivatives.nc")
        by_method(reduction).to_csv(folder / "derivatives_by_method.csv", index=False)
        reduction.runs_to_pandas().to_csv(folder / "runs.csv", index=False)
        (folder / "findings.json").write_text(
            json_text(findings_of(reduction.findings)) + "\n", encoding="utf-8"
        )
        if model is not None:
            save_model(model, folder / "model.toml")
        for track in turns.tracks if turns else ():
            put_track(track, folder, f"_Fn{track.Fn:.3f}")
        if turns:
            figures.save(figures.trajectory(turns.tracks), folder / "trajectories.svg")
        for name, sweep in (turns.sweeps if turns else {}).items():
            sweep_frame(sweep).to_csv(folder / f"sweep_{_plain(name)}.csv", index=False)
        write_report(reduction, folder / "report.html", reference=reference, turns=turns, loop=loop)
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


def _plain(name: str) -> str:
    return "".join(letter if letter.isalnum() else "_" for letter in name.lower())
