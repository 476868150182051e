"""Writing a programme of runs for those who make them, with the campaign file that reads them."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

from pmmkit.base import DataError, FileExists, UnknownNameError
from pmmkit.campaigns import Campaign
from pmmkit.diagnosis import Programme
from pmmkit.exports.campaign_csv import strut_table
from pmmkit.exports.programme.campaign_file import programme_text
from pmmkit.exports.programme.openfoam import OPENFOAM
from pmmkit.exports.programme.run_sheet import record_columns, run_sheet
from pmmkit.exports.programme.solver import TowingSolver, solver_campaign, towed_paths
from pmmkit.exports.programme.starccm import STARCCM
from pmmkit.exports.programme.towed_path import TowedPath
from pmmkit.exports.programme.two_struts import strut_settings, with_struts
from pmmkit.files import CAMPAIGN
from pmmkit.models import Model

SHEET: Final = "programme.csv"
HOW_TO: Final = "how_to.txt"
COLUMNS: Final = "columns.csv"
RUNS: Final = "runs"
SOLVERS: Final[Mapping[str, TowingSolver]] = MappingProxyType(
    {"openfoam": OPENFOAM, "starccm": STARCCM}
)
MAKERS: Final = ("csv", *SOLVERS)
"""For whom a programme is written: a carriage and its mechanism, and the solvers."""

Results = list[tuple[str, Any]]


def refuse_taken(folder: Path) -> None:
    """Refuse a folder that has a campaign file or runs: neither is written over.

    Parameters
    ----------
    folder : Path
        Where a programme is to be written.

    Raises
    ------
    FileExists
        If there is one.
    """
    for name in (CAMPAIGN.file, RUNS):
        if (folder / name).exists():
            raise FileExists(f"{folder} holds {name} already. Choose another --out.")


def programme_files(programme: Programme, of: Campaign | Model, to: str) -> Results:
    """The files of a programme as results to be written.

    Parameters
    ----------
    programme : Programme
        The runs. A carriage makes them in this order.
    of : Campaign or Model
        The tests that are made already, or what stands for them before any test: ship and water.
    to : str
        One of `MAKERS`.

    Returns
    -------
    list of (str, object)
        Names with what they hold, as `write_results` takes them: ``campaign.toml``,
        ``programme.csv``, ``how_to.txt``, the folder ``runs`` and, of a carriage, ``columns.csv``.

    Raises
    ------
    DataError
        If there is no run, or one that the solver's mesh cannot be moved for.
    UnknownNameError
        If nobody makes runs under that name.
    """
    if to not in MAKERS:
        raise UnknownNameError(f"A programme is written for {', '.join(MAKERS)}, not for {to!r}.")
    if not programme.runs:
        raise DataError(
            "The plan has no run: there is nothing to write.",
            remedy="Give it more time, other limits, or leave --to out to see why.",
        )
    known = _further(of) if isinstance(of, Campaign) else _before_tests(of)
    return _of_carriage(programme, known) if to == "csv" else _of_solver(programme, known, to)


def _further(campaign: Campaign) -> Campaign:
    """The campaign under a title of its own: both may stand side by side."""
    return campaign.with_(title=f"{campaign.title}: further runs")


def _before_tests(model: Model) -> Campaign:
    """Ship and water of a model; the forces will be those of a balance."""
    title = f"Programme for {model.ship.name}"
    return Campaign(title=title, ship=model.ship, water=model.water, runs=(), forces="balance")


def _of_carriage(programme: Programme, campaign: Campaign) -> Results:
    files = {run.id: f"{RUNS}/{run.id}.csv" for run in programme.runs}
    inside = "still inside" if campaign.forces == "balance" else "taken off"
    said = [
        "The runs of programme.csv. Save the record of each under the name that stands under file, "
        f"with the columns of {COLUMNS}; then: pmmkit reduce with this folder. Runs without a file "
        "are not made yet and left out.",
        f'forces = "{campaign.forces}": the inertia of the model is {inside}.',
    ]
    order = "drawn, in blocks of one set-up" if programme.drawn else "as planned"
    struts = strut_settings(programme, campaign)
    entries = [
        {**with_struts(run.entry, struts.get(run.id)), "file": files[run.id]}
        for run in programme.runs
    ]
    table = strut_table(campaign, campaign.runs) if struts else {}
    text = programme_text(
        campaign.with_(cfd={}, numerical={}),
        entries,
        said,
        {"struts": table, "report": {"run_order": order}},
    )
    rate = campaign.report.get("sample_rate")
    return [
        (CAMPAIGN.file, text),
        (SHEET, run_sheet(programme, files=files, rate=rate, struts=struts)),
        (COLUMNS, record_columns(struts=bool(struts))),
        (HOW_TO, _text(_carriage_how_to(programme, campaign, struts=bool(struts)))),
        (RUNS, Path.mkdir),
    ]


def _carriage_how_to(programme: Programme, campaign: Campaign, *, struts: bool) -> list[str]:
    first = programme.runs[0].id
    reference = "midship" if not campaign.moment_reference_x else "moment_reference_x"
    lines = ["Carriage and mechanism: programme.csv has a row a run.", ""]
    if programme.drawn:
        lines += [
            "1. Make the runs in this order. It is drawn, so that a zero that drifts through the",
            "   day looks like no setting. Runs of one set-up stand together.",
        ]
    else:
        lines += ["1. Make the runs in this order."]
    return [
        *lines,
        "2. A run that repeats another shows what changed in between.",
        *(f"   {line}" for line in programme.reference_lines),
        f"3. Save each record as CSV under its name, such as runs/{first}.csv, with these columns:",
        f"   {', '.join(record_columns(struts=struts)['head'])}",
        f"   Moments are about {reference}. Further columns do no harm; {COLUMNS} says more.",
        "   Some seconds at rest at the head of each record show the zeros: with tare = true under",
        "   [defaults] of campaign.toml they are taken off.",
        "4. pmmkit reduce . in this folder, at any time: runs without a file are left out.",
        "",
        "A logger with other columns or signs: say so in campaign.toml ([columns], [axes]), once.",
    ]


def _of_solver(programme: Programme, campaign: Campaign, to: str) -> Results:
    solver = SOLVERS[to]
    paths = towed_paths(programme, campaign)
    files = {run.id: f"{RUNS}/{run.id}/{solver.forces}" for run in programme.runs}
    said = [
        f"The runs of programme.csv, computed as {HOW_TO} says: a mesh with x forward, y to port "
        "and z up that is towed through water at rest, forces along axes that stay, moments about "
        "where the origin of the mesh was at rest. Runs without forces are not computed yet and "
        "left out.",
        "ramp_s is the run-up; motion is the table by which the mesh was moved, and counts before "
        "what the run was set to.",
    ]
    return [
        (CAMPAIGN.file, solver_campaign(programme, campaign, paths, solver, files, said)),
        (SHEET, run_sheet(programme, files=files, paths=paths)),
        (HOW_TO, _text(solver.how_to(programme, campaign))),
        (RUNS, partial(_write_runs, solver=solver, paths=paths, campaign=campaign)),
    ]


def _write_runs(
    folder: Path, *, solver: TowingSolver, paths: Mapping[str, TowedPath], campaign: Campaign
) -> None:
    folder.mkdir()
    for name, path in paths.items():
        solver.write_run(folder / name, path, campaign)


def _text(lines: list[str]) -> str:
    return "\n".join(lines) + "\n"
