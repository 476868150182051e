"""Hull, added mass and equations of motion as lines of MATLAB; a table as a function."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from itertools import groupby
from typing import Any, Final

from pmmkit.base import TableError
from pmmkit.conventions import CHANNELS, Convention, Derivative, parse_derivative
from pmmkit.effects import CATALOGUE
from pmmkit.equations import POLYNOMIALS
from pmmkit.exports.text import written_by
from pmmkit.models import DerivativeTable
from pmmkit.syntax import MatlabLine, comment, is_matlab_name, matlab_value

Values = Mapping[str, Mapping[str, Any]]
_FACTORS: Final = {
    "u": "u_p",
    "v": "v_p",
    "r": "r_p",
    "p": "p_p",
    "phi": "phi",
    "d": "delta_p",
    "|u|": "abs(u_p)",
    "|v|": "abs(v_p)",
    "|r|": "abs(r_p)",
    "|p|": "abs(p_p)",
    "|d|": "abs(delta_p)",
}
_FORCE_UNITS: Final = {"prime": "0.5*rho*L**2", "prime-d": "0.5*rho*L*d", "bis": "rho*g*volume"}
_MASS_UNITS: Final = {"prime": "0.5*rho*L**3", "prime-d": "0.5*rho*L**2*d", "bis": "rho*volume"}
_INERTIA: Final = {
    "udot": ("kg", "kg m"),
    "vdot": ("kg", "kg m"),
    "rdot": ("kg m", "kg m2"),
    "pdot": ("kg m", "kg m2"),
}
"""Unit of each acceleration derivative, of a force and of a moment."""


def variable(name: str) -> str:
    """Name of a derivative as MATLAB takes it.

    Examples
    --------
    >>> variable("Yv|v|"), variable("Nvvr")
    ('Yvabsv', 'Nvvr')
    """
    derivative = parse_derivative(name)
    return derivative.channel + "".join(
        f"abs{factor.strip('|')}" if "|" in factor else factor for factor in derivative.factors
    )


def hull_lines(values: Values, convention: Convention, *, rolls: bool) -> list[MatlabLine]:
    """The derivatives, and the hull's forces X, Y, N and K by them."""
    terms: dict[str, float] = {}
    for effect in POLYNOMIALS:
        for name, value in values.get(effect, {}).items():
            if CATALOGUE[effect].parameter(name) is None:
                terms[name] = terms.get(name, 0.0) + value
    bis = convention.system == "bis"
    reference, square = ("sqrt(g*L)", "1") if bis else ("U", "U**2")
    if convention.U == "carriage" and not bis:
        reference, square = "U0", "U0**2"
    surge = "(u - U0)" if convention.surge == "delta-u" else "u"
    sway = "-v" if convention.sway == "beta" else "v"
    rudder = "-delta" if convention.rudder_positive == "port" else "delta"
    lines = [MatlabLine(variable(name), float(value)) for name, value in terms.items()]
    lines += [
        MatlabLine("U_p", reference, note="speed that makes non-dimensional (m/s)"),
        MatlabLine("u_p", f"{surge}/U_p"),
        MatlabLine("v_p", f"{sway}/U_p"),
        MatlabLine("r_p", "r*L/U_p"),
        MatlabLine("p_p", "p*L/U_p"),
        MatlabLine("delta_p", rudder),
        MatlabLine(
            "unit",
            _FORCE_UNITS[convention.system] + ("" if bis else f"*{square}"),
            note="of forces (N), times L of moments",
        ),
    ]
    for channel in CHANNELS if rolls else CHANNELS[:3]:
        mine = [parse_derivative(name) for name in terms if name[0] == channel]
        total = " + ".join(_product(item, convention) for item in mine) or "0"
        arm = "" if channel in "XY" else "*L"
        lines.append(MatlabLine(channel, f"unit{arm}*({total})"))
    return lines


def _product(derivative: Derivative, convention: Convention) -> str:
    """A derivative times its factors, equal ones as powers."""
    factors = derivative.factors
    name = variable(derivative.name)
    if convention.surge == "constant" and factors == ("u", "u"):
        return f"{name}*(U/U_p)**2" if convention.system == "bis" else name
    parts = [name]
    for factor, equal in groupby(item for item in factors if item != "0"):
        count = len(list(equal))
        parts.append(_FACTORS[factor] + (f"**{count}" if count > 1 else ""))
    return "*".join(parts)


def mass_lines(added: Mapping[str, float], convention: Convention) -> list[MatlabLine]:
    """The added mass in SI units."""
    lines = [MatlabLine("mass_unit", _MASS_UNITS[convention.system], note="kg")]
    for name, value in added.items():
        if name == "lx":
            continue
        derivative = parse_derivative(name)
        turned = convention.sway == "beta" and "vdot" in derivative.factors
        moment = derivative.channel not in "XY"
        power = derivative.length_power - 1 + moment
        lines.append(
            MatlabLine(
                variable(name),
                f"{float(-value if turned else value)!r}*mass_unit"
                + ("" if not power else "*L" if power == 1 else f"*L**{power}"),
                note=_INERTIA[derivative.factors[0]][moment],
            )
        )
    return lines


def motion_lines(
    added: Mapping[str, float],
    extra: Mapping[str, list[str]],
    convention: Convention,
    *,
    rolls: bool,
) -> list[MatlabLine]:
    """The equations of motion: accelerations from the forces X, Y, N and K."""

    def share(name: str) -> str:
        own = [variable(name)] if name in added else []
        return "".join(f" - {item}" for item in (*own, *extra.get(name, ())))

    separate = convention.coriolis == "separate"

    def moving(name: str) -> str:
        return f"(mass - {variable(name)})" if separate and name in added else "mass"

    lines = [
        MatlabLine("X", f"X + {moving('Yvdot')}*v*r + mass*xG*r**2"),
        MatlabLine("Y", f"Y - {moving('Xudot')}*u*r"),
        MatlabLine("N", "N - mass*xG*u*r"),
        MatlabLine("m11", f"mass{share('Xudot')}"),
        MatlabLine("m22", f"mass{share('Yvdot')}"),
        MatlabLine("m23", f"mass*xG{share('Yrdot')}"),
        MatlabLine("m32", f"mass*xG{share('Nvdot')}"),
        MatlabLine("m33", f"Izz{share('Nrdot')}"),
        MatlabLine("u_dot", "X/m11"),
    ]
    if not rolls:
        return [
            *lines,
            MatlabLine("detM", "m22*m33 - m23*m32"),
            MatlabLine("v_dot", "(m33*Y - m23*N)/detM"),
            MatlabLine("r_dot", "(m22*N - m32*Y)/detM"),
        ]
    lever = separate and {"Xudot", "lx"} <= set(added)
    return [
        MatlabLine("K", f"K + (mass*zG{' - Xudot*lx*L' if lever else ''})*u*r"),
        *lines,
        MatlabLine("m24", f"-mass*zG{share('Ypdot')}"),
        MatlabLine("m34", f"0{share('Npdot')}"),
        MatlabLine("m42", f"-mass*zG{share('Kvdot')}"),
        MatlabLine("m43", f"0{share('Krdot')}"),
        MatlabLine("m44", f"Ixx{share('Kpdot')}"),
        MatlabLine("c1", "m33*m44 - m34*m43"),
        MatlabLine("c2", "m24*m43 - m23*m44"),
        MatlabLine("c3", "m23*m34 - m24*m33"),
        MatlabLine("detM", "m22*c1 + m32*c2 + m42*c3"),
        MatlabLine("v_dot", "(c1*Y + c2*N + c3*K)/detM"),
        MatlabLine(
            "r_dot", "((m34*m42 - m32*m44)*Y + (m22*m44 - m24*m42)*N + (m24*m32 - m22*m34)*K)/detM"
        ),
        MatlabLine(
            "p_dot", "((m32*m43 - m33*m42)*Y + (m23*m42 - m22*m43)*N + (m22*m33 - m23*m32)*K)/detM"
        ),
    ]


# A derivative table as a function for MATLAB and Octave that gives a structure.


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
