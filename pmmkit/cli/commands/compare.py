"""``pmmkit compare``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from pmmkit.cli.options import Campaign, Data, Figures, Model, patterns, sound_campaign, stem
from pmmkit.cli.output import Outcome, warned
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

if TYPE_CHECKING:
    from pmmkit.validation.comparison import Comparison


EXAMPLE: Final = "pmmkit compare model.toml my-campaign"


def compare(
    model: Model,
    campaign: Campaign,
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
    """Compare a model with tests: errors against their uncertainty, and where it fails."""
    from statistics import median

    from pmmkit.files import write_results
    from pmmkit.identification.chosen import matching
    from pmmkit.models import load_model
    from pmmkit.progress import shown
    from pmmkit.report import write_comparison
    from pmmkit.validation import comparison
    from pmmkit.validation.free_running import as_tested

    folder = results_folder(out, f"{stem(campaign)}-compared")
    known = load_model(model)
    opened, findings = sound_campaign(campaign, data)
    if runs:
        opened = opened.with_(runs=tuple(matching(opened, patterns(runs) or ())))
    rough = Carried(model=known)
    if (sea := stated_sea(wave_height, wave_period)) is not None:
        if opened.kind != "free-running":
            raise typer.BadParameter("A tank is calm while a model is towed: leave the waves out.")
        tested, _ = as_tested(known, opened)
        pace = float(median([run.settings.speed for run in opened]))
        rough = carried(tested, sea, model, pace, waves_from_deg, wave_speeds)
    with shown() as progress:
        found = comparison.compare(
            rough.model,
            opened,
            floor=floor,
            window=window,
            extrapolate=extrapolate,
            progress=progress,
        )
    content = {**found.to_dict(), "findings": [item.to_dict() for item in findings]}
    page = partial(write_comparison, found, findings=findings)
    files = write_results(folder, (*_files(found, content, figures), ("report.html", page)))
    ends = [f"Results: {folder}", f"Report:  {folder / 'report.html'}"]
    lines = [str(found), *warned(findings), *new_notes(rough, known), "", *ends]
    return Outcome(content={"out": str(folder), "files": files, **content}, lines=lines)


def _files(found: Comparison, content: Mapping[str, Any], drawn: bool) -> Iterator[tuple[str, Any]]:
    from pmmkit.figures.comparison import comparison_figures
    from pmmkit.plotting.style import figure_files

    yield "comparison.csv", found.to_pandas()
    yield "misfit.csv", found.misfit()
    if found.captive:
        yield "harmonics.csv", found.harmonics()
    if found.manoeuvres:
        yield "manoeuvres.csv", found.metrics()
    yield "comparison.json", content
    if drawn:
        yield from figure_files(comparison_figures(found), "png")
