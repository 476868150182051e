"""Identify derivatives from free-running records, and predict runs that were held out."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, Final, Literal

from pmmkit.actions.outcome import Outcome, marked, results_folder, warned, written
from pmmkit.actions.records import sound_campaign
from pmmkit.actions.setting import (
    SettingError,
    patterns,
    sensors_of,
    setting,
    settings,
    stem,
    words,
)
from pmmkit.actions.shared import Campaign, Data, ExecutionSettings, Force, Out
from pmmkit.base import did_you_mean

if TYPE_CHECKING:
    from pmmkit.identification import Chosen, MethodComparison, Smoothed
    from pmmkit.inference import Consistency
    from pmmkit.intake import CheckFinding


STAGE: Final = ("measure", 5)
EXAMPLE: Final = "pmmkit identify my-zigzags --model kvlcc2-l7 --derivatives 'Yv Yr Nv Nr'"


Method = Literal["ekf", "ukf", "trajectory", "regression", "sindy", "posterior", "all"]
"""A method of identification, or all of them."""


@settings
class MeasurementSettings:
    """Measurements that are used."""

    channels: str | None = setting(
        "Measurements to use, such as x,y,psi,r; all if absent.", default=None
    )
    sensors: str | None = setting(
        "Standard deviations of channels, SI or with _deg, such as x=0.03,y=0.03,"
        "psi_deg=0.1; told from the noise of the records if absent.",
        default=None,
    )
    rudder: Literal["auto", "measured", "ordered"] = setting(
        "Whether the column delta is the angle, or the order that the gear follows.", default="auto"
    )
    wind: bool = setting("Use the measured wind.", default=True)
    shortest: float | None = setting(
        "Leave out segments shorter than this, in s; ten ship lengths if absent.",
        default=None,
        least=0.1,
    )


@settings
class PredictionSettings:
    """What the result has to predict."""

    test_runs: tuple[str, ...] = setting(
        "Runs held out, which the result has to predict.", default=()
    )
    window: float = setting(
        "Length in s of the windows that are predicted.", default=60.0, least=0.1
    )


@settings
class PosteriorSettings(ExecutionSettings):
    """The posterior."""

    steps: int | None = setting(
        "posterior: most steps of a walker; 2000 if absent.", default=None, least=60
    )
    seed: int = setting("posterior: of the draws.", default=0, least=0)
    workers: int | None = setting(
        "posterior: how many ensembles are moved side by side on this machine; one after "
        "another if absent.",
        default=None,
        least=1,
    )


@settings
class IdentifySettings:
    """What is asked."""

    campaign: Campaign
    model: str = setting(
        "Library ship or model file of the ship, at its scale: what is not identified "
        "keeps its values."
    )
    method: Method = setting(
        "all compares the methods that take seconds; posterior draws, in minutes (pip "
        "install 'pmmkit[posterior]').",
        default="ekf",
    )
    derivatives: str | None = setting(
        "What to identify, such as 'Yv Yr Nv Nr rudder_mmg.aH current_x'; all derivatives "
        "of the hull if absent.",
        default=None,
    )
    prior: str | None = setting(
        "Library ship, model file or derivative table with what was known before; the "
        "model itself if absent.",
        default=None,
    )
    spread: float | None = setting(
        "Relative standard deviation before, in place of any covariance; 0.3 where "
        "nothing is known.",
        default=None,
    )
    runs: tuple[str, ...] = setting(
        "Runs to identify from, such as 'turn_*,ZZ10'; may be repeated. All but those "
        "held out if absent.",
        default=(),
    )
    prediction: PredictionSettings = PredictionSettings()
    measurements: MeasurementSettings = MeasurementSettings()
    extrapolate: bool = setting("Allow speeds outside the model's range.", default=False)
    posterior: PosteriorSettings = PosteriorSettings()
    data: Data = None
    out: Out = None
    force: Force = False


def identify(job: IdentifySettings) -> Outcome:
    """Do what is asked."""
    from pmmkit.base import UnknownNameError, shown
    from pmmkit.identification import (
        Chosen,
        Filtered,
        FreeRecord,
        Smoothed,
        compare_methods,
        known_before,
    )
    from pmmkit.models import load_model

    if job.spread is not None and job.spread <= 0.0:
        raise SettingError(f"--spread {job.spread:g}: it is a positive share, such as 0.3.")
    stds = sensors_of(job.measurements.sensors)
    folder = results_folder(
        job.out, f"{stem(job.campaign)}-identified", read=[job.model, job.prior], force=job.force
    )
    base = load_model(job.model)
    channels_known = FreeRecord.CHANNELS
    if lost := [name for name in stds or {} if name not in channels_known]:
        raise UnknownNameError(
            f"There is no channel {', '.join(lost)}{did_you_mean(lost[0], channels_known) or '.'} "
            f"There are {', '.join(channels_known)}."
        )
    opened, findings = sound_campaign(job.campaign, job.data)
    used, held_out = Chosen.of(
        opened,
        base,
        runs=patterns(job.runs),
        test_runs=patterns(job.prediction.test_runs),
        channels=None if job.measurements.channels is None else words(job.measurements.channels),
        rudder=job.measurements.rudder,
        wind=job.measurements.wind,
        shortest=job.measurements.shortest,
    )
    used, held_out = used.corrected(base), held_out and held_out.corrected(base)
    before = known_before(
        base,
        None if job.derivatives is None else words(job.derivatives),
        used.records[0].speed,
        prior=job.prior,
        spread=job.spread,
        extrapolate=job.extrapolate,
    )
    judged = (held_out or used).long_enough(job.prediction.window)
    some: dict[str, Any] = {} if job.method == "all" else {"methods": (job.method,)}
    with shown() as progress:
        references: tuple[Smoothed, ...] = ()
        for number, record in enumerate(judged):
            progress(number, len(judged), f"smooth {record.name}")
            references += Smoothed.references(
                base, [record], sensors=stds, extrapolate=job.extrapolate
            )
        found = compare_methods(
            base,
            used.records,
            before.names,
            **some,
            references=references,
            window=job.prediction.window,
            prior=before,
            sensors=stds,
            extrapolate=job.extrapolate,
            settings={
                "posterior": {
                    "seed": job.posterior.seed,
                    "executor": job.posterior.executor,
                    **({} if job.posterior.steps is None else {"steps": job.posterior.steps}),
                }
            },
            progress=progress,
        )
    tests = {
        name: item.detail.consistency
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
    results = _files(work, content, job.extrapolate)
    return marked(written(folder, results, content, [*_words(work), ""]), base)


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
    from pmmkit.identification import Posterior, PredictedWindow
    from pmmkit.models import save_model
    from pmmkit.views import filter_figures, window_figure

    found, records = work.found, work.used.records
    yield "identified.csv", found.parameters()
    errors = found.errors()
    errors.insert(2, "held_out", work.held_out is not None)
    yield "predictions.csv", errors
    yield "identified.json", content
    for name, item in found.found.items():
        ending = "" if len(found.found) + len(found.failed) == 1 else f"_{name}"
        yield f"model{ending}.toml", partial(save_model, item.model)
    yield "parameters.svg", found.plot().save
    for name in work.tests:
        detail = found.found[name].detail
        for kind, drawn in filter_figures(detail, records, found.model.convention).items():
            yield f"{kind}_{name}.svg", drawn.save
    for item in found.found.values():
        if isinstance(item.detail, Posterior):
            yield "posterior.nc", item.detail.write
            yield "posterior.svg", item.detail.plot(item.model.convention).save
    models = {found.BEFORE: found.model, **{name: x.model for name, x in found.found.items()}}
    sailed = PredictedWindow.of(
        models,
        work.references,
        window=found.window,
        extrapolate=extrapolate,
        currents=found.currents,
    )
    yield "prediction.svg", window_figure(sailed).save


def _content(work: _Work) -> dict[str, Any]:
    from pmmkit.identification import Posterior

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
        "units": dict(found.UNITS),
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
        "errors_before": predictions.get(found.BEFORE, {}),
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
