"""modelDescription.xml and buildDescription.xml."""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType
from typing import Any, Final

from pmmkit.base import __version__
from pmmkit.equations import Prepared
from pmmkit.exports.fmu.variables import FmuVariable, Table
from pmmkit.models import Model
from pmmkit.syntax import plain

# Units as powers of the base units.


_BASE: Final = MappingProxyType(
    {
        "1": ({}, 1.0),
        "m": ({"m": 1}, 1.0),
        "kg": ({"kg": 1}, 1.0),
        "s": ({"s": 1}, 1.0),
        "rad": ({"rad": 1}, 1.0),
        "deg": ({"rad": 1}, math.pi / 180),
        "min": ({"s": 1}, 60.0),
        "kn": ({"m": 1, "s": -1}, 1852 / 3600),
        "N": ({"kg": 1, "m": 1, "s": -2}, 1.0),
        "W": ({"kg": 1, "m": 2, "s": -3}, 1.0),
    }
)
_FACTOR: Final = re.compile(r"([a-zA-Z]+|1)(\d*)")
SHOWN: Final = MappingProxyType(
    {"rad": ("deg",), "rad/s": ("deg/s",), "m/s": ("kn",), "1/s": ("1/min",)}
)
"""Other units in which programs may show values of a unit; the first is proposed for angles."""


def modelica(unit: str) -> str:
    """A unit as Modelica and FMI write it.

    Examples
    --------
    >>> modelica("N m"), modelica("kg m2"), modelica("m/s")
    ('N.m', 'kg.m2', 'm/s')
    """
    return unit.replace(" ", ".")


def elements(unit: str) -> tuple[dict[str, int], float]:
    """Powers of kg, m, s and rad in a unit, and the factor that leads to them.

    Examples
    --------
    >>> elements("N m/min")
    ({'kg': 1, 'm': 2, 's': -3}, 0.01666...)
    """
    powers: dict[str, int] = {}
    factor = 1.0
    for side, part in zip((1, -1), unit.split("/"), strict=False):
        for name, power in _FACTOR.findall(part):
            own, size = _BASE[name]
            times = side * int(power or 1)
            factor *= size**times
            for base, exponent in own.items():
                powers[base] = powers.get(base, 0) + times * exponent
    return {base: power for base, power in powers.items() if power}, factor


def used(units: Iterable[str]) -> list[str]:
    """The units that must be defined, each once, in an order that depends on nothing else."""
    return sorted(set(units) - {"", "-"})


LENGTHS: Final = 50.0
"""Duration that is proposed, in ship lengths over the approach speed."""
_VARIABILITY: Final = {
    "independent": "continuous",
    "input": "continuous",
    "output": "continuous",
    "local": "continuous",
    "parameter": "fixed",
    "calculatedParameter": "fixed",
}
_FOLLOWS: Final = ("output", "local", "calculatedParameter")


def description_text(
    model: Model, table: Table, *, fmi: int, identifier: str, token: str, pace: float
) -> str:
    """The text of modelDescription.xml.

    pace [1/s].
    """
    root = ET.Element(
        "fmiModelDescription",
        {
            "fmiVersion": f"{fmi}.0",
            "modelName": plain(model.name),
            "guid" if fmi == 2 else "instantiationToken": token,
            "description": plain(model.title or model.name),
            "generationTool": f"pmmkit {__version__}",
            "variableNamingConvention": "structured",
            **({"numberOfEventIndicators": "0"} if fmi == 2 else {}),
        },
    )
    _interfaces(root, fmi, identifier)
    _units(root, table)
    categories = ET.SubElement(root, "LogCategories")
    ET.SubElement(
        categories, "Category", name="logStatusError", description="What was wrong and what to do."
    )
    ET.SubElement(
        root,
        "DefaultExperiment",
        startTime="0",
        stopTime=f"{LENGTHS / pace:.0f}",
        tolerance=f"{Prepared.RTOL:g}",
        stepSize=f"{0.05 / pace:.1g}",
    )
    variables = ET.SubElement(root, "ModelVariables")
    write: Callable[[ET.Element, Table, int], None] = _variable_2 if fmi == 2 else _variable_3
    for place in range(len(table.variables)):
        write(variables, table, place)
    _structure(ET.SubElement(root, "ModelStructure"), table, fmi)
    return _text(root)


def build_text(identifier: str, source: str) -> str:
    """The text of buildDescription.xml, by which importers of FMI 3 compile the sources."""
    root = ET.Element("fmiBuildDescription", fmiVersion="3.0")
    build = ET.SubElement(root, "BuildConfiguration", modelIdentifier=identifier)
    files = ET.SubElement(build, "SourceFileSet", language="C99")
    ET.SubElement(files, "SourceFile", name=source)
    return _text(root)


def _text(root: ET.Element) -> str:
    ET.indent(root)
    body = ET.tostring(root, encoding="unicode")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{body}\n'


def _interfaces(root: ET.Element, fmi: int, identifier: str) -> None:
    states = "canGetAndSetFMUstate" if fmi == 2 else "canGetAndSetFMUState"
    bytes_ = "canSerializeFMUstate" if fmi == 2 else "canSerializeFMUState"
    common = {"modelIdentifier": identifier, states: "true", bytes_: "true"}
    exchange = ET.SubElement(root, "ModelExchange", common)
    simulation = ET.SubElement(
        root, "CoSimulation", {**common, "canHandleVariableCommunicationStepSize": "true"}
    )
    if fmi == 2:
        for interface in (exchange, simulation):
            files = ET.SubElement(interface, "SourceFiles")
            ET.SubElement(files, "File", name="fmi2.c")


def _units(root: ET.Element, table: Table) -> None:
    units = ET.SubElement(root, "UnitDefinitions")
    for unit in used(item.unit for item in table.variables):
        powers, factor = elements(unit)
        entry = ET.SubElement(units, "Unit", name=modelica(unit))
        base = {name: str(power) for name, power in powers.items()}
        ET.SubElement(entry, "BaseUnit", base | ({} if factor == 1.0 else {"factor": repr(factor)}))
        for shown in SHOWN.get(unit, ()):
            size = 1.0 / elements(shown)[1]
            ET.SubElement(entry, "DisplayUnit", name=modelica(shown), factor=repr(size))


def _numeric(item: FmuVariable) -> dict[str, str]:
    """What both versions say of a number."""
    said: dict[str, str] = {}
    if item.unit != "-":
        said["unit"] = modelica(item.unit)
        shown = SHOWN.get(item.unit)
        if shown:
            said["displayUnit"] = modelica(shown[0])
    if item.low is not None:
        said["min"] = repr(float(item.low))
    if item.high is not None:
        said["max"] = repr(float(item.high))
    if item.nominal:
        said["nominal"] = repr(float(item.nominal))
    if item.start is not None:
        said["start"] = repr(float(item.start))
    return said


def _said(table: Table, place: int) -> dict[str, str]:
    """What both versions say of every variable."""
    item = table.variables[place]
    said = {
        "name": item.name,
        "valueReference": str(place),
        "description": plain(item.text),
        "causality": item.causality,
        "variability": _VARIABILITY[item.causality],
    }
    if item.causality in _FOLLOWS:
        said["initial"] = "calculated"
    elif item.causality == "parameter":
        said["initial"] = "exact"
    return said


def _variable_3(parent: ET.Element, table: Table, place: int) -> None:
    item, said = table.variables[place], _said(table, place)
    if item.is_word:
        ET.SubElement(parent, "Boolean", said | {"start": _word(item)})
        return
    more = {"derivative": str(table.places[item.rate_of])} if item.rate_of else {}
    ET.SubElement(parent, "Float64", said | _numeric(item) | more)


def _variable_2(parent: ET.Element, table: Table, place: int) -> None:
    item = table.variables[place]
    scalar = ET.SubElement(parent, "ScalarVariable", _said(table, place))
    if item.is_word:
        ET.SubElement(scalar, "Boolean", start=_word(item))
        return
    more = {"derivative": str(table.places[item.rate_of] + 1)} if item.rate_of else {}
    ET.SubElement(scalar, "Real", _numeric(item) | more)


def _word(item: FmuVariable) -> str:
    return "true" if item.start else "false"


def _structure(parent: ET.Element, table: Table, fmi: int) -> None:
    """Outputs, rates, and what must be computed at the start; each depends on all there is."""
    items = list(enumerate(table.variables))
    outputs = [place for place, item in items if item.causality == "output"]
    rates = [place for place, item in items if item.rate_of]
    begins = [table.places[name] for name in table.states]
    calculated = [place for place, item in items if item.causality == "calculatedParameter"]
    groups: Mapping[str, tuple[str, Any]] = {
        "Outputs": ("Output", outputs),
        "Derivatives": ("ContinuousStateDerivative", rates),
        "InitialUnknowns": ("InitialUnknown", sorted({*outputs, *rates, *begins, *calculated})),
    }
    for group, (single, places) in groups.items():
        if fmi == 2:
            within = ET.SubElement(parent, group)
            for place in places:
                ET.SubElement(within, "Unknown", index=str(place + 1))
        else:
            for place in places:
                ET.SubElement(parent, single, valueReference=str(place))
