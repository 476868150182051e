"""The budget of the derivatives of a reduction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.campaigns.motion.inertia import rig_of
from pmmkit.campaigns.motion.nominal import has_nominal
from pmmkit.campaigns.uncertainty import STATABLE, TypeB
from pmmkit.errors import DataError
from pmmkit.inference import root
from pmmkit.observations.equations import sensitivity
from pmmkit.observations.stated import acts
from pmmkit.reduction.budgets.budget import Budget, Result, Source
from pmmkit.reduction.joint import Push

if TYPE_CHECKING:
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
    (`pmmkit.observations.stated`); the regression, with its weights as they are, carries that to
    the derivatives. An error of all runs moves them together; one that each run draws counts run by
    run. Type A is the noise of the records with what repeats and residuals show beyond it, and
    the scatter between runs (Simonsen 2004, ITTC 7.5-02-06-04 and JCGM 100:2008, 5.1).
    """
    return replace(measured_budget(reduction), not_stated=not_stated(reduction), outside=OUTSIDE)


def measured_budget(reduction: Reduction) -> Budget:
    """The same without what was not stated, which takes longer to find than the budget itself.

    Parameters
    ----------
    reduction : Reduction
        The reduced tests.
    """
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
        Result(
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
    """What acts on the runs of a reduction and nobody stated, in words.

    Parameters
    ----------
    reduction : Reduction
        The reduced tests.
    """
    stated = [change.source for change in reduction.sensitivities[0]]
    found = []
    for known in STATABLE.values():
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
    rig = rig_of(reduction.campaign)
    for rows in reduction.rows:
        run = rows.result.run
        if not acts(source, run, tuple(rows.force)) or not has_nominal(run):
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
