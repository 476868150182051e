"""Records and candidates made into equations, and the judge of sets of effects."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from pmmkit.campaigns.run import Campaign
from pmmkit.diagnosis.free_running.candidates import FreeCandidate
from pmmkit.diagnosis.free_running.evidence import Fit, basis_of, widened
from pmmkit.diagnosis.free_running.scores import Judge, courses_of
from pmmkit.diagnosis.free_running.system import build_free
from pmmkit.diagnosis.free_running.weighing import WINDOW, weighed
from pmmkit.errors import DataError
from pmmkit.identification.from_run import free_records
from pmmkit.identification.prior import Prior
from pmmkit.identification.record import FreeRecord
from pmmkit.models import Model


def records_of(records: Sequence[FreeRecord] | Campaign, model: Model) -> Sequence[FreeRecord]:
    """Records as they are given, or those of a campaign.

    Parameters
    ----------
    records : sequence of FreeRecord or Campaign
        Free-running tests.
    model : Model
        Of the ship that made them.

    Raises
    ------
    DataError
        If there are none.
    """
    found = (
        [x for run in records.runs for x in free_records(run, model)]
        if isinstance(records, Campaign)
        else records
    )
    if not found:
        raise DataError("There is no record: give free-running tests that have a usable segment.")
    return found


def judge_of(
    model: Model,
    records: Sequence[FreeRecord],
    candidates: Sequence[FreeCandidate],
    prior: Prior,
    *,
    floor: float,
    tolerance: tuple[float, float],
    window: float | None,
    sensors: Mapping[str, float] | None,
    extrapolate: bool,
    tell: Callable[[str], None],
) -> tuple[Judge, Fit]:
    """The judge of sets of some candidates, and the fit of all of them together.

    Parameters
    ----------
    model : Model
        Complete, without the candidates.
    records : sequence of FreeRecord
        At least two.
    candidates : sequence of FreeCandidate
        Who takes part.
    prior : Prior
        What is known of the values of the model.
    floor, tolerance, window, sensors, extrapolate
        As for `diagnose_free`.
    tell : callable
        Is told what is being done.

    Raises
    ------
    DataError
        If there are fewer than two records long enough.
    """
    large = model
    for item in candidates:
        large = item.added_to(large)
    values = tuple(dict.fromkeys((*prior.names, *(v for item in candidates for v in item.values))))
    tell("Records and equations")
    system = build_free(
        large, records, values, sensors=sensors, floor=floor, extrapolate=extrapolate
    )
    basis = basis_of(system, prior, candidates)
    tell("Size of what nothing explains")
    system, largest = weighed(system, basis, [item.name for item in candidates])
    length = window or WINDOW * model.ship.L / records[0].speed
    return Judge(
        system=system,
        basis=basis,
        courses=courses_of(system, length, extrapolate=extrapolate),
        tolerance=np.array(tolerance),
        wider=widened(largest),
    ), largest
