"""Waterjets: thrust by the momentum of the jet, steered by its angle, reversed by a bucket."""

from __future__ import annotations

from typing import Final

from pmmkit.effects.effect import Effect, Parameter
from pmmkit.effects.primitives import cos, fabs, sin


def force(
    u: float, n: float, delta: float, bucket: float, L: float, rho: float, number: float,
    nozzle: float, jet: float, D: float, w: float, t: float, xj: float, reverse: float,
) -> tuple[float, float, float, float, float]:  # fmt: skip
    """X, Y [N], N [N m], thrust straight ahead [N] and the force across [N].

    The mass flow ρ A Vj leaves at Vj = `jet` n D and came in at (1 - w) u. The bucket turns the
    part of the jet along the ship round, of which the share `reverse` is left when it is down.

    Examples
    --------
    >>> X, Y, N, *_ = force(0.0, 10.0, 0.1, 0.0, 44.0, 1000.0, 1.0, 0.1, 3.0, 0.5, 0.0, 0.0, -0.5,
    ...                     0.5)
    >>> X > 0, Y < 0, N > 0
    (True, True, True)
    """
    leaving = jet * n * D
    flow = number * rho * nozzle * fabs(leaving)
    along = cos(delta) * (1.0 - bucket * (1.0 + reverse))
    thrust = flow * (leaving - (1.0 - w) * u)
    pull = (1.0 - t) * flow * (leaving * along - (1.0 - w) * u)
    side = -flow * leaving * sin(delta) * (1.0 - bucket * (1.0 - reverse))
    return pull, side, xj * L * side, thrust, side


WATERJET: Final = Effect(
    name="waterjet",
    family="propeller",
    kind="force",
    summary="Waterjets with steering nozzles and reversing buckets.",
    parameters=(
        Parameter(name="number", text="number of jets", default=1.0, low=1.0),
        Parameter(name="nozzle", text="area of one nozzle", unit="m2", low=1e-9),
        Parameter(name="jet", text="speed of the jet over n D"),
        Parameter(name="D", text="diameter of the impeller", unit="m", low=1e-6),
        Parameter(name="w", text="wake fraction of the water taken in", default=0.0, high=0.99),
        Parameter(name="t", text="thrust deduction fraction", default=0.0, high=0.99),
        Parameter(name="xj", text="nozzles forward of midship over L", default=-0.5),
        Parameter(
            name="reverse", text="thrust astern over that ahead, bucket down, at rest",
            default=0.5, low=0.0, high=1.0,
        ),
        Parameter(name="rate_deg_s", text="rate of the steering nozzles", unit="deg/s", low=1e-6),
        Parameter(name="max_deg", text="largest angle of the jet", unit="deg", default=30.0),
    ),
    needs=("n", "delta", "bucket"),
    force=force,
    outputs=("X", "Y", "N", "thrust", "rudder_force"),
    source="Momentum theory of the jet",
)  # fmt: skip
EFFECTS: Final = (WATERJET,)
