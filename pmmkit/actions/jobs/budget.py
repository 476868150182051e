"""Say which source makes how much of the uncertainty: of derivatives, a manoeuvre, a grid."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from pmmkit.actions.outcome import NOT_USABLE, Outcome, results_folder
from pmmkit.actions.setting import SettingError, numbers, setting, settings, stem, words
from pmmkit.actions.shared import (
    STRUCTURE,
    Campaign,
    Data,
    ExecutionSettings,
    OrderSettings,
    Out,
    Sets,
    StructureName,
)
from pmmkit.actions.speeds import Speed, approach

if TYPE_CHECKING:
    from pmmkit.reduction import Budget, GridStudy

STAGE: Final = ("measure", 7)
EXAMPLE: Final = "pmmkit budget my-campaign --of Yv,Nv"


@settings
class GridSettings:
    """Grids and time steps."""

    grids: str | None = setting(
        "Three tables of derivatives, computed on three grids or with three time steps: "
        "fine.csv,medium.csv,coarse.csv.",
        default=None,
    )
    steps: str | None = setting(
        "Their cell sizes or time steps, of which the ratios count: 1,1.4,2.", default=None
    )
    formal_order: float = setting(
        "Formal order of the method that computed them.", default=2.0, least=0.5
    )


@settings
class BudgetSettings:
    """What is asked."""

    campaign: Campaign
    of: str | None = setting(
        "Derivatives or metrics whose sources are all printed, such as Yv,Nv.", default=None
    )
    manoeuvre: str | None = setting(
        "A manoeuvre of the ship by these tests, whose metrics are budgeted.", default=None
    )
    imo: bool = setting("The numbers that the IMO limits are budgeted.", default=False)
    speed: Speed = None
    orders: OrderSettings = OrderSettings()
    parts: str | None = setting(
        "Library ship or model file that lends propeller and rudder.", default=None
    )
    tests_alone: bool = setting("As if what was not tested of the ship were known.", default=False)
    computed: GridSettings = GridSettings()
    structure: StructureName = STRUCTURE
    fn: Sets = "each"
    data: Data = None
    execution: ExecutionSettings = ExecutionSettings()
    out: Out = None
    force: bool = setting(
        "Sail a ship of derivatives that are not usable; the result says so.", default=False
    )


def budget(job: BudgetSettings) -> Outcome:
    """Do what is asked."""
    from pmmkit.api import model_of
    from pmmkit.base import shown
    from pmmkit.campaigns import open_campaign
    from pmmkit.files import write_results
    from pmmkit.reduction import (
        derivative_budget,
        imo_budget,
        manoeuvre_budget,
        reduce_campaign,
        with_grids,
    )

    if job.imo and job.manoeuvre is not None:
        raise SettingError("Give --manoeuvre or --imo, not both.")
    folder = results_folder(job.out, f"{stem(job.campaign)}-budget")
    study = _study(job.computed)
    opened = open_campaign(job.campaign, data=job.data)
    with shown() as progress:
        reduction = reduce_campaign(
            opened,
            structure=job.structure,
            fn=job.fn,
            progress=progress,
            executor=job.execution.executor,
        )
    found: dict[str, Budget] = {"derivatives": derivative_budget(reduction)}
    if study is not None:
        found["derivatives"] = with_grids(found["derivatives"], study)
    if job.imo or job.manoeuvre is not None:
        model = model_of(reduction, job.parts, force=job.force)
        pace = approach(job.speed, model)
        asked = job.orders.given()
        whole = (
            imo_budget(reduction, model, speed=pace, **asked)
            if job.manoeuvre is None
            else manoeuvre_budget(reduction, model, job.manoeuvre, speed=pace, **asked)
        )
        found["imo" if job.manoeuvre is None else job.manoeuvre] = (
            whole.of_tests() if job.tests_alone else whole
        )
    results: list[tuple[str, Any]] = []
    for name, item in found.items():
        results += [
            (f"budget_{name}.csv", item.to_pandas()),
            (f"budget_{name}.svg", item.plot().save),
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
    lines += [_printed(list(found.values()), words(job.of)), "", f"Results: {folder}"]
    judged = reduction.verdict
    return Outcome(
        content={**content, "files": files, "verdict": judged.to_dict()},
        lines=[*lines, *([str(judged)] if judged.faults else [])],
        status=NOT_USABLE if judged.faults else 0,
    )


def _study(computed: GridSettings) -> GridStudy | None:
    from pmmkit.models import read_table
    from pmmkit.reduction import grid_study

    grids, steps = computed.grids, numbers(computed.steps)
    if (grids is None) != (steps is None):
        raise SettingError("--grids and --steps go together: three tables, three steps.")
    if grids is None:
        return None
    files = [Path(part.strip()) for part in grids.split(",")]
    tables = [read_table(file) for file in files]
    return grid_study(tables, steps or (), formal_order=computed.formal_order)


def _printed(budgets: list[Budget], names: list[str]) -> str:
    """What was asked of, wherever it stands; the last budget as a whole where nothing was."""
    from pmmkit.presentation import Section, text_of

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
    return text_of([*tables, *last.sections()[1:]])
