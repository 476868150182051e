"""``[[matrix]]``: a table of tests says of each run what it was set to and where its history is."""

from __future__ import annotations

import math

import numpy as np
import openpyxl
import pytest
from small_campaign import HEAD

from pmmkit import open_campaign
from pmmkit.base import CampaignError

T = np.arange(0.0, 40.0, 0.05)
HEADER = ["Run", "Type", "Speed [m/s]", "Drift [deg]", "Period [s]", "Sway [mm]"]
TESTS = [
    [101, "Oblique", 1.2, -8.0, None, None],
    [102, "Oblique", 1.2, "-", "-", "-"],
    [103, "Swaying", 1.5, None, 8.0, 250.0],
    [104, "Calibration", None, None, None, None],
]
COLUMNS = (
    'columns = { speed = "Speed [m/s]", drift_deg = "Drift [deg]", period = "Period [s]", '
    'amplitude_m = "Sway [mm]" }\n'
)
WORDS = 'tests = { Oblique = "static_drift", Swaying = "pure_sway" }\n'


def history(number):
    """Forces that differ from run to run."""
    return np.column_stack([T, -20 + 0 * T, number * np.cos(0.5 * T), 0 * T])


def workbook(folder):
    """A sheet of the tests below a title, and a sheet for each run."""
    book = openpyxl.Workbook()
    sheet = book.active
    sheet.title = "Matrix"
    for row in (["Programme of hull 4711"], [], HEADER, *TESTS):
        sheet.append(row)
    for number, *_ in TESTS:
        sheet = book.create_sheet(f"Run {number}")
        for row in (["t", "X", "Y", "N"], *history(number).tolist()):
            sheet.append(row)
    book.save(folder / "tests.xlsx")


def opened(folder, matrix, *, before=""):
    (folder / "campaign.toml").write_text(HEAD + before + "[[matrix]]\n" + matrix, encoding="utf-8")
    return open_campaign(folder)


IN_A_WORKBOOK = (
    'file = "tests.xlsx"\nsource = { sheet = "Matrix" }\nid = "R{Run}"\ntest = "{Type}"\n'
    'run = "tests.xlsx"\nrun_sheet = "Run {Run}"\n'
)


def test_a_sheet_of_tests_and_a_sheet_for_each_run(tmp_path):
    workbook(tmp_path)
    found = opened(
        tmp_path,
        IN_A_WORKBOOK + WORDS + COLUMNS + "skip = [7]\n",
        before="[defaults.static_drift]\ndrift_deg = 0.0\n",
    )
    assert [run.id for run in found] == ["R101", "R102", "R103"]
    assert [run.test for run in found] == ["static_drift", "static_drift", "pure_sway"]
    assert found["R101"].settings.drift == pytest.approx(math.radians(-8))
    assert found["R102"].settings.drift == 0.0, "no value in the sheet: that of its kind"
    sway = found["R103"].settings
    assert (sway.speed, sway.period, sway.amplitude) == (1.5, 8.0, 0.25), "millimetres as metres"
    np.testing.assert_allclose(found["R103"].data["Y"], 103 * np.cos(0.5 * T))


def test_a_csv_file_of_tests_and_files_beside_it(tmp_path):
    lines = [
        ";".join("" if cell is None else str(cell).replace(".", ",") for cell in row)
        for row in (HEADER, *TESTS)
    ]
    (tmp_path / "tests.csv").write_text("\n".join(lines), encoding="utf-8")
    for number, *_ in TESTS:
        np.savetxt(tmp_path / f"run{number}.csv", history(number), delimiter=",", header="t,X,Y,N")
    found = opened(
        tmp_path,
        'file = "tests.csv"\nid = "{Run}"\ntest = "pure_sway"\nrun = "run{Run}.csv"\n'
        'where = { Type = "Swaying" }\n' + COLUMNS,
    )
    (run,) = found
    assert (run.id, run.source, run.settings.amplitude) == ("103", "run103.csv", 0.25)
    np.testing.assert_allclose(run.data["Y"], 103 * np.cos(0.5 * T))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("matrix", "said"),
    [
        (IN_A_WORKBOOK + COLUMNS, "'Oblique' is no kind of test"),
        (IN_A_WORKBOOK + COLUMNS + WORDS.replace("pure_sway", "pure_swey"), "'pure_sway'"),
        (IN_A_WORKBOOK.replace("{Run}", "{Ran}") + WORDS, "there is not exactly one column 'Ran'"),
        (IN_A_WORKBOOK + 'columns = { X = "Type" }\n', "'X' is no setting of a test"),
        (IN_A_WORKBOOK + 'columns = { period = "Type" }\n' + WORDS, "'Oblique' is not a number"),
        (IN_A_WORKBOOK.replace('"Run ', '"Lauf ') + WORDS + COLUMNS, "no sheet 'Lauf 102'"),
        (IN_A_WORKBOOK.replace("tests.xlsx", "test.xlsx"), "the file 'test.xlsx' is not there"),
        ('file = "tests.xlsx"\n', "is missing"),
    ],
)
def test_what_is_wrong_with_a_matrix_is_said(matrix, said, tmp_path):
    workbook(tmp_path)
    with pytest.raises(CampaignError) as raised:
        opened(tmp_path, matrix + "skip = [7]\n")
    assert said in str(raised.value)
