"""``pmmkit compare``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from pmmkit.cli.options import Data, Figures, patterns, sound_campaign, stem
from pmmkit.cli.output import Outcome, marked, warned
from pmmkit.cli.outputs import Out, results_folder
from pmmkit.cli.sea import (
    Carried,
    WaveHeight,
    WavePeriod,
    WaveSpeeds,
    carried,
    new_notes,
    stated_sea,
)
from pmmkit.cli.submissions import compare_tables, submitted

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign
    from pmmkit.intake import CheckFinding
    from pmmkit.validation import Comparison


EXAMPLE: Final = "pmmkit compare model.toml my-campaign"


def compare(
    model: Annotated[
        str,
        typer.Argument(
            help="Library ship, model file, or what was submitted: a campaign or SIMMAN archive, a "
            "derivative table."
        ),
    ],
    campaign: Annotated[
        Path,
        typer.Argument(
            help="The tests: folder with campaign.toml, such a file, .h5 or .zip, or its URL; a "
            "derivative table where one was submitted."
        ),
    ],
    floor: Annotated[
        float,
        typer.Option(
            min=0.0,
            max=0.5,
            help="Share of a channel's rms force that counts as uncertain whatever else is known.",
        ),
    ] = 0.005,
    window: Annotated[
        float | None,
        typer.Option(
            min=0.1,
            help="Free-running records: length in s of the windows that are predicted; 15 ship "
            "lengths if absent.",
        ),
    ] = None,
    runs: Annotated[
        list[str] | None,
        typer.Option(
            help="Runs to compare with, such as 'turn_*'; may be repeated; all if absent."
        ),
    ] = None,
    wave_height: WaveHeight = None,
    wave_period: WavePeriod = None,
    waves_from_deg: Annotated[
        float, typer.Option(help="Where they come from, from where the heading is zero.")
    ] = 0.0,
    wave_speeds: WaveSpeeds = None,
    extrapolate: Annotated[
        bool, typer.Option("--extrapolate", help="Allow speeds outside the model's range.")
    ] = False,
    figures: Figures = True,
    data: Data = None,
    out: Out = None,
) -> Outcome:
    """Compare a model, or what was submitted, with tests: errors against their uncertainty."""
    from statistics import median

    from pmmkit.base import shown
    from pmmkit.campaigns import Campaign
    from pmmkit.models import load_model
    from pmmkit.validation import as_tested, compare_submission
    from pmmkit.validation import compare as compare_comparison

    folder = results_folder(out, f"{stem(campaign)}-compared")
    other = submitted(model, data)
    if other is not None and (window or wave_height or extrapolate):
        raise typer.BadParameter("Windows, waves and extrapolation are for models alone.")
    if isinstance(other, Campaign):
        opened, findings = _chosen(campaign, data, runs)
        return _written(compare_submission(other, opened, floor=floor), findings, folder, figures)
    if other is not None:
        names = (stem(model), stem(campaign))
        return compare_tables(other, campaign, folder, names, drawn=figures)
    known = load_model(model)
    opened, findings = _chosen(campaign, data, runs)
    rough = Carried(model=known)
    if (sea := stated_sea(wave_height, wave_period)) is not None:
        if opened.kind != "free-running":
            raise typer.BadParameter("A tank is calm while a model is towed: leave the waves out.")
        tested, _ = as_tested(known, opened)
        pace = float(median([run.settings.speed for run in opened]))
        rough = carried(tested, sea, model, pace, waves_from_deg, wave_speeds)
    with shown() as progress:
        found = compare_comparison(
            rough.model,
            opened,
            floor=floor,
            window=window,
            extrapolate=extrapolate,
            progress=progress,
        )
    return marked(_written(found, findings, folder, figures, new_notes(rough, known)), known)


def _chosen(
    path: Path, data: Path | None, runs: list[str] | None
) -> tuple[Campaign, tuple[CheckFinding, ...]]:
    """The tests, those that are wanted, and what the checks say of them."""
    from pmmkit.identification import matching

    opened, findings = sound_campaign(path, data)
    if runs:
        opened = opened.with_(runs=tuple(matching(opened, patterns(runs) or ())))
    return opened, findings


def _written(
    found: Comparison,
    findings: Sequence[CheckFinding],
    folder: Path,
    drawn: bool,
    notes: Sequence[str] = (),
) -> Outcome:
    """The results of a comparison in their folder."""
    from pmmkit.files import write_results
    from pmmkit.views import write_comparison

    content = {**found.to_dict(), "findings": [item.to_dict() for item in findings]}
    # A page is a map of runs: manoeuvres of a submission are told by their measures alone.
    page = [("report.html", partial(write_comparison, found, findings=findings))]
    if not (found.captive or found.free):
        page = []
    files = write_results(folder, (*_files(found, content, drawn), *page))
    ends = [f"Results: {folder}", *(f"Report:  {folder / name}" for name, _ in page)]
    lines = [str(found), *warned(findings), *notes, "", *ends]
    return Outcome(content={"out": str(folder), "files": files, **content}, lines=lines)


def _files(found: Comparison, content: Mapping[str, Any], drawn: bool) -> Iterator[tuple[str, Any]]:
    from pmmkit.plotting import figure_files
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
