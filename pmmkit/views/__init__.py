"""What is shown of results: figures, pages, reports and the form of the IMO."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.views.figures.comparison import comparison_figures
    from pmmkit.views.figures.derivatives import (
        beside_reference,
        derivative_bars,
        growth_over_depth,
    )
    from pmmkit.views.figures.identification import filter_figures, window_figure
    from pmmkit.views.figures.inspecting import first_look
    from pmmkit.views.pages.page_file import asked_of, page_file, with_histories
    from pmmkit.views.pages.page_of import page_of
    from pmmkit.views.pages.runs import window_entry
    from pmmkit.views.pages.turning import trials_page
    from pmmkit.views.report.build import write_reduction, write_report
    from pmmkit.views.report.captive.build import captive_document, check_target
    from pmmkit.views.report.imo_form.filled import form_of_model, form_of_trials, read_stated
    from pmmkit.views.report.loop import Loop
    from pmmkit.views.report.pictures import zeros_at_rest
    from pmmkit.views.report.tables import reference_values
    from pmmkit.views.report.turning import Turns

__all__ = [
    "Loop",
    "Turns",
    "asked_of",
    "beside_reference",
    "captive_document",
    "check_target",
    "comparison_figures",
    "derivative_bars",
    "filter_figures",
    "first_look",
    "form_of_model",
    "form_of_trials",
    "growth_over_depth",
    "page_file",
    "page_of",
    "read_stated",
    "reference_values",
    "trials_page",
    "window_entry",
    "window_figure",
    "with_histories",
    "write_reduction",
    "write_report",
    "zeros_at_rest",
]

lazy(__name__)
