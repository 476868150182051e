"""``pmmkit trial``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from pmmkit.cli.options import Campaign, Data, Form, numbers, sound_campaign, stem
from pmmkit.cli.output import Outcome, warned
from pmmkit.cli.outputs import Out, results_folder
from pmmkit.presentation import Section, counted, text_of

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign as Opened
    from pmmkit.identification import Corrected, LoadingPrediction, Trial


EXAMPLE: Final = "pmmkit trial my-zigzags"


def trial(
    campaign: Campaign,
    run: Annotated[
        list[str] | None, typer.Option(help="Id of a run; may be repeated. All if absent.")
    ] = None,
    order: Annotated[
        float | None, typer.Option(help="Instant of the order [s] on the clock of the one --run.")
    ] = None,
    current: Annotated[
        str | None,
        typer.Option(help="A current that is known: north,east [m/s], such as 0.4,-0.1."),
    ] = None,
    as_tried: Annotated[
        str | None,
        typer.Option(
            help="Model of the ship in the condition of the trial, to correct for the loading, or "
            "a campaign of free-running model tests; with --full-load."
        ),
    ] = None,
    full_load: Annotated[
        str | None, typer.Option(help="The same at full load, made by the same method.")
    ] = None,
    form: Form = None,
    data: Data = None,
    out: Out = None,
) -> Outcome:
    """Measure turning circles, zigzags and stops of a sea trial, beside the limits of the IMO."""
    from pmmkit.files import write_results
    from pmmkit.identification import evaluate_trials
    from pmmkit.simulation import SOURCE
    from pmmkit.views import PAGE, form_files, form_of_trials, read_stated

    velocity = numbers(current)
    if velocity is not None and len(velocity) != 2:
        raise typer.BadParameter(f"--current {current!r}: write north,east, such as 0.4,-0.1.")
    if order is not None and len(run or ()) != 1:
        raise typer.BadParameter("--order belongs to one run: give one --run with it.")
    if (as_tried is None) != (full_load is None):
        raise typer.BadParameter("--as-tried and --full-load belong together: R = T F/B.")
    folder = results_folder(out, f"{stem(campaign)}-trial")
    opened, findings = sound_campaign(campaign, data)
    if form is not None:
        opened = replace(opened, imo={**opened.imo, **read_stated(form)})
    found = evaluate_trials(
        opened,
        runs=run,
        order=None if order is None or run is None else {run[0]: order},
        current=None if velocity is None else (velocity[0], velocity[1]),
    )
    corrected, notes = _loaded(opened, found, as_tried, full_load)
    filled = form_of_trials(opened, found, corrected=corrected, notes=notes)
    content = {
        "campaign": opened.title,
        "source": SOURCE,
        "findings": [item.to_dict() for item in findings],
        "runs": [item.to_dict() for item in found],
        "full_load": [item.to_dict() for item in corrected],
    }
    files = write_results(folder, chain(_files(found, content), form_files(filled)))
    lines = [f"{opened.title}: {len(found)} runs, limits of {SOURCE}"]
    for item in found:
        lines += ["", str(item)]
    if filled.corrections is not None:
        table = Section(title="Correction to full load", tables=[filled.corrections], points=notes)
        lines += ["", text_of([table])]
    lines += warned(findings)
    missing = counted(len(filled.not_supplied), "field")
    lines += ["", f"Form: {folder / PAGE}, with {missing} not supplied"]
    lines.append(f"Results: {folder}")
    return Outcome(content={"out": str(folder), "files": files, **content}, lines=lines)


def _loaded(
    campaign: Opened, trials: Sequence[Trial], as_tried: str | None, full_load: str | None
) -> tuple[tuple[Corrected, ...], tuple[str, ...]]:
    """The measures at full load, and where the models' draughts are others."""
    if as_tried is None or full_load is None:
        return (), ()
    from pmmkit.identification import loading_notes, mean_draught, to_full_load

    tried, full = (_prediction(item) for item in (as_tried, full_load))
    return to_full_load(trials, tried, full), loading_notes(
        tried,
        full,
        L=campaign.ship.L,
        draught=mean_draught(campaign.imo, campaign.ship.d),
        full_draught=campaign.imo.get("full_load_draught"),
    )


def _prediction(source: str) -> LoadingPrediction:
    """A model, or the tests of a campaign."""
    from pmmkit.identification import predicted_by, predicted_by_tests

    path = Path(source)
    if path.is_dir() or path.name == "campaign.toml" or path.suffix in (".h5", ".hdf5"):
        return predicted_by_tests(sound_campaign(path, None)[0])
    return predicted_by(source)


def _files(found: Sequence[Trial], content: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    import pandas as pd

    from pmmkit.plotting import save

    yield "trial.csv", pd.DataFrame([row for item in found for row in item.rows()])
    yield "trial.json", content
    for item, name in zip(found, _names(found), strict=True):
        yield f"path_{name}.csv", item.path()
        yield f"trial_{name}.svg", partial(save, item.plot())


def _names(found: Sequence[Trial]) -> list[str]:
    """The ids of runs as parts of names of files, each once."""
    names: list[str] = []
    for item in found:
        plain = "".join(
            letter if letter.isalnum() or letter in "-+." else "_" for letter in item.run
        )
        names.append(plain if plain not in names else f"{plain}_{len(names) + 1}")
    return names
