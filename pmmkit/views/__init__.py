"""What is shown of results: figures, pages, reports and the form of the IMO."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.views.figures.comparison import comparison_figures
    from pmmkit.views.figures.derivative_bars import derivative_bars
    from pmmkit.views.figures.derivatives import beside_reference
    from pmmkit.views.figures.growth import growth_over_depth
    from pmmkit.views.figures.identification import (
        innovation_figure,
        parameter_histories,
        window_figure,
    )
    from pmmkit.views.figures.inspecting import first_look
    from pmmkit.views.pages.derivatives import derivatives_page
    from pmmkit.views.pages.fall import fall_page
    from pmmkit.views.pages.files import files_page
    from pmmkit.views.pages.joint import joint_page
    from pmmkit.views.pages.misfit import misfit_page
    from pmmkit.views.pages.missing import missing_page
    from pmmkit.views.pages.numbers import BUCKETS
    from pmmkit.views.pages.page_file import page_file
    from pmmkit.views.pages.page_room import Answers, asked_of, fitted, with_runs, worst_first
    from pmmkit.views.pages.records import run_page
    from pmmkit.views.pages.runs import CUTS, literal, record_page_of, runs_page
    from pmmkit.views.pages.turning import Rival, sailed_page, spiral_page, trials_page
    from pmmkit.views.report.build import write_report
    from pmmkit.views.report.captive.build import captive_document
    from pmmkit.views.report.captive.html import check_target, write_document
    from pmmkit.views.report.comparison import write_comparison
    from pmmkit.views.report.free_running import write_free_diagnosis
    from pmmkit.views.report.imo_form.fields import read_stated
    from pmmkit.views.report.imo_form.filled import form_of_model, form_of_trials
    from pmmkit.views.report.imo_form.page import PAGE, form_files
    from pmmkit.views.report.loop import Loop, loop_of, write_diagnosis
    from pmmkit.views.report.pictures import zeros_at_rest
    from pmmkit.views.report.results import write_reduction
    from pmmkit.views.report.seakeeping import write_seakeeping
    from pmmkit.views.report.tables import reference_values
    from pmmkit.views.report.turning import Turns, changes, turns_of

__all__ = [
    "BUCKETS",
    "CUTS",
    "PAGE",
    "Answers",
    "Loop",
    "Rival",
    "Turns",
    "asked_of",
    "beside_reference",
    "captive_document",
    "changes",
    "check_target",
    "comparison_figures",
    "derivative_bars",
    "derivatives_page",
    "fall_page",
    "files_page",
    "first_look",
    "fitted",
    "form_files",
    "form_of_model",
    "form_of_trials",
    "growth_over_depth",
    "innovation_figure",
    "joint_page",
    "literal",
    "loop_of",
    "misfit_page",
    "missing_page",
    "page_file",
    "parameter_histories",
    "read_stated",
    "record_page_of",
    "reference_values",
    "run_page",
    "runs_page",
    "sailed_page",
    "spiral_page",
    "trials_page",
    "turns_of",
    "window_figure",
    "with_runs",
    "worst_first",
    "write_comparison",
    "write_diagnosis",
    "write_document",
    "write_free_diagnosis",
    "write_reduction",
    "write_report",
    "write_seakeeping",
    "zeros_at_rest",
]

lazy(__name__)
