"""Numerical uncertainty of a computation from three grids, or three time steps."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.base import DataError
from pmmkit.inference import COVERAGE
from pmmkit.models import DerivativeTable
from pmmkit.presentation import Described, Grid, Group, Section, at_froude, counted, number
from pmmkit.reduction.budgets.budget import Budget, Source

if TYPE_CHECKING:
    import pandas as pd

LOWEST: Final = 0.5
"""Least observed order that is believed."""
SLACK: Final = 1.05
"""Observed order over the formal one up to which it is believed."""
TRUSTED: Final = 1.25
"""Factor of safety where the observed order is believed."""
DOUBTED: Final = 3.0
"""Factor of safety elsewhere."""
HIGHEST: Final = 20.0
"""Order beyond which none is sought."""
ROUNDING: Final = 1e-6
"""By which an observed order may miss its limits."""


@dataclass(frozen=True, kw_only=True, repr=False)
class GridUncertainty(Described):
    """Numerical uncertainty of one number by Richardson extrapolation.

    `value`: on the finest grid. `extrapolated`: at a step of zero, with the order that counts.
    `order`: observed order p; NaN where all three values are the same. `expanded`: U_SN, about
    95 %: the factor times the estimated error.
    """

    value: float
    extrapolated: float
    order: float
    formal_order: float
    factor: float
    expanded: float

    @property
    def std(self) -> float:
        """Standard uncertainty: half of the expanded one."""
        return self.expanded / COVERAGE

    def _headline(self) -> str:
        share = f", {100 * self.expanded / abs(self.value):.2g} %" if self.value else ""
        half = self.expanded
        return f"{number(self.value, 5)} ± {number(half, 3)} (95 %{share})"

    def _sections(self) -> Sequence[Section]:
        if math.isnan(self.order):
            return [Section(paragraphs=["The same on all three"])]
        told = (
            f"Observed order {self.order:.2f} of formally {self.formal_order:g}; factor of safety "
            f"{self.factor:g}; extrapolated {number(self.extrapolated, 5)}"
        )
        return [Section(paragraphs=[told])]


def grid_uncertainty(
    values: Sequence[float], steps: Sequence[float], *, formal_order: float = 2.0
) -> GridUncertainty:
    """Numerical uncertainty of the finest of three grids, or time steps.

    Parameters
    ----------
    values : sequence of 3 float
        A force, a derivative or a metric on three similar grids, in any order.
    steps : sequence of 3 float
        Size of their cells, or time steps; only ratios count. Of N cells in three dimensions the
        size is N^(-1/3).
    formal_order : float
        Order of the method.

    Returns
    -------
    GridUncertainty

    Raises
    ------
    DataError
        If the values oscillate or diverge, or are not three.

    Notes
    -----
    The error is the difference of the two finest over r^p - 1, the order p observed on all three
    (Celik et al. 2008, for unequal ratios too). The factor of safety is 1.25 for an order from 0.5
    to the formal one (within 5 %), and 3 outside, where the error is estimated with the nearest
    order of that range (Oberkampf and Roy 2010; limits as Eça and Hoekstra 2014 have them for a
    method of second order). U covers about 95 %; its standard uncertainty is taken as U/2.

    Examples
    --------
    The outlet pressure of an inlet, of NASA's tutorial on grid convergence:

    >>> found = grid_uncertainty([0.97050, 0.96854, 0.96178], [1, 2, 4])
    >>> print(found)
    GridUncertainty 0.9705 ± 0.001 (95 %, 0.1 %)
    <BLANKLINE>
    Observed order 1.79 of formally 2; factor of safety 1.25; extrapolated 0.9713
    """
    if len(values) != 3 or len(steps) != 3:
        raise DataError("State three values and their three steps.")
    if not (np.isfinite(values).all() and np.isfinite(steps).all() and min(steps) > 0.0):
        raise DataError(f"Values {list(values)} and steps {list(steps)} must be finite, steps > 0.")
    pairs = zip(map(float, steps), map(float, values), strict=True)
    (h1, fine), (h2, medium), (h3, coarse) = sorted(pairs)
    if not h1 < h2 < h3:
        raise DataError(f"The steps {list(steps)} must differ.")
    first, second = medium - fine, coarse - medium
    shown = f"coarse to fine {number(coarse, 6)}, {number(medium, 6)}, {number(fine, 6)}"
    if first == 0.0 == second:
        order = math.nan
    elif first * second < 0.0:
        raise DataError(
            f"The values oscillate ({shown}): no order can be seen, so there is no estimate of the "
            "error. Compute a fourth grid."
        )
    elif first == 0.0 or abs(second / first) <= math.log(h3 / h2) / math.log(h2 / h1):
        raise DataError(
            f"The values do not converge ({shown}): refine the grid further."
            if first
            else f"The two finest are the same ({shown}): no order can be seen."
        )
    else:
        order = _observed(second / first, h2 / h1, h3 / h2)
    believed = math.isnan(order) or LOWEST - ROUNDING <= order <= SLACK * formal_order
    counts = formal_order if math.isnan(order) else min(max(order, LOWEST), formal_order)
    error = first / ((h2 / h1) ** counts - 1.0)
    factor = TRUSTED if believed else DOUBTED
    return GridUncertainty(
        value=fine,
        extrapolated=fine - error,
        order=order,
        formal_order=formal_order,
        factor=factor,
        expanded=factor * abs(error),
    )


def _observed(ratio: float, fine: float, coarse: float) -> float:
    """The order p with ratio = fine^p (coarse^p - 1)/(fine^p - 1); none beyond `HIGHEST`."""
    from scipy.optimize import brentq

    def miss(p: float) -> float:
        return (
            p * math.log(fine)
            + math.log(math.expm1(p * math.log(coarse)) / math.expm1(p * math.log(fine)))
            - math.log(ratio)
        )

    return HIGHEST if miss(HIGHEST) < 0.0 else float(brentq(miss, 1e-9, HIGHEST, xtol=1e-13))


@dataclass(frozen=True, kw_only=True, repr=False)
class GridStudy(Described):
    """Numerical uncertainty of derivatives from three reduced tables.

    Parameters
    ----------
    found : mapping of (Fn, name) to GridUncertainty
        Of those that converge.
    refused : mapping of (Fn, name) to str
        Why the others have none.
    """

    found: Mapping[tuple[float, str], GridUncertainty]
    refused: Mapping[tuple[float, str], str]

    def to_pandas(self) -> pd.DataFrame:
        """A row per derivative and Froude number; what was refused has only its reason."""
        import pandas as pd

        rows = [
            {
                "Fn": Fn,
                "derivative": name,
                "value": item.value,
                "extrapolated": item.extrapolated,
                "order": item.order,
                "factor": item.factor,
                "U_SN": item.expanded,
                "std": item.std,
            }
            for (Fn, name), item in self.found.items()
        ]
        rows += [
            {"Fn": Fn, "derivative": name, "refused": why}
            for (Fn, name), why in self.refused.items()
        ]
        return pd.DataFrame(rows)

    def _headline(self) -> str:
        return f"of {counted(len(self.found), 'derivative')}, {len(self.refused)} refused"

    def _sections(self) -> Sequence[Section]:
        groups: dict[str, list[list[str]]] = {}
        for (Fn, name), item in self.found.items():
            groups.setdefault(at_froude(Fn).strip(), []).append(
                [
                    name,
                    number(item.value),
                    number(item.order, 3),
                    f"{item.factor:g}",
                    number(item.expanded, 3),
                    f"{100 * item.expanded / abs(item.value):.1f} %" if item.value else "",
                ]
            )
        table = Grid(
            head=["", "finest", "order p", "factor", "U_SN (95 %)", "of the value"],
            groups=[Group(title=title, rows=rows) for title, rows in groups.items()],
        )
        left = [f"{name}{at_froude(Fn)}: {why}" for (Fn, name), why in self.refused.items()]
        lists = [Section(title="Refused", points=left)] if left else []
        return [Section(tables=[table]), *lists]


def grid_study(
    tables: Sequence[DerivativeTable], steps: Sequence[float], *, formal_order: float = 2.0
) -> GridStudy:
    """Numerical uncertainty of each derivative that three tables have.

    Parameters
    ----------
    tables : sequence of 3 DerivativeTable
        The same tests, computed on three grids or with three time steps, and reduced alike.
    steps, formal_order
        As for `grid_uncertainty`, a step a table.

    Returns
    -------
    GridStudy

    Raises
    ------
    DataError
        If there are not three tables of the same Froude numbers.
    """
    if len(tables) != 3 or len(steps) != 3:
        raise DataError("State three tables and their three steps.")
    first = tables[0]
    if any(
        len(item.Fn) != len(first.Fn)
        or not np.allclose(item.Fn, first.Fn, rtol=0.01, equal_nan=True)
        for item in tables
    ):
        raise DataError("The three tables must have the same Froude numbers.")
    found: dict[tuple[float, str], GridUncertainty] = {}
    refused: dict[tuple[float, str], str] = {}
    for row, Fn in enumerate(first.Fn.tolist()):
        for name in first.names:
            if not all(name in item for item in tables):
                continue
            values = [float(item[name][row]) for item in tables]
            if not np.isfinite(values).all():
                continue
            try:
                found[Fn, name] = grid_uncertainty(values, steps, formal_order=formal_order)
            except DataError as error:
                refused[Fn, name] = str(error)
    return GridStudy(found=found, refused=refused)


def with_grids(budget: Budget, study: GridStudy, title: str = "grid") -> Budget:
    """A budget of derivatives with the numerical uncertainty as one more source.

    Parameters
    ----------
    budget : Budget
        Of derivatives.
    study : GridStudy
        Of the same derivatives.
    title : str
        What was refined.

    Returns
    -------
    Budget
        The errors of different derivatives count as independent; what was refused is told among
        what was not stated.
    """
    factors = np.zeros((len(budget.results), len(budget.results)))
    refused = []
    for place, item in enumerate(budget.results):
        for (Fn, name), known in study.found.items():
            if name == item.name and np.isclose(Fn, item.Fn, rtol=0.01, equal_nan=True):
                factors[place, place] = known.std
        for (Fn, name), why in study.refused.items():
            if name == item.name and np.isclose(Fn, item.Fn, rtol=0.01, equal_nan=True):
                refused.append(f"{title}, {name}{at_froude(Fn)}: {why}")
    source = Source(title=title, gum="B", acts="bias", factors=factors)
    return replace(
        budget, sources=(*budget.sources, source), not_stated=(*budget.not_stated, *refused)
    )
