"""``pmmkit inspect``: what a file or a folder holds, before anything is known of it."""

from __future__ import annotations

import contextlib
import json
import os
import shutil
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from installed_readers import installed

from pmmkit.base import CampaignError, PmmkitError
from pmmkit.cli import main
from pmmkit.intake import look
from pmmkit.intake.file import clock_of, look_at
from pmmkit.intake.guessing import bare_header, suggest
from pmmkit.intake.under_way import rates_of
from pmmkit.readers import Columns, Options, Reader, Request, TextLayout, reader_for, recognise
from pmmkit.readers.registry import format_of
from pmmkit.views.figures.inspecting import envelope


def inspected(capsys, *arguments):
    """Status, JSON and words of the command."""
    status = main(["inspect", *map(str, arguments), "--json"])
    output = capsys.readouterr()
    return status, json.loads(output.out), output.err


def record(rows: int = 200, step: float = 0.1) -> np.ndarray:
    t = np.arange(rows) * step
    rng = np.random.default_rng(2)
    return np.column_stack([t, rng.normal(size=(rows, 3)).round(3)])


def text_of(table, *, between=",", head="", decimal="."):
    body = "\n".join(between.join(f"{x:.3f}" for x in row) for row in table) + "\n"
    return head + body.replace(".", decimal)


def suggestions(content, group=0):
    return {
        column["suggestion"]["name"]: column["suggestion"]["certainty"]
        for column in content["groups"][group]["columns"]
        if column["suggestion"]
    }


# Layouts: each is written by a tank somewhere, and each must read by what is said of it.

LAYOUTS = {
    "plain": ("t,X,Y,N\n", ",", ".", "utf-8", "\n"),
    "german": ("Zeit [s];Fx [N];Fy [N];Mz [Nm]\n", ";", ",", "cp1252", "\r\n"),
    "titles": ("Tank 4\nModell Ähre, 12.3.2024\n\nt\tFx\tFy\tMz\n", "\t", ".", "cp1252", "\r\n"),
    "units below": ("Time;Fx;Fy;Mz\ns;N;N;Nm\n", ";", ".", "utf-8", "\n"),
    "brackets below": ("Time Fx Fy Mz\n[s] [N] [N] [Nm]\n", " ", ".", "utf-8", "\n"),
    "comment sign": ("# t X Y N\n", " ", ".", "utf-8", "\n"),
    "no header": ("", " ", ".", "utf-8", "\n"),
    "mark": ("\ufefft,X,Y,N\n", ",", ".", "utf-8", "\r\n"),
    "sixteen": ("t;X;Y;N\n", ";", ",", "utf-16", "\r\n"),
    "mac": ("t,X,Y,N\n", ",", ".", "utf-8", "\r"),
}


@pytest.mark.parametrize("name", LAYOUTS)
def test_a_layout_is_told_and_reads_as_it_is_told(name, tmp_path):
    head, between, decimal, encoding, end = LAYOUTS[name]
    table = record()
    text = text_of(table, between=between, head=head, decimal=decimal)
    path = tmp_path / "run.dat"
    path.write_bytes(text.replace("\n", end).encode(encoding))
    (found,) = look_at(path, "run.dat")
    assert found.problems == ()
    assert found.rows == len(table)
    request = Request(path=path, shown="run.dat", options=found.options)
    read = reader_for(request).columns(request, lambda _, width: range(width))
    np.testing.assert_allclose(np.column_stack(read.values), table, atol=1e-9)
    named = {column.suggestion.name for column in found.columns if column.suggestion}
    assert named == ({"t"} if name == "no header" else {"t", "X", "Y", "N"})


@settings(max_examples=60)
@given(
    between=st.sampled_from([",", ";", "\t", " "]),
    above=st.lists(st.text(alphabet="abc XYZ:/-", min_size=1, max_size=30), max_size=6),
    rows=st.integers(4, 40),
    width=st.integers(3, 8),
    header=st.booleans(),
)
def test_lines_above_never_hide_the_numbers(between, above, rows, width, header):
    table = np.arange(rows * width, dtype=float).reshape(rows, width) / 7
    lines = [*above, *([between.join(f"c{n}" for n in range(width))] if header else [])]
    text = text_of(table, between=between, head="".join(f"{line}\n" for line in lines))
    found = TextLayout.of(text.encode(), whole=True)
    assert found is not None
    assert found.first_row == len(lines) + 1
    assert (found.delimiter, len(found.headers)) == (between, width)
    if header:
        assert found.header_line == len(lines)


@pytest.mark.slow
@settings(max_examples=150)
@given(data=st.binary(max_size=400))
def test_no_bytes_are_too_much(data, tmp_path_factory):
    path = tmp_path_factory.mktemp("odd") / "file.dat"
    path.write_bytes(data)
    with contextlib.suppress(PmmkitError):
        look(path)
    shutil.rmtree(path.parent)


@pytest.mark.slow
@settings(max_examples=60)
@given(place=st.integers(0, 3000), junk=st.binary(min_size=1, max_size=8))
def test_damage_is_named_and_the_rest_is_shown(place, junk, tmp_path_factory):
    """Bytes written over the middle of a good file: still the same columns, or an error of ours."""
    good = text_of(record(), head="t,X,Y,N\n").encode()
    path = tmp_path_factory.mktemp("hurt") / "run.csv"
    path.write_bytes(good[:place] + junk + good[place + len(junk) :])
    try:
        found = look(path).groups[0].first
    except PmmkitError:
        assert place < 60 or b"\0" in junk
    else:
        assert found.rows > 150 or found.problems
    shutil.rmtree(path.parent)


# Formats by content.


def test_formats_that_come_along(datasets, tmp_path):
    import openpyxl

    book = openpyxl.Workbook()
    for row in [["t", "X"], *record()[:, :2].tolist()]:
        book.active.append(row)
    book.save(tmp_path / "really_a_workbook.dat")
    (tmp_path / "run.xyz").write_text("t X\n0.0 1.0\n0.1 1.1\n", encoding="utf-8")
    (tmp_path / "letter.docx").write_bytes(b"PK\x03\x04 no zip at all")
    (tmp_path / "notes.txt").write_text("Ran well.\nNo numbers.\n", encoding="utf-8")
    assert recognise(tmp_path / "really_a_workbook.dat") == "excel"
    assert recognise(tmp_path / "run.xyz") == "csv"
    assert recognise(datasets / "s175" / "runs.h5") == "pmmkit"
    assert recognise(tmp_path / "letter.docx") is None
    assert recognise(tmp_path / "notes.txt") is None
    assert recognise(tmp_path / "nowhere") is None
    assert recognise(tmp_path) is None


@pytest.fixture
def boxes():
    """A format of one's own: folders that hold a file named ``box``, files that begin with BOX."""
    headers = ("Time [s]", "Fx [kN]")

    class Silent(Reader):
        name, words, reads = "silent", "silent", "What nobody recognises."

        def columns(self, request, choose):
            return Columns(headers=(), positions=(), values=())

    class Boxes(Silent):
        name, words, reads = "boxes", "box", "Boxes."

        def recognises(self, path, head):
            return head.startswith(b"BOX") or (path / "box").is_file()

        def columns(self, request, choose):
            positions = tuple(choose(headers, 2))
            values = (np.arange(30) * 0.5, np.ones(30))
            return Columns(
                headers=headers,
                positions=positions,
                values=tuple(values[place] for place in positions),
            )

    with installed(Silent, Boxes):
        yield Boxes


def test_a_further_format_comes_before_plain_text(boxes, tmp_path):
    path = tmp_path / "run.dat"
    path.write_bytes(b"BOX\n1,2\n3,4\n5,6\n")
    assert recognise(path) == "boxes"
    assert format_of("run.dat", Options(), path) == "boxes"
    assert format_of("run.dat", Options(format="csv"), path) == "csv"
    assert format_of("run.dat", Options()) == "csv"
    assert format_of("run.xlsx", Options(), path) == "excel"
    assert reader_for(Request(path=path, shown="run.dat")).__class__ is boxes


def test_a_container_is_told_by_its_content(boxes, datasets, tmp_path):
    shutil.copy(datasets / "s175" / "runs.h5", tmp_path / "ours.h5")
    (tmp_path / "theirs.h5").write_bytes(b"BOX")
    assert format_of("ours.h5", Options(), tmp_path / "ours.h5") == "pmmkit"
    assert format_of("theirs.h5", Options(), tmp_path / "theirs.h5") == "boxes"


def test_a_folder_may_be_a_measurement(boxes, tmp_path, capsys):
    for case in ("U1", "U2"):
        (tmp_path / case).mkdir()
        (tmp_path / case / "box").write_bytes(b"")
        (tmp_path / case / "inside.csv").write_text("a,b\n1,2\n3,4\n", encoding="utf-8")
    status, content, _ = inspected(capsys, tmp_path)
    assert status == 0
    (group,) = content["groups"]
    assert (group["format"], group["files"], group["rows"]) == ("boxes", ["U1", "U2"], 30)
    assert look(tmp_path / "U1").groups[0].first.clock.interval == 0.5


# Columns.


def test_what_columns_probably_are():
    headers = [
        "Physical Time: Physical Time (s)",
        "Fy Monitor: Force (N)",
        "Mz Monitor (N-m)",
        "Yaw angle (deg)",
        "n_rpm",
        "r_angvelo [rad/s]",
        "Gauge 7 [V]",
        "beta",
    ]
    bare = [bare_header(header) for header in headers]
    found = suggest([name for name, _ in bare], [unit for _, unit in bare], {})
    names = [item.name if item else None for item in found]
    assert names == ["t", "Y", "N", "psi", "n", "r", None, None]
    assert found[4].unit == "rpm"


def test_a_unit_that_measures_something_else_speaks_against_a_name():
    """X in metres is a position, N in rpm no moment."""
    found = suggest(["t", "X", "Y", "N"], ["s", "m", "m", "rpm"], {})
    assert [item.name for item in found] == ["t", "x", "y", "n"]


def test_an_exact_name_wins_over_a_usual_one():
    found = suggest(["time", "Force X", "X"], [None, None, None], {})
    assert [item and (item.name, item.certainty) for item in found] == [
        ("t", "probably"),
        None,
        ("X", "surely"),
    ]


def test_degrees_are_told_by_their_size():
    numbers = {1: np.array([0.0, 12.0, -35.0])}
    (_, delta) = suggest(["t", "rudder"], [None, None], numbers)
    assert delta.unit == "deg"
    (_, delta) = suggest(["t", "rudder"], ["s", "rad"], numbers)
    assert delta.unit is None


def test_time_is_told_by_its_shape_alone(tmp_path, capsys):
    (tmp_path / "run.dat").write_text(text_of(record(), between=" "), encoding="utf-8")
    _, content, words = inspected(capsys, tmp_path / "run.dat")
    assert suggestions(content) == {"t": "probably"}
    assert "increases steadily, by 0.1 a row" in words
    assert "no header" in words


def test_rates_are_found_among_columns_without_names():
    """The columns of a free-running record: which one is the rate of which."""
    t = np.linspace(0, 100, 2001)
    psi = 20 * np.sin(0.2 * t)
    columns = {
        1: 1.2 * t,
        2: psi,
        3: np.full_like(t, 1.2),
        4: 4 * np.cos(0.2 * t),
        5: np.radians(4 * np.cos(0.2 * t)),
    }
    found = rates_of(t, columns)
    assert set(found) == {4, 5}
    assert found[4][0] == 2
    assert found[5] == (2, pytest.approx(np.radians(1), rel=0.01))


def test_the_clock():
    even = clock_of(np.arange(100) * 0.02)
    assert even.even
    assert (even.gaps, even.repeated, even.backward) == (0, 0, 0)
    t = np.concatenate([np.arange(50) * 0.1, 7 + np.arange(50) * 0.1, [11.9, 11.9, 3.0]])
    torn = clock_of(t)
    assert (torn.gaps, torn.repeated, torn.backward) == (1, 2, 1)
    assert torn.longest == pytest.approx(2.1)
    assert clock_of(t, seams=[50]).gaps == 0


# The command.


@pytest.mark.slow
def test_a_file_in_words_json_figure_and_table(tmp_path, capsys):
    head = "Time [s],Fx [kN],Fy [kN],Mz [kN m],valve\n"
    table = np.column_stack([record(), np.full(200, 2.5)])
    (tmp_path / "run.csv").write_text(text_of(table, head=head), encoding="utf-8")
    out = tmp_path / "seen"
    status, content, words = inspected(capsys, tmp_path / "run.csv", "--out", out)
    assert status == 0
    assert suggestions(content) == dict.fromkeys(("t", "X", "Y", "N"), "probably")
    (group,) = content["groups"]
    assert (group["rows"], group["clock"]["even"]) == (200, True)
    assert group["clock"]["interval"] == pytest.approx(0.1)
    assert [column["constant"] for column in group["columns"]] == [False] * 4 + [True]
    assert group["columns"][1]["min"] == table[:, 1].min()
    assert "Sampled every 0.1 s (even), 19.9 s long." in words
    assert "Next: pmmkit new-campaign" in words
    assert (out / "inspect.png").read_bytes().startswith(b"\x89PNG")
    lines = (out / "inspect.csv").read_text(encoding="utf-8").splitlines()
    assert len(lines) == 6
    assert lines[2].startswith("run.csv,2,Fx [kN],kN,")


def test_nothing_is_written_without_out(tmp_path, capsys):
    (tmp_path / "run.csv").write_text(text_of(record(), head="t,X,Y,N\n"), encoding="utf-8")
    inspected(capsys, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["run.csv"]


def test_a_folder_is_grouped(datasets, tmp_path, capsys):
    (tmp_path / "deep").mkdir()
    for number in range(30):
        (tmp_path / "deep" / f"run_{number:02d}.csv").write_text(
            text_of(record(50), head="t,X,Y,N\n"), encoding="utf-8"
        )
    (tmp_path / "other.txt").write_text(text_of(record(60), head="t X K N\n", between=" "))
    (tmp_path / "photo.jpg").write_bytes(b"\xff\xd8\xff")
    (tmp_path / ".hidden.csv").write_text("a,b\n1,2\n3,4\n", encoding="utf-8")
    shutil.copytree(datasets / "s175", tmp_path / "s175")
    status, content, words = inspected(capsys, tmp_path)
    assert status == 0
    assert sorted(len(group["files"]) for group in content["groups"]) == [1, 30]
    assert content["other_files"][".jpg"] == 1
    assert "29 more with the same columns" in words
    assert "and 17 more." in words
    assert content["campaigns"][0]["tests"]["pure_sway"] == 9
    assert "63 runs (27 static_drift, 9 pure_sway, 9 pure_yaw, 18 yaw_drift)" in words


def test_a_campaign_folder_is_summarised(datasets, capsys):
    status, content, words = inspected(capsys, datasets / "s175")
    assert status == 0
    assert [item["file"] for item in content["campaigns"]] == ["campaign.toml", "runs.h5"]
    assert "at 1, 1.5, 2 m/s" in words
    assert "new-campaign" not in words
    status, content, _ = inspected(capsys, datasets / "s175" / "runs.h5")
    assert content["campaigns"][0]["runs"] == 63


def test_a_workbook_sheet_by_sheet(tmp_path, capsys):
    import openpyxl

    book = openpyxl.Workbook()
    book.active.title = "Notes"
    book.active.append(["Nothing here"])
    for name, head in (("Drift", ["Time", "Fx", "Fy"]), ("Sway", ["Time", "Fx", "Mz"])):
        sheet = book.create_sheet(name)
        for row in (["KCS, tank 2"], [], head, ["s", "N", "N"], *record()[:, :3].tolist()):
            sheet.append(row)
    book.save(tmp_path / "tests.xlsx")
    status, content, words = inspected(capsys, tmp_path / "tests.xlsx")
    assert status == 0
    drift, sway = content["groups"]
    assert drift["source"] == {"format": "excel", "skip_rows": 0, "sheet": "Drift"}
    assert [column["unit"] for column in drift["columns"]] == ["s", "N", "N"]
    assert set(suggestions(content, 1)) == {"t", "X"}, "a moment is not measured in N"
    assert (drift["rows"], sway["rows"]) == (200, 200)
    assert "sheet Notes" in words
    assert "no rows below its header" in words


@pytest.mark.slow
def test_a_large_file_is_sampled(tmp_path, capsys, monkeypatch):
    """Beginning, middle and end: about the number of rows, spikes there, gaps only real ones."""
    monkeypatch.setattr("pmmkit.intake.file.LARGE", 100_000)
    monkeypatch.setattr("pmmkit.intake.file._PARTS", (20_000, 10_000, 10_000))
    table = record(20_000)
    table[-3, 2] = 777.0
    (tmp_path / "long.csv").write_text(text_of(table, head="t,X,Y,N\n"), encoding="utf-8")
    status, content, words = inspected(capsys, tmp_path / "long.csv", "--out", tmp_path / "seen")
    assert status == 0
    (group,) = content["groups"]
    assert group["sampled"]
    assert group["rows"] == pytest.approx(20_000, rel=0.02)
    assert group["clock"]["gaps"] == 0
    assert group["clock"]["even"]
    assert group["clock"]["duration"] == pytest.approx(1999.9)
    assert group["columns"][2]["max"] == 777.0
    assert "only beginning, middle and end were read" in words
    assert (tmp_path / "seen" / "inspect.png").is_file()


def test_thinning_keeps_every_spike():
    rng = np.random.default_rng(4)
    y = rng.normal(size=123_457)
    for place in (0, 50_000, 123_456):
        y[place] = 50.0 + place
    t, thin = envelope(np.arange(len(y), dtype=float), y)
    assert len(thin) < 4000
    assert {50.0, 50_050.0, 123_506.0} <= set(thin)
    assert thin.min() == y.min()
    assert np.all(np.diff(t) > 0)


# What goes wrong.


def test_an_unknown_layout_shows_its_first_lines(tmp_path, capsys):
    path = tmp_path / "odd.out"
    path.write_bytes(b"\x1b[31mStarted\x07\nsolver: ok\n" + b"x" * 500 + b"\n")
    assert main(["inspect", str(path)]) == 1
    said = capsys.readouterr().err
    assert "the layout is not known" in said
    assert "\\x1b[31mStarted\\x07" in said
    assert "\x1b" not in said
    assert "solver: ok" in said
    assert max(map(len, said.splitlines())) < 400
    assert "at least two rows of numbers" in said


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda folder: None, "It is empty."),
        (lambda folder: (folder / "a.png").write_bytes(b"\x89PNG"), "1 other files: 1 .png."),
        (lambda folder: (folder / "a.csv").write_bytes(b""), "a.csv: the file is empty (0 bytes)."),
    ],
)
def test_a_folder_without_measurements(make, said, tmp_path, capsys):
    make(tmp_path)
    assert main(["inspect", str(tmp_path)]) == 1
    words = capsys.readouterr().err
    assert "there are no measurements in this folder" in words
    assert said in words
    assert main(["new-campaign", str(tmp_path)]) == 1
    assert list(tmp_path.glob("*.toml")) == []


def test_nothing_there(tmp_path, capsys):
    assert main(["inspect", str(tmp_path / "gone")]) == 1
    assert "there is no such file or folder" in capsys.readouterr().err


def test_a_file_that_may_not_be_read_does_not_stop_the_others(tmp_path, capsys, monkeypatch):
    for name in ("good.csv", "secret.csv"):
        (tmp_path / name).write_text(text_of(record(), head="t,X,Y,N\n"), encoding="utf-8")
    allowed = Path.open

    def refused(self, *arguments, **more):
        if self.name == "secret.csv":
            raise PermissionError(13, "Permission denied", str(self))
        return allowed(self, *arguments, **more)

    monkeypatch.setattr(Path, "open", refused)
    status, content, _ = inspected(capsys, tmp_path)
    assert status == 0
    assert content["groups"][0]["files"] == ["good.csv"]
    assert content["problems"] == ["secret.csv: cannot be read: Permission denied."]
    assert main(["inspect", str(tmp_path / "secret.csv")]) == 1


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs named pipes")
def test_pipes_and_circles_of_links_do_not_hang(tmp_path, capsys):
    (tmp_path / "run.csv").write_text(text_of(record(), head="t,X,Y,N\n"), encoding="utf-8")
    os.mkfifo(tmp_path / "pipe.csv")
    (tmp_path / "again").symlink_to(tmp_path, target_is_directory=True)
    (tmp_path / "broken").symlink_to(tmp_path / "nowhere")
    status, content, _ = inspected(capsys, tmp_path)
    assert status == 0
    assert [group["files"] for group in content["groups"]] == [["run.csv"]]
    assert main(["inspect", str(tmp_path / "pipe.csv")]) == 1


def test_thousands_of_files_are_looked_at_in_part(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("pmmkit.intake.folder.MOST_FILES", 20)
    for number in range(50):
        (tmp_path / f"run_{number}.csv").write_text("t,X\n0,1\n1,2\n2,3\n", encoding="utf-8")
    _, content, words = inspected(capsys, tmp_path)
    assert len(content["groups"][0]["files"]) == 20
    assert content["passed_over"] == 30
    assert "30 more files were not looked at" in words


def test_a_damaged_file_alone_is_shown_with_what_is_wrong(tmp_path, capsys):
    lines = text_of(record(), head="t,X,Y,N\n").splitlines()
    lines[50] = "5.0,oops,1.0,2.0"
    lines[90] = lines[90] + ",9"
    (tmp_path / "run.csv").write_text("\n".join(lines), encoding="utf-8")
    status, content, words = inspected(capsys, tmp_path / "run.csv")
    assert status == 0
    assert "column X, row 51: 'oops' is not a number." in words
    assert "5 fields, too many" in words
    assert content["groups"][0]["rows"] == 199
    assert content["groups"][0]["columns"][1]["remark"] == "1 without a number"


# Measurements that others made.


def test_the_zigzags_of_hsva(shared_data, capsys):
    """Thirteen records without header: the velocities are the rates of positions and heading."""
    status, content, _ = inspected(capsys, shared_data / "kvlcc2_hsva_free")
    assert status == 0
    group = content["groups"][0]
    assert len(group["files"]) == 13
    assert group["source"]["skip_rows"] == 4
    assert group["clock"]["interval"] == pytest.approx(0.05)
    assert "the rate of column 2" in group["columns"][4]["remark"]
    assert "the rate of column 3" in group["columns"][5]["remark"]
    assert "the rate of column 4" in group["columns"][6]["remark"]
    assert content["groups"][1]["kind"] == "open water"


@pytest.mark.slow
def test_the_tables_of_hmri(shared_data, capsys):
    _, content, _ = inspected(capsys, shared_data / "kvlcc2_hmri_pmm")
    by_file = {group["files"][0]: group for group in content["groups"]}
    table = by_file["static_drift_rudder.csv"]
    assert table["kind"] == "table"
    names = [column["suggestion"] and column["suggestion"]["name"] for column in table["columns"]]
    assert names[1:8] == ["drift_deg", "rudder_deg", "speed", "propeller_rps", "X", "Y", "N"]
    book = "HMRI_KVLCC2_PMM_model_self_propulsion.xls, sheet Static Drift & Rudder Test"
    assert len(by_file[book]["columns"]) == 12


def test_the_records_of_the_esso_osaka(shared_data, capsys):
    _, content, _ = inspected(capsys, shared_data / "esso_osaka_free")
    (group,) = content["groups"]
    assert len(group["files"]) == 12
    assert set(suggestions(content)) == {
        "t",
        "x",
        "u",
        "y",
        "v",
        "psi",
        "r",
        "n",
        "delta",
        "wind_speed",
        "wind_direction",
    }


def test_an_error_of_a_single_file_is_ours(tmp_path):
    (tmp_path / "a.xlsx").write_bytes(b"PK\x03\x04" + b"\0" * 100)
    with pytest.raises(CampaignError):
        look(tmp_path / "a.xlsx")
