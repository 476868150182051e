"""``pmmkit compare``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from pmmkit.cli.options import (
    Campaign,
    Data,
    Figures,
    Model,
    Out,
    results_folder,
    sound_campaign,
    stem,
)
from pmmkit.cli.output import Outcome, warned
from pmmkit.presentation import aligned

if TYPE_CHECKING:
    import pandas as pd

    from pmmkit.validation.comparison import Comparison

MOST: Final = 12
"""Sentences on the screen; all of them are in the files."""


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
    extrapolate: Annotated[
        bool, typer.Option("--extrapolate", help="Allow speeds outside the model's range.")
    ] = False,
    figures: Figures = True,
    data: Data = None,
    out: Out = None,
) -> Outcome:
    """Compare a model with tests: errors against their uncertainty, and where it fails."""
    from pmmkit.files import write_results
    from pmmkit.models import load_model
    from pmmkit.progress import shown
    from pmmkit.validation import comparison

    folder = results_folder(out, f"{stem(campaign)}-compared")
    known = load_model(model)
    opened, findings = sound_campaign(campaign, data)
    with shown() as progress:
        found = comparison.compare(
            known, opened, floor=floor, window=window, extrapolate=extrapolate, progress=progress
        )
    content = {**found.to_dict(), "findings": [item.to_dict() for item in findings]}
    files = write_results(folder, _files(found, content, figures))
    lines = [*_words(found), *warned(findings), "", f"Results: {folder}"]
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


def _words(found: Comparison) -> list[str]:
    """What the command prints."""
    from pmmkit.validation.uncertainty import COVERAGE

    lines = [f"{found.campaign}: compared with {found.model}", *found.notes, ""]
    lines.append(
        f"Root mean square errors and expanded validation uncertainty (k = {COVERAGE:g}, floor "
        f"{100 * found.floor:g} % of the channel):"
    )
    lines.append(_table(found.to_pandas()))
    if found.manoeuvres:
        lines += ["", "Manoeuvres, simulated with the ship's own steering:", _measures(found)]
    sentences = found.standouts()
    lines += ["", "What stands out:" if sentences else "Nothing stands out."]
    lines += [f"  {text}" for text in sentences[:MOST]]
    if len(sentences) > MOST:
        lines.append(f"  and {len(sentences) - MOST} more, in comparison.json")
    return lines


def _table(table: pd.DataFrame) -> str:
    """Errors by channel and kind of test."""
    from pmmkit.campaigns.test_kinds.registry import kind_of
    from pmmkit.numerics import rms

    rows = []
    for key, group in table.groupby(["channel", "unit", "test"], sort=False):
        channel, unit, test = map(str, key)
        error, measured, doubt = (
            rms(group[name].to_list()) for name in ("error", "measured", "uncertainty")
        )
        rows.append(
            [
                f"{channel} [{unit}], {kind_of(test).title}",
                str(len(group)),
                f"{error:.3g}",
                f"{100 * error / measured:.1f} %" if measured else "-",
                f"{doubt:.2g}",
                f"{int(group['within'].sum())} of {len(group)}",
            ]
        )
    rows.sort(key=lambda row: row[0].split(",")[0])
    head = ["channel, test", "runs", "error", "over measured", "uncertainty", "within it"]
    return aligned(head, rows)


def _measures(found: Comparison) -> str:
    from pmmkit.validation.comparison import TOLD

    rows = [
        [
            f"{row['run']} {row['measure'].replace('_', ' ')} [{row['unit']}]",
            f"{row['measured']:.3g}",
            f"{row['simulated']:.3g}",
            f"{row['error']:+.2g}",
            f"{row['uncertainty']:.2g}",
        ]
        for item in found.manoeuvres
        for row in item.rows()
        if row["measure"] in TOLD
    ]
    return aligned(["measure", "measured", "simulated", "error", "uncertainty"], rows)
