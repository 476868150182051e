"""Compare a model, or what was submitted, with tests: errors against their uncertainty."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from pmmkit.actions.outcome import Outcome, marked, warned, written
from pmmkit.actions.places import figure_files, results_folder
from pmmkit.actions.sea import Carried, WaveSettings, carried, new_notes
from pmmkit.actions.setting import SettingError, setting, settings
from pmmkit.actions.shared import Data, Figures, Out
from pmmkit.actions.sound import sound_campaign
from pmmkit.actions.submissions import compare_tables, submitted
from pmmkit.actions.text import patterns, stem

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign
    from pmmkit.intake import CheckFinding
    from pmmkit.validation import Comparison


EXAMPLE: Final = "pmmkit compare model.toml my-campaign"


@settings
class CompareSettings:
    """What is asked."""

    model: str = setting(
        "Library ship, model file, or what was submitted: a campaign or SIMMAN archive, a "
        "derivative table.",
        argument=True,
    )
    campaign: Path = setting(
        "The tests: folder with campaign.toml, such a file, .h5 or .zip, or its URL; a "
        "derivative table where one was submitted.",
        argument=True,
    )
    floor: float = setting(
        "Share of a channel's rms force that counts as uncertain whatever else is known.",
        default=0.005,
        least=0.0,
        most=0.5,
    )
    window: float | None = setting(
        "Free-running records: length in s of the windows that are predicted; 15 ship "
        "lengths if absent.",
        default=None,
        least=0.1,
    )
    runs: tuple[str, ...] = setting(
        "Runs to compare with, such as 'turn_*'; may be repeated; all if absent.", default=()
    )
    waves: WaveSettings = WaveSettings()
    extrapolate: bool = setting("Allow speeds outside the model's range.", default=False)
    figures: Figures = True
    data: Data = None
    out: Out = None


def compare(job: CompareSettings) -> Outcome:
    """Do what is asked."""
    from statistics import median

    from pmmkit.base import shown
    from pmmkit.campaigns import Campaign
    from pmmkit.models import load_model
    from pmmkit.validation import as_tested, compare_submission
    from pmmkit.validation import compare as compare_comparison

    folder = results_folder(job.out, f"{stem(job.campaign)}-compared")
    other = submitted(job.model, job.data)
    if other is not None and (job.window or job.waves.wave_height or job.extrapolate):
        raise SettingError("Windows, waves and extrapolation are for models alone.")
    if isinstance(other, Campaign):
        opened, findings = _chosen(job.campaign, job.data, job.runs)
        return _written(
            compare_submission(other, opened, floor=job.floor), findings, folder, job.figures
        )
    if other is not None:
        names = (stem(job.model), stem(job.campaign))
        return compare_tables(other, job.campaign, folder, names, drawn=job.figures)
    known = load_model(job.model)
    opened, findings = _chosen(job.campaign, job.data, job.runs)
    rough = Carried(model=known)
    if job.waves.sea is not None:
        if opened.kind != "free-running":
            raise SettingError("A tank is calm while a model is towed: leave the waves out.")
        tested, _ = as_tested(known, opened)
        pace = float(median([run.settings.speed for run in opened]))
        rough = carried(tested, job.waves, job.model, pace)
    with shown() as progress:
        found = compare_comparison(
            rough.model,
            opened,
            floor=job.floor,
            window=job.window,
            extrapolate=job.extrapolate,
            progress=progress,
        )
    return marked(_written(found, findings, folder, job.figures, new_notes(rough, known)), known)


def _chosen(
    path: Path, data: Path | None, runs: Sequence[str]
) -> tuple[Campaign, tuple[CheckFinding, ...]]:
    """The tests, those that are wanted, and what the checks say of them."""
    opened, findings = sound_campaign(path, data)
    if runs:
        opened = opened.with_(runs=tuple(opened.matching(patterns(runs) or ())))
    return opened, findings


def _written(
    found: Comparison,
    findings: Sequence[CheckFinding],
    folder: Path,
    drawn: bool,
    notes: Sequence[str] = (),
) -> Outcome:
    """The results of a comparison in their folder."""
    from pmmkit.views import write_report

    content = {**found.to_dict(), "findings": [item.to_dict() for item in findings]}
    # A page is a map of runs: manoeuvres of a submission are told by their measures alone.
    page = [("report.html", partial(write_report, found, findings=findings))]
    if not (found.captive or found.free):
        page = []
    results = (*_files(found, content, drawn), *page)
    lines = [str(found), *warned(findings), *notes, ""]
    told = (f"Report:  {folder / name}" for name, _ in page)
    return written(folder, results, content, lines).then(*told)


def _files(found: Comparison, content: Mapping[str, Any], drawn: bool) -> Iterator[tuple[str, Any]]:
    from pmmkit.validation import errors_in_percent, measures_in_percent
    from pmmkit.views import comparison_figures

    if found.captive or found.free:
        yield "comparison.csv", found.to_pandas()
        yield "misfit.csv", found.misfit()
    if found.captive:
        yield "harmonics.csv", found.harmonics()
        yield "percent.csv", errors_in_percent(found.captive)
    if found.manoeuvres:
        yield "manoeuvres.csv", found.metrics()
        if not found.free:
            yield "percent.csv", measures_in_percent(found.manoeuvres)
    yield "comparison.json", content
    if drawn:
        yield from figure_files(comparison_figures(found), "png")
