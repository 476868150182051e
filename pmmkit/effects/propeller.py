"""Propeller: thrust and torque by open-water characteristics, the wake in a turn."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

from pmmkit.effects.definition import Effect, Parameter
from pmmkit.effects.hull import HULL
from pmmkit.effects.primitives import exp, fabs, interpolate, maximum, minimum, where
from pmmkit.effects.seen import Move, Vessel


def wake_inflow(
    u: float,
    v: float,
    r: float,
    beta: float,
    L: float,
    U: float,
    wake: int,
    wp: float,
    xp: float,
    tau: float,
    cpv: float,
    cpr: float,
    C1: float,
    C2_positive: float,
    C2_negative: float,
    cp: float,
) -> float:
    """Speed of the water into the propeller disc [m/s].

    u, v, r, beta, U [m/s]; L [m].

    Notes
    -----
    Son and Nomoto (1981): u (1 - wp + τ[(v' + xp r')² + cpv v' + cpr r']). Yasukawa and Yoshimura
    (2015): u (1 - wp)(1 + [1 - exp(-C1 |βP|)](C2 - 1)), βP = β - xp r'. Kose (1982), at low speed:
    u (1 - wp + τ |v' + xp r'| + cp (v' + xp r')²), at most u.

    Examples
    --------
    >>> wake_inflow(10.0, -2.0, 0.02, 0.2, 175.0, 10.2, 0, 0.2, -0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
    ...              0.0)
    8.0
    """
    if wake == 0:
        return u * (1.0 - wp)
    yaw = r * L / U
    if wake == 1:
        sway = v / U
        cross = sway + xp * yaw
        return u * (1.0 - wp + tau * (cross * cross + cpv * sway + cpr * yaw))
    if wake == 3:
        turned = fabs(v / U + xp * yaw)
        return u * minimum(1.0 - wp + turned * (tau + cp * turned), 1.0)
    angle = beta - xp * yaw
    limit = where(angle > 0.0, C2_positive, C2_negative)
    return u * (1.0 - wp) * (1.0 + (1.0 - exp(-C1 * fabs(angle))) * (limit - 1.0))


def force(
    u: float,
    v: float,
    r: float,
    beta: float,
    n: float,
    L: float,
    U: float,
    rho: float,
    D: float,
    t: float,
    wake: int,
    wp: float,
    xp: float,
    tau: float,
    cpv: float,
    cpr: float,
    C1: float,
    C2_positive: float,
    C2_negative: float,
    cp: float,
    open_water: int,
    kt0: float,
    kt1: float,
    kt2: float,
    kq0: float,
    kq1: float,
    kq2: float,
    J: Sequence[float],
    KT: Sequence[float],
    KQ: Sequence[float],
) -> tuple[float, float, float, float, float]:
    """Surge force [N], inflow [m/s], thrust [N], torque [N m] and thrust over ρ D² [m²/s²].

    Thrust is ρ n|n| D⁴ KT(J), written so that the polynomial holds at n = 0 too; astern, with J
    negative, that is the bilinear form of n|n| and |n| VA.
    """
    inflow = wake_inflow(
        u, v, r, beta, L, U, wake, wp, xp, tau, cpv, cpr, C1, C2_positive, C2_negative, cp
    )
    tip = n * D
    if open_water == 0:
        loading = kt0 * tip * fabs(tip) + kt1 * fabs(tip) * inflow + kt2 * inflow * inflow
        twist = kq0 * tip * fabs(tip) + kq1 * fabs(tip) * inflow + kq2 * inflow * inflow
    else:
        advance = inflow * tip / maximum(tip * tip, 1e-12)
        loading = tip * fabs(tip) * interpolate(advance, J, KT)
        twist = tip * fabs(tip) * interpolate(advance, J, KQ)
    thrust = rho * D * D * loading
    return (1.0 - t) * thrust, inflow, thrust, rho * D * D * D * twist, loading


WAKES: Final = ("constant", "son-nomoto", "mmg", "kose")
"""The option ``wake`` of a propeller, as `wake_inflow` numbers it."""
WAKE_PARAMETERS: Final = (
    Parameter(name="xp", text="propeller forward of midship over L", default=-0.5),
    Parameter(
        name="tau",
        text="growth of the inflow with (v' + xp r')², kose: with |v' + xp r'|",
        form=("wake", "son-nomoto", "kose"),
    ),
    Parameter(name="cpv", text="inflow per v'", default=0.0, form=("wake", "son-nomoto")),
    Parameter(name="cpr", text="inflow per r'", default=0.0, form=("wake", "son-nomoto")),
    Parameter(name="cp", text="growth with (v' + xp r')²", default=0.0, form=("wake", "kose")),
    Parameter(name="C1", text="how fast the wake fades with drift", form=("wake", "mmg")),
    Parameter(name="C2_positive", text="inflow at large positive drift", form=("wake", "mmg")),
    Parameter(name="C2_negative", text="inflow at large negative drift", form=("wake", "mmg")),
)
"""What a propeller says of its place and of the wake in a turn."""
_POLYNOMIAL: Final = ("open_water", "polynomial")
_TABLE: Final = ("open_water", "table")
PROPELLER: Final = Effect(
    name="propeller",
    family="propeller",
    kind="force",
    roles=("propulsion",),
    summary="Thrust of one propeller ahead, from KT over J, with wake and thrust deduction.",
    parameters=(
        Parameter(name="D", text="diameter", unit="m", low=1e-6),
        Parameter(name="t", text="thrust deduction fraction", low=-0.99, high=0.99),
        Parameter(name="kt0", text="KT at J = 0", form=_POLYNOMIAL),
        Parameter(name="kt1", text="coefficient of J in KT", form=_POLYNOMIAL),
        Parameter(name="kt2", text="coefficient of J² in KT", default=0.0, form=_POLYNOMIAL),
        Parameter(name="kq0", text="KQ at J = 0", default=0.0, form=_POLYNOMIAL),
        Parameter(name="kq1", text="coefficient of J in KQ", default=0.0, form=_POLYNOMIAL),
        Parameter(name="kq2", text="coefficient of J² in KQ", default=0.0, form=_POLYNOMIAL),
        Parameter(
            name="J", text="advance ratios of the tables, ascending", form=_TABLE, table=True
        ),
        Parameter(name="KT", text="KT at each J", form=_TABLE, table=True, over=("J",)),
        Parameter(name="KQ", text="KQ at each J", form=_TABLE, table=True, over=("J",)),
        Parameter(
            name="wp", text="wake fraction straight ahead", low=-0.99, high=0.99, uncertain=True
        ),
        *WAKE_PARAMETERS,
    ),
    options={"wake": WAKES, "open_water": ("polynomial", "table")},
    needs=("n",),
    force=force,
    outputs=("X", "propeller_inflow", "thrust", "torque", "loading"),
    sources=("son_nomoto_1981", "yasukawa_yoshimura_2015"),
)
_TOWED: Final = "captive tests measure the force on the model: thrust enters by its gauge"


def _freed(name: str, summary: str, sizes: Mapping[str, float], *, check: str) -> Effect:
    return Effect(
        name=name,
        family="propeller",
        kind="freed",
        frees=PROPELLER.name,
        summary=summary,
        parameters=tuple(
            Parameter(name=own, text=f"change of {own} of the propeller", typical=size)
            for own, size in sizes.items()
        ),
        sources=("yasukawa_yoshimura_2015", "son_nomoto_1981"),
        check=check,
        not_captive=_TOWED,
    )


def resistance_of_the_model(vessel: Vessel) -> Mapping[str, Move]:
    """The resistance of a model off, by its own derivative."""
    known = vessel.derivatives()
    name = next((name for name in ("Xuu", "Xu") if name in known), None)
    if name is None:
        return {}
    return {name: Move(values={name: 1.0}, typical=0.15 * abs(known[name]) or 1e-4)}


WAKE_IN_DRIFT: Final = _freed(
    "wake_in_drift",
    "Flow into the propeller in drift and turn.",
    {"C2_positive": 0.3, "C2_negative": 0.3, "tau": 0.4, "cp": 0.3},
    check="captive drift with the thrust measured",
)
PROPELLER_LOAD: Final = _freed(
    "propeller_load",
    "Thrust at the revolutions of the runs: wake and thrust deduction.",
    {"wp": 0.08, "t": 0.05},
    check="captive straight runs at three revolutions",
)
SCALE_EFFECT: Final = Effect(
    name="scale_effect",
    family="propeller",
    kind="freed",
    frees=HULL,
    summary="Resistance of another scale or surface.",
    moves=resistance_of_the_model,
    sources=("ittc_7.5-02-03-01.4",),
    check="a resistance test of this model",
    not_captive="one model has one scale: its resistance is measured",
)
EFFECTS: Final = (PROPELLER, WAKE_IN_DRIFT, PROPELLER_LOAD, SCALE_EFFECT)
