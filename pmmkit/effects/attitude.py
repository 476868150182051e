"""How the ship sits in the water: sinkage and trim at speed, and what they do to the forces."""

from __future__ import annotations

from typing import Final

from pmmkit.effects.definition import Effect, Parameter


def squat(
    Fn: float, d: float, sinkage_per_Fn2: float, trim_deg_per_Fn2: float
) -> tuple[float, float]:
    """Sinkage [m], positive down, and trim [rad], positive bow up, of a ship at speed.

    Examples
    --------
    >>> squat(0.5, 4.0, 0.25, 0.0)
    (0.25, 0.0)
    """
    square = Fn * Fn
    return sinkage_per_Fn2 * d * square, trim_deg_per_Fn2 * square * 0.017453292519943295


def force(
    v: float,
    U: float,
    L: float,
    d: float,
    rho: float,
    sinkage: float,
    trim: float,
    Yv_sinkage: float,
    Nv_sinkage: float,
    Nv_trim: float,
) -> tuple[float, float]:
    """Y [N] and N [N m] of sway on a hull that sits deeper, or by the stern.

    ½ρL²U² v' Yv_sinkage s/d, and ½ρL³U² v' (Nv_sinkage s/d + Nv_trim trim L/d).

    Examples
    --------
    >>> force(0.5, 1.0, 4.0, 0.2, 1000.0, 0.002, 0.0, -0.02, 0.0, 0.0)
    (-0.8, 0.0)
    """
    unit = 0.5 * rho * L * L * U * v
    deeper = sinkage / d
    return unit * Yv_sinkage * deeper, unit * L * (Nv_sinkage * deeper + Nv_trim * trim * L / d)


SQUAT: Final = Effect(
    name="squat",
    family="attitude",
    kind="force",
    summary="Sinkage and trim of the ship at speed, for effects that ask for them.",
    parameters=(
        Parameter(name="sinkage_per_Fn2", text="sinkage over the draught and Fn²", low=0.0),
        Parameter(name="trim_deg_per_Fn2", text="trim, bow up, over Fn²", unit="deg", default=0.0),
    ),
    force=squat,
    outputs=("sinkage", "trim"),
    sources=("ittc_7.5-02-02-01",),
)
SINKAGE_TRIM: Final = Effect(
    name="sinkage_trim",
    in_words="Sinkage and trim",
    family="attitude",
    kind="force",
    summary="Forces of sway that grow as the hull sits deeper, and turn with its trim.",
    parameters=(
        Parameter(
            name="Yv_sinkage",
            text="change of Yv per sinkage over the draught",
            typical=-2.0 * 0.0116,
        ),
        Parameter(
            name="Nv_sinkage",
            text="change of Nv per sinkage over the draught",
            typical=-2.0 * 0.00385,
        ),
        Parameter(name="Nv_trim", text="change of Nv per trim [rad] times L/d", typical=0.002),
    ),
    force=force,
    outputs=("Y", "N"),
    sources=("ittc_7.5-02-02-01", "inoue_hirano_kijima_1981"),
    check="the same runs with the model free and fixed in heave and pitch",
    excites=("sinkage",),
    not_free_running="sinkage goes with the square of the speed, which a model holds by its Fn",
)
EFFECTS: Final = (SQUAT, SINKAGE_TRIM)
