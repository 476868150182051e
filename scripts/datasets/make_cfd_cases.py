"""What two solvers would have written: OpenFOAM cases and STAR-CCM+ exports of one programme.

    python -m scripts.datasets.make_cfd_cases FOLDER

Static drift, pure sway, pure yaw and yaw with drift of the S175 model at 1.5 m/s. The forces follow
from the true derivatives of ``datasets/s175`` through the plain formulas of ``virtual_tank.py``;
the files hold them as solvers do:

``FOLDER/openfoam``
    A case a run. x forward and z up, forces and moments in earth axes about a CofR that stays where
    the hull was at rest, the motion in ``sixDoFRigidBodyState``. The start from rest rings for some
    seconds, and the computation was killed in the middle of a row and begun again from an earlier
    time.
``FOLDER/star``
    A plot export a run: x aft and z up (so that the yaw motion, positive about z, begins to port),
    forces along axes of the hull, inner iterations printed, the same start, and the part after the
    restart in a second file.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scripts.datasets.s175_programme import Plan, oscillation
from scripts.datasets.s175_truth import load_truth
from scripts.datasets.virtual_tank import SHIP, WATER, motion, water_forces

Array = NDArray[np.float64]
SPEED, STEP, CYCLES, STATIC_S = 1.5, 0.05, 4, 40.0
KILLED, AGAIN = 0.62, 0.55
"""Shares of a run at which it was killed, and from which it was begun again."""
RINGING_S = 2.0
INNER = 4


def programme() -> Iterator[Plan]:
    """Eleven runs at one speed."""
    tag = f"U{SPEED:.1f}"
    for drift in (-8.0, -4.0, 0.0, 4.0, 8.0, 12.0):
        yield Plan(f"static_drift_{tag}_b{drift:+03.0f}", "static_drift", SPEED, drift_deg=drift)
    yield Plan(f"pure_sway_{tag}_v0.16", "pure_sway", SPEED, v=0.16)
    for r in (0.3, 0.6):
        yield Plan(f"pure_yaw_{tag}_r{r:.1f}", "pure_yaw", SPEED, r=r)
    for drift in (-8.0, 8.0):
        yield Plan(f"yaw_drift_{tag}_b{drift:+03.0f}_r0.4", "yaw_drift", SPEED, drift, r=0.4)


@dataclass(frozen=True, kw_only=True)
class History:
    """One run: body forces in our axes, and the hull beside the carriage."""

    t: Array
    force: Mapping[str, Array]
    y: Array
    psi: Array


def history(plan: Plan, *, phase: float = 0.0) -> History:
    """Forces with the ringing of a start from rest, and where the hull is."""
    duration = CYCLES * plan.period if plan.period else STATIC_S
    t = STEP * np.arange(1, round(duration / STEP) + 1)
    drift = math.radians(plan.drift_deg)
    y, psi = 0.0 * t, drift + 0.0 * t
    if plan.period is None:
        state = motion("static_drift", plan.speed, t, 1.0, drift=drift)
    else:
        theta = plan.frequency * t + phase
        state = oscillation(plan, plan.speed, theta, plan.frequency, drift)
        if plan.amplitude_m:
            y = plan.amplitude_m * np.sin(theta)
        if plan.yaw_amplitude:
            heading = plan.yaw_amplitude * np.sin(theta)
            slope = plan.speed * np.tan(heading)
            y = np.concatenate([[0.0], np.cumsum(0.5 * STEP * (slope[1:] + slope[:-1]))])
            psi = drift + heading
    forces = water_forces(load_truth().at(SHIP.froude(plan.speed, WATER.g)), *state)
    ringing = 1 + 3.0 * np.exp(-t / RINGING_S) * np.cos(2 * math.pi * t / RINGING_S)
    return History(t=t, force={k: x * ringing for k, x in forces.items()}, y=y, psi=psi)


def parts_of(t: Array) -> tuple[tuple[float, slice], tuple[float, slice]]:
    """Start time and rows of the computation that was killed, and of the one that followed."""
    killed, again = (round(share * len(t)) for share in (KILLED, AGAIN))
    return (0.0, slice(0, killed)), (float(t[again - 1]), slice(again, len(t)))


def write_openfoam(folder: Path, plan: Plan, run: History) -> None:
    """``postProcessing`` of a case as ESI's v2212 and later write it, two starts."""
    cos, sin = np.cos(run.psi), np.sin(run.psi)
    X, Y, N = (run.force[name] for name in "XYN")
    north, east = X * cos - Y * sin, X * sin + Y * cos
    moment = N - run.y * north
    none = 0.0 * run.t
    total = {
        "force": np.stack([north, -east, none], axis=1),
        "moment": np.stack([none, none, -moment], axis=1),
    }
    names = "\t".join(" ".join(f"{p}_{a}" for a in "xyz") for p in ("total", "pressure", "viscous"))
    results = folder / plan.id / "postProcessing"
    for number, (start, rows) in enumerate(parts_of(run.t)):
        for kind, vectors in total.items():
            head = (
                f"# {kind.capitalize():<12}\n"
                f"# {'CofR':<12}: (0.000000e+00 0.000000e+00 0.000000e+00)\n"
                f"#\n# {'Time':<12}\t{names}\n"
            )
            parts = np.concatenate([vectors, 0.9 * vectors, 0.1 * vectors], axis=1)[rows]
            lines = [
                f"{t:<14.8g} " + " ".join(f"{value:.6e}" for value in row)
                for t, row in zip(run.t[rows], parts, strict=True)
            ]
            text = head + "\n".join(lines) + "\n"
            _write(results / "forces" / f"{start:g}" / f"{kind}.dat", text[:-31] if not number
                   else text)
        head = (
            "# Motion State\n# Angle Units : degrees\n"
            "# Time\tcentreOfRotation\tcentreOfMass\trotation\tvelocity\tomega\n"
        )
        where = np.stack([none, -run.y, none], axis=1)[rows]
        angle = np.degrees(-run.psi[rows])
        lines = [
            f"{t:.8g}\t{_vector(place)}\t{_vector(place)}\t(0 0 {turn:.9g})\t(0 0 0)\t(0 0 0)"
            for t, place, turn in zip(run.t[rows], where, angle, strict=True)
        ]
        _write(results / "sixDoFRigidBodyState" / f"{start:g}" / "sixDoFRigidBodyState.dat",
               head + "\n".join(lines) + "\n")


def write_star(folder: Path, plan: Plan, run: History) -> None:
    """Two exports of a plot of three reports: before and after the restart."""
    head = ('"Physical Time: Physical Time (s)","Fx Monitor: Force (N)","Fy Monitor: Force (N)",'
            '"Mz Monitor: Moment (N-m)"\n')
    X, Y, N = (run.force[name] for name in "XYN")
    table = np.stack([-X, Y, -N], axis=1)
    for number, (_, rows) in enumerate(parts_of(run.t)):
        lines = []
        for t, settled in zip(run.t[rows], table[rows], strict=True):
            for inner in range(INNER - 1, -1, -1):
                numbers = settled * (1 + 0.05 * inner)
                lines.append(",".join(f"{value:.9g}" for value in (t, *numbers)))
        text = head + "\n".join(lines) + "\n"
        _write(folder / plan.id / f"forces_{number + 1}.csv", text)


def _vector(values: Array) -> str:
    return "(" + " ".join(f"{value:.9g}" for value in values) + ")"


def _write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8", newline="")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    folder = parser.parse_args().folder
    for plan in programme():
        write_openfoam(folder / "openfoam", plan, history(plan))
        to_port = math.pi if plan.yaw_amplitude else 0.0
        write_star(folder / "star", plan, history(plan, phase=to_port))
    print(f"{len(list(programme()))} runs: {folder / 'openfoam'} and {folder / 'star'}")


if __name__ == "__main__":
    main()
