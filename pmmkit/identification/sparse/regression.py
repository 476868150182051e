"""Sparse regression: which terms of a library the measured forces ask for, and their values."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pmmkit.base import DataError
from pmmkit.conventions import Structure
from pmmkit.identification.forces import ForceRecord
from pmmkit.identification.sparse.collinear import Collinearity
from pmmkit.identification.sparse.request import (
    Groups,
    SparseRequest,
    check_numbers,
    physics_groups,
    request,
)
from pmmkit.identification.sparse.result import SparseRegression, assembled
from pmmkit.inference import EffectiveSample, Resampling, Selection, SelectionMethod
from pmmkit.models import Model
from pmmkit.numerics import Array

__all__ = [
    "Collinearity",
    "SparseRegression",
    "look_for_collinearity",
    "physics_groups",
    "sparse_regression",
]


def sparse_regression(
    model: Model,
    records: Sequence[ForceRecord],
    library: str | Sequence[str] | Structure,
    *,
    fixed: Sequence[str] = (),
    always: Sequence[str] = (),
    groups: Groups | None = None,
    method: SelectionMethod = "stlsq",
    threshold: float | None = None,
    share: float = Selection.SHARE,
    bags: int = Resampling.BAGS,
    weak: bool | int = False,
    seed: int = 0,
    extrapolate: bool = False,
) -> SparseRegression:
    """Choose the terms of a library that measured forces ask for, and fit their values.

    Notes
    -----
    The targets are measured forces: nothing is differenced. Rows are divided by the stated
    standard deviations, columns scaled to unit rms, so that a coefficient is the rms force of its
    term in standard deviations, and a threshold means the same for v and v²r. Each run is turned
    into a triangle by QR once; bags and held-out runs are made of these, without loss.

    The threshold has the least ``n log(error²) + terms log(n)``, the error that of runs left out
    of the fit and n the samples over their design effect, since samples of one run share its
    errors (a held-out BIC). A bag draws whole runs, because samples of one run share its errors
    and its residuals are correlated: bags of samples give intervals that are too narrow.

    ``elimination`` weighs all sets on its way from all terms to none by the BIC with n independent
    samples and the variance that they have; it tells like terms from each other where thresholds
    cannot. In four kinds of 60 made campaigns of 18 or 36 runs (white noise, small forces, offsets
    of runs, autocorrelated noise; ``python -m scripts.studies.terms``) it found the very set of
    terms in 100, 77, 73 and 75 %, ``stlsq`` in 98, 68, 57 and 55 %.

    pysindy's STLSQ (Brunton et al. 2016) chooses the terms where nothing else is asked for; the
    values come from QR, because its ridge solves the normal equations (with a condition number
    of 1e6, four digits are left). Done here, because pysindy 2.1 lacks it or means something
    else: groups; terms exempt from the threshold (``sparse_ind`` leaves them out of ``coef_``);
    bags of whole runs with a seed (its ensembles draw samples, from numpy's global state); bags
    that do not excite a term; thresholds that do not grow with the number of samples (its
    normalised columns have unit length, ours unit rms); their choice by held-out runs. Terms held
    fixed are subtracted beforehand, which needs none of its constraints.

    The weak form multiplies target and library with the same test functions and sums over time.
    It helps where measured motions are noisy, which pulls coefficients towards zero, and against
    vibration; it costs a little where the forces alone have white noise. No derivative is moved
    to the test functions: accelerations are those that the record states.

    The covariance is that of least squares with the terms that stay, its rows worth what errors
    shared by a run leave of them, and that of the choice (`pmmkit.inference.Selection`). In the
    made campaigns above it held the truth in 95 to 98 % at a stated 95 % (each term in 87 to
    100 %). Standard deviations over the bags did so in 95 to 97 % on the whole, but were three to
    eighteen times as large for terms that have a like one (100 %), and too small for those that
    rest on few runs (82 to 90 %). Of three or five runs the intervals hold 93 to 96 %, where noise
    lasts through a run 78 to 87 %: so few say little of how long it lasts.

    References
    ----------
    Brunton, Proctor and Kutz (2016), PNAS 113: sparse regression by thresholds. Fasel, Kutz,
    Brunton and Brunton (2022), Proc. R. Soc. A 478: bags and inclusion shares. Messenger and
    Bortz (2021), Multiscale Model. Simul. 19: weak form.

    Examples
    --------
    >>> from pmmkit.equations import prepare
    >>> from pmmkit.models import load_model
    >>> ship, rng = load_model("kvlcc2-l7"), np.random.default_rng(1)
    >>> ready = prepare(ship, 1.2)
    >>> records = []
    >>> for run in range(8):
    ...     motion = {"u": np.full(30, 1.2), "v": rng.uniform(-.4, .4, 30), "n": np.full(30, 1.7)}
    ...     Y = ready.water_forces(motion)["Y"] + rng.normal(0, .5, 30)
    ...     records.append(ForceRecord(name=f"drift {run}", motion=motion, forces={"Y": Y},
    ...                                std={"Y": .5}, speed=1.2))
    >>> found = sparse_regression(ship, records, "Yv Yvvv Yvvvvv", method="stepwise", bags=20)
    >>> found.table.names, found.left_out
    (('Yv', 'Yvvv'), ('Yvvvvv',))
    """
    check_numbers(bags, share, threshold, weak)
    asked = request(
        model,
        records,
        library,
        fixed=fixed,
        always=always,
        groups=groups,
        method=method,
        weak=weak,
        extrapolate=extrapolate,
    )
    resampling = Resampling.of(len(records), bags, np.random.default_rng(seed))
    selections = [
        Selection.of(problem, runs, resampling, threshold=threshold, share=share)
        for problem, runs in zip(asked.problems, asked.runs, strict=True)
    ]
    selection = Selection.combined(selections, [problem.columns for problem in asked.problems])
    if not selection.stays.any():
        raise DataError(
            f"No term stays in {share:.0%} of the bags. Lower threshold or share, take a term as "
            f"always, or state smaller standard deviations where they are too large."
        )
    return assembled(
        model,
        asked,
        selection,
        covariance=_covariance(asked, selections),
        paths=[item.path for item in selections if item.path is not None],
        errors=_errors(asked, selections, resampling),
    )


def _covariance(asked: SparseRequest, selections: Sequence[Selection]) -> Array:
    """Covariance of the terms that stay; systems that share no term are independent."""
    stays = np.zeros(len(asked.names), bool)
    whole = np.zeros((len(stays),) * 2)
    for problem, runs, item in zip(asked.problems, asked.runs, selections, strict=True):
        at = np.array(problem.columns)[item.stays]
        stays[at] = True
        whole[np.ix_(at, at)] = item.covariance(runs, EffectiveSample.of(runs))
    return np.asarray(whole[np.ix_(stays, stays)])


def _errors(
    asked: SparseRequest, selections: Sequence[Selection], resampling: Resampling
) -> dict[str, dict[str, float]]:
    """Rms error of each run left out, by run and channel, where it is measured."""
    errors: dict[str, dict[str, float]] = {rows.run: {} for rows in asked.rows}
    for problem, runs, item in zip(asked.problems, asked.runs, selections, strict=True):
        held_out = resampling.held_out(problem, runs, item.threshold)
        for rows, run, squares in zip(asked.rows, runs, held_out, strict=True):
            mean = np.sqrt(squares / np.maximum(run.rows, 1))
            errors[rows.run] |= {
                channel: value
                for channel, value, count in zip(
                    problem.channels, mean.tolist(), run.rows.tolist(), strict=True
                )
                if count
            }
    return errors


def look_for_collinearity(
    model: Model,
    records: Sequence[ForceRecord],
    library: str | Sequence[str] | Structure,
    *,
    weak: bool | int = False,
    extrapolate: bool = False,
) -> Collinearity:
    """Which terms of a library these records cannot tell apart, before any fit."""
    return request(model, records, library, weak=weak, extrapolate=extrapolate).collinearity
