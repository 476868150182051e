"""A propeller in all four quadrants: ahead and astern, in water from ahead and from astern."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from pmmkit.effects.definition import Effect, Parameter
from pmmkit.effects.primitives import (
    atan2,
    cos,
    fabs,
    interpolate,
    maximum,
    minimum,
    pi,
    sin,
    sqrt,
    where,
)
from pmmkit.effects.propeller import WAKE_PARAMETERS, WAKES, wake_inflow

_TIP: Final = 0.7 * pi
_THRUST_COS: Final = (
    (0.0249, 0.1783, 0.0147, 0.0275, -0.0172, -0.0522, 0.0021, 0.0369, -0.0021, -0.0189,
     0.0033, 0.0221, -0.0031, 0.002),
    (-0.0257, 0.2466, 0.0355, -0.0225, -0.0001, -0.0293, -0.0077, 0.0227, 0.0027, -0.0002,
     0.0079, 0.0022, -0.0056, 0.0135),
    (0.0377, 0.0187, -0.0704, -0.0732, 0.0432, -0.0065, -0.0048, 0.028, -0.0021, -0.0063,
     -0.0008, -0.0205, 0.0061, 0.0003),
)  # fmt: skip
_THRUST_SIN: Final = (
    (0.0, -0.7485, -0.0138, 0.1009, -0.011, 0.0479, 0.0118, -0.0085, -0.0077, 0.0243, 0.0079,
     -0.0003, -0.0045, 0.0096),
    (0.0, 0.1727, 0.0125, -0.0473, -0.004, 0.0074, -0.0051, 0.0035, 0.0075, 0.0047, -0.0081,
     0.0025, 0.0046, 0.0039),
    (0.0, 0.135, 0.0326, -0.0363, -0.003, -0.0167, -0.0233, 0.0318, 0.0175, -0.0261, -0.0147,
     0.0034, 0.0051, -0.0044),
)  # fmt: skip
_TORQUE_COS: Final = (
    (0.00264, 0.0269, 0.00134, 0.00641, -0.002, -0.00756, 0.00026, 0.00601, -0.00156, -0.00322,
     0.00132, 0.00298, -0.00105, 0.00132),
    (0.00419, 0.06362, -0.00332, 0.00058, 0.00098, -0.01047, -0.00493, 0.01428, 0.00297,
     -0.00659, -0.00065, 0.0059, 0.00073, -0.00139),
    (0.01179, 0.04149, -0.02234, -0.01178, 0.01366, -0.0024, -0.0098, 0.01076, 0.01128, -0.00071,
     -0.00711, -0.00284, 0.00704, -0.00448),
)  # fmt: skip
_TORQUE_SIN: Final = (
    (0.0, -0.11071, 0.00028, 0.01648, -0.00215, 0.00845, 0.00085, -0.00321, -0.0006, 0.00464,
     0.00116, -0.0001, -0.00064, 0.00157),
    (0.0, -0.08055, -0.00066, 0.01237, -0.0025, 0.00476, 0.00306, 0.00407, -0.00292, -0.00216,
     0.00376, 0.00468, -0.00306, 0.00024),
    (0.0, 0.03525, 0.001, -0.0039, -0.00197, -0.0079, 0.0039, 0.01393, -0.00412, -0.01616,
     0.00396, 0.00922, -0.00303, -0.00367),
)  # fmt: skip


def b4_70(beta: float, pitch: float) -> tuple[float, float]:
    """Thrust and torque coefficient CT*, CQ* of Wageningen B4-70 propellers in four quadrants.

    Notes
    -----
    Harmonics 0 to 13 of Roddy, Hess and Faller (2006), NSWCCD-50-TR-2006/004, appendix B, for the
    pitches 0.5, 0.6, 0.8, 1.0, 1.2, 1.4, joined by a parabola in pitch. The parabola is within
    0.007 of those sums in CT* and 0.0014 in CQ* (rms over all angles); the harmonics left out, 14
    to 30, hold 0.013 of CT* and 0.003 of CQ* (rms) at pitch 1.0. The numbers were read in a
    public copy of the table, not in the report itself.

    Examples
    --------
    >>> import math
    >>> CT, CQ = b4_70(0.0, 1.0)
    >>> round(CT * math.pi / 8 * (0.7 * math.pi) ** 2, 2)
    0.41
    """
    p = pitch - 1.0
    c1, s1 = cos(beta), sin(beta)
    c, s = 0.0 * beta + 1.0, 0.0 * beta
    thrust, torque = 0.0 * beta, 0.0 * beta
    for k in range(14):
        a = _THRUST_COS[0][k] + p * (_THRUST_COS[1][k] + p * _THRUST_COS[2][k])
        b = _THRUST_SIN[0][k] + p * (_THRUST_SIN[1][k] + p * _THRUST_SIN[2][k])
        thrust = thrust + a * c + b * s
        a = _TORQUE_COS[0][k] + p * (_TORQUE_COS[1][k] + p * _TORQUE_COS[2][k])
        b = _TORQUE_SIN[0][k] + p * (_TORQUE_SIN[1][k] + p * _TORQUE_SIN[2][k])
        torque = torque + a * c + b * s
        c, s = c * c1 - s * s1, s * c1 + c * s1
    return thrust, torque


def estimate(
    beta: float,
    pitch: float,
    kt0: float,
    kt1: float,
    kt2: float,
    kq0: float,
    kq1: float,
    kq2: float,
) -> tuple[float, float]:
    """CT* and CQ* from open-water polynomials, completed by the curves of `b4_70`.

    Notes
    -----
    An estimate, not a measurement. From J = 0 to the J at which the thrust vanishes the
    polynomials hold exactly. Outside, the curves are those of B4-70, to which the difference at
    the nearer end of that range is added, fading smoothly over 30 degrees. So the curves are
    continuous, and far from the first quadrant they are those of B4-70 whatever the polynomials.

    Examples
    --------
    >>> CT, _ = estimate(0.0, 0.0, 0.5, -0.4, 0.0, 0.0, 0.0, 0.0)
    >>> import math
    >>> round(CT * math.pi / 8 * (0.7 * math.pi) ** 2, 12)
    0.5
    """
    root = sqrt(maximum(kt1 * kt1 - 4.0 * kt2 * kt0, 0.0))
    J0 = 2.0 * kt0 / maximum(root - kt1, 1e-9)
    known = where(pitch > 0.0, pitch, 0.0105 + 0.9447 * J0)
    ratio = minimum(maximum(known, 0.5), 1.4)
    end = minimum(maximum(beta, 0.0), atan2(J0, _TIP))
    turns, water = cos(end) / _TIP, sin(end)
    series_T, series_Q = b4_70(end, ratio)
    step_T = 8.0 / pi * (kt0 * turns * turns + kt1 * turns * water + kt2 * water * water)
    step_Q = 8.0 / pi * (kq0 * turns * turns + kq1 * turns * water + kq2 * water * water)
    gone = minimum(fabs(beta - end) * 6.0 / pi, 1.0)
    left = 1.0 - gone * gone * (3.0 - 2.0 * gone)
    CT, CQ = b4_70(beta, ratio)
    return (CT + left * (step_T - series_T), CQ + where(kq0 > 0.0, left * (step_Q - series_Q), 0.0))


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
    t_astern: float,
    wake: int,
    wp: float,
    wp_astern: float,
    xp: float,
    tau: float,
    cpv: float,
    cpr: float,
    C1: float,
    C2_positive: float,
    C2_negative: float,
    cp: float,
    characteristics: int,
    pitch: float,
    kt0: float,
    kt1: float,
    kt2: float,
    kq0: float,
    kq1: float,
    kq2: float,
    beta_deg: Sequence[float],
    CT: Sequence[float],
    CQ: Sequence[float],
    astern: int,
    Yp: Sequence[float],
    Np: Sequence[float],
    J_astern: Sequence[float],
) -> tuple[float, float, float, float, float, float, float]:
    """X, Y [N], N [N m], inflow [m/s], thrust [N], torque [N m], thrust over ρ D² [m²/s²]."""
    tip = _TIP * n * D
    turning = tip / maximum(sqrt(u * u + tip * tip), 1e-9)
    reversed_ = minimum(maximum(-10.0 * turning, 0.0), 1.0)
    fraction = where(u >= 0.0, wp + reversed_ * (wp_astern - wp), 0.0)
    inflow = wake_inflow(
        u, v, r, beta, L, U, wake, fraction, xp, tau, cpv, cpr, C1, C2_positive, C2_negative, cp
    )
    advance = atan2(inflow, tip)
    if characteristics == 0:
        push, twist = estimate(advance, pitch, kt0, kt1, kt2, kq0, kq1, kq2)
    elif characteristics == 1:
        push, twist = b4_70(advance, pitch)
    else:
        angle = advance * 180.0 / pi
        angle = where(angle < beta_deg[0], angle + 360.0, angle)
        push, twist = interpolate(angle, beta_deg, CT), interpolate(angle, beta_deg, CQ)
    square = (inflow * inflow + tip * tip) * pi / 8.0
    loading = square * push
    thrust = rho * D * D * loading
    deduction = where(thrust >= 0.0, t, t_astern)
    side, turn = 0.0 * n, 0.0 * n
    if astern == 1:
        J = -u / (D * maximum(-n, 1e-9))
        scale = where(n < 0.0, 0.5 * rho * n * n * D * D * D * D, 0.0)
        side = scale * interpolate(J, J_astern, Yp)
        turn = scale * L * interpolate(J, J_astern, Np)
    return (
        (1.0 - deduction) * thrust,
        side,
        turn,
        inflow,
        thrust,
        rho * D * D * D * square * twist,
        loading,
    )


_POLYNOMIAL: Final = ("characteristics", "polynomial")
_TABLE: Final = ("characteristics", "table")
_ASTERN: Final = ("astern", "table")
_ANGLES: Final = ("beta_deg",)
_ADVANCES: Final = ("J_astern",)
FOUR_QUADRANT_PROPELLER: Final = Effect(
    name="four_quadrant_propeller",
    in_words="Four-quadrant propeller",
    family="propeller",
    kind="force",
    roles=("propulsion",),
    summary="Thrust and torque ahead and astern, with the side force of a propeller that turns "
    "astern.",
    parameters=(
        Parameter(name="D", text="diameter", unit="m", low=1e-6),
        Parameter(name="t", text="thrust deduction fraction ahead", low=-0.99, high=0.99),
        Parameter(
            name="t_astern",
            text="thrust deduction fraction of a thrust astern",
            default=0.0,
            low=-0.99,
            high=0.99,
        ),
        Parameter(
            name="pitch",
            text="pitch over diameter, for curves of Wageningen B4-70; 0: from KT",
            default=0.0,
            low=0.0,
            high=2.0,
        ),
        Parameter(name="kt0", text="KT at J = 0", form=_POLYNOMIAL, low=1e-9),
        Parameter(name="kt1", text="coefficient of J in KT", form=_POLYNOMIAL),
        Parameter(name="kt2", text="coefficient of J² in KT", default=0.0, form=_POLYNOMIAL),
        Parameter(
            name="kq0",
            text="KQ at J = 0; 0: the torque of Wageningen B4-70",
            default=0.0,
            form=_POLYNOMIAL,
        ),
        Parameter(name="kq1", text="coefficient of J in KQ", default=0.0, form=_POLYNOMIAL),
        Parameter(name="kq2", text="coefficient of J² in KQ", default=0.0, form=_POLYNOMIAL),
        Parameter(
            name="beta_deg",
            text="advance angles over a full turn, ascending, from -180 or 0",
            unit="deg",
            form=_TABLE,
            table=True,
        ),
        Parameter(
            name="CT",
            text="T over ½ρ(VA² + (0.7πnD)²)πD²/4 at each angle",
            form=_TABLE,
            table=True,
            over=_ANGLES,
        ),
        Parameter(
            name="CQ",
            text="Q over ½ρ(VA² + (0.7πnD)²)πD³/4 at each angle",
            form=_TABLE,
            table=True,
            over=_ANGLES,
        ),
        Parameter(
            name="J_astern",
            text="u/(nD) of the side force astern, ascending (negative ahead)",
            form=_ASTERN,
            table=True,
        ),
        Parameter(
            name="Yp",
            text="side force over ½ρn²D⁴ with n < 0 at each J",
            form=_ASTERN,
            table=True,
            over=_ADVANCES,
        ),
        Parameter(
            name="Np",
            text="moment over ½ρn²D⁴L with n < 0 at each J",
            form=_ASTERN,
            table=True,
            over=_ADVANCES,
        ),
        Parameter(name="wp", text="wake fraction straight ahead", low=-0.99, high=0.99),
        Parameter(
            name="wp_astern",
            text="wake fraction while the propeller turns astern",
            default=0.0,
            low=-0.99,
            high=0.99,
        ),
        *WAKE_PARAMETERS,
    ),
    options={
        "wake": WAKES,
        "characteristics": ("polynomial", "b4-70", "table"),
        "astern": ("none", "table"),
    },
    needs=("n",),
    astern=True,
    force=force,
    outputs=("X", "Y", "N", "propeller_inflow", "thrust", "torque", "loading"),
    sources=(
        "van_lammeren_van_manen_oosterveld_1969",
        "roddy_hess_faller_2006",
        "sea_trial_identification",
    ),
    remark="curves of B4-70 from the second, with polynomials an estimate outside the first "
    "quadrant; side force astern from the last, equations of the propeller",
)
EFFECTS: Final = (FOUR_QUADRANT_PROPELLER,)
