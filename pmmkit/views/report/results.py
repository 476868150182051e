"""The files of a reduction, all or nothing."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pmmkit.files import MODEL, write_results
from pmmkit.imo import metrics_of
from pmmkit.models import Model, ReferenceTable, compare, save_model, write_table
from pmmkit.reduction import Reduction
from pmmkit.views.pages.page_file import page_file
from pmmkit.views.report.build import report_answers, report_places
from pmmkit.views.report.loop import Loop
from pmmkit.views.report.turning import Turns

if TYPE_CHECKING:
    import pandas as pd


def write_reduction(
    reduction: Reduction,
    out: Path,
    *,
    model: Model | None,
    reference: ReferenceTable | None = None,
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
    reference : ReferenceTable, optional
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
    from matplotlib.backends.backend_svg import svgProlog

    places = report_places(reduction, reference=reference, turns=turns)
    answers = report_answers(reduction, places, reference=reference, turns=turns, loop=loop)
    return write_results(
        out,
        (
            *_tables(reduction, reference or ReferenceTable.published(reduction.table)),
            *(
                (f"{picture.file}.svg", svgProlog + picture.svg)
                for place in places.values()
                for picture in place.pictures
                if picture.file
            ),
            *([(MODEL.file, partial(save_model, model))] if model else []),
            *(_turns(turns) if turns else ()),
            ("report.html", page_file(answers)),
        ),
    )


def _tables(reduction: Reduction, beside: ReferenceTable | None) -> Iterator[tuple[str, Any]]:
    yield "derivatives.csv", partial(write_table, reduction.table)
    yield "derivatives.nc", partial(write_table, reduction.table)
    yield "derivatives_by_method.csv", by_method(reduction, beside)
    yield "influence.csv", reduction.influences.to_pandas()
    yield "runs.csv", reduction.runs_to_pandas()
    sunk = reduction.squat_to_pandas()
    if len(sunk):
        yield "squat.csv", sunk
    yield "findings.json", [item.to_dict() for item in reduction.findings]


def _turns(turns: Turns) -> Iterator[tuple[str, Any]]:
    for track in turns.tracks:
        yield f"track_Fn{track.Fn:.3f}.csv", track.to_csv()
        yield f"metrics_Fn{track.Fn:.3f}.json", metrics_of(track)
    for name, sweep in turns.sweeps.items():
        plain = "".join(letter if letter.isalnum() else "_" for letter in name.lower())
        yield f"sweep_{plain}.csv", sweep.to_dataframe().reset_index()


def by_method(reduction: Reduction, reference: ReferenceTable | None = None) -> pd.DataFrame:
    """The derivatives by every way in one table."""
    import pandas as pd

    frames = [estimate.to_pandas() for estimate in reduction.estimates.values()]
    frames += [table.to_pandas() for table in reduction.families.values()]
    frames += [table.to_pandas().assign(run=name) for name, table in reduction.single_runs.items()]
    if reference is not None:
        beside = compare(reduction.table, reference.table)
        frames.append(
            beside[["Fn", "derivative"]].assign(
                value=beside["reference"], method=f"published: {reference.name}", runs=0
            )
        )
    columns = [*reduction.table.to_pandas().columns, "run", "share"]
    whole = pd.concat([frame.reindex(columns=columns) for frame in frames], ignore_index=True)
    whole["run"] = whole["run"].astype(object).fillna("")
    return whole[whole["value"].notna() | whole["share"].notna()].reset_index(drop=True)
