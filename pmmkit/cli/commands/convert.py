"""``pmmkit convert``."""

from __future__ import annotations

from dataclasses import asdict
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Final

import typer

from pmmkit.cli.options import stated
from pmmkit.cli.output import Outcome
from pmmkit.cli.outputs import Out, results_file

EXAMPLE: Final = "pmmkit convert derivatives.csv --system bis --format xlsx"


class TableFormat(StrEnum):
    """Format of a derivative table."""

    csv = "csv"
    nc = "nc"
    xlsx = "xlsx"
    tex = "tex"


def convert(
    table: Annotated[Path, typer.Argument(help="Derivative table: .csv, .nc, .h5 or .xlsx.")],
    system: Annotated[str | None, typer.Option(help="prime, prime-d or bis.")] = None,
    coriolis: Annotated[str | None, typer.Option(help="in-derivatives or separate.")] = None,
    sway: Annotated[str | None, typer.Option(help="v or beta.")] = None,
    surge: Annotated[str | None, typer.Option(help="u or constant.")] = None,
    format: Annotated[TableFormat | None, typer.Option(help="That of the table if absent.")] = None,
    out: Out = None,
) -> Outcome:
    """Convert a table between systems, conventions and file formats."""
    from pmmkit.base import FileExists
    from pmmkit.files import check_folder
    from pmmkit.models import converted, read_table, write_table

    changes = stated(system=system, coriolis=coriolis, sway=sway, surge=surge)
    known = read_table(table)
    made = converted(known, **changes) if changes else known
    folder = out or table.parent
    ending = f".{format.value}" if format else table.suffix
    target = folder / f"{'-'.join([table.stem, *changes.values()])}{ending}"
    if target.resolve() == table.resolve():
        raise FileExists(f"{table} is already that table: say a system, a convention or a format.")
    check_folder(folder)
    target = results_file(None if out is None else target, target)
    write_table(made, target)
    return Outcome(
        content={"file": str(target), "convention": asdict(made.convention)},
        lines=[f"{target}: {made.convention.meaning}."],
    )
