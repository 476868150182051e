"""Programmes that are made: what carriage and solvers get, and what comes back without an edit.

The laboratory of this module is its own: it reads the tables that were written in the format, axes
and units of the program they are for, differentiates the path, knows the forces of one ship, and
writes them as that program does.
"""

from __future__ import annotations

import csv
import re
import tomllib
from pathlib import Path
from types import SimpleNamespace
from typing import get_args

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from pmmkit.actions.jobs.plan import Maker
from pmmkit.campaigns import Settings, open_campaign
from pmmkit.cli import main
from pmmkit.diagnosis import Option, Programme
from pmmkit.exports import programme_files
from pmmkit.exports.programme.write import MAKERS
from pmmkit.files import write_results
from pmmkit.models import read_table

ROOT = Path(__file__).parents[2]
L, RHO = 7.0, 1000.0
SPEED = 1.2
TRUTH = {
    "Xuu": -0.0014,
    "Xvv": -0.0026,
    "Xrr": 0.0007,
    "Xvr": -0.0136,
    "Xudot": -0.0010,
    "Yv": -0.0207,
    "Yvvv": -0.105,
    "Yr": 0.0054,
    "Yrrr": 0.0005,
    "Yvvr": 0.025,
    "Yvrr": -0.026,
    "Yvdot": -0.0147,
    "Yrdot": -0.0004,
    "Nv": -0.0090,
    "Nvvv": -0.0020,
    "Nr": -0.0032,
    "Nrrr": -0.0009,
    "Nvvr": -0.0193,
    "Nvrr": 0.0036,
    "Nvdot": -0.0004,
    "Nrdot": -0.0007,
}
"""Of the size of a tanker's; forces over ½ρL²U², moments over ½ρL³U²."""
LIMITS = f"""
[limits]
speeds = [{SPEED}]
drift_deg = 12
frequencies = [2.0, 3.2]
tests = ["static_drift", "pure_sway", "pure_yaw", "yaw_drift"]
"""


def run(*words) -> int:
    return main([str(word) for word in words])


def planned(tmp_path: Path, to: str, runs: int = 14) -> Path:
    """The folder of a programme, as it is ordered in an empty one."""
    limits, folder = tmp_path / "limits.toml", tmp_path / "day"
    limits.write_text(LIMITS, encoding="utf-8")
    words = ("--limits", limits, "--runs", runs, "--to", to, "--out", folder)
    assert run("plan", "kvlcc2-l7", *words) == 0
    return folder


def sheet(folder: Path) -> list[dict[str, str]]:
    with (folder / "programme.csv").open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


# The ship of the laboratory.


def forces(u, v, r, udot, vdot, rdot) -> SimpleNamespace:
    """X, Y, N of the water on the hull: x forward, y to starboard, z down [N, N m]."""
    U = np.hypot(u, v)
    p = {"u": u / U, "v": v / U, "r": r * L / U}
    p |= {"udot": udot * L / U**2, "vdot": vdot * L / U**2, "rdot": rdot * L**2 / U**2}
    total = dict.fromkeys("XYN", 0.0)
    for name, value in TRUTH.items():
        factors = [name[1:]] if name[1:] in p else list(name[1:])
        total[name[0]] = total[name[0]] + value * np.prod([p[f] for f in factors], axis=0)
    scale = 0.5 * RHO * L**2 * U**2
    return SimpleNamespace(X=scale * total["X"], Y=scale * total["Y"], N=scale * L * total["N"])


def hull_forces(t, x, y, psi):
    """The same from a path over ground: x forward, y to starboard, heading to starboard."""
    paths = [CubicSpline(t, values) for values in (x, y, psi)]
    (vx, vy, r), (ax, ay, rdot) = (
        [path.derivative(order)(t) for path in paths] for order in (1, 2)
    )
    cos, sin = np.cos(psi), np.sin(psi)
    u, v = vx * cos + vy * sin, vy * cos - vx * sin
    udot = ax * cos + ay * sin + r * v
    vdot = ay * cos - ax * sin - r * u
    return forces(u, v, r, udot, vdot, rdot)


def of_mesh(t, x, y, psi):
    """Fx, Fy, Mz along axes that stay (x forward, y to port, z up) about where the mesh began."""
    felt = hull_forces(t, x, -y, -psi)
    cos, sin = np.cos(psi), np.sin(psi)
    ahead, port = felt.X, -felt.Y
    Fx, Fy = ahead * cos - port * sin, ahead * sin + port * cos
    return Fx, Fy, -felt.N + x * Fy - y * Fx


def resampled(table, end, step=0.05):
    """A table (t, …) at the time steps of a solver, which begins to move at the first."""
    t = step * np.arange(1, round(end / step) + 1)
    return t, [CubicSpline(table[0], column)(t) for column in table[1:]]


def started(t, values):
    """The first seconds of a computation ring, whatever the mesh does."""
    return values * (1 + 2.0 * np.exp(-t / 1.0) * np.cos(6 * t))


def check(folder: Path, capsys, names=tuple(TRUTH), share=0.005) -> None:
    """`pmmkit reduce` on the folder as it is gives the ship back, with its signs."""
    capsys.readouterr()
    assert run("check", folder) == 0, capsys.readouterr().out
    assert run("reduce", folder, "--out", folder / "reduced") == 0, capsys.readouterr().out
    found = read_table(folder / "reduced" / "derivatives.csv").at()
    for name in names:
        assert found[name] == pytest.approx(TRUTH[name], rel=share), name


# OpenFOAM


def six_degrees(file: Path) -> np.ndarray:
    """t, x, y, z [m] and rotations [deg] of a table: a count, then (t ((x y z) (rx ry rz)))."""
    text = re.sub(r"//.*", "", file.read_text(encoding="utf-8"))
    count, rows = re.fullmatch(r"\s*(\d+)\s*\((.*)\)\s*", text, re.DOTALL).groups()
    number = r"([-+.\deE]+)"
    triple = rf"\({number} {number} {number}\)"
    found = re.findall(rf"\({number} \({triple} {triple}\)\)", rows)
    assert len(found) == int(count) == len(rows.strip().splitlines())
    return np.array(found, float).T


def write_openfoam(case: Path, t, Fx, Fy, Mz) -> None:
    none = np.zeros_like(t)
    for kind, vector in (("force", (Fx, Fy, none)), ("moment", (none, none, Mz))):
        names = " ".join(f"total_{axis}" for axis in "xyz")
        head = f"# {kind.capitalize()}\n# CofR : (0 0 0)\n#\n# Time\t{names}\n"
        file = case / "postProcessing" / "forces" / "0" / f"{kind}.dat"
        file.parent.mkdir(parents=True, exist_ok=True)
        rows = "".join(
            f"{a:.6g}\t" + " ".join(f"{value:.10g}" for value in row) + "\n"
            for a, *row in zip(t, *vector, strict=True)
        )
        file.write_text(head + rows, encoding="utf-8")


@pytest.mark.slow
@pytest.mark.parametrize("to", ["openfoam", "starccm"])
def test_no_run_of_a_solver_is_made_again_as_a_reference(to, tmp_path, capsys):
    folder = planned(tmp_path, to)
    assert "No reference run: a solver gives the same" in capsys.readouterr().out
    assert "a solver gives the same" in (folder / "how_to.txt").read_text(encoding="utf-8")
    assert not any(row.get("repeat of") for row in sheet(folder))


def test_what_openfoam_computes_of_a_programme_is_reduced_without_an_edit(tmp_path, capsys):
    folder = planned(tmp_path, "openfoam")
    for row in sheet(folder):
        case = folder / "runs" / row["id"]
        t, x, y, z, *turned = six_degrees(case / "constant" / "6DoF.dat")
        end = float(row["end time [s]"])
        assert t[-1] > end
        assert not z.any()
        assert not turned[0].any()
        assert not turned[1].any()
        t, (x, y, psi) = resampled((t, x, y, np.radians(turned[2])), end)
        write_openfoam(case, t, *(started(t, part) for part in of_mesh(t, x, y, psi)))
    check(folder, capsys)


# STAR-CCM+


@pytest.mark.slow
def test_what_starccm_computes_of_a_programme_is_reduced_without_an_edit(tmp_path, capsys):
    folder = planned(tmp_path, "starccm")
    for row in sheet(folder):
        place = folder / "runs" / row["id"]
        with (place / "motion.csv").open(encoding="utf-8", newline="") as stream:
            heads, *rows = csv.reader(stream)
        column = dict(zip(heads, np.array(rows, float).T, strict=True))
        table = [column[name] for name in ("t (s)", "x (m)", "y (m)", "psi (rad)")]
        t, path = resampled(table, float(row["end time [s]"]))
        parts = [started(t, part) for part in of_mesh(t, *path)]
        head = '"Physical Time: Physical Time (s)"' + "".join(
            f',"{name} Monitor: {kind}"'
            for name, kind in (("Fx", "Force (N)"), ("Fy", "Force (N)"), ("Mz", "Moment (N-m)"))
        )
        lines = [",".join(f"{x:.10g}" for x in values) for values in zip(t, *parts, strict=True)]
        (place / "forces.csv").write_text("\n".join([head, *lines, ""]), encoding="utf-8")
    check(folder, capsys)


# Every kind of run that a mesh can make

KINDS = """
[[runs]]
test = "static_drift"
speed = 1.2
drift_deg = -11.5
[[runs]]
test = "circular_motion"
speed = 1.2
radius = 21.0
drift_deg = 4.0
[[runs]]
test = "circular_motion"
speed = 1.2
yaw_rate = -0.08
[[runs]]
test = "pure_surge"
speed = 1.2
period = 11.0
amplitude_m = 0.3
[[runs]]
test = "sway_yaw"
speed = 1.2
period = 14.0
amplitude_m = 0.4
yaw_amplitude_deg = 9.0
[[runs]]
test = "yaw_drift"
speed = 1.2
period = 14.0
yaw_amplitude_deg = 9.0
drift_deg = 6.0
"""


def computed(case: Path, end: float) -> tuple[SimpleNamespace, np.ndarray]:
    """What the hull felt on its way and her velocities, by the table, as OpenFOAM writes it."""
    t, x, y, _, *turned = six_degrees(case / "constant" / "6DoF.dat")
    t, (x, y, psi) = resampled((t, x, y, np.radians(turned[2])), end)
    write_openfoam(case, t, *of_mesh(t, x, y, psi))
    return hull_forces(t, x, -y, -psi), t


@pytest.mark.slow
@pytest.mark.parametrize("ahead", [0.0, -0.4])
def test_forces_of_every_kind_of_run_are_those_that_the_hull_felt(ahead, tmp_path):
    """About the point whose motion is meant, which is the origin of the mesh."""
    limits, folder = tmp_path / "limits.toml", tmp_path / "day"
    limits.write_text(KINDS, encoding="utf-8")
    (tmp_path / "campaign.toml").write_text(
        f"[campaign]\nmotion_reference_x = {ahead}\n"
        '[ship]\nname = "kvlcc2-l7"\n[water]\nrho = 1000.0\n'
    )
    words = ("--limits", limits, "--hours", 9, "--to", "openfoam", "--out", folder)
    assert run("plan", "kvlcc2-l7", tmp_path, *words) == 0
    assert ("0.4 m abaft midship" in (folder / "how_to.txt").read_text()) == (ahead < 0)
    rows = sheet(folder)
    assert {row["test"].replace(" ", "_") for row in rows} == set(re.findall('"(.*)"', KINDS))
    for row in rows:
        felt, t = computed(folder / "runs" / row["id"], float(row["end time [s]"]))
        made = open_campaign(folder)[row["id"]]
        kept = t >= t[0] + float(row["run-up [s]"])
        np.testing.assert_allclose(made.data["t"], t[kept], atol=1e-5)
        for name in "XYN":
            expected = getattr(felt, name)[kept]
            atol = 2e-4 * np.abs(expected).max() + 0.02
            np.testing.assert_allclose(made.data[name], expected, atol=atol)
        # The phase that is stated, and the velocities of the settings, are those of the path.
        nominal = made.nominal_motion(t[kept])
        measured = made.measured_motion(made.data, t[kept])
        for name in "uvr":
            np.testing.assert_allclose(
                getattr(measured, name), getattr(nominal, name), atol=2e-3, err_msg=row["id"]
            )


DRIFT = """[[runs]]
test = "yaw_drift"
speed = 1.2
period = 12.0
yaw_amplitude_deg = 8.0
drift_deg = 8.0
"""


def test_the_same_words_give_the_same_files(tmp_path):
    kept = []
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        folder = planned(tmp_path / name, "starccm", runs=3)
        files = [file for file in folder.rglob("*") if file.is_file()]
        kept.append({file.relative_to(folder): file.read_bytes() for file in files})
    assert kept[0] == kept[1]
    assert len(kept[0]) == 8


def test_a_rudder_that_swings_is_made_by_no_mesh(tmp_path, capsys):
    limits = tmp_path / "limits.toml"
    rudder = 'test = "harmonic_rudder"\nspeed = 1.2\nperiod = 9.0\nrudder_amplitude_deg = 15.0\n'
    limits.write_text(f"[[runs]]\n{rudder}{DRIFT}", encoding="utf-8")
    words = ("plan", "kvlcc2-l7", "--limits", limits, "--hours", 0.5, "--out")
    assert run(*words, tmp_path / "mesh", "--to", "openfoam") == 1
    assert "the rudder swings" in capsys.readouterr().err
    assert not (tmp_path / "mesh").exists()
    assert run(*words, tmp_path / "tank", "--to", "csv") == 0
    assert "15.0" in {row["rudder amplitude [deg]"] for row in sheet(tmp_path / "tank")}


def test_what_is_built_into_the_mesh_is_said(tmp_path):
    limits = tmp_path / "limits.toml"
    limits.write_text(f'[[runs]]\ntest = "static_rudder"\nspeed = 1.2\nrudder_deg = -20\n{DRIFT}')
    words = ("plan", "kvlcc2-l7", "--limits", limits, "--out", tmp_path / "a", "--to", "starccm")
    assert run(*words, "--hours", 1) == 0
    assert "rudder at -20 deg" in (tmp_path / "a" / "how_to.txt").read_text(encoding="utf-8")


def test_a_plan_without_a_run_is_not_written(tmp_path, capsys):
    limits = tmp_path / "limits.toml"
    limits.write_text(DRIFT)
    words = ("plan", "kvlcc2-l7", "--limits", limits, "--out", tmp_path / "a", "--to", "csv")
    assert run(*words, "--hours", 0.05) == 1
    assert "The plan has no run" in capsys.readouterr().err


def test_a_folder_with_a_campaign_is_not_written_over(tmp_path, capsys):
    folder = planned(tmp_path, "csv", runs=2)
    before = {file: file.read_bytes() for file in folder.iterdir() if file.is_file()}
    words = ("--limits", tmp_path / "limits.toml", "--runs", 3, "--to", "csv", "--out", folder)
    assert run("plan", "kvlcc2-l7", *words) == 1
    assert "holds campaign.toml already" in capsys.readouterr().err
    assert {file: file.read_bytes() for file in folder.iterdir() if file.is_file()} == before


def test_manoeuvres_are_no_programme_of_a_carriage(tmp_path, capsys):
    (tmp_path / "turn.csv").write_text("t,x,y,psi\n0,0,0,0\n1,1,0,0\n2,2,0,0\n")
    (tmp_path / "campaign.toml").write_text(
        '[campaign]\nkind = "free-running"\n[ship]\nname = "kvlcc2-l7"\n[[runs]]\nid = "T"\n'
        'test = "turning"\nfile = "turn.csv"\nspeed = 1.0\nrudder_deg = 35\n'
    )
    assert run("plan", "kvlcc2-l7", tmp_path, "--to", "csv", "--out", tmp_path / "a") == 1
    assert "--to: for captive tests" in capsys.readouterr().err


def test_a_mechanism_of_two_struts_is_told_how_to_set_them(tmp_path):
    """In pure yaw they lead by 2 atan(ωb/2U) (Gertler), and the hull goes where it points."""
    spacing, speed, tests = 1.8, 1.2, ("pure_sway", "pure_yaw", "yaw_drift", "sway_yaw")
    (tmp_path / "ps.csv").write_text("t [s],X [N],Y [N],N [N m]\n0,1,1,1\n1,1,1,1\n")
    (tmp_path / "campaign.toml").write_text(
        '[ship]\nname = "kvlcc2-l7"\n[water]\nrho = 1000.0\n[campaign]\n[struts]\n'
        f"spacing = {spacing}\ncentre_x = 0.1\n"
        '[[runs]]\nid = "PS"\ntest = "pure_sway"\nfile = "ps.csv"\nspeed = 1.2\n'
        "period = 9.0\nstrut_amplitude_m = 0.25\n"
    )
    known = open_campaign(tmp_path)
    settings = {
        "pure_sway": Settings(speed=speed, period=11.0, amplitude=0.3),
        "pure_yaw": Settings(speed=speed, period=11.0, yaw_amplitude=0.15),
        "yaw_drift": Settings(speed=speed, period=11.0, yaw_amplitude=0.15, drift=0.1),
        "sway_yaw": Settings(speed=speed, period=11.0, amplitude=0.3, yaw_amplitude=0.15),
    }
    options = [
        Option(test=test, settings=settings[test], cycles=4, record=44.0, hours=0.2)
        for test in tests
    ]
    write_results(tmp_path / "day", programme_files(Programme.of(options), known, "csv"))
    again = {run.test: run for run, _ in open_campaign(tmp_path / "day").excluded}
    t = np.linspace(0, 11, 200)
    for test, run_ in again.items():
        motion, psi0 = run_.nominal_motion(t), settings[test].yaw_amplitude or 0.0
        omega = 2 * np.pi / 11.0
        assert np.abs(motion.r).max() == pytest.approx(psi0 * omega, rel=0.03, abs=1e-6), test
    assert np.abs(again["pure_yaw"].nominal_motion(t).v).max() < 0.02 * speed
    np.testing.assert_allclose(
        again["pure_sway"].nominal_motion(t).v, 0.3 * omega * np.cos(omega * t), atol=1e-3
    )
    lead = np.degrees(2 * np.arctan(omega * spacing / (2 * speed)))
    rows = {row["test"]: row for row in sheet(tmp_path / "day")}
    told = {test: float(row["lead of the forward strut [deg]"]) for test, row in rows.items()}
    assert told["pure yaw"] == pytest.approx(lead, abs=1e-3)
    assert told["pure sway"] == 0.0
    assert float(rows["pure sway"]["strut amplitude [m]"]) == 0.3
    heads = (tmp_path / "day" / "columns.csv").read_text()
    assert "y_forward [m]" in heads
    assert "psi [deg]" not in heads


def test_those_who_make_runs_are_one_list():
    assert get_args(Maker) == MAKERS


@pytest.mark.slow
def test_the_next_run_of_a_campaign_is_written_with_what_is_known_of_it(tmp_path):
    words = ("--for", "memory,fault_pmm_amplitude", "--to", "openfoam", "--out", tmp_path / "next")
    assert run("plan", "cubic", ROOT / "datasets" / "s175", *words) == 0
    (row,) = sheet(tmp_path / "next")
    computed(tmp_path / "next" / "runs" / row["id"], float(row["end time [s]"]))
    known, made = open_campaign(ROOT / "datasets" / "s175"), open_campaign(tmp_path / "next")
    assert (made.ship, made.water) == (known.ship, known.water)
    assert made.forces == "hydrodynamic"
    assert made.title != known.title
    assert [item.id for item in made.runs] == [row["id"]]


# A carriage with its mechanism


def carriage_record(row, ship, rng, step=0.1):
    """Some seconds at rest, the carriage comes up to speed, then the run: what a logger has."""
    U, beta = float(row["speed [m/s]"]), np.radians(float(row["drift angle [deg]"]))
    omega = float(row["omega [rad/s]"] or 0.0)
    a, psi0 = float(row["amplitude [m]"] or 0.0), np.radians(float(row["yaw amplitude [deg]"] or 0))
    t = step * np.arange(round((20.0 + 1.05 * float(row["record [s]"])) / step))
    pace = U * np.clip((t - 5.0) / 4.0, 0.0, 1.0)
    theta = omega * t + rng.uniform(0, 2 * np.pi)  # the mechanism runs when the carriage starts
    psi, across = psi0 * np.sin(theta), pace * np.tan(psi0 * np.sin(theta))
    y = CubicSpline(t, across).antiderivative()(t)
    y = a * np.sin(theta) + y - y[t > 12.0].mean()
    x = CubicSpline(t, pace).antiderivative()(t)
    moving = t > 9.5
    felt = hull_forces(t[moving], x[moving], y[moving], (psi + beta)[moving])
    ax, ay, rdot = (CubicSpline(t, part).derivative(2)(t) for part in (x, y, psi + beta))
    r = CubicSpline(t, psi).derivative()(t)
    ahead = ax * np.cos(psi + beta) + ay * np.sin(psi + beta)
    aside = ay * np.cos(psi + beta) - ax * np.sin(psi + beta)
    m, xG, Izz = ship["mass"], ship["xG"], ship["Izz"]
    inertia = {"X": m * (ahead - xG * r**2), "Y": m * (aside + xG * rdot)}
    inertia["N"] = Izz * rdot + m * xG * aside
    read = {"t [s]": t}
    for name, unit in (("X", "N"), ("Y", "N"), ("N", "N m")):
        water = np.zeros_like(t)
        water[moving] = getattr(felt, name)
        noise = 0.002 * np.abs(water).max() * rng.normal(size=len(t))
        read[f"{name} [{unit}]"] = water - inertia[name] + noise
    return read | {"y [m]": y, "psi [deg]": np.degrees(psi + beta), "U_carriage [m/s]": pace}


def save(file: Path, columns) -> None:
    """As a logger in Hamburg does: semicolons and decimal commas."""
    rows = np.column_stack(list(columns.values()))
    lines = [";".join(columns)]
    lines += [";".join(f"{x:.7g}" for x in row).replace(".", ",") for row in rows]
    file.write_text("\r\n".join([*lines, ""]), encoding="utf-8", newline="")


@pytest.mark.slow
def test_what_a_carriage_records_of_a_programme_is_reduced_without_an_edit(tmp_path, capsys):
    folder = planned(tmp_path, "csv")
    assert "Reference run" in capsys.readouterr().out
    ship = tomllib.loads((folder / "campaign.toml").read_text(encoding="utf-8"))["ship"]
    rng = np.random.default_rng(3)
    made = sheet(folder)
    for row in made[:7]:
        save(folder / row["file"], carriage_record(row, ship, rng))
    capsys.readouterr()
    assert run("reduce", folder, "--out", tmp_path / "noon") in (0, 3)
    (told,) = [line for line in capsys.readouterr().out.splitlines() if "Not made yet" in line]
    assert all((row["id"] in told.split(": ")[1].split(", ")) == (row in made[7:]) for row in made)
    for row in made[7:]:
        save(folder / row["file"], carriage_record(row, ship, rng))
    names = ("Xuu", "Xvr", "Yv", "Yvvv", "Yr", "Yvdot", "Nv", "Nr", "Nvvr", "Nrdot")
    check(folder, capsys, names, share=0.04)
    how = (folder / "how_to.txt").read_text(encoding="utf-8")
    again = re.findall(r"Reference run (\S+) \(", how)
    for first in again:
        (block,) = {row["set-up"] for row in made if row["id"] == first}
        own = [row for row in made if row["set-up"] == block]
        there = [row["repeat of"] == first or row["id"] == first for row in own]
        assert (there[0], there[-1]) == (True, True)
        assert sum(there) == 3
    assert again, "a drift of the day shows in a run that is made again"
