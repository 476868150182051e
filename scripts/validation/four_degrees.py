"""Ships that roll: S175 and KCS in four degrees of freedom."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from typing import Final

import numpy as np

from pmmkit.conventions import Ship
from pmmkit.models import load_model
from pmmkit.simulation import simulate, stability
from scripts.validation.forces import FRESH, MMG, polynomial
from scripts.validation.published import Published, Values, table
from scripts.validation.sailed import turns, zigzags

SON_NOMOTO = {
    "sources": ("son_nomoto_1981", "fossen_perez_2004"),
    "nature": "recomputed",
    "part": "program",
}
PORT = SON_NOMOTO | {
    "place": "their values as `container.m` has them, in another port of that program",
    "how": "library ships `s175-3dof` and `s175`, rudder at 2.34°/s, which fits that port",
    "within": 0.015,
}
GEAR: Final = 2.34

KCS: Final = Ship(
    name="KCS", L=230.0, B=32.2, d=10.8, volume=52030.0, mass=5.203e7, Izz=1.7e11, xG=-3.39
)
OKUDA: Final = {
    "Xuu": -0.020, "Xvv": -0.087, "Xvr": -0.093, "Xrr": -0.023, "Xvvvv": 0.809,
    "Xvphi": 0.010, "Xrphi": 0.009, "Xphiphi": -0.002,
    "Yv": -0.243, "Yr": 0.055, "Yvvv": -1.675, "Yvvr": -0.083, "Yvrr": -0.447, "Yrrr": 0.020,
    "Yphi": 0.001, "Yvvphi": 0.161, "Yvphiphi": -0.243, "Yrphiphi": -0.130,
    "Nv": -0.105, "Nr": -0.036, "Nvvv": -0.288, "Nvvr": -0.579, "Nvrr": -0.003, "Nrrr": -0.042,
    "Nphi": -0.009, "Nvvphi": -0.327, "Nvphiphi": -0.232, "Nrphiphi": 0.041,
}  # fmt: skip
"""KCS by Okuda, Yasukawa and Matsuda (2023) over ½ρLdU², as the test of xdyn quotes it."""
LEVER: Final = 3.704
"""Of the side force of the hull below the waterline [m]."""
MX, MY = (share * 0.5 * 1000.0 * 230.0**2 * 10.8 for share in (0.006, 0.152))


@cache
def kcs(phi_deg: float) -> Values:
    """Forces on KCS at u 10, v -2 m/s in the centre of gravity, r 1 rad/s and a heel."""
    rolled = {
        f"K{name[1:]}": -LEVER / KCS.L * value for name, value in OKUDA.items() if name[0] == "Y"
    }
    u, v, r, phi = 10.0, -2.0 + KCS.xG, 1.0, math.radians(phi_deg)
    forces = polynomial({**OKUDA, **rolled}, KCS, MMG, u=u, v=v, r=r, phi=phi)
    righting = -FRESH.g * KCS.mass * 0.6 * phi
    return {
        "X": forces["X"] + MY * v * r,
        "Y": forces["Y"] - MX * u * r,
        "K": forces["K"] + righting,
        "N": forces["N"],
    }


def okuda(title: str, phi_deg: float, values: Values) -> tuple[Published, ...]:
    """Forces on KCS at a heel."""
    return table(
        title,
        values,
        lambda: kcs(phi_deg),
        unit={"X": "N", "Y": "N", "K": "N m", "N": "N m"},
        sources=("okuda_yasukawa_matsuda_2023", "xdyn"),
        place="expected values of the program's test of the MMG model with the paper's derivatives",
        nature="computed",
        part="program",
        how="a hull polynomial with terms of heel, the moment of roll by the side force on its "
        "lever, added mass in the Coriolis terms, and the righting moment",
        within=1e-6,
    )


@cache
def steady(speed: float) -> Values:
    """The end of a turn of S175 with the public program's steering gear."""
    track = simulate(
        "s175",
        speed=speed,
        rudder_deg=35.0,
        rudder_law="lag",
        rudder_lag=1.0,
        rudder_rate_deg=5.0,
        duration=1200.0,
    )
    return {
        "u": track.u[-1],
        "v": track.v[-1],
        "r": math.degrees(track.r[-1]),
        "heel": math.degrees(track.phi[-1]),
    }


def octave(speed: float, values: Values) -> tuple[Published, ...]:
    """The end of a turn beside the public program."""
    return table(
        f"S175, steady turn at 35° from {speed:g} m/s",
        values,
        lambda: steady(speed),
        unit={"u": "m/s", "v": "m/s", "r": "°/s", "heel": "°"},
        place="`container.m` run in GNU Octave for 1200 s, Runge-Kutta steps of 0.05 s",
        how="library ship `s175`, rudder with that program's lag",
        within=5e-4,
        **SON_NOMOTO,
    )


@cache
def linear() -> Values:
    """S175 straight ahead at 7 m/s, over the prime system."""
    found = stability("s175-3dof", 7.0)
    model = load_model("s175-3dof")
    mass, added = 0.00792, model.values("added_mass")
    inertia = float(model.ship.Izz / (0.5 * model.water.rho * model.ship.L**5))
    return {
        "Yδ": found.rudder[0],
        "Nδ": found.rudder[1],
        "Nv/Yv": found.lever_sway,
        "Nr/(Yr - m - mx)": found.lever_yaw,
        "m - Yvdot": mass - float(added["Yvdot"]),
        "-Yrdot": -float(added["Yrdot"]),
        "Iz - Nrdot": inertia - float(added["Nrdot"]),
    }


def of_both(values: Mapping[tuple[str, float], Mapping[tuple[float, float], tuple[float, ...]]]):
    """Zigzags of S175 with and without roll."""
    for (model, speed), angles in values.items():
        roll = "with roll" if model == "s175" else "without roll"
        yield from zigzags(
            f"S175 {roll}, zigzags at {speed:g} m/s", model, speed, angles, rate=GEAR, **PORT
        )


CIRCLES: Final = {
    ("s175-3dof", 6.0): (3.510, 1.983, 4.365, 1.771),
    ("s175-3dof", 9.0): (3.619, 1.990, 4.374, 1.771),
    ("s175-3dof", 12.0): (3.725, 1.999, 4.386, 1.771),
    ("s175", 6.0): (3.425, 1.905, 4.239, 1.743),
    ("s175", 9.0): (3.403, 1.795, 4.066, 1.707),
    ("s175", 12.0): (3.235, 1.564, 3.725, 1.651),
}
"""Advance, transfer, tactical diameter and steady radius over L at 35° to starboard."""


def circles():
    """Turns of S175 with and without roll."""
    metrics = ("advance_L", "transfer_L", "tactical_diameter_L", "steady_diameter_L")
    for (model, speed), numbers in CIRCLES.items():
        roll = "with roll" if model == "s175" else "without roll"
        values = np.multiply(numbers, (1, 1, 1, 2)).tolist()
        yield from turns(
            f"S175 {roll}, turning circle at {speed:g} m/s",
            model,
            speed,
            {(35.0, metric): value for metric, value in zip(metrics, values, strict=True)},
            rate=GEAR,
            **PORT,
        )


FIGURES: tuple[Published, ...] = (
    *circles(),
    *of_both(
        {
            ("s175-3dof", 6.0): {(10, 10): (3.86, 4.58), (20, 20): (7.23, 6.83)},
            ("s175-3dof", 12.0): {(10, 10): (5.47, 6.22), (20, 20): (11.34, 10.57)},
            ("s175", 6.0): {(10, 10): (4.03, 5.07), (20, 20): (7.85, 7.21)},
            ("s175", 12.0): {(10, 10): (7.26, 10.33), (20, 20): (19.14, 13.72)},
        }
    ),
    *octave(6.0, {"u": 2.6661, "v": -0.6000, "r": 0.514477, "heel": -1.573}),
    *octave(12.0, {"u": 5.2107, "v": -1.2090, "r": 1.062846, "heel": -6.330}),
    *table(
        "S175, made linear at 7 m/s",
        {
            "m - Yvdot": 0.01497, "-Yrdot": 0.0003525, "Iz - Nrdot": 0.000875,
            "Nv/Yv": 0.0038436 / 0.012035, "Nr/(Yr - m - mx)": 0.00243 / 0.00522,
            "Yδ": -0.002578, "Nδ": 0.00126,
        },
        linear,
        place="matrices of `Lcontainer.m`",
        how="the equations of library ship `s175-3dof` made linear at 7 m/s",
        within=0.2,
        why="They hold a rudder in another slipstream than that of the nonlinear program at the "
        "same speed: the whole rudder is a seventh weaker, sway and yaw damping differ with it.",
        sources=("fossen_perez_2004",),
        nature="computed",
        part="program",
    ),
    *okuda(
        "KCS, forces upright",
        0.0,
        {"X": -1601757553.1071172, "Y": 40686696096.544792,
         "K": -150767007420.00192, "N": -12949573903321.889},
    ),
    *okuda(
        "KCS, forces at 30° of heel to port",
        -30.0,
        {"X": -1616739557.1540694, "Y": 40572979614.85589,
         "K": -150185450190.3095, "N": -12938477140345.436},
    ),
)  # fmt: skip
