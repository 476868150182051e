"""Derivative tables from one convention to another, covariance included.

Every conversion is linear in the derivatives, so a covariance C becomes J C Jᵀ. What cannot be
converted exactly from the numbers alone is refused with the reason.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields
from typing import Any, Final, Literal, get_args, get_origin, get_type_hints

import numpy as np

from pmmkit.base import TableError
from pmmkit.conventions import Convention, Derivative, System, parse_derivative
from pmmkit.models.tables.points import moved, rewritten
from pmmkit.models.tables.table import DerivativeTable
from pmmkit.numerics import Array

NOT_CONVERTED: Final = "The table is not converted"
BIS_NOTE: Final = (
    "Converted between bis and a prime system at U = Fn sqrt(g L) of each row: derivatives of "
    "terms whose power of speed is not 2 hold at that speed."
)


def converted(
    table: DerivativeTable, convention: Convention | None = None, **changes: Any
) -> DerivativeTable:
    """The same hydrodynamics in another convention.

    Parameters
    ----------
    table : DerivativeTable
        What to convert.
    convention : Convention, optional
        The convention to reach; that of the table where absent.
    **changes
        Single entries of the convention, e.g. ``system="prime-d"``, ``sway="beta"``,
        ``coriolis="separate"``, ``moment_reference_x=0.12``.

    Returns
    -------
    DerivativeTable
        With the new convention; derivatives that a conversion brings in are added at the end.

    Raises
    ------
    TableError
        If the request is not understood, or the numbers of the table do not suffice.

    Notes
    -----
    - `system`: one factor per derivative. In ``bis`` it depends on Fn where the power of speed is
      not 2 (U = Fn √(gL)); a pooled table with such terms is refused. With instantaneous U such
      terms change their form in drift, which a note of the table says; there and back is exact.
    - `sway`, `rudder_positive`: the sign of terms odd in v and v̇, or in the rudder angle. ``beta``
      is -v' exactly; a source that means the angle itself has β ≈ sin β = -v'.
    - `surge`: ``constant`` and ``u`` differ by Xvv(constant) = Xvv - Xuu, because u'² = 1 - v'²
      with instantaneous U. Xvv is added where the table has none.
    - `coriolis`: Yr(total) = Yr(separate) - mx and Xvr(total) = Xvr(separate) + my, with
      mx = -Xudot and my = -Yvdot of the table. Yr multiplies r' and the term written out u'r', so
      the totals agree to second order in v'. K is left as it is.
    - `moment_reference_x`, `motion_reference_x`: see `points.moved`.
    - `U`, and surge ``delta-u``, are refused: they are expansions about other points, and which
      derivatives come out depends on the runs. Reduce the runs again.

    Examples
    --------
    >>> from pmmkit.conventions import Ship, Water
    >>> from pmmkit.models.tables.table import from_values
    >>> kvlcc2 = Ship(name="KVLCC2", L=320., B=58., d=20.8, volume=312600., mass=3.2e8, Izz=2e12)
    >>> table = from_values({"Yr": .083, "Xvr": .002, "Xudot": -.022, "Yvdot": -.223},
    ...     ship=kvlcc2, water=Water(),
    ...     convention=Convention(system="prime-d", coriolis="separate"))
    >>> total = converted(table, coriolis="in-derivatives").at()
    >>> round(total["Yr"], 6), round(total["Xvr"], 6)
    (0.061, 0.225)
    """
    source = table.convention
    try:
        target = (convention or source).with_(**changes)
    except TypeError as error:
        known = ", ".join(item.name for item in fields(Convention))
        raise TableError(
            f"Conventions have no {', '.join(set(changes) - set(known.split(', ')))}: {known}.",
            title=NOT_CONVERTED,
        ) from error
    _refuse(table, target)
    if target == source:
        return table
    moves = (
        source.moment_reference_x != target.moment_reference_x
        or source.motion_reference_x != target.motion_reference_x
    )
    shifts = source.motion_reference_x != target.motion_reference_x
    if source.system == "bis" and target.system != "bis":
        table = _in_system(table, target.system)
    table = _in_signs(table, sway="v" if moves else target.sway, rudder=target.rudder_positive)
    through_u = shifts and target.surge != "delta-u"
    table = _in_surge(table, "u" if through_u else target.surge)
    table = _in_coriolis(table, "in-derivatives" if moves else target.coriolis)
    if moves:
        table = moved(table, moment=target.moment_reference_x, motion=target.motion_reference_x)
    table = _in_coriolis(table, target.coriolis)
    table = _in_surge(table, target.surge)
    table = _in_signs(table, sway=target.sway, rudder=target.rudder_positive)
    return _in_system(table, target.system)


def to_system(table: DerivativeTable, system: System) -> DerivativeTable:
    """The table in another non-dimensional system (see `converted`).

    Examples
    --------
    >>> from pmmkit.conventions import Ship, Water
    >>> from pmmkit.models.tables.table import from_values
    >>> ship = Ship(name="m", L=4.0, B=1.0, d=.25, volume=.5, mass=500., Izz=500.)
    >>> table = from_values({"Yv": -.0116}, ship=ship, water=Water())
    >>> to_system(table, "prime-d")["Yv"]
    array([-0.1856])
    """
    return converted(table, system=system)


def _refuse(table: DerivativeTable, target: Convention) -> None:
    """Raise for requests that no arithmetic on the table can fulfil."""
    source = table.convention
    hints = get_type_hints(Convention)
    wrong = []
    for item in fields(Convention):
        value, hint = getattr(target, item.name), hints[item.name]
        if get_origin(hint) is Literal:
            if value not in get_args(hint):
                wrong.append(f"{item.name} {value!r} is not known: {', '.join(get_args(hint))}.")
        elif not (isinstance(value, int | float) and math.isfinite(value)):
            wrong.append(f"{item.name} {value!r} is not a number.")
    if wrong:
        raise TableError(wrong, title=NOT_CONVERTED)
    if target.U != source.U:
        wrong.append(
            f"The table is made with {source.U} U; derivatives with {target.U} U are another fit, "
            f"not another unit (Yvvv moves by about Yv/2, and by how much depends on the "
            f"amplitudes of the runs). Reduce the runs again with U = {target.U!r}."
        )
    if target.surge != source.surge:
        if "delta-u" in (target.surge, source.surge):
            wrong.append(
                f"Surge {source.surge!r} to {target.surge!r}: 'delta-u' expands about the approach "
                f"speed, the other forms do not. Reduce the runs again with surge = "
                f"{target.surge!r}."
            )
        elif source.U == "carriage" and source.system != "bis":
            wrong.append(
                "Surge 'u' and 'constant' are tied by u'² + v'² = 1, which holds for instantaneous "
                "U only; this table has carriage U. Reduce the runs again."
            )
    if wrong:
        raise TableError(wrong, title=NOT_CONVERTED)


def _in_signs(
    table: DerivativeTable, *, sway: Literal["v", "beta"], rudder: Literal["starboard", "port"]
) -> DerivativeTable:
    flips = [
        variable
        for variable, change in (
            ("v", table.convention.sway != sway),
            ("d", table.convention.rudder_positive != rudder),
        )
        if change
    ]
    if not flips:
        return table

    def expand(derivative: Derivative) -> Mapping[str, float]:
        return {
            derivative.name: math.prod(derivative.sign_under_flip(variable) for variable in flips)
        }

    convention = table.convention.with_(sway=sway, rudder_positive=rudder)
    return rewritten(table, expand).with_(convention=convention)


def _in_surge(
    table: DerivativeTable, surge: Literal["u", "constant", "delta-u"]
) -> DerivativeTable:
    if table.convention.surge == surge:
        return table
    sign = -1.0 if surge == "constant" else 1.0

    def expand(derivative: Derivative) -> Mapping[str, float]:
        own = {derivative.name: 1.0}
        if derivative.factors != ("u", "u"):
            return own
        return own | {f"{derivative.channel}vv": sign}

    return rewritten(table, expand).with_(convention=table.convention.with_(surge=surge))


def _in_coriolis(
    table: DerivativeTable, coriolis: Literal["in-derivatives", "separate"]
) -> DerivativeTable:
    if table.convention.coriolis == coriolis:
        return table
    channels = {name[0] for name in table.names}
    bis = table.convention.system == "bis"
    wrong = [
        f"{name} is needed (the added mass {mass} = -{name}), but the table "
        + ("does not have it." if name not in table else "has no value for it.")
        + f" Reduce runs that excite it, or add it, to move the Coriolis term into {into}."
        for name, mass, into in (("Xudot", "mx", "Yr"), ("Yvdot", "my", "Xvr"))
        if into[0] in channels and (name not in table or np.isnan(table[name]).all())
    ]
    if bis and table.pooled and "Y" in channels:
        wrong.append("In bis, mx u r over Yr r is Fn, and a pooled table has none. Use prime.")
    if wrong:
        raise TableError(wrong, title=NOT_CONVERTED)
    sign = 1.0 if coriolis == "in-derivatives" else -1.0
    along = table.Fn if bis else 1.0

    def expand(derivative: Derivative) -> Mapping[str, float | Array]:
        own: dict[str, float | Array] = {derivative.name: 1.0}
        if derivative.name == "Xudot" and "Y" in channels:
            own["Yr"] = sign * along
        if derivative.name == "Yvdot" and "X" in channels:
            own["Xvr"] = -sign
        return own

    return rewritten(table, expand).with_(convention=table.convention.with_(coriolis=coriolis))


def _in_system(table: DerivativeTable, system: System) -> DerivativeTable:
    source = table.convention.system
    if source == system:
        return table
    ship = table.ship
    unit = {"prime": 1.0, "prime-d": ship.L / ship.d, "bis": ship.L**3 / (2 * ship.volume)}
    unknown = [
        f"The ship's {what} is not known, but {name} needs it."
        for name, what in (("prime-d", "length or draught"), ("bis", "length or volume"))
        if name in (source, system) and not math.isfinite(unit[name])
    ]
    through_bis = "bis" in (source, system)
    tied = [name for name in table.names if parse_derivative(name).speed_power != 2]
    if through_bis and table.pooled and tied:
        unknown.append(
            f"Between bis and {system if source == 'bis' else source} the factors of "
            f"{', '.join(tied)} depend on Fn, and a pooled table has none. Reduce per Froude "
            f"number, or keep the system."
        )
    if through_bis and tied and np.any(table.Fn == 0):
        unknown.append("Between bis and the other systems a row at Fn = 0 has no finite factors.")
    if unknown:
        raise TableError(unknown, title=NOT_CONVERTED)
    ratio = unit[system] / unit[source]
    sense = int(system == "bis") - int(source == "bis")

    def expand(derivative: Derivative) -> Mapping[str, float | Array]:
        factor = ratio ** (1 - derivative.count("T"))
        power = sense * (2 - derivative.speed_power)
        return {derivative.name: factor * table.Fn**power if power else factor}

    notes = table.notes
    if through_bis and tied and table.convention.U == "instantaneous":
        others = tuple(note for note in notes if note != BIS_NOTE)
        notes = others if BIS_NOTE in notes else (*others, BIS_NOTE)
    return rewritten(table, expand).with_(
        convention=table.convention.with_(system=system), notes=notes
    )
