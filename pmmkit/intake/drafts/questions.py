"""What a campaign file still leaves to a person: its lines marked TODO, with what is guessed."""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Final, Literal

from pmmkit.base import CampaignError
from pmmkit.conventions import Ship, factor_to, is_unit, split_unit
from pmmkit.files import toml_string
from pmmkit.intake.drafts.columns import aligned
from pmmkit.intake.seen import FileLook
from pmmkit.readers import READERS, Cell, Cells, to_number

# Particulars of the model in a list beside the tests: name, number, unit, a row each.


Found = Mapping[str, tuple[float, str]]
_DISPLACEMENT: Final = "displacement"
"""A mass or a volume, as its unit tells."""
_NAMES: Final[Mapping[str, tuple[str, ...]]] = {
    "scale": ("sc", "scale", "lambda", "λ", "model scale", "maßstab", "massstab", "schaal"),
    "L": (
        *("lpp", "l pp", "lbp", "l", "length between perpendiculars", "länge zw. loten"),
        *("länge zwischen den loten", "垂線間長", "垂线间长", "수선간장"),
        *("longueur entre perpendiculaires", "eslora entre perpendiculares"),
        "comprimento entre perpendiculares",
    ),
    "B": (
        *("b", "bwl", "breadth", "beam", "breite", "breedte", "largeur", "manga", "boca"),
        *("幅", "船幅", "型宽", "船宽", "폭", "선폭"),
    ),
    "d": (
        *("tm", "t", "d", "draught", "draft", "tiefgang", "diepgang", "tirant d'eau", "calado"),
        *("喫水", "吃水", "흘수"),
    ),
    "volume": ("vol", "volume", "displacement volume", "displaced volume"),
    "mass": (
        *("mass", "m", "model mass", "mass of the model", "masse", "massa", "masa"),
        *("質量", "质量", "질량", _DISPLACEMENT),
    ),
    "Izz": (
        *("iz", "izz", "i z", "i zz", "yaw inertia", "yaw moment of inertia"),
        *("trägheitsmoment um z", "massenträgheitsmoment um z", "gierträgheitsmoment"),
    ),
    "xG": ("xg", "x g", "lcg", "schwerpunkt vor mitte", "centre of gravity forward of midship"),
    "propeller.D": ("dp", "d p", "propeller d", "propeller diameter", "diameter of the propeller"),
    "rho": ("rho", "ρ", "density", "density of the water", "water density"),
    "rudder.area": ("ar", "a r", "rudder area", "area of the rudder"),
}
"""Usual names in such lists; the first that is there counts."""
_POWERS: Final = {
    "L": 1,
    "B": 1,
    "d": 1,
    "volume": 3,
    "mass": 3,
    "xG": 1,
    "propeller.D": 1,
    "rudder.area": 2,
}
_UNITS: Final[Mapping[str, str]] = {
    "mass": "kg",
    **dict.fromkeys(("L", "B", "d", "xG", "propeller.D"), "m"),
}
"""Units of those that lists have in others, mm and t, too."""
_GYRADIUS: Final = (0.18, 0.32)
"""Radius of gyration over L: tells whether Izz is that of the model or of the ship."""
_DEPTHS: Final = ("hmodel", "h model", "model depth", "water depth", "depth of water", "depth")
_WATERS: Final = (990.0, 1035.0)
"""Density of what a ship floats in, from a warm tank to a salt sea [kg/m³]."""
_RHO: Final = 1000.0
"""Density by which the mass that goes with Izz is told [kg/m³]."""


def particulars_of(
    looks: Sequence[FileLook], sheets: Sequence[str]
) -> tuple[Found, Mapping[str, tuple[float, str]]]:
    """Particulars of the model by key of the campaign file, each with where it stands.

    A list of particulars has no header: every row of its sheet is looked at. A text without rows is
    read for sentences.
    """
    for look in looks:
        cells = _cells(look)
        found = dict(_model(_listed(_in_rows(cells) if cells else {}), look.shown))
        if {"L", "B", "d"} <= set(found) and cells:
            depths = _depths(cells, look.shown, sheets)
            if {*depths} == {*sheets} and len({depth for depth, _ in depths.values()}) == 1:
                return {**found, "depth": next(iter(depths.values()))}, {}
            return found, depths
        if not look.has_sheets:
            text = look.path.read_text(encoding="utf-8", errors="replace")
            for words in (_in_pairs(text), _in_prose(text)):
                found = dict(_model(_listed(words), look.shown))
                if {"L", "B", "d"} <= set(found) and found["L"] > found["B"] > found["d"]:
                    return found, {}
    return {}, {}


Words = Mapping[str, tuple[float, str, str]]
"""By name in small letters a number, its unit, and both as they stand there."""
_WRITTEN: Final = r"(?:1\s*:\s*)?([-+]?(?:\d+(?:[.,]\d+)?|[.,]\d+)(?:[eE][-+]?\d+)?)"
"""In prose: digits before the point may lack, and a scale may be written 1:46.4."""
_LETTERS: Final = ("L", "B", "T", "d")
"""Names of one letter that prose is believed: as they are written, no others."""
_SIZES: Final = re.compile(rf"{_WRITTEN}\s*m?\s*[x×]\s*{_WRITTEN}\s*m?\s*[x×]\s*{_WRITTEN}\s*m\b")
"""Three sizes, such as "4.0 x 0.7 x 0.25 m"."""
_TANK: Final = re.compile(r"(?i)tank|basin|flume|channel|canal|becken|rinne")
"""What else has a length, a breadth and a depth."""
_PAIR: Final = re.compile(
    rf"\s*[\"']?(?P<name>[^\W\d_][\w .]*?)[\"']?\s*[:=]\s*(?P<number>{_WRITTEN})"
    r"\s*(?P<unit>[a-zA-Z]+(?:[ /][a-zA-Z]+)?[23²³]?)?\s*,?\s*(?:(?:#|;|//).*)?"
)
"""A name, a number, perhaps a unit and a remark: all of a line."""


_COMMA: Final = re.compile(r"\s*[+-]?\d*,(?!\d{3}\s*$)\d+\s*")
"""A number such as 4,0; in 1,234 the comma may as well stand before thousands."""


def _cells(look: FileLook) -> Cells | None:
    """The rows of a list; None where a file holds none."""
    try:
        bare = replace(look, options=replace(look.options, header=False))
        return READERS[bare.format or "csv"].cells(bare.request)
    except CampaignError:
        return None


def _in_rows(cells: Cells) -> Words:
    """Of rows with a name, a number and a unit."""
    words: dict[str, tuple[float, str, str]] = {}
    for line, row in zip(cells.lines, cells.rows, strict=True):
        name = row[0]
        if not isinstance(name, str) or len(row) < 2:
            continue
        number = to_number(row[1], cells.decimal)
        if number is None and _COMMA.fullmatch(str(row[1])):  # a workbook's text
            number = to_number(row[1], ",")
        if number is not None and math.isfinite(number):
            plain, own = split_unit(name)
            unit = row[2] if len(row) > 2 and isinstance(row[2], str) else own or ""
            told = f"{name.strip()} = {number:g} {unit}, row {line}"
            words.setdefault(plain.strip().casefold(), (number, unit.strip(), told))
    return words


def _in_pairs(text: str) -> Words:
    """Of lines such as ``I_z: 9908.6  # measured`` or ``"B": 1.2688,``, as YAML, INI and JSON have
    them; a lone D is the depth of one ship and the propeller of another, and is left."""
    words: dict[str, tuple[float, str, str]] = {}
    for line, said in enumerate(text.splitlines(), 1):
        found = _PAIR.fullmatch(said)
        if found is None or found["name"] == "D":
            continue
        number, unit = float(found["number"].replace(",", ".")), found["unit"] or ""
        told = f"{found['name']} = {f'{number:g} {unit}'.strip()}, line {line}"
        name = found["name"].replace("_", " ").casefold()
        words.setdefault(name, (number, unit, told))
    return words


def _in_prose(text: str) -> Words:
    """Of sentences such as "Lpp 3.0 m, B = .489, d .201", and of rows between bars."""
    long = sorted((x for names in _NAMES.values() for x in names if len(x) > 1), key=len)
    known = "|".join([f"(?i:{re.escape(x)})" for x in reversed(long)] + [*_LETTERS])
    stated = re.compile(
        rf"(?<![\w./])({known})(?:\s*(?:=|:|\b(?:is|was|of)\b)\s*|\s+){_WRITTEN}"
        r"(?![\d.:]|\s*%)\s*([a-zA-Z]+[23²³]?)?"
    )
    words: dict[str, tuple[float, str, str]] = {}
    for line, said in enumerate(text.splitlines(), 1):
        for name, number, told in _sizes(said):
            words.setdefault(name, (number, "", f"{told}, line {line}"))
        for name, written, unit in stated.findall(re.sub(r"[|*`$]+", " ", said)):
            number = float(written.replace(",", "."))
            told = f"{name} = {f'{number:g} {unit}'.strip()}, line {line}"
            words.setdefault(name.casefold(), (number, unit, told))
    return words


def _sizes(said: str) -> Iterator[tuple[str, float, str]]:
    """Length, breadth and draught of a model in a line such as "4.0 m x 0.7 m x 0.25 m"."""
    for found in () if _TANK.search(said) else _SIZES.finditer(said):
        L, B, d = (float(x.replace(",", ".")) for x in found.groups())
        if B > 0.0 < d and L < Ship.LONGEST_MODEL and 3.0 < L / B < 15.0 and 1.5 < B / d < 8.0:
            yield from (("l", L, found[0]), ("b", B, found[0]), ("t", d, found[0]))


def _listed(words: Words) -> dict[str, tuple[float, str]]:
    """Numbers by our names, and their names with the rows."""
    found = {}
    for key, names in _NAMES.items():
        target = _UNITS.get(key, "")
        for name in names:
            number, unit, told = words.get(name, (math.nan, "", ""))
            factor = factor_to(unit, target) if target and is_unit(unit) else None
            if math.isfinite(number) and (factor or name != _DISPLACEMENT):
                found[key] = (number * (factor or 1.0), told)
                break
    return found


def _model(
    listed: Mapping[str, tuple[float, str]], shown: str
) -> Iterator[tuple[str, tuple[float, str]]]:
    """The particulars at the scale of the model."""
    scale = listed.get("scale", (1.0, ""))[0]
    length = listed.get("L", (0.0, ""))[0]
    ship = scale > 1.0 and length > Ship.LONGEST_MODEL
    values: dict[str, float] = {}
    for key, power in _POWERS.items():
        if key in listed:
            values[key] = listed[key][0] / (scale**power if ship else 1.0)
            told = f", over {scale:g}{' ²³'[power - 1].strip()}" if ship else ""
            yield key, (float(f"{values[key]:.4g}"), f"{shown}: {listed[key][1]}{told}")
    # A list of the full-scale ship tells the sea and not the tank.
    if not ship and "rho" in listed and _WATERS[0] < listed["rho"][0] < _WATERS[1]:
        yield "rho", (listed["rho"][0], f"{shown}: {listed['rho'][1]}")
    if "volume" not in values and "mass" in values:
        values["volume"] = values["mass"] / _RHO
    if "Izz" in listed and {"L", "volume"} <= set(values):
        for factor, told in ((1.0, ""), (scale**-5, f", over {scale:g}⁵")):
            value = listed["Izz"][0] * factor
            size = math.sqrt(abs(value) / (_RHO * values["volume"])) / values["L"]
            if _GYRADIUS[0] < size < _GYRADIUS[1]:
                yield "Izz", (float(f"{value:.4g}"), f"{shown}: {listed['Izz'][1]}{told}")
                return


def _depths(cells: Cells, shown: str, sheets: Sequence[str]) -> dict[str, tuple[float, str]]:
    """The depth of the water by sheet of runs, where rows are named after them."""
    titles = [
        (split_unit(cell)[0].strip().casefold(), place, cell)
        for row in cells.rows
        for place, cell in enumerate(row)
        if isinstance(cell, str)
    ]
    named = [item for name in _DEPTHS for item in titles if item[0] == name]
    found: dict[str, tuple[float, str]] = {}
    if not named:
        return found
    _, place, title = named[0]
    for line, row in zip(cells.lines, cells.rows, strict=True):
        for sheet in dict.fromkeys(sheets):
            if _is(row[0], sheet):
                number = to_number(row[place], cells.decimal)
                if number is not None and number > 0:
                    depth = float(f"{number:.6g}")
                    found.setdefault(sheet, (depth, f"{shown}: {title}, row {line}"))
    return found


def _is(cell: Cell, name: str) -> bool:
    return isinstance(cell, str) and cell.strip().casefold() == name.casefold()


MARK: Final = "TODO"
"""Stands in the comment of a line that a person must fill in or confirm, who then takes it away."""
_FRESH_WATER: Final = 999.1
"""At 15 °C (ITTC 7.5-02-01-03, 2011) [kg/m³]."""
TANK_WATER, _SEA_WATER = (
    aligned(f"rho = {rho:g}", f"{name} water of 15 °C; {MARK} density [kg/m³] if it was another")
    for rho, name in ((_FRESH_WATER, "fresh"), (1026.0, "sea"))
)
"""A guess for a model, 0.1 % true from 10 to 20 °C; and for a ship, with 35 g/kg of salt."""
GYRADIUS: Final = 0.25
"""Radius of gyration in yaw over L, as of most ships: 0.24 to 0.26."""


@dataclass(frozen=True, kw_only=True)
class Question:
    """A question, and what stands for the answer meanwhile.

    Parameters
    ----------
    lines : tuple of int
        Lines of the campaign file where it is answered, the first is 1.
    key : str
        Table and key, such as ``ship.L``.
    text : str
        What is asked.
    kind : {"needed", "guessed", "estimated", "off"}
        Nothing can be computed before it is answered; a guess is computed with; an estimate from
        the particulars is, with its uncertainty; the line is off, and what it would say does not
        hold.
    guess : str
        What is taken meanwhile, or would be a usual answer; empty where nothing is known.
    why : str
        Where the guess comes from.
    """

    lines: tuple[int, ...]
    key: str
    text: str
    kind: Literal["needed", "guessed", "estimated", "off"]
    guess: str = ""
    why: str = ""

    def __str__(self) -> str:
        more = f" and {len(self.lines) - _SHOWN} more" if len(self.lines) > _SHOWN else ""
        shown = ", ".join(map(str, self.lines[:_SHOWN]))
        where = f"line{'s' if len(self.lines) > 1 else ''} {shown}{more}"
        told = f" {_WORDS[self.kind]} {self.guess}: {self.why}." if self.guess else ""
        stop = "" if self.text.endswith("?") else "."
        return f"{where}, {self.key}: {self.text}{stop}{told}"


_SHOWN: Final = 3
_WORDS: Final = {
    "needed": "Perhaps",
    "guessed": "Guessed",
    "estimated": "Estimated",
    "off": "Taken as",
}
_LINE: Final = re.compile(
    r"^(?P<off># ?)?(?P<left>\[.*?\]|[\w\"' .()-]+ = .*?)\s*# (?P<note>.*?)"
    rf"{MARK} ?(?P<text>.*)$"
)
_TABLE: Final = re.compile(r"^\[\[?(?P<name>[^\]]+)\]\]?")


def questions_of(text: str) -> tuple[Question, ...]:
    """The questions that a campaign file leaves, those of many runs as one.

    Parameters
    ----------
    text : str
        The campaign file.

    Returns
    -------
    tuple of Question
        Those that are needed first, then what is guessed, then lines that are off.

    Examples
    --------
    >>> for found in questions_of('[ship]\\nvolume = 2.0\\n# mass = ...   # TODO mass [kg]\\n'):
    ...     print(found)
    line 3, ship.mass: mass [kg]. Taken as 1998: density times volume.
    """
    asked: dict[_Asked, list[int]] = {}
    table = ""
    for number, line in enumerate(text.splitlines(), start=1):
        head = _TABLE.match(line)
        table = head["name"] if head is not None else table
        found = _LINE.match(line)
        if found is not None:
            asked.setdefault(_Asked.of(found, table), []).append(number)
    raw = _read(text)
    stated = _stated(raw)
    named = _names_library_ship(raw)
    questions = [
        item.question(tuple(lines), stated)
        for item, lines in asked.items()
        if not item.answered
        and not (item.key == "ship.name" and stated.get("ship"))
        and not (named and item.key.startswith("ship."))
    ]
    return tuple(sorted(questions, key=lambda item: list(_WORDS).index(item.kind)))


def with_density(text: str) -> str:
    """A campaign file whose guess of the density is that of its ship."""
    from pmmkit.models import load_ship

    raw = _read(text)
    named = _names_library_ship(raw)
    length = load_ship(raw["ship"]["name"]).L if named else _stated(raw).get("ship", {}).get("L", 0)
    sea = length > Ship.LONGEST_MODEL
    return text.replace(*((TANK_WATER, _SEA_WATER) if sea else (_SEA_WATER, TANK_WATER)))


def with_answer(text: str, lines: Sequence[int], answer: str) -> str:
    r"""A campaign file with what a person says in the place of a question; all else stays.

    Examples
    --------
    >>> asked = '[water]  # fresh\n# rho = ...   # TODO density [kg/m³]'
    >>> print(with_answer(asked, [2], "998.6"))
    [water]  # fresh
    rho = 998.6                      # density [kg/m³]
    """
    told = text.split("\n")
    for number in lines:
        found = _LINE.match(told[number - 1]) if 0 < number <= len(told) else None
        if found is None or found["left"].startswith("["):
            continue
        key = found["left"].partition(" = ")[0].strip()
        other = _OTHER.fullmatch(answer.strip())
        if other is not None and f"{other['key']} = " in found["text"]:
            told[number - 1] = aligned(f"{other['key']} = {_value(other['value'])}", "")
            continue
        note = found["note"].strip("; ") or found["text"].partition("; fresh")[0].rstrip(".:, ")
        short = note if len(note) < _LONGEST_NOTE else ""
        told[number - 1] = aligned(f"{key} = {_value(answer)}", short.removesuffix(", or"))
    return "\n".join(told)


_NUMBER: Final = re.compile(r"[+-]?(\d{1,15}([.,]\d*)?|[.,]\d+)(e[+-]?\d{1,3})?", re.IGNORECASE)
"""A number as people type it."""
_OTHER: Final = re.compile(r"(?P<key>[A-Za-z]\w*) ?= ?(?P<value>.+)")
"""An answer by another key that the question names, such as volume for mass."""
_LONGEST_NOTE: Final = 70
"""Of what was asked, kept beside its answer."""


def _value(answer: str) -> str:
    """An answer as TOML: what is none is taken for a text."""
    typed = answer.strip()
    if _NUMBER.fullmatch(typed):
        point = typed.replace(",", ".")
        whole = point.lstrip("+-").isdigit()
        return str(int(point)) if whole else repr(float(point))
    try:
        alone = "\n" not in typed and set(tomllib.loads(f"x = {typed}")) == {"x"}
        return typed if alone else toml_string(typed)
    except tomllib.TOMLDecodeError:
        return toml_string(typed)


@dataclass(frozen=True)
class _Asked:
    """A marked line, apart from where it stands: that of many runs is one."""

    key: str
    value: str
    on: bool
    note: str
    text: str

    @classmethod
    def of(cls, line: re.Match[str], table: str) -> _Asked:
        key, _, value = line["left"].partition(" = ")
        name = key.strip("[]") if key.startswith("[") else f"{table}.{key.strip()}"
        text = line["text"].rstrip(".:, ").removesuffix(", or")
        return cls(name, value.strip(), line["off"] is None, line["note"].strip("; "), text)

    @property
    def known(self) -> bool:
        """Whether a value stands there."""
        return bool(self.value) and "..." not in self.value

    @property
    def answered(self) -> bool:
        """Whether a person wrote the value: a draft says why it has one, or has the usual one."""
        table, _, key = self.key.rpartition(".")
        return self.on and self.known and not self.note and self.value != _default(table, key)

    def question(
        self, lines: tuple[int, ...], stated: Mapping[str, Mapping[str, float]]
    ) -> Question:
        """What is asked at these lines, with the guess that what is stated allows."""
        ask = partial(Question, lines=lines, key=self.key, text=self.text)
        if self.known and self.on:
            why = self.note or "nothing in the files says otherwise"
            return ask(kind="guessed", guess=self.value, why=why)
        table, _, key = self.key.rpartition(".")
        if self.known or key in _MAY_LACK or any(part in _MAY_LACK for part in self.key.split(".")):
            return ask(kind="off", guess=_default(table, key), why="the line is off")
        guess, why = estimate_of(self.key, stated)
        follows = bool(guess) and key in _EITHER
        return ask(kind="off" if follows else "needed", guess=guess, why=why)


_MAY_LACK: Final = ("axes", "cfd", "name", "GM", "Ix")
"""Tables and keys whose lines may be off though no value stands in them."""


_EITHER: Final = ("mass", "volume")
"""Of these one is enough."""


_WITHOUT_AXES: Final = {("campaign", "drift_positive"): "starboard-bow"}
"""What holds where a key is not stated and no axis is turned."""


def _default(table: str, key: str) -> str:
    """What holds where a key is not stated; empty where nothing does."""
    from pmmkit.campaigns import CampaignFile

    if (table, key) in _WITHOUT_AXES:
        return toml_string(_WITHOUT_AXES[table, key])
    field = CampaignFile.keys_of(table).get(key)
    value = None if field is None else field.default
    if value in (None, "", []):
        return ""
    return toml_string(value) if isinstance(value, str) else str(value)


def _read(text: str) -> Mapping[str, Any]:
    """The tables of a file; none where it is none."""
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        return {}


def _names_library_ship(raw: Mapping[str, Any]) -> bool:
    """Whether nothing but the name of a ship of the library stands in ``[ship]``."""
    from pmmkit.models import ships

    ship = raw.get("ship")
    return isinstance(ship, dict) and {*ship} == {"name"} and ship["name"] in ships()


def _stated(raw: Mapping[str, Any]) -> Mapping[str, Mapping[str, float]]:
    """The numbers that stand in ship and water."""
    return {
        name: {key: float(value) for key, value in table.items() if type(value) in (int, float)}
        for name, table in raw.items()
        if name in ("ship", "water") and isinstance(table, dict)
    }


def estimate_of(name: str, stated: Mapping[str, Mapping[str, float]]) -> tuple[str, str]:
    """A number for a particular that nobody stated, and where it comes from."""
    ship, water = stated.get("ship", {}), stated.get("water", {})
    rho = water.get("rho", _FRESH_WATER)
    length, volume = ship.get("L"), ship.get("volume")
    mass = ship.get("mass", rho * volume if volume else None)
    if name == "ship.mass" and volume is not None:
        return f"{rho * volume:.4g}", "density times volume"
    if name == "ship.volume" and mass is not None and rho > 0:
        return f"{mass / rho:.4g}", "mass over density"
    if name == "ship.Izz" and mass is not None and length is not None:
        about = mass * (ship.get("xG", 0.0) ** 2 + (GYRADIUS * length) ** 2)
        return f"{about:.4g}", f"radius of gyration {GYRADIUS:g} L, as of most ships"
    return "", ""
