"""What the page of the workbench draws of something, whatever that is."""

from __future__ import annotations

from functools import singledispatch
from typing import Any

from pmmkit.campaigns import Campaign
from pmmkit.diagnosis import Diagnosis, Fall, Together
from pmmkit.intake import Drafted
from pmmkit.models import Model
from pmmkit.reduction import Reduction
from pmmkit.validation import Comparison
from pmmkit.views.pages.derivatives import derivatives_page
from pmmkit.views.pages.files import files_page
from pmmkit.views.pages.missing import fall_page, joint_page, missing_page
from pmmkit.views.pages.numbers import BUCKETS
from pmmkit.views.pages.records import misfit_page, run_page
from pmmkit.views.pages.runs import runs_page
from pmmkit.views.pages.turning import sailed_page


@singledispatch
def page_of(shown: Any, *more: Any, **settings: Any) -> dict[str, Any]:
    """What the page of the workbench draws of something, as plain data.

    Parameters
    ----------
    shown : Drafted, Campaign, Comparison, Diagnosis, Together, Fall, Reduction or Model
        Files with the campaign file that is drafted; tests as they were read; where a model
        fails; what is missing, as one campaign or several say; how the error falls; derivatives;
        a manoeuvre.
    *more
        Of a campaign what the checks said. Of a diagnosis its session, and a function that is told
        the share that is done and of which candidate. Of a model the name of the manoeuvre.
    **settings
        Of a campaign the place of the ``first`` run, or the id of the ``run`` that is shown in
        full. Of a comparison the name of the ``run`` that is shown, in ``buckets`` pieces; without
        it the map of all. Of a model ``speed``, whether there is a ``band``, its ``rivals`` and
        those of `simulate`.
    """
    del more, settings
    raise TypeError(f"{type(shown).__name__} has no page.")


page_of.register(Campaign, runs_page)
page_of.register(Diagnosis, missing_page)
page_of.register(Drafted, files_page)
page_of.register(Fall, fall_page)
page_of.register(Model, sailed_page)
page_of.register(Reduction, derivatives_page)
page_of.register(Together, joint_page)


@page_of.register(Comparison)
def _of_comparison(
    comparison: Comparison, *, run: str | None = None, buckets: int | None = None
) -> dict[str, Any]:
    """The map of all runs, or one of them, measured and modelled."""
    if run is None:
        return misfit_page(comparison)
    return run_page(comparison, run, buckets or BUCKETS)
