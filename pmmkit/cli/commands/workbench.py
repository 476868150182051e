"""``pmmkit workbench``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from pmmkit.cli.options import Data, Floor, Noise, stem
from pmmkit.cli.output import Outcome, say
from pmmkit.cli.outputs import Out

if TYPE_CHECKING:
    from pmmkit.workbench import Desk

EXAMPLE: Final = "pmmkit workbench my-campaign model.toml --save page.html"


def workbench(
    campaign: Annotated[
        Path | None,
        typer.Argument(help="Folder with campaign.toml, such a file, or .h5; chosen on the page."),
    ] = None,
    model: Annotated[
        str | None,
        typer.Argument(
            help="Library ship, model file, or a structure to which the tests are reduced; "
            "abkowitz3 if absent."
        ),
    ] = None,
    parts: Annotated[
        str | None,
        typer.Option(
            help="Library ship or model file that lends propeller and rudder to a structure; what "
            "the campaign file states, and estimates, if absent."
        ),
    ] = None,
    beside: Annotated[
        list[Path] | None,
        typer.Option(
            "--with",
            help="Another campaign of the same ship, captive or free running; may be repeated.",
        ),
    ] = None,
    folder: Annotated[
        list[Path] | None,
        typer.Option(
            help="Folder whose campaigns may be opened on the page; may be repeated; the present "
            "one if absent. Nothing else is read."
        ),
    ] = None,
    port: Annotated[
        int | None, typer.Option(min=1024, max=65535, help="Port; the next free one if absent.")
    ] = None,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open a browser.")] = True,
    save: Annotated[
        Path | None,
        typer.Option(help="Write the page as one HTML file, which opens by itself, and end."),
    ] = None,
    floor: Floor = None,
    noise: Noise = None,
    data: Data = None,
    out: Out = None,
) -> Outcome:
    """See where a model fails on a page in the browser, add what is missing, watch the error fall.

    The page is served to this machine alone. What is done is kept in the results folder and found
    again there; steps.toml replays it.
    """
    from pmmkit.files import check_folder, free_folder
    from pmmkit.presentation import counted
    from pmmkit.workbench import Desk, WorkbenchState, serve

    target = out or Path("pmmkit-workbench" if campaign is None else f"{stem(campaign)}-workbench")
    check_folder(target)
    if beside and campaign is None:
        raise typer.BadParameter("--with names another campaign: name the first one too.")
    also = beside or []
    own = [path for path in (campaign, *also, *map(Path, filter(None, (model, parts)))) if path]
    named = [*(folder or ([] if campaign else [Path()])), *(own if campaign else [])]
    desk = Desk(target, named)
    asked = WorkbenchState(
        campaign=str(campaign or ""),
        model=model or "",
        data=str(data or ""),
        parts=parts or "",
        also=tuple(map(str, also)),
        noise=noise,
        floor=floor,
    )
    if campaign is not None and desk.state is not None:
        if desk.state.is_about(asked):
            say(f"Going on with {target}: {counted(len(desk.state.steps), 'step')}.")
        else:
            target = free_folder(target)
            say(f"The folder holds another campaign or model: this goes to {target}.")
            desk = Desk(target, named)
    if campaign is not None and desk.state is None:
        desk.open(asked)
    if save is not None:
        return _saved(desk, target, save)
    serve(desk, port=port, browser=browser, say=lambda address: say(f"{address}\nCtrl+C ends it."))
    return Outcome(content={"out": str(target)}, lines=[f"Results: {target}"])


def _saved(desk: Desk, folder: Path, target: Path) -> Outcome:
    """The page as a file, with what stands in the folder."""
    from pmmkit.files import write_text
    from pmmkit.workbench import frozen_page

    try:
        if desk.job.stand == "idle":
            desk.resume()
        desk.wait(say)
        write_text(target, frozen_page(desk))
    finally:
        desk.close()
    content = {"out": str(folder), "files": [str(target)]}
    return Outcome(content=content, lines=[f"Page: {target}", f"Results: {folder}"])
