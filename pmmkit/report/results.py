"""The files of a reduction, all or nothing."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pmmkit.figures import trajectory
from pmmkit.files import write_results
from pmmkit.models import Model, save_model
from pmmkit.plotting.style import save
from pmmkit.reduction import Reduction
from pmmkit.report.build import write_report
from pmmkit.report.loop import Loop
from pmmkit.report.reference import Reference
from pmmkit.report.turning import Turns
from pmmkit.simulation.results import sweep_frame, track_files
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
    report = partial(write_report, reduction, reference=reference, turns=turns, loop=loop)
    return write_results(
        out,
        (
            *_tables(reduction),
            *([("model.toml", partial(save_model, model))] if model else []),
            *(_turns(turns) if turns else ()),
            ("report.html", report),
        ),
    )


def _tables(reduction: Reduction) -> Iterator[tuple[str, Any]]:
    yield "derivatives.csv", partial(write_table, reduction.table)
    yield "derivatives.nc", partial(write_table, reduction.table)
    yield "derivatives_by_method.csv", by_method(reduction)
    yield "influence.csv", reduction.influences.to_pandas()
    yield "runs.csv", reduction.runs_to_pandas()
    yield "findings.json", [item.to_dict() for item in reduction.findings]


def _turns(turns: Turns) -> Iterator[tuple[str, Any]]:
    for track in turns.tracks:
        yield from track_files(track, f"_Fn{track.Fn:.3f}")
    yield "trajectories.svg", partial(save, trajectory(turns.tracks))
    for name, sweep in turns.sweeps.items():
        plain = "".join(letter if letter.isalnum() else "_" for letter in name.lower())
        yield f"sweep_{plain}.csv", sweep_frame(sweep)


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
