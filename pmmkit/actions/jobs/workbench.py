"""See where a model fails on a page in the browser, add what is missing, watch the error fall.

The page is served to this machine alone. What is done is kept in the results folder and found
again there; steps.toml replays it.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Final

from pmmkit.actions.catalogue import action
from pmmkit.actions.outcome import Outcome, check_folder, say
from pmmkit.actions.setting import SettingError, setting, settings, stem
from pmmkit.actions.shared import Data, NoiseSettings, Out

if TYPE_CHECKING:
    from pmmkit.workbench import Desk

STAGE: Final = ("explain", 5)
EXAMPLE: Final = "pmmkit workbench my-campaign model.toml --save page.html"


@settings
class WorkbenchSettings:
    """What is asked."""

    campaign: Path | None = setting(
        "Folder with campaign.toml, such a file, or .h5; chosen on the page.",
        default=None,
        argument=True,
    )
    model: str | None = setting(
        "Library ship, model file, or a structure to which the tests are reduced; "
        "abkowitz3 if absent.",
        default=None,
        argument=True,
    )
    parts: str | None = setting(
        "Library ship or model file that lends propeller and rudder to a structure; what "
        "the campaign file states, and estimates, if absent.",
        default=None,
    )
    beside: tuple[Path, ...] = setting(
        "Another campaign of the same ship, captive or free running; may be repeated.",
        default=(),
        names="--with",
    )
    folder: tuple[Path, ...] = setting(
        "Folder whose campaigns may be opened on the page; may be repeated; the present "
        "one if absent. Nothing else is read.",
        default=(),
    )
    port: int | None = setting(
        "Port; the next free one if absent.", default=None, least=1024, most=65535
    )
    browser: bool = setting("Open a browser.", default=True)
    save: Path | None = setting(
        "Write the page as one HTML file, which opens by itself, and end.", default=None
    )
    uncertainty: NoiseSettings = NoiseSettings()
    data: Data = None
    out: Out = None


def workbench(job: WorkbenchSettings) -> Outcome:
    """Do what is asked."""
    from pmmkit.files import free_folder
    from pmmkit.presentation import counted
    from pmmkit.workbench import Desk, WorkbenchState, serve

    target = job.out or Path(
        "pmmkit-workbench" if job.campaign is None else f"{stem(job.campaign)}-workbench"
    )
    check_folder(target)
    if job.beside and job.campaign is None:
        raise SettingError("--with names another campaign: name the first one too.")
    own = [
        path
        for path in (job.campaign, *job.beside, *map(Path, filter(None, (job.model, job.parts))))
        if path
    ]
    named = [*(job.folder or ([] if job.campaign else [Path()])), *(own if job.campaign else [])]
    desk = Desk(target, named, action)
    asked = WorkbenchState(
        campaign=str(job.campaign or ""),
        model=job.model or "",
        data=str(job.data or ""),
        parts=job.parts or "",
        also=tuple(map(str, job.beside)),
        noise=job.uncertainty.noise,
        floor=job.uncertainty.floor,
    )
    if job.campaign is not None and desk.state is not None:
        if desk.state.is_about(asked):
            say(f"Going on with {target}: {counted(len(desk.state.steps), 'step')}.")
        else:
            target = free_folder(target)
            say(f"The folder holds another campaign or model: this goes to {target}.")
            desk = Desk(target, named, action)
    if job.campaign is not None and desk.state is None:
        desk.open(asked)
    if job.save is not None:
        return _saved(desk, target, job.save)
    serve(
        desk,
        port=job.port,
        browser=job.browser,
        say=lambda address: say(f"{address}\nCtrl+C ends it."),
    )
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
