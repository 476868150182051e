"""What checks found, as words and as data."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from pmmkit.checks.finding import CheckFinding, name_runs


def findings_of(findings: Iterable[CheckFinding]) -> list[dict[str, Any]]:
    """Findings of the checks for JSON."""
    return [
        {
            "check": item.check,
            "severity": item.severity,
            "message": item.message,
            "runs": list(item.runs),
            "remedy": item.remedy,
            "numbers": dict(item.numbers),
        }
        for item in findings
    ]


def findings_text(findings: Sequence[CheckFinding]) -> str:
    """Findings of the checks for people."""
    if not findings:
        return "The checks found nothing to say."
    blocks = []
    for item in findings:
        where = f" ({name_runs(item.runs)})" if item.runs else ""
        lines = [f"{item.severity.upper()} {item.check}{where}", f"  {item.message}"]
        if item.remedy:
            lines.append(f"  {item.remedy}")
        blocks.append("\n".join(lines))
    return "\n".join(blocks)
