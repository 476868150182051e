"""Exports of STAR-CCM+ monitors: their headers, several of one run, and damaged ones.

The headers are those found in public programs that read such exports; the numbers are made here.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pmmkit import open_campaign
from pmmkit.base import CampaignError, DataError
from pmmkit.readers import READERS, Options, Request
from pmmkit.readers.starccm import reader as starccm
from scripts.datasets.campaign_text import S175

TIME = "Physical Time: Physical Time (s)"
FORCES = ("Fx Monitor: Force (N)", "Fy Monitor: Force (N)", "Mz Monitor: Moment (N-m)")
T = np.round(0.05 * np.arange(1, 61), 10)
X, Y, N = -30.0 + 0.2 * np.sin(T), 12.0 * np.cos(T), 4.0 * np.sin(2 * T)
TOML = (
    """[campaign]
title = "computed"
kind = "captive"
forces = "hydrodynamic"
"""
    + S175
    + """[source]
format = "star-ccm+"
{source}
{columns}
[[runs]]
id = "SD"
test = "static_drift"
file = "{file}"
speed = 1.5
drift_deg = 8.0
"""
)


def export(headers, *columns, bom=False, ends="\n") -> bytes:
    """An export: a quoted header and a row for each sample, in the digits of a Java program."""
    lines = [",".join(f'"{header}"' for header in headers)]
    lines += [",".join(map(repr, row)) for row in np.column_stack(columns).tolist()]
    text = ends.join(lines) + ends
    return text.encode("utf-8-sig" if bom else "utf-8")


@pytest.fixture
def read(tmp_path):
    """Write files and read the run they belong to."""

    def _read(files: dict[str, bytes], file: str = "run", columns: str = "", source: str = ""):
        for name, content in files.items():
            path = tmp_path / name
            path.parent.mkdir(exist_ok=True)
            path.write_bytes(content)
        text = TOML.format(file=file, columns=f"[columns]\n{columns}", source=source)
        (tmp_path / "campaign.toml").write_text(text, encoding="utf-8")
        return open_campaign(tmp_path)["SD"].data

    return _read


def notes(data) -> str:
    return "\n".join(json.loads(data.attrs["conversions"]))


def headers_of(path: Path) -> tuple[str, ...]:
    return starccm.names(Request(path=path, shown=path.name))


@pytest.mark.parametrize(
    ("header", "offered"),
    [
        ("Thrust 1 Monitor: Thrust (N)", "Thrust 1 [N]"),
        ("Moment 1 Monitor: Moment (N-m)", "Moment 1 [N m]"),
        ("Fy Monitor: Force (N)", "Fy [N]"),
        ("Mz Monitor: Moment (N-m)", "Mz [N m]"),
        ("Mz Monitor: Moment (lbf-ft)", "Mz [lbf ft]"),
        ("Fx Monitor: Force (kN)", "Fx [kN]"),
        ("Fx Monitor: Force (lbf)", "Fx [lbf]"),
        ("Frequency Monitor: Expression", "Frequency [-]"),
        ("Drag Monitor: Drag Monitor (N)", "Drag [N]"),
        ("Pitch_Moment Monitor: Pitch_Moment Monitor (N-m)", "Pitch_Moment [N m]"),
        ("Cd Monitor: Cd Monitor", "Cd [-]"),
        ("Continuity: Residual", "Continuity [-]"),
        ("Cabs_X Monitor 2: Force (N)", "Cabs_X 2 [N]"),
        ("Name_X Monitor (N)", "Name_X [N]"),
        ("Total Blade Thrust (Force) Monitor: Force (N)", "Total Blade Thrust (Force) [N]"),
        ("Force Truss Top  2  y Monitor: Force (N)", "Force Truss Top 2 y [N]"),
        ("InletVela Monitor: Surface Average of Velocity: Magnitude (m/s)", "InletVela [m/s]"),
        ("Yaw Rate Monitor: Yaw Rate Monitor (radian/s)", "Yaw Rate [rad/s]"),
        ("Shaft Speed Monitor: Expression (rpm)", "Shaft Speed [rpm]"),
        ("点10RH Monitor: Sum of RH", "点10RH [-]"),
        ("Mass Monitor: Mass Flow (kg/s)", "Mass [kg/s]"),
    ],
)
def test_names_and_units_of_headers(header, offered):
    assert starccm.clean_headers(["Iteration", header])[1] == offered


@given(
    st.lists(
        st.sampled_from(
            [
                "Fx Monitor: Force (N)",
                "Fx Monitor 2: Force (N)",
                "Fx 2 Monitor: Force (N)",
                "Fx (N)",
                "Fx Monitor: Moment (N-m)",
                "Fx  Monitor: Force (N)",
                "Fx: Residual",
                "Fx",
            ]
        ),
        max_size=8,
    )
)
def test_names_stay_unique(headers):
    names = [header.rsplit(" [", 1)[0] for header in starccm.clean_headers(headers)]
    assert len(set(names)) == len(names)


@pytest.mark.slow
@pytest.mark.parametrize("bom", [False, True])
@pytest.mark.parametrize("ends", ["\n", "\r\n"])
@pytest.mark.parametrize(
    "first",
    [
        TIME,
        "Physical Time (s)",
        "Physikalische Zeit (s)",
        "物理时间 (s)",
        "时间",
        "Zeit",
        "Solution Time: Solution Time (s)",
        "Fizikai idő (s)",
    ],
)
def test_an_export_reads_without_being_mapped(read, first, bom, ends):
    data = read({"a.csv": export((first, *FORCES), T, X, Y, N, bom=bom, ends=ends)}, "a.csv")
    for name, expected in {"t": T, "X": X, "Y": Y, "N": N}.items():
        assert np.array_equal(data[name].values, expected)
    assert "X from column 'Fx [N]', its usual name" in notes(data)
    assert ("is taken for the time" in notes(data)) == (not first.startswith("Physical"))


def test_units_become_si(read):
    headers = (
        "Physical Time (ms)",
        "Fx Monitor: Force (kN)",
        "Fy Monitor: Force (lbf)",
        "Mz Monitor: Moment (kN-m)",
    )
    data = read({"a.csv": export(headers, T * 1e3, X, Y, N)}, "a.csv")
    assert data["t"].values == pytest.approx(T)
    assert data["X"].values == pytest.approx(1e3 * X)
    assert data["Y"].values == pytest.approx(4.4482216152605 * Y)
    assert data["N"].values == pytest.approx(1e3 * N)


def test_other_names_are_suggested_and_never_guessed(read):
    headers = (TIME, "Drag Monitor: Drag Monitor (N)", "Hull_Y Monitor: Force (N)", FORCES[2])
    files = {"a.csv": export(headers, T, X, Y, N)}
    with pytest.raises(CampaignError) as caught:
        read(files, "a.csv")
    assert 'X = "Drag [N]"' in str(caught.value)
    assert 'Y = "Hull_Y [N]"' in str(caught.value)
    data = read(files, "a.csv", columns='X = "Drag"\nY = "Hull_Y"\n')
    assert np.array_equal(data["X"].values, X)
    assert np.array_equal(data["Y"].values, Y)


def test_two_usual_names_are_left_to_the_user(read):
    headers = (TIME, *FORCES, "Force X Monitor: Force (N)")
    files = {"a.csv": export(headers, T, X, Y, N, 2 * X)}
    with pytest.raises(CampaignError, match="there is no column X"):
        read(files, "a.csv")
    data = read(files, "a.csv", columns='X = "Force X"\n')
    assert np.array_equal(data["X"].values, 2 * X)


def test_a_coefficient_is_no_force(read):
    headers = (TIME, "Fx Monitor: Fx Monitor", *FORCES[1:])
    files = {"a.csv": export(headers, T, X, Y, N)}
    with pytest.raises(CampaignError, match="X is stated without dimension"):
        read(files, "a.csv")


def test_inner_iterations_leave_the_last_row_of_each_step(read):
    inner = np.repeat(T, 5)
    start = np.repeat(X, 5) + np.tile([3.0, 1.0, 0.5, 0.1, 0.0], len(T))
    files = {"a.csv": export((TIME, *FORCES), inner, start, np.repeat(Y, 5), np.repeat(N, 5))}
    data = read(files, "a.csv")
    assert np.array_equal(data["t"].values, T)
    assert np.array_equal(data["X"].values, X)
    assert "240 rows of inner iterations left out" in notes(data)


def test_time_may_stand_behind_the_iterations(read):
    count = np.arange(1.0, 1 + 3 * len(T))
    columns = [count, *(np.repeat(values, 3) for values in (T, X, Y, N))]
    data = read({"a.csv": export(("Iteration", TIME, *FORCES), *columns)}, "a.csv")
    assert np.array_equal(data["t"].values, T)
    assert np.array_equal(data["Y"].values, Y)


@pytest.mark.parametrize("file", ["run", "run/*.csv", "run/run_*"])
def test_files_with_different_columns_merge_on_time(read, file):
    files = {
        "run/run_Fx.csv": export((TIME, FORCES[0]), T, X),
        "run/run_others.csv": export((TIME, *FORCES[1:]), T + 1e-9, Y, N),
    }
    data = read(files, file)
    for name, expected in {"t": T, "X": X, "Y": Y, "N": N}.items():
        assert np.array_equal(data[name].values, expected)


def test_inner_iterations_of_one_file_beside_time_steps_of_another(read):
    files = {
        "run/a.csv": export((TIME, FORCES[0]), np.repeat(T, 2), np.repeat(X, 2) + [1, 0] * len(T)),
        "run/b.csv": export((TIME, *FORCES[1:]), T, Y, N),
    }
    data = read(files)
    assert np.array_equal(data["X"].values, X)
    assert np.array_equal(data["N"].values, N)


def test_every_third_step_gives_the_common_times_only(read):
    files = {
        "run/a.csv": export((TIME, *FORCES[:2]), T, X, Y),
        "run/b.csv": export((TIME, FORCES[2]), T[2::3], N[2::3]),
    }
    data = read(files)
    for name, expected in {"t": T, "X": X, "Y": Y, "N": N}.items():
        assert np.array_equal(data[name].values, expected[2::3])
    assert "20 common times kept; rows: a.csv 60, b.csv 20" in notes(data)


@pytest.mark.parametrize("shift", [0.02, 0.001])
def test_other_times_are_refused_with_file_and_place(read, shift):
    files = {
        "run/a.csv": export((TIME, *FORCES[:2]), T, X, Y),
        "run/b.csv": export((TIME, FORCES[2]), np.append(T[:10], T[10:40] + shift), N[:40]),
    }
    with pytest.raises(CampaignError) as caught:
        read(files)
    message = str(caught.value)
    assert f"b.csv has a row at {T[10] + shift:.10g}, a.csv has none" in message
    assert "30 of the 40 rows" in message


def test_files_that_go_on_longer_than_each_other_are_refused(read):
    files = {
        "run/a.csv": export((TIME, *FORCES[:2]), T[:50], X[:50], Y[:50]),
        "run/b.csv": export((TIME, FORCES[2]), T[20:], N[20:]),
    }
    with pytest.raises(CampaignError, match=r"b\.csv has a row at 2\.55"):
        read(files)


@pytest.mark.parametrize("word", ["Iteration", "迭代", "Zeitschritt"])
def test_iterations_beside_time_say_what_to_export(read, word):
    files = {
        "run/a.csv": export((TIME, *FORCES[:2]), T, X, Y),
        "run/b.csv": export((word, FORCES[2]), np.arange(1.0, 61.0), N),
    }
    with pytest.raises(CampaignError) as caught:
        read(files)
    assert f"b.csv goes by '{word}', a.csv by 'Physical Time [s]'" in str(caught.value)
    assert "x axis of its plot to Physical Time" in str(caught.value)


def test_residuals_beside_the_forces_do_no_harm(read):
    files = {
        "run/forces.csv": export((TIME, *FORCES), T, X, Y, N),
        "run/residuals.csv": export(("Iteration", "Continuity: Residual"), T, X),
    }
    data = read(files)
    assert np.array_equal(data["N"].values, N)
    assert "no column used of residuals.csv" in notes(data)


def test_iterations_alone_are_no_time(read):
    files = {"a.csv": export(("Iteration", *FORCES), np.arange(1.0, 61.0), X, Y, N)}
    with pytest.raises(CampaignError, match="there is no column t"):
        read(files, "a.csv")
    data = read(files, "a.csv", columns='t = { name = "Iteration", scale = 0.5 }\n')
    assert data["t"].values == pytest.approx(0.5 * np.arange(1, 61))


def test_a_column_in_two_files(read):
    files = {
        "run/a.csv": export((TIME, *FORCES[:2]), T, X, Y),
        "run/b.csv": export((TIME, *FORCES[1:]), T, Y, N),
    }
    with pytest.raises(CampaignError, match=r"Fy \[N\] stands in b\.csv and in a\.csv"):
        read(files)


def cut_in_time(first, second, change=0.0):
    """Two exports of the same monitors, the second from a restart."""
    parts = {"run/a.csv": (slice(*first), 0.0), "run/b.csv": (slice(*second), change)}
    return {
        name: export((TIME, *FORCES), T[part], X[part] + by, Y[part], N[part])
        for name, (part, by) in parts.items()
    }


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ((0, 30), (30, 60)),
        ((30, 60), (0, 30)),
        ((0, 40), (25, 60)),
        ((0, 60), (10, 20)),
        ((0, 40), (0, 60)),
    ],
)
def test_restarts_that_agree_are_joined(read, first, second):
    data = read(cut_in_time(first, second))
    for name, expected in {"t": T, "X": X, "Y": Y, "N": N}.items():
        assert np.array_equal(data[name].values, expected)
    assert "follows" in notes(data) or "agree where they overlap" in notes(data)


def test_restarts_that_disagree_need_their_order(read):
    files = cut_in_time((0, 40), (25, 60), 0.5)
    with pytest.raises(CampaignError) as caught:
        read(files)
    assert f"Fx [N] at {T[25]:.10g} is" in str(caught.value)
    assert 'order = ["a.csv", "b.csv"]' in str(caught.value)
    data = read(files, source='order = ["a.csv", "b.csv"]')
    assert np.array_equal(data["t"].values, T)
    assert np.array_equal(data["X"].values, np.append(X[:25], X[25:] + 0.5))
    assert f"b.csv counts from {T[25]:.10g} on: 15 rows of a.csv left out" in notes(data)
    with pytest.raises(CampaignError, match=r"order .* names c\.csv"):
        read(files, source='order = ["a.csv", "c.csv"]')


def test_a_restart_with_another_time_step(read):
    files = cut_in_time((0, 40), (40, 60))
    fine = np.round(np.arange(1.5, 3.0, 0.02), 10)
    values = [np.interp(fine, T, column) for column in (X, Y, N)]
    files["run/b.csv"] = export((TIME, *FORCES), fine, *values)
    with pytest.raises(CampaignError, match="not at the same times"):
        read(files)
    data = read(files, source='order = ["a.csv", "b.csv"]')
    assert np.array_equal(data["t"].values, np.append(T[:29], fine))


def test_time_that_goes_back_within_a_file(read):
    again = np.append(T[:40], T[30:])
    columns = [np.append(values[:40], values[30:]) for values in (X, Y, N)]
    with pytest.raises(CampaignError, match=r"goes back from 2 to 1\.55 after 40 rows"):
        read({"a.csv": export((TIME, *FORCES), again, *columns)}, "a.csv")


def test_every_file_of_a_folder_is_hashed(read, tmp_path):
    read(cut_in_time((0, 40), (25, 60)))
    assert list(open_campaign(tmp_path).file_hashes()) == ["run/a.csv", "run/b.csv"]


def test_folders_without_exports(read):
    with pytest.raises(CampaignError, match=r"holds no \.csv file"):
        read({"run/a.txt": b"1"})
    with pytest.raises(CampaignError, match="is not there"):
        read({}, "none/*.csv")


def test_exports_are_recognised_by_content(tmp_path):
    yes = [
        (TIME, FORCES[0]),
        ("Iteration", FORCES[0]),
        ("时间", "Cd Monitor: Cd Monitor"),
        ("Iteration", "Continuity: Residual"),
        ("Zeit (s)", "Fx Monitor (N)"),
    ]
    for headers in yes:
        for bom in (False, True):
            assert READERS["star-ccm+"].recognises(
                tmp_path / "a.csv", export(headers, T, X, bom=bom)
            )
    for head in (b"", b"t,X\n0,1\n", b'"t","X"\n0,1\n', b"\x00\xff", b"Fx Monitor: Force (N)"):
        assert not READERS["star-ccm+"].recognises(tmp_path / "a.csv", head)
    assert not READERS["star-ccm+"].recognises(tmp_path, b"")
    (tmp_path / "a.CSV").write_bytes(export(yes[0], T, X))
    assert READERS["star-ccm+"].recognises(tmp_path, b"")


# Damage


GOOD = export((TIME, *FORCES), T, np.round(X, 6), np.round(Y, 6), np.round(N, 6))
REFERENCE = np.stack([T, np.round(X, 6), np.round(Y, 6), np.round(N, 6)])


def outcome(read, content: bytes):
    """The samples, or None after an error of ours; anything else is a failure."""
    try:
        data = read({"a.csv": content}, "a.csv")
    except DataError:
        return None, ""
    return np.stack([data[name].values for name in "tXYN"]), notes(data)


@pytest.mark.slow
def test_cut_anywhere(read):
    """The whole rows before the cut and nothing of the row that is cut; it is noted."""
    rng = np.random.default_rng(1)
    complete = 0
    for cut in {*rng.integers(0, len(GOOD), 120).tolist(), 0, 1, len(GOOD) - 1}:
        found, said = outcome(read, GOOD[:cut])
        if found is None:
            continue
        rows = GOOD[:cut].count(b"\n") - 1
        assert np.array_equal(found, REFERENCE[:, :rows])
        assert ("cut off" in said) == (not GOOD[:cut].endswith(b"\n"))
        complete += 1
    assert complete > 80


def test_a_last_row_with_all_its_digits_but_no_line_end_stays(read):
    lines = [f"{t:.2f},{x:.4f},{x:.4f},{x:.4f}" for t, x in zip(T, X, strict=True)]
    head = GOOD.split(b"\n")[0].decode()
    found, said = outcome(read, "\n".join([head, *lines]).encode())
    assert found is not None
    assert found.shape == (4, 60)
    assert "cut off" not in said
    found, said = outcome(read, "\n".join([head, *lines]).encode()[:-1])
    assert found is not None
    assert found.shape == (4, 59)
    assert "a.csv: the last row is cut off" in said


def test_a_last_row_with_too_few_fields(read):
    found, said = outcome(read, GOOD + b"3.05,-29.5\n")
    assert found is not None
    assert np.array_equal(found, REFERENCE)
    assert "a.csv: the last row is cut off" in said


def test_a_remark_behind_a_row_that_is_cut_off(read):
    found, said = outcome(read, GOOD + b"3.05,-29.5\n# stopped\n")
    assert found is not None
    assert np.array_equal(found, REFERENCE)
    assert "comments among the rows left out" in said
    with pytest.raises(CampaignError, match="row 5"):
        read({"a.csv": GOOD.replace(b"\n0.2,", b"\n0.2;") + b"3.05,-29\n# stopped\n"}, "a.csv")


@pytest.mark.slow
def test_flipped_bits(read):
    rng = np.random.default_rng(2)
    start = GOOD.index(b"\n") + 1
    for place, bit in zip(
        rng.integers(start, len(GOOD), 120), rng.integers(0, 8, 120), strict=True
    ):
        broken = bytearray(GOOD)
        broken[place] ^= 1 << int(bit)
        found, _ = outcome(read, bytes(broken))
        if found is not None and place < len(GOOD) - 1:
            assert found.shape == REFERENCE.shape
            assert np.sum(found != REFERENCE) <= 1


@pytest.mark.slow
def test_headers_with_a_flipped_bit(read):
    rng = np.random.default_rng(3)
    stop = GOOD.index(b"\n")
    for place, bit in zip(rng.integers(0, stop, 120), rng.integers(0, 8, 120), strict=True):
        broken = bytearray(GOOD)
        broken[place] ^= 1 << int(bit)
        found, _ = outcome(read, bytes(broken))
        assert found is None or found.shape[1] == len(T)


@pytest.mark.parametrize("cell", ["nan", "", "abc", "1e400", "1e35", "Infinity", "1;5"])
def test_bad_cells_in_the_middle_are_named(read, cell):
    lines = GOOD.decode().splitlines()
    for row in (5, 17):
        parts = lines[row].split(",")
        parts[2] = cell
        lines[row] = ",".join(parts)
    with pytest.raises(CampaignError) as caught:
        read({"a.csv": "\n".join([*lines, ""]).encode()}, "a.csv")
    for word in ("a.csv", "Fy", "row 6", "row 18"):
        assert word in str(caught.value)


@pytest.mark.parametrize("row", [1, 9, 40])
def test_rows_of_another_length_are_named(read, row):
    for change in (lambda line: line + ",9.9", lambda line: line.rsplit(",", 1)[0]):
        lines = GOOD.decode().splitlines()
        lines[row] = change(lines[row])
        with pytest.raises(CampaignError, match=f"row {row + 1}"):
            read({"a.csv": "\n".join([*lines, ""]).encode()}, "a.csv")


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"\n",
        GOOD.split(b"\n")[0],
        GOOD.split(b"\n")[0] + b"\n",
        b"\0" * 400,
        b"\x89HDF\r\n\x1a\n",
        GOOD.split(b"\n")[0] + b"\n1.0,2",
        b'"' * 99,
        b'"Physical Time (s)',
        b"Case 7\n\nno names here\n" + GOOD.split(b"\n", 1)[1],
    ],
    ids=[
        "0 bytes",
        "blank",
        "cut header",
        "header only",
        "zeros",
        "HDF5",
        "half a row",
        "quotes",
        "half a name",
        "no header",
    ],
)
def test_files_that_hold_no_export(read, content):
    with pytest.raises(CampaignError, match=r"a\.csv"):
        read({"a.csv": content}, "a.csv")


def test_all_files_of_a_run_are_looked_at(read):
    with pytest.raises(CampaignError) as caught:
        read({"run/a.csv": b"", "run/b.csv": GOOD, "run/c.csv": b"\0\0"})
    assert "run/a.csv" in str(caught.value)
    assert "run/c.csv" in str(caught.value)
    files = {
        "run/a.csv": export((TIME, *FORCES[:2]), T, X, Y).replace(b"\n0.5,", b"\n0.5;"),
        "run/b.csv": export((TIME, "Cd Monitor"), T, X),
        "run/c.csv": export((TIME, FORCES[2]), T, N).replace(b"\n1.5,", b"\n?,"),
    }
    with pytest.raises(CampaignError) as caught:
        read(files, "run/*.csv")
    assert "run/a.csv" in str(caught.value)
    assert "row 11" in str(caught.value)
    assert "run/c.csv" in str(caught.value)
    assert "row 31" in str(caught.value)


def test_an_export_is_no_table(tmp_path):
    (tmp_path / "a.csv").write_bytes(GOOD)
    request = Request(path=tmp_path / "a.csv", shown="a.csv", options=Options())
    with pytest.raises(CampaignError, match="not a table of rows"):
        READERS["star-ccm+"].cells(request)
    assert headers_of(tmp_path / "a.csv") == ("Physical Time [s]", "Fx [N]", "Fy [N]", "Mz [N m]")
