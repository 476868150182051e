"""How wide texts are, and the little mathematics of symbols such as $Y'_{v|v|}$."""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

_BY_WIDTH: Final = {
    200: "\u2009",
    227: "′",
    275: "'",
    278: "ijlìíîïı",
    284: "ł",
    295: "IJÌÍÎÏΙΪİ",
    318: " ,.\xa0\xb7\u2018\u2019",
    337: "/:;\\|¦",
    338: "ίι",
    352: "f",
    361: "-\xad",
    374: "″",
    390: "()[]",
    392: "t",
    401: "!¡²³¹⁰⁴⁵⁶⁷⁸⁹₀₁₂₃₄₅₆₇₈₉",
    411: "r",
    460: '"',
    471: "ªº",
    500: "*_`§¨¯°´¸–",
    517: "∂",
    518: "“”",
    521: "s∫šş",
    525: "zž",
    528: "⁻⁺",
    531: "?¿",
    541: "έε",
    544: "ζ",
    550: "cçćč",
    557: "LΓ",
    558: "ξ",
    559: "ν",
    562: "Ł",
    575: "F",
    578: "χ",
    579: "kΰυ",
    587: "ς",
    589: "κ",
    590: "•",
    592: "vxyýÿγλ",
    602: "πτ",
    603: "PΡ",
    605: "Þ",
    611: "TYÝΤΥΫ",
    612: "o«»ðòóôõöøδθοōő",
    613: "aàáâãäåā",
    615: "eèéêë",
    630: "ß",
    632: "EÈÉÊËΕΞΣ",
    634: "hnuñùúûüήησű",
    635: "SbdgpqþρŠŞğ",
    636: "$0123456789{}¢£¤¥µ¶μ",
    637: "√",
    638: "β",
    656: "KΚ",
    659: "άα",
    660: "φψ",
    674: "∑",
    684: "AVÀÁÂÃÄÅΑΔΛĀ",
    685: "XZΖΧŽ",
    686: "BΒ",
    695: "R",
    698: "CÇĆČ",
    714: "∝",
    732: "UÙÚÛÜŰ",
    748: "NÑΝ",
    752: "HΗΠ",
    764: "Ω",
    770: "D",
    775: "GÐĞ",
    780: "&",
    787: "OQÒÓÔÕÖØΘΟΦΨŌŐ",
    818: "w",
    833: "∞",
    837: "ω",
    838: "#+<=>^~¬±×÷−≤≥≈≠→←↑↓",
    863: "MΜ",
    950: "%",
    969: "¼½¾",
    974: "mÆ",
    982: "æ",
    989: "W",
    1000: "@©®—…",
}
"""Letters by their width, in thousandths of the size: DejaVu Sans 2.37, regular."""
_WIDTHS: Final = {ord(letter): width for width, own in _BY_WIDTH.items() for letter in own}
_OTHER, _WIDE = 640, 1000
"""Of letters that are not listed; of East Asian ones, which are square."""
LINE: Final = 1.2
"""From line to line, over the size of letters."""
ASCENT, DESCENT, MIDDLE = 0.76, 0.24, 0.36
"""Over the size of letters: height of capitals with a little room, depth, half a capital."""
_SMALLER: Final = 0.7
_RAISED, _LOWERED = 0.38, -0.18
"""Size and shift of exponents and indices, over the size of letters."""
_NAMED: Final = {
    "alpha": "α", "beta": "β", "gamma": "γ", "delta": "δ", "zeta": "ζ", "eta": "η", "theta": "θ",
    "lambda": "λ", "mu": "μ", "pi": "π", "rho": "ρ", "sigma": "σ", "tau": "τ", "phi": "φ",
    "psi": "ψ", "omega": "ω", "Delta": "Δ", "times": "×", "cdot": "·", ",": "\u2009", " ": " ",
}  # fmt: skip
SUPERSCRIPTS: Final = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_PRIME: Final = {"'": "′"}


@dataclass(frozen=True, kw_only=True)
class Glyphs:
    """Letters of one look; rise, scale: over the size of the text."""

    text: str
    italic: bool = False
    rise: float = 0.0
    scale: float = 1.0

    @property
    def width(self) -> float:
        """Over the size of the text."""
        return self.scale * _width(self.text)


@lru_cache(maxsize=4096)
def runs_of(line: str) -> tuple[Glyphs, ...]:
    """A line of text with its mathematics between $ taken apart.

    Examples
    --------
    >>> [(run.text, run.italic, run.rise) for run in runs_of("$Y'_{\\\\dot{v}}$ [-]")]
    [('Y′', True, 0.0), ('v̇', True, -0.18), (' [-]', False, 0.0)]
    """
    parts = re.split(r"(?<!\\)\$", line)
    if len(parts) % 2 == 0:  # a $ that none closes
        return (Glyphs(text=line.replace(r"\$", "$")),)
    found: list[Glyphs] = []
    for number, part in enumerate(parts):
        if number % 2:
            found += _mathematics(part, 0.0, 1.0)
        elif part:
            found.append(Glyphs(text=part.replace(r"\$", "$")))
    return tuple(found)


def width_of(line: str, size: float) -> float:
    """How wide a line of letters of a size is [pt]."""
    return size * sum(run.width for run in runs_of(line))


_TOKEN: Final = re.compile(r"\\dot\{(\w)\}|\\([A-Za-z]+|.) ?|([_^])|([{}])|(.)")


def _mathematics(text: str, rise: float, scale: float) -> list[Glyphs]:
    """Runs of a formula: letters in italics, indices and exponents smaller."""
    found: list[Glyphs] = []
    levels: list[tuple[float, float]] = [(rise, scale)]
    now = levels[0]
    pending = None
    for match in _TOKEN.finditer(text):
        dotted, named, shift, brace, plain = match.groups()
        if shift:
            up = _RAISED if shift == "^" else _LOWERED
            pending = now[0] + up * now[1], now[1] * _SMALLER
        elif brace == "{":
            levels.append(now)
            now = pending or now
            pending = None
        elif brace == "}":
            now = levels.pop()
        else:
            letter = (
                f"{dotted}\u0307"
                if dotted
                else _NAMED.get(named, named)
                if named
                else _PRIME.get(plain, plain)
            )
            at = pending or now
            pending = None
            _add(found, letter, *at)
    return found


def _add(found: list[Glyphs], letter: str, rise: float, scale: float) -> None:
    """Put a letter behind the last one, where both look alike."""
    italic = letter[0].isalpha()
    if found and letter in "′|":  # marks of what stands before them
        italic = found[-1].italic
    last = found[-1] if found else None
    if last and (last.italic, last.rise, last.scale) == (italic, rise, scale):
        found[-1] = Glyphs(text=last.text + letter, italic=italic, rise=rise, scale=scale)
    else:
        found.append(Glyphs(text=letter, italic=italic, rise=rise, scale=scale))


@lru_cache(maxsize=4096)
def _width(text: str) -> float:
    return sum(_letter(letter) for letter in text) / 1000.0


def _letter(letter: str) -> int:
    known = _WIDTHS.get(ord(letter))
    if known is not None:
        return known
    if unicodedata.combining(letter):
        return 0
    return _WIDE if unicodedata.east_asian_width(letter) in "WF" else _OTHER
