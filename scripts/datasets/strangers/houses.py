"""Fourteen more laboratories, each with its own habits of files, names, units and axes.

All but the computation begin at rest, gather way, and weigh the model's inertia with the water's
force; the speed of the carriage is recorded.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from scripts.datasets.strangers.hulls import RHO, TANKER, Array, forces, inertia
from scripts.datasets.strangers.motions import Driven, drift, sway, yaw

SPEED = 1.2
"""Of all tests [m/s]."""
NOISE: Mapping[str, float] = {"X": 0.15, "Y": 0.4, "N": 0.5}
"""Of a sample [N, N m]."""
REST, RAMP = 3.0, 4.0
"""Seconds at rest, and of gathering way."""
FOOT, POUND = 0.3048, 4.4482216


@dataclass(frozen=True)
class Order:
    """A test: its kind, what it was set to (degrees, seconds, metres), what drives the hull."""

    kind: str
    set_to: Mapping[str, float]
    driven: Driven
    duration: float


@dataclass(frozen=True)
class Record:
    """What was recorded, SI, y to starboard: time, carriage, place across, heading, X, Y, N."""

    t: Array
    carriage: Array
    y: Array
    psi: Array
    forces: Mapping[str, Array]


def programme() -> Iterator[Order]:
    """Nine drift angles, three pure sway and three pure yaw tests."""
    for beta in (-8, -4, 0, 2, 4, 6, 8, 10, 12):
        yield Order("drift", {"beta": beta}, drift(SPEED, beta), 30.0)
    swings = ((9.0, 0.25), (9.0, 0.40), (13.0, 0.50))
    for T, a in swings:
        yield Order("sway", {"T": T, "a": a}, sway(SPEED, T, a), 5 * T)
    for T, a in swings:
        heading = float(np.degrees(np.arctan(2 * np.pi * a / T / SPEED)))
        yield Order("yaw", {"T": T, "psi": heading}, yaw(SPEED, T, heading), 5 * T)


def recorded(
    order: Order,
    rng: np.random.Generator,
    *,
    step: float = 0.05,
    run_out: float = 0.0,
    zeros: Mapping[str, float] | None = None,
) -> Record:
    """A record of a towed model: rest, ramp, test, and a ramp at the end of so many seconds."""
    end = REST + RAMP + order.duration + run_out
    t = np.arange(0.0, end, step)
    moved = order.driven(t - REST - RAMP)
    way = _smooth((t - REST) / RAMP)
    if run_out:
        way = way * _smooth((end - t) / run_out)
    water, pull = forces(TANKER, moved), inertia(TANKER, moved)
    read = {
        key: way**2 * (water[key] - pull[key])
        + (zeros or {}).get(key, 0.0)
        + std * rng.standard_normal(t.size)
        for key, std in NOISE.items()
    }
    return Record(t, SPEED * way, way * moved["y"], way * moved["psi"], read)


def _smooth(share: Array) -> Array:
    """From 0 to 1 without a kink."""
    part = np.clip(share, 0.0, 1.0)
    return part * part * (3.0 - 2.0 * part)


def _table(file: Path, columns: Mapping[str, Array], form: str = "%.5f") -> None:
    with file.open("w", newline="", encoding="utf-8") as stream:
        stream.write(",".join(columns) + "\n")
        np.savetxt(stream, np.column_stack(list(columns.values())), fmt=form, delimiter=",")


def _named(order: Order, **forms: str) -> str:
    """The name of a test's file by the form of its kind."""
    return forms[order.kind].format(U=SPEED, **order.set_to)


def pounds(folder: Path, *, seed: int = 11) -> None:
    """Pounds and feet, in names too; gauges with zeros; a ramp at either end; a list of ship."""
    folder.mkdir(parents=True)
    rng = np.random.default_rng(seed)
    zeros = {"X": 2.1, "Y": -3.3, "N": 1.2}
    for number, order in enumerate(programme(), start=201):
        read, feet = recorded(order, rng, step=0.02, run_out=4.0, zeros=zeros), order.set_to.get("a")
        told = _named(
            order,
            drift="SD_V3.94_B{beta:+03.0f}",
            sway=f"PS_V3.94_T{{T:.1f}}_A{(feet or 0.0) / FOOT:.3f}ft",
            yaw="PY_V3.94_T{T:.1f}_P{psi:.2f}deg",
        )
        columns = {
            "Time (s)": read.t,
            "Carriage Speed (ft/s)": read.carriage / FOOT,
            "Surge Force (lbf)": read.forces["X"] / POUND,
            "Sway Force (lbf)": read.forces["Y"] / POUND,
            "Yaw Moment (ft-lbf)": read.forces["N"] / POUND / FOOT,
            "Sway Pos (ft)": read.y / FOOT,
            "Yaw Angle (deg)": np.degrees(read.psi),
        }
        _table(folder / f"Run{number}_{told}.csv", columns)
    lines = ("Lpp  13.123 ft", "B  2.297 ft", "T  0.820 ft", "Displacement 992.1 lb", "LCG 0.197 ft")
    (folder / "particulars.txt").write_text("\n".join(("Model 5512", *lines, "")))


def listed_tdms(folder: Path, *, seed: int = 12) -> None:
    """LabVIEW files with numbers for names, a German list of the tests beside; y to port, z up."""
    from nptdms import ChannelObject, TdmsWriter

    folder.mkdir(parents=True)
    rng = np.random.default_rng(seed)
    words = {"drift": "Schräg", "sway": "Querschwingen", "yaw": "Gieren"}
    head = ("Versuch", "Art", "v [m/s]", "Driftwinkel [°]", "Periode [s]", "Amplitude [m]")
    with (folder / "Versuchsplan.csv").open("w", newline="", encoding="utf-8") as stream:
        plan = csv.writer(stream, delimiter=";")
        plan.writerow((*head, "Kurswinkel [°]"))
        for number, order in enumerate(programme(), start=1):
            numbers = (SPEED, *(order.set_to.get(key) for key in ("beta", "T", "a", "psi")))
            cells = ["" if x is None else f"{x:.6g}".replace(".", ",") for x in numbers]
            plan.writerow([f"V{number:03d}", words[order.kind], *cells])
            read = recorded(order, rng, step=0.01)
            clock = {"wf_increment": 0.01, "wf_start_offset": 0.0}
            channels = [
                ChannelObject("Messung", name, values, {**clock, "unit_string": unit})
                for name, values, unit in (
                    ("Wagengeschwindigkeit", read.carriage, "m/s"),
                    ("Fx", read.forces["X"], "N"),
                    ("Fy", -read.forces["Y"], "N"),
                    ("Mz", -read.forces["N"], "Nm"),
                    ("Querweg", -1000 * read.y, "mm"),
                    ("Gierwinkel", -np.degrees(read.psi), "°"),
                )
            ]
            with TdmsWriter(folder / f"V{number:03d}.tdms") as file:
                file.write_segment(channels)


def monitors(folder: Path, *, seed: int = 13) -> None:
    """Monitors of STAR-CCM+, a file a computation; y to port, z up; steady ones converge."""
    folder.mkdir(parents=True)
    rng = np.random.default_rng(seed)
    for order in programme():
        t = np.arange(0.02, order.duration, 0.02)
        felt = forces(TANKER, order.driven(t))
        start = 1 + 0.5 * np.exp(-t / 1.2) * np.cos(5 * t)
        told = _named(order, drift="drift_{beta:g}deg_V1p2", sway="pure_sway_T{T:g}s_A{a:g}m_V1p2", yaw="pure_yaw_T{T:g}s_psi{psi:.3f}deg_V1p2")
        columns = {
            '"Physical Time: Physical Time (s)"': t,
            '"Force X Monitor: Force (N)"': start * felt["X"],
            '"Force Y Monitor: Force (N)"': _restless(-start * felt["Y"], rng),
            '"Moment Z Monitor: Moment (N-m)"': _restless(-start * felt["N"], rng),
        }
        _table(folder / f"{told}.csv", columns, "%.8e")


def _restless(values: Array, rng: np.random.Generator) -> Array:
    return values + 0.02 * rng.standard_normal(values.size)


def one_hdf5(folder: Path, *, seed: int = 14) -> None:
    """One HDF5 file with a group a run, whose attributes say what it was set to."""
    import h5py

    folder.mkdir(parents=True)
    rng = np.random.default_rng(seed)
    words = {"drift": "static_drift", "sway": "pure_sway", "yaw": "pure_yaw"}
    keys = {"beta": "beta_deg", "T": "period_s", "a": "amplitude_m", "psi": "psi_deg"}
    with h5py.File(folder / "campaign.h5", "w") as file:
        for number, order in enumerate(programme(), start=1):
            read = recorded(order, rng)
            run = file.create_group(f"run_{number:02d}_{words[order.kind]}")
            run.attrs["speed"] = SPEED
            run.attrs.update({keys[key]: value for key, value in order.set_to.items()})
            for name, values, unit in _channels(read):
                run.create_dataset(name, data=values).attrs["unit"] = unit


def _channels(read: Record) -> Sequence[tuple[str, Array, str]]:
    """Channels in SI with degrees of heading."""
    return (
        ("time", read.t, "s"),
        ("carriage_speed", read.carriage, "m/s"),
        ("Fx", read.forces["X"], "N"),
        ("Fy", read.forces["Y"], "N"),
        ("Mz", read.forces["N"], "Nm"),
        ("sway", read.y, "m"),
        ("yaw", np.degrees(read.psi), "deg"),
    )


def structs(folder: Path, *, seed: int = 15) -> None:
    """One MATLAB file with a struct a run; no units, angles in degrees, settings as scalars."""
    from scipy.io import savemat

    folder.mkdir(parents=True)
    rng = np.random.default_rng(seed)
    runs: dict[str, dict[str, Any]] = {}
    for number, order in enumerate(programme(), start=1):
        read = recorded(order, rng)
        columns = {name: values for name, values, _ in _channels(read)}
        runs[f"run{number:02d}_{order.kind}"] = {**columns, **order.set_to, "U": SPEED}
    savemat(folder / "tests.mat", runs)


def one_text(folder: Path, *, seed: int = 16) -> None:
    """All runs below each other in one text, told by a column; a list of the tests beside."""
    folder.mkdir(parents=True)
    rng = np.random.default_rng(seed)
    words = {"drift": "static drift", "sway": "pure sway", "yaw": "pure yaw"}
    with (
        (folder / "timeseries.csv").open("w", newline="", encoding="utf-8") as series,
        (folder / "tests.csv").open("w", newline="", encoding="utf-8") as listed,
    ):
        rows, tests = csv.writer(series), csv.writer(listed)
        tests.writerow(["run", "test type", "beta [deg]", "T [s]", "y0 [m]", "psi0 [deg]"])
        for number, order in enumerate(programme(), start=1):
            read, own = recorded(order, rng), order.set_to
            cells = [own.get(key, "") for key in ("beta", "T", "a", "psi")]
            tests.writerow([number, words[order.kind], *cells])
            channels = _channels(read)
            if number == 1:
                rows.writerow(["run", *(f"{name} [{unit}]" for name, _, unit in channels)])
            table = np.column_stack([values for _, values, _ in channels])
            rows.writerows([number, *(f"{x:.5f}" for x in row)] for row in table)


def _zone(stream: TextIO, read: Record, title: str) -> None:
    """A record as a zone of Tecplot, by points."""
    table = np.column_stack([values for _, values, _ in _channels(read)])
    kinds = " ".join("SINGLE" for _ in table[0])
    stream.write(f'ZONE T="{title}"\n I={len(table)}, J=1, K=1, F=POINT\n DT=({kinds} )\n')
    np.savetxt(stream, table, fmt="%15.6E")


def _variables(read: Record) -> str:
    names = "\n".join(f'"{name} ({unit})"' for name, _, unit in _channels(read))
    return f"VARIABLES = {names}\n"


def _told(order: Order) -> str:
    """What a test was set to, in its title."""
    return _named(
        order,
        drift="static drift beta={beta:g} deg",
        sway="pure sway T={T:g} s ymax={a:g} m",
        yaw="pure yaw T={T:g} s psi0={psi:.4g} deg",
    )


def tecplot(folder: Path, *, seed: int = 17) -> None:
    """Tecplot's text, a file a run with a number for a name: the title says what it was set to."""
    folder.mkdir(parents=True)
    rng = np.random.default_rng(seed)
    for number, order in enumerate(programme(), start=1):
        read = recorded(order, rng)
        with (folder / f"run{number:02d}.dat").open("w", encoding="utf-8") as stream:
            stream.write(f'TITLE = "{_told(order)}, U={SPEED} m/s"\n{_variables(read)}')
            _zone(stream, read, f"run {number}")


def zones(folder: Path, *, seed: int = 18) -> None:
    """One file of Tecplot with a zone for each run."""
    folder.mkdir(parents=True)
    rng = np.random.default_rng(seed)
    with (folder / "tests.plt").open("w", encoding="utf-8") as stream:
        for number, order in enumerate(programme(), start=1):
            read = recorded(order, rng)
            if number == 1:
                stream.write(f'TITLE = "PMM tests of a coaster"\n{_variables(read)}')
            _zone(stream, read, _told(order))


_HARMONICS = range(1, 7)


def phase_averaged(folder: Path, *, seed: int = 19) -> None:
    """Forces over ½ρU² and powers of the length; of swings the mean cycle, over t/T."""
    folder.mkdir(parents=True)
    rng = np.random.default_rng(seed)
    half = 0.5 * RHO * SPEED**2 * TANKER.L**2
    units = {"X'": ("X", half), "Y'": ("Y", half), "N'": ("N", half * TANKER.L)}

    def cosines(share: Array) -> Array:
        angle = 2 * np.pi * np.outer(share, _HARMONICS)
        return np.column_stack([np.ones(len(share)), np.cos(angle), np.sin(angle)])

    cycle = np.linspace(0.0, 1.0, 65)
    for order in programme():
        read, own = recorded(order, rng), order.set_to
        begun = read.t - REST - RAMP
        told = _named(order, drift="SD_U{U:.1f}_beta{beta:+g}", sway="PS_U{U:.1f}_T{T:g}s_a{a:g}m", yaw="PY_U{U:.1f}_T{T:g}s_psi{psi:.2f}deg")
        forces = {name: read.forces[key] / unit for name, (key, unit) in units.items()}
        if order.kind == "drift":
            steady = begun > 1.0
            columns = {"t [s]": read.t[steady] - read.t[steady][0]}
            columns |= {f"{name} [-]": values[steady] for name, values in forces.items()}
        else:
            share = begun / own["T"]
            whole = (share >= 1.0) & (share < 4.0)
            seen = {"y [m]": read.y, "psi [deg]": np.degrees(read.psi)}
            seen |= {f"{name} [-]": values for name, values in forces.items()}
            mean = np.linalg.lstsq(
                cosines(share[whole]), np.column_stack([x[whole] for x in seen.values()]), rcond=None
            )[0]
            columns = {"t/T [-]": cycle}
            columns |= dict(zip(seen, (cosines(cycle) @ mean).T, strict=True))
        _table(folder / f"{told}.csv", columns, "%.7f")


GAUGES = (0.55, -0.65)
"""Places of two gauges, forward of midship [m]."""


def two_gauges(folder: Path, *, seed: int = 20) -> None:
    """Side forces of a forward and an aft gauge, and no yaw moment."""
    folder.mkdir(parents=True)
    rng = np.random.default_rng(seed)
    fore, aft = GAUGES
    for order in programme():
        read = recorded(order, rng)
        told = _named(order, drift="SD_V{U:.2f}_b{beta:+g}", sway="PureSway_V{U:.2f}_T{T:g}_A{a:g}m", yaw="PureYaw_V{U:.2f}_T{T:g}_psi{psi:.2f}")
        Y, N = read.forces["Y"], read.forces["N"]
        columns = {
            "Time [s]": read.t,
            "Fx [N]": read.forces["X"],
            "Fy_fwd [N]": (N - aft * Y) / (fore - aft),
            "Fy_aft [N]": (fore * Y - N) / (fore - aft),
            "y [m]": read.y,
            "psi [deg]": np.degrees(read.psi),
        }
        _table(folder / f"{told}.csv", columns)


def without_headers(folder: Path, *, seed: int = 21) -> None:
    """Numbers alone; a text beside them says what the columns are, and gives the particulars."""
    folder.mkdir(parents=True)
    rng = np.random.default_rng(seed)
    (folder / "readme.txt").write_text(
        "Captive tests of a coaster\n"
        "Columns: 1 time [s], 2 carriage speed [m/s], 3 longitudinal force [N], 4 transverse force "
        "[N], 5 yaw moment [Nm], 6 sway [m], 7 yaw [deg]\n"
        "Model: Lpp 4.0 m, B 0.7 m, T 0.25 m, displacement 450 kg, LCG 0.06 m\n"
    )
    for order in programme():
        read = recorded(order, rng)
        told = _named(order, drift="drift_{beta:+03.0f}", sway="sway_T{T:g}_A{a:g}m", yaw="yaw_T{T:g}_A{psi:.2f}deg")
        forces = (read.forces[name] for name in "XYN")
        columns = (read.t, read.carriage, *forces, read.y, np.degrees(read.psi))
        np.savetxt(folder / f"{told}.txt", np.column_stack(columns), "%12.5f")


def two_recorders(folder: Path, *, seed: int = 22) -> None:
    """Forces in one folder and the motion in another, at other rates; one clock for both."""
    (folder / "forces").mkdir(parents=True)
    (folder / "motion").mkdir()
    rng = np.random.default_rng(seed)
    for order in programme():
        own = order.set_to
        told = _named(order, drift="SD_U{U:.1f}_b{beta:+g}", sway="PS_U{U:.1f}_T{T:g}_a{a:g}m", yaw="PY_U{U:.1f}_T{T:g}_psi{psi:.2f}deg")
        read, seen = recorded(order, rng), recorded(order, rng, step=0.02)
        forces = {"Fx [N]": "X", "Fy [N]": "Y", "Mz [Nm]": "N"}
        columns = {"t [s]": read.t} | {name: read.forces[key] for name, key in forces.items()}
        _table(folder / "forces" / f"{told}.csv", columns)
        moved = {"Sway Pos (mm)": 1e3 * seen.y, "Yaw Angle (deg)": np.degrees(seen.psi)}
        _table(folder / "motion" / f"{told}.csv", {"t [s]": seen.t, **moved})


def headed_sheets(folder: Path, *, seed: int = 23) -> None:
    """A German workbook: a sheet for each test, whose head says what it was set to, decimal commas
    as texts, and a sheet of the ship."""
    from openpyxl import Workbook

    folder.mkdir(parents=True)
    rng, book = np.random.default_rng(seed), Workbook()
    ship = book.active
    ship.title = "Schiff"
    for row in (
        ("Länge zwischen den Loten", "4,0", "m"),
        ("Breite", "0,7", "m"),
        ("Tiefgang", "0,25", "m"),
        ("Masse", "450", "kg"),
        ("Trägheitsmoment um z", "451,6", "kg m²"),
        ("Schwerpunkt vor Mitte", "0,06", "m"),
    ):
        ship.append(row)
    kinds = {"drift": "Schräglauf", "sway": "Reines Querschwingen", "yaw": "Reines Gieren"}
    keys = {"beta": "Driftwinkel [°]", "T": "Periode [s]", "a": "Amplitude [m]"}
    keys["psi"] = "Gieramplitude [°]"
    for number, order in enumerate(programme(), start=1):
        read, sheet = recorded(order, rng, step=0.1), book.create_sheet(f"V{number:03d}")
        sheet.append(["Versuch", kinds[order.kind]])
        sheet.append(["Geschwindigkeit [m/s]", "1,2"])
        for key, value in order.set_to.items():
            sheet.append([keys[key], f"{value:.4g}".replace(".", ",")])
        sheet.append([])
        sheet.append(["Zeit", "Schleppgeschw.", "Querweg", "Kurswinkel", "FX", "FY", "MZ"])
        sheet.append(["s", "m/s", "mm", "°", "N", "N", "Nm"])
        columns = [read.t, read.carriage, 1e3 * read.y, np.degrees(read.psi)]
        for row in np.column_stack([*columns, *read.forces.values()]):
            sheet.append([float(f"{value:.6g}") for value in row])
    book.save(folder / "Versuche.xlsx")


def listings(folder: Path, *, seed: int = 24) -> None:
    """Listings of Fortran: capitals, D before the power of ten, names behind the C of a comment."""
    folder.mkdir(parents=True)
    rng = np.random.default_rng(seed)
    names = ("TIME[S]", "VC[M/S]", "YPOS[M]", "PSI[DEG]", "FX[N]", "FY[N]", "MZ[NM]")
    for number, order in enumerate(programme(), start=1):
        read = recorded(order, rng)
        told = _named(
            order,
            drift="DRIFT BETA={beta:.1f} DEG",
            sway="PURE SWAY T={T:.1f} S A={a:.3f} M",
            yaw="PURE YAW T={T:.1f} S PSI0={psi:.2f} DEG",
        )
        columns = [read.t, read.carriage, read.y, np.degrees(read.psi), *read.forces.values()]
        head = [f"C  RUN {number:03d}", f"C  {told}", "C" + "".join(f"{x:>15}" for x in names)]
        rows = [
            " " + "".join(f"{value:15.6E}" for value in row).replace("E", "D")
            for row in np.column_stack(columns)
        ]
        text = "\n".join([*head, *rows, ""])
        (folder / f"RUN{number:03d}.OUT").write_text(text, encoding="ascii")
    ship = ("LPP = 4.000 M", "BREADTH = 0.700 M", "DRAFT = 0.250 M", "MASS = 450.0 KG")
    more = ("IZZ = 451.6 KGM2", "XG = 0.060 M", "WATER DENSITY = 999.1 KG/M3")
    (folder / "SHIP.TXT").write_text("\n".join([*ship, *more, ""]), encoding="ascii")


HOUSES = {
    "pounds": pounds,
    "listed_tdms": listed_tdms,
    "monitors": monitors,
    "one_hdf5": one_hdf5,
    "structs": structs,
    "one_text": one_text,
    "tecplot": tecplot,
    "zones": zones,
    "phase_averaged": phase_averaged,
    "two_gauges": two_gauges,
    "without_headers": without_headers,
    "two_recorders": two_recorders,
    "headed_sheets": headed_sheets,
    "listings": listings,
}
"""Folders of the coaster's tests, each by its writer."""
