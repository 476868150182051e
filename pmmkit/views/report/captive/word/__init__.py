"""A test report for Word: a document of its own, or the laboratory's template filled."""

from pmmkit.views.report.captive.word.build import fields_of, word_bytes

__all__ = ["fields_of", "word_bytes"]
