"""Reduce captive tests and write their test report; what is not supplied is listed in it."""

from __future__ import annotations

from pathlib import Path
from typing import Final, Literal

from pmmkit.actions.outcome import NOT_USABLE, Outcome, results_file, say
from pmmkit.actions.setting import SettingError, cycles_of, setting, settings, stem
from pmmkit.actions.shared import (
    STRUCTURE,
    Campaign,
    Cycles,
    Data,
    ExecutionSettings,
    Output,
    Sets,
    StructureName,
)
from pmmkit.presentation import counted

STAGE: Final = ("hand in", 1)
EXAMPLE: Final = "pmmkit report my-campaign --standard ittc"
MOST: Final = 6
"""Keys that are named on the screen."""


Standard = Literal["ittc"]
"""What a report is structured after."""
Format = Literal["html", "docx"]
"""What a report is written as."""


@settings
class ReportSettings:
    """What is asked."""

    campaign: Campaign
    standard: Standard = setting(
        "Procedure whose list of contents the report follows.", default="ittc"
    )
    to: Format | None = setting(
        "HTML that a browser prints on A4, or Word (pip install 'pmmkit[word]'); the "
        "ending of the output says it if absent.",
        default=None,
    )
    output: Output = None
    template: Path | None = setting(
        "The laboratory's own Word document (.docx), which is filled.", default=None
    )
    structure: StructureName = STRUCTURE
    fn: Sets = "each"
    cycles: Cycles = None
    data: Data = None
    execution: ExecutionSettings = ExecutionSettings()


def report(job: ReportSettings) -> Outcome:
    """Do what is asked."""
    from pmmkit.base import DataError, shown
    from pmmkit.campaigns import open_campaign
    from pmmkit.reduction import reduce_campaign
    from pmmkit.views import captive_document, check_target, write_report

    ending = job.to if job.to else "docx" if job.template and job.output is None else "html"
    target = results_file(job.output, f"{stem(job.campaign)}-report.{ending}", read=[job.template])
    if job.to and target.suffix.lower() != f".{job.to}":
        raise SettingError(f"--to {job.to} and the output {target.name} contradict.")
    check_target(target, job.template)
    opened = open_campaign(job.campaign, data=job.data)
    if opened.kind != "captive":
        raise DataError(
            f"{opened.title}: this report is of captive tests. Free-running records are told by "
            f"pmmkit trial."
        )
    with shown() as progress:
        found = reduce_campaign(
            opened,
            structure=job.structure,
            fn=job.fn,
            cycles=cycles_of(job.cycles),
            progress=progress,
            executor=job.execution.executor,
        )
    say("Writing the report ...")
    made = captive_document(found, standard=job.standard)
    file = write_report(made, target, template=job.template)
    judged = found.verdict
    missing = [
        {"chapter": place, "item": item.what, "key": item.supply} for place, item in made.missing
    ]
    content = {
        "campaign": opened.title,
        "standard": job.standard,
        "file": str(file),
        "chapters": [f"{mark} {chapter.title}" for mark, chapter in made.numbered],
        "not_supplied": missing,
        "verdict": judged.told(),
    }
    keys = [item["key"] for item in missing]
    named = f": {', '.join(keys[:MOST])}{' …' if len(keys) > MOST else ''}" if keys else ""
    lines = [
        f"{counted(len(keys), 'item')} not supplied{named}",
        *(["The last chapter lists them with the keys of campaign.toml."] if keys else []),
        *(f"  - {reason}" for reason in judged.faults),
        f"Verdict: {judged.use}{judged.proviso}.",
        f"Report: {file.resolve()}",
    ]
    return Outcome(content=content, lines=lines, status=NOT_USABLE if judged.faults else 0)
