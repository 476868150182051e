"""A published figure with its source, and ours beside it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Final, Literal

Part = Literal["prediction", "program", "literature"]
"""Who stands beside whom: our prediction beside a measurement; our program beside another, a
formula, a rule or a value that nobody measured; two other parties beside one another."""
Nature = Literal["measured", "computed", "recomputed", "printed"]
"""From a tank or a ship; a computation that others published; one that another program made for
this list from published values; a formula, a table or a rule."""
AGREES: Final = (0.01, 0.02, 0.05)
"""Shares within which figures are counted; one beyond the last says why."""

Values = Mapping[str, float]


@dataclass(frozen=True, kw_only=True)
class Published:
    """One figure that others published, and the one that stands beside it.

    Parameters
    ----------
    name : str
        What it is.
    value : float
        As published.
    unit : str
        Its unit, or what it is made non-dimensional by.
    table : str
        Title of the table that it stands in.
    sources : tuple of str
        Keys of the bibliography.
    place : str
        Where in the source, and how it came here.
    nature : {"measured", "computed", "recomputed", "printed"}
        What kind of figure it is.
    part : {"prediction", "program", "literature"}
        Who made it and who made the other, so which of the three pages it stands on.
    how : str
        How ours is computed.
    ours : callable
        Computes ours; the other party's where two others stand beside one another.
    std : float
        Standard uncertainty that the program states for ours, zero if it states none.
    within : float
        Share of the published figure by which ours may differ: what the test asks for.
    why : str
        Why ours differs.
    """

    name: str
    value: float
    unit: str
    table: str
    sources: tuple[str, ...]
    place: str
    nature: Nature
    part: Part
    how: str
    ours: Callable[[], float] = field(compare=False)
    std: float = 0.0
    within: float
    why: str = ""

    @property
    def off(self) -> float:
        """Ours less the published figure, as a share of its size."""
        return (self.ours() - self.value) / abs(self.value)

    @property
    def agrees(self) -> float:
        """The smallest of `AGREES` that holds the difference, infinite if none does."""
        return next((share for share in AGREES if abs(self.off) <= share), math.inf)

    @property
    def expected(self) -> bool:
        """Whether the difference is at most twice the standard uncertainty that is stated."""
        return abs(self.ours() - self.value) <= 2 * self.std


def table(
    title: str,
    values: Values,
    ours: Callable[[], Values],
    *,
    sources: tuple[str, ...],
    place: str,
    nature: Nature,
    part: Part,
    how: str,
    within: float,
    unit: str | Mapping[str, str] = "",
    std: Values | None = None,
    but: Values | None = None,
    why: str | Mapping[str, str] = "",
) -> tuple[Published, ...]:
    """The figures of one table.

    Parameters
    ----------
    title : str
        Its title.
    values : mapping of str to float
        What was published, by name.
    ours : callable
        Ours by the same names; called when one of them is asked for, and best cached.
    sources, place, nature, part, how
        As of each figure.
    unit : str or mapping
        Their unit, of all or by name.
    within : float
        The share that the figures may differ by.
    std : mapping of str to float, optional
        Standard uncertainties that are stated, by name.
    but : mapping of str to float, optional
        Other shares, by name.
    why : str or mapping
        Why figures differ, of all or by name.

    Examples
    --------
    >>> (found,) = table("Circles", {"area": 3.14}, lambda: {"area": 3.14159}, unit="r²",
    ...     sources=("abkowitz_1964",), place="page 1", nature="printed", part="program",
    ...     how="π", within=1e-3)
    >>> f"{found.off:.5f}", found.agrees
    ('0.00051', 0.01)
    """
    shares, stated = but or {}, std or {}
    reasons = dict.fromkeys(values, why) if isinstance(why, str) else why
    units = dict.fromkeys(values, unit) if isinstance(unit, str) else unit
    return tuple(
        Published(
            name=name,
            value=value,
            unit=units.get(name, ""),
            table=title,
            sources=sources,
            place=place,
            nature=nature,
            part=part,
            how=how,
            ours=lambda name=name: float(ours()[name]),
            std=stated.get(name, 0.0),
            within=shares.get(name, within),
            why=reasons.get(name, ""),
        )
        for name, value in values.items()
    )


def pairs(
    rows: Iterable[tuple[float, float, float]],
    first: str,
    second: str,
    label: Callable[[float], str],
) -> Values:
    """A table of two columns by name."""
    values = {}
    for at, one, other in rows:
        values |= {f"{first}, {label(at)}": one, f"{second}, {label(at)}": other}
    return values
