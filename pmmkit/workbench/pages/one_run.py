"""One run of any kind, measured and modelled."""

from __future__ import annotations

from typing import Any

from pmmkit.validation.comparison import Comparison
from pmmkit.workbench.pages.history import history_page
from pmmkit.workbench.pages.numbers import BUCKETS
from pmmkit.workbench.pages.records import record_page


def run_page(comparison: Comparison, name: str, buckets: int = BUCKETS) -> dict[str, Any]:
    """What is drawn of one run: of captive tests (see `history_page`) or of a record that runs free
    (see `record_page`).

    Parameters
    ----------
    comparison : Comparison
        That holds it.
    name : str
        Of a run that was compared.
    buckets : int
        As for `thinned`.

    Raises
    ------
    KeyError
        If it was not compared.
    """
    for record in comparison.free:
        if record.name == name:
            return record_page(record, comparison.ship.L, comparison.floor)
    return history_page(comparison, name, buckets)
