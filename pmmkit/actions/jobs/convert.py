"""Convert a table between systems, conventions and file formats."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Final, Literal

from pmmkit.actions.outcome import Outcome, check_folder, results_file
from pmmkit.actions.setting import present, setting, settings
from pmmkit.actions.shared import Out

STAGE: Final = ("model", 7)
EXAMPLE: Final = "pmmkit convert derivatives.csv --system bis --format xlsx"


Format = Literal["csv", "nc", "xlsx", "tex"]
"""Format of a derivative table."""


@settings
class ConvertSettings:
    """What is asked."""

    table: Path = setting("Derivative table: .csv, .nc, .h5 or .xlsx.", argument=True)
    system: str | None = setting("prime, prime-d or bis.", default=None)
    coriolis: str | None = setting("in-derivatives or separate.", default=None)
    sway: str | None = setting("v or beta.", default=None)
    surge: str | None = setting("u or constant.", default=None)
    format: Format | None = setting("That of the table if absent.", default=None)
    out: Out = None


def convert(job: ConvertSettings) -> Outcome:
    """Do what is asked."""
    from pmmkit.base import FileExists
    from pmmkit.models import converted, read_table, write_table

    changes = present(system=job.system, coriolis=job.coriolis, sway=job.sway, surge=job.surge)
    known = read_table(job.table)
    made = converted(known, **changes) if changes else known
    folder = job.out or job.table.parent
    ending = f".{job.format}" if job.format else job.table.suffix
    target = folder / f"{'-'.join([job.table.stem, *changes.values()])}{ending}"
    if target.resolve() == job.table.resolve():
        raise FileExists(
            f"{job.table} is already that table: say a system, a convention or a format."
        )
    check_folder(folder)
    target = results_file(None if job.out is None else target, target)
    write_table(made, target)
    return Outcome(
        content={"file": str(target), "convention": asdict(made.convention)},
        lines=[f"{target}: {made.convention.meaning}."],
    )
