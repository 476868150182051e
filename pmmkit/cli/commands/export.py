"""``pmmkit export``."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Final

import typer

from pmmkit.cli.options import Data, stem
from pmmkit.cli.output import Outcome
from pmmkit.cli.outputs import results_file
from pmmkit.cli.speeds import WAYS, TypedSpeed, typed

EXAMPLE: Final = "pmmkit export kvlcc2 --to mss --speed 8"


class Format(StrEnum):
    """What other programs read."""

    mss = "mss"
    shipmmg = "shipmmg"
    csv = "csv"
    excel = "excel"
    latex = "latex"
    netcdf = "netcdf"


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
        TypedSpeed | None,
        typer.Option(
            parser=typed,
            metavar="SPEED",
            help=f"For models whose values depend on it, at the model's own scale: {WAYS}.",
        ),
    ] = None,
    data: Data = None,
) -> Outcome:
    """Write a model, table, campaign or track for MATLAB, shipmmg, Excel, LaTeX and others."""
    from pmmkit import exports
    from pmmkit.exports.subject import read_subject
    from pmmkit.exports.write import file_name
    from pmmkit.models import Model

    default: str | Path = ""
    if output is None:
        if to is None:
            raise typer.BadParameter(
                "Say what to write: --to mss, or -o with an ending such as .m."
            )
        default = file_name(read_subject(what, data=data), stem(what), to.value)
    target = results_file(output, default)
    pace = None
    if speed is not None:
        subject = read_subject(what, data=data)
        known = isinstance(subject, Model)
        pace = speed.of(subject.ship, subject.water) if known else speed.without_ship()
    files = exports.export(what, target, to.value if to else None, speed=pace, data=data)
    return Outcome(
        content={"files": [str(file) for file in files]},
        lines=[f"{target}: {len(files)} files." if target.is_dir() else f"Written: {target}"],
    )
