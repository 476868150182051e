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
from pmmkit.actions.jobs.uncertainty import UncertaintySettings
from pmmkit.actions.outcome import Outcome, marked, results_folder, say, warned, written
from pmmkit.actions.records import (
    RecordSettings,
    errors_table,
    middle_speed,
    session_of_several,
    sound_campaign,
    sound_campaigns,
)
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
    OrderSettings,
    Out,
    Own,
)
from pmmkit.actions.speeds import TypedSpeed

if TYPE_CHECKING:
    import pandas as pd

    from pmmkit.campaigns import Campaign as Tests
    from pmmkit.diagnosis import Diagnosis, Together
    from pmmkit.intake import CheckFinding
    from pmmkit.models import Model


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
    from pmmkit.conventions import STRUCTURES
    from pmmkit.models import load_model

    asked = job.records
    names = None if job.candidates is None else words(job.candidates)
    executor = job.execution.executor
    campaign = job.campaigns[0]
    known = words(job.given)
    name = "-".join(map(stem, job.campaigns))
    folder = results_folder(job.out, f"{name}-diagnosed", read=[job.model], force=job.force)
    if len(job.campaigns) > 1:
        return marked(_together(job, names, known, folder), job.model)
    like = None if job.model in STRUCTURES else load_model(job.model)
    opened, checked = sound_campaign(campaign, job.data, executor, model=like)
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
        drawn.append(("homogeneity.svg", loop.diagnosis.plot_homogeneity().save))
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


# Several campaigns of one ship.


NEXT_SHIP: Final = "another_laboratory.toml"
"""File of the model of a laboratory that has not tested yet."""
SHIPS: Final = 500
"""Ships that tell its turn: an end of a 95 % interval is known to a tenth of its half."""


def _together(
    job: DiagnoseSettings, names: Sequence[str] | None, given: Sequence[str], folder: Path
) -> Outcome:
    """The answer of several campaigns, and what it says of the next ship."""
    from pmmkit.base import DataError
    from pmmkit.conventions import STRUCTURES
    from pmmkit.effects import own_effects
    from pmmkit.models import load_model, save_model

    if job.outside:
        raise DataError("--outside belongs to the diagnosis of one campaign.")
    if job.model in STRUCTURES:
        raise DataError(
            f"{job.model} is a structure: several campaigns are asked about a model. Give a model "
            f"file or a library ship; pmmkit reduce writes a model from captive tests."
        )
    model = load_model(job.model)
    opened = sound_campaigns(job.campaigns, job.data, model)
    free = [one for one, _ in opened.values() if one.kind == "free-running"]
    session = session_of_several(
        model,
        {title: one for title, (one, _) in opened.items()},
        names,
        job.records,
        **vars(job.uncertainty),
        own=own_effects(job.own) if job.own else (),
        executor=job.execution.executor,
    )
    for effect in given:
        name, _, of = effect.partition("@")
        session = session.add(name, "known to be there", campaign=of)
    found = session.diagnose()
    speed = middle_speed(free[0], found.others[0].model) if found.others else 0.0
    turns = turns_of(found.others[0].model, found.others[0].ship, speed) if found.others else None
    head = [f"{title}: {len(one.runs)} runs, {one.kind}" for title, (one, _) in opened.items()]
    warnings = [text for _, checked in opened.values() for text in warned(checked)]
    content = {
        **found.to_dict(),
        "model": model.name,
        "turn": {} if turns is None else turns.to_dict("index"),
        "checks": {title: [x.to_dict() for x in own] for title, (_, own) in opened.items()},
    }
    results: list[tuple[str, Any]] = [
        ("diagnosis.json", content),
        ("effects.csv", found.to_pandas()),
    ]
    if found.model is not None:
        results.append(("model.toml", partial(save_model, found.model)))
    if found.others:
        results.append((NEXT_SHIP, partial(save_model, found.others[0].model)))
    if turns is not None:
        results.append(("turn.csv", turns.to_csv))
    if job.figures:
        results.append(("evidence.svg", found.plot().save))
    lines = [*head, *warnings, str(found), ""]
    for title, rows in found.errors.items():
        lines += [f"{title}, what is held out:", errors_table(rows), ""]
    if turns is not None:
        lines += _turn_words(turns, speed)
    done = written(folder, results, content, lines)
    return done.then(*_next_of_all(job, found, given, folder / NEXT_SHIP, speed))


def turns_of(another: Model, alone: Model, speed: float) -> pd.DataFrame | None:
    """Turns of a laboratory that has not tested yet to both sides: a row for each measure, in ship
    lengths, with its 95 % interval, and that of what is not known of the ship alone; None where
    such a ship cannot turn.

    speed [m/s].
    """
    import numpy as np
    import pandas as pd

    from pmmkit.base import PmmkitError
    from pmmkit.conventions import Criterion
    from pmmkit.simulation import monte_carlo

    rows = {}
    for side, sign in (("starboard", 1.0), ("port", -1.0)):
        order: dict[str, Any] = {
            "speed": speed,
            "rudder_deg": sign * Criterion.HARD_OVER,
            "n": SHIPS,
        }
        try:
            whole, ship = (monte_carlo(x, **order) for x in (another, alone))
        except PmmkitError:
            return None
        for measure in ("advance_L", "transfer_L", "tactical_diameter_L", "steady_diameter_L"):
            low, high = whole.interval(measure)
            least, most = ship.interval(measure)
            rows[f"{measure} {side}"] = {
                "mean": float(np.nanmean(whole.metrics[measure])),
                "low": low,
                "high": high,
                "ship_low": least,
                "ship_high": most,
            }
    return pd.DataFrame.from_dict(rows, orient="index")


def _turn_words(turns: pd.DataFrame, speed: float) -> list[str]:
    """The turns in words.

    speed [m/s].
    """
    from pmmkit.conventions import Criterion
    from pmmkit.presentation import aligned

    rows = [
        [
            str(name).replace("_L ", " to ").replace("_", " "),
            f"{row['mean']:.2f}",
            f"{row['low']:.2f} to {row['high']:.2f}",
            f"{row['ship_low']:.2f} to {row['ship_high']:.2f}",
        ]
        for name, row in turns.iterrows()
    ]
    return [
        f"Turn of a laboratory that has not tested yet, {Criterion.HARD_OVER:g}° of rudder at "
        f"{speed:.4g} m/s, in ship lengths with 95 % intervals; the last column "
        "is what is not known of the ship, the rest of it by what laboratories differ:",
        aligned(["", "mean", "next laboratory", "of the ship"], rows),
        "",
    ]


def _next_of_all(
    job: DiagnoseSettings, found: Together, given: Sequence[str], another: Path, speed: float
) -> list[str]:
    """The commands that put what is the ship's into the model, and that ask the next ship.

    speed [m/s].
    """
    from pmmkit.conventions import Criterion

    lines = []
    titles = dict(zip(found.names, job.campaigns, strict=True))
    if found.proposed:
        faults = [f"{x}@{name}" for name in titles for x in found.faults_of(name)]
        lines += _adding("Next:", job, (*given, *found.proposed, *faults), job.own)
    if found.others:
        turn = UncertaintySettings(
            model=str(another),
            speed=TypedSpeed(round(speed, 3)),
            orders=OrderSettings(rudder_deg=Criterion.HARD_OVER),
        )
        lines.append(f"For the next ship: pmmkit uncertainty {as_typed(turn)}")
    return lines


def _record_files(found: Diagnosis, drawn: bool) -> Iterator[tuple[str, Any]]:
    from pmmkit.models import save_model

    for name, made in (("model", found.model), ("model_refitted", found.refitted)):
        if made is not None:
            yield f"{name}.toml", partial(save_model, made)
    if drawn:
        yield "evidence.svg", found.plot().save
        yield "coverage.svg", found.plot_coverage().save


def _next(job: DiagnoseSettings, found: Diagnosis, given: Sequence[str], folder: Path) -> list[str]:
    """The commands that put the findings, or a formula in their place, into the model, or plan the
    run that decides."""
    campaign = job.campaigns[0]
    advice = f"pmmkit plan {as_typed(PlanSettings(model=job.model, campaign=campaign))}"
    lines = _with_tests(job, found)
    if found.findings and not found.proposed:
        lines.append("No effect is advised: each holds for one kind of run alone.")
    elif found.findings:
        head = "Or, by these records alone:" if lines else "Next:"
        lines += _adding(head, job, (*given, *(x.effect for x in found.proposed)), job.own)
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


def _with_tests(job: DiagnoseSettings, found: Diagnosis) -> list[str]:
    """The advice to ask records together with the captive tests that the model was made of: of
    several that were tried that predicted a third laboratory best (docs/case_next_ship.md)."""
    from pmmkit.conventions import STRUCTURES
    from pmmkit.models import load_model

    if job.model in STRUCTURES or found.model is None or not found.findings:
        return []
    model = load_model(job.model)
    built = [step.ship for step in model.steps if step.action == "built"]
    if model.covariance is None or not built:
        return []
    asked = DiagnoseSettings(
        model=job.model,
        campaigns=(Path("TESTS"), *job.campaigns),
        data=job.data,
        records=job.records,
    )
    return [f"Next, TESTS for the captive tests of {built[-1]}: pmmkit diagnose {as_typed(asked)}"]


def _adding(
    head: str, job: DiagnoseSettings, effects: tuple[str, ...], own: Path | None
) -> list[str]:
    """The command that adds effects to the model; to a structure after it is reduced."""
    from pmmkit.conventions import STRUCTURES
    from pmmkit.files import MODEL, free_folder, is_empty_place

    better = AddSettings(
        model=job.model,
        effects=effects,
        fit=job.campaigns,
        data=job.data,
        records=job.records,
        uncertainty=job.uncertainty,
        own=own,
        output=next(filter(is_empty_place, (Path(f"model{n}.toml") for n in count(2)))),
    )
    if job.model not in STRUCTURES:
        return [f"{head} pmmkit add {as_typed(better)}"]
    campaign = job.campaigns[0]
    folder = free_folder(Path(f"{stem(campaign)}-reduced"))
    base = ReduceSettings(
        campaign=campaign, structure=job.model, fn="pooled", data=job.data, out=folder
    )
    fitted = settings_from(AddSettings, {**stated(better), "model": str(folder / MODEL.file)})
    return [
        f"{head} pmmkit reduce {as_typed(base)}",
        f"{' ' * len(head)} pmmkit add {as_typed(fitted)}",
    ]
