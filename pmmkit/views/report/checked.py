"""What the checks found, as a section."""

from __future__ import annotations

from collections.abc import Sequence

from pmmkit.intake import CheckFinding, name_runs
from pmmkit.presentation import Picture, Section


def checked_section(findings: Sequence[CheckFinding], figures: Sequence[Picture] = ()) -> Section:
    """What the checks found, with the zeros of the gauges where they tell them."""
    shown = [
        {
            "severity": item.severity,
            "check": item.check,
            "message": item.message,
            "runs": name_runs(item.runs, 12),
            "remedy": item.remedy,
        }
        for item in findings
    ]
    return Section(
        title="What the checks found",
        paragraphs=[] if shown else ["The checks found nothing to say."],
        findings=shown,
        tables=[item.grid() for item in findings if item.by_run],
        figures=list(figures),
    )
