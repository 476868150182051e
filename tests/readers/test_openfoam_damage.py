"""Damaged files of OpenFOAM: an error of ours that names the row, or the right answer."""

from __future__ import annotations

import re
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from foam_texts import esi, every, foundation, notes, numbers, total, written

from pmmkit.base import CampaignError
from pmmkit.readers.openfoam import header as parsing
from pmmkit.readers.openfoam.header import layout_of

T, PARTS = numbers()


GOOD = {
    "nested": {"forces.dat": foundation(T, PARTS)},
    "flat": {"force.dat": esi(T, PARTS, "F", brackets=False)},
}


@pytest.fixture(params=GOOD.values(), ids=list(GOOD))
def good(request, tmp_path):
    """A file, its bytes and what it should give."""
    (name,) = request.param
    file = written(tmp_path, request.param) / name
    return file, file.read_bytes(), np.stack(list(every(file).values()))


def outcome(file: Path) -> np.ndarray | None:
    """All numbers, or None after an error of ours."""
    try:
        return np.stack(list(every(file).values()))
    except CampaignError:
        return None


@pytest.mark.slow
def test_truncated_anywhere(good):
    """The whole rows before the cut, or an error of ours: never a row in part."""
    file, whole, reference = good
    rng = np.random.default_rng(1)
    header = whole.count(b"#")
    lengths = set()
    for cut in {*rng.integers(0, len(whole), 80).tolist(), 0, 1, len(whole) - 1, len(whole)}:
        file.write_bytes(whole[:cut])
        table = outcome(file)
        if table is None:
            assert whole[:cut].count(b"\n") <= header
            continue
        rows = table.shape[1]
        assert rows == whole[:cut].count(b"\n") - header or cut == len(whole) - 1
        assert np.array_equal(table, reference[:, :rows])
        lengths.add(rows)
    assert len(lengths) > 10


def test_a_last_row_that_is_cut_off_is_noted(tmp_path):
    text = foundation(T, PARTS)
    written(tmp_path, {"forces.dat": text[:-30]})
    assert len(every(tmp_path)["Time [s]"]) == len(T) - 1
    assert "forces.dat: the last row is cut off" in notes(tmp_path)
    written(tmp_path, {"forces.dat": text[:-1]})
    assert len(every(tmp_path)["Time [s]"]) == len(T)


@pytest.mark.slow
def test_flipped_bytes(good):
    """One bit changed in the rows: refused, or no more than one number and its sum changed."""
    file, whole, reference = good
    rng = np.random.default_rng(2)
    start = layout_of(whole).start
    seen = 0
    for place, bit in zip(
        rng.integers(start, len(whole), 250), rng.integers(0, 8, 250), strict=True
    ):
        broken = bytearray(whole)
        broken[place] ^= 1 << int(bit)
        file.write_bytes(bytes(broken))
        table = outcome(file)
        if table is None:
            continue
        rows = table.shape[1]
        assert rows >= reference.shape[1] - 1
        assert np.sum(table != reference[:, :rows]) <= 2
        seen += 1
    assert seen > 10


def test_a_total_that_is_not_the_sum_of_its_parts(tmp_path):
    """Exchanged columns or a damaged digit show in the total that OpenCFD writes."""
    text = esi(T, PARTS, "F", brackets=False)
    swapped = text.replace("total_x total_y", "total_y total_x", 1)
    with pytest.raises(CampaignError, match="is not the sum of its parts"):
        every(written(tmp_path, {"force.dat": swapped}))
    whole = (
        text.replace("total_x total_y", "total_y total_x")
        .replace("pressure_x pressure_y", "pressure_y pressure_x")
        .replace("viscous_x viscous_y", "viscous_y viscous_x")
    )
    found = every(written(tmp_path, {"force.dat": whole}))
    assert found["Fx [N]"] == pytest.approx(total("F", 1, ("pressure", "viscous")), abs=1e-4)


@pytest.mark.parametrize(
    ("cell", "words"),
    [
        ("nan", "no value"),
        ("-inf", "infinite"),
        ("1e400", "infinite"),
        ("1.0e+45", "absurdly large"),
        ("abc", "not a number"),
        ("1,5", "not a number"),
        ("1 2", "too many"),
        ("", "too few"),
        ("(1", "brackets"),
        ("1\x002", "zero bytes"),
        ("ü", "not a number"),
    ],
)
def test_bad_cells_are_named_with_row_and_column(cell, words, tmp_path):
    rows = foundation(T, PARTS).splitlines(keepends=True)
    for row in (7, 20):
        fields = rows[row].split(" ")
        rows[row] = " ".join([*fields[:-2], cell, fields[-1]])
    written(tmp_path, {"forces.dat": "".join(rows)})
    with pytest.raises(CampaignError, match=words) as caught:
        every(tmp_path)
    assert "row 8" in str(caught.value)
    assert "row 21" in str(caught.value)
    if words in ("no value", "infinite", "not a number"):
        assert "column My_viscous [N m]" in str(caught.value)


def test_rows_without_a_value_may_be_left_out(tmp_path):
    rows = foundation(T, PARTS).splitlines(keepends=True)
    rows[7] = re.sub(r"\S+\)\)\n", "nan))\n", rows[7])
    written(tmp_path, {"forces.dat": "".join(rows)})
    table = every(tmp_path, missing="drop")
    assert len(table["Time [s]"]) == len(T) - 1


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"\n\n",
        b"\0" * 500,
        foundation(T, PARTS).encode("utf-16"),
        foundation(T, PARTS)[:40].encode(),
        foundation(T, PARTS).encode()[150:],
        "".join(foundation(T, PARTS).splitlines(keepends=True)[:3]).encode(),
        b"\xff\xfe\x00\x01" * 99,
    ],
    ids=["0 bytes", "blank", "zeros", "utf-16", "half a header", "no header", "header", "junk"],
)
def test_files_that_hold_no_history(data, tmp_path):
    path = tmp_path / "forces.dat"
    path.write_bytes(data)
    for place in (path, tmp_path):
        with pytest.raises(CampaignError):
            every(place)


def test_line_ends_and_marks_of_other_machines(tmp_path):
    text = foundation(T, PARTS)
    reference = np.stack(list(every(written(tmp_path / "a", {"forces.dat": text})).values()))
    for name, data in {
        "crlf": text.replace("\n", "\r\n").encode(),
        "bom": b"\xef\xbb\xbf" + text.encode(),
        "cp1252": text.replace("# Forces", "# Kräfte", 1).encode("cp1252"),
        "zeros at the end": text.encode() + b"\0" * 4096,
        "blank lines at the end": text.encode() + b"\n\n \n",
    }.items():
        path = tmp_path / f"{name}.dat"
        path.write_bytes(data)
        assert np.array_equal(np.stack(list(every(path).values())), reference), name


def test_blocks_make_no_difference(tmp_path, monkeypatch):
    text = foundation(T, PARTS)
    folder = written(tmp_path, {"forces.dat": text[:-5]})
    reference = every(folder)
    for size in (211, 1000, len(text) - 5):
        monkeypatch.setattr(parsing, "BLOCK", size)
        found = every(folder)
        assert all(np.array_equal(found[name], reference[name]) for name in reference)


def test_memory_stays_within_a_few_times_the_file(tmp_path):
    row = " ".join(["-1.234567e+02"] * 9)
    head = esi(T[:1], PARTS, "F", brackets=False).splitlines(keepends=True)[:4]
    head[3] = head[3].replace("total", "other")
    lines = "".join(f"{t * 0.001:<14.8g} {row}\n" for t in range(1, 40000))
    path = tmp_path / "force.dat"
    path.write_bytes(("".join(head) + lines).encode())
    every(path)
    tracemalloc.start()
    every(path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 4 * path.stat().st_size
