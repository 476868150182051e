"""What each run does to the derivatives, and whether it is at odds with the others."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.checks import CheckFinding
from pmmkit.numerics import Array
from pmmkit.observations.equations import Rows, Sensitivity
from pmmkit.presentation import at_froude
from pmmkit.reduction.between_runs import drawn, size_of
from pmmkit.reduction.derivatives import Columns
from pmmkit.reduction.estimate import ChannelFit
from pmmkit.reduction.solve import Solution, solve
from pmmkit.tables.table import CONFIDENCE

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure


SUSPICIOUS: Final = 0.01
"""Chance from which a run is judged again, by the others alone."""
SUSPECTS: Final = 3
"""Runs that are judged so at once."""
MOST: Final = 3
"""Runs that can be at odds; of more, nobody could say which side is right."""
AT_ODDS: Final = 0.01
"""Chance, over all runs and channels of a campaign, below which a run is at odds with the rest."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Influence:
    """One run in one channel.

    Parameters
    ----------
    run, channel : str
        Which.
    Fn : float
        Froude number of the fit; NaN for one over all speeds.
    names : tuple of str
        The derivatives of the channel.
    shift : array (p,)
        Their change by the run: with it less without it; NaN where the others do not determine
        a derivative.
    share : array (p,)
        The same over half of the 95 % interval.
    departure : float
        Root mean square of what the others predict of it less what it measured, over what noise
        and scatter between runs allow (externally studentised).
    chance : float
        Probability of so much, for one run.
    """

    run: str
    channel: str
    Fn: float
    names: tuple[str, ...]
    shift: Array
    share: Array
    departure: float
    chance: float

    def __repr__(self) -> str:
        most = float(np.nanmax(np.abs(self.share), initial=0.0))
        return (
            f"<Influence of {self.run} in {self.channel}{at_froude(self.Fn)}: departs "
            f"{self.departure:.2g} times, moves a derivative by {most:.2g} half intervals>"
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class Influences:
    """What each run does to each derivative.

    Parameters
    ----------
    items : tuple of Influence
        A run in a channel each, in the order of the campaign.
    odd : tuple of Influence
        Those at odds with the other runs beyond chance.
    """

    items: tuple[Influence, ...]
    odd: tuple[Influence, ...]

    def __repr__(self) -> str:
        return f"<Influences of {len({x.run for x in self.items})} runs, {len(self.odd)} at odds>"

    def strong(self) -> tuple[tuple[Influence, str, float], ...]:
        """Runs that move a derivative by more than half of its interval, the strongest first."""
        found = [
            (item, name, float(share))
            for item in self.items
            for name, share in zip(item.names, item.share, strict=True)
            if abs(share) > 1.0
        ]
        return tuple(sorted(found, key=lambda entry: -abs(entry[2])))

    def to_pandas(self) -> pd.DataFrame:
        """A row per run and derivative: run, channel, Fn, derivative, shift, share, departure,
        chance."""
        import pandas as pd

        return pd.DataFrame(
            [
                {
                    "run": item.run,
                    "channel": item.channel,
                    "Fn": item.Fn,
                    "derivative": name,
                    "shift": float(shift),
                    "share": float(share),
                    "departure": item.departure,
                    "chance": item.chance,
                }
                for item in self.items
                for name, shift, share in zip(item.names, item.shift, item.share, strict=True)
            ]
        )

    def plot(self) -> Figure:
        """Runs against derivatives, coloured by how far each run moves each."""
        from pmmkit.plotting.derivatives import influence_map

        runs = list(dict.fromkeys(item.run for item in self.items))
        names = list(dict.fromkeys(name for item in self.items for name in item.names))
        grid = np.full((len(runs), len(names)), np.nan)
        for item in self.items:
            at = runs.index(item.run), [names.index(name) for name in item.names]
            grid[at] = np.where(
                np.abs(np.nan_to_num(item.share)) >= np.abs(np.nan_to_num(grid[at])),
                item.share,
                grid[at],
            )
        figure: Figure = influence_map(grid, runs, names, {item.run for item in self.odd})
        return figure


def influences(
    solution: Solution,
    rows: Sequence[Rows],
    sensitivities: Sequence[Sequence[Sensitivity]],
    columns: Columns,
) -> Influences:
    """What each run does to the derivatives that were fitted.

    Parameters
    ----------
    solution : Solution
        The fits.
    rows, sensitivities, columns
        What was fitted, as for `solve`.

    Returns
    -------
    Influences

    Notes
    -----
    With whitened rows A, gain G and residual e of a run, the values without it are
    θ − G(I − AG)⁻¹e (Cook and Weisberg 1982), and the misfit of what the others predict of it is
    eᵀ(I − AG)⁻¹e. A bad run makes the scatter of all look larger, so that the runs that depart
    most are judged again by values and scatter of the others alone.
    """
    items = _internal(solution, rows)
    limit = AT_ODDS / max(len(items), 1)
    odd: list[Influence] = []
    rest = items
    for _ in range(MOST):
        aside = {one.run for one in odd}
        by_chance = sorted(rest, key=lambda one: one.chance)
        suspects = [
            run
            for run in dict.fromkeys(one.run for one in by_chance if one.chance < SUSPICIOUS)
            if run not in aside
        ]
        judged = {
            run: _by_the_others({run, *aside}, run, solution, rows, sensitivities, columns)
            for run in suspects[:SUSPECTS]
        }
        worst = min(
            judged,
            key=lambda run: min((c for _, c in judged[run].values()), default=1.0),
            default="",
        )
        beyond = {key: x for key, x in judged.get(worst, {}).items() if x[1] < limit}
        if not beyond:
            break
        odd += [
            replace(
                one, departure=beyond[one.Fn, one.channel][0], chance=beyond[one.Fn, one.channel][1]
            )
            for one in items
            if one.run == worst and (one.Fn, one.channel) in beyond
        ]
        without = _without({worst, *aside}, solution, rows)
        rest = _internal(
            solve(rows, sensitivities, columns, without, solution.between.unknown()), rows
        )
    return Influences(items=items, odd=tuple(odd))


def _internal(solution: Solution, rows: Sequence[Rows]) -> tuple[Influence, ...]:
    """Each run against the others, with the scatter of all."""
    half = _half_widths(solution)
    return tuple(
        one for group, item in solution.fits for one in _of_fit(solution, group, item, half, rows)
    )


def _without(
    aside: Collection[str], solution: Solution, rows: Sequence[Rows]
) -> list[tuple[float, list[int]]]:
    """Froude numbers with their runs, some left out."""
    return [
        (float(Fn), [place for place in members if rows[place].result.run.id not in aside])
        for Fn, members in zip(solution.Fn, solution.groups, strict=True)
    ]


def _by_the_others(
    aside: Collection[str],
    run: str,
    solution: Solution,
    rows: Sequence[Rows],
    sensitivities: Sequence[Sequence[Sensitivity]],
    columns: Columns,
) -> dict[tuple[float, str], tuple[float, float]]:
    """Departure and chance of a run in each channel, by values and scatter of the other runs."""
    from scipy.special import fdtrc

    between = solution.between.unknown()
    home = [
        number
        for number, members in enumerate(solution.groups)
        if any(rows[place].result.run.id == run for place in members)
    ]
    without = _without(aside, solution, rows)
    others = solve(rows, sensitivities, columns, [without[number] for number in home], between)
    place_of = {label: place for place, label in enumerate(others.joint.labels)}
    scatter = others.between.scatter
    found: dict[tuple[float, str], tuple[float, float]] = {}
    for group, item in solution.fits:
        if group not in home:
            continue
        members = solution.groups[group]
        mine = [
            n
            for n, block in enumerate(item.blocks)
            if rows[members[block.run]].result.run.id == run
        ]
        known = [place_of.get((home.index(group), name), -1) for name in item.fit.names]
        places = [place for place in known if place >= 0]
        if not mine or not places or scatter is None or item.channel not in scatter.weights:
            continue
        value = np.array([others.joint.value[place] if place >= 0 else 0.0 for place in known])
        covariance = others.joint.covariance[np.ix_(places, places)]
        if not np.all(np.isfinite(value)) or not np.all(np.isfinite(covariance)):
            continue
        block = item.blocks[mine[0]]
        design = block.design[:, item.chosen]
        rest = block.rows - design @ value
        draw = drawn(
            item.channel,
            [block],
            dict(zip(item.fit.names, value.tolist(), strict=True)),
            [rest],
            [rows[place] for place in members],
            [sensitivities[place] for place in members],
            solution.between.of(members),
            size_of(item.blocks, item.channel, solution.between.of(members)),
        )
        there = design[:, [place >= 0 for place in known]]
        base = (
            item.noise[mine[0]] / max(item.scale, 1.0)
            if np.isfinite(item.scale)
            else item.noise[mine[0]]
        )
        base = base + there @ covariance @ there.T + draw.stated[0] @ draw.stated[0].T
        nodes, weight = scatter.weighed(item.channel)
        own = draw.own[0] * nodes[:, None, :]
        allowed = base + own @ np.swapaxes(own, 1, 2)
        squared = np.einsum("m,gmn,n->g", rest, np.linalg.inv(allowed), rest) / len(rest)
        freedom = min(float(item.noise_dof[mine[0]]), 1e6)
        chance = float(weight @ fdtrc(len(rest), max(freedom, 1.0), np.maximum(squared, 0.0)))
        found[float(solution.Fn[group]), item.channel] = (
            float(np.sqrt(max(weight @ squared, 0.0))),
            chance,
        )
    return found


def at_odds(found: Influences, *, weighed: bool = False) -> tuple[CheckFinding, ...]:
    """Runs at odds with the others, as the checks say it.

    Parameters
    ----------
    found : Influences
        What was found.
    weighed : bool
        Whether they were given less weight.
    """
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
        for one in found.odd
    )


def weighed_down(
    rows: Sequence[Rows], solution: Solution, odd: Sequence[Influence]
) -> tuple[Rows, ...]:
    """The rows with less weight for runs at odds: the variance that explains their departure.

    Parameters
    ----------
    rows : sequence of Rows
        The equations of the runs.
    solution : Solution
        Of all runs at full weight.
    odd : sequence of Influence
        Runs and channels that are at odds.
    """
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
            wide = departure**2 * (item.noise[number] + columns @ columns.T)
            size = len(block.keep)
            covariance = np.eye(size) * float(np.max(np.diagonal(wide)))
            covariance[np.ix_(block.keep, block.keep)] = wide
            found[place] = replace(
                found[place],
                result=replace(result, covariance={**result.covariance, item.channel: covariance}),
            )
    return tuple(found)


def _half_widths(solution: Solution) -> dict[tuple[int, str], float]:
    from scipy.special import stdtrit

    joint = solution.joint
    dof = np.where(np.isinf(joint.dof), 1e9, joint.dof)
    half = stdtrit(dof, (1 + CONFIDENCE) / 2) * np.sqrt(np.diagonal(joint.covariance))
    return dict(zip(joint.labels, half.tolist(), strict=True))


def _of_fit(
    solution: Solution,
    group: int,
    item: ChannelFit,
    half: dict[tuple[int, str], float],
    rows: Sequence[Rows],
) -> list[Influence]:
    from scipy.special import fdtrc

    sizes = [len(block.rows) for block in item.blocks]
    edges = np.cumsum([0, *sizes])
    width = np.array([half[group, name] for name in item.fit.names])
    parts, misfits, total = [], [], 0.0
    for number, (block, white) in enumerate(zip(item.blocks, item.whiteners, strict=True)):
        gain = item.fit.gain[:, edges[number] : edges[number + 1]]
        hat = white @ block.design[:, item.chosen] @ gain
        inner = np.eye(len(hat)) - hat
        rest = white @ item.residual[number]
        alone = np.linalg.pinv(inner, rcond=1e-6) @ rest
        parts.append((gain @ alone, _lost(inner)))
        misfits.append(float(rest @ alone))
        total += float(np.sum(rest**2))
    spread = item.width.dof[np.isfinite(item.width.dof)]
    known = float(np.median(spread)) if len(spread) else np.inf
    found = []
    for number, block in enumerate(item.blocks):
        shift, lost = parts[number]
        run = rows[solution.groups[group][block.run]].result.run.id
        freedom = sizes[number]
        others = item.freedom - freedom
        level = max((total - misfits[number]) / others, 1.0) if others > 0 else 1.0
        squared = misfits[number] / freedom / level
        found.append(
            Influence(
                run=run,
                channel=item.channel,
                Fn=float(solution.Fn[group]),
                names=item.fit.names,
                shift=np.where(lost, np.nan, shift),
                share=np.where(lost, np.nan, shift) / width,
                departure=float(np.sqrt(max(squared, 0.0))),
                chance=float(fdtrc(freedom, min(max(others, 1), known), max(squared, 0.0))),
            )
        )
    return found


def _lost(inner: Array) -> bool:
    """Whether the others do not determine what the run does."""
    return bool(np.linalg.svd(inner, compute_uv=False)[-1] < 1e-6)
