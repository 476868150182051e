"""The budget of the derivatives of a reduction."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.base import DataError
from pmmkit.campaigns import TypeB
from pmmkit.inference import root
from pmmkit.numerics import Array
from pmmkit.reduction.budgets.budget import Budget, BudgetResult, Source
from pmmkit.reduction.observations.equations import sensitivity
from pmmkit.reduction.observations.stated import acts
from pmmkit.reduction.solve import Push

if TYPE_CHECKING:
    import pandas as pd

    from pmmkit.reduction.reduce import Reduction


NOISE: Final = "noise, repeats and misfit"
NUMERICAL: Final = "U_SN of the computation"
SCATTER: Final = {
    "offset": "scatter between runs: zero",
    "harmonics": "scatter between runs: harmonics",
    "gain": "scatter between runs: gain",
    "drift": "scatter between runs: drift angle",
}
STEP: Final = 1e-3
"""Error that asks whether runs feel a source [SI or share]."""
ROUNDING: Final = 1e-9
"""Change of the regressors over their size that says so."""
OUTSIDE: Final = (
    "residual current and waves between runs (waiting time)",
    "blockage, and the finite depth of the tank",
    "freedom in heave, pitch and roll",
    "the facility: another tank with the same model",
    "scale effect",
    "form of the mathematical model",
)
"""What no statement in a campaign file covers."""


def derivative_budget(reduction: Reduction) -> Budget:
    """Which source makes how much of the uncertainty of each derivative.

    Parameters
    ----------
    reduction : Reduction
        The reduced tests.

    Returns
    -------
    Budget
        Of the derivatives of the global regression that have an uncertainty, at each Froude
        number. Its variances are those of the table's covariance.

    Raises
    ------
    DataError
        If none has an uncertainty.

    Notes
    -----
    A source that is wrong by one standard uncertainty changes the equations of each run
    (`pmmkit.reduction.observations.stated`); the regression, with its weights as they are, carries
    that to the derivatives. An error of all runs moves them together; one that each run draws
    counts run by run. Type A is the noise of the records with what repeats and residuals show
    beyond it, and the scatter between runs (Simonsen 2004, ITTC 7.5-02-06-04 and JCGM 100:2008,
    5.1).
    """
    return replace(measured_budget(reduction), not_stated=not_stated(reduction), outside=OUTSIDE)


def measured_budget(reduction: Reduction) -> Budget:
    """The same without what was not stated, which takes longer to find than the budget itself."""
    joint = reduction.solution.joint
    asked = set(next(iter(reduction.estimates.values())).table.names)
    there = [
        place
        for place, (_, name) in enumerate(joint.labels)
        if name in asked and np.isfinite(joint.covariance[place, place])
    ]
    if not there:
        raise DataError(
            "None of these derivatives was determined with an uncertainty: more runs than "
            "derivatives are needed, or records that show their noise."
        )
    results = tuple(
        BudgetResult(
            name=joint.labels[place][1],
            value=float(joint.value[place]),
            Fn=float(reduction.solution.Fn[joint.labels[place][0]]),
        )
        for place in there
    )
    campaign = reduction.campaign
    return Budget(
        subject=campaign.title or campaign.ship.name,
        results=results,
        sources=(_noise(reduction, there), *_pushed(reduction, there)),
    )


def _noise(reduction: Reduction, there: Sequence[int]) -> Source:
    """What the noise of each run does, channel by channel."""
    solution = reduction.solution
    factors, drawn, start = [], [], 0
    for group, item in solution.fits:
        end = start + len(item.fit.names)
        for block, pull, noise in zip(
            item.blocks, item.pulls(), item.noise.covariances, strict=True
        ):
            own = root(noise).T
            wide = np.zeros((len(own), len(solution.joint.labels)))
            wide[:, start:end] = own @ pull.T
            factors.append(wide[:, there])
            drawn += len(own) * [_test(reduction, solution.groups[group][block.run])]
        start = end
    return Source(
        title=NOISE, gum="A", acts="precision", factors=np.concatenate(factors), drawn=tuple(drawn)
    )


def _pushed(reduction: Reduction, there: Sequence[int]) -> list[Source]:
    """The sources behind the pushes; those that change nothing are left out.

    What is not stated under ``[uncertainty]`` is the numerical uncertainty of ``[cfd]``.
    """
    stated = reduction.campaign.uncertainty
    pushes: dict[TypeB | str, list[Push]] = {}
    for push in reduction.solution.joint.pushes:
        pushes.setdefault(push.source, []).append(push)
    found = []
    for source, own in pushes.items():
        factors = np.stack([push.column[there] for push in own])
        if not factors.any():
            continue
        drawn = tuple(_test(reduction, push.run) for push in own if push.run is not None)
        found.append(
            Source(title=SCATTER[source], gum="A", acts="precision", factors=factors, drawn=drawn)
            if isinstance(source, str)
            else Source(
                title=source.title if source in stated else f"{NUMERICAL}: {source.kind.channel}",
                gum="B",
                acts="bias" if source.shared else "precision",
                factors=factors,
                common=source.common,
                drawn=drawn,
            )
        )
    return found


def _test(reduction: Reduction, run: int) -> str:
    return reduction.rows[run].result.run.test


def not_stated(reduction: Reduction) -> tuple[str, ...]:
    """What acts on the runs of a reduction and nobody stated, in words."""
    stated = [change.source for change in reduction.sensitivities[0]]
    found = []
    for known in TypeB.STATABLE.values():
        for relative in (False, True) if known.of == "gauge" else (False,):
            source = TypeB(name=known.name, std=STEP, relative=relative, shared=True)
            alike = [
                item
                for item in stated
                if item.name == known.name
                and (item.shared or not known.zero)
                and (known.of != "gauge" or (item.shared and item.relative == relative))
            ]
            if not alike and _felt(source, reduction):
                told = known.of == "gauge" or known.zero
                found.append(source.title if told else known.title)
    return tuple(found)


def _felt(source: TypeB, reduction: Reduction) -> bool:
    """Whether an error of a source changes the equations of any run."""
    rig = reduction.campaign.rig
    for rows in reduction.rows:
        run = rows.result.run
        if not acts(source, run, tuple(rows.force)) or not run.has_nominal:
            continue
        change = sensitivity(
            rows, source, reduction.campaign, rig, rows.names, reduction.convention
        )
        for channel in set(rows.force) & set(rows.design):
            size = np.abs(np.nan_to_num(rows.design[channel])).max(initial=0.0)
            moved = np.abs(np.nan_to_num(change.design[channel])).max(initial=0.0)
            if moved > ROUNDING * size or np.nan_to_num(change.force[channel]).any():
                return True
    return False


# Which runs, tests and sources of uncertainty make the uncertainty of a result.


def contributions(
    reduction: Reduction, slopes: Mapping[str, float], *, Fn: float | None = None
) -> pd.DataFrame:
    """Share of each test type and of each shared uncertainty in the variance of a result.

    Parameters
    ----------
    reduction : Reduction
        The reduced tests.
    slopes : mapping of str to float
        Change of the result per unit of each derivative, such as
        ``dict(zip(found.names, found.slopes["tactical_diameter"]))`` with `found` from
        `sensitivities`; derivatives without an entry do not count.
    Fn : float, optional
        Froude number of the result; needed where the table has several. Between two of them the
        derivatives are interpolated linearly.

    Returns
    -------
    DataFrame
        `derivative_budget` grouped by test: a row per test type (the noise of its runs and what
        each draws for itself: offset, gain, the setting of the drift angle) and per source that
        all runs share (such as a gauge), with the number of runs, the standard deviation of the
        result by it alone, and its share of the variance, the largest first. The shares sum to 1.

    Raises
    ------
    DataError
        If no derivative with a slope was determined.
    """
    budget, known = measured_budget(reduction), reduction.solution.Fn
    weights = _weights(known, Fn)
    carry = np.zeros((len(budget.results), 1))
    for place, item in enumerate(budget.results):
        weight = weights[0] if len(known) == 1 else weights[known == item.Fn][0]
        if math.isfinite(item.value):
            carry[place] = weight * slopes.get(item.name, 0.0)
    result = BudgetResult(name="", value=math.nan)
    carried = budget.carried(carry, [result], budget.subject).by_test()
    if not carried.std[0] > 0.0:
        raise DataError("None of these derivatives was determined with an uncertainty.")
    runs, every = _runs(reduction, weights), len(reduction.rows)
    frame = carried.to_pandas().set_index("source")
    frame["runs"] = [runs[item.title] if item.drawn else every for item in carried.sources]
    kept = frame.loc[frame["runs"] > 0, ["runs", "std", "share"]]
    return kept.sort_values("share", ascending=False)


def _runs(reduction: Reduction, weights: Array) -> Counter[str]:
    """How many runs of each kind of test count at a Froude number."""
    groups = reduction.solution.groups
    return Counter(
        reduction.rows[run].result.run.test
        for weight, runs in zip(weights.tolist(), groups, strict=True)
        for run in runs
        if weight > 0.0
    )


def _weights(known: Array, Fn: float | None) -> Array:
    """Share of each group of runs in the derivatives at a Froude number."""
    if len(known) == 1:
        return np.ones(1)
    if Fn is None:
        raise DataError("The table has several Froude numbers: say which.")
    place = np.interp(Fn, known, np.arange(len(known)))
    return np.maximum(0.0, 1.0 - np.abs(np.arange(len(known)) - place))
