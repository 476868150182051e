"""Propose the run or manoeuvre to make next, or a whole programme, before any test is made as well.

With --to the captive runs are written for those who make them: settings of carriage and mechanism,
or tables that move the mesh of a solver, with a campaign file that reads what comes back.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal

from pmmkit.actions.outcome import Outcome, marked, results_folder, say, written
from pmmkit.actions.records import RecordSettings
from pmmkit.actions.setting import present, setting, settings, stated, stem, words
from pmmkit.actions.shared import Data, Given, Out
from pmmkit.actions.speeds import TypedSpeed, typed_list
from pmmkit.base import DataError
from pmmkit.presentation import aligned, counted, quoted

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign
    from pmmkit.diagnosis import Advice, Limits, Option, TestPlan


STAGE: Final = ("explain", 4)
EXAMPLE: Final = "pmmkit plan cubic my-campaign"

Maker = Literal["csv", "openfoam", "starccm"]
"""Who makes the runs: a carriage, by a table, or a solver."""


NO_REFERENCE: Final = {
    "csv": "No run is repeated as a reference through the day.",
    **dict.fromkeys(
        ("openfoam", "starccm"), "No reference run: a solver gives the same on any day."
    ),
}
"""What is said where no run shows what the day does."""


@settings
class ProgrammeSettings:
    """A programme."""

    runs: int | None = setting("A programme of so many runs.", default=None)
    hours: float | None = setting("A programme of so many hours.", default=None)
    speeds: str | None = setting(
        "Speeds of the model in the tank, such as 1.0,1.5 [m/s] or 'Fn 0.1,0.2'.", default=None
    )


@settings
class PlannedNoiseSettings:
    """What is uncertain in any case."""

    noise: float | None = setting(
        "Uncertainty of means and harmonics over the rms force, of tests that state none.",
        default=None,
    )
    record_noise: float = setting(
        "Before any test: noise of a record over the rms force.", default=0.015
    )
    floor: float | None = setting(
        "What is too small to matter, over the rms force; 0.005 if absent, of "
        "free-running records 0.001.",
        default=None,
    )


@settings
class SailedSettings:
    """Free-running records."""

    records: tuple[str, ...] = setting(
        "Free-running runs that count, such as 'turn_*'; may be repeated.", default=()
    )
    channels: str | None = setting(
        "Channels of free-running records, as for diagnose.", default=None
    )
    sensors: str | None = setting(
        "Standard deviations of these channels, as for diagnose.", default=None
    )
    windage: str | None = setting(
        "Areas above water of a ship that sails, as for diagnose.", default=None
    )
    spread: float | None = setting(
        "How far values of the model may be off, as for diagnose.", default=None, least=0.0
    )

    @property
    def records_asked(self) -> RecordSettings:
        """The same as other jobs ask it."""
        return RecordSettings(
            runs=self.records,
            channels=self.channels,
            sensors=self.sensors,
            windage=self.windage,
            spread=self.spread,
        )


@settings
class PlanSettings:
    """What is asked."""

    model: str = setting(
        "Model file, library ship, or a structure such as cubic; a model with values "
        "before any test.",
        argument=True,
    )
    campaign: Path | None = setting(
        "Tests that are made; one without runs gives ship and water.", default=None, argument=True
    )
    effects: str | None = setting(
        "Effects to tell apart, or one to show, such as memory,current.",
        default=None,
        names="--for",
    )
    programme: ProgrammeSettings = ProgrammeSettings()
    limits: Path | None = setting(
        "TOML file with [limits] of tank and rig, or [[runs]] to choose from.", default=None
    )
    uncertainty: PlannedNoiseSettings = PlannedNoiseSettings()
    given: Given = ()
    sailed: SailedSettings = SailedSettings()
    to: Maker | None = setting(
        "Write the runs for those who make them: a table for the carriage, or cases of a solver.",
        default=None,
    )
    references: bool = setting(
        "With --to csv: make a reference run of each set-up at the begin, in the middle and at the "
        "end of each day.",
        default=True,
    )
    before: bool = setting("As if no test of the campaign were made.", default=False)
    data: Data = None
    out: Out = None


def plan(job: PlanSettings) -> Outcome:
    """Do what is asked."""
    from pmmkit.diagnosis import next_runs
    from pmmkit.diagnosis import plan as plan_programme

    listed = None if job.programme.speeds is None else typed_list(job.programme.speeds)
    if job.to is not None and job.out is not None:
        from pmmkit.exports import refuse_taken

        refuse_taken(job.out)
    folder = results_folder(
        job.out, f"{stem(job.model if job.campaign is None else job.campaign)}-plan"
    )
    opened = None if job.campaign is None else _opened(job.campaign, job.data, job.before)
    if opened is not None and opened.kind == "free-running":
        _refuse_captive(job)
        advice = _next_manoeuvre(job, opened, listed)
        return marked(_written(advice, _advice_lines(advice), folder, ()), job.model)
    if stated(job.sailed):
        raise DataError("Options of free-running records are of no use for captive tests.")
    allowed, options = _limits(opened, job.model, job.limits, listed)
    asked: dict[str, Any] = {
        "effects": tuple(words(job.effects)),
        "limits": allowed,
        "options": options,
        **present(floor=job.uncertainty.floor),
        "given": words(job.given),
        "noise": job.uncertainty.noise,
    }
    if opened is not None and opened.runs and not {"runs", "hours"} & set(stated(job.programme)):
        advice = next_runs(job.model, opened, **asked)
        return _captive(job, advice, _advice_lines(advice), folder, opened)
    made = plan_programme(
        job.model,
        opened,
        runs=job.programme.runs,
        hours=job.programme.hours,
        record_noise=job.uncertainty.record_noise,
        **asked,
    )
    return _captive(job, made, _plan_lines(made), folder, opened)


def _captive(
    job: PlanSettings,
    found: Advice | TestPlan,
    lines: Sequence[str],
    folder: Path,
    campaign: Campaign | None,
) -> Outcome:
    """Captive runs, written for those who make them where that is asked."""
    if job.to is None:
        return marked(_written(found, lines, folder, ()), job.model)
    from pmmkit.diagnosis import Programme
    from pmmkit.exports import programme_files
    from pmmkit.models import load_model

    options, known = found.options, load_model(job.model) if campaign is None else campaign
    if job.to == "csv":
        programme = Programme.of(options, draw=True, references=job.references)
        whom = "The carriage makes"
    else:
        # The runs that tell most are computed first: no day goes by that could look like a setting.
        # And a solver gives the same twice.
        programme, whom = Programme.of([*dict.fromkeys(options)]), f"For {job.to}"
    files = programme_files(programme, known, job.to)
    then = f"Then: pmmkit reduce {quoted(folder)}"
    if campaign is not None and campaign.runs:
        then = f"{then}, or put [[runs]] of its campaign.toml into that of the tests before."
    references = " ".join(programme.reference_lines)
    said = f"{whom} {counted(len(programme.runs), 'run')}: how_to.txt and programme.csv. {then}"
    said = f"{said}\n{references or NO_REFERENCE[job.to]}"
    return marked(_written(found, [*lines, said], folder, files), job.model)


def _refuse_captive(job: PlanSettings) -> None:
    """What the planning of captive tests alone takes."""
    captive = ("runs", "hours", "noise", "given", "before", "to", "references")
    given = [f"--{name}" for name in captive if name in stated(job)]
    if given:
        raise DataError(
            f"Of free-running records plan names the manoeuvre to make next. Leave out "
            f"{' and '.join(given)}: for captive tests."
        )


def _next_manoeuvre(
    job: PlanSettings, campaign: Campaign, speeds: Sequence[TypedSpeed] | None
) -> Advice:
    from pmmkit.diagnosis import Limits, complete_model, next_runs, read_plan_file

    loaded, asked = complete_model(job.model), job.sailed.records_asked
    used, _ = asked.chosen(campaign, loaded)
    limits, options = Limits.of_records(loaded, used.records), None
    if job.limits is not None:
        limits, options = read_plan_file(job.limits, campaign.ship, limits)
    if speeds is not None:
        limits = limits.with_(speeds=tuple(x.of(campaign.ship, campaign.water) for x in speeds))
    return next_runs(
        loaded,
        used.records,
        effects=tuple(words(job.effects)),
        limits=limits,
        options=options,
        progress=say,
        **present(floor=job.uncertainty.floor, **asked.system()),
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
    from pmmkit.diagnosis import Limits, read_plan_file
    from pmmkit.models import load_model

    found = Limits.of(campaign) if campaign is not None and campaign.runs else None
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


def _written(
    found: Advice | TestPlan, lines: Sequence[str], folder: Path, more: Iterable[tuple[str, Any]]
) -> Outcome:
    results = [("plan.csv", found.to_pandas()), ("plan.toml", found.entries), *more]
    return written(folder, results, found.to_dict(), lines)


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
        *(["What these runs cannot tell:"] if made.untold else []),
        *(f"  {item}" for item in made.untold),
    ]
