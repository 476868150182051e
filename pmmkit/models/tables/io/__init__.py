"""Files of derivative tables: CSV with a JSON file beside it, NetCDF4/HDF5, Excel, LaTeX."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Final

from pmmkit.base import Problem, TableError
from pmmkit.conventions import Convention, Ship, Water
from pmmkit.models.tables.io.excel import read_excel, write_excel
from pmmkit.models.tables.io.netcdf import read_netcdf, write_netcdf
from pmmkit.models.tables.io.text import read_csv, sidecar_of, to_latex, write_csv, write_latex
from pmmkit.models.tables.table import DerivativeTable

__all__ = ["is_table", "read_table", "sidecar_of", "to_latex", "write_table"]

_WRITERS: Final[dict[str, Callable[[DerivativeTable, Path], None]]] = {
    ".csv": write_csv,
    ".nc": write_netcdf,
    ".h5": write_netcdf,
    ".xlsx": write_excel,
    ".tex": write_latex,
}
_READERS: Final[dict[str, Callable[..., DerivativeTable]]] = {
    ".csv": read_csv,
    ".nc": read_netcdf,
    ".h5": read_netcdf,
    ".xlsx": read_excel,
}


def is_table(path: str | Path) -> bool:
    """Whether a path has the ending of a table that can be read; other words name a model.

    Examples
    --------
    >>> is_table("out/derivatives.csv"), is_table("kvlcc2")
    (True, False)
    """
    return Path(path).suffix.lower() in _READERS


def write_table(table: DerivativeTable, path: str | Path) -> Path:
    """Write a table in the format that the suffix names; all of it or nothing.

    Parameters
    ----------
    table : DerivativeTable
        The table.
    path : path
        ``.csv``: the columns Fn, derivative, value, std, ci_low, ci_high, method, runs (Fn empty
        for a pooled table, an empty cell where there is no value) and, beside it, a ``.json`` file
        of the same stem with everything else. ``.nc`` or ``.h5``: NetCDF4. ``.xlsx``: the sheets
        derivatives, covariance, about. ``.tex``: booktabs, for reading only.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    TableError
        If the suffix is not known or the file cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> from pmmkit.models.tables.compare import identical
    >>> from pmmkit.models.tables.table import from_values
    >>> ship = Ship(name="m", L=4.0, B=1.0, d=.25, volume=.5, mass=500., Izz=500.)
    >>> table = from_values({"Yv": [-.01, -.012]}, std={"Yv": .001}, Fn=[.1, .2],
    ...                     ship=ship, water=Water())
    >>> file = write_table(table, Path(tempfile.mkdtemp()) / "derivatives.csv")
    >>> identical(read_table(file), table)
    True
    """
    target = Path(path)
    writer = _WRITERS.get(target.suffix.lower())
    if writer is None:
        raise TableError(_unknown(target, _WRITERS))
    try:
        writer(table, target)
    except UnicodeError as error:
        raise TableError(
            Problem(message="a name or a method is no text in UTF-8.", file=str(target))
        ) from error
    except OSError as error:
        raise TableError(
            Problem(message=f"cannot be written: {error.strerror or error}.", file=str(target))
        ) from error
    return target


def read_table(
    path: str | Path,
    *,
    convention: Convention | None = None,
    ship: Ship | None = None,
    water: Water | None = None,
) -> DerivativeTable:
    """Read a table that `write_table` wrote, or a CSV with the same columns.

    Parameters
    ----------
    path : path
        A ``.csv``, ``.nc``, ``.h5`` or ``.xlsx`` file.
    convention, ship, water
        For a CSV without its ``.json`` file: what its numbers mean. What is not given is assumed
        and noted in the table; other files know their own.

    Raises
    ------
    TableError
        If the file is missing, damaged or not a derivative table; every problem is listed with
        file, row and column.
    """
    source = Path(path)
    if not is_table(source):
        raise TableError(_unknown(source, _READERS))
    if not source.is_file():
        raise TableError(
            Problem(message="there is no such file.", file=str(source), remedy="Check the path.")
        )
    try:
        reader = _READERS[source.suffix.lower()]
        if reader is read_csv:
            return read_csv(source, convention=convention, ship=ship, water=water)
        return reader(source)
    except OSError as error:
        raise TableError(
            Problem(message=f"cannot be read: {error.strerror or error}.", file=str(source))
        ) from error


def _unknown(path: Path, known: Iterable[str]) -> Problem:
    return Problem(
        message=f"the suffix {path.suffix!r} is not that of a derivative table.",
        file=str(path),
        remedy=f"Known: {', '.join(known)}.",
    )
