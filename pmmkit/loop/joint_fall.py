"""How the errors of several campaigns fall with each effect that is added."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import TYPE_CHECKING

from pmmkit.loop.evidence import BASE, Fall
from pmmkit.models.step import Step
from pmmkit.presentation import Described, Grid, Group, Section, counted

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class JointFall(Described):
    """How the errors of each campaign fall with each step.

    Parameters
    ----------
    added : tuple of Step
        In the order in which they were added.
    taken : mapping of str to tuple of bool
        By campaign, whether it was asked for each of them.
    falls : mapping of str to Fall
        By campaign, over the steps that it was asked for.
    """

    added: tuple[Step, ...]
    taken: Mapping[str, tuple[bool, ...]]
    falls: Mapping[str, Fall]

    @property
    def steps(self) -> tuple[str, ...]:
        """``base``, then the effects in the order in which they were added, a fault with the
        campaign that has it."""
        return (
            BASE,
            *(f"{x.effect} ({x.campaign})" if x.campaign else x.effect for x in self.added),
        )

    @property
    def errors(self) -> tuple[Mapping[str, float], ...]:
        """After each step, by campaign."""
        after = self.by_campaign
        return tuple({k: x[i] for k, x in after.items()} for i in range(len(self.steps)))

    @property
    def totals(self) -> tuple[float, ...]:
        """Those of the first campaign [`unit`]."""
        return tuple(next(iter(self.by_campaign.values())))

    @property
    def unit(self) -> str:
        """Of `totals`."""
        return next(iter(self.falls.values())).unit

    @property
    def of(self) -> str:
        """What `totals` are errors of."""
        return next(iter(self.falls.values())).of

    @property
    def by_campaign(self) -> Mapping[str, list[float]]:
        """The error of each campaign after every step; one that it is not asked for leaves it."""
        return {name: self._after(name) for name in self.falls}

    @property
    def useless(self) -> tuple[str, ...]:
        """Steps that lower the error of no campaign."""
        return tuple(
            name
            for number, (name, step) in enumerate(zip(self.steps[1:], self.added, strict=True))
            if all(
                step.effect in own.useless
                for of, own in self.falls.items()
                if self.taken[of][number]
            )
        )

    @property
    def how(self) -> str:
        """What was left out, and what the numbers are, in a sentence."""
        return " ".join(f"{name}: {own.how}" for name, own in self.falls.items())

    def table(self) -> Grid:
        """A row per step, a column per campaign; blank where a campaign is not asked for a step."""
        rows = []
        for number, step in enumerate(self.steps):
            cells = [
                f"{after[number]:.3g}" if number == 0 or self.taken[name][number - 1] else ""
                for name, after in self.by_campaign.items()
            ]
            rows.append([f"+ {step}" if number else step, *cells])
        head = [f"{name}: {own.of} [{own.unit}]" for name, own in self.falls.items()]
        return Grid(head=["after", *head], groups=[Group(rows=rows)])

    def remarks(self) -> list[str]:
        """Of each campaign."""
        return [f"{name}: {text}" for name, own in self.falls.items() for text in own.remarks()]

    def plot(self) -> Figure:
        """Errors after each step, a panel for each campaign."""
        from pmmkit.plotting.records import waterfall

        return waterfall(
            self.steps,
            {
                (f"{name}: {self.falls[name].of}", self.falls[name].unit): values
                for name, values in self.by_campaign.items()
            },
        )

    def to_pandas(self) -> pd.DataFrame:
        """The errors of each campaign, with its name; what one does not tell is NaN."""
        import pandas as pd

        found = [own.to_pandas().assign(campaign=name) for name, own in self.falls.items()]
        return pd.concat(found, ignore_index=True)

    def _after(self, name: str) -> list[float]:
        own = self.falls[name].totals
        return [own[count] for count in accumulate(self.taken[name], initial=0)]

    def _headline(self) -> str:
        ends = [
            f"{name} {' to '.join(dict.fromkeys(f'{x:.3g}' for x in (own[0], own[-1])))} "
            f"{self.falls[name].unit}"
            for name, own in self.by_campaign.items()
        ]
        return f"{', '.join(ends)} after {counted(len(self.added), 'step')}"

    def _sections(self) -> Sequence[Section]:
        said = [Section(points=self.remarks())] if self.remarks() else []
        return [Section(title="Error of what is left out of the fit", tables=[self.table()]), *said]
