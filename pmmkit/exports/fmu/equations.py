"""The equations of one model as C, with its variables and numbers."""

from __future__ import annotations

import inspect
from collections.abc import Iterable, Iterator, Sequence
from typing import Final

from pmmkit.base import ModelError, Problem
from pmmkit.equations import Prepared
from pmmkit.exports.fmu.variables import BEGIN, GEAR, Table
from pmmkit.exports.text import written_by
from pmmkit.models import Model
from pmmkit.syntax import CProgram, Unwritable, c_number, comment

_MOMENT: Final = ("list", "double", "double", "double", "list", "list")
_FUNCTIONS: Final[dict[str, Sequence[str]]] = {
    "complete": ("list",),
    "rates": _MOMENT,
    "forces": _MOMENT,
    "self_propulsion": ("double", "list", "list", "list"),
    "flow": ("double",) * 2,
    "wind_over_current": ("double",) * 4,
    "gear_rate": ("double",) * 4,
    "ordered": ("list", "int", *("double",) * 5),
    "controlled": ("double", "list", "int"),
    "carried": ("double", "double", "double", "list", "list", "list", "double", "double"),
}
"""What ship.h calls, with the kinds of the arguments."""
_CLOSEST: Final = 1e-13
"""Least relative tolerance, as `simulate` has it."""
_ONLY_FOR: Final = {"self_propulsion": "n_approach", "wind_over_current": "wind_speed"}
"""Functions that only an FMU with a certain variable calls."""
_ASKED: Final = (
    *("time", "delta", "n", "n_approach", "delta_order", "n_order", "bucket"),
    *("current_speed", "current_direction", "wind_speed", "wind_direction"),
    *("wave_height", "wave_direction", "steering_gear", "delta_rate", "delta_max", "delta_lag"),
)
"""Variables that ship.h knows by their names; it does without those that a model has not."""
_SURROUNDINGS: Final = (
    *("current_x", "current_y", "wind_speed", "wind_direction", "wave_height", "wave_direction"),
)


def equations_text(model: Model, ready: Prepared, table: Table, *, token: str) -> str:
    """The text of equations.h."""
    lines = [
        *(line.replace("%", "//", 1) for line in written_by("//")),
        *comment(f"{model.title or model.name}: equations and numbers.", "//"),
        "",
        "#include <math.h>",
        "",
        _program(ready, table).text,
        *_numbers(table),
        "",
        *_defined(ready, table, token),
    ]
    return "\n".join(lines) + "\n"


def _program(ready: Prepared, table: Table) -> CProgram:
    text, module = ready.program()
    program = CProgram(text, module)
    problems = []
    for item in ready.structure.used:
        name = f"effect_{item.effect}"
        tables = {own for own, _ in item.tables}
        options = {own for own, _ in item.options}
        asked = [
            "table" if x in tables else "int" if x in options else "double"
            for x in inspect.signature(getattr(module, name)).parameters
        ]
        try:
            program.take(name, asked)
        except Unwritable as error:
            problems.append(
                Problem(
                    message=f"{item.effect}: it is written with {error}.",
                    remedy="Leave it out to export the rest.",
                )
            )
    if problems:
        raise ModelError(problems, title=f"Model {ready.name!r} cannot be written as C")
    for name, kinds in _FUNCTIONS.items():
        if _ONLY_FOR.get(name, "time") in table.places:
            program.take(name, kinds)
    return program


def _numbers(table: Table) -> Iterator[str]:
    yield "struct slope { int place; int variable; double size; };"
    starts = [0.0 if item.start is None else item.start for item in table.variables]
    yield from _listed("double START", starts)
    yield from _listed("double BASE", table.base)
    nominal = (item.nominal for item in table.variables if item.name in table.states)
    yield from _listed("double NOMINAL", [size or 1.0 for size in nominal])
    slopes = [
        f"{{{place}, {variable}, {c_number(size)}}}"
        for variable, item in enumerate(table.variables)
        for place, size in item.slopes
    ]
    yield f"static const struct slope SLOPE[{len(slopes)}] = {{"
    yield from _rows(slopes)
    yield "};"


def _listed(name: str, values: Iterable[float]) -> list[str]:
    texts = [c_number(float(value)) for value in values]
    return [f"static const {name}[{len(texts)}] = {{", *_rows(texts), "};"]


def _rows(texts: list[str]) -> list[str]:
    return [f"    {', '.join(texts[i : i + 6])}," for i in range(0, len(texts), 6)]


def _defined(ready: Prepared, table: Table, token: str) -> Iterator[str]:
    """The names by which ship.h knows all that."""
    places, states = table.places, table.states
    known = {
        "TOKEN": f'"{token}"',
        "TOLERANCE": c_number(Prepared.RTOL),
        "CLOSEST": c_number(_CLOSEST),
        "LONGEST_STEP": c_number(ready.longest_step),
        "VARIABLES": len(table.variables),
        "CONSTANTS": len(table.base),
        "STATES": len(states),
        **ready.gears(),
        "SLOPES": sum(len(item.slopes) for item in table.variables),
        "FIRST_STATE": places[states[0]],
        "U_STATE": states.index("u"),
        "FIRST_RATE": places[f"der({states[0]})"],
        "GEAR_STATE": places[GEAR],
        "GEAR_RATE": places[f"der({GEAR})"],
        "FIRST_FORCE": places["X"],
        "FIRST_INPUT": places["delta_order"],
        "FIRST_BEGIN": places[f"{states[0]}{BEGIN}"],
        "FIRST_PARAMETER": places[f"{states[0]}{BEGIN}"],
        **{f"V_{name.upper()}": places[name] for name in _ASKED if name in places},
        **{f"K_{name.upper()}": ready.place(name) for name in _SURROUNDINGS},
    }
    for name, value in known.items():
        yield f"#define {name} {value}"
