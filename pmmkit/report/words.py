"""Numbers and names as they stand in a report."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

from markupsafe import Markup

from pmmkit.conventions import Convention, parse_derivative
from pmmkit.tables import DerivativeTable
from pmmkit.tables.io.latex import with_uncertainty

Cell = str | None
_LETTERS: Final = {"phi": "φ", "d": "δ", "|d|": "|δ|"}
TESTS: Final = {
    "resistance": "resistance",
    "propulsion": "self-propulsion",
    "static_drift": "static drift",
    "static_heel": "static heel",
    "static_rudder": "static rudder",
    "drift_rudder": "drift with rudder",
    "circular_motion": "circular motion",
    "pure_surge": "pure surge",
    "pure_sway": "pure sway",
    "pure_yaw": "pure yaw",
    "yaw_drift": "yaw with drift",
    "yaw_rudder": "yaw with rudder",
    "sway_yaw": "sway and yaw",
}


@dataclass(frozen=True, kw_only=True, eq=False)
class Reference:
    """Derivatives of a source that stand beside ours.

    Parameters
    ----------
    table : DerivativeTable
        Its values, in any convention.
    name : str
        Its name in tables and figures.
    """

    table: DerivativeTable
    name: str


@dataclass(frozen=True, kw_only=True)
class Group:
    """Rows of a table under a title of their own."""

    rows: Sequence[Sequence[Cell]]
    title: str = ""


@dataclass(frozen=True, kw_only=True)
class Grid:
    """A table of a report; a cell None says that there is no value.

    Parameters
    ----------
    head : sequence of str
        Names of the columns.
    groups : sequence of Group
        The rows.
    caption : str
        A line above the table.
    texts : tuple of int
        Columns that hold sentences.
    """

    head: Sequence[str]
    groups: Sequence[Group]
    caption: str = ""
    texts: tuple[int, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Picture:
    """A figure of a report as SVG text, with what it shows in words."""

    svg: str
    caption: str
    narrow: bool = False


@dataclass(frozen=True, kw_only=True)
class Section:
    """A section of a report: sentences, points, findings, tables and figures in this order."""

    title: str
    paragraphs: Sequence[str] = ()
    points: Sequence[str] = ()
    findings: Sequence[Mapping[str, str]] = ()
    tables: Sequence[Grid] = ()
    figures: Sequence[Picture] = field(default_factory=tuple)


def symbol(name: str, convention: Convention) -> Markup:
    """A derivative in HTML.

    Parameters
    ----------
    name : str
        Name of the derivative.
    convention : Convention
        Decides on one or two strokes, and on v or β.

    Examples
    --------
    >>> print(symbol("Nvvr", Convention()))
    <i class="deriv">N′<sub>vvr</sub></i>
    """
    derivative = parse_derivative(name)
    letters = _LETTERS | ({"v": "β", "|v|": "|β|"} if convention.sway == "beta" else {})
    factors = [
        letters.get(factor[0], factor[0]) + "\N{COMBINING DOT ABOVE}"
        if factor.endswith("dot")
        else letters.get(factor, factor)
        for factor in derivative.factors
    ]
    stroke = "″" if convention.system == "bis" else "′"
    return Markup('<i class="deriv">{}{}<sub>{}</sub></i>').format(
        derivative.channel, stroke, "".join(factors)
    )


def plus_minus(value: float, half: float) -> Cell:
    """A value with half the length of its interval, to two digits of the latter.

    Parameters
    ----------
    value, half : float
        The value, and what stands after the sign ±.

    Examples
    --------
    >>> plus_minus(-0.0116, 0.00046)
    '-0.01160 ± 0.00046'
    >>> plus_minus(0.25, math.nan)
    '0.25000'
    """
    if math.isnan(value):
        return None
    return with_uncertainty(value, half, "plus-minus").replace(r"\pm", "±")


def number(value: float, digits: int = 4) -> str:
    """A number to some significant digits; a dash where there is none.

    Parameters
    ----------
    value : float
        The number.
    digits : int
        Significant digits.

    Examples
    --------
    >>> number(4.361), number(float("nan"))
    ('4.361', '–')
    """
    return f"{value:.{digits}g}" if math.isfinite(value) else "–"


def percent(share: float) -> str:
    """A change in percent with its sign; no sign where it rounds to zero.

    Examples
    --------
    >>> percent(0.2193), percent(-0.0001)
    ('+21.9 %', '0.0 %')
    """
    text = f"{100 * share:+.1f} %"
    return "0.0 %" if text in ("+0.0 %", "-0.0 %") else text


def counted(count: int, what: str) -> str:
    """A count with its noun.

    Examples
    --------
    >>> counted(1, "run"), counted(3, "run")
    ('1 run', '3 runs')
    """
    return f"{count} {what}" if count == 1 else f"{count} {what}s"


def flattened(content: Mapping[str, Any], path: tuple[str, ...] = ()) -> Iterable[tuple[str, str]]:
    """Nested content as pairs of a dotted name and a text.

    Parameters
    ----------
    content : mapping
        Mappings, sequences and plain values.
    path : tuple of str
        Names above it.

    Examples
    --------
    >>> list(flattened({"files": {"a.csv": "5f"}, "cycles": None, "made": ["x", "y"]}))
    [('files: a.csv', '5f'), ('made', 'x'), ('made', 'y')]
    """
    for key, value in content.items():
        here = (*path, str(key))
        if isinstance(value, Mapping):
            yield from flattened(value, here)
        elif isinstance(value, (list, tuple)):
            for item in value:
                if isinstance(item, Mapping):
                    yield from flattened(item, here)
                else:
                    yield ": ".join(here), str(item)
        elif value not in (None, ""):
            yield ": ".join(here), str(value)
