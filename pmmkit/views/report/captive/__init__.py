"""The test report of a captive campaign: content made once, written as a page or for Word."""

from pmmkit.views.report.captive.build import STANDARDS, captive_document
from pmmkit.views.report.captive.document import Chapter, Document, Item
from pmmkit.views.report.captive.html import FORMATS, check_target, html_of, write_document

__all__ = [
    "FORMATS",
    "STANDARDS",
    "Chapter",
    "Document",
    "Item",
    "captive_document",
    "check_target",
    "html_of",
    "write_document",
]
