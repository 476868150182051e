"""Find how the S175's derivatives must change with Fn for the turning circles of a published study.

The smallest linear dependence on Fn² (least sum of squares of the relative slopes, none above
40 %) with which the 3-DOF ship, full scale, 35° of rudder at 5°/s, turns as published from 6 to
12 m/s. Writes datasets/s175/truth.toml; the same file every time.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scripts.datasets.s175_truth import Truth
from scipy.optimize import lsq_linear

from pmmkit.files import datasets_folder, write_text
from pmmkit.models import Model, load_model, to_model
from pmmkit.simulation import simulate
from pmmkit.files import toml_text

Array = NDArray[np.float64]
SPEEDS = (6.0, 9.0, 12.0)
TARGET = {
    "steady_diameter": 0.2269,
    "tactical_diameter": 0.2193,
    "transfer": 0.1879,
    "advance": 0.1373,
}
LARGEST = 0.40
WEIGHT = 1e4
STEP = 1e-3
HEADER = """\
# The truth behind the synthetic S175 programme of this folder. SYNTHETIC: these are not measured.
# Written by scripts/datasets/make_s175_truth.py; read it with load_truth() of scripts/datasets/s175_truth.py.
#
# [derivatives] holds the values at Fn_low: Son and Nomoto's set (datasets/ships/s175-3dof.toml) in
#   the form that captive tests measure it, that is with the added-mass Coriolis terms inside
#   (Yr - mx, Xvr + my). Prime system (½ρL²U², ½ρL³U²), instantaneous U, Xuu multiplies u'².
# [slopes] holds the relative change s from Fn_low to Fn_high:
#   value(Fn) = value(Fn_low) * (1 + s * (Fn² - Fn_low²) / (Fn_high² - Fn_low²)).
#   A derivative without a slope (the acceleration derivatives) does not change.
# [trend.*] is the change of the turning circle from Fn_low to Fn_high in parts of its value at
#   Fn_low: full scale, 3 degrees of freedom, 35° of rudder at 5°/s, propeller and rudder of
#   s175-3dof. "published" is what the slopes were sought for; steady_radius is half the diameter.
# [turn.*] are the metrics at the three approach speeds, lengths in ship lengths.
# The slopes are the smallest in the sense of least squares with none above 0.40. Many other
# dependences give the same circles; nothing here says that a real S175 has this one.
"""


def reference(ship: Model) -> tuple[dict[str, float], dict[str, float]]:
    """Hull derivatives as measured in captive tests, and acceleration derivatives."""
    hull = ship.values("hull_polynomial")
    mass = {name: x for name, x in ship.values("added_mass").items() if name != "lx"}
    hull["Yr"] = round(hull["Yr"] + mass["Xudot"], 12)
    hull["Xvr"] = round(hull["Xvr"] - mass["Yvdot"], 12)
    return hull, mass


def turn(truth: Truth, parts: Model, speed: float) -> dict[str, float]:
    """Metrics of the turn at a speed."""
    Fn = parts.ship.froude(speed, parts.water.g)
    model = to_model(truth.table([Fn]), parts)
    return dict(simulate(model, "turning", rudder_deg=35.0, speed=speed, rtol=1e-9).metrics)


def find(ship: Model) -> Truth:
    """The slopes, by Gauss-Newton steps of bounded least norm."""
    hull, mass = reference(ship)
    low, high = (ship.ship.froude(speed, ship.water.g) for speed in (SPEEDS[0], SPEEDS[-1]))
    names = list(hull)

    def truth(slopes: Array) -> Truth:
        given = dict(zip(names, slopes.tolist(), strict=True))
        return Truth(at_low=hull | mass, slopes=given, Fn_low=low, Fn_high=high)

    def trend(slopes: Array) -> Array:
        metrics = turn(truth(slopes), ship, SPEEDS[-1])
        return np.array([metrics[name] / start[name] - 1 for name in TARGET])

    start = turn(truth(np.zeros(len(names))), ship, SPEEDS[0])
    wanted = np.array(list(TARGET.values()))
    slopes = np.zeros(len(names))
    for _ in range(30):
        value = trend(slopes)
        slope = np.stack(
            [
                (trend(slopes + STEP * e) - trend(slopes - STEP * e)) / (2 * STEP)
                for e in np.eye(len(names))
            ],
            axis=1,
        )
        system = np.vstack([slope * WEIGHT, np.eye(len(names))])
        right = np.concatenate([WEIGHT * (wanted - value + slope @ slopes), np.zeros(len(names))])
        found = lsq_linear(system, right, bounds=(-LARGEST, LARGEST), method="bvls", tol=1e-14).x
        change = float(np.max(np.abs(found - slopes)))
        slopes = found
        if change < 1e-6:
            break
    return truth(np.round(slopes, 4))


def text(truth: Truth, ship: Model) -> str:
    """The file."""
    turns = {speed: turn(truth, ship, speed) for speed in SPEEDS}
    trends = {}
    for name, published in TARGET.items():
        achieved = turns[SPEEDS[-1]][name] / turns[SPEEDS[0]][name] - 1
        label = "steady_radius" if name == "steady_diameter" else name
        trends[label] = {
            "published": published,
            "achieved": round(achieved, 5),
            "residual": round(achieved - published, 5) + 0.0,
        }
    kept = (
        "advance_L", "transfer_L", "tactical_diameter_L", "steady_diameter_L",
        "steady_drift_deg", "speed_ratio",
    )
    data = {
        "schema": 1,
        "title": "Synthetic truth of the S175 programme",
        "synthetic": True,
        "system": "prime",
        "U": "instantaneous",
        "surge": "u",
        "coriolis": "in-derivatives",
        "L": 175.0,
        "g": 9.81,
        "speeds": list(SPEEDS),
        "Fn_low": truth.Fn_low,
        "Fn_high": truth.Fn_high,
        "derivatives": dict(truth.at_low),
        "slopes": dict(truth.slopes),
        "trend": trends,
        "turn": {
            f"{speed:g}_m_s": {name: round(metrics[name], 5) for name in kept}
            for speed, metrics in turns.items()
        },
    }
    return HEADER + toml_text(data)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=datasets_folder() / "s175" / "truth.toml")
    out = parser.parse_args().out
    ship = load_model("s175-3dof")
    truth = find(ship)
    write_text(out, text(truth, ship))
    print(f"{out}: largest slope {max(map(abs, truth.slopes.values())):.3f}")


if __name__ == "__main__":
    main()
