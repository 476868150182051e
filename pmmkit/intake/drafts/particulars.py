"""Particulars of the model in a list beside the tests: name, number, unit, a row each."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from pmmkit.base import CampaignError
from pmmkit.conventions import split_unit
from pmmkit.intake.seen import FileLook
from pmmkit.readers import READERS, Cell, Cells, to_number

Found = Mapping[str, tuple[float, str]]
_NAMES: Final[Mapping[str, tuple[str, ...]]] = {
    "scale": ("sc", "scale", "lambda", "λ", "model scale", "maßstab", "massstab", "schaal"),
    "L": ("lpp", "l pp", "lbp", "l", "length between perpendiculars"),
    "B": ("b", "bwl", "breadth", "beam"),
    "d": ("tm", "t", "d", "draught", "draft", "tiefgang", "diepgang"),
    "volume": ("vol", "volume", "displacement volume", "displaced volume"),
    "Izz": ("iz", "izz", "i z", "i zz"),
    "xG": ("xg", "x g", "lcg"),
}
"""Usual names in such lists; the first that is there counts."""
_POWERS: Final = {"L": 1, "B": 1, "d": 1, "volume": 3, "xG": 1}
_LONGEST: Final = 20.0
"""Length of a model at most [m]: a longer one is the ship."""
_GYRADIUS: Final = (0.18, 0.32)
"""Radius of gyration over L: tells whether Izz is that of the model or of the ship."""
_DEPTHS: Final = ("hmodel", "h model", "model depth", "water depth", "depth of water", "depth")
_RHO: Final = 1000.0
"""Density by which the mass that goes with Izz is told [kg/m³]."""


def particulars_of(
    looks: Sequence[FileLook], sheets: Sequence[str]
) -> tuple[Found, Mapping[str, tuple[float, str]]]:
    """Particulars of the model by key of the campaign file, each with where it stands."""
    for look in looks:
        try:
            cells = READERS[look.format].cells(look.request)
        except CampaignError:
            continue
        found = dict(_model(_listed(cells), look.shown))
        if {"L", "B", "d"} <= set(found):
            depths = _depths(cells, look.shown, sheets)
            if {*depths} == {*sheets} and len({depth for depth, _ in depths.values()}) == 1:
                return {**found, "depth": next(iter(depths.values()))}, {}
            return found, depths
    return {}, {}


def _listed(cells: Cells) -> dict[str, tuple[float, str]]:
    """Numbers by our names, and their names with the rows."""
    words: dict[str, tuple[float, str]] = {}
    for line, row in zip(cells.lines, cells.rows, strict=True):
        name = row[0]
        if not isinstance(name, str) or len(row) < 2:
            continue
        number = to_number(row[1], cells.decimal)
        if number is not None and math.isfinite(number):
            unit = row[2] if len(row) > 2 and isinstance(row[2], str) else ""
            plain = split_unit(name)[0].strip().casefold()
            words.setdefault(plain, (number, f"{name.strip()} = {number:g} {unit}, row {line}"))
    return {
        key: next(words[name] for name in names if name in words)
        for key, names in _NAMES.items()
        if any(name in words for name in names)
    }


def _model(
    listed: Mapping[str, tuple[float, str]], shown: str
) -> Iterator[tuple[str, tuple[float, str]]]:
    """The particulars at the scale of the model."""
    scale = listed.get("scale", (1.0, ""))[0]
    length = listed.get("L", (0.0, ""))[0]
    ship = scale > 1.0 and length > _LONGEST
    values: dict[str, float] = {}
    for key, power in _POWERS.items():
        if key in listed:
            values[key] = listed[key][0] / (scale**power if ship else 1.0)
            told = f", over {scale:g}{'³' if power == 3 else ''}" if ship else ""
            yield key, (float(f"{values[key]:.4g}"), f"{shown}: {listed[key][1]}{told}")
    if "Izz" in listed and {"L", "volume"} <= set(values):
        for factor, told in ((1.0, ""), (scale**-5, f", over {scale:g}⁵")):
            value = listed["Izz"][0] * factor
            size = math.sqrt(abs(value) / (_RHO * values["volume"])) / values["L"]
            if _GYRADIUS[0] < size < _GYRADIUS[1]:
                yield "Izz", (float(f"{value:.4g}"), f"{shown}: {listed['Izz'][1]}{told}")
                return


def _depths(cells: Cells, shown: str, sheets: Sequence[str]) -> dict[str, tuple[float, str]]:
    """The depth of the water by sheet of runs, where rows are named after them."""
    place = next(
        (
            index
            for name in _DEPTHS
            for index, header in enumerate(cells.headers)
            if split_unit(header)[0].strip().casefold() == name
        ),
        None,
    )
    found: dict[str, tuple[float, str]] = {}
    if place is None:
        return found
    for line, row in zip(cells.lines, cells.rows, strict=True):
        for sheet in dict.fromkeys(sheets):
            if _is(row[0], sheet):
                number = to_number(row[place], cells.decimal)
                if number is not None and number > 0:
                    found.setdefault(
                        sheet, (number, f"{shown}: {cells.headers[place]}, row {line}")
                    )
    return found


def _is(cell: Cell, name: str) -> bool:
    return isinstance(cell, str) and cell.strip().casefold() == name.casefold()
