"""Derivative tables as CSV, with a JSON file beside them for what a CSV cannot hold, and LaTeX."""

from __future__ import annotations

import csv
import io
import json
import math
from pathlib import Path
from typing import Any, Final, Literal

import numpy as np

from pmmkit.base import Problem, TableError
from pmmkit.conventions import CHANNELS, Convention, Ship, Water
from pmmkit.files import write_text
from pmmkit.models.tables.io.content import NOT_READ, assemble
from pmmkit.models.tables.io.rows import COLUMNS, TableGrid, cell_text, read_rows
from pmmkit.models.tables.table import DerivativeTable
from pmmkit.numerics import Array
from pmmkit.presentation import plus_minus, safe_cell, text_of_cell, with_uncertainty

Style = Literal["parentheses", "plus-minus"]
UNKNOWN_SHIP: Final = Ship(
    name="unknown", L=math.nan, B=math.nan, d=math.nan, volume=math.nan, mass=math.nan, Izz=math.nan
)
ALONE: Final = (
    "Read from a CSV alone: derivatives taken as independent, degrees of freedom as infinite."
)
ASSUMED: Final = {
    "convention": "Convention assumed: prime, instantaneous U, total coefficients as measured.",
    "ship": "Ship not known: conversions that need its lengths are refused.",
    "water": "Water assumed: rho 1025 kg/m³, g 9.81 m/s².",
}


def sidecar_of(path: str | Path) -> Path:
    """The JSON file that belongs to a CSV table."""
    return Path(path).with_suffix(".json")


def write_csv(table: DerivativeTable, path: str | Path) -> None:
    """Write a table as CSV and the JSON file beside it."""
    low, high = table.interval()
    numbers = np.stack([table.value, table.std, low, high])
    stream = io.StringIO(newline="")
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(COLUMNS)
    for row, speed in enumerate(table.Fn):
        for column, name in enumerate(table.names):
            writer.writerow(
                [
                    cell_text(speed),
                    safe_cell(name),
                    *map(cell_text, numbers[:, row, column]),
                    safe_cell(str(table.method[row, column])),
                    int(table.runs[row, column]),
                ]
            )
    content = table.attributes() | {
        "Fn": _jsonable(table.Fn),
        "names": list(table.names),
        "dof": _jsonable(table.dof),
        "covariance": _jsonable(_square(table.covariance)),
    }
    write_text(path, stream.getvalue())
    write_text(sidecar_of(path), _dump(content))


def read_csv(
    path: str | Path,
    *,
    convention: Convention | None = None,
    ship: Ship | None = None,
    water: Water | None = None,
) -> DerivativeTable:
    """Read a table from a CSV, with the JSON file beside it where there is one.

    Convention, ship and water are for a CSV that stands alone.
    """
    source = Path(path)
    grid = read_rows(_lines(source), file=str(source))
    sidecar = sidecar_of(source)
    if not sidecar.is_file():
        return _alone(grid, convention, ship, water)
    file = str(sidecar)
    remedy = f"Restore both, or remove {sidecar.name} to read {source.name} alone."
    try:
        content = json.loads(sidecar.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise TableError(
            Problem(message=f"is not readable JSON ({error}).", file=file, remedy=remedy),
            title=NOT_READ,
        ) from error
    problems: list[Problem] = []
    content = content if isinstance(content, dict) else {}
    names, k, n = content.get("names"), len(grid.Fn), len(grid.names)
    if not isinstance(names, list) or sorted(map(str, names)) != sorted(grid.names):
        problems.append(
            Problem(message=f"names are not those of {source.name}.", file=file, remedy=remedy)
        )
    wanted = {"Fn": (k,), "dof": (k, n), "covariance": (k * n, k * n)}
    arrays = {key: _array(content.get(key), shape) for key, shape in wanted.items()}
    problems += [
        Problem(
            message=f"{key} is not a list of {' x '.join(map(str, wanted[key]))} numbers.",
            file=file,
            remedy=remedy,
        )
        for key, array in arrays.items()
        if array is None
    ]
    if problems:
        raise TableError(problems, title=NOT_READ)
    Fn, dof, covariance = (arrays[key] for key in wanted)
    assert Fn is not None
    assert dof is not None
    assert covariance is not None
    assert isinstance(names, list)
    grid = grid.ordered(names)
    table = assemble(
        names=grid.names,
        Fn=grid.Fn,
        value=grid.numbers["value"],
        covariance=covariance.reshape(k, n, k, n),
        dof=dof,
        method=grid.method,
        runs=grid.runs,
        header=content,
        file=f"{source} and {sidecar.name}",
        remedy=remedy,
    )
    grid.check(table, file=str(source), remedy=remedy)
    return table


def _alone(
    grid: TableGrid, convention: Convention | None, ship: Ship | None, water: Water | None
) -> DerivativeTable:
    given = {"convention": convention, "ship": ship, "water": water}
    assumed = [ASSUMED[name] for name, part in given.items() if part is None]
    k, n = grid.numbers["value"].shape
    return DerivativeTable(
        names=grid.names,
        Fn=grid.Fn,
        value=grid.numbers["value"],
        covariance=np.diag(grid.numbers["std"].ravel() ** 2).reshape(k, n, k, n),
        dof=np.full((k, n), np.inf),
        method=grid.method,
        runs=grid.runs,
        convention=convention or Convention(),
        ship=ship or UNKNOWN_SHIP,
        water=water or Water(),
        notes=(ALONE, *assumed),
    )


def _lines(source: Path) -> list[tuple[int, list[str]]]:
    """The rows of a CSV with their numbers; blank lines are left out."""
    file = str(source)
    content = source.read_bytes()
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        row = content.count(b"\n", 0, error.start) + 1
        raise TableError(
            Problem(message="is not UTF-8 text.", file=file, row=row), title=NOT_READ
        ) from error
    reader = csv.reader(io.StringIO(text, newline=""), strict=True)
    try:
        return [(reader.line_num, [*map(text_of_cell, cells)]) for cells in reader if cells]
    except csv.Error as error:
        raise TableError(
            Problem(message=f"is not CSV ({error}).", file=file, row=reader.line_num),
            title=NOT_READ,
        ) from error


def _square(covariance: Array) -> Array:
    k, n = covariance.shape[:2]
    return covariance.reshape(k * n, k * n)


def _jsonable(array: Array) -> Any:
    """Nested lists with null for NaN and "inf" for infinity."""
    items = array.astype(object)
    items[np.isnan(array)] = None
    items[np.isinf(array)] = "inf"
    return items.tolist()


def _array(given: Any, shape: tuple[int, ...]) -> Array | None:
    """The array behind nested lists; None where they are not one of that shape."""
    try:
        items = np.array(given, dtype=object)
    except ValueError:
        return None
    if items.shape != shape:
        return None
    flat = [math.nan if x is None else math.inf if x == "inf" else x for x in items.ravel()]
    if not all(isinstance(x, int | float) and not isinstance(x, bool) for x in flat):
        return None
    try:
        return np.array(flat, float).reshape(shape)
    except OverflowError:
        return None


def _dump(content: dict[str, Any]) -> str:
    """JSON with a line per entry and per row of the covariance."""
    lines = []
    for key, value in content.items():
        if key == "covariance":
            text = "[\n" + ",\n".join(json.dumps(row) for row in value) + "\n]"
        else:
            text = json.dumps(value)
        lines.append(f"{json.dumps(key)}: {text}")
    return "{\n" + ",\n".join(lines) + "\n}\n"


def to_latex(table: DerivativeTable, *, style: Style = "parentheses") -> str:
    """The table as LaTeX text for the package booktabs: a column per Froude number, rows grouped
    by channel. An empty cell is a value that the runs do not determine.
    """
    std = table.std
    heads = [""] if table.pooled else [f"$Fn = {speed:.3f}$" for speed in table.Fn]
    told = plus_minus if style == "plus-minus" else with_uncertainty
    lines = [
        rf"\begin{{tabular}}{{l{'r' * len(heads)}}}",
        r"\toprule",
        " & ".join(["", *heads] if any(heads) else ["", "all speeds"]) + r" \\",
    ]
    for channel in CHANNELS:
        columns = [place for place, name in enumerate(table.names) if name[0] == channel]
        if columns:
            lines.append(r"\midrule")
        for column in columns:
            cells = [
                told(value, spread).replace("±", r"\pm")
                for value, spread in zip(table.value[:, column], std[:, column], strict=True)
            ]
            name = table.convention.latex(table.names[column])
            lines.append(
                " & ".join([f"${name}$", *(f"${cell}$" if cell else "--" for cell in cells)])
                + r" \\"
            )
    return "\n".join([*lines, r"\bottomrule", r"\end{tabular}", ""])


def write_latex(table: DerivativeTable, path: str | Path, *, style: Style = "parentheses") -> None:
    """Write a table as LaTeX text."""
    write_text(path, to_latex(table, style=style))
