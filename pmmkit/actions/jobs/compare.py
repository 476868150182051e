"""Compare a model, or what was submitted, with tests: errors against their uncertainty."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from pmmkit.actions.outcome import Outcome, figure_files, marked, results_folder, warned, written
from pmmkit.actions.records import sound_campaigns
from pmmkit.actions.sea import WaveSettings, carried, new_notes
from pmmkit.actions.setting import SettingError, patterns, setting, settings, stem
from pmmkit.actions.shared import Data, Figures, Out
from pmmkit.base import TableError

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign
    from pmmkit.intake import CheckFinding
    from pmmkit.models import DerivativeTable, Model
    from pmmkit.validation import Comparison

_Tests = Mapping[str, tuple["Campaign", tuple["CheckFinding", ...]]]
"""Tests by their titles, and what the checks say of them."""

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
    campaigns: tuple[Path, ...] = setting(
        "The tests: folder with campaign.toml, such a file, .h5 or .zip, or its URL; several of "
        "one ship, captive and free running, are told each and together; a derivative table where "
        "one was submitted.",
        argument=True,
        metavar="CAMPAIGN",
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
        "Runs to compare with, of whichever campaign, such as 'turn_*'; may be repeated; all if "
        "absent.",
        default=(),
    )
    waves: WaveSettings = WaveSettings()
    extrapolate: bool = setting("Allow speeds outside the model's range.", default=False)
    figures: Figures = True
    data: Data = None
    out: Out = None


def compare(job: CompareSettings) -> Outcome:
    """Do what is asked."""
    from pmmkit.campaigns import Campaign
    from pmmkit.models import DerivativeTable, load_model
    from pmmkit.validation import compare_submission

    first, *others = job.campaigns
    folder = results_folder(job.out, f"{'-'.join(map(stem, job.campaigns))}-compared")
    other = submitted(job.model, job.data)
    if other is not None and (job.window or job.waves.wave_height or job.extrapolate):
        raise SettingError("Windows, waves and extrapolation are for models alone.")
    if other is not None and others:
        raise SettingError("What was submitted is compared with one campaign.")
    if isinstance(other, DerivativeTable):
        names = (stem(job.model), stem(first))
        return compare_tables(other, first, folder, names, drawn=job.figures)
    base = load_model(job.model) if other is None else other
    like = None if isinstance(base, Campaign) else base
    opened = sound_campaigns(job.campaigns, job.data, like)
    chosen = _chosen({title: one for title, (one, _) in opened.items()}, patterns(job.runs))
    if isinstance(base, Campaign):
        each = {x: compare_submission(base, one, floor=job.floor) for x, one in chosen.items()}
        return _written(job, each, opened, (), folder)
    if job.waves.sea is not None and all(one.kind == "captive" for one in chosen.values()):
        raise SettingError("A tank is calm while a model is towed: leave the waves out.")
    notes = [f"note: no such run in {title}." for title in opened if title not in chosen]
    each = {}
    for title, tests in chosen.items():
        each[title], more = _beside(job, base, tests)
        notes += more
    return marked(_written(job, each, opened, notes, folder), base)


def _chosen(
    campaigns: Mapping[str, Campaign], wanted: Sequence[str] | None
) -> Mapping[str, Campaign]:
    """The campaigns with the runs that are wanted, without those that have none."""
    from pmmkit.campaigns import Campaign

    if not wanted:
        return campaigns
    fit = Campaign.fitting(campaigns, wanted)
    return {x: campaigns[x].with_(runs=tuple(campaigns[x].matching(own))) for x, own in fit.items()}


def _beside(
    job: CompareSettings, known: Model, tests: Campaign
) -> tuple[Comparison, Sequence[str]]:
    """A model beside a campaign, in waves where it runs free; what there is to say of them."""
    from statistics import median

    from pmmkit.base import shown
    from pmmkit.validation import as_tested
    from pmmkit.validation import compare as compare_comparison

    rough, of_sea = known, tuple[str, ...]()
    if job.waves.sea is not None and tests.kind == "free-running":
        tested, _ = as_tested(known, tests)
        pace = float(median([run.settings.speed for run in tests]))
        rough, _, of_sea = carried(tested, job.waves, job.model, pace)
    with shown() as progress:
        found = compare_comparison(
            rough,
            tests,
            floor=job.floor,
            window=job.window,
            extrapolate=job.extrapolate,
            progress=progress,
        )
    return found, new_notes(rough, of_sea, known)


def _written(
    job: CompareSettings,
    each: Mapping[str, Comparison],
    opened: _Tests,
    notes: Sequence[str],
    folder: Path,
) -> Outcome:
    """The results of a comparison, or of those with each campaign and all together."""
    from pmmkit.validation import JointComparison

    checks = {title: opened[title][1] for title in each}
    told = {title: [item.to_dict() for item in own] for title, own in checks.items()}
    warnings = warned(item for own in checks.values() for item in own)
    results: Iterator[tuple[str, Any]]
    if len(job.campaigns) == 1:
        ((title, found),) = each.items()
        content = {**found.to_dict(), "findings": told[title]}
        results, lines = _files(found, checks[title], job.figures), [str(found)]
    else:
        joint = JointComparison(each=each)
        content = {**joint.to_dict(), "findings": told}
        places = dict(zip(opened, job.campaigns, strict=True))
        own = (
            (f"{number}_{stem(places[title])}_{name}", made)
            for number, (title, found) in enumerate(each.items(), 1)
            for name, made in _files(found, checks[title], job.figures)
        )
        results, lines = chain([("joint.csv", joint.joint())], own), [str(joint)]
    every = chain([("comparison.json", content)], results)
    done = written(folder, every, content, [*lines, *warnings, *notes, ""])
    pages = [name for name in done.content["files"] if name.endswith("report.html")]
    return done.then(*(f"Report:  {folder / name}" for name in pages))


def _files(
    found: Comparison, findings: Sequence[CheckFinding], drawn: bool
) -> Iterator[tuple[str, Any]]:
    from pmmkit.validation import errors_in_percent, measures_in_percent
    from pmmkit.views import comparison_figures, write_report

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
    if drawn:
        yield from figure_files(comparison_figures(found), "png")
    # A page is a map of runs: manoeuvres of a submission are told by their measures alone.
    if found.captive or found.free:
        yield "report.html", partial(write_report, found, findings=findings)
