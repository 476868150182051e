"""``pmmkit plan``."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from pmmkit.base import DataError
from pmmkit.cli.options import Data, Given, stated, stem, words
from pmmkit.cli.output import Outcome, marked, say
from pmmkit.cli.outputs import Out, results_folder
from pmmkit.cli.records import RecordOptions
from pmmkit.cli.speeds import TypedSpeed, typed_list
from pmmkit.presentation import aligned

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign
    from pmmkit.diagnosis import Advice, Limits, Option, TestPlan


EXAMPLE: Final = "pmmkit plan cubic my-campaign"


def plan(
    model: Annotated[
        str,
        typer.Argument(
            help="Model file, library ship, or a structure such as cubic; a model with values "
            "before any test."
        ),
    ],
    campaign: Annotated[
        Path | None,
        typer.Argument(help="Tests that are made; one without runs gives ship and water."),
    ] = None,
    effects: Annotated[
        str | None,
        typer.Option(
            "--for", help="Effects to tell apart, or one to show, such as memory,current."
        ),
    ] = None,
    runs: Annotated[int | None, typer.Option(help="A programme of so many runs.")] = None,
    hours: Annotated[float | None, typer.Option(help="A programme of so many hours.")] = None,
    speeds: Annotated[
        str | None,
        typer.Option(
            help="Speeds of the model in the tank, such as 1.0,1.5 [m/s] or 'Fn 0.1,0.2'."
        ),
    ] = None,
    limits: Annotated[
        Path | None,
        typer.Option(help="TOML file with [limits] of tank and rig, or [[runs]] to choose from."),
    ] = None,
    noise: Annotated[
        float | None,
        typer.Option(
            help="Uncertainty of means and harmonics over the rms force, of tests that state none."
        ),
    ] = None,
    record_noise: Annotated[
        float, typer.Option(help="Before any test: noise of a record over the rms force.")
    ] = 0.015,
    floor: Annotated[
        float | None,
        typer.Option(
            help="What is too small to matter, over the rms force; 0.005 if absent, of "
            "free-running records 0.001."
        ),
    ] = None,
    given: Given = None,
    records: Annotated[
        list[str] | None,
        typer.Option(help="Free-running runs that count, such as 'turn_*'; may be repeated."),
    ] = None,
    channels: Annotated[
        str | None, typer.Option(help="Channels of free-running records, as for diagnose.")
    ] = None,
    sensors: Annotated[
        str | None, typer.Option(help="Standard deviations of these channels, as for diagnose.")
    ] = None,
    windage: Annotated[
        str | None, typer.Option(help="Areas above water of a ship that sails, as for diagnose.")
    ] = None,
    spread: Annotated[
        float | None,
        typer.Option(min=0.0, help="How far values of the model may be off, as for diagnose."),
    ] = None,
    before: Annotated[
        bool, typer.Option("--before", help="As if no test of the campaign were made.")
    ] = False,
    data: Data = None,
    out: Out = None,
) -> Outcome:
    """The run or manoeuvre to make next, or a whole programme, before any test is made as well."""
    from pmmkit.diagnosis import next_runs
    from pmmkit.diagnosis import plan as plan_programme

    listed = None if speeds is None else typed_list(speeds)
    folder = results_folder(out, f"{stem(model if campaign is None else campaign)}-plan")
    opened = None if campaign is None else _opened(campaign, data, before)
    of_records = RecordOptions(
        runs=records, channels=channels, sensors=sensors, windage=windage, spread=spread
    )
    if opened is not None and opened.kind == "free-running":
        _refuse_captive(
            runs=runs, hours=hours, noise=noise, given=words(given) or None, before=before or None
        )
        advice = _next_manoeuvre(
            model,
            opened,
            file=limits,
            speeds=listed,
            effects=words(effects),
            floor=floor,
            asked=of_records,
        )
        return marked(_written(advice, _advice_lines(advice), folder), model)
    if of_records.typed():
        raise DataError("Options of free-running records are of no use for captive tests.")
    allowed, options = _limits(opened, model, limits, listed)
    asked: dict[str, Any] = {
        "effects": tuple(words(effects)),
        "limits": allowed,
        "options": options,
        **stated(floor=floor),
        "given": words(given),
        "noise": noise,
    }
    if opened is not None and opened.runs and runs is None and hours is None:
        advice = next_runs(model, opened, **asked)
        return marked(_written(advice, _advice_lines(advice), folder), model)
    made = plan_programme(model, opened, runs=runs, hours=hours, record_noise=record_noise, **asked)
    return marked(_written(made, _plan_lines(made), folder), model)


def _refuse_captive(**captive: object) -> None:
    """What the planning of captive tests alone takes."""
    given = [f"--{name}" for name in stated(**captive)]
    if given:
        raise DataError(
            f"Of free-running records plan names the manoeuvre to make next. Leave out "
            f"{' and '.join(given)}: for captive tests."
        )


def _next_manoeuvre(
    model: str,
    campaign: Campaign,
    *,
    file: Path | None,
    speeds: Sequence[TypedSpeed] | None,
    effects: Sequence[str],
    floor: float | None,
    asked: RecordOptions,
) -> Advice:
    from pmmkit.diagnosis import complete_model, limits_of_records, next_manoeuvres, read_plan_file

    loaded = complete_model(model)
    used, _ = asked.chosen(campaign, loaded)
    limits, options = limits_of_records(loaded, used.records), None
    if file is not None:
        limits, options = read_plan_file(file, campaign.ship, limits)
    if speeds is not None:
        limits = limits.with_(speeds=tuple(x.of(campaign.ship, campaign.water) for x in speeds))
    return next_manoeuvres(
        loaded,
        used.records,
        effects=tuple(effects),
        limits=limits,
        options=options,
        progress=say,
        **stated(floor=floor, **asked.system()),
    )


def _opened(campaign: Path, data: Path | None, before: bool) -> Campaign:
    from pmmkit.base import CampaignError
    from pmmkit.campaigns import open_campaign

    if before:
        return open_campaign(campaign, data=data, runs=False)
    try:
        return open_campaign(campaign, data=data)
    except CampaignError as error:
        if all("there are no runs" in item.message for item in error.problems):
            return open_campaign(campaign, data=data, runs=False)
        raise


def _limits(
    campaign: Campaign | None, model: str, file: Path | None, speeds: Sequence[TypedSpeed] | None
) -> tuple[Limits | None, tuple[Option, ...] | None]:
    from pmmkit.diagnosis import Limits, limits_of, read_plan_file
    from pmmkit.models import load_model

    found = limits_of(campaign) if campaign is not None and campaign.runs else None
    tested = load_model(model) if campaign is None and (speeds or file) else campaign
    if speeds is not None and tested is not None:
        pace = tuple(speed.of(tested.ship, tested.water) for speed in speeds)
        found = (found or Limits(speeds=(1.0,))).with_(speeds=pace)
    if file is None:
        if found is None:
            raise DataError("Before any test a plan needs speeds: --speeds 1.0,1.5, or --limits.")
        return found, None
    ship = campaign.ship if campaign is not None else load_model(model).ship
    return read_plan_file(file, ship, found)


def _written(found: Advice | TestPlan, lines: Sequence[str], folder: Path) -> Outcome:
    from pmmkit.diagnosis import entries_text
    from pmmkit.files import write_results

    results = [("plan.csv", found.to_pandas()), ("plan.toml", entries_text(found.options))]
    files = write_results(folder, results)
    return Outcome(
        content={"out": str(folder), "files": files, **found.to_dict()},
        lines=[*lines, f"Results: {folder}"],
    )


def _advice_lines(advice: Advice) -> list[str]:
    lines = [advice.words]
    if advice.runs and advice.rivals:
        lines.append(
            aligned(
                ["run", "repeats", "gain in ln odds", "ln odds then", "resolves", "hours"],
                [
                    [
                        item.option.words,
                        f"{item.repeats}",
                        f"{item.gain:.1f}",
                        f"{item.after:.1f}",
                        f"{100 * item.resolves:.0f} %",
                        f"{item.hours:.2f}",
                    ]
                    for item in advice.runs
                ],
            )
        )
    elif advice.runs:
        lines.append(
            aligned(
                ["run", "shows", "hours"],
                [
                    [item.option.words, " ".join(item.gains), f"{item.hours:.2f}"]
                    for item in advice.runs
                ],
            )
        )
    lines += advice.notes
    if advice.captive is not None:
        lines.append(
            aligned(
                ["captive test", "min", "hours"],
                [
                    [step.option.words, f"{60 * step.option.hours:.0f}", f"{step.hours:.2f}"]
                    for step in advice.captive.steps
                ],
            )
        )
    return lines


def _plan_lines(made: TestPlan) -> list[str]:
    head = (
        f"{made.made} tests are made and show {len(made.before)} of {len(made.sights)} effects. "
        if made.made
        else ""
    )
    last = made.steps[-1] if made.steps else None
    told = (
        f"{len(made.steps)} runs in {made.hours:.1f} h show {last.visible} of {len(made.sights)} "
        f"effects at usual size and tell {100 * last.separated:.0f} % of their pairs apart."
        if last
        else "No further run is worth its time."
    )
    return [
        head + told,
        aligned(
            ["run", "min", "hours", "visible", "apart", "becomes visible"],
            [
                [
                    step.option.words,
                    f"{60 * step.option.hours:.0f}",
                    f"{step.hours:.2f}",
                    f"{step.visible}",
                    f"{100 * step.separated:.0f} %",
                    ", ".join(step.shown),
                ]
                for step in made.steps
            ],
        ),
        "Stays invisible:" if made.invisible else "Nothing stays invisible.",
        *(f"  {item.name}: {item.why}." for item in made.invisible),
    ]
