"""The command about comparison; what does the work is imported when it runs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pmmkit.cli.options import Campaign, Data, Json, Model, Out, app, finish, stem


@app.command()
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
    figures: Annotated[
        bool, typer.Option(help="Draw figures, which takes most of the time.")
    ] = True,
    data: Data = None,
    out: Out = None,
    json: Json = False,
) -> None:
    """Compare a model with tests: errors against their uncertainty, and where it fails."""
    from pmmkit.cli import comparing

    finish(
        comparing.compare_with(
            model,
            campaign,
            out or Path(f"{stem(campaign)}-compared"),
            floor=floor,
            window=window,
            extrapolate=extrapolate,
            drawn=figures,
            data=data,
        ),
        json,
    )
