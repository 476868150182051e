"""Runs at odds with the others: found, told as checks tell it, weighed down."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.inference import RunEffects
from pmmkit.intake import CheckFinding
from pmmkit.numerics import Array
from pmmkit.reduction.between_runs import BetweenRuns, RunDraws, drawn, size_of
from pmmkit.reduction.derivatives import DerivativeNames
from pmmkit.reduction.estimate import ChannelFit
from pmmkit.reduction.influence import Influence, influences
from pmmkit.reduction.observations.equations import Rows, Sensitivity
from pmmkit.reduction.solve import Solution, solve

SUSPICIOUS: Final = 0.01
"""Chance from which a run is judged again, by the others alone."""
SUSPECTS: Final = 3
"""Runs that are judged so at once."""
MOST: Final = 3
"""Runs that can be at odds; of more, nobody could say which side is right."""
AT_ODDS: Final = 0.01
"""Chance, over all runs and channels of a campaign, below which a run is at odds with the rest."""
BEYOND_COUNTING: Final = 1e6
"""Degrees of freedom from which noise is known; F of infinitely many has no number."""


_Groups = tuple[tuple[int, tuple[int, ...]], ...]
"""Froude groups of a solution, each with the places of its runs."""
_Judgement = tuple[float, float]
"""How far a run departs in one channel, and the probability of so much, for one run."""


def runs_at_odds(
    found: Sequence[Influence],
    solution: Solution,
    rows: Sequence[Rows],
    sensitivities: Sequence[Sequence[Sensitivity]],
    columns: DerivativeNames,
) -> tuple[Influence, ...]:
    """Which runs depart from the others beyond chance, in which channel, and how far.

    Notes
    -----
    A bad run makes the scatter of all look larger, so that the runs that depart most are judged
    again by values and scatter of the others alone, and the rest anew without the worst.
    """

    # Those of one round; without pushes, which no judgement needs and a budget alone takes.
    @lru_cache(maxsize=SUSPECTS)
    def solved(groups: _Groups) -> Solution:
        members = [(float(solution.Fn[number]), runs) for number, runs in groups]
        unknown, near = solution.between.unknown(), solution.between.scatter
        made = solve(rows, sensitivities, columns, members, unknown, near=near)
        return replace(made, joint=replace(made.joint, pushes=()))

    limit = AT_ODDS / max(len(found), 1)
    odd: list[Influence] = []
    for _ in range(MOST):
        aside = {one.run for one in odd}
        rest = influences(solved(_without(aside, solution, rows)), rows) if aside else found
        judged = {
            run: _by_the_others({run, *aside}, run, solution, rows, sensitivities, solved)
            for run in _suspects(rest, aside)
        }
        worst = min(judged, key=lambda run: _least_chance(judged[run]), default="")
        beyond = {name: x for name, x in judged.get(worst, {}).items() if x[1] < limit}
        if not beyond:
            break
        odd += [
            replace(one, departure=own[0], chance=own[1])
            for one in found
            if one.run == worst and (own := beyond.get(one.channel))
        ]
    return tuple(odd)


def _suspects(found: Sequence[Influence], aside: Collection[str]) -> list[str]:
    """The runs that depart most, the least likely first."""
    by_chance = sorted(found, key=lambda one: one.chance)
    runs = dict.fromkeys(one.run for one in by_chance if one.chance < SUSPICIOUS)
    return [run for run in runs if run not in aside][:SUSPECTS]


def _least_chance(judged: Mapping[str, _Judgement]) -> float:
    return min((chance for _, chance in judged.values()), default=1.0)


def _without(aside: Collection[str], solution: Solution, rows: Sequence[Rows]) -> _Groups:
    """Froude groups with their runs, some left out."""
    return tuple(
        (group, tuple(place for place in members if rows[place].result.run.id not in aside))
        for group, members in enumerate(solution.groups)
    )


def _by_the_others(
    aside: Collection[str],
    run: str,
    solution: Solution,
    rows: Sequence[Rows],
    sensitivities: Sequence[Sequence[Sensitivity]],
    solved: Callable[[_Groups], Solution],
) -> dict[str, _Judgement]:
    """A run in each channel, judged by values and scatter of the runs that are not aside."""
    group, members = next(
        (number, members)
        for number, members in enumerate(solution.groups)
        if any(rows[place].result.run.id == run for place in members)
    )
    own = [rows[place] for place in members]
    changes = [sensitivities[place] for place in members]
    between = solution.between.of(members)
    without = _without(aside, solution, rows)
    if not without[group][1]:
        return {}  # nobody else was at this speed
    others = solved((without[group],))
    judged = {
        item.channel: _held_against(others, item, number, own, changes, between)
        for place, item in solution.fits
        if place == group and (number := _block_of(run, own, item)) is not None
    }
    return {channel: found for channel, found in judged.items() if found is not None}


def _held_against(
    others: Solution,
    item: ChannelFit,
    number: int,
    rows: Sequence[Rows],
    changes: Sequence[Sequence[Sensitivity]],
    between: BetweenRuns,
) -> _Judgement | None:
    """One block of a fit against the values of other runs; None where they do not say enough."""
    scatter = others.between.scatter
    prediction = _predicted(others, item.fit.names)
    if prediction is None or scatter is None or item.channel not in scatter.weights:
        return None
    block = item.blocks[number]
    value, _, _ = prediction
    rest = block.rows - block.design[:, item.chosen] @ value
    draw = drawn(
        item.channel,
        [block],
        dict(zip(item.fit.names, value.tolist(), strict=True)),
        [rest],
        rows,
        changes,
        between,
        size_of(item.blocks, item.channel, between),
    )
    nodes, weight = scatter.nodes[item.channel], scatter.weights[item.channel]
    allowed = _allowed(item, number, prediction, draw, nodes)
    return _judgement(rest, allowed, weight, float(item.noise.dof[number]))


def _block_of(run: str, members: Sequence[Rows], item: ChannelFit) -> int | None:
    """Which block of a fit holds the rows of a run, if any."""
    return next(
        (
            number
            for number, block in enumerate(item.blocks)
            if members[block.run].result.run.id == run
        ),
        None,
    )


_Prediction = tuple[Array, NDArray[np.bool_], Array]
"""Coefficients (p,) of a fit as other runs have them, zero where they do not have one; which they
have, and the covariance of those."""


def _predicted(others: Solution, names: Sequence[str]) -> _Prediction | None:
    """What other runs say of coefficients; None where they leave one that they have open."""
    place_of = {name: place for place, (_, name) in enumerate(others.joint.labels)}
    known = [place_of.get(name) for name in names]
    places = [place for place in known if place is not None]
    value = np.array([0.0 if place is None else others.joint.value[place] for place in known])
    covariance = others.joint.covariance[np.ix_(places, places)]
    if not places or not np.all(np.isfinite(value)) or not np.all(np.isfinite(covariance)):
        return None
    return value, np.array([place is not None for place in known]), covariance


def _allowed(
    item: ChannelFit, number: int, prediction: _Prediction, draw: RunDraws, nodes: Array
) -> Array:
    """Covariance of a run's departure from what others predict at each size of the scatter,
    array (g, m, m): noise, doubt of the prediction, stated uncertainties, and its own draw."""
    _, there, covariance = prediction
    noise = _as_sisters(item, number) * item.noise.covariances[number]
    known = item.blocks[number].design[:, item.chosen][:, there]
    base = noise + known @ covariance @ known.T + draw.stated[0] @ draw.stated[0].T
    own = draw.own[0] * RunEffects.per_column(nodes, len(known))[:, None, :]
    return base + own @ np.swapaxes(own, 1, 2)


def _as_sisters(item: ChannelFit, number: int) -> float:
    """By how much a run's noise a second is below the middle one of its channel, at least 1.

    Cycles are kept because they look alike, so that a short record can be quiet by luck: what
    only its quiet noise makes a departure is none.
    """
    own = item.blocks[number]
    level = [
        float(np.mean(np.diagonal(covariance))) * duration
        for block, covariance in zip(item.blocks, item.noise.covariances, strict=True)
        if block.dynamic == own.dynamic and np.isfinite(duration := block.duration)
    ]
    if not np.isfinite(own.duration):
        return 1.0
    its = float(np.mean(np.diagonal(item.noise.covariances[number]))) * own.duration
    return max(1.0, float(np.median(level)) / its)


def _judgement(rest: Array, allowed: Array, weight: Array, freedom: float) -> _Judgement:
    """How far a departure (m,) is from what is allowed (g, m, m), by F over the weighed sizes."""
    from scipy.special import fdtrc

    squared = np.einsum("m,gmn,n->g", rest, np.linalg.inv(allowed), rest) / len(rest)
    within = float(np.clip(freedom, 1.0, BEYOND_COUNTING))
    departure = float(np.sqrt(max(weight @ squared, 0.0)))
    return departure, float(weight @ fdtrc(len(rest), within, np.maximum(squared, 0.0)))


def at_odds(odd: Sequence[Influence], *, weighed: bool = False) -> tuple[CheckFinding, ...]:
    """Runs at odds with the others, as the checks say it."""
    done = "It counts with less weight." if weighed else "It counts with its full weight."
    return tuple(
        CheckFinding(
            check="odd_run",
            severity="warning",
            message=(
                f"{one.channel} departs by {one.departure:.1f} times what noise and scatter "
                f"between runs allow from what the other runs predict of it. {done}"
            ),
            runs=(one.run,),
            remedy=(
                "Look at its record, and exclude it in the campaign file with the reason, or "
                "reduce with odd runs weighed down."
            ),
            numbers={"departure": one.departure, "chance": one.chance},
            channels=(one.channel,),
        )
        for one in odd
    )


def weighed_down(
    rows: Sequence[Rows], solution: Solution, odd: Sequence[Influence]
) -> tuple[Rows, ...]:
    """The rows with less weight for runs at odds: the variance that explains their departure."""
    departures = {(one.run, one.channel): one.departure for one in odd}
    found = list(rows)
    for group, item in solution.fits:
        for number, block in enumerate(item.blocks):
            place = solution.groups[group][block.run]
            result = found[place].result
            departure = departures.get((result.run.id, item.channel))
            if departure is None or block.covariance is None:
                continue
            columns = item.width.columns[number]
            wide = departure**2 * (item.noise.covariances[number] + columns @ columns.T)
            size = len(block.keep)
            covariance = np.eye(size) * float(np.max(np.diagonal(wide)))
            covariance[np.ix_(block.keep, block.keep)] = wide
            found[place] = replace(
                found[place],
                result=replace(result, covariance={**result.covariance, item.channel: covariance}),
            )
    return tuple(found)
