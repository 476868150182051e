"""Folders of laboratory text: names that carry the values, rest, ramps, run-out, gauge zeros.

The hull is that of `own_tank`. A record begins at rest, the carriage gathers way, the oscillator
comes up, everything runs steadily, and then all of it backwards. Nothing but names of files,
headers and columns says what was done.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from own_tank import IZZ, MASS, NOISE, TRUTH, XG, L, forces

G = 9.81
ZEROS = {"X": 1.7, "Y": -2.3, "N": 0.9}
"""What the gauges show at rest [N, N m]."""


@dataclass(frozen=True, kw_only=True)
class Test:
    """What is set: drift angle [deg], sway amplitude [m], heading amplitude [deg], period [s]."""

    __test__ = False

    kind: str
    speed: float
    drift: float = 0.0
    sway: float = 0.0
    heading: float = 0.0
    period: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Course:
    """How a run goes in time [s].

    `rest, ramp, stop, after`: of the carriage. `late`: from the carriage at its speed to the start
    of the oscillator; negative where it starts before. `rise`: in which the swing comes up and
    goes down. `steady`: of a drift test at speed; `cycles`: of a swing at its full size.
    """

    rest: float = 4.0
    ramp: float = 6.0
    stop: float = 5.0
    after: float = 3.0
    late: float = 0.0
    rise: float = 5.0
    steady: float = 25.0
    cycles: float = 3.0
    rate: float = 20.0


def _soft(x: np.ndarray) -> np.ndarray:
    return 0.5 - 0.5 * np.cos(np.pi * np.clip(x, 0.0, 1.0))


def record(test: Test, course: Course, finer: int = 8) -> dict[str, np.ndarray]:
    """Time from 0, what the balance shows, and where the hull and the carriage are."""
    c = course
    begun = c.rest + c.ramp + c.late
    swing = test.period * c.cycles
    full = (begun + c.rise, begun + c.rise + swing) if swing else (0.0, c.rest + c.ramp + c.steady)
    ahead = max(full[1] + (c.rise + c.late if swing else 0.0), c.rest + c.ramp)
    end = ahead + c.stop + c.after
    t = np.arange(round(end * c.rate * finer)) / (c.rate * finer)
    carriage = test.speed * np.minimum(
        _soft((t - c.rest) / c.ramp), _soft((ahead + c.stop - t) / c.stop)
    )
    x = np.concatenate([[0.0], np.cumsum(0.5 * (carriage[1:] + carriage[:-1]) * np.diff(t))])
    y, psi = np.zeros_like(t), np.full_like(t, math.radians(test.drift))
    if swing:
        w = 2.0 * math.pi / test.period
        size = np.minimum(_soft((t - begun) / c.rise), _soft((full[1] + c.rise - t) / c.rise))
        angle = w * (t - full[0])
        largest = math.radians(test.heading)
        if test.heading:
            grid = np.linspace(0.0, 2.0 * math.pi, 2001)
            slope = test.speed / w * np.tan(largest * np.sin(grid))
            path = np.concatenate(
                [[0.0], np.cumsum(0.5 * (slope[1:] + slope[:-1]) * np.diff(grid))]
            )
            y = size * np.interp(np.mod(angle, 2.0 * math.pi), grid, path - path.mean())
            psi = psi + size * largest * np.sin(angle)
        else:
            y = size * test.sway * np.sin(angle)
    columns = {"t": t, **forces(t, x, y, psi), "carriage": carriage, "y": y, "psi": psi}
    return {name: values[::finer] for name, values in columns.items()}


def programme(speed: float) -> tuple[Test, ...]:
    """Drift, sway and yaw at one speed."""
    return (
        *(Test(kind="drift", speed=speed, drift=b) for b in (-8, -4, 0, 2, 4, 6, 8, 10, 12)),
        *(
            Test(kind="sway", speed=speed, sway=a, period=T)
            for T, a in ((9.0, 0.25), (9.0, 0.4), (13.0, 0.5))
        ),
        *(
            Test(kind="yaw", speed=speed, heading=h, period=T)
            for T, h in ((9.0, 8.0), (9.0, 15.0), (13.0, 12.0))
        ),
    )


Header = Callable[[Test], Sequence[str]]


@dataclass(frozen=True, kw_only=True)
class Laboratory:
    """How a laboratory writes: names of files, lines above, columns with their factors."""

    name: Callable[[int, Test], str]
    head: Header
    columns: Mapping[str, tuple[str, float]]
    course: Course
    speed: float = 1.2
    separator: str = "\t"
    zeros: Mapping[str, float]


def _numbered(number: int, test: Test) -> str:
    if test.kind == "drift":
        return f"V{400 + number}_drift_{test.drift:g}deg_U{test.speed}.txt"
    size = f"A{test.sway:.2f}" if test.kind == "sway" else f"psi{test.heading:.0f}deg"
    return f"V{400 + number}_{test.kind}_{size}_T{test.period:.1f}_U{test.speed}.txt"


def _froude(number: int, test: Test) -> str:
    Fn = test.speed / math.sqrt(G * L)
    if test.kind == "drift":
        return f"drift_{test.drift:g}deg_Fn{Fn:.2f}.dat"
    size = f"a{test.sway:.2f}m" if test.kind == "sway" else f"psi{test.heading:.0f}deg"
    return f"pure_{test.kind}_{size}_T{test.period:.0f}s_Fn{Fn:.2f}.dat"


def _plain(number: int, test: Test) -> str:
    return f"run{number:03d}.csv"


def _spoken(test: Test) -> list[str]:
    """What a record of the third laboratory says above its columns."""
    what = {"drift": "Static drift", "sway": "Pure sway", "yaw": "Pure yaw"}[test.kind]
    lines = [f"# Test: {what}", f"# Carriage speed: {test.speed} m/s"]
    if test.kind == "drift":
        lines.append(f"# Drift angle: {test.drift:g} deg")
    else:
        lines.append(f"# Period: {test.period} s")
        lines.append(
            f"# Sway amplitude: {test.sway} m"
            if test.kind == "sway"
            else f"# Yaw amplitude: {test.heading:g} deg"
        )
    return lines


LABORATORIES = {
    "numbered": Laboratory(
        name=_numbered,
        head=lambda test: ["Model 4711, captive tests"],
        columns={
            "t": ("Time [s]", 1.0), "carriage": ("Carriage speed [m/s]", 1.0), "X": ("FX [N]", 1.0),
            "Y": ("FY [N]", 1.0), "N": ("MZ [Nm]", 1.0), "y": ("y [m]", 1.0),
            "psi": ("psi [deg]", 180.0 / math.pi),
        },
        course=Course(late=-6.0, rise=6.0, cycles=2.6),
        zeros=ZEROS,
    ),
    "froude": Laboratory(
        name=_froude,
        head=lambda test: [],
        columns={
            "t": ("t [s]", 1.0), "X": ("X [N]", 1.0), "Y": ("Y [N]", 1.0), "N": ("N [Nm]", 1.0),
            "carriage": ("V_carriage [m/s]", 1.0), "y": ("sway [mm]", 1000.0),
            "psi": ("heading [deg]", 180.0 / math.pi),
        },
        course=Course(rest=2.0, ramp=4.0, stop=4.0, after=2.0, late=2.0, rise=9.0, cycles=2.0),
        speed=round(0.2 * math.sqrt(G * L), 3),
        separator=" ",
        zeros={"X": -0.8, "Y": 3.1, "N": -1.6},
    ),
    "headed": Laboratory(
        name=_plain,
        head=_spoken,
        columns={
            "t": ("time [s]", 1.0), "X": ("Fx [N]", 1.0), "Y": ("Fy [N]", 1.0),
            "N": ("Mz [Nm]", 1.0), "y": ("y [m]", 1.0), "psi": ("psi [deg]", 180.0 / math.pi),
            "carriage": ("carriage [m/s]", 1.0),
        },
        course=Course(rest=6.0, ramp=5.0, stop=5.0, after=8.0, late=-9.0, rise=4.0, cycles=4.0),
        separator=",",
        zeros=ZEROS,
    ),
}  # fmt: skip
"""Swing comes up with the carriage; a cycle later; before the carriage, whose files are headed."""


def write(
    folder: Path, laboratory: Laboratory, *, without: Sequence[str] = (), seed: int = 5
) -> dict[str, Test]:
    """The folder, without some columns, and its tests by file."""
    folder.mkdir(parents=True)
    dice = np.random.default_rng(seed)
    tests = {}
    for number, test in enumerate(programme(laboratory.speed), start=11):
        found = record(test, laboratory.course)
        for name, zero in laboratory.zeros.items():
            noise = NOISE[name] * dice.standard_normal(found["t"].size)
            found[name] = found[name] + zero + noise
        found["carriage"] = found["carriage"] + 0.002 * dice.standard_normal(found["t"].size)
        join = laboratory.separator.join
        columns = {x: item for x, item in laboratory.columns.items() if x not in without}
        rows = np.column_stack([factor * found[key] for key, (_, factor) in columns.items()])
        head = [*laboratory.head(test), join(title for title, _ in columns.values())]
        lines = [*head, *(join(f"{x:.4f}" for x in row) for row in rows)]
        file = folder / laboratory.name(number, test)
        file.write_text("\n".join(lines) + "\n", encoding="utf-8")
        tests[file.name] = test
    return tests


PARTICULARS = {"L": L, "B": 0.7, "d": 0.25, "mass": MASS, "Izz": IZZ, "xG": XG}
"""What a person knows of the hull; the water is fresh."""
__all__ = [
    "LABORATORIES",
    "PARTICULARS",
    "TRUTH",
    "Course",
    "Laboratory",
    "Test",
    "record",
    "write",
]
