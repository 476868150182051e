"""The work behind ``pmmkit compare``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from pmmkit.campaigns.file.campaign_file import open_campaign
from pmmkit.checks import examine, refuse
from pmmkit.cli.console import Outcome, json_text
from pmmkit.cli.findings import findings_of
from pmmkit.cli.tracks import check_folder
from pmmkit.files import atomic_folder
from pmmkit.models import load_model
from pmmkit.numerics import rms
from pmmkit.presentation import aligned
from pmmkit.progress import shown
from pmmkit.validation.comparison import TOLD, Comparison, compare
from pmmkit.validation.misfit import words_of_test
from pmmkit.validation.uncertainty import COVERAGE

if TYPE_CHECKING:
    import pandas as pd

MOST: Final = 12
"""Sentences on the screen; all of them are in the files."""


def compare_with(
    model: str,
    campaign: Path,
    out: Path,
    *,
    floor: float,
    window: float | None = None,
    extrapolate: bool = False,
    drawn: bool = True,
    data: Path | None = None,
) -> Outcome:
    """Compare a model with the tests of a campaign, and write everything.

    Parameters
    ----------
    model : str
        Library ship or model file.
    campaign, data : Path
        As for `open_campaign`.
    out : Path
        Folder of the results.
    floor, window, extrapolate
        As for `compare`.
    drawn : bool
        Whether to draw figures.

    Returns
    -------
    Outcome
        With a row per run and channel, the map of misfit and the sentences.
    """
    check_folder(out)
    known = load_model(model)
    opened = open_campaign(campaign, data=data)
    findings = examine(opened)
    refuse(findings)
    with shown() as progress:
        found = compare(
            known, opened, floor=floor, window=window, extrapolate=extrapolate, progress=progress
        )
    content = {**_content(found), "findings": findings_of(findings)}
    files = _write(found, out, content, drawn=drawn)
    warned = [f"{item['severity']}: {item['message']}" for item in content["findings"]]
    lines = [*_words(found), *dict.fromkeys(warned), "", f"Results: {out}"]
    return Outcome(content={"out": str(out), "files": files, **content}, lines=lines)


def _content(found: Comparison) -> dict[str, Any]:
    return {
        "campaign": found.campaign,
        "model": found.model,
        "kind": found.kind,
        "floor": found.floor,
        "coverage_factor": COVERAGE,
        "runs": found.rows(),
        "misfit": found.misfit().to_dict("records"),
        "standouts": [{"text": str(item), **asdict(item)} for item in found.outstanding()]
        if found.captive
        else [{"text": text} for text in found.standouts()],
        "manoeuvres": [row for item in found.manoeuvres for row in item.rows()],
        "notes": list(found.notes),
    }


def _write(found: Comparison, out: Path, content: Mapping[str, Any], *, drawn: bool) -> list[str]:
    """All files of the results, or none."""
    with atomic_folder(out) as folder:
        found.to_pandas().to_csv(folder / "comparison.csv", index=False)
        found.misfit().to_csv(folder / "misfit.csv", index=False)
        if found.captive:
            found.harmonics().to_csv(folder / "harmonics.csv", index=False)
        if found.manoeuvres:
            found.metrics().to_csv(folder / "manoeuvres.csv", index=False)
        (folder / "comparison.json").write_text(json_text(content) + "\n", encoding="utf-8")
        if drawn:
            from pmmkit.figures import comparison as figures
            from pmmkit.plotting.style import save

            for name, figure in figures.comparison_figures(found).items():
                save(figure, folder / f"{name}.png")
        return sorted(file.name for file in folder.iterdir())


def _words(found: Comparison) -> list[str]:
    """What the command prints."""
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
    rows = []
    for key, group in table.groupby(["channel", "unit", "test"], sort=False):
        channel, unit, test = map(str, key)
        error, measured, doubt = (
            rms(group[name].to_list()) for name in ("error", "measured", "uncertainty")
        )
        rows.append(
            [
                f"{channel} [{unit}], {words_of_test(test)}",
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
