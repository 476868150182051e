"""``pmmkit identify``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from pmmkit.base import did_you_mean
from pmmkit.cli.options import (
    Campaign,
    Data,
    Scheduler,
    patterns,
    sensors_of,
    sound_campaign,
    stem,
    where,
    words,
)
from pmmkit.cli.output import Outcome, marked, warned
from pmmkit.cli.outputs import Force, Out, results_folder

if TYPE_CHECKING:
    from pmmkit.identification import Chosen, MethodComparison, Smoothed
    from pmmkit.inference import Consistency
    from pmmkit.intake import CheckFinding


EXAMPLE: Final = "pmmkit identify my-zigzags --model kvlcc2-l7 --derivatives 'Yv Yr Nv Nr'"


class IdentificationChoice(StrEnum):
    """A method of identification, or all of them."""

    ekf = "ekf"
    ukf = "ukf"
    trajectory = "trajectory"
    regression = "regression"
    sindy = "sindy"
    posterior = "posterior"
    all = "all"


class Rudder(StrEnum):
    """What the rudder column is."""

    auto = "auto"
    measured = "measured"
    ordered = "ordered"


def identify(
    campaign: Campaign,
    model: Annotated[
        str,
        typer.Option(
            help="Library ship or model file of the ship, at its scale: what is not identified "
            "keeps its values."
        ),
    ],
    method: Annotated[
        IdentificationChoice,
        typer.Option(
            help="all compares the methods that take seconds; posterior draws, in minutes (pip "
            "install 'pmmkit[posterior]')."
        ),
    ] = IdentificationChoice.ekf,
    derivatives: Annotated[
        str | None,
        typer.Option(
            help="What to identify, such as 'Yv Yr Nv Nr rudder_mmg.aH current_x'; all derivatives "
            "of the hull if absent."
        ),
    ] = None,
    prior: Annotated[
        str | None,
        typer.Option(
            help="Library ship, model file or derivative table with what was known before; the "
            "model itself if absent."
        ),
    ] = None,
    spread: Annotated[
        float | None,
        typer.Option(
            help="Relative standard deviation before, in place of any covariance; 0.3 where "
            "nothing is known."
        ),
    ] = None,
    runs: Annotated[
        list[str] | None,
        typer.Option(
            help="Runs to identify from, such as 'turn_*,ZZ10'; may be repeated. All but those "
            "held out if absent."
        ),
    ] = None,
    test_runs: Annotated[
        list[str] | None,
        typer.Option("--test-runs", help="Runs held out, which the result has to predict."),
    ] = None,
    channels: Annotated[
        str | None, typer.Option(help="Measurements to use, such as x,y,psi,r; all if absent.")
    ] = None,
    sensors: Annotated[
        str | None,
        typer.Option(
            help="Standard deviations of channels, SI or with _deg, such as x=0.03,y=0.03,"
            "psi_deg=0.1; told from the noise of the records if absent."
        ),
    ] = None,
    rudder: Annotated[
        Rudder,
        typer.Option(
            help="Whether the column delta is the angle, or the order that the gear follows."
        ),
    ] = Rudder.auto,
    wind: Annotated[bool, typer.Option(help="Use the measured wind.")] = True,
    shortest: Annotated[
        float | None,
        typer.Option(
            min=0.1, help="Leave out segments shorter than this, in s; ten ship lengths if absent."
        ),
    ] = None,
    window: Annotated[
        float, typer.Option(min=0.1, help="Length in s of the windows that are predicted.")
    ] = 60.0,
    extrapolate: Annotated[
        bool, typer.Option("--extrapolate", help="Allow speeds outside the model's range.")
    ] = False,
    steps: Annotated[
        int | None, typer.Option(min=60, help="posterior: most steps of a walker; 2000 if absent.")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="posterior: of the draws.")] = 0,
    workers: Annotated[
        int | None,
        typer.Option(
            min=1,
            help="posterior: how many ensembles are moved side by side on this machine; one after "
            "another if absent.",
        ),
    ] = None,
    scheduler: Scheduler = None,
    data: Data = None,
    out: Out = None,
    force: Force = False,
) -> Outcome:
    """Identify derivatives from free-running records, and predict runs that were held out."""
    from pmmkit.base import UnknownNameError, shown
    from pmmkit.files import write_results
    from pmmkit.identification import (
        CHANNELS,
        SECONDS,
        Filtered,
        chosen_records,
        compare_methods,
        consistency,
        known_before,
        parameters_of,
        reference,
    )
    from pmmkit.models import load_model

    if spread is not None and spread <= 0.0:
        raise typer.BadParameter(f"--spread {spread:g}: it is a positive share, such as 0.3.")
    stds = sensors_of(sensors)
    folder = results_folder(out, f"{stem(campaign)}-identified", read=[model, prior], force=force)
    base = load_model(model)
    if lost := [name for name in stds or {} if name not in CHANNELS]:
        raise UnknownNameError(
            f"There is no channel {', '.join(lost)}{did_you_mean(lost[0], CHANNELS) or '.'} There "
            f"are {', '.join(CHANNELS)}."
        )
    opened, findings = sound_campaign(campaign, data)
    used, held_out = chosen_records(
        opened,
        base,
        runs=patterns(runs),
        test_runs=patterns(test_runs),
        channels=None if channels is None else words(channels),
        rudder=rudder.value,
        wind=wind,
        shortest=shortest,
    )
    used, held_out = used.corrected(base), held_out and held_out.corrected(base)
    names = parameters_of(base, None if derivatives is None else words(derivatives))
    before = known_before(
        base, names, used.records[0].speed, prior=prior, spread=spread, extrapolate=extrapolate
    )
    judged = (held_out or used).long_enough(window)
    with shown() as progress:
        references: tuple[Smoothed, ...] = ()
        for number, record in enumerate(judged):
            progress(number, len(judged), f"smooth {record.name}")
            references += reference(base, [record], sensors=stds, extrapolate=extrapolate)
        found = compare_methods(
            base,
            used.records,
            names,
            methods=SECONDS if method is IdentificationChoice.all else (method.value,),
            references=references,
            window=window,
            prior=before,
            sensors=stds,
            extrapolate=extrapolate,
            settings={
                IdentificationChoice.posterior.value: {
                    "seed": seed,
                    "executor": where(workers, scheduler),
                    **({} if steps is None else {"steps": steps}),
                }
            },
            progress=progress,
        )
    tests = {
        name: consistency(item.detail)
        for name, item in found.found.items()
        if isinstance(item.detail, Filtered)
    }
    work = _Work(
        title=opened.title,
        used=used,
        held_out=held_out,
        found=found,
        references=references,
        tests=tests,
        findings=findings,
    )
    content = _content(work)
    files = write_results(folder, _files(work, content, extrapolate))
    lines = [*_words(work), "", f"Results: {folder}"]
    done = Outcome(content={"out": str(folder), "files": files, **content}, lines=lines)
    return marked(done, base)


@dataclass(frozen=True, kw_only=True)
class _Work:
    """All that one call of the command found."""

    title: str
    used: Chosen
    held_out: Chosen | None
    found: MethodComparison
    references: tuple[Smoothed, ...]
    tests: Mapping[str, Consistency]
    findings: Sequence[CheckFinding]


def _files(work: _Work, content: Mapping[str, Any], extrapolate: bool) -> Iterator[tuple[str, Any]]:
    from pmmkit.identification import BEFORE, Posterior, predicted_window, write_posterior
    from pmmkit.models import save_model
    from pmmkit.plotting import save
    from pmmkit.views import innovation_figure, parameter_histories, window_figure

    found, records = work.found, work.used.records
    yield "identified.csv", found.parameters()
    errors = found.errors()
    errors.insert(2, "held_out", work.held_out is not None)
    yield "predictions.csv", errors
    yield "identified.json", content
    for name, item in found.found.items():
        ending = "" if len(found.found) + len(found.failed) == 1 else f"_{name}"
        yield f"model{ending}.toml", partial(save_model, item.model)
    yield "parameters.svg", partial(save, found.plot())
    for name in work.tests:
        detail = found.found[name].detail
        drawn = parameter_histories(detail, records, found.model.convention)
        yield f"history_{name}.svg", partial(save, drawn)
        drawn = innovation_figure(detail, records)
        yield f"innovations_{name}.svg", partial(save, drawn)
    for item in found.found.values():
        if isinstance(item.detail, Posterior):
            yield "posterior.nc", partial(write_posterior, item.detail.tree)
            yield "posterior.svg", partial(save, item.detail.plot(item.model.convention))
    models = {BEFORE: found.model, **{name: x.model for name, x in found.found.items()}}
    sailed = predicted_window(
        models,
        work.references,
        window=found.window,
        extrapolate=extrapolate,
        currents=found.currents,
    )
    yield "prediction.svg", partial(save, window_figure(sailed))


def _content(work: _Work) -> dict[str, Any]:
    from pmmkit.identification import BEFORE, UNITS, Posterior

    found = work.found
    predictions = {
        name: {**item.errors, "all": item.pooled()} for name, item in found.predictions.items()
    }
    return {
        "campaign": work.title,
        "model": found.model.name,
        "used": work.used.content(),
        "held_out": work.held_out.content() if work.held_out else None,
        "prior": found.prior.origin,
        "window": found.window,
        "units": dict(UNITS),
        "methods": {
            name: {
                "parameters": item.to_pandas().reset_index().to_dict("records"),
                "unseen": list(item.unseen),
                "left_out": list(item.left_out),
                "missing": list(item.missing),
                "seconds": item.seconds,
                "notes": list(item.notes),
                "errors": predictions.get(name, {}),
                "consistency": work.tests[name].to_pandas().to_dict("records")
                if name in work.tests
                else None,
                "judgement": list(work.tests[name].words()) if name in work.tests else [],
                **(item.detail.content() if isinstance(item.detail, Posterior) else {}),
            }
            for name, item in found.found.items()
        },
        "failed": dict(found.failed),
        "errors_before": predictions.get(BEFORE, {}),
        "findings": [item.to_dict() for item in work.findings],
    }


def _words(work: _Work) -> list[str]:
    """What the command prints."""
    lines = [f"{work.title}: identified with {work.found.model.name}", *work.used.words("Used")]
    if work.held_out is not None:
        lines += work.held_out.words("Held out")
    lines += [*warned(work.findings), "", str(work.found), ""]
    lines.append(
        "The predictions are of the runs held out."
        if work.held_out is not None
        else "The predictions are of the very runs that were used, which is no test: hold some out "
        "with --test-runs."
    )
    tests = [f"{name}: {text}" for name, test in work.tests.items() for text in test.words()]
    return [*lines, *tests]
