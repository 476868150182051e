"""Derivatives about another point: moments and motions referred elsewhere on the ship."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator, Mapping
from typing import Final

from pmmkit.conventions import Derivative, bare, canonical, parse_derivative
from pmmkit.errors import TableError
from pmmkit.tables.linear import rewritten
from pmmkit.tables.table import DerivativeTable

NOT_MOVED: Final = "The table is not converted"


def moved(table: DerivativeTable, *, moment: float, motion: float) -> DerivativeTable:
    """The table with moments and motions referred to other points.

    Parameters
    ----------
    table : DerivativeTable
        Derivatives with sway "v", surge "u" or "delta-u", Coriolis terms inside.
    moment, motion : float
        The new reference points, forward of midship [m].

    Raises
    ------
    TableError
        If the motion point moves and a term holds |v| (or the ship's length is not known).

    Notes
    -----
    With Δ the step forward over L, the moment becomes N - Δ Y, exactly and term by term. Motions:
    v = v_new - Δ r and v̇ = v̇_new - Δ ṙ are put into every term. The instantaneous speed changes
    too, U² = U_new² (1 - 2 Δ v r + Δ² r²): terms whose power of speed is not 2 gain terms two
    orders higher in v and r. They are kept up to the highest order that the table has in surge and
    in the other channels; with carriage U and in bis there are none. There and back gives the
    same numbers.
    """
    L = table.ship.L
    convention = table.convention
    if not math.isfinite(L):
        raise TableError("The ship's length is not known.", title=NOT_MOVED)
    step = (motion - convention.motion_reference_x) / L
    if step:
        table = _motion(table, step)
    step = (moment - convention.moment_reference_x) / L
    if step:
        table = _moment(table, step)
    return table.with_(
        convention=convention.with_(moment_reference_x=moment, motion_reference_x=motion)
    )


def _moment(table: DerivativeTable, step: float) -> DerivativeTable:
    def expand(derivative: Derivative) -> Mapping[str, float]:
        own = {derivative.name: 1.0}
        if derivative.channel == "Y":
            own[f"N{derivative.term}"] = -step
        return own

    return rewritten(table, expand)


def _motion(table: DerivativeTable, step: float) -> DerivativeTable:
    parsed = [parse_derivative(name) for name in table.names]
    closed = [derivative.name for derivative in parsed if "|v|" in derivative.factors]
    if closed:
        raise TableError(
            f"{', '.join(closed)}: |v| at one point is |v - x r| at another, which is no sum of "
            f"such terms. Reduce the runs again with motions referred to the point you need.",
            title=NOT_MOVED,
        )
    highest: dict[bool, int] = defaultdict(int)
    for derivative in parsed:
        surge = derivative.channel == "X"
        highest[surge] = max(highest[surge], _order(derivative))
    varying = table.convention.U == "instantaneous" and table.convention.system != "bis"

    def expand(derivative: Derivative) -> Mapping[str, float]:
        exponent = (2 - derivative.speed_power) / 2 if varying else 0.0
        room = highest[derivative.channel == "X"] - _order(derivative)
        rest = tuple(factor for factor in derivative.factors if factor not in ("v", "vdot"))
        sums: dict[str, float] = defaultdict(float)
        for first, rates in _shifted(derivative.factors.count("v"), "v", "r", step):
            for second, accelerations in _shifted(
                derivative.factors.count("vdot"), "vdot", "rdot", step
            ):
                for third, gained in _speed_ratio(exponent, room, step):
                    new = (*rates, *accelerations, *gained)
                    kept = tuple(factor for factor in rest if factor != "0" or not new)
                    name = canonical(derivative.channel + "".join((*kept, *new)))
                    sums[name] += first * second * third
        return sums

    return rewritten(table, expand)


def _order(derivative: Derivative) -> int:
    """Order of a term in v and r."""
    return sum(bare(factor) in ("v", "r") for factor in derivative.factors)


def _shifted(
    power: int, sway: str, yaw: str, step: float
) -> Iterator[tuple[float, tuple[str, ...]]]:
    """Terms of (sway - step yaw)**power."""
    for count in range(power + 1):
        yield math.comb(power, count) * (-step) ** count, (sway,) * (power - count) + (yaw,) * count


def _speed_ratio(
    exponent: float, room: int, step: float
) -> Iterator[tuple[float, tuple[str, ...]]]:
    """Terms of (1 - 2 step v r + step² r²)**exponent up to an order in v and r."""
    factor = 1.0
    for outer in range(room // 2 + 1):
        for inner in range(outer + 1):
            weight = math.comb(outer, inner) * (-2 * step) ** inner * step ** (2 * (outer - inner))
            if factor:
                yield factor * weight, ("v",) * inner + ("r",) * (2 * outer - inner)
        factor *= (exponent - outer) / (outer + 1)
