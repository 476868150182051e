"""A budget of uncertainty: what each source adds to the variance of each result."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, Literal, cast

import numpy as np

from pmmkit.base import DataError, UnknownNameError, did_you_mean
from pmmkit.inference import Propagated
from pmmkit.numerics import Array
from pmmkit.presentation import Described, Grid, Group, Section, at_froude, counted, number

if TYPE_CHECKING:
    import pandas as pd

    from pmmkit.plotting import Figure

Gum = Literal["A", "B", "A, B"]
Acts = Literal["bias", "precision"]
BESIDE: Final = 6
"""Results that stand side by side with all their sources."""
NAMED: Final = 3
"""Sources that are named of a result where there are more results."""
SEEN: Final = 0.01
"""Share from which on they are."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Source:
    """One source of uncertainty.

    `gum`: evaluated from the measurements, or stated (JCGM 100:2008, 3.3.4), or both. `acts`:
    the same error in all runs, or one that each run draws for itself. `factors (q, n)`: change
    of each result by each of q independent errors of one standard deviation. `common`: cause
    that it shares with other sources, of which the errors are then the same; empty for none.
    `tested`: whether it is one of the tests; else of what was estimated or lent beside them.
    `drawn`: of each of the q errors the name of the kind of test whose run draws it; empty
    where all runs have the same.
    """

    title: str
    gum: Gum
    acts: Acts
    factors: Array
    common: str = ""
    tested: bool = True
    drawn: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class BudgetResult:
    """What a budget is of.

    `name`: a derivative or a metric. `Fn`: Froude number; NaN for a set over all speeds.
    """

    name: str
    value: float
    unit: str = "-"
    Fn: float = math.nan


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Budget(Described):
    """Shares of each source in the variance of each result; they add up to one.

    Parameters
    ----------
    subject : str
        What it is a budget of.
    results : tuple of BudgetResult
        Derivatives or metrics.
    sources : tuple of Source
        What makes their uncertainty.
    not_stated : tuple of str
        What nobody stated, so that it is not in the budget, in words.
    outside : tuple of str
        What no statement covers.

    Notes
    -----
    Sources are independent but for those of one common cause; shares are those of `Propagated`.
    """

    subject: str
    results: tuple[BudgetResult, ...]
    sources: tuple[Source, ...]
    not_stated: tuple[str, ...] = ()
    outside: tuple[str, ...] = ()

    @property
    def propagated(self) -> Propagated:
        """What the sources do to the results."""
        return Propagated(
            factors=tuple(source.factors for source in self.sources),
            causes=tuple(source.common for source in self.sources),
        )

    @property
    def std(self) -> Array:
        """Combined standard uncertainty of each result, array (results,)."""
        return self.propagated.std

    @property
    def shares(self) -> Array:
        """Of each source in the variance of each result, array (sources, results)."""
        return self.propagated.shares

    def of(self, *names: str, Fn: float | None = None) -> Budget:
        """The budget of some results alone.

        Parameters
        ----------
        *names : str
            Derivatives or metrics; all by default.
        Fn : float, optional
            The nearest Froude number alone.

        Raises
        ------
        UnknownNameError
            If there is no such result.
        """
        known = dict.fromkeys(item.name for item in self.results)
        for name in names:
            if name not in known:
                raise UnknownNameError(
                    f"The budget has no {name!r}{did_you_mean(name, known) or '.'} It has "
                    f"{', '.join(known)}."
                )
        order = names or tuple(known)
        near = _nearest({item.Fn for item in self.results}, Fn)
        chosen = [
            place
            for name in order
            for place, item in enumerate(self.results)
            if item.name == name and (Fn is None or item.Fn == near)
        ]
        return replace(
            self,
            results=tuple(self.results[place] for place in chosen),
            sources=tuple(
                replace(source, factors=source.factors[:, chosen]) for source in self.sources
            ),
        )

    def of_tests(self) -> Budget:
        """The budget as if what was not tested of a ship were known."""
        return replace(
            self,
            subject=f"{self.subject}, as if what was not tested were known",
            sources=tuple(item for item in self.sources if item.tested),
        )

    def by_test(self) -> Budget:
        """The same variances with what single runs draw put together by kind of test.

        Noise, scatter and the settings of each run are told by the kind of test, under its name;
        sources of all runs stay as they are. What the budget sums to does not change.
        """
        drawn: dict[str, list[Array]] = {}
        evaluated: dict[str, set[str]] = {}
        for source in self.sources:
            for test in dict.fromkeys(source.drawn):
                own = np.array([name == test for name in source.drawn])
                drawn.setdefault(test, []).append(source.factors[own])
                evaluated.setdefault(test, set()).add(source.gum)
        return replace(
            self,
            sources=(
                *(
                    Source(
                        title=test,
                        gum=cast(Gum, ", ".join(sorted(evaluated[test]))),
                        acts="precision",
                        factors=np.concatenate(factors),
                        drawn=(test,) * sum(map(len, factors)),
                    )
                    for test, factors in drawn.items()
                ),
                *(source for source in self.sources if not source.drawn),
            ),
        )

    def carried(self, carry: Array, results: Sequence[BudgetResult], subject: str) -> Budget:
        """The budget of other results, which are linear in these.

        Parameters
        ----------
        carry : array (n, m)
            Change of each new result by each of these.
        results : sequence of m BudgetResult
            What they are.
        subject : str
            What it is a budget of.
        """
        moved = self.propagated.carried(carry.T).factors
        return replace(
            self,
            subject=subject,
            results=tuple(results),
            sources=tuple(
                replace(source, factors=factors)
                for source, factors in zip(self.sources, moved, strict=True)
            ),
        )

    def to_pandas(self) -> pd.DataFrame:
        """A row per result and source: GUM type, bias or precision, u [unit of the result], share.

        `std` is the standard uncertainty by the source alone, `variance` what it adds to the
        variance of the result, and `share` that over the whole.
        """
        import pandas as pd

        found = self.propagated
        variances, shares, std, alone = found.variances, found.shares, found.std, found.alone
        rows = [
            {
                "result": result.name,
                "Fn": result.Fn,
                "value": result.value,
                "unit": result.unit,
                "combined_std": std[column],
                "source": source.title,
                "gum": source.gum,
                "acts_as": source.acts,
                "common": source.common,
                "std": alone[row, column],
                "variance": variances[row, column],
                "share": shares[row, column],
            }
            for column, result in enumerate(self.results)
            for row, source in enumerate(self.sources)
        ]
        return pd.DataFrame(rows)

    def grid(self) -> Grid:
        """All sources of the results, a column a result; the largest first."""
        shares, std = self.shares, self.std
        rows = [
            [
                self.sources[row].title,
                self.sources[row].gum,
                self.sources[row].acts,
                *(f"{100 * share:.1f} %" for share in shares[row]),
            ]
            for row in self._order()
        ]
        value = np.array([item.value for item in self.results])
        total = [
            ["together", "", "", *(f"{100 * x:.1f} %" for x in shares.sum(axis=0))],
            ["value", "", "", *(number(x) for x in value)],
            ["standard uncertainty", "", "", *(number(x, 3) for x in std)],
            [
                "of the value",
                "",
                "",
                *(_of_the_value(x, y) for x, y in zip(std, value, strict=True)),
            ],
        ]
        return Grid(
            head=["source", "GUM", "acts as", *(_heading(item) for item in self.results)],
            groups=[Group(rows=rows), Group(rows=total)],
        )

    def summary(self) -> Grid:
        """A row a result: value, standard uncertainty, and where most of it comes from."""
        shares, std = self.shares, self.std
        groups: dict[str, list[list[str]]] = {}
        for column, item in enumerate(self.results):
            first = np.argsort(-np.abs(shares[:, column]), kind="stable")[:NAMED]
            most = ", ".join(
                f"{self.sources[row].title} {100 * shares[row, column]:.0f} %"
                for row in first
                if abs(shares[row, column]) >= SEEN
            )
            groups.setdefault(_key(item), []).append(
                [
                    item.name,
                    number(item.value),
                    number(std[column], 3),
                    _of_the_value(std[column], item.value),
                    most,
                ]
            )
        return Grid(
            head=["", "value", "u", "u / value", "most of it"],
            groups=[Group(title=title, rows=rows) for title, rows in groups.items()],
            texts=(4,),
        )

    def plot(self) -> Figure:
        """Shares as stacked bars, a bar a result and a panel a Froude number."""
        from pmmkit.reduction.figures import stacked_shares

        if not self.results:
            raise DataError("The budget has no results to draw.")
        shares = self.shares
        order = self._order()
        panels = {}
        for Fn in dict.fromkeys(_key(item) for item in self.results):
            own = [place for place, item in enumerate(self.results) if _key(item) == Fn]
            panels[Fn] = ([self.results[place].name for place in own], shares[np.ix_(order, own)])
        return stacked_shares(panels, [self.sources[row].title for row in order])

    def _order(self) -> list[int]:
        """Places of the sources that count for anything, the largest on average first."""
        size = np.abs(self.shares).sum(axis=1)
        return [int(row) for row in np.argsort(-size, kind="stable") if size[row] > 0.0]

    def _headline(self) -> str:
        return f"of {self.subject}: {counted(len(self.sources), 'source')}"

    def _sections(self) -> Sequence[Section]:
        few = len(self.results) <= BESIDE
        table = self.grid() if few else self.summary()
        lists = [
            Section(title="Not stated, so not in the budget", points=self.not_stated),
            Section(title="Not covered by any statement", points=self.outside),
        ]
        return [Section(tables=[table]), *(item for item in lists if item.points)]


def beside(budgets: Sequence[Budget]) -> Budget:
    """Budgets of several results by the same sources as one."""
    known: dict[tuple[str, int], dict[int, Source]] = {}
    for place, budget in enumerate(budgets):
        count: dict[str, int] = {}
        for source in budget.sources:
            again = count[source.title] = count.get(source.title, -1) + 1
            known.setdefault((source.title, again), {})[place] = source
    sources = []
    for own in known.values():
        first = next(iter(own.values()))
        columns = [
            own[place].factors
            if place in own
            else np.zeros((len(first.factors), len(budget.results)))
            for place, budget in enumerate(budgets)
        ]
        sources.append(replace(first, factors=np.concatenate(columns, axis=1)))
    return replace(
        budgets[0],
        results=tuple(item for budget in budgets for item in budget.results),
        sources=tuple(sources),
    )


def _heading(item: BudgetResult) -> str:
    unit = "" if item.unit == "-" else f" [{item.unit}]"
    return f"{item.name}{unit}" if math.isnan(item.Fn) else f"{item.name}{unit}, {_key(item)}"


def _key(item: BudgetResult) -> str:
    return at_froude(item.Fn).strip().removeprefix("at ")


def _of_the_value(std: float, value: float) -> str:
    return f"{100 * std / abs(value):.1f} %" if value else ""


def _nearest(known: Collection[float], Fn: float | None) -> float:
    return math.nan if Fn is None else min(known, key=lambda x: abs(x - Fn))
