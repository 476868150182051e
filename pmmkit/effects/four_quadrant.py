"""A propeller in all four quadrants: ahead and astern, in water from ahead and astern."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from pmmkit.effects.effect import Effect, Parameter
from pmmkit.effects.primitives import atan2, fabs, interpolate, pi, where
from pmmkit.effects.propeller import wake_inflow


def force(
    u: float, v: float, r: float, beta: float, n: float, L: float, U: float, rho: float,
    D: float, t: float,
    t_astern: float, wake: int, wp: float, xp: float, tau: float, cpv: float, cpr: float,
    C1: float, C2_positive: float, C2_negative: float, cp: float, characteristics: int, kt0: float,
    kt1: float, kt2: float, kq0: float, kq1: float, kq2: float, astern: float,
    beta_deg: Sequence[float], CT: Sequence[float], CQ: Sequence[float], Yp0: float, Yp1: float,
    Np0: float, Np1: float,
) -> tuple[float, float, float, float, float, float, float]:  # fmt: skip
    """X, Y [N], N [N m], inflow [m/s], thrust [N], torque [N m], thrust over ρ D² [m²/s²]."""
    ahead = wake_inflow(
        u, v, r, beta, L, U, wake, wp, xp, tau, cpv, cpr, C1, C2_positive, C2_negative, cp
    )
    inflow = where(u >= 0.0, ahead, u)
    tip = n * D
    if characteristics == 0:
        share = where(n >= 0.0, 1.0, astern)
        drag = kt2 * inflow * fabs(inflow)
        loading = share * kt0 * tip * fabs(tip) + kt1 * fabs(tip) * inflow + drag
        twist = share * kq0 * tip * fabs(tip) + kq1 * fabs(tip) * inflow
        twist += kq2 * inflow * fabs(inflow)
    else:
        around = 0.7 * pi * tip
        angle = atan2(inflow, around) * 180.0 / pi
        turned = where(angle < 0.0, angle + 360.0, angle)
        square = (inflow * inflow + around * around) * pi / 8.0
        loading = square * interpolate(turned, beta_deg, CT)
        twist = square * interpolate(turned, beta_deg, CQ)
    thrust = rho * D * D * loading
    deduction = where(thrust >= 0.0, t, t_astern)
    reach = u * fabs(tip) / D
    side = where(n < 0.0, 0.5 * rho * D * D * (Yp0 * tip * tip + Yp1 * reach * D), 0.0)
    turn = where(n < 0.0, 0.5 * rho * D * D * L * (Np0 * tip * tip + Np1 * reach * D), 0.0)
    return (
        (1.0 - deduction) * thrust, side, turn, inflow, thrust, rho * D * D * D * twist, loading
    )  # fmt: skip


_POLYNOMIAL: Final = ("characteristics", "polynomial")
_TABLE: Final = ("characteristics", "table")
_SN: Final = ("wake", "son-nomoto")
_TAU: Final = ("wake", "son-nomoto", "kose")
_KOSE: Final = ("wake", "kose")
_MMG: Final = ("wake", "mmg")
FOUR_QUADRANT_PROPELLER: Final = Effect(
    name="four_quadrant_propeller",
    family="propeller",
    kind="force",
    summary="Thrust and torque ahead and astern, with the side force of a propeller that turns "
    "astern.",
    parameters=(
        Parameter(name="D", text="diameter", unit="m", low=1e-6),
        Parameter(name="t", text="thrust deduction fraction ahead", low=-0.99, high=0.99),
        Parameter(
            name="t_astern", text="thrust deduction fraction of a thrust astern", default=0.0,
            low=-0.99, high=0.99,
        ),
        Parameter(name="kt0", text="KT at J = 0", form=_POLYNOMIAL),
        Parameter(name="kt1", text="coefficient of J in KT", form=_POLYNOMIAL),
        Parameter(name="kt2", text="coefficient of J² in KT", default=0.0, form=_POLYNOMIAL),
        Parameter(name="kq0", text="KQ at J = 0", default=0.0, form=_POLYNOMIAL),
        Parameter(name="kq1", text="coefficient of J in KQ", default=0.0, form=_POLYNOMIAL),
        Parameter(name="kq2", text="coefficient of J² in KQ", default=0.0, form=_POLYNOMIAL),
        Parameter(
            name="astern", text="KT at J = 0 astern over that ahead", default=0.8,
            form=_POLYNOMIAL, low=0.0, high=1.5,
        ),
        Parameter(
            name="beta_deg", text="hydrodynamic advance angles 0 to 360, ascending", unit="deg",
            form=_TABLE, table=True,
        ),
        Parameter(
            name="CT", text="T over ½ρ(VA² + (0.7πnD)²)πD²/4 at each angle", form=_TABLE,
            table=True,
        ),
        Parameter(
            name="CQ", text="Q over ½ρ(VA² + (0.7πnD)²)πD³/4 at each angle", form=_TABLE,
            table=True,
        ),
        Parameter(name="Yp0", text="side force astern over ½ρn²D⁴ at J = 0", default=0.0),
        Parameter(name="Yp1", text="its growth with J = u/(|n|D)", default=0.0),
        Parameter(name="Np0", text="moment astern over ½ρn²D⁴L at J = 0", default=0.0),
        Parameter(name="Np1", text="its growth with J = u/(|n|D)", default=0.0),
        Parameter(name="wp", text="wake fraction straight ahead", low=-0.99, high=0.99),
        Parameter(name="xp", text="propeller forward of midship over L", default=-0.5),
        Parameter(
            name="tau", text="growth of the inflow with (v' + xp r')², kose: with |v' + xp r'|",
            form=_TAU,
        ),
        Parameter(name="cpv", text="inflow per v'", default=0.0, form=_SN),
        Parameter(name="cpr", text="inflow per r'", default=0.0, form=_SN),
        Parameter(name="cp", text="growth with (v' + xp r')²", default=0.0, form=_KOSE),
        Parameter(name="C1", text="how fast the wake fades with drift", form=_MMG),
        Parameter(name="C2_positive", text="inflow at large positive drift", form=_MMG),
        Parameter(name="C2_negative", text="inflow at large negative drift", form=_MMG),
    ),
    options={
        "wake": ("constant", "son-nomoto", "mmg", "kose"),
        "characteristics": ("polynomial", "table"),
    },
    needs=("n",),
    force=force,
    outputs=("X", "Y", "N", "propeller_inflow", "thrust", "torque", "loading"),
    source="Tables: van Lammeren, van Manen and Oosterveld 1969. Polynomial: ahead the open-water "
    "characteristics, astern the bilinear form n|n|, |n|VA (Blanke 1981; Fossen 2011): an estimate",
)  # fmt: skip
EFFECTS: Final = (FOUR_QUADRANT_PROPELLER,)
