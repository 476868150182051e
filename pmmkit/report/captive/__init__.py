"""The test report of a captive campaign: content made once, written as a page or for Word."""

from pmmkit.report.captive.build import STANDARDS, captive_document
from pmmkit.report.captive.document import Chapter, Document, Item
from pmmkit.report.captive.html import html_of
from pmmkit.report.captive.write import FORMATS, check_target, write_document

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
