"""Names that the columns of a run may have, and what each is measured in."""

from __future__ import annotations

import math
import re
from functools import cache
from typing import Final

from pmmkit.conventions.derivatives import is_unit, unit_factor

FORCE_CHANNELS: Final = ("X", "Y", "N", "K", "T", "Q", "FX_rudder", "FY_rudder")

CHANNEL_UNITS: Final[dict[str, str]] = {
    "t": "s",
    "X": "N",
    "Y": "N",
    "N": "N m",
    "K": "N m",
    "u": "m/s",
    "v": "m/s",
    "r": "rad/s",
    "p": "rad/s",
    "phi": "rad",
    "udot": "m/s2",
    "vdot": "m/s2",
    "rdot": "rad/s2",
    "pdot": "rad/s2",
    "delta": "rad",
    "n": "1/s",
    "T": "N",
    "Q": "N m",
    "FX_rudder": "N",
    "FY_rudder": "N",
    "sinkage": "m",
    "trim": "rad",
    "speed": "m/s",
    "U_carriage": "m/s",
    "Y_forward": "N",
    "Y_aft": "N",
    "y_forward": "m",
    "y_aft": "m",
    "x": "m",
    "y": "m",
    "psi": "rad",
    "xdot": "m/s",
    "ydot": "m/s",
    "wind_speed": "m/s",
    "wind_direction": "rad",
    "lat": "deg",
    "lon": "deg",
    "sog": "m/s",
    "cog": "rad",
}
"""SI unit of each channel of a history or of a row of means; positions on the earth stay in
degrees."""

DEGREE_CHANNELS: Final[dict[str, str]] = {
    "psi_deg": "psi",
    "phi_deg": "phi",
    "heel_deg": "phi",
    "delta_deg": "delta",
    "rudder_deg": "delta",
    "waterjet_deg": "delta",
    "trim_deg": "trim",
    "wind_direction_deg": "wind_direction",
    "cog_deg": "cog",
}
"""Names of columns in degrees, and the channels that they become."""

_HARMONIC: Final = re.compile(
    rf"(?P<channel>{'|'.join(FORCE_CHANNELS)})_"
    r"(?:(?P<mean>mean)|(?P<std>std)|(?P<part>sin|cos|in|out)(?P<order>[1-9][0-9]?))"
)
_WITH_UNIT: Final = re.compile(
    r"(?P<name>.*?)\s*(?:\[(?P<square>[^\[\]]*)\]|\((?P<round>[^()]*)\))"
)


def harmonic_part(name: str) -> tuple[str, str, int] | None:
    """Channel, part (``mean``, ``std``, ``sin``, ``cos``, ``in``, ``out``) and harmonic.

    Parameters
    ----------
    name : str
        Of a column of a table; any other gives None.

    Examples
    --------
    >>> harmonic_part("FX_rudder_cos3")
    ('FX_rudder', 'cos', 3)
    >>> harmonic_part("X") is None
    True
    """
    found = _HARMONIC.fullmatch(name)
    if found is None:
        return None
    part = found["mean"] or found["std"] or found["part"]
    return found["channel"], part, int(found["order"] or 0)


def split_unit(header: str) -> tuple[str, str | None]:
    """Name and unit of a column header written ``name [unit]`` or ``name (unit)``.

    Round brackets count as a unit only where they hold one that is known.

    Parameters
    ----------
    header : str
        What stands over the column.

    Examples
    --------
    >>> split_unit("X [kN]"), split_unit("beta(deg)"), split_unit("Force (model)")
    (('X', 'kN'), ('beta', 'deg'), ('Force (model)', None))
    """
    found = _WITH_UNIT.fullmatch(header.strip())
    if found is None:
        return header.strip(), None
    if found["square"] is not None:
        return found["name"], found["square"].strip()
    if not is_unit(found["round"]):
        return header.strip(), None
    return found["name"], found["round"].strip()


@cache
def unit_in_name(name: str) -> tuple[str, str] | None:
    """Channel and unit of a column whose name ends in its unit; None if it does not.

    A stroke of the unit may be written as an underscore. ``in`` is no unit here, where it may say
    what goes in.

    Examples
    --------
    >>> unit_in_name("psi_deg"), unit_in_name("r_deg_s"), unit_in_name("u_knots")
    (('psi', 'deg'), ('r', 'deg/s'), ('u', 'knots'))
    >>> unit_in_name("FX_rudder"), unit_in_name("r_kg"), unit_in_name("r_filtered")
    (None, None, None)
    """
    if name in DEGREE_CHANNELS:
        return DEGREE_CHANNELS[name], "deg"
    if name in CHANNEL_UNITS:
        return None
    for place in [found.start() for found in re.finditer("_", name)]:
        channel, tail = name[:place], name[place + 1 :]
        if channel not in CHANNEL_UNITS or tail in ("", "in"):
            continue
        for unit in (tail, tail.replace("_", "/")):
            if is_unit(unit) and factor_to(unit, CHANNEL_UNITS[channel]) is not None:
                return channel, unit
    return None


def channel_of(name: str) -> str:
    """The channel that a column of that name becomes; any other name as it is.

    Parameters
    ----------
    name : str
        Of a column, with its unit or without.

    Examples
    --------
    >>> channel_of("heel_deg"), channel_of("p_deg_s"), channel_of("drift_deg")
    ('phi', 'p', 'drift_deg')
    """
    found = unit_in_name(name)
    return name if found is None else found[0]


def factor_to(unit: str, target: str) -> float | None:
    """Factor from a unit to a target unit; None if they measure different things.

    Parameters
    ----------
    unit, target : str
        Such as ``kN`` and ``N``.

    Raises
    ------
    DataError
        If the unit is not known.

    Examples
    --------
    >>> factor_to("kN", "N"), factor_to("rad", "deg"), factor_to("m", "N")
    (1000.0, 57.29577951308232, None)
    """
    have, factor = unit_factor(unit)
    want, scale = unit_factor(target)
    if have == want:
        return factor / scale
    if (have, want) == ("rad/s", "1/s"):
        return factor / (2 * math.pi)
    if have == "1/s" and want == "rad/s" and unit.strip().lower() == "1/s":
        return 1.0
    return None
