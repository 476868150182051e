"""The form of MSC/Circ.1053, appendix 6, for a model or for the trials of a ship."""

from pmmkit.report.imo_form.fields import read_stated
from pmmkit.report.imo_form.filled import form_of_model, form_of_trials
from pmmkit.report.imo_form.form import Entry, Form, Line
from pmmkit.report.imo_form.page import PAGE, form_files, form_html

__all__ = [
    "PAGE",
    "Entry",
    "Form",
    "Line",
    "form_files",
    "form_html",
    "form_of_model",
    "form_of_trials",
    "read_stated",
]
