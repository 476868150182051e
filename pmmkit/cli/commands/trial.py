"""``pmmkit trial``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from pmmkit.cli.options import Campaign, Data, numbers, sound_campaign, stem
from pmmkit.cli.output import Outcome, warned
from pmmkit.cli.outputs import Out, results_folder

if TYPE_CHECKING:
    from pmmkit.trials import Trial


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
    data: Data = None,
    out: Out = None,
) -> Outcome:
    """Measure turning circles, zigzags and stops of a sea trial, beside the limits of the IMO."""
    from pmmkit.files import write_results
    from pmmkit.simulation.imo import SOURCE
    from pmmkit.trials import evaluate_trials

    velocity = numbers(current)
    if velocity is not None and len(velocity) != 2:
        raise typer.BadParameter(f"--current {current!r}: write north,east, such as 0.4,-0.1.")
    if order is not None and len(run or ()) != 1:
        raise typer.BadParameter("--order belongs to one run: give one --run with it.")
    folder = results_folder(out, f"{stem(campaign)}-trial")
    opened, findings = sound_campaign(campaign, data)
    found = evaluate_trials(
        opened,
        runs=run,
        order=None if order is None or run is None else {run[0]: order},
        current=None if velocity is None else (velocity[0], velocity[1]),
    )
    content = {
        "campaign": opened.title,
        "source": SOURCE,
        "findings": [item.to_dict() for item in findings],
        "runs": [item.to_dict() for item in found],
    }
    files = write_results(folder, _files(found, content))
    lines = [f"{opened.title}: {len(found)} runs, limits of {SOURCE}"]
    for item in found:
        lines += ["", str(item)]
    lines += warned(findings)
    lines.append(f"Results: {folder}")
    return Outcome(content={"out": str(folder), "files": files, **content}, lines=lines)


def _files(found: Sequence[Trial], content: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    import pandas as pd

    from pmmkit.plotting.style import save

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
