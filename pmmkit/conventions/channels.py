"""Names that the columns of a run may have, and what each is measured in."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Iterable
from functools import cache
from typing import Final

from pmmkit.conventions.derivatives import is_unit, unit_factor

FORCE_CHANNELS: Final = ("X", "Y", "N", "K", "T", "Q", "FX_rudder", "FY_rudder")
MOMENTS: Final = frozenset({"N", "K", "Q"})

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

STRUT_CHANNELS: Final = frozenset({"y_forward", "y_aft"})
"""Positions of two struts across the tank, which tell place and heading of the hull."""

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

SETTING_UNITS: Final[dict[str, str]] = {
    "speed": "m/s",
    "drift_deg": "deg",
    "heel_deg": "deg",
    "rudder_deg": "deg",
    "propeller_rps": "1/s",
    "period": "s",
    "frequency_hz": "1/s",
    "amplitude_m": "m",
    "yaw_amplitude_deg": "deg",
    "rudder_amplitude_deg": "deg",
    "path_amplitude_m": "m",
    "strut_amplitude_m": "m",
    "strut_phase_deg": "deg",
    "phase_deg": "deg",
    "yaw_rate": "rad/s",
    "radius": "m",
    "depth": "m",
    "switch_deg": "deg",
    "wave_height": "m",
    "wave_period": "s",
    "waves_from_deg": "deg",
    "vdot_amplitude": "",
    "v_amplitude": "",
    "r_amplitude": "",
    "rdot_amplitude": "",
}
"""Unit of each numeric setting of a run, as the campaign file states it."""

_HARMONIC: Final = re.compile(
    rf"(?P<channel>{'|'.join(FORCE_CHANNELS)})_"
    r"(?:(?P<mean>mean)|(?P<std>std)|(?P<part>sin|cos|in|out)(?P<order>[1-9][0-9]?))"
)
_WITH_UNIT: Final = re.compile(
    r"(?P<name>.*?)\s*(?:\[(?P<square>[^\[\]]*)\]|\((?P<round>[^()]*)\))"
)
_TABLE_CHANNELS: Final = (*FORCE_CHANNELS, "n", "sinkage", "trim")


def harmonic_part(name: str) -> tuple[str, str, int] | None:
    """Channel, part (``mean``, ``std``, ``sin``, ``cos``, ``in``, ``out``) and harmonic.

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

    Examples
    --------
    >>> channel_of("heel_deg"), channel_of("p_deg_s"), channel_of("drift_deg")
    ('phi', 'p', 'drift_deg')
    """
    found = unit_in_name(name)
    return name if found is None else found[0]


def unit_of(name: str, *, table: bool) -> str | None:
    """SI unit, or the one in the name, of a column of that name; None if the name is not known.

    Parameters
    ----------
    name : str
        Name of a channel, and for tables of a setting, of a mean or of a harmonic.
    table : bool
        Whether the file is a table whose rows are runs.
    """
    if table:
        if name in SETTING_UNITS:
            return SETTING_UNITS[name]
        part = harmonic_part(name)
        if part is not None:
            return CHANNEL_UNITS[part[0]]
    if name in CHANNEL_UNITS:
        return CHANNEL_UNITS[name]
    found = unit_in_name(name)
    return None if found is None else found[1]


def names_taken_unasked(*, table: bool) -> frozenset[str] | None:
    """Header names that are taken without being mapped; None stands for every known name.

    In a table a column ``r`` or ``v`` is too often a non-dimensional amplitude: velocities are
    taken there only where the campaign file maps them.
    """
    return frozenset((*_TABLE_CHANNELS, *SETTING_UNITS)) if table else None


def factor_to(unit: str, target: str) -> float | None:
    """Factor from a unit to a target unit; None if they measure different things.

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


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """``; did you mean 'x'?`` with the nearest known name, or nothing.

    Examples
    --------
    >>> did_you_mean("drift_dge", ["drift_deg", "speed"]), did_you_mean("KVLCC", ["kvlcc2"])
    ("; did you mean 'drift_deg'?", "; did you mean 'kvlcc2'?")
    """
    listed = list(known)
    folded = {item.lower(): item for item in listed}
    if name.lower() in folded:
        return f"; did you mean {folded[name.lower()]!r}?"
    near = difflib.get_close_matches(name, listed, n=1, cutoff=0.6) or [
        folded[item] for item in difflib.get_close_matches(name.lower(), folded, n=1, cutoff=0.6)
    ]
    return f"; did you mean {near[0]!r}?" if near else ""
