"""A workbook of a laboratory: runs, cycles, statistics and another table below one header."""

from __future__ import annotations

import json
import math
import sys
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import openpyxl
import pytest

from pmmkit import open_campaign
from pmmkit.campaigns import Run
from pmmkit.cli import main
from pmmkit.intake import look
from pmmkit.intake.blocks import statistic_in

DEG = math.pi / 180
GROUPS = [None, None, "POSITION", None, "VELOCITY", None, None, "ACCELERATION", None, None]
GROUPS += ["DOF 1", "DOF 2", "DOF 3", "PROPELLER", None]
GROUPS += ["RUDDER (force measurements not useful)", None, None, None, None]
NAMES = ["Test ()", "TYPE ()", "y (m)", "psi (°)", "u (m/s)", "v (m/s)", "r (°/s)"]
NAMES += ["u' (m/s²)", "v' (m/s²)", "r' (°/s²)", "X (N)", "Y (N)", "N (Nm)"]
NAMES += [
    "given (rpm)",
    "measured (rpm)",
    "given (°)",
    "measured (°)",
    "X (N)",
    "Y (N)",
    "Drift (°)",
]
MERGED = ("C1:D1", "E1:G1", "H1:J1", "N1:O1", "P1:S1")
U, PERIOD, COUNT = 0.6, 40.0, 24
MASS, IZZ = 300.0, 300.0
Row = list[Any]


def forces(v: float, r: float, vdot: float, rdot: float, delta: float) -> tuple[float, ...]:
    """What a balance reads of a hull that is linear, with its mass inside [N, N m]."""
    y = -80.0 * v + 30.0 * r - (280.0 + MASS) * vdot - MASS * U * r + 5.0 * delta
    n = -110.0 * v - 60.0 * r - (200.0 + IZZ) * rdot - 10.0 * delta
    return -2.0 - 3.0 * delta**2 + MASS * v * r, y, n


def row(name: str, word: str, *, y=0.0, psi=0.0, v=0.0, r=0.0, vdot=0.0, rdot=0.0, delta=0.0,
        seen: float | None = None, drift=0.0, noise=0.0) -> Row:  # fmt: skip
    u = math.sqrt(U**2 - v**2)
    x, side, turn = (value + noise for value in forces(v, r, vdot, rdot, delta))
    motion = [y, psi / DEG, u, v, r / DEG, 0.0, vdot, rdot / DEG]
    turns = [300.0, 300.5, delta / DEG, (delta if seen is None else seen) / DEG]
    return [name, word, *motion, x, side, turn, *turns, 0.1, 0.2, drift / DEG]


def steady(name: str, beta: float, delta: float, noise: float = 0.0) -> Row:
    angle = beta * DEG
    return row(
        name, "STAT", psi=angle, v=-U * math.sin(angle), delta=delta * DEG, drift=angle, noise=noise
    )


def cycle(name: str, word: str, motion: str, *, beta: float = 0.0, delta: float = 0.0) -> list[Row]:
    """24 rows of one cycle, the first of them anywhere."""
    omega = 2 * math.pi / PERIOD
    rows = []
    for theta in 2 * math.pi * (np.arange(COUNT) + 0.5) / COUNT:
        sine, cosine = math.sin(theta), math.cos(theta)
        moved: dict[str, float] = {"drift": beta * DEG, "delta": delta * DEG}
        if motion == "sway":
            moved |= {"y": 0.2 * sine, "v": 0.2 * omega * cosine, "vdot": -0.2 * omega**2 * sine}
        elif motion == "yaw":
            size = 12 * DEG
            moved |= {"psi": size * sine + beta * DEG, "r": size * omega * cosine}
            moved |= {"rdot": -size * omega**2 * sine, "v": -U * math.sin(beta * DEG)}
        else:
            moved |= {"delta": 35 * DEG * sine, "seen": 35 * DEG * math.sin(theta - 0.03)}
            moved |= {"psi": beta * DEG, "v": -U * math.sin(beta * DEG)}
        rows.append(row(name, word, **moved))
    return rows


def statistics(of: str) -> list[Row]:
    words = ("AVERAGE", "STAND. DEV.", "RELATIVE", "DELTA")
    return [[of, word, None, *[0.25] * (len(NAMES) - 3)] for word in words]


def turning(rows: int) -> list[Row]:
    """A test on a turntable, with columns of its own."""
    texts = ["time", "y", "psi", "Xf", "Yf", "Xa", "Ya", "measured", "T", "Q"]
    table = [["ROTATION", None, *texts], [None, None, "(s)", "(m)", "(°)", *["(N)"] * 4], []]
    return table + [["J0", None, *np.linspace(0, 1, 10) * place] for place in range(rows)]


def sheet(prefix: str) -> list[Row]:
    found: list[Row] = [GROUPS, NAMES]
    found += [
        steady(f"{prefix}_C{place:02d}", beta, delta)
        for place, (beta, delta) in enumerate(
            (beta, delta) for beta in (-12, -8, -4, 0, 4, 8, 12) for delta in (-20, 0, 20)
        )
    ]
    found += [[], *(steady(f"{prefix}_R{n}", 4, 10, noise=0.05 * n) for n in range(5)), []]
    found += [*statistics(f"{prefix}_Rx"), []]
    found += cycle(f"{prefix}_F0", "PMMY", "sway") + cycle(f"{prefix}_F1", "PMMY", "sway")
    found += [[], *cycle(f"{prefix}_G0", "PMMPSI", "yaw"), *cycle(f"{prefix}_G1", "PMMPSI", "yaw")]
    found += cycle(f"{prefix}_G2", "PMMPSI", "yaw", beta=8.0)
    found += cycle(f"{prefix}_G3", "PMMPSI", "yaw", delta=20.0)
    found += [[], *cycle(f"{prefix}_M0", "MULTI", "rudder"), []]
    return [*found, *turning(60)]


ENVIRONMENT: list[Row] = [
    ["Name", "ship", "h/T", "hmodel (m)"],
    ["A01", "C1", 2.0, 0.41],
    ["A02", "C1", 1.2, 0.246],
    [],
    ["SC", 50.0, "Scale"],
    ["LPP", 200.0, "m"],
    ["B", 30.0, "m"],
    ["TM", 10.0, "m", "as measured"],
    ["VOL", 37500.0, "m³"],
    ["XG", -2.5, "m"],
    ["IZ", 300.0, "kgm²", "as measured"],
    ["PROPELLER"],
    ["Dp", 6.0, "m", "diameter"],
    ["P/Dp", 0.8, "-"],
    ["RUDDER"],
    ["AR", 40.0, "m²"],
]


def saved(path: Path, sheets: Mapping[str, list[Row]]) -> None:
    book = openpyxl.Workbook()
    book.remove(book.active)
    for title, rows in sheets.items():
        page = book.create_sheet(title)
        for line in rows:
            page.append(line)
        if title != "Environment":
            for cells in MERGED:
                page.merge_cells(cells)
    book.save(path)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    pages = {"Environment": ENVIRONMENT, "A01": sheet("A01"), "A02": sheet("a02")}
    saved(tmp_path / "results.xlsx", pages)
    return tmp_path


@pytest.mark.parametrize(
    ("cell", "kind"),
    [
        ("AVERAGE", "mean"),
        ("STAND. DEV.", "std"),
        ("Average SD", "std"),
        ("MAX DELTA", "range"),
        ("Mittelwert", "mean"),
        ("gemiddelde", "mean"),
        ("標準偏差", "std"),
        ("Mean drift 4", ""),
        ("STATX0", ""),
        ("", ""),
        (3.5, ""),
    ],
)
def test_words_of_statistics(cell: str | float, kind: str) -> None:
    assert statistic_in(cell) == kind


def test_inspect_tells_what_the_rows_are(folder: Path) -> None:
    lines = [line.strip() for line in look(folder).lines()]
    own = [line for line in lines if line.startswith("A01: ")]
    words = [line.partition(": ")[2].partition(": ")[2] for line in own]
    assert words == [
        "26 steady tests (STAT).",
        "statistics of repeats, no runs: mean, std, relative, range "
        "(AVERAGE, STAND. DEV., RELATIVE, DELTA).",
        "2 tests of one cycle, 24 rows each: pure_sway (PMMY).",
        "2 tests of one cycle, 24 rows each: pure_yaw (PMMPSI).",
        "1 test of one cycle, 24 rows each: yaw_drift (PMMPSI).",
        "1 test of one cycle, 24 rows each: yaw_rudder (PMMPSI).",
        "1 sweep of the rudder, 24 rows each: every row as a steady test (MULTI).",
        "another table, with names of its own: ROTATION, time, y, psi, Xf, Yf, Xa, Ya, measured, "
        "T, Q; not read.",
    ]


def test_statistics_and_other_tables_are_not_counted_among_the_numbers(folder: Path) -> None:
    """The turntable reaches 59 in every column, the runs hold ±35°."""
    (first,) = [group.first for group in look(folder).groups if group.first.kind == "table"]
    assert first.rows == 26 + 7 * 24
    assert first.known["rudder_deg"].high == pytest.approx(34.7, abs=0.1)
    assert not first.problems


def test_what_a_header_doubts_is_left_out_and_the_rest_of_its_group_is_not(folder: Path) -> None:
    (first,) = [group.first for group in look(folder).groups if group.first.kind == "table"]
    rudder = [column for column in first.columns if column.title.startswith("RUDDER")]
    assert [column.suggestion and column.suggestion.name for column in rudder] == [
        "rudder_deg",
        "delta",
        None,
        None,
    ]
    assert "'force measurements not useful'" in rudder[2].remark
    assert first.known["X"].title == "X (N)"
    assert {"u", "v", "r", "udot", "vdot", "rdot", "propeller_rps", "n"} <= set(first.known)


def drafted(capsys, folder: Path, *arguments: str) -> tuple[dict[str, Any], Path]:
    target = folder / "a.toml"
    status = main(["new-campaign", str(folder), "-o", str(target), *arguments, "--json"])
    assert status == 0
    return json.loads(capsys.readouterr().out), target


def test_a_sheet_with_other_names_has_columns_of_its_own(folder: Path, capsys) -> None:
    """What a sweep takes instead of them (the rudder as measured) stands among these."""
    book = openpyxl.load_workbook(folder / "results.xlsx")
    book["A02"]["A2"] = "proef"
    book["A02"]["T2"] = "Drift angle (°)"
    book.save(folder / "results.xlsx")
    _, target = drafted(capsys, folder)
    text = target.read_text(encoding="utf-8")
    raw = tomllib.loads(text)
    sweeps = [item for item in raw["tables"] if item["where"] == {"TYPE ()": "MULTI"}]
    assert [item["columns"]["delta"] for item in sweeps] == [False, False]
    for item in raw["tables"]:
        theirs = "Drift angle (°)" if item["source"]["sheet"] == "A02" else "Drift (°)"
        assert {**raw.get("columns", {}), **item.get("columns", {})}["drift_deg"] == theirs
    target.write_text(text.replace("rho = 999.1", "rho = 1000.0"), encoding="utf-8")
    by_sheet = {"A0": 0, "a0": 0}
    for run in open_campaign(target):
        by_sheet[run.id[:2]] += 1
    assert by_sheet["A0"] == by_sheet["a0"] == 26 + 24 + 6


def test_no_edited_line_leads_to_a_campaign(folder: Path, capsys) -> None:
    """All stands in the workbook, or the forces tell it; water is fresh unless it is said."""
    content, target = drafted(capsys, folder, "--sheet", "A02")
    assert len(content["tables"]) == 6
    text = target.read_text(encoding="utf-8")
    raw = tomllib.loads(text)
    assert raw["ship"] == {"L": 4.0, "B": 0.6, "d": 0.2, "volume": 0.3, "Izz": 300.0, "xG": -0.05}
    assert raw["water"] == {"rho": 999.1, "depth": 0.246}
    assert (raw["propeller"], raw["rudder"]) == ({"D": 0.12}, {"area": 0.016})
    assert raw["campaign"]["forces"] == "balance"
    assert raw["campaign"]["rudder_positive"] == "port"
    campaign = open_campaign(target)
    counted = {test: sum(run.test == test for run in campaign) for test in
               ("drift_rudder", "pure_sway", "pure_yaw", "yaw_drift", "yaw_rudder")}  # fmt: skip
    assert counted == {
        "drift_rudder": 26 + 24,
        "pure_sway": 2,
        "pure_yaw": 2,
        "yaw_drift": 1,
        "yaw_rudder": 1,
    }
    yaw = campaign["a02_G2"].settings
    assert yaw.period == pytest.approx(PERIOD, rel=1e-6)
    assert yaw.yaw_amplitude == pytest.approx(12 * DEG, rel=1e-6)
    assert yaw.drift == pytest.approx(8 * DEG)
    assert yaw.propeller_rps == pytest.approx(5.0)
    assert campaign["a02_C00"].settings.speed == pytest.approx(U)


def test_particulars_stand_beside_lists_without_names(tmp_path: Path, capsys) -> None:
    """Two tables of calibrations fill the columns to the right of the ship, and name none."""
    gauges = ["XF", 4.19, 0.008, 0.02, "N", 41.9, 0.08]
    pages: dict[str, list[Row]] = {
        "Environment": [
            line if place < 4 else [*line, *[None] * (5 - len(line)), *gauges, None, *gauges]
            for place, line in enumerate(ENVIRONMENT)
        ]
    }
    pages["Environment"] = [
        ["T0Z05A01", *line[1:]] if line[:1] == ["A01"] else line for line in pages["Environment"]
    ]
    saved(tmp_path / "results.xlsx", {**pages, "T0Z05A01": sheet("T0Z05A01")})
    _, target = drafted(capsys, tmp_path)
    raw = tomllib.loads(target.read_text(encoding="utf-8"))
    assert raw["ship"] == {"L": 4.0, "B": 0.6, "d": 0.2, "volume": 0.3, "Izz": 300.0, "xG": -0.05}
    assert raw["water"]["depth"] == 0.41
    assert not [item for item in raw["tables"] if "switch_deg" in item]
    assert len(open_campaign(target)) == 26 + 24 + 6


def near_the_bottom(v: float, r: float, vdot: float, rdot: float, delta: float):
    """The hull of `forces` with five times its added mass in sway."""
    x, y, n = forces_in_deep_water(v, r, vdot, rdot, delta)
    return x, y - 4 * 280.0 * vdot, n


forces_in_deep_water = forces


@pytest.mark.parametrize("inside", [True, False])
def test_the_mass_tells_the_inertia_where_added_mass_is_large(
    tmp_path: Path, capsys, monkeypatch, inside: bool
) -> None:
    """Y over r u is a sixth of Y over the sway acceleration with the model's mass inside."""

    def read(v: float, r: float, vdot: float, rdot: float, delta: float) -> tuple[float, ...]:
        x, y, n = near_the_bottom(v, r, vdot, rdot, delta)
        own = 0.0 if inside else MASS
        return x - own * v * r, y + own * (vdot + U * r), n + (own and IZZ) * rdot

    monkeypatch.setattr(sys.modules[__name__], "forces", read)
    saved(tmp_path / "results.xlsx", {"Environment": ENVIRONMENT, "A01": sheet("A01")})
    _, target = drafted(capsys, tmp_path)
    text = target.read_text(encoding="utf-8")
    assert tomllib.loads(text)["campaign"]["forces"] == ("balance" if inside else "hydrodynamic")
    assert ("beside the mass of 299.7 kg" in text) or not inside


def test_the_sign_of_the_rudder_is_told_by_few_of_many_steady_tests(tmp_path: Path, capsys) -> None:
    """Of 300 rows with drift and rudder 21 part the two."""
    rows = sheet("A01")
    more = [steady(f"A01_S{n:03d}", 8, 10, noise=1e-3 * (n % 7)) for n in range(280)]
    pages = {"Environment": ENVIRONMENT, "A01": [*rows[:23], *more, *rows[23:]]}
    saved(tmp_path / "results.xlsx", pages)
    _, target = drafted(capsys, tmp_path)
    raw = tomllib.loads(target.read_text(encoding="utf-8"))
    assert raw["campaign"]["rudder_positive"] == "port"


def test_a_cell_that_no_run_uses_is_no_question(tmp_path: Path, capsys) -> None:
    """A row of a sweep has no drift: its drift is the heading's. A row of yaw lacks its force."""
    rows = sheet("A01")
    swept = next(place for place, line in enumerate(rows) if line and line[0] == "A01_M0")
    for line in rows[swept : swept + COUNT]:
        line[NAMES.index("v (m/s)")] = line[NAMES.index("Drift (°)")] = 0.0
        line[NAMES.index("psi (°)")] = 8.0
    rows[swept + 5][NAMES.index("Drift (°)")] = None
    saved(tmp_path / "results.xlsx", {"Environment": ENVIRONMENT, "A01": rows})
    content, _ = drafted(capsys, tmp_path)
    assert not [item for item in content["todo"] if "lacks values" in item]
    yawed = next(place for place, line in enumerate(rows) if line and line[0] == "A01_G0")
    rows[yawed + 3][NAMES.index("Y (N)")] = None
    saved(tmp_path / "results.xlsx", {"Environment": ENVIRONMENT, "A01": rows})
    (tmp_path / "a.toml").unlink()
    content, _ = drafted(capsys, tmp_path)
    (lacking,) = [item for item in content["todo"] if "lacks values" in item]
    assert "pure_yaw" in lacking
    assert "pure_sway" not in lacking


def test_the_draft_says_what_it_left_and_offers_the_statistics(folder: Path, capsys) -> None:
    _, target = drafted(capsys, folder, "--sheet", "A01")
    text = target.read_text(encoding="utf-8")
    assert "another table, with names of its own: ROTATION" in text
    assert "sheet A01, rows 31 to 34: statistics of repeats, no runs" in text
    assert '# Y_gauge = { std = 0.25, unit = "N" }' in text
    assert "not useful" in text
    assert "[uncertainty]" not in tomllib.loads(text)


def test_the_repeats_are_grouped(folder: Path, capsys) -> None:
    _, target = drafted(capsys, folder, "--sheet", "A01")
    text = target.read_text(encoding="utf-8").replace("rho = 999.1", "rho = 1000.0")
    target.write_text(text, encoding="utf-8")
    groups = [[run.id for run in group] for group in Run.repeats(open_campaign(target).runs)]
    assert [f"A01_R{n}" for n in range(5)] in groups
    assert ["A01_F0", "A01_F1"] in groups
    assert ["A01_G0", "A01_G1"] in groups


def test_several_sheets_are_told_apart(folder: Path, capsys) -> None:
    content, target = drafted(capsys, folder)
    assert len(content["tables"]) == 12
    assert any("depth: taken by sheet" in item for item in content["todo"])
    text = target.read_text(encoding="utf-8").replace("rho = 999.1", "rho = 1000.0")
    target.write_text(text, encoding="utf-8")
    campaign = open_campaign(target)
    assert campaign.depths == (0.41, 0.246)
    assert {run.id[:3].casefold() for run in campaign.by_depth()[1]} == {"a02"}
    assert main(["new-campaign", str(folder), "-o", str(folder / "b.toml"), "--sheet", "A9"])
    assert "There are 'Environment', 'A01', 'A02'" in capsys.readouterr().err


def test_a_swinging_rudder_is_as_measured_and_its_drift_that_of_the_heading(tmp_path, capsys):
    """A laboratory's tests with a rudder that swings at a heading had 0 for drift and v."""
    rows = sheet("A01")
    swung = cycle("A01_M1", "MULTI", "rudder", beta=8.0)
    for line in swung:
        line[NAMES.index("v (m/s)")] = line[NAMES.index("Drift (°)")] = 0.0
    at = next(place for place, line in enumerate(rows) if line and line[0] == "A01_M0")
    book = openpyxl.Workbook()
    page = book.active
    page.title = "A01"
    for line in [*rows[:at], *swung, *rows[at + COUNT :]]:
        page.append(line)
    for cells in MERGED:
        page.merge_cells(cells)
    book.save(tmp_path / "results.xlsx")
    _, target = drafted(capsys, tmp_path)
    text = target.read_text(encoding="utf-8")
    assert "the drift is taken from it" in text
    typed = {
        "rho = 999.1": "rho = 1000.0",
        "# L = ...": "L = 4.0",
        "# B = ...": "B = 0.6",
        "# d = ...": "d = 0.2",
        "# mass = ...": "volume = 0.3",
        "# Izz = ...": "Izz = 300.0",
    }
    for draft, own in typed.items():
        text = text.replace(draft, own, 1)
    target.write_text(text, encoding="utf-8")
    runs = [run for run in open_campaign(target).runs if run.id.startswith("A01_M1")]
    assert len(runs) == COUNT
    for run, line in zip(runs, swung, strict=True):
        assert run.settings.drift == pytest.approx(8 * DEG)
        assert run.settings.speed == pytest.approx(line[NAMES.index("u (m/s)")])
        measured = NAMES.index("measured (°)")
        assert abs(run.settings.rudder) == pytest.approx(abs(line[measured]) * DEG, abs=1e-9)
