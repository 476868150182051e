"""The command that writes for other programs."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from pmmkit.cli.options import Data, Json, app, finish


class Format(StrEnum):
    """What other programs read."""

    mss = "mss"
    shipmmg = "shipmmg"
    csv = "csv"
    excel = "excel"
    latex = "latex"
    netcdf = "netcdf"


@app.command()
def export(
    what: Annotated[
        str,
        typer.Argument(
            help="Library ship, model file, campaign, derivative table, or track.csv of a "
            "simulation."
        ),
    ],
    to: Annotated[
        Format | None,
        typer.Option(help="What to write; the ending of the output says it if absent."),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="File, or folder for a campaign as csv.")
    ] = None,
    speed: Annotated[
        float | None,
        typer.Option(help="For models whose values depend on it: speed in m/s at their scale."),
    ] = None,
    data: Data = None,
    json: Json = False,
) -> None:
    """Write a model, table, campaign or track for MATLAB, shipmmg, Excel, LaTeX and others."""
    from pmmkit.cli import exporting

    if to is None and output is None:
        raise typer.BadParameter("Say what to write: --to mss, or -o with an ending such as .m.")
    finish(
        exporting.export(
            what, to=None if to is None else to.value, output=output, speed=speed, data=data
        ),
        json,
    )
