"""A comparison as a page: the map of runs, each of them measured and modelled."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from pmmkit.intake import CheckFinding
from pmmkit.presentation import Grid, Group, Section, number
from pmmkit.validation import Comparison, errors_in_percent
from pmmkit.views.pages.misfit import misfit_page
from pmmkit.views.pages.page_file import state_of
from pmmkit.views.pages.page_room import Answers, with_runs, worst_first
from pmmkit.views.pages.records import run_page
from pmmkit.views.pages.sections import PageSection, told_page
from pmmkit.views.report.checked import checked_section


def comparison_answers(found: Comparison, findings: Sequence[CheckFinding] = ()) -> Answers:
    """What the page of a comparison holds; findings are those of the checks."""
    misfit = misfit_page(found)
    answers: Answers = {
        "state": state_of(
            title=found.campaign or "Tests",
            kind=found.kind,
            runs=len(found.captive) + len(found.free),
            model=found.model,
        ),
        "misfit 0": misfit,
        "told data": told_page(PageSection(after=[checked_section(findings)])),
        "told where": told_page(PageSection(folded=[*found.sections(), *_in_percent(found)])),
    }
    return with_runs(answers, worst_first(misfit), partial(run_page, found), "run {} 0".format)


def _in_percent(found: Comparison) -> list[Section]:
    """The errors of static runs as workshops table them."""
    static = [run for run in found.captive if not run.view.run.dynamic]
    if not static:
        return []
    table = errors_in_percent(static)
    channels = list(dict.fromkeys(table["channel"]))
    cells = {
        (row["run"], row["channel"]): f"{number(row['E_percent'], 3)} "
        f"({number(row['U_D_percent'], 2)}, {number(row['U_V_percent'], 2)})"
        for row in table.to_dict("records")
    }
    sizes = table["E_percent"].abs().groupby(table["channel"]).mean()
    rows = [
        [run.view.run.id, *(cells.get((run.view.run.id, name)) for name in channels)]
        for run in static
    ]
    rows.append(["mean size", *(number(float(sizes[name]), 3) for name in channels)])
    grid = Grid(
        head=["run", *(f"{name}: E (U_D, U_V)" for name in channels)], groups=[Group(rows=rows)]
    )
    title = "Static runs: E = measured less predicted, in per cent of the measured (k = 2)"
    return [Section(title=title, tables=[grid])]
