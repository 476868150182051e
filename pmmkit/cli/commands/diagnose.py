"""``pmmkit diagnose``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from pmmkit.cli.options import (
    Data,
    DrawFigures,
    Floor,
    Given,
    Noise,
    Own,
    Scheduler,
    WorkerCount,
    sound_campaign,
    stated,
    stem,
    typed_again,
    where,
    words,
)
from pmmkit.cli.output import Outcome, marked, say, warned
from pmmkit.cli.outputs import Force, Out, results_folder
from pmmkit.cli.records import (
    WINDOW,
    Candidates,
    Channels,
    Judged,
    RecordOptions,
    Runs,
    Sensors,
    Shortest,
    Spread,
    TestRuns,
    Windage,
    Window,
    errors_table,
)
from pmmkit.presentation import quoted

if TYPE_CHECKING:
    from pmmkit.base import Workers
    from pmmkit.campaigns import Campaign as Tests
    from pmmkit.diagnosis import Diagnosis
    from pmmkit.intake import CheckFinding

EXAMPLE: Final = "pmmkit diagnose cubic my-campaign"
Base = Annotated[
    str, typer.Argument(help="Model file, library ship, or a structure such as cubic.")
]
Campaigns = Annotated[
    list[Path],
    typer.Argument(
        metavar="CAMPAIGN",
        help="Folder with campaign.toml, such a file, .h5, or its URL; several, captive and "
        "free running, vote together.",
    ),
]


def diagnose(
    model: Base,
    campaigns: Campaigns,
    floor: Floor = None,
    noise: Noise = None,
    given: Given = None,
    own: Own = None,
    candidates: Candidates = None,
    runs: Runs = None,
    test_runs: TestRuns = None,
    channels: Channels = None,
    spread: Spread = None,
    shortest: Shortest = None,
    sensors: Sensors = None,
    windage: Windage = None,
    judged: Judged = None,
    window: Window = WINDOW,
    figures: DrawFigures = True,
    data: Data = None,
    workers: WorkerCount = None,
    scheduler: Scheduler = None,
    out: Out = None,
    force: Force = False,
) -> Outcome:
    """Name the effect, or the fault of the measurement, that the model lacks."""
    from pmmkit.base import DataError
    from pmmkit.files import write_results

    asked = RecordOptions(
        candidates=candidates,
        runs=runs,
        test_runs=test_runs,
        channels=channels,
        spread=spread,
        shortest=shortest,
        sensors=sensors,
        windage=windage,
        judged=judged,
        window=window,
    )
    executor = where(workers, scheduler)
    campaign = campaigns[0]
    known = words(given)
    name = "-".join(map(stem, campaigns))
    folder = results_folder(out, f"{name}-diagnosed", read=[model], force=force)
    if len(campaigns) > 1:
        if known or own is not None or test_runs or window != WINDOW or executor:
            raise DataError(
                "--given, --own, --test-runs, --window, --workers and --scheduler belong to the "
                "diagnosis of one campaign."
            )
        from pmmkit.cli.together import together_outcome

        return together_outcome(
            model,
            campaigns,
            folder,
            data=data,
            captive={"floor": floor, "noise": noise},
            free=asked.together(),
            drawn=figures,
        )
    opened, checked = sound_campaign(campaign, data, executor)
    if opened.kind == "free-running":
        if known or noise is not None or own is not None:
            raise DataError(
                "--given, --noise and --own belong to captive tests; these runs run free."
            )
        answer = _of_records(model, opened, checked, asked, executor, floor=floor, drawn=figures)
    elif asked.typed():
        raise DataError("Options of free-running records are of no use for captive tests.")
    else:
        answer = _of_captive_tests(
            model,
            opened,
            checked,
            executor,
            floor=floor,
            noise=noise,
            own=own,
            given=known,
            drawn=figures,
        )
    found = answer.found
    content = {
        **found.to_dict(),
        "campaign": opened.title,
        **answer.content,
        "checks": [item.to_dict() for item in checked],
    }
    results = [("diagnosis.json", content), ("effects.csv", found.to_pandas()), *answer.files]
    files = write_results(folder, results)
    lines = [
        *answer.head,
        *warned(checked),
        str(found),
        "",
        *answer.tail,
        f"Results: {folder}",
        *_next(
            model,
            campaign,
            found,
            known,
            data=typed_again(data=data),
            options=asked.repeated() + typed_again(floor=floor, noise=noise, own=own),
        ),
    ]
    done = Outcome(content={"out": str(folder), "files": files, **content}, lines=lines)
    return marked(done, model)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Answer:
    """A diagnosis with what is said of it, and written, beside it."""

    found: Diagnosis
    content: Mapping[str, Any]
    files: Sequence[tuple[str, Any]]
    head: Sequence[str]
    tail: Sequence[str] = ()


def _of_captive_tests(
    model: str,
    campaign: Tests,
    checked: Sequence[CheckFinding],
    executor: Workers,
    *,
    floor: float | None,
    noise: float | None,
    own: Path | None,
    given: Sequence[str],
    drawn: bool,
) -> _Answer:
    from pmmkit.diagnosis import begin
    from pmmkit.effects import own_effects
    from pmmkit.views import loop_of, write_diagnosis

    session = begin(
        model,
        campaign,
        floor=floor,
        noise=noise,
        own=own_effects(own) if own else (),
        executor=executor,
    )
    for effect in given:
        session = session.add(effect, "known to be there")
    loop = loop_of(session, model)
    count = len(campaign.runs)
    page = partial(write_diagnosis, loop, title=campaign.title, runs=count, findings=checked)
    return _Answer(
        found=loop.diagnosis,
        content={"model": model},
        files=[
            ("error_fall.csv", loop.fall.to_pandas()),
            *([("report.html", page)] if drawn else []),
        ],
        head=[f"{campaign.title}: {count} runs against {model}"],
    )


def _of_records(
    name: str,
    campaign: Tests,
    checked: Sequence[CheckFinding],
    asked: RecordOptions,
    executor: Workers,
    *,
    floor: float | None,
    drawn: bool,
) -> _Answer:
    from pmmkit.diagnosis import begin
    from pmmkit.models import load_model
    from pmmkit.views import write_free_diagnosis

    model = load_model(name)
    used, kept = asked.chosen(campaign, model)
    session = begin(
        model,
        used.records,
        candidates=asked.names,
        progress=say,
        executor=executor,
        **stated(floor=floor),
        **asked.settings(kept),
    )
    found = session.diagnose()
    page = partial(write_free_diagnosis, found, session, title=campaign.title, findings=checked)
    errors = {name: dict(row) for name, row in found.errors.items()}
    return _Answer(
        found=found,
        content={
            "model": model.name,
            "errors": errors,
            "used": used.content(),
            "held_out": kept.content() if kept else None,
        },
        files=[*_record_files(found, drawn), *([("report.html", page)] if drawn else [])],
        head=[
            f"{campaign.title}: {len(used.records)} records against {model.name}",
            *used.words("Used"),
            *(kept.words("Held out") if kept else []),
        ],
        tail=[
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


def _next(
    model: str, campaign: Path, found: Diagnosis, given: Sequence[str], *, data: str, options: str
) -> list[str]:
    """The command that puts the findings into the model, or plans the run that decides."""
    from pmmkit.conventions import STRUCTURES
    from pmmkit.files import first_free, free_folder

    base, tests = quoted(Path(model)), quoted(campaign)
    advice = f"pmmkit plan {base} {tests}"
    if not found.findings:
        return [f"Next: {advice}"] if found.suspected else []
    told_apart = [f"Or, to tell the rivals apart: {advice}"] if len(found.group) > 1 else []
    names = " ".join([*given, *(item.effect for item in found.proposed)])
    better = first_free(Path(f"model{number}.toml") for number in count(2))
    fit = f"--fit {tests}{data}{options} -o {better}"
    if model not in STRUCTURES:
        return [f"Next: pmmkit add {base} {names} {fit}", *told_apart]
    reduced = free_folder(Path(f"{stem(campaign)}-reduced"))
    into = f"--structure {model} --fn pooled{data} --out {quoted(reduced)}"
    return [
        f"Next: pmmkit reduce {tests} {into}",
        f"      pmmkit add {quoted(reduced / 'model.toml')} {names} {fit}",
        *told_apart,
    ]
