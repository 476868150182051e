"""Name the effect, or the fault of the measurement, that the model lacks."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import nullcontext
from functools import partial
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from pmmkit.actions.jobs.add import AddSettings
from pmmkit.actions.jobs.plan import PlanSettings
from pmmkit.actions.jobs.reduce import ReduceSettings
from pmmkit.actions.outcome import Outcome, marked, results_folder, say, warned, written
from pmmkit.actions.records import RecordSettings, errors_table, sound_campaign, sound_campaigns
from pmmkit.actions.setting import (
    as_typed,
    present,
    setting,
    settings,
    settings_from,
    stated,
    stem,
    words,
)
from pmmkit.actions.shared import (
    Data,
    DrawFigures,
    ExecutionSettings,
    Force,
    Given,
    NoiseSettings,
    Out,
    Own,
)

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign
    from pmmkit.campaigns import Campaign as Tests
    from pmmkit.diagnosis import Diagnosis
    from pmmkit.intake import CheckFinding


# ``pmmkit diagnose`` with several campaigns.


def together_outcome(
    name: str,
    paths: Sequence[Path],
    folder: Path,
    *,
    data: Path | None,
    captive: dict[str, Any],
    free: dict[str, Any],
    drawn: bool,
) -> Outcome:
    """The answer of several campaigns, printed and written."""
    from pmmkit.base import DataError
    from pmmkit.conventions import STRUCTURES
    from pmmkit.diagnosis import joint_diagnosis
    from pmmkit.models import load_model, save_model
    from pmmkit.plotting import save

    if name in STRUCTURES:
        raise DataError(
            f"{name} is a structure: several campaigns are asked about a model. Give a model file "
            f"or a library ship; pmmkit reduce writes a model from captive tests."
        )
    model = load_model(name)
    asked: dict[str, Campaign] = {}
    head, warnings, checks = [], [], {}
    for title, (campaign, checked) in sound_campaigns(paths, data).items():
        asked[title] = campaign
        head.append(f"{title}: {len(campaign.runs)} runs, {campaign.kind}")
        warnings += warned(checked)
        checks[title] = [item.to_dict() for item in checked]
    found = joint_diagnosis(
        model, asked, captive=present(**captive), free=present(**free), progress=say
    )
    content = {**found.to_dict(), "model": model.name, "checks": checks}
    results: list[tuple[str, Any]] = [
        ("diagnosis.json", content),
        ("effects.csv", found.to_pandas()),
    ]
    if found.model is not None:
        results.append(("model.toml", partial(save_model, found.model)))
    if found.others:
        another = found.others[0].model
        results.append(("another_laboratory.toml", partial(save_model, another)))
    if drawn:
        results.append(("evidence.svg", partial(save, found.plot())))
    lines = [*head, *warnings, str(found), ""]
    return marked(written(folder, results, content, lines), model)


STAGE: Final = ("explain", 2)
EXAMPLE: Final = "pmmkit diagnose cubic my-campaign"
EMPIRICAL: Final = "empirical.toml"
"""File of the terms of a formula, as effects of the user."""


@settings
class DiagnoseSettings:
    """What is asked."""

    model: str = setting("Model file, library ship, or a structure such as cubic.", argument=True)
    campaigns: tuple[Path, ...] = setting(
        "Folder with campaign.toml, such a file, .h5, or its URL; several, captive and "
        "free running, vote together.",
        argument=True,
        metavar="CAMPAIGN",
    )
    uncertainty: NoiseSettings = NoiseSettings()
    given: Given = ()
    own: Own = None
    candidates: str | None = setting(
        "Effects and faults that free-running records are asked for, such as "
        "asymmetry,rudder_stall; the whole catalogue if absent.",
        default=None,
    )
    records: RecordSettings = RecordSettings()
    outside: bool = setting(
        "Hide each entry of the catalogue in these captive tests while the catalogue has it not: "
        "how probable is it that a name stands for something outside? A minute of processor time "
        "for 50 runs, kept in hidden_entries.json beside the campaign.",
        default=False,
    )
    figures: DrawFigures = True
    data: Data = None
    execution: ExecutionSettings = ExecutionSettings()
    out: Out = None
    force: Force = False


def diagnose(job: DiagnoseSettings) -> Outcome:
    """Do what is asked."""
    from pmmkit.base import DataError

    asked = job.records
    names = None if job.candidates is None else words(job.candidates)
    executor = job.execution.executor
    campaign = job.campaigns[0]
    known = words(job.given)
    name = "-".join(map(stem, job.campaigns))
    folder = results_folder(job.out, f"{name}-diagnosed", read=[job.model], force=job.force)
    if len(job.campaigns) > 1:
        of_one = known or job.own is not None or job.outside or executor
        if of_one or {"test_runs", "window"} & set(stated(asked)):
            raise DataError(
                "--given, --own, --outside, --test-runs, --window, --workers and --scheduler "
                "belong to the diagnosis of one campaign."
            )

        return together_outcome(
            job.model,
            job.campaigns,
            folder,
            data=job.data,
            captive=vars(job.uncertainty),
            free=asked.together(names),
            drawn=job.figures,
        )
    opened, checked = sound_campaign(campaign, job.data, executor)
    if opened.kind == "free-running":
        if known or job.uncertainty.noise is not None or job.own is not None or job.outside:
            raise DataError(
                "--given, --noise, --own and --outside belong to captive tests; these runs run "
                "free."
            )
        found, more, files, head, tail = _of_records(job, opened, checked, names)
    elif names is not None or stated(asked):
        raise DataError("Options of free-running records are of no use for captive tests.")
    else:
        found, more, files, head, tail = _of_captive_tests(job, opened, checked, known)
    content = {
        **found.to_dict(),
        "campaign": opened.title,
        **more,
        "checks": [item.to_dict() for item in checked],
    }
    results = [("diagnosis.json", content), ("effects.csv", found.to_pandas()), *files]
    lines = [*head, *warned(checked), str(found), "", *tail]
    done = written(folder, results, content, lines).then(*_next(job, found, known, folder))
    return marked(done, job.model)


_Answer = tuple[
    "Diagnosis", Mapping[str, Any], Sequence[tuple[str, Any]], Sequence[str], Sequence[str]
]
"""A diagnosis, what is told of it to programs, files, and lines above and below it."""


def _of_captive_tests(
    job: DiagnoseSettings, campaign: Tests, checked: Sequence[CheckFinding], given: Sequence[str]
) -> _Answer:
    from pmmkit.base import shown
    from pmmkit.diagnosis import begin
    from pmmkit.effects import own_effects
    from pmmkit.plotting import save
    from pmmkit.views import Loop, write_report

    own = own_effects(job.own) if job.own else ()
    executor = job.execution.executor
    with shown() if job.outside else nullcontext() as progress:
        session = begin(
            job.model,
            campaign,
            **vars(job.uncertainty),
            own=own,
            executor=executor or (os.cpu_count() if job.outside else None),
            outside=job.outside,
            progress=progress,
        )
        for effect in given:
            session = session.add(effect, "known to be there")
        loop = Loop.of(session, job.model)
    count = len(campaign.runs)
    formula = loop.diagnosis.formula
    page = partial(write_report, loop, title=campaign.title, runs=count, findings=checked)
    drawn: list[tuple[str, Any]] = [("report.html", page)] if job.figures else []
    if job.figures and loop.diagnosis.homogeneity:
        drawn.append(("homogeneity.svg", partial(save, loop.diagnosis.plot_homogeneity())))
    return (
        loop.diagnosis,
        {"model": job.model},
        [
            ("error_fall.csv", loop.fall.to_pandas()),
            *([(EMPIRICAL, formula.text(own))] if formula is not None and formula.terms else []),
            *drawn,
        ],
        [f"{campaign.title}: {count} runs against {job.model}"],
        (),
    )


def _of_records(
    job: DiagnoseSettings,
    campaign: Tests,
    checked: Sequence[CheckFinding],
    names: Sequence[str] | None,
) -> _Answer:
    from pmmkit.diagnosis import begin
    from pmmkit.models import load_model
    from pmmkit.views import write_report

    model = load_model(job.model)
    used, kept = job.records.chosen(campaign, model)
    session = begin(
        model,
        used.records,
        candidates=names,
        progress=say,
        executor=job.execution.executor,
        **present(floor=job.uncertainty.floor),
        **job.records.settings(kept),
    )
    found = session.diagnose()
    page = partial(write_report, found, session=session, title=campaign.title, findings=checked)
    errors = {name: dict(row) for name, row in found.errors.items()}
    return (
        found,
        {
            "model": model.name,
            "errors": errors,
            "used": used.content(),
            "held_out": kept.content() if kept else None,
        },
        [*_record_files(found, job.figures), *([("report.html", page)] if job.figures else [])],
        [
            f"{campaign.title}: {len(used.records)} records against {model.name}",
            *used.words("Used"),
            *(kept.words("Held out") if kept else []),
        ],
        [
            "Root mean square errors over windows with the measured rudder:",
            errors_table(errors),
            "",
        ],
    )


def _record_files(found: Diagnosis, drawn: bool) -> Iterator[tuple[str, Any]]:
    from pmmkit.models import save_model
    from pmmkit.plotting import save

    for name, made in (("model", found.model), ("model_refitted", found.refitted)):
        if made is not None:
            yield f"{name}.toml", partial(save_model, made)
    if drawn:
        yield "evidence.svg", partial(save, found.plot())
        yield "coverage.svg", partial(save, found.plot_coverage())


def _next(job: DiagnoseSettings, found: Diagnosis, given: Sequence[str], folder: Path) -> list[str]:
    """The commands that put the findings, or a formula in their place, into the model, or plan the
    run that decides."""
    campaign = job.campaigns[0]
    advice = f"pmmkit plan {as_typed(PlanSettings(model=job.model, campaign=campaign))}"
    lines = []
    if found.findings:
        lines += _adding("Next:", job, (*given, *(x.effect for x in found.proposed)), job.own)
        lines += [f"Or, to tell the rivals apart: {advice}"] * (len(found.group) > 1)
    elif found.suspected:
        lines.append(f"Next: {advice}")
    elif found.verdict == "refit":
        lines.append(f"Next: take {folder / 'model.toml'}: the values that fit these records.")
    if found.formula is not None and found.formula.terms:
        names = [x.name for x in found.formula.effects]
        effects = (*given, *found.formula.beside, *names)
        head = "Or, as numbers without a cause:" if lines else "Next, as numbers without a cause:"
        lines += _adding(head, job, effects, folder / EMPIRICAL)
    return lines


def _adding(
    head: str, job: DiagnoseSettings, effects: tuple[str, ...], own: Path | None
) -> list[str]:
    """The command that adds effects to the model; to a structure after it is reduced."""
    from pmmkit.conventions import STRUCTURES
    from pmmkit.files import MODEL, free_folder, is_empty_place

    campaign = job.campaigns[0]
    better = AddSettings(
        model=job.model,
        effects=effects,
        fit=(campaign,),
        data=job.data,
        records=job.records,
        uncertainty=job.uncertainty,
        own=own,
        target=next(filter(is_empty_place, (Path(f"model{n}.toml") for n in count(2)))),
    )
    if job.model not in STRUCTURES:
        return [f"{head} pmmkit add {as_typed(better)}"]
    folder = free_folder(Path(f"{stem(campaign)}-reduced"))
    base = ReduceSettings(
        campaign=campaign, structure=job.model, fn="pooled", data=job.data, out=folder
    )
    fitted = settings_from(AddSettings, {**stated(better), "model": str(folder / MODEL.file)})
    return [
        f"{head} pmmkit reduce {as_typed(base)}",
        f"{' ' * len(head)} pmmkit add {as_typed(fitted)}",
    ]
