"""The test report of a captive campaign: content made once, written as a page or for Word."""
