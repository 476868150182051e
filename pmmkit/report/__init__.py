"""The report: one HTML file with everything that was found."""

from pmmkit.report.build import report_html, write_report
from pmmkit.report.loop import Loop, loop_of, write_diagnosis
from pmmkit.report.turning import Turns, changes
from pmmkit.report.words import Reference

__all__ = [
    "Loop",
    "Reference",
    "Turns",
    "changes",
    "loop_of",
    "report_html",
    "write_diagnosis",
    "write_report",
]
