"""The form of MSC/Circ.1053, appendix 6, for a model or for the trials of a ship."""

from pmmkit.views.report.imo_form.fields import read_stated
from pmmkit.views.report.imo_form.filled import form_of_model, form_of_trials
from pmmkit.views.report.imo_form.form import CriterionLine, FormField, ImoForm
from pmmkit.views.report.imo_form.page import PAGE, form_files, form_html

__all__ = [
    "PAGE",
    "CriterionLine",
    "FormField",
    "ImoForm",
    "form_files",
    "form_html",
    "form_of_model",
    "form_of_trials",
    "read_stated",
]
