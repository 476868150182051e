"""``pmmkit report``."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Final

import typer

from pmmkit.cli.options import (
    Campaign,
    Cycles,
    Data,
    Scheduler,
    Sets,
    StructureName,
    WorkerCount,
    cycles_of,
    stem,
    where,
)
from pmmkit.cli.output import NOT_USABLE, Outcome, say
from pmmkit.cli.outputs import results_file
from pmmkit.presentation import counted

EXAMPLE: Final = "pmmkit report my-campaign --standard ittc"
MOST: Final = 6
"""Keys that are named on the screen."""


class ReportStandard(StrEnum):
    """What a report is structured after."""

    ittc = "ittc"


class ReportFormat(StrEnum):
    """What a report is written as."""

    html = "html"
    docx = "docx"


def report(
    campaign: Campaign,
    standard: Annotated[
        ReportStandard, typer.Option(help="Procedure whose list of contents the report follows.")
    ] = ReportStandard.ittc,
    to: Annotated[
        ReportFormat | None,
        typer.Option(
            help="HTML that a browser prints on A4, or Word (pip install 'pmmkit[word]'); the "
            "ending of the output says it if absent."
        ),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="File of the report.")
    ] = None,
    template: Annotated[
        Path | None,
        typer.Option(help="The laboratory's own Word document (.docx), which is filled."),
    ] = None,
    structure: StructureName = "abkowitz3",
    fn: Sets = "each",
    cycles: Cycles = None,
    data: Data = None,
    workers: WorkerCount = None,
    scheduler: Scheduler = None,
) -> Outcome:
    """Reduce captive tests and write their test report; what is not supplied is listed in it."""
    from pmmkit.base import DataError, shown
    from pmmkit.campaigns import open_campaign
    from pmmkit.reduction import reduce_campaign
    from pmmkit.views import captive_document, check_target, write_document

    ending = to.value if to else "docx" if template and output is None else "html"
    target = results_file(output, f"{stem(campaign)}-report.{ending}", read=[template])
    if to and target.suffix.lower() != f".{to.value}":
        raise typer.BadParameter(f"--to {to.value} and the output {target.name} contradict.")
    check_target(target, template)
    opened = open_campaign(campaign, data=data)
    if opened.kind != "captive":
        raise DataError(
            f"{opened.title}: this report is of captive tests. Free-running records are told by "
            f"pmmkit trial."
        )
    with shown() as progress:
        found = reduce_campaign(
            opened,
            structure=structure,
            fn=fn,
            cycles=cycles_of(cycles),
            progress=progress,
            executor=where(workers, scheduler),
        )
    say("Writing the report ...")
    made = captive_document(found, standard=standard.value)
    file = write_document(made, target, template=template)
    judged = found.verdict
    missing = [
        {"chapter": place, "item": item.what, "key": item.supply} for place, item in made.missing
    ]
    content = {
        "campaign": opened.title,
        "standard": standard.value,
        "file": str(file),
        "chapters": [f"{mark} {chapter.title}" for mark, chapter in made.numbered],
        "not_supplied": missing,
        "verdict": {"use": judged.use, "reasons": list(judged.reasons)},
    }
    keys = [item["key"] for item in missing]
    named = f": {', '.join(keys[:MOST])}{' …' if len(keys) > MOST else ''}" if keys else ""
    lines = [
        f"{counted(len(keys), 'item')} not supplied{named}",
        *(["The last chapter lists them with the keys of campaign.toml."] if keys else []),
        *(f"  - {reason}" for reason in judged.faults),
        f"Verdict: {judged.use}.",
        f"Report: {file.resolve()}",
    ]
    return Outcome(content=content, lines=lines, status=NOT_USABLE if judged.faults else 0)
