"""The command about sea trials; what does the work is imported when it runs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pmmkit.cli.options import Campaign, Data, Json, Out, app, finish, numbers, stem


@app.command()
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
    json: Json = False,
) -> None:
    """Measure turning circles, zigzags and stops of a sea trial, beside the limits of the IMO."""
    from pmmkit.cli import trials

    velocity = numbers(current)
    if velocity is not None and len(velocity) != 2:
        raise typer.BadParameter(f"--current {current!r}: write north,east, such as 0.4,-0.1.")
    if order is not None and len(run or ()) != 1:
        raise typer.BadParameter("--order belongs to one run: give one --run with it.")
    result = trials.trial(
        campaign,
        out or Path(f"{stem(campaign)}-trial"),
        runs=run,
        order=None if order is None or run is None else {run[0]: order},
        current=None if velocity is None else (velocity[0], velocity[1]),
        data=data,
    )
    finish(result, json)
