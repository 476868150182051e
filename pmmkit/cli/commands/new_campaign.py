"""``pmmkit new-campaign``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from pmmkit.cli.output import Outcome
from pmmkit.presentation import quoted

if TYPE_CHECKING:
    from pmmkit.intake import Draft


EXAMPLE: Final = "pmmkit new-campaign my-files --ship s175"


def new_campaign(
    folder: Annotated[Path, typer.Argument(help="Folder with the files of the tests, or a file.")],
    out: Annotated[
        Path | None, typer.Option(help="Campaign file; campaign.toml in the folder if absent.")
    ] = None,
    ship: Annotated[
        str | None, typer.Option(help="Ship of the library (pmmkit ships), at its scale.")
    ] = None,
    sheet: Annotated[
        str | None, typer.Option(help="The only sheet of the workbook that is meant.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace a file that is there.")] = False,
) -> Outcome:
    """Draft a campaign.toml from the files of a folder, for a person to check and complete."""
    from pmmkit.base import FileExists
    from pmmkit.campaigns import FILE_NAME
    from pmmkit.files import write_text
    from pmmkit.intake import draft_of, proposed, written

    beside = folder if folder.is_dir() or not folder.exists() else folder.parent
    target = beside / FILE_NAME if out is None else out
    if target.is_dir():
        target = target / FILE_NAME
    if target.exists() and not force:
        raise FileExists(f"{target} is there: it was not replaced. Name another --out, or --force.")
    draft = proposed(draft_of(folder, target, ship=ship, sheet=sheet), target)
    text = written(draft)
    try:
        write_text(target, text.text)
    except OSError as error:
        raise FileExists(
            f"{target} cannot be written: {error.strerror}. Choose another place with --out."
        ) from error
    saved = sum(len(campaign) for _, campaign in draft.saved)
    count = saved + len(draft.runs) + len(draft.tables)
    lines = [f"{target}: {_counted(draft)}; {text.complete} of {count} entries need nothing more."]
    if draft.look.passed_over:
        lines.append(f"{draft.look.passed_over} more files were not looked at.")
    lines += ["", "For you to say or to check (TODO in the file):"]
    lines += [f"  {number}. {item}" for number, item in enumerate(text.todo, start=1)]
    command = f"pmmkit check {quoted(target.parent if target.name == FILE_NAME else target)}"
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


def _counted(draft: Draft) -> str:
    parts = [f"{len(draft.runs)} histories"] if draft.runs else []
    parts += [f"{len(draft.tables)} tables"] if draft.tables else []
    parts += [f"{len(campaign)} runs of {file}" for file, campaign in draft.saved]
    return f"a {draft.kind} campaign of {', '.join(parts)}"
