"""Derivative tables as NetCDF4 (HDF5).

They are sealed: a damaged file is refused before it is opened. Files without a seal
(saved again by other programs) are read and checked by their fingerprint.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Final

import numpy as np

from pmmkit.base import Problem, TableError
from pmmkit.files import atomic_path, is_intact
from pmmkit.models.tables.io.content import NOT_READ, assemble
from pmmkit.models.tables.table import NESTED, DerivativeTable, flat

_DIMENSIONS: Final = {
    "Fn": ("Fn",),
    "derivative": ("derivative",),
    "Fn_2": ("Fn_2",),
    "derivative_2": ("derivative_2",),
    "value": ("Fn", "derivative"),
    "covariance": ("Fn", "derivative", "Fn_2", "derivative_2"),
    "dof": ("Fn", "derivative"),
    "method": ("Fn", "derivative"),
    "runs": ("Fn", "derivative"),
}
_TEXTS: Final = frozenset({"derivative", "derivative_2", "method"})
_REMEDY: Final = "Write the file again."


def write_netcdf(table: DerivativeTable, path: str | Path) -> None:
    """Write a table as NetCDF4; the same table gives the same bytes."""
    import h5netcdf
    import h5py

    k, n = table.value.shape
    names = np.array(table.names, dtype=object)
    content: dict[str, Any] = {
        "Fn": table.Fn,
        "derivative": names,
        "Fn_2": table.Fn,
        "derivative_2": names,
        "value": table.value,
        "covariance": table.covariance,
        "dof": table.dof,
        "method": table.method.astype(object),
        "runs": table.runs,
    }
    with atomic_path(path, sealed=True) as part, h5netcdf.File(part, "w") as file:
        file.dimensions = {"Fn": k, "derivative": n, "Fn_2": k, "derivative_2": n}
        for key, value in flat(table.attributes()).items():
            file.attrs[key] = value
        for name, dimensions in _DIMENSIONS.items():
            kind = h5py.string_dtype() if name in _TEXTS else content[name].dtype
            file.create_variable(name, dimensions, kind, data=content[name])


def read_netcdf(path: str | Path) -> DerivativeTable:
    """Read a table from NetCDF4."""
    import h5netcdf
    import h5py

    name = str(path)
    if is_intact(path) is False:
        raise TableError(
            Problem(message="is damaged: its checksum is another.", file=name, remedy=_REMEDY),
            title=NOT_READ,
        )
    try:
        with h5py.File(path, "r") as raw, h5netcdf.File(raw, "r") as file:
            missing = [key for key in _DIMENSIONS if key not in file.variables]
            if missing:
                raise TableError(
                    [
                        Problem(message="is missing.", file=name, column=key, remedy=_REMEDY)
                        for key in missing
                    ],
                    title=NOT_READ,
                )
            content = {key: file.variables[key][...] for key in _DIMENSIONS}
            header = {key: _attribute(key, value) for key, value in file.attrs.items()}
        return assemble(
            names=tuple(_texts(content["derivative"])),
            Fn=np.asarray(content["Fn"], float),
            value=np.asarray(content["value"], float),
            covariance=np.asarray(content["covariance"], float),
            dof=np.asarray(content["dof"], float),
            method=_texts(content["method"]),
            runs=content["runs"],
            header=header,
            file=name,
            remedy=_REMEDY,
        )
    except TableError:
        raise
    except Exception as error:
        raise TableError(
            Problem(
                message=f"is not a readable derivative table ({type(error).__name__}: {error}).",
                file=name,
                remedy="The file is damaged or of another kind. Write it again.",
            ),
            title=NOT_READ,
        ) from error


def _attribute(key: str, value: Any) -> Any:
    if key in NESTED:
        return json.loads(value)
    return value.item() if isinstance(value, np.generic) else value


def _texts(array: Any) -> list[str]:
    return [item.decode() if isinstance(item, bytes) else str(item) for item in np.ravel(array)]
