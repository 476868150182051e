"""What a method of reduction is, what it is given, and what it gives."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from pmmkit.campaigns import Campaign
from pmmkit.conventions import Convention
from pmmkit.inference import Consistency, Selection
from pmmkit.models import DerivativeTable
from pmmkit.numerics import Array
from pmmkit.presentation import Described, Section
from pmmkit.reduction.derivatives import DerivativeNames
from pmmkit.reduction.estimate import ChannelFit
from pmmkit.reduction.methods.over_time import OverTime, joined
from pmmkit.reduction.observations.equations import Rows, Sensitivity
from pmmkit.reduction.observations.histories import RunHistory
from pmmkit.reduction.solve import Solution, to_table

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, kw_only=True, eq=False)
class MethodInputs:
    """What every method starts from: the runs, and what the global regression knows of them.

    `convention`: meaning of the derivatives. `columns`: the derivatives asked for. `solution`:
    the global regression. Its groups, the noise of its blocks and their errors private to runs
    (`ChannelFit.noise`, `ChannelFit.private`) are those of every method. `rows`: means and
    harmonics of each run. `cycles`: whole cycles behind the harmonics of the regression over
    those behind `rows`, run by run. `sensitivities`: how the equations change with each stated
    uncertainty. `histories`: each run over time; empty where no method that was asked for needs
    them. `channels`: the equations over time, with their Froude group; the terms that the
    regression determines come first, then those of the library.
    """

    campaign: Campaign
    convention: Convention
    columns: DerivativeNames
    solution: Solution
    table: DerivativeTable
    rows: tuple[Rows, ...]
    cycles: tuple[float, ...]
    sensitivities: tuple[tuple[Sensitivity, ...], ...]
    histories: tuple[RunHistory, ...] = ()
    channels: tuple[tuple[int, OverTime], ...] = ()

    def over_time(self, fits: Iterable[tuple[int, ChannelFit]]) -> Solution:
        """Fits of `channels` as a solution, with the uncertainties that runs share."""
        return joined(self.solution, fits, self.sensitivities, self.histories)

    def tabled(
        self, solution: Solution, method: str, columns: DerivativeNames | None = None
    ) -> DerivativeTable:
        """A solution as a table."""
        return to_table(
            solution, columns or self.columns, self.campaign, self.convention, method=method
        )


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Estimate(Described):
    """Derivatives by one method.

    `table`: the derivatives with their intervals. `notes`: what the method has to say. `shares
    (k,)`: of a method that chooses terms: in which part of the bags of runs each was taken, by
    Froude number; NaN where it was not looked for. `same_terms`: of a method that chooses
    terms: what it gives with the terms of the regression. `tests`: of a filter: the tests of
    its innovations. `seconds`: it took, beside what all methods share.
    """

    method: str
    table: DerivativeTable
    notes: tuple[str, ...] = ()
    shares: Mapping[str, Array] = field(default_factory=lambda: MappingProxyType({}))
    same_terms: DerivativeTable | None = None
    tests: Consistency | None = None
    seconds: float = 0.0

    def to_pandas(self) -> pd.DataFrame:
        """The table with the shares of its terms, those left out at the end."""
        import pandas as pd

        frame = self.table.to_pandas()
        if not self.shares:
            return frame
        rows = [
            {"Fn": Fn, "derivative": name, "share": share}
            for name, own in self.shares.items()
            for Fn, share in zip(self.table.Fn.tolist(), own.tolist(), strict=True)
        ]
        whole = frame.merge(pd.DataFrame(rows), how="outer", on=["Fn", "derivative"], sort=False)
        beside = np.where(whole["share"] < Selection.SHARE, "left out", "a zero offset")
        told = [f"{self.method}: {text}" for text in beside]
        whole["method"] = whole["method"].where(whole["method"].notna(), told)
        whole["runs"] = whole["runs"].fillna(0).astype(int)
        return whole

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

    `name`: what a user asks for. `text`: what it does, in a line. `estimate`: from
    `MethodInputs` to an `Estimate`. `over_time`: whether it needs the runs over time.
    """

    name: str
    text: str
    estimate: Callable[[MethodInputs], Estimate]
    over_time: bool = False
