"""``pmmkit demo``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Final

import typer

from pmmkit.cli.output import Outcome
from pmmkit.cli.outputs import Out, results_folder

EXAMPLE: Final = "pmmkit demo --out my-demo"


def demo(
    my_data: Annotated[
        Path | None,
        typer.Option(
            "--my-data",
            help="Your own folder or file instead: as far as it goes towards a turn, and what is "
            "missing. Nothing is written there.",
        ),
    ] = None,
    ship: Annotated[
        str | None,
        typer.Option(help="Ship of the library (pmmkit ships) that was tested, with --my-data."),
    ] = None,
    out: Out = None,
) -> Outcome:
    """Reduce the synthetic S175 programme, compare it with Son and Nomoto, turn the ship."""
    from pmmkit.cli.commands.reduce import reduced
    from pmmkit.cli.commands.trial import trial
    from pmmkit.cli.my_data import as_far_as_it_goes
    from pmmkit.files import datasets_folder

    if my_data is not None:
        return as_far_as_it_goes(my_data, reduce=reduced, measure=trial, ship=ship, out=out)
    if ship is not None:
        raise typer.BadParameter("--ship goes with --my-data FOLDER.")
    return reduced(
        datasets_folder() / "s175",
        results_folder(out, "pmmkit-demo"),
        parts="s175-3dof",
        reference="s175-3dof",
        reference_name="Son and Nomoto 1981",
        asked="cubic",
    )
