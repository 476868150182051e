"""``pmmkit export``."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Final

import typer

from pmmkit.cli.options import Data, stem
from pmmkit.cli.output import Outcome, marked
from pmmkit.cli.outputs import results_file
from pmmkit.cli.speeds import WAYS, TypedSpeed, typed

EXAMPLE: Final = "pmmkit export kvlcc2 --to mss --speed 8"


class Interface(StrEnum):
    """Versions of the Functional Mock-up Interface."""

    three = "3"
    two = "2"


class ExportFormat(StrEnum):
    """What other programs read."""

    mss = "mss"
    shipmmg = "shipmmg"
    fmu = "fmu"
    csv = "csv"
    excel = "excel"
    latex = "latex"
    netcdf = "netcdf"
    simman = "simman"


def export(
    what: Annotated[
        str,
        typer.Argument(
            help="Library ship, model file, campaign, derivative table, or track.csv of a "
            "simulation."
        ),
    ],
    to: Annotated[
        ExportFormat | None,
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
    fmi: Annotated[
        Interface | None,
        typer.Option(help="For fmu: version of the interface; 3 if absent, older programs read 2."),
    ] = None,
    compile: Annotated[
        bool, typer.Option("--compile", help="For fmu: put a library for this machine into it.")
    ] = False,
) -> Outcome:
    """Write a model, table, campaign or track for MATLAB, Simulink, Excel, SIMMAN and others."""
    from pmmkit.exports import ENDINGS, file_name, read_subject
    from pmmkit.exports import export as export_exports
    from pmmkit.models import Model

    default: str | Path = ""
    subject = read_subject(what, data=data)
    if output is None:
        if to is None:
            raise typer.BadParameter(
                "Say what to write: --to mss, or -o with an ending such as .m."
            )
        default = file_name(subject, stem(what), to.value)
    target = results_file(output, default)
    pace = None
    if speed is not None:
        known = isinstance(subject, Model)
        pace = speed.of(subject.ship, subject.water) if known else speed.without_ship()
    files = export_exports(
        what,
        target,
        to.value if to else None,
        speed=pace,
        data=data,
        fmi=None if fmi is None else 2 if fmi is Interface.two else 3,
        compile=compile,
    )
    lines = [f"{target}: {len(files)} files." if target.is_dir() else f"Written: {target}"]
    if target.suffix == ENDINGS[ExportFormat.fmu.value]:
        lines += _of_fmu(what, pace, compile=compile)
    done = Outcome(content={"files": [str(file) for file in files]}, lines=lines)
    return marked(done, subject) if isinstance(subject, Model) else done


def _of_fmu(what: str, speed: float | None, *, compile: bool) -> list[str]:
    """What a user of an FMU asks next: how the ship begins, and whether there is a library."""
    from pmmkit.exports import approach_of
    from pmmkit.models import load_model

    model = load_model(what)
    at = approach_of(model, speed)
    froude = model.ship.froude(at, model.water.g)
    begins = f"The ship begins at {at:.4g} m/s (Fn {froude:.2g})"
    lines = [f"{begins}." if speed is not None else f"{begins}; --speed chooses another speed."]
    if not compile:
        lines.append("It holds C sources; --compile puts a library for this machine into it.")
    return lines
