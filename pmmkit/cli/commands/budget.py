"""``pmmkit budget``."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from pmmkit.cli.options import (
    Campaign,
    Data,
    More,
    RudderDeg,
    Scheduler,
    Sets,
    StructureName,
    SwitchDeg,
    WorkerCount,
    numbers,
    settings_of,
    stated,
    stem,
    where,
    words,
)
from pmmkit.cli.output import NOT_USABLE, Outcome
from pmmkit.cli.outputs import Out, results_folder
from pmmkit.cli.speeds import Speed, approach

if TYPE_CHECKING:
    from pmmkit.reduction import Budget, GridStudy

EXAMPLE: Final = "pmmkit budget my-campaign --of Yv,Nv"


def budget(
    campaign: Campaign,
    of: Annotated[
        str | None,
        typer.Option(help="Derivatives or metrics whose sources are all printed, such as Yv,Nv."),
    ] = None,
    manoeuvre: Annotated[
        str | None,
        typer.Option(help="A manoeuvre of the ship by these tests, whose metrics are budgeted."),
    ] = None,
    imo: Annotated[
        bool, typer.Option("--imo", help="The numbers that the IMO limits are budgeted.")
    ] = False,
    speed: Speed = None,
    rudder_deg: RudderDeg = None,
    switch_deg: SwitchDeg = None,
    more: More = None,
    parts: Annotated[
        str | None, typer.Option(help="Library ship or model file that lends propeller and rudder.")
    ] = None,
    tests_alone: Annotated[
        bool,
        typer.Option("--tests-alone", help="As if what was not tested of the ship were known."),
    ] = False,
    grids: Annotated[
        str | None,
        typer.Option(
            help="Three tables of derivatives, computed on three grids or with three time steps: "
            "fine.csv,medium.csv,coarse.csv."
        ),
    ] = None,
    steps: Annotated[
        str | None,
        typer.Option(help="Their cell sizes or time steps, of which the ratios count: 1,1.4,2."),
    ] = None,
    formal_order: Annotated[
        float, typer.Option(min=0.5, help="Formal order of the method that computed them.")
    ] = 2.0,
    structure: StructureName = "abkowitz3",
    fn: Sets = "each",
    data: Data = None,
    workers: WorkerCount = None,
    scheduler: Scheduler = None,
    out: Out = None,
    force: Annotated[
        bool,
        typer.Option(
            "--force", help="Sail a ship of derivatives that are not usable; the result says so."
        ),
    ] = False,
) -> Outcome:
    """Which source makes how much of the uncertainty: of derivatives, a manoeuvre, a grid."""
    from pmmkit.api import model_of
    from pmmkit.base import shown
    from pmmkit.campaigns import open_campaign
    from pmmkit.files import write_results
    from pmmkit.plotting import save
    from pmmkit.reduction import (
        derivative_budget,
        imo_budget,
        manoeuvre_budget,
        reduce_campaign,
        with_grids,
    )

    if imo and manoeuvre is not None:
        raise typer.BadParameter("Give --manoeuvre or --imo, not both.")
    folder = results_folder(out, f"{stem(campaign)}-budget")
    study = _study(grids, steps, formal_order)
    opened = open_campaign(campaign, data=data)
    with shown() as progress:
        reduction = reduce_campaign(
            opened,
            structure=structure,
            fn=fn,
            progress=progress,
            executor=where(workers, scheduler),
        )
    found: dict[str, Budget] = {"derivatives": derivative_budget(reduction)}
    if study is not None:
        found["derivatives"] = with_grids(found["derivatives"], study)
    if imo or manoeuvre is not None:
        model = model_of(reduction, parts, force=force)
        pace = approach(speed, model)
        asked = {**stated(rudder_deg=rudder_deg, switch_deg=switch_deg), **settings_of(more)}
        whole = (
            imo_budget(reduction, model, speed=pace, **asked)
            if manoeuvre is None
            else manoeuvre_budget(reduction, model, manoeuvre, speed=pace, **asked)
        )
        found["imo" if manoeuvre is None else manoeuvre] = (
            whole.of_tests() if tests_alone else whole
        )
    results: list[tuple[str, Any]] = []
    for name, item in found.items():
        results += [
            (f"budget_{name}.csv", item.to_pandas()),
            (f"budget_{name}.svg", partial(save, item.plot())),
        ]
    if study is not None:
        results.append(("grids.csv", study.to_pandas()))
    content: dict[str, Any] = {
        "campaign": opened.title,
        "out": str(folder),
        "budgets": {name: item.to_pandas().to_dict("records") for name, item in found.items()},
        "not_stated": list(found["derivatives"].not_stated),
        "outside": list(found["derivatives"].outside),
        "grids": None if study is None else study.to_pandas().to_dict("records"),
    }
    files = write_results(folder, [*results, ("budget.json", content)])
    lines = [] if study is None else [str(study), ""]
    lines += [_printed(list(found.values()), words(of)), "", f"Results: {folder}"]
    judged = reduction.verdict
    return Outcome(
        content={**content, "files": files, "verdict": judged.to_dict()},
        lines=[*lines, *([str(judged)] if judged.faults else [])],
        status=NOT_USABLE if judged.faults else 0,
    )


def _study(grids: str | None, steps: str | None, formal_order: float) -> GridStudy | None:
    from pmmkit.models import read_table
    from pmmkit.reduction import grid_study

    if (grids is None) != (steps is None):
        raise typer.BadParameter("--grids and --steps go together: three tables, three steps.")
    if grids is None:
        return None
    files = [Path(part.strip()) for part in grids.split(",")]
    return grid_study(
        [read_table(file) for file in files], numbers(steps) or (), formal_order=formal_order
    )


def _printed(budgets: list[Budget], names: list[str]) -> str:
    """What was asked of, wherever it stands; the last budget as a whole where nothing was."""
    from pmmkit.presentation import Section, sections_of, text_of

    last = budgets[-1]
    if not names:
        return str(last)
    known = [{item.name for item in budget.results} for budget in budgets]
    lost = [name for name in names if not any(name in own for own in known)]
    if lost:
        last.of(*lost)
    tables = [
        Section(title=f"{budget.subject}: {name}", tables=[budget.of(name).grid()])
        for name in names
        for budget, own in zip(budgets, known, strict=True)
        if name in own
    ]
    return text_of([*tables, *sections_of(last)[1:]])
