"""A bulk carrier's trials: crash stop and turning circles against a model with few measured values.

    python -m scripts.studies.bulk_carrier

Trial and hull derivatives are those printed in "Estimation of Hydrodynamic Derivatives from Sea
Trial Data Using System Identification Technique" (170 m bulk carrier in ballast, 19 137 t). It
gives nine derivatives and neither propeller, rudder nor resistance: these are estimated from the
particulars, named as such below, and not tuned to the trial. The stop is also run with estimates
varied, to show which of them decides it.
"""

from __future__ import annotations

import math
from types import MappingProxyType

import pmmkit as pk
from pmmkit.effects.cross_flow import hoerner_cd
from pmmkit.empirical import friction_coefficient
from pmmkit.models import Model, Part
from pmmkit.ship import Ship, Water, viscosity

KNOT = 1852 / 3600
L, B, D_MEAN, MASS = 170.0, 28.0, 5.104, 19_137e3
WATER = Water(rho=1025.0, nu=1.19e-6)
VOLUME = MASS / WATER.rho
BLOCK = VOLUME / (L * B * D_MEAN)
TRIAL = 14.1 * KNOT
TURNS = {
    (-35.0, "advance_L"): 3.61,
    (-35.0, "transfer_L"): 0.74,
    (-35.0, "tactical_diameter_L"): 2.99,
    (35.0, "advance_L"): 3.62,
    (35.0, "transfer_L"): 0.85,
    (35.0, "tactical_diameter_L"): 3.08,
}
"""Turning circles of the trial: rudder [deg, to starboard] and metric."""
STOP = {"time_to_stop": 587.0, "track_reach": 2407.0}
"""The crash stop of the trial [s, m]."""
POWER, RATED = 6.5e6, 127 / 60
PAPER = "paper: identified from the sea trial"
ESTIMATE = "estimated: from particulars"
PRINTED = {
    "Xudot": -73.7e-5,
    "Yvdot": -1219.0e-5,
    "Yrdot": -92.8e-5,
    "Nvdot": -40.2e-5,
    "Nrdot": -64.8e-5,
    "Yv": -1369.8e-5,
    "Yr": 299.4e-5,
    "Nv": -725.0e-5,
    "Nr": -229.0e-5,
}


def resistance_coefficient(speed: float) -> float:
    """Xuu' from the ITTC 1957 line, form factor 1.2, allowance 0.0004, residuary 0.0006."""
    wetted = 1.7 * L * D_MEAN + VOLUME / D_MEAN
    friction = friction_coefficient(speed * L / viscosity(WATER))
    return -(1.2 * friction + 0.0004 + 0.0006) * wetted / L**2


def bulk_carrier(**changes: float) -> Model:
    """The model; `changes` replace estimates (t_astern, astern_share, reverse_below, CD)."""
    given = {
        "t_astern": 0.1,
        "astern_share": 0.8,
        "reverse_below": 0.35 * RATED,
        "CD": hoerner_cd(B, D_MEAN),
    } | changes
    hull = {name: x for name, x in PRINTED.items() if not name.endswith("dot")}
    mass = {name: x for name, x in PRINTED.items() if name.endswith("dot")}
    estimated = {
        "Xuu": resistance_coefficient(TRIAL),
        "Xvv": 0.0,
        "Xrr": 0.0,
        "Xvr": 0.7 * -PRINTED["Yvdot"],
    }
    parts = (
        Part(
            effect="hull_polynomial",
            values=MappingProxyType(hull | estimated),
            source=PAPER,
            sources=MappingProxyType(dict.fromkeys(estimated, ESTIMATE)),
        ),
        Part(effect="added_mass", values=MappingProxyType(mass), source=PAPER),
        Part(
            effect="crossflow_drag",
            source="estimated: Hoerner's curve over B/(2d)",
            values=MappingProxyType({"CD": given["CD"]}),
        ),
        Part(
            effect="four_quadrant_propeller",
            source=ESTIMATE,
            options=MappingProxyType({"characteristics": "b4-70"}),
            values=MappingProxyType(
                {
                    "D": 5.0,
                    "pitch": 0.7,
                    "t": 0.2,
                    "t_astern": given["t_astern"],
                    "wp": 0.5 * BLOCK - 0.05,
                    "xp": -0.48,
                }
            ),
        ),
        Part(
            effect="shaft",
            source=ESTIMATE,
            options=MappingProxyType({"limit": "constant"}),
            values=MappingProxyType(
                {
                    "inertia": 6e4,
                    "torque_max": POWER / (2 * math.pi * RATED),
                    "astern_share": given["astern_share"],
                    "reverse_below": given["reverse_below"],
                    "friction": 0.02 * POWER / (2 * math.pi * RATED),
                }
            ),
        ),
        Part(
            effect="rudder_mmg",
            source=ESTIMATE,
            options=MappingProxyType({"inflow": "mmg"}),
            values=MappingProxyType(
                {
                    "area": 27.0,
                    "lift_slope": 6.13 * 1.6 / (1.6 + 2.25),
                    "epsilon": 1.1,
                    "kappa": 0.5,
                    "eta": 5.0 / math.sqrt(27.0 * 1.6),
                    "gamma_positive": 0.45,
                    "gamma_negative": 0.45,
                    "lR": -0.9,
                    "tR": 0.45 - 0.28 * BLOCK,
                    "aH": 0.627 * BLOCK - 0.153,
                    "xH": -0.45,
                    "rate_deg_s": 2.8,
                }
            ),
        ),
    )
    return Model(
        name="bulk carrier, 170 m, ballast",
        ship=Ship(
            name="bulk carrier",
            L=L,
            B=B,
            d=D_MEAN,
            volume=VOLUME,
            mass=MASS,
            xG=0.0,
            Izz=MASS * (0.25 * L) ** 2,
        ),
        water=WATER,
        parts=MappingProxyType({part.effect: part for part in parts}),
        scale="full scale, L = 170 m; propulsion point: self-propulsion of the model's equations",
    )


def main() -> None:
    model = bulk_carrier()
    start = pk.simulate(model, "turning", rudder_deg=35, speed=TRIAL, compiled=False)
    print(
        f"CB {BLOCK:.3f}, {60 * start.n[0]:.0f} rpm at 14.1 kn (rated {60 * RATED:.0f} at 6500 kW)"
    )
    print("\nTurning circles, 35°, in L        trial   model")
    for side in dict.fromkeys(angle for angle, _ in TURNS):
        track = pk.simulate(model, "turning", rudder_deg=side, speed=TRIAL, compiled=False)
        for name, trial in ((name, x) for (angle, name), x in TURNS.items() if angle == side):
            found = track.metrics[name]
            off = 100 * (found / trial - 1)
            where = "port" if side < 0 else "starboard"
            print(f"  {where:10} {name:20} {trial:6.2f}  {found:6.2f}  {off:+.0f} %")
    print("\nCrash stop from 14.1 kn          time [s]   track reach [m]   over L")
    print(f"  {'trial':30} {STOP['time_to_stop']:8.0f} {STOP['track_reach']:14.0f} {14.2:12.1f}")
    cases: dict[str, dict[str, float]] = {
        "model, as estimated": {},
        "no thrust deduction astern": {"t_astern": 0.0},
        "thrust deduction astern 0.3": {"t_astern": 0.3},
        "torque astern as ahead": {"astern_share": 1.0},
        "torque astern 0.6 of ahead": {"astern_share": 0.6},
        "reversed at once": {"reverse_below": 10.0},
        "reversed below 25 % of rated": {"reverse_below": 0.25 * RATED},
    }
    for title, changes in cases.items():
        found = pk.simulate(
            bulk_carrier(**changes), "stopping", speed=TRIAL, turns=-0.8, compiled=False
        ).metrics
        off = found["track_reach"] / STOP["track_reach"] - 1
        print(
            f"  {title:30} {found['time_to_stop']:8.0f} {found['track_reach']:14.0f} "
            f"{found['track_reach_L']:12.1f}   {100 * off:+.0f} %"
        )


if __name__ == "__main__":
    main()
