"""What each run does to the derivatives, and how far it departs from the others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pmmkit.inference import of_others
from pmmkit.numerics import Array, coverage_factor
from pmmkit.presentation import at_froude
from pmmkit.reduction.estimate import ChannelFit, solvable
from pmmkit.reduction.observations.equations import Rows
from pmmkit.reduction.solve import Solution

if TYPE_CHECKING:
    import pandas as pd

    from pmmkit.plotting import Figure


@dataclass(frozen=True, kw_only=True, eq=False)
class Influence:
    """One run in one channel.

    `Fn`: Froude number of the fit; NaN for one over all speeds. `names`: the derivatives of the
    channel. `shift (p,)`: their change by the run: with it less without it; NaN where the
    others do not determine a derivative. `share (p,)`: the same over half of the 95 % interval.
    `departure`: root mean square of what the others predict of it less what it measured, over
    what noise and scatter between runs allow (externally studentised). `chance`: probability of
    so much, for one run.
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

    `items`: a run in a channel each, in the order of the campaign. `odd`: those at odds with
    the other runs beyond chance.
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
        from pmmkit.reduction.figures import influence_map

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
        return influence_map(grid, runs, names, {item.run for item in self.odd})


def influences(solution: Solution, rows: Sequence[Rows]) -> tuple[Influence, ...]:
    """What each run does to the derivatives that were fitted, by the scatter of all runs.

    Notes
    -----
    With whitened rows A, gain G and residual e of a run, the values without it are
    θ − G(I − AG)⁻¹e (Cook and Weisberg 1982), and the misfit of what the others predict of it is
    eᵀ(I − AG)⁻¹e.
    """
    half = _half_widths(solution)
    found: list[Influence] = []
    for group, item in solution.fits:
        with solvable(item.channel, float(solution.Fn[group])):
            found += _of_fit(solution, group, item, half, rows)
    return tuple(found)


def _half_widths(solution: Solution) -> dict[tuple[int, str], float]:
    joint = solution.joint
    half = coverage_factor(joint.dof) * np.sqrt(np.diagonal(joint.covariance))
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
        rest = white @ item.residual[number]
        inverse, determined = of_others(hat, hat=True)
        alone = inverse @ rest
        parts.append((gain @ alone, not determined))
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
