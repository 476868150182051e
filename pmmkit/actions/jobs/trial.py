"""Measure turning circles, zigzags and stops of a sea trial, beside the limits of the IMO."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from pmmkit.actions.outcome import Outcome, results_folder, warned, written
from pmmkit.actions.records import sound_campaign
from pmmkit.actions.setting import SettingError, numbers, setting, settings, stem
from pmmkit.actions.shared import Campaign, Data, Form, Out
from pmmkit.presentation import Section, counted, text_of

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign as Opened
    from pmmkit.identification import Corrected, LoadingPrediction, Trial


STAGE: Final = ("measure", 6)
EXAMPLE: Final = "pmmkit trial my-zigzags"


@settings
class TrialSettings:
    """What is asked."""

    campaign: Campaign
    run: tuple[str, ...] = setting("Id of a run; may be repeated. All if absent.", default=())
    order: float | None = setting(
        "Instant of the order [s] on the clock of the one --run.", default=None
    )
    current: str | None = setting(
        "A current that is known: north,east [m/s], such as 0.4,-0.1.", default=None
    )
    as_tried: str | None = setting(
        "Model of the ship in the condition of the trial, to correct for the loading, or "
        "a campaign of free-running model tests; with --full-load.",
        default=None,
    )
    full_load: str | None = setting("The same at full load, made by the same method.", default=None)
    form: Form = None
    data: Data = None
    out: Out = None


def trial(job: TrialSettings) -> Outcome:
    """Do what is asked."""
    from pmmkit.conventions import cite
    from pmmkit.identification import evaluate_trials
    from pmmkit.views import form_of_trials, read_stated

    velocity = numbers(job.current)
    if velocity is not None and len(velocity) != 2:
        raise SettingError(f"--current {job.current!r}: write north,east, such as 0.4,-0.1.")
    if job.order is not None and len(job.run) != 1:
        raise SettingError("--order belongs to one run: give one --run with it.")
    if (job.as_tried is None) != (job.full_load is None):
        raise SettingError("--as-tried and --full-load belong together: R = T F/B.")
    folder = results_folder(job.out, f"{stem(job.campaign)}-trial")
    opened, findings = sound_campaign(job.campaign, job.data)
    if job.form is not None:
        opened = replace(opened, imo={**opened.imo, **read_stated(job.form)})
    found = evaluate_trials(
        opened,
        runs=job.run or None,
        order=None if job.order is None else {job.run[0]: job.order},
        current=None if velocity is None else (velocity[0], velocity[1]),
    )
    corrected, notes = _loaded(opened, found, job.as_tried, job.full_load)
    filled = form_of_trials(opened, found, corrected=corrected, notes=notes)
    content = {
        "campaign": opened.title,
        "source": cite("msc137"),
        "findings": [item.to_dict() for item in findings],
        "runs": [item.to_dict() for item in found],
        "full_load": [item.to_dict() for item in corrected],
    }
    lines = [f"{opened.title}: {len(found)} runs, limits of {cite('msc137')}"]
    for item in found:
        lines += ["", str(item)]
    if filled.corrections is not None:
        table = Section(title="Correction to full load", tables=[filled.corrections], points=notes)
        lines += ["", text_of([table])]
    lines += warned(findings)
    missing = counted(len(filled.not_supplied), "field")
    lines += ["", f"Form: {folder / filled.PAGE}, with {missing} not supplied"]
    return written(folder, chain(_files(found, content), filled.files()), content, lines)


def _loaded(
    campaign: Opened, trials: Sequence[Trial], as_tried: str | None, full_load: str | None
) -> tuple[tuple[Corrected, ...], tuple[str, ...]]:
    """The measures at full load, and where the models' draughts are others."""
    if as_tried is None or full_load is None:
        return (), ()
    tried, full = (_prediction(item) for item in (as_tried, full_load))
    return tried.to_full_load(trials, full), tried.notes(
        full,
        L=campaign.ship.L,
        draught=campaign.draught,
        full_draught=campaign.imo.get("full_load_draught"),
    )


def _prediction(source: str) -> LoadingPrediction:
    """A model, or the tests of a campaign."""
    from pmmkit.identification import LoadingPrediction

    path = Path(source)
    if path.is_dir() or path.name == "campaign.toml" or path.suffix in (".h5", ".hdf5"):
        return LoadingPrediction.of(sound_campaign(path, None)[0])
    return LoadingPrediction.of(source)


def _files(found: Sequence[Trial], content: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    import pandas as pd

    yield "trial.csv", pd.DataFrame([row for item in found for row in item.rows()])
    yield "trial.json", content
    for item, name in zip(found, _names(found), strict=True):
        yield f"path_{name}.csv", item.path()
        yield f"trial_{name}.svg", item.plot().save


def _names(found: Sequence[Trial]) -> list[str]:
    """The ids of runs as parts of names of files, each once."""
    names: list[str] = []
    for item in found:
        plain = "".join(
            letter if letter.isalnum() or letter in "-+." else "_" for letter in item.run
        )
        names.append(plain if plain not in names else f"{plain}_{len(names) + 1}")
    return names
