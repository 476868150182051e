"""Propulsion, rudder and shallow water of tankers in the bis system, as Berlekom and Goddard."""

from __future__ import annotations

from typing import Final

from pmmkit.effects.definition import Effect, Parameter
from pmmkit.effects.primitives import atan2, fabs, maximum


def force(
    u: float,
    v: float,
    r: float,
    delta: float,
    n: float,
    L: float,
    d: float,
    rho: float,
    volume: float,
    depth: float,
    t: float,
    Tuu: float,
    Tun: float,
    Tnn: float,
    YT: float,
    NT: float,
    cun: float,
    cnn: float,
    Xccdd: float,
    Xccbd: float,
    Yccd: float,
    Yccbbd: float,
    Nccd: float,
    Nccbbd: float,
    Yccbbdz: float,
    Nccbbdz: float,
    Xuuz: float,
    Xvrz: float,
    Xvvzz: float,
    Yurz: float,
    Yvvz: float,
    Nurz: float,
    Nuvz: float,
    Nvrz: float,
    Yuvz_limit: float,
    Xudotz: float,
    Yvdotz: float,
    Nrdotz: float,
) -> tuple[float, float, float, float, float, float, float, float]:
    """X, Y [N], N [N m], thrust, rudder's side force [N], and added mass by the depth.

    Everything is written per displaced mass: thrust Tuu u²/L + Tun u n + L Tnn n|n|, rudder by the
    square of the speed at it, c² = cun u n + cnn n², with ζ = d/(h - d).
    """
    mass = rho * volume
    z = d / maximum(depth - d, 1e-6)
    thrust = Tuu * u * u / L + Tun * u * n + L * Tnn * n * fabs(n)
    square = maximum(cun * u * n + cnn * n * n, 0.0)
    beta = atan2(v, maximum(u, 1e-9))
    port = -delta
    bent = square * fabs(beta) * beta * fabs(port)
    Yuvz = -0.85 * maximum(1.0 - Yuvz_limit / maximum(z, 1e-9), 0.0)
    X = thrust * (1.0 - t) + square / L * (Xccdd * port * port + Xccbd * beta * port)
    X += z / L * (Xuuz * u * u + L * Xvrz * v * r + Xvvzz * v * v * z)
    side = Yccd * square * port / L
    Y = side + (Yccbbd + Yccbbdz * z) * bent / L + YT * thrust
    Y += z / L * (L * Yurz * u * r + Yuvz * u * v + Yvvz * fabs(v) * v)
    N = Nccd * square * port + (Nccbbd + Nccbbdz * z) * bent + NT * L * thrust
    N += z * (L * Nurz * u * r + Nuvz * u * v + L * Nvrz * fabs(v) * r)
    return (
        mass * X,
        mass * Y,
        mass * N,
        mass * thrust,
        mass * side,
        mass * Xudotz * z,
        mass * Yvdotz * z,
        mass * L * L * Nrdotz * z,
    )


_TERMS: Final = {
    "Tuu": "thrust per u²/L",
    "Tun": "thrust per u n",
    "Tnn": "thrust per L n|n|",
    "YT": "side force over thrust",
    "NT": "moment over thrust and L",
    "cun": "speed at the rudder squared per u n",
    "cnn": "per n²",
    "Xccdd": "rudder drag",
    "Xccbd": "rudder drag with drift",
    "Yccd": "rudder force",
    "Yccbbd": "rudder force lost with drift",
    "Nccd": "rudder moment",
    "Nccbbd": "rudder moment lost with drift",
}
_UNITS: Final = {"cun": "m", "cnn": "m2"}
_SHALLOW: Final = {
    "Yccbbdz": "Yccbbd per ζ",
    "Nccbbdz": "Nccbbd per ζ",
    "Xuuz": "Xuu per ζ",
    "Xvrz": "Xvr per ζ",
    "Xvvzz": "Xvv per ζ²",
    "Yurz": "Yur per ζ",
    "Yvvz": "Yv|v| per ζ",
    "Nurz": "Nur per ζ",
    "Nuvz": "Nuv per ζ",
    "Nvrz": "N|v|r per ζ",
    "Xudotz": "Xudot per ζ",
    "Yvdotz": "Yvdot per ζ",
    "Nrdotz": "Nrdot per ζ",
}
TANKER_BIS: Final = Effect(
    name="tanker_bis",
    in_words="Tanker (bis system)",
    family="propeller",
    kind="force",
    roles=("propulsion", "steering"),
    summary="Propeller, rudder and shallow-water terms of a tanker per displaced mass (bis "
    "system).",
    parameters=(
        Parameter(name="t", text="thrust deduction fraction", low=-0.99, high=0.99),
        *(
            Parameter(name=name, text=text, unit=_UNITS.get(name, "-"))
            for name, text in _TERMS.items()
        ),
        *(Parameter(name=name, text=text, default=0.0) for name, text in _SHALLOW.items()),
        Parameter(
            name="Yuvz_limit",
            text="ζ from which Yuv falls by 0.85 (1 - limit/ζ) per ζ",
            default=1e9,
            low=0.0,
        ),
        Parameter(name="rate_deg_s", text="rate of the steering gear", unit="deg/s", low=1e-6),
        Parameter(name="max_deg", text="largest rudder angle", unit="deg", default=90.0, low=0.0),
    ),
    needs=("delta", "n", "depth"),
    astern=True,
    force=force,
    outputs=("X", "Y", "N", "thrust", "rudder_force", "Xudot", "Yvdot", "Nrdot"),
    sources=("van_berlekom_goddard_1972",),
    remark="Appendix A",
)
EFFECTS: Final = (TANKER_BIS,)
