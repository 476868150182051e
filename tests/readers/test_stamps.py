"""Time stamps of ships' recorders: dates and clocks as seconds since the first row."""

from __future__ import annotations

from datetime import datetime, timedelta

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pmmkit.base import CampaignError
from pmmkit.readers import READERS, Options, Request
from pmmkit.readers.text.stamps import elapsed, is_stamp, seconds_of

FORMS = {
    "ISO": "%Y-%m-%dT%H:%M:%S.%fZ",
    "ISO with a blank": "%Y-%m-%d %H:%M:%S.%f",
    "German": "%d.%m.%Y %H:%M:%S.%f",
    "afternoon": "%Y/%m/%d %I:%M:%S.%f %p",
    "clock alone": "%H:%M:%S.%f",
}


@pytest.mark.parametrize("form", FORMS.values(), ids=FORMS)
@given(
    start=st.datetimes(min_value=datetime(1990, 1, 1), max_value=datetime(2060, 1, 1)),
    steps=st.lists(st.integers(0, 3_600_000), min_size=2, max_size=40),
)
def test_seconds_are_those_between_the_instants(form, start, steps):
    millis = np.cumsum([0, *steps])
    written = [(start + timedelta(milliseconds=int(x))).strftime(form) for x in millis]
    assert all(map(is_stamp, written))
    found = elapsed(seconds_of(pd.Series(written)))
    assert found == pytest.approx(millis / 1000.0, abs=1e-5)


def test_a_month_beyond_twelve_is_a_day():
    written = ["05/13/2024 23:59:59", "05/14/2024 00:00:01"]
    assert elapsed(seconds_of(pd.Series(written))).tolist() == [0.0, 2.0]


def record(count=300):
    start = datetime(2024, 12, 31, 23, 58)
    stamps = [(start + timedelta(seconds=0.5 * k)).isoformat() for k in range(count)]
    return [f"{stamp},{0.1 * k:.1f},{-k}" for k, stamp in enumerate(stamps)]


def read(path):
    request = Request(path=path, shown=path.name, options=Options(format="csv"))
    return READERS["csv"].columns(request, lambda *_: (0, 1))


def test_a_column_of_stamps_is_seconds_of_a_record(tmp_path):
    file = tmp_path / "log.csv"
    file.write_text("\n".join(["UTC,x,y", *record(), ""]))
    t, x = read(file).values
    assert t == pytest.approx(0.5 * np.arange(300), abs=1e-6)
    assert x == pytest.approx(0.1 * np.arange(300))


def test_quotes_and_pieces_give_the_same(tmp_path, monkeypatch):
    file, quoted = tmp_path / "log.csv", tmp_path / "quoted.csv"
    rows = record(4000)
    file.write_text("\n".join(["UTC,x,y", *rows, ""]))
    quoted.write_text(
        "\n".join(["UTC,x,y", *(f'"{x}"'.replace(",", '",', 1)[:-1] for x in rows), ""])
    )
    whole = read(file).values[0]
    assert read(quoted).values[0].tolist() == whole.tolist()
    monkeypatch.setattr("pmmkit.readers.text.splitting.BLOCK", 4096)
    assert read(file).values[0].tolist() == whole.tolist()


def test_a_damaged_stamp_is_told_with_its_row(tmp_path):
    rows = record()
    rows[7] = rows[7].replace("T", "x", 1)
    file = tmp_path / "log.csv"
    file.write_text("\n".join(["UTC,x,y", *rows, ""]))
    with pytest.raises(CampaignError, match="row 9"):
        read(file)
