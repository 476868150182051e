"""Commands about tests and tables; what does the work is imported when a command runs."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from pmmkit.cli.options import Campaign, Data, Json, Out, app, finish, stem


class Fn(StrEnum):
    """A set of derivatives per Froude number, or one over all speeds."""

    each = "each"
    pooled = "pooled"


class Format(StrEnum):
    """Format of a derivative table."""

    csv = "csv"
    nc = "nc"
    xlsx = "xlsx"
    tex = "tex"


@app.command()
def demo(out: Out = None, json: Json = False) -> None:
    """Reduce the synthetic S175 programme, compare it with Son and Nomoto, turn the ship."""
    from pmmkit.cli import reducing

    finish(reducing.demo(out or Path("pmmkit-demo")), json)


@app.command()
def reduce(
    campaign: Campaign,
    structure: Annotated[
        str, typer.Option(help="Name of a structure, or derivatives such as 'Yv Yv|v| Nv'.")
    ] = "abkowitz3",
    fn: Annotated[Fn, typer.Option(help="A set per Froude number, or one over all.")] = Fn.each,
    cycles: Annotated[
        str | None, typer.Option(help="Cycles to take, such as 3 or 3-6; a test decides if absent.")
    ] = None,
    parts: Annotated[
        str | None, typer.Option(help="Library ship or model file that gives propeller and rudder.")
    ] = None,
    reference: Annotated[
        str | None, typer.Option(help="Library ship, model file or table to compare with.")
    ] = None,
    data: Data = None,
    jobs: Annotated[
        int | None,
        typer.Option(min=1, help="Processes that read runs; the number of processors if absent."),
    ] = None,
    memory: Annotated[
        float, typer.Option(min=1, help="Memory that they may take together in MB.")
    ] = 1000.0,
    out: Out = None,
    json: Json = False,
) -> None:
    """Reduce captive tests to a table of derivatives, a model and a report.

    Typed again after an interruption it goes on with the runs that were not yet read.
    """
    from pmmkit.cli import reducing

    result = reducing.reduce(
        campaign,
        out or Path(f"{stem(campaign)}-reduced"),
        structure=structure,
        fn=fn.value,
        cycles=_cycles(cycles),
        data=data,
        parts=parts,
        reference=reference,
        jobs=jobs,
        memory=memory,
    )
    finish(result, json)


@app.command()
def check(campaign: Campaign, data: Data = None, out: Out = None, json: Json = False) -> None:
    """Look for data that contradict themselves; exit status 1 if some do."""
    from pmmkit.cli import tasks

    result = tasks.check(campaign, data=data, out=out)
    finish(result, json)
    if result.content["errors"]:
        raise typer.Exit(1)


@app.command()
def convert(
    table: Annotated[Path, typer.Argument(help="Derivative table: .csv, .nc, .h5 or .xlsx.")],
    system: Annotated[str | None, typer.Option(help="prime, prime-d or bis.")] = None,
    coriolis: Annotated[str | None, typer.Option(help="in-derivatives or separate.")] = None,
    sway: Annotated[str | None, typer.Option(help="v or beta.")] = None,
    surge: Annotated[str | None, typer.Option(help="u or constant.")] = None,
    format: Annotated[Format | None, typer.Option(help="That of the table if absent.")] = None,
    out: Out = None,
    json: Json = False,
) -> None:
    """Convert a table between systems, conventions and file formats."""
    from pmmkit.cli import tasks

    wanted = {"system": system, "coriolis": coriolis, "sway": sway, "surge": surge}
    changes = {name: value for name, value in wanted.items() if value is not None}
    ending = f".{format.value}" if format else table.suffix
    finish(tasks.convert(table, out or table.parent, ending, changes), json)


@app.command()
def ships(json: Json = False) -> None:
    """The library of ships."""
    from pmmkit.cli import tasks

    finish(tasks.ships_of_library(), json)


@app.command()
def effects(json: Json = False) -> None:
    """The catalogue of effects that models are made of."""
    from pmmkit.cli import tasks

    finish(tasks.effects(), json)


def _cycles(text: str | None) -> int | tuple[int, int] | None:
    if text is None:
        return None
    first, dash, last = text.partition("-")
    try:
        return (int(first), int(last)) if dash else int(first)
    except ValueError:
        raise typer.BadParameter(f"{text!r}: write one cycle (3) or a range (3-6).") from None
