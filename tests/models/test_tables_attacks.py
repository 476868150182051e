"""Tables that are made to do harm: refused soon, with what is wrong."""

from __future__ import annotations

import zipfile

import numpy as np
import openpyxl
import pytest

import pmmkit as pk
from pmmkit.base import TableError
from pmmkit.models import from_values


@pytest.fixture
def table():
    return from_values({"Yv": -0.01}, ship=pk.load_model("kvlcc2-l7").ship, water=pk.Water())


@pytest.mark.slow
def test_a_cell_at_the_far_end_of_a_sheet(table, tmp_path):
    pk.export(table, tmp_path / "t.xlsx")
    book = openpyxl.load_workbook(tmp_path / "t.xlsx")
    book["covariance"].cell(1048576, 16384, "x")
    book.save(tmp_path / "t.xlsx")
    with pytest.raises(TableError, match="more than 5,000,000 cells"):
        pk.read_table(tmp_path / "t.xlsx")


@pytest.mark.slow
def test_a_workbook_that_unpacks_to_gigabytes(table, tmp_path):
    pk.export(table, tmp_path / "t.xlsx")
    with zipfile.ZipFile(tmp_path / "t.xlsx", "a", zipfile.ZIP_DEFLATED) as parts:
        for number in range(2):
            parts.writestr(f"xl/more{number}.xml", bytes(251_000_000))
    assert (tmp_path / "t.xlsx").stat().st_size < 1_000_000
    with pytest.raises(TableError, match="more than 500,000,000 bytes"):
        pk.read_table(tmp_path / "t.xlsx")


@pytest.mark.parametrize("method", ["\x0b", "\ud800", "a" * 40_000])
def test_a_method_that_no_cell_holds(method, table, tmp_path):
    named = table.with_(method=np.array([[method]]))
    with pytest.raises(TableError, match="a workbook does not hold"):
        pk.export(named, tmp_path / "t.xlsx")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("ending", ["csv", "nc"])
def test_a_method_that_is_no_text(ending, table, tmp_path):
    named = table.with_(method=np.array([["\ud800"]]))
    with pytest.raises(TableError, match="no text in UTF-8"):
        pk.export(named, tmp_path / f"t.{ending}")
    assert list(tmp_path.iterdir()) == []
