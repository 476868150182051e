"""MATLAB files: what scipy and MATLAB's own HDF5 layout hold comes out; bombs and damage do not."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import h5py
import numpy as np
import pytest
from container_files import (
    CHANNELS,
    as_matlab,
    cells,
    check_damage,
    headers,
    little_memory,
    matlab_cell,
    matlab_dataset,
    matlab_text,
    read,
    run_of,
    series,
    values,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy.io import loadmat, savemat

from pmmkit.base import CampaignError
from pmmkit.readers import READERS

COUNT = 40


def cellstr(*texts: str) -> np.ndarray:
    return np.array(texts, dtype=object)


@pytest.fixture(params=["5", "5 packed", "4", "7.3", "7.3 packed"])
def every_version(request, tmp_path) -> Path:
    """The same four vectors in each version of the format."""
    path, data = tmp_path / "run.mat", series(COUNT)
    if request.param.startswith("7.3"):
        how = {"chunks": (1, 16), "compression": "gzip"} if "packed" in request.param else {}

        def write(file: h5py.File) -> None:
            for name, vector in data.items():
                matlab_dataset(file, name, vector[:, None], **how)

        return as_matlab(path, write)
    version, _, packed = request.param.partition(" ")
    savemat(path, data, format=version, do_compression=bool(packed), oned_as="column")
    return path


def test_vectors_are_columns_in_every_version(every_version):
    found = values(every_version)
    assert set(found) == set(CHANNELS)
    for name, vector in series(COUNT).items():
        assert np.array_equal(found[name], vector)


def test_every_version_is_recognised_by_content(every_version, tmp_path):
    head = every_version.read_bytes()[:65536]
    assert READERS["matlab"].recognises(every_version, head)
    for other in (b"", b"t,X,Y,N\n0,1,2,3\n", bytes(200), head[512:], b"\x89HDF\r\n\x1a\n"):
        assert not READERS["matlab"].recognises(tmp_path / "other", other)


def test_a_run_of_a_campaign(every_version):
    data = run_of(every_version)
    assert np.array_equal(data["N"].values, series(COUNT)["N"])


@pytest.mark.slow
@given(
    array=hnp.arrays(
        dtype=st.sampled_from(
            ["f8", "f4", "i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "?", ">f8", ">i2"]
        ),
        shape=st.tuples(st.integers(2, 9), st.integers(2, 5)),
    ),
    packed=st.booleans(),
)
@settings(max_examples=60, deadline=None)
def test_any_matrix_is_what_scipy_reads(tmp_path_factory, array, packed):
    """Every numeric class; scipy is the other program."""
    path = tmp_path_factory.mktemp("m") / "m.mat"
    savemat(path, {"M": array}, do_compression=packed)
    truth = np.asarray(loadmat(path)["M"], dtype=float)
    usable = np.all(np.isfinite(truth)) and np.abs(truth).max() < 1e30
    if not usable:
        return
    found = values(path)
    longer = truth if truth.shape[0] >= truth.shape[1] else truth.T
    assert np.array_equal(np.column_stack(list(found.values())), longer)


def test_structs_have_dots_and_a_group_selects_one(tmp_path):
    path = tmp_path / "runs.mat"
    run1, run2 = series(COUNT, 1), series(COUNT, 2)
    savemat(path, {"run1": run1, "run2": {"data": run2}, "rho": 999.1})
    assert set(headers(path)) == {
        *(f"run1.{name}" for name in CHANNELS),
        *(f"run2.data.{name}" for name in CHANNELS),
    }
    assert np.array_equal(values(path, "X", group="run1")["X"], run1["X"])
    assert np.array_equal(values(path, "X", group="run2.data")["X"], run2["X"])
    with pytest.raises(CampaignError, match=r"no struct 'run3'; did you mean 'run1'\?.*run2\.data"):
        headers(path, group="run3")


def test_an_array_of_structs_is_counted_as_in_matlab(tmp_path):
    path = tmp_path / "runs.mat"
    runs = np.zeros((1, 2), dtype=[("t", object), ("X", object)])
    for place in range(2):
        for name in ("t", "X"):
            runs[0, place][name] = series(COUNT, place)[name]
    savemat(path, {"runs": runs})
    assert headers(path) == ("runs(1).t", "runs(1).X", "runs(2).t", "runs(2).X")
    assert np.array_equal(values(path, "X", group="runs(2)")["X"], series(COUNT, 1)["X"])


def test_structs_cells_and_arrays_of_structs_of_version_73(tmp_path):
    one, two = series(COUNT, 1), series(COUNT, 2)

    def write(file: h5py.File) -> None:
        group = file.create_group("run1")
        group.attrs["MATLAB_class"] = np.bytes_("struct")
        for name, vector in one.items():
            matlab_dataset(group, name, vector[:, None])
        matlab_text(group, "remark", "calm water")
        matlab_cell(file, file, "names", ["A", "B [kN]", "C"])
        matlab_dataset(file, "M", np.column_stack([two[name] for name in "XYN"]))
        array = file.create_group("runs")
        array.attrs["MATLAB_class"] = np.bytes_("struct")
        store = file["#refs#"]
        kept = [matlab_dataset(store, f"s{place}", two["X"][:, None] + place) for place in (1, 2)]
        array.create_dataset(
            "X", data=np.array([[item.ref for item in kept]], dtype=h5py.ref_dtype)
        )

    path = as_matlab(tmp_path / "run.mat", write)
    found = values(path)
    assert set(found) == {
        "A",
        "B [kN]",
        "C",
        "run1.t",
        "run1.X",
        "run1.Y",
        "run1.N",
        "runs(1).X",
        "runs(2).X",
    }
    assert np.array_equal(found["run1.N"], one["N"])
    assert np.array_equal(found["B [kN]"], two["Y"])
    assert np.array_equal(found["runs(2).X"], two["X"] + 2)


def test_a_matrix_takes_the_names_beside_it(tmp_path):
    path = tmp_path / "m.mat"
    data = series(COUNT)
    matrix = np.column_stack([data[name] for name in CHANNELS])
    savemat(path, {"data": matrix})
    assert headers(path) == ("data(1)", "data(2)", "data(3)", "data(4)")
    savemat(path, {"data": matrix, "names": cellstr("t", "X [kN]", "Y [kN]", "N [kNm]")})
    assert headers(path) == ("t", "X [kN]", "Y [kN]", "N [kNm]")
    assert np.array_equal(run_of(path)["X"].values, data["X"] * 1000.0)
    savemat(path, {"data": matrix, "names": cellstr(*"abcd"), "units": cellstr(*"efgh")})
    assert headers(path) == ("data(1)", "data(2)", "data(3)", "data(4)")


def test_a_matrix_lies_along_the_vectors_beside_it(tmp_path):
    """Three samples of forty channels, because the time has three values."""
    path = tmp_path / "m.mat"
    savemat(path, {"t": np.arange(3.0), "M": np.arange(120.0).reshape(3, 40)})
    found = values(path)
    assert len(found) == 41
    assert found["M(2)"].tolist() == [1.0, 41.0, 81.0]


def test_other_lengths_are_not_taken_unasked_but_can_be_asked_for(tmp_path):
    """x of three values is no channel of a run of forty; a fast channel is there if named."""
    path = tmp_path / "run.mat"
    savemat(path, {**series(COUNT), "x": [1.0, 2.0, 3.0], "raw": np.arange(900.0), "rho": 999.1})
    assert "x" not in run_of(path)
    assert "raw (900 values)" in headers(path)
    assert len(values(path, "raw (900 values)")["raw (900 values)"]) == 900
    with pytest.raises(CampaignError, match=r"t has 40, raw \(900 values\) has 900"):
        read(path, "t", "raw (900 values)")


def test_what_is_left_out_is_told_where_a_column_is_missed(tmp_path):
    path = tmp_path / "run.mat"
    savemat(path, {**series(COUNT), "rho": 999.1, "note": "calm", "Z": np.ones(9) * 1j})
    with pytest.raises(CampaignError) as caught:
        run_of(path, '[columns]\nX = "Fx"\n')
    text = str(caught.value)
    for word in ("'Fx'", "rho (a single number)", "note (a text)", "Z (complex numbers)"):
        assert word in text


def test_without_a_time_the_sample_rate_is_asked_for(tmp_path):
    path = tmp_path / "run.mat"
    data = series(COUNT)
    savemat(path, {name: data[name] for name in "XYN"})
    with pytest.raises(CampaignError, match="sample_rate = 200"):
        run_of(path)
    found = run_of(path, "[source]\nsample_rate = 50.0\n")
    assert np.allclose(found["t"].values, data["t"], rtol=0, atol=1e-12)
    assert "50 samples a second" in found.attrs["conversions"]
    savemat(path, data)
    with pytest.raises(CampaignError, match="has a column of time"):
        run_of(path, "[source]\nsample_rate = 50.0\n")
    assert run_of(path, "[source]\nsample_rate = 10.0\n[columns]\nt = false\n")["t"][10] == 1.0


def test_missing_values_are_told_with_their_rows(tmp_path):
    path = tmp_path / "run.mat"
    data = series(COUNT)
    data["Y"][[4, 7]] = np.nan
    data["N"][9] = 1e35
    savemat(path, data)
    with pytest.raises(CampaignError) as caught:
        run_of(path)
    text = str(caught.value)
    assert "column Y, row 5" in text
    assert "column Y, row 8" in text
    assert "column N, row 10" in text
    data["N"][9] = 0.0
    savemat(path, data)
    kept = run_of(path, '[source]\nmissing = "drop"\n')
    assert kept.sizes["t"] == COUNT - 2
    with pytest.raises(CampaignError, match="time is counted by rows"):
        run_of(path, '[source]\nmissing = "drop"\nsample_rate = 50.0\n[columns]\nt = false\n')


def element(kind: int, data: bytes) -> bytes:
    return struct.pack("<2I", kind, len(data)) + data + bytes(-len(data) % 8)


def version_5(*elements: bytes) -> bytes:
    return b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM" + b"".join(elements)


def opaque(name: bytes, kind: bytes) -> bytes:
    """How MATLAB writes a table: class 17, three names, then references into its own store."""
    parts = [element(6, struct.pack("<2I", 17, 0)), element(1, name), element(1, b"MCOS")]
    inner = [
        element(6, struct.pack("<2I", 13, 0)),
        element(5, struct.pack("<2i", 6, 1)),
        element(1, b""),
        element(6, struct.pack("<6I", 0xDD000000, 2, 1, 1, 1, 1)),
    ]
    return element(14, b"".join([*parts, element(1, kind), element(14, b"".join(inner))]))


def test_tables_and_times_of_matlab_are_refused_with_the_way_out(tmp_path):
    path = tmp_path / "run.mat"
    path.write_bytes(version_5(opaque(b"tt", b"timetable"), opaque(b"d", b"datetime")))
    with pytest.raises(CampaignError, match=r"tt \(timetable\), d \(datetime\).*timetable2table"):
        headers(path)

    def write(file: h5py.File) -> None:
        data = matlab_dataset(file, "ts", np.zeros((1, 6), dtype=np.uint32), "timeseries")
        data.attrs["MATLAB_object_decode"] = np.int32(3)

    as_matlab(path, write)
    with pytest.raises(CampaignError, match=r"ts \(timeseries\).*ts\.Time"):
        headers(path)


def test_a_file_of_scipy_with_an_object_beside_columns_reads(tmp_path):
    path = tmp_path / "run.mat"
    savemat(path, series(COUNT))
    path.write_bytes(path.read_bytes() + opaque(b"tt", b"timetable"))
    assert headers(path) == CHANNELS


def test_tables_of_runs_with_names_in_a_cell_array(tmp_path):
    path = tmp_path / "tests.mat"
    names = cellstr(*(f"SD{place}" for place in range(5)))
    savemat(path, {"Run": names, "Y": np.arange(5.0), "beta": np.arange(5.0) * 2, "rho": 1.0})
    table = cells(path)
    assert table.headers == ("Run", "Y", "beta")
    assert table.rows[3] == ("SD3", 3.0, 6.0)


def test_a_stream_that_expands_too_far_is_refused_before_it_does(tmp_path):
    """Declared: 3 GB. Not declared: 64 MB behind a variable that says it has 320 bytes."""
    path = tmp_path / "bomb.mat"
    tag = struct.pack("<2I", 14, 3_000_000_000)
    path.write_bytes(version_5(struct.pack("<2I", 15, 5000), zlib.compress(tag).ljust(5000, b"\0")))
    with little_memory(), pytest.raises(CampaignError, match="3,000,000,008 bytes"):
        headers(path)
    packed = zlib.compress(struct.pack("<2I", 14, 320) + bytes(64_000_000))
    path.write_bytes(version_5(struct.pack("<2I", 15, len(packed)), packed))
    with little_memory(), pytest.raises(CampaignError, match="not as long as it says"):
        headers(path)


def test_many_streams_that_together_expand_too_far(tmp_path):
    path = tmp_path / "bomb.mat"
    packed = zlib.compress(struct.pack("<2I", 14, 150_000_000) + bytes(1000))
    stream = struct.pack("<2I", 15, len(packed)) + packed
    path.write_bytes(version_5(stream, stream))
    with little_memory(), pytest.raises(CampaignError, match="300,000,016 bytes"):
        headers(path)


def test_version_4_with_more_values_than_bytes(tmp_path):
    path = tmp_path / "bomb.mat"
    path.write_bytes(struct.pack("<5i", 0, 2**31 - 1, 2**31 - 1, 0, 2) + b"X\0" + bytes(800))
    with little_memory(), pytest.raises(CampaignError, match="behind the end of the file"):
        headers(path)


def test_a_dataset_that_was_never_written_is_not_zeros(tmp_path):
    """Version 7.3: 8 GB declared in a file of 2 kB; and one that is small enough."""

    def write(file: h5py.File) -> None:
        for name in ("X", "Y"):
            item = file.create_dataset(name, shape=(1, 10**9), dtype="f8", chunks=(1, 1000))
            item.attrs["MATLAB_class"] = np.bytes_("double")
        item = file.create_dataset("t", shape=(1, 1000), dtype="f8", chunks=(1, 100))
        item.attrs["MATLAB_class"] = np.bytes_("double")

    path = as_matlab(tmp_path / "bomb.mat", write)
    with little_memory(), pytest.raises(CampaignError, match="8,000,000,000 bytes"):
        read(path, "X")
    with pytest.raises(CampaignError, match="should have 10 chunks, 0 are there"):
        read(path, "t (1000 values)")


@pytest.mark.slow
def test_damage(every_version):
    """Refused, or the right shape with no more wrong than the bytes that were damaged."""
    assert check_damage(every_version, CHANNELS, 150) > 20


@pytest.mark.parametrize(
    ("content", "word"),
    [
        (b"", "empty"),
        (b"# Created by Octave 8.4.0\n# name: t\n", "Octave"),
        (b"t,X,Y,N\n0,1,2,3\n", "not a MATLAB file"),
        (b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM" + b"\0" * 4, "left over"),
    ],
    ids=["empty", "octave", "text", "cut"],
)
def test_files_that_are_none(tmp_path, content, word):
    path = tmp_path / "run.mat"
    path.write_bytes(content)
    with pytest.raises(CampaignError, match=word):
        headers(path)
