"""What a method of reduction is, what it is given, and what it gives."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

from pmmkit.campaigns.run import Campaign
from pmmkit.conventions import Convention
from pmmkit.inference import Consistency
from pmmkit.numerics import Array
from pmmkit.observations.equations import Rows, Sensitivity
from pmmkit.observations.histories import History
from pmmkit.presentation import Described, Section
from pmmkit.reduction.derivatives import Columns
from pmmkit.reduction.estimate import ChannelFit
from pmmkit.reduction.methods.over_time import OverTime, joined
from pmmkit.reduction.solve import Solution, to_table
from pmmkit.tables import DerivativeTable


@dataclass(frozen=True, kw_only=True, eq=False)
class Evidence:
    """What every method starts from: the runs, and what the global regression knows of them.

    Parameters
    ----------
    campaign : Campaign
        The tests.
    convention : Convention
        Meaning of the derivatives.
    columns : Columns
        The derivatives asked for.
    solution : Solution
        The global regression. Its groups, the noise of its blocks and their errors private to
        runs (`ChannelFit.noise`, `ChannelFit.private`) are those of every method.
    table : DerivativeTable
        Its derivatives.
    rows : tuple of Rows
        Means and harmonics of each run.
    cycles : tuple of float
        Whole cycles behind the harmonics of the regression over those behind `rows`, run by run.
    sensitivities : tuple of tuple of Sensitivity
        How the equations change with each stated uncertainty.
    histories : tuple of History
        Each run over time; empty where no method that was asked for needs them.
    channels : tuple of (int, OverTime)
        The equations over time, with their Froude group; the terms that the regression
        determines come first, then those of the library.
    """

    campaign: Campaign
    convention: Convention
    columns: Columns
    solution: Solution
    table: DerivativeTable
    rows: tuple[Rows, ...]
    cycles: tuple[float, ...]
    sensitivities: tuple[tuple[Sensitivity, ...], ...]
    histories: tuple[History, ...] = ()
    channels: tuple[tuple[int, OverTime], ...] = ()

    def over_time(self, fits: Iterable[tuple[int, ChannelFit]]) -> Solution:
        """Fits of `channels` as a solution, with the uncertainties that runs share."""
        return joined(self.solution, fits, self.sensitivities, self.histories)

    def tabled(
        self, solution: Solution, method: str, columns: Columns | None = None
    ) -> DerivativeTable:
        """A solution as a table."""
        return to_table(
            solution, columns or self.columns, self.campaign, self.convention, method=method
        )


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Estimate(Described):
    """Derivatives by one method.

    Parameters
    ----------
    method : str
        Its name.
    table : DerivativeTable
        The derivatives with their intervals.
    notes : tuple of str
        What the method has to say.
    shares : mapping of str to array (k,)
        Of a method that chooses terms: in which part of the bags of runs each was taken, by
        Froude number; NaN where it was not looked for.
    same_terms : DerivativeTable, optional
        Of a method that chooses terms: what it gives with the terms of the regression.
    tests : Consistency, optional
        Of a filter: the tests of its innovations.
    seconds : float
        It took, beside what all methods share.
    """

    method: str
    table: DerivativeTable
    notes: tuple[str, ...] = ()
    shares: Mapping[str, Array] = field(default_factory=lambda: MappingProxyType({}))
    same_terms: DerivativeTable | None = None
    tests: Consistency | None = None
    seconds: float = 0.0

    def _headline(self) -> str:
        return f"by {self.method}: {self.table._headline()}"

    def _sections(self) -> Sequence[Section]:
        kept = {
            name: ", ".join("–" if math.isnan(x) else f"{x:.0%}" for x in share)
            for name, share in self.shares.items()
        }
        taken = Section(
            title="Part of the bags of runs in which a term was taken",
            points=[f"{name}: {text}" for name, text in kept.items()],
        )
        return [
            Section(title="Derivatives", tables=[self.table.grid()]),
            *([taken] if kept else []),
            *([Section(title="Notes", points=self.notes)] if self.notes else []),
        ]


@dataclass(frozen=True, kw_only=True)
class Method:
    """A way from captive runs to derivatives.

    Parameters
    ----------
    name : str
        What a user asks for.
    text : str
        What it does, in a line.
    estimate : callable
        From `Evidence` to an `Estimate`.
    over_time : bool
        Whether it needs the runs over time.
    """

    name: str
    text: str
    estimate: Callable[[Evidence], Estimate]
    over_time: bool = False
