"""Commands about files of which nothing is known; what does the work is imported when one runs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pmmkit.cli.options import Json, Out, app, finish


@app.command()
def inspect(
    path: Annotated[Path, typer.Argument(help="File of measurements, or a folder with many.")],
    out: Out = None,
    json: Json = False,
) -> None:
    """Say what a file or a folder holds: format, columns, units, and what they probably are."""
    from pmmkit.cli import inspecting

    finish(inspecting.inspect(path, out=out), json)


@app.command("new-campaign")
def new_campaign(
    folder: Annotated[Path, typer.Argument(help="Folder with the files of the tests.")],
    out: Annotated[
        Path | None, typer.Option(help="Campaign file; campaign.toml in the folder if absent.")
    ] = None,
    ship: Annotated[
        str | None, typer.Option(help="Ship of the library (pmmkit ships), at its scale.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace a file that is there.")] = False,
    json: Json = False,
) -> None:
    """Draft a campaign.toml from the files of a folder, for a person to check and complete."""
    from pmmkit.cli import drafting

    finish(drafting.new_campaign(folder, out=out, ship=ship, force=force), json)
