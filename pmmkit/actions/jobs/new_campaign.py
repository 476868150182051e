"""Draft a campaign.toml from the files of a folder, for a person to check and complete.

The draft is campaign.toml beside the files if -o is absent.
"""

from __future__ import annotations

from pathlib import Path
from typing import Final

from pmmkit.actions.outcome import Outcome
from pmmkit.actions.setting import setting, settings
from pmmkit.actions.shared import Output
from pmmkit.presentation import quoted

STAGE: Final = ("measure", 2)
EXAMPLE: Final = "pmmkit new-campaign my-files --ship s175"


@settings
class NewCampaignSettings:
    """What is asked."""

    folder: Path = setting("Folder with the files of the tests, or a file.", argument=True)
    output: Output = None
    ship: str | None = setting("Ship of the library (pmmkit ships), at its scale.", default=None)
    sheet: str | None = setting("The only sheet of the workbook that is meant.", default=None)
    force: bool = setting("Replace a file that is there.", default=False)


def new_campaign(job: NewCampaignSettings) -> Outcome:
    """Do what is asked."""
    from pmmkit.base import FileExists
    from pmmkit.files import CAMPAIGN, write_text
    from pmmkit.intake import campaign_draft, written

    beside = job.folder if job.folder.is_dir() or not job.folder.exists() else job.folder.parent
    target = beside / CAMPAIGN.file if job.output is None else job.output
    if target.is_dir():
        target = target / CAMPAIGN.file
    if target.exists() and not job.force:
        raise FileExists(f"{target} is there: it was not replaced. Name another -o, or --force.")
    draft = campaign_draft(job.folder, target, ship=job.ship, sheet=job.sheet)
    text = written(draft)
    try:
        write_text(target, text.text)
    except OSError as error:
        raise FileExists(
            f"{target} cannot be written: {error.strerror}. Choose another place with -o."
        ) from error
    saved = sum(len(campaign) for _, campaign in draft.saved)
    count = saved + len(draft.runs) + len(draft.tables)
    lines = [f"{target}: {draft.words}; {text.complete} of {count} entries need nothing more."]
    if draft.look.passed_over:
        lines.append(f"{draft.look.passed_over} more files were not looked at.")
    lines += ["", "For you to say or to check (TODO in the file):"]
    lines += [f"  {number}. {item}" for number, item in enumerate(text.todo, start=1)]
    command = f"pmmkit check {quoted(target.parent if target.name == CAMPAIGN.file else target)}"
    lines += ["", f"Next: {command}"]
    content = {
        "file": str(target),
        "kind": draft.kind,
        "runs": [
            {
                "id": run.id,
                "file": run.file,
                "test": run.test,
                "settings": {item.key: item.value for item in run.settings if item.active},
            }
            for run in draft.runs
        ],
        "tables": [
            {"id": entry.id, "file": entry.file, "test": entry.test} for entry in draft.tables
        ],
        "saved": {file: len(campaign) for file, campaign in draft.saved},
        "complete": text.complete,
        "todo": list(text.todo),
        "next": command,
    }
    return Outcome(content=content, lines=lines)
