"""Workbooks with a sheet per run, and tables that list the tests: what a draft makes of them."""

from __future__ import annotations

import math

import numpy as np
import openpyxl
import pytest
from test_new_campaign import drafted, filled_in

from pmmkit import open_campaign
from pmmkit.intake import look

T = np.arange(0.0, 30.0, 0.1)
TESTS = [
    (101, "Schrägschlepp", 1.2, -8.0, None, None),
    (102, "Schrägschlepp", 1.2, 4.0, None, None),
    (103, "Querschwingen", 1.2, None, 8.0, 0.25),
    (104, "Querschwingen", 1.5, None, 10.0, 0.3),
]
HEADER = ["Nr.", "Versuch", "Geschwindigkeit [m/s]", "Driftwinkel [deg]", "Periode [s]"]


def history(number):
    return np.column_stack([T, -20 + 0 * T, number * np.cos(0.5 * T), np.sin(0.5 * T)])


def in_sheets(folder, names, *, matrix=True, tests=TESTS):
    book = openpyxl.Workbook()
    book.remove(book.active)
    if matrix:
        sheet = book.create_sheet("Programm")
        for row in (["Modell 4711"], [], [*HEADER, "Amplitude [m]"], *tests):
            sheet.append(list(row))
    for number, name in names.items():
        sheet = book.create_sheet(name)
        for row in (["Zeit [s]", "Längskraft [N]", "Querkraft [N]", "Giermoment [Nm]"],):
            sheet.append(row)
        for row in history(number).tolist():
            sheet.append(row)
    book.save(folder / "tests.xlsx")


def as_listed(found, ids):
    assert [run.id for run in found] == list(ids)
    for run, (_, kind, speed, drift, period, amplitude) in zip(found, TESTS, strict=False):
        assert run.test == {"Sch": "static_drift", "Que": "pure_sway"}[kind[:3]]
        assert run.settings.speed == speed
        assert run.settings.drift == pytest.approx(math.radians(drift or 0.0))
        assert (run.settings.period, run.settings.amplitude) == (period, amplitude)
        number = int(run.id[-3:])
        np.testing.assert_allclose(run.data["Y"], number * np.cos(0.5 * T))


def test_a_sheet_of_tests_gives_all_runs(tmp_path, capsys):
    in_sheets(tmp_path, {number: f"V {number}" for number, *_ in TESTS})
    status, content, _ = drafted(capsys, tmp_path)
    assert (status, content["complete"]) == (0, 4)
    filled_in(tmp_path)
    as_listed(open_campaign(tmp_path), [f"V {number}" for number, *_ in TESTS])


def test_a_text_file_of_tests_gives_all_runs_beside_it(tmp_path, capsys):
    lines = [";".join([*HEADER, "Amplitude [m]"])]
    lines += [";".join("" if cell is None else str(cell) for cell in row) for row in TESTS]
    (tmp_path / "programm.csv").write_bytes("\n".join(lines).replace(".", ",").encode("cp1252"))
    (tmp_path / "daten").mkdir()
    for number, *_ in TESTS:
        np.savetxt(
            tmp_path / "daten" / f"messung_{number}.csv",
            history(number),
            delimiter=",",
            header="t,X,Y,N",
            comments="",
        )
    drafted(capsys, tmp_path)
    filled_in(tmp_path)
    text = (tmp_path / "campaign.toml").read_text(encoding="utf-8")
    assert "[[runs]]" not in text
    as_listed(open_campaign(tmp_path), [f"messung_{number}" for number, *_ in TESTS])


def test_rows_without_a_run_and_runs_without_a_row(tmp_path, capsys):
    listed = {101: "V 101", 103: "V 103", 104: "V 104", 900: "Kalibrierung"}
    in_sheets(tmp_path, listed)
    _, content, words = drafted(capsys, tmp_path)
    assert {run["id"] for run in content["runs"]} == set(listed.values())
    assert "test: Kalibrierung" in words
    filled_in(tmp_path)
    path = tmp_path / "campaign.toml"
    text = path.read_text(encoding="utf-8")
    assert "skip = [5]" in text
    path.write_text(
        text.replace("# test = ...", 'test = "resistance"\n#').replace(
            "# speed = ...", "speed = 1.0\n#"
        ),
        encoding="utf-8",
    )
    found = open_campaign(tmp_path)
    assert {run.id for run in found} == set(listed.values())


def test_a_word_that_nobody_knows_is_asked_for(tmp_path, capsys):
    tests = [*TESTS, (105, "Versuch Nr. 5", 1.2, 0.0, None, None)]
    in_sheets(tmp_path, {number: f"V {number}" for number, *_ in tests}, tests=tests)
    _, content, words = drafted(capsys, tmp_path)
    assert "which kind of test is 'Versuch Nr. 5'" in words
    assert content["runs"][-1]["test"] is None


def test_sheets_alone_are_runs_named_after_them(tmp_path, capsys):
    in_sheets(tmp_path, {1: "SD_U1.2_b+04", 2: "SD_U1.2_b-08"}, matrix=False)
    status, content, _ = drafted(capsys, tmp_path)
    assert (status, content["complete"]) == (0, 2)
    filled_in(tmp_path)
    one, two = open_campaign(tmp_path)
    assert (one.id, round(math.degrees(two.settings.drift), 9)) == ("SD_U1.2_b+04", -8.0)
    np.testing.assert_allclose(two.data["Y"], 2 * np.cos(0.5 * T))


@pytest.mark.slow
def test_each_sheet_of_a_workbook_is_gone_through_a_few_times_at_most(tmp_path, monkeypatch):
    """Its cost grows with the sheets, not with their square."""
    from pmmkit.readers.excel import reader

    in_sheets(tmp_path, {number: f"V {number}" for number in range(30)}, matrix=False)
    read = []
    grid = reader._grid
    monkeypatch.setattr(reader, "_grid", lambda request: read.append(1) or grid(request))
    (group,) = look(tmp_path).groups
    assert len(group.files) == 30
    assert len(read) <= 2 * 30


@pytest.mark.parametrize(
    ("cell", "name"),
    [(lambda n: f"{n:04d}", "Run{}"), (lambda n: n, "Run0{}"), (lambda n: f"{n:05d}", "V 0{}")],
    ids=["padded in the list", "padded in the sheets", "padded otherwise"],
)
def test_zeros_before_a_number_make_no_other_number(tmp_path, capsys, cell, name):
    """0101 in the list against Run101 as the name of a sheet, and the reverse."""
    tests = [(cell(number), *rest) for number, *rest in TESTS]
    names = [name.format(number) for number, *_ in TESTS]
    in_sheets(tmp_path, dict(zip([n for n, *_ in TESTS], names, strict=True)), tests=tests)
    status, content, _ = drafted(capsys, tmp_path)
    assert (status, content["complete"]) == (0, 4)
    filled_in(tmp_path)
    as_listed(open_campaign(tmp_path), names)


def test_zeros_before_a_number_in_the_names_of_files(tmp_path, capsys):
    lines = [";".join([*HEADER, "Amplitude [m]"])]
    lines += [";".join("" if cell is None else str(cell) for cell in row) for row in TESTS]
    (tmp_path / "programm.csv").write_bytes("\n".join(lines).replace(".", ",").encode("cp1252"))
    for number, *_ in TESTS:
        columns = {"delimiter": ",", "header": "t,X,Y,N", "comments": ""}
        np.savetxt(tmp_path / f"Run00{number}.csv", history(number), **columns)
    drafted(capsys, tmp_path)
    filled_in(tmp_path)
    as_listed(open_campaign(tmp_path), [f"Run00{number}" for number, *_ in TESTS])


@pytest.mark.parametrize("own", [True, False], ids=["a list in each", "one list for both"])
def test_runs_in_sheets_of_several_workbooks(tmp_path, capsys, own):
    """Two workbooks; the list of tests stands in each of them, or in the first for both."""
    for name, part in (("eins", TESTS[:2]), ("zwei", TESTS[2:])):
        tests = part if own else TESTS
        names = {number: f"V {number}" for number, *_ in part}
        in_sheets(tmp_path, names, tests=tests, matrix=own or name == "eins")
        (tmp_path / "tests.xlsx").rename(tmp_path / f"{name}.xlsx")
    status, content, _ = drafted(capsys, tmp_path)
    assert (status, content["complete"]) == (0, 4)
    filled_in(tmp_path)
    as_listed(open_campaign(tmp_path), [f"V {number}" for number, *_ in TESTS])


def test_the_same_sheets_in_two_workbooks_are_named_after_them(tmp_path, capsys):
    for name in ("eins", "zwei"):
        in_sheets(tmp_path, {number: f"V {number}" for number, *_ in TESTS})
        (tmp_path / "tests.xlsx").rename(tmp_path / f"{name}.xlsx")
    drafted(capsys, tmp_path)
    filled_in(tmp_path)
    found = [run.id for run in open_campaign(tmp_path)]
    assert found == [f"{book}_V {n}" for book in ("eins", "zwei") for n, *_ in TESTS]
