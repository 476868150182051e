"""What changes with the Froude number: F = (Fn/Fn0)² - 1 is zero at a speed of reference."""

from __future__ import annotations

from typing import Final

from pmmkit.effects.definition import Effect, Parameter
from pmmkit.effects.primitives import exp
from pmmkit.effects.terms import terms


def resistance(
    U: float, Fn: float, L: float, rho: float, X_F: float, X_FF: float, Fn0: float
) -> tuple[float]:
    """X [N]: ½ρL²U² (X_F F + X_FF F²), at a speed [m/s] and the Froude number of the waves.

    Examples
    --------
    >>> round(resistance(2.0, 0.4, 4.0, 1000.0, -1e-4, 0.0, 0.2)[0], 9)
    -9.6
    """
    F = Fn * Fn / (Fn0 * Fn0) - 1.0
    return (0.5 * rho * L * L * U * U * F * (X_F + X_FF * F),)


def hump(
    U: float, Fn: float, L: float, rho: float, X_hump: float, Fn_hump: float, width: float
) -> tuple[float]:
    """X [N]: ½ρL²U² X_hump exp(-((Fn - Fn_hump)/width)²), waves of bow and stern in step.

    Examples
    --------
    >>> hump(2.0, 0.3, 4.0, 1000.0, -1e-4, 0.3, 0.02)
    (-3.2,)
    """
    away = (Fn - Fn_hump) / width
    return (0.5 * rho * L * L * U * U * X_hump * exp(-away * away),)


_APPROACH: Final = "the values of a model are those of its approach speed throughout a manoeuvre"
RESISTANCE_CURVE: Final = Effect(
    name="resistance_curve",
    family="speed",
    kind="force",
    summary="Resistance that does not go with the square of the speed.",
    parameters=(
        Parameter(name="X_F", text="multiplies F in X over ½ρL²U²", typical=-4e-5),
        Parameter(name="X_FF", text="multiplies F² in X over ½ρL²U²", typical=-2.5e-5),
        Parameter(name="Fn0", text="Froude number at which F = (Fn/Fn0)² - 1 is zero", low=1e-3),
    ),
    force=resistance,
    stands_in=("Xuu",),
    outputs=("X",),
    sources=("ittc_7.5-02-02-01",),
    check="resistance at more speeds",
    excites=("several speeds",),
    not_free_running=_APPROACH,
)
WAVE_MAKING_HUMP: Final = Effect(
    name="wave_making_hump",
    in_words="Wave-making hump",
    family="speed",
    kind="force",
    summary="A hump of the resistance about one Froude number.",
    parameters=(
        Parameter(name="X_hump", text="height over ½ρL²U²", typical=-1e-4),
        Parameter(
            name="Fn_hump",
            text="Froude number of the hump",
            low=0.05,
            high=1.0,
            grid=(0.18, 0.22, 0.26, 0.30),
        ),
        Parameter(name="width", text="of the hump in Froude numbers", default=0.02, low=1e-3),
    ),
    force=hump,
    outputs=("X",),
    sources=("havelock_1909",),
    check="resistance at Froude numbers between those tested",
    excites=("four speeds",),
    not_free_running=_APPROACH,
)
FROUDE_LINEAR: Final = terms(
    "froude_linear",
    "speed",
    "Linear derivatives that change with the Froude number.",
    {"Yv F": -0.0010, "Nv F": 0.0003, "Yr F": -0.00045, "Nr F": -0.00012},
    sources=("yoon_2009",),
    check="a third speed",
    excites=("several speeds",),
    not_free_running=_APPROACH,
    in_words="Speed in linear terms",
)
FROUDE_NONLINEAR: Final = terms(
    "froude_nonlinear",
    "speed",
    "Cubic derivatives that change with the Froude number.",
    {"Yvvv F": -0.035, "Nvvv F": 0.0006, "Yrrr F": 0.004, "Nrrr F": -0.0008},
    sources=("yoon_2009",),
    check="amplitude steps at the extreme speeds",
    excites=("several speeds",),
    not_free_running=_APPROACH,
    in_words="Speed in nonlinear terms",
)
FROUDE_COUPLING: Final = terms(
    "froude_coupling",
    "speed",
    "Products of sway and yaw that change with the Froude number.",
    {"Yvvr F": 0.005, "Yvrr F": -0.010, "Nvvr F": -0.010, "Nvrr F": 0.0004, "Xvr F": 0.0008},
    sources=("yoon_2009",),
    check="yaw with drift at the extreme speeds",
    excites=("several speeds",),
    not_free_running=_APPROACH,
    in_words="Speed in coupling terms",
)
FROUDE_SURGE: Final = terms(
    "froude_surge",
    "speed",
    "Resistance of sway and yaw that changes with the Froude number.",
    {"Xvv F": -0.0006, "Xrr F": 0.0001},
    sources=("yoon_2009",),
    check="static drift and pure yaw at the extreme speeds",
    excites=("several speeds",),
    not_free_running=_APPROACH,
    in_words="Speed in surge terms",
)
EFFECTS: Final = (
    RESISTANCE_CURVE,
    WAVE_MAKING_HUMP,
    FROUDE_LINEAR,
    FROUDE_NONLINEAR,
    FROUDE_COUPLING,
    FROUDE_SURGE,
)
