"""Numbers and names as they stand in a report."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Final

from pmmkit.conventions import Convention, parse_derivative
from pmmkit.workbench.pages.sections import Symbol

_LETTERS: Final = {"phi": "φ", "d": "δ", "|d|": "|δ|"}


def symbol(name: str, convention: Convention) -> Symbol:
    """A derivative as it is typeset.

    Parameters
    ----------
    name : str
        Name of the derivative.
    convention : Convention
        Decides on one or two strokes, and on v or β.

    Examples
    --------
    >>> print(symbol("Nvvr", Convention()))
    N′vvr
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
    return Symbol(f"{derivative.channel}{stroke}", "".join(factors))


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


def gathered(pairs: Iterable[tuple[str, str]]) -> list[list[str]]:
    """Pairs of a name and a text as rows of a table, without what repeats the row above.

    Parameters
    ----------
    pairs : iterable of (str, str)
        Of `flattened`: names under one name that have the same text stand in one row, and a name
        with several texts stands once.

    Examples
    --------
    >>> gathered([("left out: SD_1", "again"), ("left out: SD_2", "again"), ("made", "x")])
    [['left out: SD_1, SD_2', 'again'], ['made', 'x']]
    >>> gathered([("made", "x"), ("made", "y")])
    [['made', 'x'], ['', 'y']]
    """
    found: list[tuple[str, str, list[str]]] = []
    for name, text in pairs:
        above, _, own = name.rpartition(": ")
        if above and found and found[-1][:2] == (above, text):
            found[-1][2].append(own)
        else:
            found.append((above, text, [own]))
    names = [f"{above}: {', '.join(own)}" if above else own[0] for above, _, own in found]
    return [
        ["" if place and name == names[place - 1] else name, text]
        for place, (name, (_, text, _)) in enumerate(zip(names, found, strict=True))
    ]
