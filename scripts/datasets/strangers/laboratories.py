"""The files of five laboratories and of a sea trial, each in its own layout.

Each writer makes one folder and returns nothing: what a stranger knows of the tests is in names of
files and headers, and in `known`.
"""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from scripts.datasets.strangers.houses import HOUSES
from scripts.datasets.strangers.hulls import (
    CONTAINER,
    RHO,
    TANKER,
    Array,
    Hull,
    Motion,
    forces,
    inertia,
    turn,
)
from scripts.datasets.strangers.motions import Driven, circle, drift, sway, yaw

GAUGES: Mapping[str, float] = {"X": 0.15, "Y": 0.4, "N": 0.5, "K": 0.05}
"""Noise of a sample [N, N m]."""
SLOW, FAST = 1.2, 1.4
"""Speeds of the coaster and of the feeder [m/s]."""
STEADY = 40.0
"""How long a record of a steady test is [s]."""


@dataclass(frozen=True)
class Test:
    """One test: the name of its file, what drives the hull, how long [s]."""

    name: str
    driven: Driven
    duration: float
    kind: str = ""
    settings: Mapping[str, float] | None = None


def _noisy(found: Mapping[str, Array], rng: np.random.Generator) -> dict[str, Array]:
    return {key: x + GAUGES[key] * rng.standard_normal(x.size) for key, x in found.items()}


def _heading_of_path(speed: float, period: float, amplitude: float) -> float:
    """Amplitude of the heading [deg] of a pure yaw whose path swings by `amplitude` [m]."""
    return float(np.degrees(np.arctan(2 * np.pi * amplitude / period / speed)))


def workbook(folder: Path, *, seed: int = 1) -> None:
    """A workbook with a matrix of the tests and a sheet a run; the inertia is taken off."""
    import openpyxl

    rng = np.random.default_rng(seed)
    tests = [
        *(("Static drift", b, None, None, None) for b in (-8, -4, 0, 2, 4, 6, 8, 10, 12)),
        *(
            ("Pure sway", None, T, a, None)
            for T, a in ((8, 0.15), (8, 0.25), (8, 0.35), (12, 0.3), (12, 0.45))
        ),
        *(
            ("Pure yaw", None, T, None, h)
            for T, h in ((8, 6), (8, 10), (8, 14), (12, 10), (12, 16))
        ),
    ]
    book = openpyxl.Workbook()
    matrix = book.worksheets[0]
    matrix.title = "Matrix"
    matrix.append(["Test programme hull 4711"])
    matrix.append([])
    matrix.append(
        ["Run", "Type", "Speed [m/s]", "Drift [deg]", "Period [s]", "Sway amplitude [m]",
         "Yaw amplitude [deg]"]
    )  # fmt: skip
    for number, (kind, beta, period, amplitude, heading) in enumerate(tests, start=101):
        matrix.append([number, kind, SLOW, beta, period, amplitude, heading])
        if beta is not None:
            driven, duration = drift(SLOW, beta), STEADY
        elif amplitude is not None:
            driven, duration = sway(SLOW, period, amplitude), 5.0 * period
        else:
            driven, duration = yaw(SLOW, period, heading), 5.0 * period
        t = np.arange(0, duration, 0.05)
        felt = _noisy(forces(TANKER, driven(t)), rng)
        sheet = book.create_sheet(f"Run {number}")
        sheet.append(["Time [s]", "Fx [N]", "Fy [N]", "Mz [Nm]"])
        for row in zip(t, felt["X"], felt["Y"], felt["N"], strict=True):
            sheet.append([round(float(x), 5) for x in row])
    folder.mkdir(parents=True)
    book.save(folder / "tests.xlsx")


REST, START = 3.0, 3.0
"""The carriage stands, then gathers way [s]."""
ZEROS: Mapping[str, float] = {"X": 1.7, "Y": -2.3, "N": 0.9}
"""What the gauges of `text` show at rest [N, N m]."""


def text(folder: Path, *, seed: int = 2) -> None:
    """German text and one Japanese: decimal commas, rest and ramp first, inertia inside."""
    rng = np.random.default_rng(seed)
    folder.mkdir(parents=True)
    oblique = [
        Test(f"Schraeg_beta{b:+03d}", drift(SLOW, b), STEADY) for b in (-8, -4, 0, 2, 4, 6, 8, 10)
    ]
    swings = [
        Test(name, driven, 5 * T)
        for T, a in ((9.0, 0.25), (9.0, 0.4), (13.0, 0.5))
        for name, driven in (
            (f"Querschwingen_T{T:.1f}s_a{a:.2f}m", sway(SLOW, T, a)),
            (f"Gieren_T{T:.1f}s_a{a:.2f}m", yaw(SLOW, T, _heading_of_path(SLOW, T, a))),
        )
    ]
    german = [
        "Messdatei Schleppkanal; Modell 4711; Öltemperatur 20 °C",
        "Zeit [s];Längskraft [N];Querkraft [N];Giermoment [Nm];Querweg [mm];Gierwinkel [°]",
    ]
    for test in (*oblique, *swings):
        _balance_record(folder / f"{test.name}.txt", test, german, "cp1252", ",", rng)
    japanese = [
        "曳航試験 模型船4711",
        "時間 [s];前後力 [N];横力 [N];回頭モーメント [N・m];横変位 [mm];回頭角 [°]",
    ]
    last = Test("斜航_beta+12", drift(SLOW, 12), STEADY)
    _balance_record(folder / f"{last.name}.txt", last, japanese, "cp932", ".", rng)


def _balance_record(
    file: Path, test: Test, head: list[str], encoding: str, point: str, rng: np.random.Generator
) -> None:
    """A record that begins at rest; the gauges have zeros and the inertia is inside."""
    t = np.arange(0, REST + START + test.duration, 0.05)
    moved = test.driven(t - REST - START)
    way = np.clip((t - REST) / START, 0, 1) ** 2
    water, pull = forces(TANKER, moved), inertia(TANKER, moved)
    read = {key: way * (water[key] - pull[key]) + zero for key, zero in ZEROS.items()}
    noisy = _noisy(read, rng)
    place = [1000 * way * moved["y"], np.degrees(way * moved["psi"])]
    rows = [
        ";".join(f"{x:.4f}" for x in row).replace(".", point)
        for row in zip(t, noisy["X"], noisy["Y"], noisy["N"], *place, strict=True)
    ]
    file.write_bytes(("\r\n".join([*head, *rows]) + "\r\n").encode(encoding))


CONTROL = """\
FoamFile { version 2.0; format ascii; class dictionary; object controlDict; }
application interFoam;
endTime 65;
functions
{
    forces
    {
        type forces;
        libs (forces);
        patches (hull);
        rho rhoInf;
        rhoInf 998.8;   // kg/m3
        CofR (0 0 0);
    }
}
"""
COMPUTED_RHO = 998.8
RINGING = 8.0
"""After which the start from rest has died out [s]."""


def openfoam(folder: Path, *, version: str = "v2306", seed: int = 3) -> None:
    """Cases of OpenFOAM, x forward, y to port, z up.

    Drift by inflow that is turned in a mesh that stays; sway and yaw by a mesh that moves, with
    forces along the tank and moments about the point where midship was; the mesh goes to port
    first, as its axes say. `version` v2306 writes force.dat and moment.dat, v10 forces.dat.
    """
    rng = np.random.default_rng(seed)
    still = [
        Test(f"drift_U1.2_b{b:+03d}", drift(SLOW, b), 30.0) for b in (0, 2, 4, 6, 8, 10, 12, -6)
    ]
    moving = []
    for T, a in ((9.0, 0.25), (9.0, 0.4), (13.0, 0.5)):
        h = _heading_of_path(SLOW, T, a)
        name = f"yaw_U1.2_T{T:.1f}s_psi{h:.3f}deg"
        moving += [
            Test(f"sway_U1.2_T{T:.1f}s_a{a:.2f}m", sway(SLOW, T, -a), 5 * T),
            Test(name, yaw(SLOW, T, -h), 5 * T),
        ]
    for test in (*still, *moving):
        _case(folder / test.name, test, moves=test in moving, version=version, rng=rng)


def _case(case: Path, test: Test, *, moves: bool, version: str, rng: np.random.Generator) -> None:
    t = np.round(np.arange(0.05, test.duration, 0.05), 6)
    moved = test.driven(t)
    ship = forces(TANKER, moved)
    start = 1 + 0.6 * np.exp(-t / 1.0) * np.cos(4 * t)
    felt = {
        key: start * ship[key] * COMPUTED_RHO / RHO + std * rng.standard_normal(t.size)
        for key, std in (("X", 0.01), ("Y", 0.03), ("N", 0.03))
    }
    x, y, n = felt["X"], -felt["Y"], -felt["N"]
    if moves:
        angle, aside = -moved["psi"], -moved["y"]
        x, y = x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle)
        n = n - aside * x
    (case / "system").mkdir(parents=True)
    (case / "system" / "controlDict").write_text(CONTROL, encoding="ascii")
    again = int(0.6 * t.size)
    for begin, rows in (("0", slice(0, again + 20)), (f"{t[again]:g}", slice(again, None))):
        place = case / "postProcessing" / "forces" / begin
        place.mkdir(parents=True)
        write = _forces_of_v10 if version == "v10" else _forces_of_v2306
        write(place, t[rows], x[rows], y[rows], n[rows])


def _forces_of_v2306(place: Path, t: Array, x: Array, y: Array, n: Array) -> None:
    zero = np.zeros_like(t)
    for name, title, vector in (
        ("force", "Force", (x, y, zero)),
        ("moment", "Moment", (zero, zero, n)),
    ):
        head = [f"# {title}", "# CofR      : (0 0 0)", "#"]
        parts = [f"{part}_{axis}" for part in ("total", "pressure", "viscous") for axis in "xyz"]
        head.append("# Time\t" + "\t".join(parts))
        columns = [share * item for share in (1.0, 0.8, 0.2) for item in vector]
        rows = [
            f"{row[0]:g}\t" + "\t".join(f"{value:.8e}" for value in row[1:])
            for row in zip(t, *columns, strict=True)
        ]
        (place / f"{name}.dat").write_text("\n".join([*head, *rows]) + "\n", encoding="ascii")


def _forces_of_v10(place: Path, t: Array, x: Array, y: Array, n: Array) -> None:
    head = [
        "# Forces",
        "# CofR                : (0 0 0)",
        "# Time                forces(pressure viscous) moment(pressure viscous)",
    ]

    def pair(a: float, b: float, c: float) -> str:
        return " ".join(f"({s * a:.8e} {s * b:.8e} {s * c:.8e})" for s in (0.8, 0.2))

    rows = [
        f"{now:g}\t({pair(a, b, 0.0)}) ({pair(0.0, 0.0, c)})"
        for now, a, b, c in zip(t, x, y, n, strict=True)
    ]
    (place / "forces.dat").write_text("\n".join([*head, *rows]) + "\n", encoding="ascii")


def heeled(folder: Path, *, seed: int = 4) -> None:
    """Drift, sway, yaw and heel of the feeder, K measured; the zeros are those at each heel."""
    rng = np.random.default_rng(seed)
    tests = [
        *(Test(f"drift_b{b:+03d}", drift(FAST, b), STEADY) for b in (-8, -4, 0, 4, 8, 12)),
        *(
            Test(f"heel_phi{p:+03d}_b{b:+03d}", drift(FAST, b, p), STEADY)
            for p in (-10, -5, 5, 10)
            for b in (0, 6, 12)
        ),
        *(
            Test(f"sway_T{T:.1f}s_a{a:.2f}m", sway(FAST, T, a), 5 * T)
            for T, a in ((9.0, 0.25), (9.0, 0.4), (13.0, 0.6))
        ),
        *(
            Test(f"yaw_T{T:.1f}s_psi{h:.1f}deg", yaw(FAST, T, h), 5 * T)
            for T, h in ((9.0, 8.0), (9.0, 14.0), (13.0, 18.0))
        ),
        *(
            Test(f"yaw_drift_T{T:.1f}s_psi{h:.1f}deg_b{b:+03d}", yaw(FAST, T, h, b), 5 * T)
            for T, h in ((9.0, 14.0), (13.0, 18.0))
            for b in (5, 10)
        ),
        *(
            Test(f"yaw_T{T:.1f}s_psi{h:.1f}deg_phi{p:+03d}", yaw(FAST, T, h, heel=p), 5 * T)
            for T, h in ((9.0, 14.0), (13.0, 18.0))
            for p in (-10, 10)
        ),
    ]
    folder.mkdir(parents=True)
    for test in tests:
        t = np.arange(0, test.duration, 0.05)
        felt = _noisy(forces(CONTAINER, test.driven(t)), rng)
        columns = {"Time [s]": t, "Fx [N]": felt["X"], "Fy [N]": felt["Y"], "Mz [Nm]": felt["N"]}
        _write_csv(folder / f"{test.name}.csv", {**columns, "Mx [Nm]": felt["K"]})


def rotating_arm(folder: Path, *, seed: int = 5) -> None:
    """Oblique towing and a rotating arm: forces along and across the arm's way, inertia inside."""
    rng = np.random.default_rng(seed)
    tests = [
        *(Test(f"oblique_b{b:+03d}", drift(SLOW, b), STEADY) for b in (-8, -4, 0, 4, 8, 12)),
        *(
            Test(f"rotating_arm_R{R:+.1f}m_b{b:+03d}", circle(SLOW, R, b), STEADY)
            for R in (24.0, 16.0, 12.0, 9.0)
            for b in (-4, 0, 4, 8, 12)
        ),
        Test("rotating_arm_R-12.0m_b-04", circle(SLOW, -12.0, -4), STEADY),
    ]
    folder.mkdir(parents=True)
    for test in tests:
        t = np.arange(0, test.duration, 0.05)
        moved = test.driven(t)
        water, pull = forces(TANKER, moved), inertia(TANKER, moved)
        felt = {key: water[key] - pull[key] for key in ("X", "Y", "N")}
        along, across = _turned(felt["X"], felt["Y"], moved["psi"])
        read = _noisy({"X": along, "Y": across, "N": felt["N"]}, rng)
        columns = {"Time [s]": t, "Fx [N]": read["X"], "Fy [N]": read["Y"], "Mz [Nm]": read["N"]}
        _write_csv(folder / f"{test.name}.csv", columns)


def _turned(x: Array, y: Array, angle: Array) -> tuple[Array, Array]:
    """Components along axes from which the ship is turned by an angle to starboard."""
    return x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle)


def sea_trial(folder: Path, *, seed: int = 6) -> None:
    """Turning circles and a zigzag of the coaster, recorded aboard."""
    rng = np.random.default_rng(seed)
    folder.mkdir(parents=True)
    for order in (35.0, -35.0, 20.0):
        sailed = turn(TANKER, SLOW, np.radians(order))
        kept = slice(0, None, 4)
        t = sailed.t[kept]
        columns = {
            "Time [s]": t,
            "x [m]": sailed.x[kept] + 0.02 * rng.standard_normal(t.size),
            "y [m]": sailed.y[kept] + 0.02 * rng.standard_normal(t.size),
            "Heading [deg]": np.degrees(sailed.psi[kept]) + 0.1 * rng.standard_normal(t.size),
            "Rudder [deg]": np.degrees(sailed.delta[kept]),
            "Revolutions [rpm]": np.full(t.size, 60 * sailed.n),
        }
        _write_csv(folder / f"turning_U{SLOW}_rudder{order:+.0f}.csv", columns)


def _write_csv(file: Path, columns: Mapping[str, Array]) -> None:
    with file.open("w", newline="", encoding="utf-8") as stream:
        table = csv.writer(stream)
        table.writerow(columns)
        table.writerows([f"{x:.5f}" for x in row] for row in zip(*columns.values(), strict=True))


FOLDERS: Mapping[str, Callable[[Path], None]] = {
    "workbook": workbook,
    "text": text,
    "openfoam": openfoam,
    "openfoam_v10": lambda folder: openfoam(folder, version="v10"),
    "heeled": heeled,
    "rotating_arm": rotating_arm,
    **HOUSES,
}
"""The captive campaigns, each by its writer."""
HULLS: Mapping[str, Hull] = {name: CONTAINER if name == "heeled" else TANKER for name in FOLDERS}
SPEEDS: Mapping[str, float] = {name: FAST if name == "heeled" else SLOW for name in FOLDERS}
"""Of the approach in the turn, and of the tests [m/s]."""
