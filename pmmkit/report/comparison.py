"""A comparison as a page: the map of runs, each of them measured and modelled."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from pmmkit.checks.finding import CheckFinding
from pmmkit.files import write_text
from pmmkit.presentation import sections_of
from pmmkit.report.checked import checked_section
from pmmkit.validation.comparison import Comparison
from pmmkit.workbench.page_file import page_file, state_of
from pmmkit.workbench.page_room import Answers, with_runs, worst_first
from pmmkit.workbench.pages.misfit import misfit_page
from pmmkit.workbench.pages.one_run import run_page
from pmmkit.workbench.pages.sections import Place, told_page


def write_comparison(
    found: Comparison, path: str | Path, *, findings: Sequence[CheckFinding] = ()
) -> Path:
    """Write a comparison as one HTML file, all or nothing.

    Parameters
    ----------
    found : Comparison
        A model beside tests.
    path : path
        File to write.
    findings : sequence of CheckFinding
        What the checks say of the tests.

    Returns
    -------
    Path
        The file.
    """
    target = Path(path)
    write_text(target, page_file(comparison_answers(found, findings)))
    return target


def comparison_answers(found: Comparison, findings: Sequence[CheckFinding] = ()) -> Answers:
    """What the page of a comparison holds.

    Parameters
    ----------
    found, findings
        As for `write_comparison`.
    """
    misfit = misfit_page(found)
    answers: Answers = {
        "state": state_of(
            title=found.campaign or "Tests",
            kind=found.kind,
            runs=len(found.captive) + len(found.free),
            model=found.model,
        ),
        "misfit 0": misfit,
        "told data": told_page(Place(after=[checked_section(findings)])),
        "told where": told_page(Place(folded=sections_of(found))),
    }
    return with_runs(answers, worst_first(misfit), partial(run_page, found), "run {} 0".format)
