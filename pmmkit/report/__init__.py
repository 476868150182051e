"""The report: one HTML file with everything that was found."""

from pmmkit.report.build import report_html, write_report
from pmmkit.report.turning import Turns, changes

__all__ = ["Turns", "changes", "report_html", "write_report"]
