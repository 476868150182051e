"""Look for data that contradict themselves; exit status 1 if some do."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, Final

from pmmkit.actions.outcome import Outcome, check_folder, not_made
from pmmkit.actions.setting import settings
from pmmkit.actions.shared import Campaign, Data, Out

if TYPE_CHECKING:
    from pmmkit.intake import CheckFinding


STAGE: Final = ("measure", 3)
EXAMPLE: Final = "pmmkit check my-campaign"


@settings
class CheckSettings:
    """What is asked."""

    campaign: Campaign
    data: Data = None
    out: Out = None


def check(job: CheckSettings) -> Outcome:
    """Do what is asked."""
    from pmmkit.campaigns import open_campaign
    from pmmkit.files import write_results
    from pmmkit.intake import examine

    if job.out:
        check_folder(job.out)
    opened = open_campaign(job.campaign, data=job.data)
    found = examine(opened)
    errors = sum(item.severity == "error" for item in found)
    findings = [item.to_dict() for item in found]
    content = {
        "campaign": opened.title,
        "runs": len(opened),
        "errors": errors,
        "findings": findings,
    }
    if job.out:
        write_results(job.out, [("findings.json", findings), *_files(found)])
    return Outcome(
        content=content, lines=[_text(found), *not_made(opened)], status=1 if errors else 0
    )


def _files(findings: Sequence[CheckFinding]) -> Iterator[tuple[str, Any]]:
    """Figures and tables of the findings that have numbers of each run."""
    from pmmkit.views import zeros_at_rest

    for item in findings:
        if item.by_run:
            yield f"{item.check}.svg", zeros_at_rest(item).save


def _text(findings: Sequence[CheckFinding]) -> str:
    """Findings of the checks for people."""
    from pmmkit.intake import name_runs

    if not findings:
        return "The checks found nothing to say."
    blocks = []
    for item in findings:
        where = f" ({name_runs(item.runs)})" if item.runs else ""
        lines = [f"{item.severity.upper()} {item.check}{where}", f"  {item.message}"]
        if item.remedy:
            lines.append(f"  {item.remedy}")
        lines += [f"  {line}" for line in item.grid().lines()] if item.by_run else []
        blocks.append("\n".join(lines))
    return "\n".join(blocks)
