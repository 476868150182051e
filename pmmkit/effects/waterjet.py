"""Waterjets: thrust by the momentum of the jet, steered by its angle, reversed by a bucket."""

from __future__ import annotations

from typing import Final

from pmmkit.effects.definition import Effect, Parameter
from pmmkit.effects.primitives import cos, fabs, maximum, minimum, pi, sin


def force(
    u: float,
    v: float,
    r: float,
    n: float,
    delta: float,
    bucket: float,
    L: float,
    rho: float,
    number: float,
    nozzle: float,
    D: float,
    phi0: float,
    phi1: float,
    kq: float,
    w: float,
    t: float,
    xj: float,
    zj: float,
    xi: float,
    turning: float,
    reverse: float,
    reverse_side: float,
    max_deg: float,
) -> tuple[float, float, float, float, float, float, float]:
    """X, Y [N], N, K [N m], thrust straight ahead [N], torque [N m] and the jets' force across [N].

    Each pump takes in the flow Q = phi0 n D³ + phi1 (1 - w) u D², never backwards, and throws it
    out at Q over the area of the nozzle. The momentum of the jet leaves along the nozzle; that of
    the water taken in, (1 - w) u along the ship and v + xi L r across it, is lost to the ship.
    A pump turns one way only: revolutions astern count as ahead. A positive angle turns to
    starboard. The bucket turns a share of the jet forward.

    Examples
    --------
    >>> jets = dict(number=3.0, nozzle=0.1, D=0.6, phi0=0.7, phi1=0.0, kq=0.0, w=0.0, t=0.0,
    ...             xj=-0.5, zj=0.0, xi=-0.4, turning=0.0, reverse=0.5, reverse_side=-0.5,
    ...             max_deg=30.0)
    >>> X, Y, N, *_ = force(5.0, 0.0, 0.0, 10.0, 0.3, 0.0, 44.0, 1025.0, **jets)
    >>> X > 0, Y < 0, N > 0
    (True, True, True)
    """
    most = max_deg * pi / 180.0
    angle = minimum(maximum(delta, -most), most)
    down = minimum(maximum(bucket, 0.0), 1.0)
    along = (1.0 - w) * u
    flow = maximum(D * D * (phi0 * fabs(n) * D + phi1 * along), 0.0)
    mass = number * rho * flow
    jet = mass * flow / nozzle
    thrust = jet - mass * along
    share = 1.0 - down * (1.0 + reverse)
    sideways = 1.0 - down * (1.0 - reverse_side)
    steering = -jet * sideways * sin(angle)
    intake = -turning * mass * (v + xi * L * r)
    side = steering + intake
    return (
        (1.0 - t) * (jet * share * cos(angle) - mass * along),
        side,
        L * (xj * steering + xi * intake),
        -zj * L * steering,
        thrust,
        number * kq * rho * n * n * D * D * D * D * D,
        steering,
    )


WATERJET: Final = Effect(
    name="waterjet",
    family="waterjet",
    kind="force",
    roles=("propulsion", "steering"),
    summary="Waterjets with steering nozzles and reversing buckets.",
    parameters=(
        Parameter(name="number", text="number of jets", default=1.0, low=0.0),
        Parameter(name="nozzle", text="area of one nozzle", unit="m2", low=1e-9),
        Parameter(name="D", text="diameter of a pump", unit="m", low=1e-6),
        Parameter(name="phi0", text="flow of a pump over n D³ at rest", low=0.0),
        Parameter(name="phi1", text="growth of that flow with (1 - w) u/(n D)", default=0.0),
        Parameter(name="kq", text="torque of a pump over ρn²D⁵", default=0.0, low=0.0),
        Parameter(name="w", text="wake fraction of the intake", default=0.0, low=-0.99, high=0.99),
        Parameter(name="t", text="thrust deduction fraction", default=0.0, low=-0.99, high=0.99),
        Parameter(name="xj", text="nozzles forward of midship over L", default=-0.5),
        Parameter(name="zj", text="nozzles below the origin over L", default=0.0),
        Parameter(name="xi", text="intakes forward of midship over L", default=-0.4),
        Parameter(
            name="turning",
            text="share of the cross flow at the intake that the ship must stop",
            default=1.0,
            low=0.0,
            high=1.0,
        ),
        Parameter(
            name="reverse",
            text="force astern over that of the jet, bucket down",
            default=0.5,
            low=0.0,
            high=1.0,
        ),
        Parameter(
            name="reverse_side",
            text="side force over that of the jet ahead, bucket down; minus "
            "reverse if the bucket turns with the nozzle",
            default=-0.5,
            low=-1.0,
            high=1.0,
        ),
        Parameter(name="rate_deg_s", text="rate of the steering nozzles", unit="deg/s", low=1e-6),
        Parameter(
            name="max_deg",
            text="largest angle of the jet",
            unit="deg",
            default=30.0,
            low=0.0,
            high=90.0,
        ),
    ),
    needs=("n", "delta", "bucket"),
    astern=True,
    force=force,
    outputs=("X", "Y", "N", "K", "thrust", "torque", "rudder_force"),
    sources=(),
    remark="Momentum of the jet less that of the water taken in; the shares of the bucket are "
    "typical values, to be replaced by those of the maker",
)
EFFECTS: Final = (WATERJET,)
