"""A waterjet patrol vessel's trials: turns by the jets' angle and a stop by buckets.

    python -m scripts.studies.patrol_vessel

The trials are those printed in "Estimation of Hydrodynamic Derivatives from Sea Trial Data Using
System Identification Technique" (44 m, three waterjets, 330 t). Of `patrol-vessel-44` of the
library it gives length, breadth, draught, displacement, power and revolutions; all else is
estimated and not tuned to the trials. The turns are sailed again with one thing changed at a time,
to show what of it the two turns can tell.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Final

import numpy as np

import pmmkit as pk
from pmmkit.models import Model
from pmmkit.simulation import Track

NAME: Final = "patrol-vessel-44"
KNOT: Final = 1852 / 3600
L, MASS = 44.0, 330e3
TURNING_SPEED, STOPPING_SPEED = 29.0 * KNOT, 28.3 * KNOT
ENGINE, POWER, JETS = 2050 / 60, 2720e3, 3
ANGLE = 30.0
TURNS: Final[Mapping[tuple[float, str], float]] = {
    (-ANGLE, "advance_L"): 4.05,
    (-ANGLE, "transfer_L"): 2.48,
    (-ANGLE, "tactical_diameter_L"): 4.10,
    (ANGLE, "advance_L"): 3.75,
    (ANGLE, "transfer_L"): 2.15,
    (ANGLE, "tactical_diameter_L"): 3.24,
}
"""Turning circles of the trial: angle of the jets [deg, to starboard] and metric."""
TIMES: Final = {-ANGLE: 57.0, ANGLE: 56.0}
"""Times of the turns [s]; the paper does not say to which heading: taken as 360°."""
STOP: Final = {"time_to_stop": 25.0, "track_reach": 209.0}
"""The stop by buckets of the trial [s, m]."""
PROPULSIVE: Final = 0.55
"""Share of the engines' power that reaches the hull at 29 knots in the ship of the library."""
PUMP, INTAKE, GEAR = 0.9, 0.8, 0.97
"""Efficiencies of a pump and of the gearing, and the share of the intake's dynamic head that a pump
gets: usual values."""


def jet(propulsive: float, wake: float) -> tuple[float, float, float]:
    """Resistance of the ship [N], speed of a jet [m/s] and flow of a pump [m³/s].

    Parameters
    ----------
    propulsive : float
        Resistance times speed over the engines' power, in the approach to a turn.
    wake : float
        Fraction at the intakes.

    Notes
    -----
    Thrust ρQ(Vj - ui) of a jet is a third of the resistance; its pump's power goes into
    ½ρQ(Vj² - 0.8 ui²). The faster of the two jets that meet both is the smaller one.
    """
    resistance = propulsive * JETS * POWER / TURNING_SPEED
    thrust, inflow = resistance / JETS, (1.0 - wake) * TURNING_SPEED
    half = GEAR * PUMP * POWER / thrust
    fast = half + math.sqrt(half**2 - 2.0 * half * inflow + INTAKE * inflow**2)
    return resistance, fast, thrust / (1025.0 * (fast - inflow))


def patrol_vessel(*, propulsive: float = PROPULSIVE, **changes: float) -> Model:
    """The ship of the library; `changes` replace values of the jets, or multiply derivatives."""
    model = pk.load_model(NAME)
    hull, jets = model.values("hull_polynomial"), model.values("waterjet")
    if propulsive != PROPULSIVE:
        _, fast, flow = jet(propulsive, jets["w"])
        changes |= {
            "nozzle": flow / fast,
            "phi0": flow / (ENGINE * jets["D"] ** 3),
            "Xuu": propulsive / PROPULSIVE,
        }
    multiplied = {name: x * hull[name] for name, x in changes.items() if name in hull}
    replaced = {name: x for name, x in changes.items() if name not in hull}
    return model.with_values("hull_polynomial", **multiplied).with_values("waterjet", **replaced)


def turned(model: Model, angle: float = ANGLE) -> Track:
    """A turning circle as in the trial."""
    return pk.simulate(
        model, "turning", rudder_deg=angle, speed=TURNING_SPEED, compiled=False, dt=0.05
    )


def round_once(track: Track) -> float:
    """Time of a turn by 360° [s]."""
    return float(np.interp(2.0 * math.pi, np.abs(track.psi), track.t))


def by_course(track: Track) -> tuple[float, float, float]:
    """Advance, transfer and tactical diameter [L] at 90° and 180° of the course, not the heading.

    A log of positions shows the course; in a turn it lags behind the heading by the drift angle.
    """
    course = np.unwrap(track.psi + np.arctan2(track.v, track.u))
    first, half = (float(np.interp(angle, course, track.t)) for angle in (math.pi / 2, math.pi))
    advance, transfer = (float(np.interp(first, track.t, way)) / L for way in (track.x, track.y))
    return advance, transfer, float(np.interp(half, track.t, track.y)) / L


def stopped(model: Model, **settings: float) -> Mapping[str, Any]:
    """Numbers of a stop as in the trial."""
    return pk.simulate(model, "stopping", speed=STOPPING_SPEED, compiled=False, **settings).metrics


CHANGES: Final[Mapping[str, Mapping[str, float]]] = {
    "as estimated": {},
    "jets turned at 2.5°/s (5)": {"rate_deg_s": 2.5},
    "jets turned at 10°/s": {"rate_deg_s": 10.0},
    "intakes do not stop the cross flow": {"turning": 0.0},
    "0.58 of the power reaches the hull (0.55)": {"propulsive": 0.58},
    "0.50 of it": {"propulsive": 0.50},
    "Nr 10 % larger": {"Nr": 1.1},
    "Nv 20 % smaller": {"Nv": 0.8},
    "Yv 20 % larger": {"Yv": 1.2},
    "Nvvr 35 % larger": {"Nvvr": 1.35},
    "Nrrr 30 % larger": {"Nrrr": 1.3},
    "Nvvr 35 %, Nr 20 % larger": {"Nvvr": 1.35, "Nr": 1.2},
}
"""What is varied, one at a time; of the hull by the standard errors of the estimates."""
STOPS: Final[Mapping[str, Mapping[str, float]]] = {
    "pumps run on": {"turns": -1.0},
    "pumps at 0.7 of it, as pmmkit assumes": {"turns": -0.7},
    "pumps at 0.5": {"turns": -0.5},
    "pumps run on, bucket down in 15 s": {"turns": -1.0, "reversal_s": 15.0},
}


def main() -> None:
    model = patrol_vessel()
    resistance, fast, flow = jet(PROPULSIVE, model.values("waterjet")["w"])
    print(
        f"Resistance {resistance / 1e3:.0f} kN, {resistance / MASS / 9.81:.3f} of the weight; jets "
        f"{fast:.1f} m/s, {flow:.2f} m³/s each, nozzle {math.sqrt(4 * flow / fast / math.pi):.2f} m"
    )
    print(f"{'':42} advance  transfer  tactical diameter [L]  360° [s]")
    for angle, side in ((-ANGLE, "port"), (ANGLE, "starboard")):
        told = "".join(f"{x:9.2f}" for (own, _), x in TURNS.items() if own == angle)
        print(f"trial, to {side:32}{told}{TIMES[angle]:20.0f}")
    for title, changes in CHANGES.items():
        track = turned(patrol_vessel(**changes))
        told = "".join(f"{track.metrics[name]:9.2f}" for own, name in TURNS if own > 0)
        print(f"{title:42}{told}{round_once(track):20.0f}")
        told = "".join(f"{x:9.2f}" for x in by_course(track))
        print(f"{'    by course, not by heading':42}{told}")
    print(f"\n{'stop from 28.3 knots':42} time [s]  track reach [m]")
    print(f"{'trial':42}{STOP['time_to_stop']:9.1f}{STOP['track_reach']:15.0f}")
    for title, settings in STOPS.items():
        found = stopped(model, **settings)
        print(f"{title:42}{found['time_to_stop']:9.1f}{found['track_reach']:15.0f}")
    track = turned(model)
    side = float(np.hypot(track.u[-1], track.v[-1]) * track.r[-1])
    ratio = side / 9.81 / math.tan(math.radians(12.0))
    print(
        f"\nA steady heel of 12° is that of GM = {ratio:.2f} of the lever from G to the side force"
    )


if __name__ == "__main__":
    main()
