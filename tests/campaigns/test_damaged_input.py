"""Damaged campaign files and histories: an error of ours, or the right answer."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from pmmkit import open_campaign
from pmmkit.base import CampaignError, DataError
from scripts.datasets.campaign_text import S175

ROWS = 240
TOML = (
    """[campaign]
title = "damage"
kind = "captive"
forces = "hydrodynamic"
"""
    + S175
    + """[[runs]]
id = "SD"
test = "static_drift"
file = "SD.csv"
speed = 1.5
drift_deg = 8.0
"""
)


@pytest.fixture(scope="module")
def good(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("good")
    rng = np.random.default_rng(0)
    t = np.arange(ROWS) * 0.1
    values = np.column_stack([t, *rng.normal(size=(3, ROWS)).round(4)])
    text = "t,X,Y,N\n" + "".join(",".join(f"{x:.4f}" for x in row) + "\n" for row in values)
    (folder / "SD.csv").write_bytes(text.encode())
    (folder / "campaign.toml").write_text(TOML, encoding="utf-8")
    return folder


def read(folder: Path):
    (run,) = open_campaign(folder).runs
    return run.data.load()


def damaged(good: Path, tmp_path: Path, name: str, data: bytes) -> Path:
    folder = tmp_path / "case"
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(good, folder)
    (folder / name).write_bytes(data)
    return folder


def outcome(folder: Path):
    """The data, or None after an error of ours; anything else is a failure."""
    try:
        return read(folder)
    except DataError:
        return None


def test_the_good_file_reads(good):
    assert read(good).sizes["t"] == ROWS


@pytest.mark.slow
def test_truncated_anywhere(good, tmp_path):
    """Cut inside a row: refused. Cut between rows: the rows before, all of them."""
    whole = (good / "SD.csv").read_bytes()
    reference = read(good)
    rng = np.random.default_rng(1)
    for cut in {*rng.integers(0, len(whole), 60).tolist(), 0, 1, 7, 8, len(whole) - 1}:
        data = outcome(damaged(good, tmp_path, "SD.csv", whole[:cut]))
        if data is None:
            continue
        rows = data.sizes["t"]
        assert rows == whole[:cut].rstrip(b"\n").count(b"\n")
        last = slice(0, rows - 1)
        for name in ("X", "Y", "N"):
            assert np.array_equal(data[name].values[last], reference[name].values[last])


@pytest.mark.slow
def test_flipped_bytes(good, tmp_path):
    """One byte changed: refused, or the same shape with no other number changed."""
    whole = bytearray((good / "SD.csv").read_bytes())
    reference = np.stack([read(good)[name].values for name in ("t", "X", "Y", "N")])
    rng = np.random.default_rng(2)
    for place, bit in zip(rng.integers(8, len(whole), 150), rng.integers(0, 8, 150), strict=True):
        broken = bytearray(whole)
        broken[place] ^= 1 << int(bit)
        data = outcome(damaged(good, tmp_path, "SD.csv", bytes(broken)))
        if data is None:
            continue
        found = np.stack([data[name].values for name in ("t", "X", "Y", "N")])
        assert found.shape == reference.shape
        assert np.sum(found != reference) <= 1


def test_columns_swapped_are_read_by_name(good, tmp_path):
    lines = (good / "SD.csv").read_text().splitlines()
    swapped = "\n".join(",".join(line.split(",")[i] for i in (2, 0, 3, 1)) for line in lines)
    data = outcome(damaged(good, tmp_path, "SD.csv", swapped.encode()))
    assert data is not None
    assert np.array_equal(data["Y"].values, read(good)["Y"].values)


@pytest.mark.parametrize(
    ("cell", "word"),
    [
        ("nan", "Y"),
        ("", "Y"),
        ("abc", "Y"),
        ("1e400", "Y"),
        ("1e35", "Y"),
        ("inf", "Y"),
        ("1;5", "Y"),
    ],
)
def test_bad_cells_are_named_with_row_and_column(good, tmp_path, cell, word):
    lines = (good / "SD.csv").read_text().splitlines()
    for row in (5, 17):
        parts = lines[row].split(",")
        parts[2] = cell
        lines[row] = ",".join(parts)
    folder = damaged(good, tmp_path, "SD.csv", "\n".join(lines).encode())
    with pytest.raises(CampaignError) as caught:
        read(folder)
    text = str(caught.value)
    assert "SD.csv" in text
    assert word in text
    assert "6" in text
    assert "18" in text


@pytest.mark.parametrize(
    "data",
    [b"", b"\n", b"t,X,Y,N\n", b"\x00" * 400, b"\xff\xfe" + b"t,X\n1,2\n" * 9, b"a,b\n1,2\n" * 20],
    ids=["0 bytes", "blank", "header only", "zeros", "wrong encoding", "foreign columns"],
)
def test_files_that_hold_no_history(good, tmp_path, data):
    with pytest.raises(CampaignError, match=r"SD\.csv"):
        read(damaged(good, tmp_path, "SD.csv", data))


@pytest.mark.parametrize("extra", [",9.9", ""], ids=["a field too many", "a field too few"])
def test_rows_of_another_length(good, tmp_path, extra):
    lines = (good / "SD.csv").read_text().splitlines()
    lines[9] = lines[9] + extra if extra else lines[9].rsplit(",", 1)[0]
    with pytest.raises(CampaignError, match="10"):
        read(damaged(good, tmp_path, "SD.csv", "\n".join(lines).encode()))


@pytest.mark.slow
def test_campaign_file_truncated_or_flipped(good, tmp_path):
    """No damage to campaign.toml leads anywhere but to our errors or to a campaign."""
    whole = TOML.encode()
    rng = np.random.default_rng(3)
    cases = [whole[:cut] for cut in rng.integers(0, len(whole), 60).tolist()]
    for place, value in zip(
        rng.integers(0, len(whole), 120), rng.integers(0, 256, 120), strict=True
    ):
        cases.append(whole[:place] + bytes([int(value)]) + whole[place + 1 :])
    for data in cases:
        folder = damaged(good, tmp_path, "campaign.toml", data)
        found = outcome(folder)
        assert found is None or found.sizes["t"] == ROWS


@pytest.mark.parametrize("data", [b"", b"\x00\x01\x02", "título".encode("utf-16")])
def test_campaign_files_that_are_none(good, tmp_path, data):
    with pytest.raises(DataError):
        open_campaign(damaged(good, tmp_path, "campaign.toml", data))


def test_all_problems_at_once(good, tmp_path):
    text = TOML.replace("speed = 1.5", "speed = -1.5").replace("mass = 454.476", "masss = 454.476")
    text = text.replace('"static_drift"', '"static_drfit"')
    text += '[[runs]]\nid = "b"\ntest = "resistance"\nfile = "none.csv"\nspeed = 1.0\n'
    with pytest.raises(CampaignError) as caught:
        open_campaign(damaged(good, tmp_path, "campaign.toml", text.encode()))
    message = str(caught.value)
    for word in (
        "masss",
        "did you mean 'mass'",
        "static_drfit",
        "static_drift",
        "speed",
        "none.csv",
    ):
        assert word in message
    assert len(caught.value.problems) >= 4
