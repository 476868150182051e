"""Where methods disagree on the same runs, and why."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from pmmkit.models import DerivativeTable
from pmmkit.presentation import number
from pmmkit.reduction.methods.method import Estimate

Cause = Literal["structure", "excitation", "noise"]
APART: Final = 2.58
"""Standard deviations of their difference from which two families of tests disagree: several pairs
are looked at."""
EXPLAINED: Final = 0.5
"""Share of a difference that must vanish with the same terms for the terms to be its cause."""


@dataclass(frozen=True, kw_only=True)
class Difference:
    """A derivative for which a method and the regression differ.

    `Fn`: Froude number; NaN for all speeds. `value, basis`: by the method (zero where it leaves
    the term out) and by the regression. `sigma`: difference over the larger of the two standard
    uncertainties. `cause`: the methods' terms differ; families of tests differ; neither, the
    methods weigh the same noise otherwise. Empty for one that is not beyond the intervals.
    """

    method: str
    title: str
    derivative: str
    Fn: float
    value: float
    basis: float
    sigma: float
    cause: Cause | Literal[""] = ""
    why: str = ""

    @property
    def place(self) -> str:
        """At which Froude number, in words."""
        return "over all speeds" if math.isnan(self.Fn) else f"at Fn {self.Fn:.3f}"

    @property
    def sentence(self) -> str:
        """In words."""
        return (
            f"{self.derivative} {self.place}: {self.title} {number(self.value)}, regression "
            f"{number(self.basis)} ({self.sigma:+.1f} standard deviations). {self.why}"
        )


def differences(
    estimates: Mapping[str, Estimate], families: Mapping[str, DerivativeTable]
) -> tuple[Difference, ...]:
    """Derivatives for which neither 95 % interval holds the other method's value, and why.

    Where families of tests disagree the interval of the regression alone counts: the misfit widens
    the intervals of all methods. A term that sparse regression leaves out counts as zero.

    Notes
    -----
    The same runs stand behind all methods, so their errors are alike and small differences mean
    little: only those beyond the intervals are named. A cause is tried, not guessed: with the
    terms of the regression, does a method's difference vanish (structure)? Do the families of
    tests by themselves give different values (excitation)? If neither, the weights that the
    methods give to the same noise are left.
    """
    table = estimates["regression"].table
    low, high = table.interval()
    found = []
    for method, estimate in estimates.items():
        left, right = estimate.table.interval()
        for item in _every(method, estimate, table):
            row, column = item.row, table.index(item.derivative)
            if low[row, column] <= item.value <= high[row, column]:
                continue
            cause, why = _cause(table, families, estimate, item)
            if item.taken and cause != "excitation":
                own = estimate.table.index(item.derivative)
                if left[row, own] <= item.basis <= right[row, own]:
                    continue
            found.append(item.told(cause, why))
    return tuple(found)


def worst(estimates: Mapping[str, Estimate], method: str) -> Difference | None:
    """The derivative for which a method is farthest from the regression; None without any."""
    table = estimates["regression"].table
    every = [x for x in _every(method, estimates[method], table) if x.taken]
    return max(every, key=lambda item: abs(item.sigma)).told("", "") if every else None


@dataclass(frozen=True, kw_only=True)
class _Pair:
    """A value by a method and by the regression."""

    method: str
    title: str
    derivative: str
    row: int
    Fn: float
    value: float
    basis: float
    sigma: float
    taken: bool

    def told(self, cause: Cause | Literal[""], why: str) -> Difference:
        return Difference(
            method=self.method,
            title=self.title,
            derivative=self.derivative,
            Fn=self.Fn,
            value=self.value,
            basis=self.basis,
            sigma=self.sigma,
            cause=cause,
            why=why,
        )


def _every(method: str, estimate: Estimate, table: DerivativeTable) -> Iterator[_Pair]:
    """Values that method and regression both have; zero for a term that was left out."""
    if estimate.table is table:
        return
    own = estimate.table
    for row, Fn in enumerate(table.Fn.tolist()):
        for column, name in enumerate(table.names):
            basis, std = float(table.value[row, column]), float(table.std[row, column])
            value = float(own[name][row]) if name in own else math.nan
            taken = math.isfinite(value)
            share = estimate.shares.get(name)
            if not taken and share is not None and math.isfinite(share[row]):
                value = 0.0
            wide = std if not taken else float(np.fmax(std, own.std[row, own.index(name)]))
            if math.isfinite(value) and math.isfinite(basis) and wide > 0:
                yield _Pair(
                    method=method,
                    title=estimate.method,
                    derivative=name,
                    row=row,
                    Fn=Fn,
                    value=value,
                    basis=basis,
                    sigma=(value - basis) / wide,
                    taken=taken,
                )


def _cause(
    table: DerivativeTable, families: Mapping[str, DerivativeTable], estimate: Estimate, item: _Pair
) -> tuple[Cause, str]:
    if estimate.same_terms is not None:
        same = float(estimate.same_terms[item.derivative][item.row])
        if abs(same - item.basis) < EXPLAINED * abs(item.value - item.basis):
            return "structure", _terms(estimate, table, item)
    apart = _families(families, item)
    if apart:
        return "excitation", apart
    return (
        "noise",
        "Noise: terms are the same and families of tests agree; the methods weigh the noise "
        "of the runs otherwise.",
    )


def _terms(estimate: Estimate, table: DerivativeTable, item: _Pair) -> str:
    """Which terms of the channel differ."""

    def there(own: DerivativeTable) -> set[str]:
        return {
            name
            for name in own.names
            if name[0] == item.derivative[0] and math.isfinite(own[name][item.row])
        }

    ours, basis = there(estimate.table), there(table)
    parts = [
        f"{word} {', '.join(sorted(names))}"
        for word, names in (("without", basis - ours), ("with", ours - basis))
        if names
    ]
    share = estimate.shares.get(item.derivative)
    kept = (
        ""
        if share is None
        else f"{item.derivative} taken in {share[item.row]:.0%} of the bags of runs, "
    )
    terms = " and ".join(parts) or "offsets taken otherwise"
    return f"Structure: {kept}{terms}; with the terms of the regression the two agree."


def _families(families: Mapping[str, DerivativeTable], item: _Pair) -> str:
    """The two families of tests that are farthest apart, where they disagree."""
    told = []
    for title, table in families.items():
        rows = [0] if table.pooled else np.flatnonzero(np.isclose(table.Fn, item.Fn, rtol=0.01))
        if item.derivative in table and len(rows):
            row, column = int(rows[0]), table.index(item.derivative)
            value, std = float(table.value[row, column]), float(table.std[row, column])
            if math.isfinite(value) and math.isfinite(std):
                told.append((value, std, title))
    pairs = [
        (abs(a[0] - b[0]) / math.hypot(a[1], b[1]), a, b)
        for place, a in enumerate(told)
        for b in told[place + 1 :]
        if a[1] or b[1]
    ]
    if not pairs:
        return ""
    far, a, b = max(pairs)
    if far < APART:
        return ""
    return (
        f"Excitation: {a[2]} alone gives {number(a[0])}, {b[2]} alone {number(b[0])}, "
        f"{far:.1f} standard deviations apart."
    )
