"""A derivative table as a function for MATLAB and Octave that gives a structure."""

from __future__ import annotations

from dataclasses import asdict
from typing import Final

from pmmkit.base import TableError
from pmmkit.exports.matlab.hull import variable
from pmmkit.exports.text import written_by
from pmmkit.models import DerivativeTable
from pmmkit.syntax import comment, is_matlab_name, matlab_value

_PARTICULARS: Final = {
    "L": "length between perpendiculars (m)",
    "B": "breadth (m)",
    "d": "draught (m)",
    "volume": "displaced volume (m3)",
    "mass": "mass (kg)",
    "Izz": "yaw inertia (kg m2)",
    "xG": "centre of gravity forward of midship (m)",
}


def table_to_mss(table: DerivativeTable, *, name: str = "derivatives") -> str:
    """The text of a function ``table = name()`` with the derivatives over the Froude number.

    Examples
    --------
    >>> from pmmkit.conventions import Ship, Water
    >>> from pmmkit.models import from_values
    >>> ship = Ship(name="m", L=4.0, B=1.0, d=.25, volume=.5, mass=500., Izz=500.)
    >>> table = from_values({"Yv|v|": [-.01, -.012]}, Fn=[.1, .2], ship=ship, water=Water())
    >>> [line for line in table_to_mss(table).splitlines() if "Yv" in line][0]
    'table.Yvabsv = [-0.01, -0.012];'
    """
    if not is_matlab_name(name):
        raise TableError(
            f"{name!r} is no name of a function in MATLAB. Choose a file name of letters, digits "
            f"and underscores that starts with a letter."
        )
    known = [(variable(item), column) for column, item in enumerate(table.names)]
    return "\n".join(
        [
            f"function table = {name}()",
            *comment(
                f"Derivatives of {table.ship.name} over the Froude number; NaN where the tests do "
                f"not determine a value. Non-dimensional as table.convention says, standard "
                f"uncertainties in table.std."
            ),
            *(line for note in table.notes for line in comment(f"Note: {note}")),
            *written_by(),
            *(
                line
                for key, value in table.provenance.items()
                for line in comment(f"Provenance: {key}: {value}")
            ),
            "",
            f"table.Fn = {matlab_value(list(table.Fn))};",
            *(
                f"table.{item} = {matlab_value(list(table.value[:, column]))};"
                for item, column in known
            ),
            "",
            *(
                f"table.std.{item} = {matlab_value(list(table.std[:, column]))};"
                for item, column in known
            ),
            "",
            f"table.ship.name = {matlab_value(table.ship.name)};",
            *(
                f"table.ship.{item} = {matlab_value(getattr(table.ship, item))};  % {text}"
                for item, text in _PARTICULARS.items()
            ),
            f"table.water.rho = {matlab_value(table.water.rho)};  % density (kg/m3)",
            f"table.water.g = {matlab_value(table.water.g)};  % gravity (m/s2)",
            *(
                f"table.convention.{name} = {matlab_value(value)};"
                for name, value in asdict(table.convention).items()
            ),
            "",
            "end",
            "",
        ]
    )
