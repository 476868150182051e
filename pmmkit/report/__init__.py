"""Reports: the page of the workbench as one HTML file, with what a command has worked out."""

from pmmkit.models.reference import Reference, reference_of
from pmmkit.report.build import report_html, write_report
from pmmkit.report.comparison import write_comparison
from pmmkit.report.free_running import write_free_diagnosis
from pmmkit.report.loop import Loop, loop_of, write_diagnosis
from pmmkit.report.seakeeping import write_seakeeping
from pmmkit.report.turning import Turns, changes, turns_of

__all__ = [
    "Loop",
    "Reference",
    "Turns",
    "changes",
    "loop_of",
    "reference_of",
    "report_html",
    "turns_of",
    "write_comparison",
    "write_diagnosis",
    "write_free_diagnosis",
    "write_report",
    "write_seakeeping",
]
