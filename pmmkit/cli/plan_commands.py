"""The command about the next run and programmes; what does the work is imported when it runs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pmmkit.cli.options import Data, Json, Out, app, finish, numbers, stem


@app.command()
def plan(
    model: Annotated[
        str,
        typer.Argument(
            help="Model file, library ship, or a structure such as cubic; a model with values "
            "before any test."
        ),
    ],
    campaign: Annotated[
        Path | None,
        typer.Argument(help="Tests that are made; one without runs gives ship and water."),
    ] = None,
    effects: Annotated[
        str | None,
        typer.Option(
            "--for", help="Effects to tell apart, or one to show, such as memory,current."
        ),
    ] = None,
    runs: Annotated[int | None, typer.Option(help="A programme of so many runs.")] = None,
    hours: Annotated[float | None, typer.Option(help="A programme of so many hours.")] = None,
    speeds: Annotated[str | None, typer.Option(help="Speeds in m/s, such as 1.0,1.5.")] = None,
    limits: Annotated[
        Path | None,
        typer.Option(help="TOML file with [limits] of tank and rig, or [[runs]] to choose from."),
    ] = None,
    noise: Annotated[
        float | None,
        typer.Option(
            help="Uncertainty of means and harmonics over the rms force, of tests that state none."
        ),
    ] = None,
    record_noise: Annotated[
        float, typer.Option(help="Before any test: noise of a record over the rms force.")
    ] = 0.015,
    floor: Annotated[
        float, typer.Option(help="What is too small to matter, over the rms force.")
    ] = 0.005,
    given: Annotated[
        str | None,
        typer.Option(help="Effects that are known to be there, such as fault_misalignment,memory."),
    ] = None,
    before: Annotated[
        bool, typer.Option("--before", help="As if no test of the campaign were made.")
    ] = False,
    data: Data = None,
    out: Out = None,
    json: Json = False,
) -> None:
    """The run to make next, or a whole programme, before any test is made as well."""
    from pmmkit.cli import planning

    named = stem(Path(model)) if campaign is None else stem(campaign)
    listed = numbers(speeds)
    result = planning.plan(
        model,
        campaign,
        out or Path(f"{named}-plan"),
        effects=tuple((effects or "").replace(",", " ").split()),
        runs=runs,
        hours=hours,
        speeds=None if listed is None else tuple(listed),
        limits=limits,
        noise=noise,
        record_noise=record_noise,
        floor=floor,
        given=(given or "").replace(",", " ").split(),
        before=before,
        data=data,
    )
    finish(result, json)
