"""Compare a model, or what was submitted, with tests: errors against their uncertainty."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from pmmkit.actions.outcome import Outcome, figure_files, marked, results_folder, warned, written
from pmmkit.actions.records import sound_campaign
from pmmkit.actions.sea import WaveSettings, carried, new_notes
from pmmkit.actions.setting import SettingError, patterns, setting, settings, stem
from pmmkit.actions.shared import Data, Figures, Out
from pmmkit.base import TableError

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign
    from pmmkit.intake import CheckFinding
    from pmmkit.models import DerivativeTable
    from pmmkit.validation import Comparison


# What is compared with tests and is no model: the campaign or the table of somebody else.


def submitted(what: str, data: Path | None) -> Campaign | DerivativeTable | None:
    """A campaign or a derivative table by its path; None where a model is meant."""
    from pmmkit.campaigns import Campaign
    from pmmkit.exports import read_subject
    from pmmkit.files import Url
    from pmmkit.models import DerivativeTable, ships

    here = Url.of(what) is None
    if what in ships() or (here and not Path(what).expanduser().exists()):
        return None
    found = read_subject(what, data=data)
    return found if isinstance(found, Campaign | DerivativeTable) else None


def compare_tables(
    table: DerivativeTable, measured: Path, folder: Path, names: tuple[str, str], *, drawn: bool
) -> Outcome:
    """A derivative table beside another: differences with their uncertainty, bars side by side."""
    from pmmkit.exports import read_subject
    from pmmkit.models import DerivativeTable, compare

    reference = read_subject(measured)
    if not isinstance(reference, DerivativeTable):
        raise SettingError(f"A table is compared with a table, and {measured} is none.")
    beside = compare(table, reference)
    try:
        worst = [f"Farthest apart: {worst_deviation(table, reference)[1]}."]
    except ValueError:
        worst = []
    inside = int(beside["inside"].sum())
    known = int(beside["std"].notna().sum())
    lines = [
        f"{names[0]} beside {names[1]}: {len(beside)} derivatives; {inside} of {known} 95 % "
        "intervals hold the value compared with.",
        *worst,
        "",
    ]
    results = _table_files(beside, table, reference, names, drawn)
    return written(folder, results, {"derivatives": beside.to_dict("records")}, lines)


def _table_files(
    beside: Any,
    table: DerivativeTable,
    reference: DerivativeTable,
    names: tuple[str, str],
    drawn: bool,
) -> Iterator[tuple[str, Any]]:
    from pmmkit.views import beside_reference, derivative_bars

    yield "derivatives_beside.csv", beside
    if drawn:
        figures = {
            "derivative_bars": derivative_bars({names[1]: reference, names[0]: table}),
            "derivatives_beside": beside_reference(table, reference, reference_name=names[1]),
        }
        yield from figure_files(figures, "png")


def worst_deviation(
    table: DerivativeTable,
    reference: DerivativeTable | Mapping[str, float | Sequence[float]],
    *,
    names: Sequence[str] | None = None,
) -> tuple[float, str]:
    """How far the value is from its reference that is farthest, in standard uncertainties.

    With its sign, and in words. Values whose uncertainty is not known do not count.

    Examples
    --------
    >>> from pmmkit.conventions import Ship, Water
    >>> from pmmkit.models import from_values
    >>> ship = Ship(name="m", L=4.0, B=1.0, d=.25, volume=.5, mass=500., Izz=500.)
    >>> table = from_values({"Yv": -.0118}, std={"Yv": .0001}, ship=ship, water=Water())
    >>> print(worst_deviation(table, {"Yv": -.0116})[1])
    Yv: -2.00 standard deviations, the largest of 1
    """
    from pmmkit.models import compare

    frame = compare(table, reference, names=names)
    frame = frame[frame["difference_std"].notna()]
    if frame.empty:
        raise TableError("No value has an uncertainty and a reference to compare it with.")
    row = frame.iloc[int(frame["difference_std"].abs().to_numpy().argmax())]
    place = "" if math.isnan(row["Fn"]) else f" at Fn {row['Fn']:.4g}"
    far = float(row["difference_std"])
    return far, (
        f"{row['derivative']}{place}: {far:+.2f} standard deviations, the largest of {len(frame)}"
    )


STAGE: Final = ("explain", 1)
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
    rough, of_sea = known, tuple[str, ...]()
    if job.waves.sea is not None:
        if opened.kind != "free-running":
            raise SettingError("A tank is calm while a model is towed: leave the waves out.")
        tested, _ = as_tested(known, opened)
        pace = float(median([run.settings.speed for run in opened]))
        rough, _, of_sea = carried(tested, job.waves, job.model, pace)
    with shown() as progress:
        found = compare_comparison(
            rough,
            opened,
            floor=job.floor,
            window=job.window,
            extrapolate=job.extrapolate,
            progress=progress,
        )
    return marked(
        _written(found, findings, folder, job.figures, new_notes(rough, of_sea, known)), known
    )


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
