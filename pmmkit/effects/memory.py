"""Forces that do not belong to the motion of the instant: lags, and added mass that changes."""

from __future__ import annotations

from typing import Final

from pmmkit.effects.definition import Effect, Parameter


def late_sway_force(
    v: float,
    U: float,
    L: float,
    rho: float,
    late_sway: float,
    Yv_late: float,
    Nv_late: float,
    lag: float,
) -> tuple[float, float, float]:
    """Y [N], N [N m] and the rate of what follows U v [m²/s³].

    ½ρL² Yv_late (s - U v) and the same with L in N, ds/dt = (U v - s) U/(lag L): what Yv holds in
    steady motion comes late by that share.

    Examples
    --------
    >>> late_sway_force(0.5, 2.0, 4.0, 1000.0, 1.0, -0.002, 0.0, 0.3)
    (-0.0, 0.0, 0.0)
    """
    now = U * v
    missing = 0.5 * rho * L * L * (late_sway - now)
    return Yv_late * missing, Nv_late * L * missing, (now - late_sway) * U / (lag * L)


def late_cross_flow_force(
    v: float,
    U: float,
    L: float,
    rho: float,
    late_cube: float,
    Yvvv_late: float,
    Nvvv_late: float,
    lag: float,
) -> tuple[float, float, float]:
    """Y [N], N [N m] and the rate of what follows v³/U [m²/s³], as `late_sway_force`.

    Examples
    --------
    >>> late_cross_flow_force(1.0, 2.0, 4.0, 1000.0, 0.0, -0.1, 0.0, 0.5)
    (400.0, -0.0, 0.5)
    """
    now = v * v * v / U
    missing = 0.5 * rho * L * L * (late_cube - now)
    return Yvvv_late * missing, Nvvv_late * L * missing, (now - late_cube) * U / (lag * L)


def added_mass_in_drift(
    v: float, U: float, L: float, rho: float, Yvvvdot: float, Nvvvdot: float
) -> tuple[float, float]:
    """Force [N] and moment [N m] per sway acceleration: ½ρL³ Yvvvdot v'², ½ρL⁴ Nvvvdot v'².

    Examples
    --------
    >>> added_mass_in_drift(0.5, 1.0, 2.0, 1000.0, -0.02, 0.0)
    (-20.0, 0.0)
    """
    unit = 0.5 * rho * L * L * L * (v / U) * (v / U)
    return unit * Yvvvdot, unit * L * Nvvvdot


_PRIME: Final = "(½ρL²U², ½ρL³U² with the speed of the instant)"
_LAG: Final = Parameter(name="lag", text="lag in L/U", low=1e-3, grid=(0.15, 0.3, 0.5, 0.8))
MEMORY: Final = Effect(
    name="memory",
    family="memory",
    kind="state",
    summary="Part of the sway force builds up late, so that damping falls with frequency.",
    parameters=(
        Parameter(name="Yv_late", text=f"part of Yv that is late {_PRIME}", typical=-0.2 * 0.0116),
        Parameter(name="Nv_late", text="part of Nv that is late", typical=-0.2 * 0.00385),
        _LAG,
    ),
    force=late_sway_force,
    outputs=("Y", "N", "late_sway_rate"),
    states=("late_sway",),
    sources=("van_leeuwen_1964", "nomoto_1975"),
    check="pure sway at ω' = 1 and 6 beside static drift",
)
LAGGED_CROSSFLOW: Final = Effect(
    name="lagged_crossflow",
    in_words="Lagged cross-flow",
    family="memory",
    kind="state",
    not_free_running="in zigzags and turns `memory` stands for it",
    summary="The cubic sway force lags behind the motion.",
    parameters=(
        Parameter(
            name="Yvvv_late", text=f"part of Yvvv that is late {_PRIME}", typical=-0.9 * 0.109
        ),
        Parameter(name="Nvvv_late", text="part of Nvvv that is late", typical=0.9 * 0.0015),
        _LAG,
    ),
    force=late_cross_flow_force,
    outputs=("Y", "N", "late_cube_rate"),
    states=("late_cube",),
    sources=("wagner_1925",),
    remark="a one-pole lag, as of lift that builds up",
    check="pure sway at two frequencies and one large amplitude",
)
NONLINEAR_ADDED_MASS: Final = Effect(
    name="nonlinear_added_mass",
    in_words="Nonlinear added mass",
    family="memory",
    kind="mass",
    not_free_running="sway accelerations of a free ship are too small: pure sway shows it",
    summary="Added mass that changes with the sway velocity.",
    parameters=(
        Parameter(name="Yvvvdot", text=f"multiplies v² v̇ in Y {_PRIME}", typical=-0.020),
        Parameter(name="Nvvvdot", text="multiplies v² v̇ in N", typical=-0.004),
    ),
    force=added_mass_in_drift,
    outputs=("Yvdot", "Nvdot"),
    sources=("abkowitz_1964",),
    check="pure sway at more amplitudes",
)
EFFECTS: Final = (MEMORY, LAGGED_CROSSFLOW, NONLINEAR_ADDED_MASS)
