"""A waterjet patrol vessel's trials: turns by the jets' angle and a stop by buckets.

    python -m scripts.studies.patrol_vessel [--write FILE]

The trials are those printed in "Estimation of Hydrodynamic Derivatives from Sea Trial Data Using
System Identification Technique" (44 m, three waterjets, 330 t). Of the ship it gives length,
breadth, draught, displacement, power and revolutions; all else is estimated or assumed, named as
such below, and not tuned to the trials. The turns are sailed again with one thing changed at a
time, to show what of it the two turns can tell. `--write` makes `datasets/patrol_vessel`'s model.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, Final

import numpy as np

import pmmkit as pk
from pmmkit.conventions import force_unit
from pmmkit.empirical import estimate
from pmmkit.models import Model, Part
from pmmkit.ship import Ship, Water
from pmmkit.simulation.track import Track

KNOT: Final = 1852 / 3600
L, B, DRAUGHT, MASS = 44.0, 8.36, 1.65, 330e3
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
PAPER: Final = "stated: "
ASSUMED: Final = "assumed: "
PUMP, INTAKE, GEAR = 0.9, 0.8, 0.97
"""Efficiencies of a pump and of the gearing, and the share of the intake's dynamic head that a pump
gets: usual values."""
NOTES: Final = (
    "Not to be relied on. A planing hull at Fn 0.72, estimated by regressions over displacement "
    "ships; jets from the engines' power and usual efficiencies. docs/waterjets.md has her trials "
    "beside it.",
    "She does not heel: neither GM nor the centre of gravity's height is stated.",
    "The paper's speeds differ: 34 knots among the particulars, 29 in the turns, 28.3 in the stop.",
)


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


def patrol_vessel(*, propulsive: float = 0.55, **changes: float) -> Model:
    """The model; `changes` replace values of the jets, or multiply derivatives of the hull."""
    water = Water(rho=1025.0)
    ship = Ship(
        name="Inshore patrol vessel",
        L=L,
        B=B,
        d=DRAUGHT,
        volume=MASS / water.rho,
        mass=MASS,
        xG=0.0,
        Izz=MASS * (0.25 * L) ** 2,
    )
    guess, cross = estimate(ship, "yoshimura-masumoto"), estimate(ship, "clarke")
    values = guess.values | {name: L / DRAUGHT * cross.values[name] for name in ("Yrdot", "Nvdot")}
    doubts = guess.std | {name: L / DRAUGHT * cross.std[name] for name in ("Yrdot", "Nvdot")}
    resistance, fast, flow = jet(propulsive, 0.05)
    unit = force_unit("X", guess.convention.system, ship=ship, water=water, U=TURNING_SPEED)
    values = values | {"Xuu": -resistance / unit}
    doubts = doubts | {"Xuu": 0.25 * resistance / unit}
    values = {name: x * changes.get(name, 1.0) for name, x in values.items()}
    moving = {name: x for name, x in values.items() if name.endswith("dot")}
    jets = {
        "number": float(JETS),
        "nozzle": flow / fast,
        "D": 0.7,
        "phi0": flow / (ENGINE * 0.7**3),
        "w": 0.05,
        "rate_deg_s": 5.0,
        "max_deg": ANGLE,
    }
    parts = (
        _part(
            "hull_polynomial",
            {name: x for name, x in values.items() if name not in moving},
            f"empirical: {guess.source}",
            references=guess.sources[:1],
            std=doubts,
            sources={"Xuu": f"{ASSUMED}{propulsive:g} of the engines' power at 29 knots"},
        ),
        _part(
            "added_mass",
            moving,
            "empirical: Clarke, Gedling and Hine 1983; Zhou et al. 1983",
            references=("clarke_gedling_hine_1983", "zhou_1983"),
            std=doubts,
        ),
        _part(
            "waterjet",
            jets | {name: x for name, x in changes.items() if name not in values},
            f"{ASSUMED}usual values",
            references=("sea_trial_identification",),
            sources={
                "number": f"{PAPER}three waterjets",
                "max_deg": f"{PAPER}the angle of the turns; the largest is not",
                "nozzle": f"{ASSUMED}thrust and power of a jet with usual efficiencies",
                "phi0": f"{ASSUMED}that jet at the 2050 revolutions per minute of the turns",
            },
        ),
    )
    return Model(
        name="patrol-vessel",
        title="Inshore patrol vessel with three waterjets, from her particulars",
        ship=ship,
        water=water,
        convention=guess.convention.with_(surge="constant"),
        parts=MappingProxyType({part.effect: part for part in parts}),
        scale="full scale, L = 44 m; revolutions are those of the engines",
        notes=NOTES,
    )


def _part(
    effect: str,
    values: Mapping[str, float],
    source: str,
    *,
    references: tuple[str, ...],
    std: Mapping[str, float] = MappingProxyType({}),
    sources: Mapping[str, str] = MappingProxyType({}),
) -> Part:
    return Part(
        effect=effect,
        values=MappingProxyType({name: _short(x) for name, x in values.items()}),
        source=source,
        references=references,
        std=MappingProxyType({name: _short(x) for name, x in std.items() if name in values}),
        sources=MappingProxyType(dict(sources)),
    )


def _short(value: float) -> float:
    """Five digits: more say nothing, and a person reads the file."""
    return float(f"{value:.5g}")


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
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--write", help="file for the model")
    options = parser.parse_args()
    model = patrol_vessel()
    if options.write:
        pk.save_model(model, options.write)
    resistance, fast, flow = jet(0.55, 0.05)
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
