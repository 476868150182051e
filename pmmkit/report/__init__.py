"""The report: one HTML file with everything that was found."""

from pmmkit.report.build import report_html, write_report
from pmmkit.report.turning import Turns, changes
from pmmkit.report.words import Reference

__all__ = ["Reference", "Turns", "changes", "report_html", "write_report"]
