"""Numbers as people read them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

ABSENT: Final = "–"
"""What stands where there is no value."""
LONG: Final = 1e7
"""Size from which a number is told by its power of ten: no digit before the point means more."""
PLAIN: Final = 1e5
"""Size up to which significant digits are told without a power of ten, as on the page."""
WIDE: Final = 1.96
"""Standard deviations of half of a 95 % interval."""


def with_uncertainty(value: float, spread: float) -> str:
    """A value with its standard uncertainty in brackets, to two digits of the latter.

    Parameters
    ----------
    value, spread : float
        The value, and its uncertainty; to five digits where there is none, empty for NaN.

    Examples
    --------
    >>> with_uncertainty(-.01160, .000234)
    '-0.01160(23)'
    >>> with_uncertainty(-12.3, 41.)
    '-12(41)'
    >>> with_uncertainty(1.23456e8, 2.34e5)
    '1.2346(23)e+08'
    """
    return _beside(value, spread, signed=False)


def plus_minus(value: float, half: float) -> str:
    """A value with half the length of its interval, to two digits of the latter; empty for NaN.

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
    >>> print(plus_minus(-.0116, 3.2e180))
    (0.0 ± 3.2)e+180
    """
    return _beside(value, half, signed=True)


def _beside(value: float, spread: float, *, signed: bool) -> str:
    if math.isnan(value):
        return ""
    if math.isinf(value):
        return ABSENT
    if not math.isfinite(spread) or spread <= 0:
        return _plain(value)
    largest = max(abs(value), spread)
    if largest >= LONG:
        power = math.floor(math.log10(float(f"{largest:.1e}")))
        text = _beside(value / 10.0**power, spread / 10.0**power, signed=signed)
        return f"({text})e+{power:02d}" if signed else f"{text}e+{power:02d}"
    places = 1 - math.floor(math.log10(spread))
    if round(spread, places) >= 10.0 ** (2 - places):
        places -= 1
    places = max(places, 0)
    if signed:
        return f"{fixed(value, places)} ± {fixed(spread, places)}"
    return f"{fixed(value, places)}({round(spread * 10**places)})"


def _plain(value: float) -> str:
    if abs(value) >= LONG:
        return fixed(value, 0)
    places = 4 - math.floor(math.log10(abs(value))) if value else 0
    return fixed(value, max(places, 0))


def number(value: float, digits: int = 4, *, signed: bool = False) -> str:
    """A number to some significant digits; a dash where there is none.

    Parameters
    ----------
    value : float
        The number.
    digits : int
        Significant digits.
    signed : bool
        Whether a positive number has its sign.

    Examples
    --------
    >>> number(4.361), number(float("nan"))
    ('4.361', '–')
    >>> number(12345.678), number(123456.78), number(-0.0), number(4.361, 2, signed=True)
    ('12350', '1.235e+05', '0', '+4.4')
    """
    if not math.isfinite(value):
        return ABSENT
    if value == 0.0:
        return "0"
    sign = "+" if signed else ""
    text = f"{value:{sign}.{digits}g}"
    return f"{float(text):{sign}.0f}" if "e+" in text and abs(value) < PLAIN else text


def fixed(value: float, places: int, *, signed: bool = False) -> str:
    """A number to some decimal places; by its power of ten from ten million on, a dash for none.

    What rounds to zero has no sign.

    Parameters
    ----------
    value : float
        The number.
    places : int
        Decimal places.
    signed : bool
        Whether a positive number has its sign.

    Examples
    --------
    >>> fixed(4.3611, 2), fixed(4.36e180, 2), fixed(0.5, 1, signed=True), fixed(math.nan, 2)
    ('4.36', '4.36e+180', '+0.5', '–')
    """
    if not math.isfinite(value):
        return ABSENT
    form = ".2e" if abs(value) >= LONG else f".{places}f"
    text = f"{value:{'+' if signed else ''}{form}}"
    return text.lstrip("+-") if float(text) == 0.0 else text


def percent(share: float, *, signed: bool = True) -> str:
    """A change, or a share, in percent; no sign where it rounds to zero.

    Parameters
    ----------
    share : float
        The change over what it is a change of.
    signed : bool
        Whether a positive one has its sign, as a change has.

    Examples
    --------
    >>> percent(0.2193), percent(-0.0001), percent(math.nan), percent(0.2193, signed=False)
    ('+21.9 %', '0.0 %', '–', '21.9 %')
    """
    if not math.isfinite(share):
        return ABSENT
    return f"{fixed(100 * share, 1, signed=signed)} %"


def counted(count: int, what: str) -> str:
    """A count with its noun.

    Parameters
    ----------
    count : int
        How many.
    what : str
        The noun, singular.

    Examples
    --------
    >>> counted(1, "run"), counted(3, "run"), counted(2, "guess"), counted(2, "history")
    ('1 run', '3 runs', '2 guesses', '2 histories')
    """
    if count == 1:
        return f"1 {what}"
    if what[-1:] == "y" and what[-2:-1] not in "aeiou":
        return f"{count} {what[:-1]}ies"
    return f"{count} {what}{'es' if what.endswith(('s', 'x', 'ch', 'sh')) else 's'}"


def listed(words: Sequence[str]) -> str:
    """Words in a row, the last two joined by *and*.

    Parameters
    ----------
    words : sequence of str
        One at least.

    Examples
    --------
    >>> listed(["Yv"]), listed(["Yv", "Yr", "Nv"])
    ('Yv', 'Yv, Yr and Nv')
    """
    return f"{', '.join(words[:-1])} and {words[-1]}" if len(words) > 1 else words[0]


def at_froude(Fn: float) -> str:
    """Where a sentence speaks of one Froude number; nothing for all speeds (NaN).

    Parameters
    ----------
    Fn : float
        Froude number.

    Examples
    --------
    >>> at_froude(0.2172), at_froude(math.nan)
    (' at Fn 0.217', '')
    """
    return "" if math.isnan(Fn) else f" at Fn {Fn:.3f}"
