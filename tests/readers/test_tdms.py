"""LabVIEW files: what npTDMS wrote comes out; a file cut short never passes for a shorter one."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from container_files import (
    cells,
    check_damage,
    headers,
    little_memory,
    read,
    request_of,
    run_of,
    series,
    values,
)
from nptdms import ChannelObject, GroupObject, RootObject, TdmsWriter

from pmmkit.base import CampaignError
from pmmkit.readers import READERS, reader_for
from pmmkit.readers.tdms.reader import LEAD_IN

COUNT = 40
UNITS = {"X": "kN", "Y": "kN", "N": "kNm"}
WAVE = {"wf_increment": 0.02, "wf_start_offset": 0.0, "wf_samples": COUNT}


def channel(name: str, data: Any, group: str = "PMM", **properties: Any) -> ChannelObject:
    return ChannelObject(group, name, np.asarray(data), properties=properties)


def write(path: Path, *segments: list[Any]) -> Path:
    with TdmsWriter(path) as writer:
        for segment in segments:
            writer.write_segment(segment)
    return path


def forces(part: slice = slice(None), **properties: Any) -> list[Any]:
    data = series(COUNT)
    return [
        channel(name, data[name][part], unit_string=unit, **properties)
        for name, unit in UNITS.items()
    ]


@pytest.fixture
def run(tmp_path) -> Path:
    """Four segments of ten samples."""
    parts = [slice(start, start + 10) for start in range(0, COUNT, 10)]
    return write(tmp_path / "run.tdms", *(forces(part, **WAVE) for part in parts))


def test_channels_have_units_and_time_from_the_increment(run):
    assert headers(run) == ("X [kN]", "Y [kN]", "N [kNm]", "t [s]")
    data, truth = run_of(run), series(COUNT)
    assert np.allclose(data["t"].values, truth["t"], rtol=0, atol=1e-14)
    for name in "XYN":
        assert np.array_equal(data[name].values, truth[name] * 1000.0)
    assert "wf_increment = 0.02 s" in data.attrs["conversions"]


def test_it_is_recognised_by_content(run, tmp_path):
    assert READERS["tdms"].recognises(run, run.read_bytes()[:65536])
    assert reader_for(request_of(run)).name == "tdms"
    assert not READERS["tdms"].recognises(tmp_path / "run.tdms", b"t,X,Y,N\n")


def test_a_start_that_is_not_stated_is_zero_and_one_that_is_counts(tmp_path):
    path = tmp_path / "run.tdms"
    write(path, forces(wf_increment=0.5))
    assert run_of(path)["t"][:3].values.tolist() == [0.0, 0.5, 1.0]
    assert "wf_start_offset is not stated" in run_of(path).attrs["conversions"]
    write(path, forces(wf_increment=0.5, wf_start_offset=3.0))
    assert run_of(path)["t"][:3].values.tolist() == [3.0, 3.5, 4.0]


def test_without_increment_the_sample_rate_is_asked_for(tmp_path):
    path = write(tmp_path / "run.tdms", forces())
    with pytest.raises(CampaignError, match="sample_rate = 200"):
        run_of(path)
    assert run_of(path, "[source]\nsample_rate = 8.0\n")["t"][4] == 0.5


def test_a_sample_rate_that_contradicts_the_increment_is_refused(run):
    assert np.isclose(run_of(run, "[source]\nsample_rate = 50.0\n")["t"][5], 0.1)
    with pytest.raises(CampaignError, match="100 Hz is stated, wf_increment of the file says 50"):
        run_of(run, "[source]\nsample_rate = 100.0\n")


def test_a_channel_of_time_counts_before_increments(tmp_path):
    path = write(tmp_path / "run.tdms", [*forces(**WAVE), channel("t", np.arange(COUNT) * 0.5)])
    assert headers(path) == ("X [kN]", "Y [kN]", "N [kNm]", "t")
    assert run_of(path)["t"][1] == 0.5


def test_a_spectrum_is_not_a_history(tmp_path):
    path = write(tmp_path / "run.tdms", forces(**WAVE, wf_xunit_string="Hz"))
    assert "t [s]" not in headers(path)


def test_time_stamps_are_seconds_from_the_first(tmp_path):
    stamps = np.datetime64("2024-05-01T23:59:59.5") + np.arange(COUNT) * np.timedelta64(20, "ms")
    path = write(tmp_path / "run.tdms", [channel("Time", stamps), *forces()])
    data = run_of(path, '[columns]\nt = "Time"\n')
    assert np.allclose(data["t"].values, series(COUNT)["t"], rtol=0, atol=2e-6)


def test_groups_are_named_where_channels_are_not_unique(tmp_path):
    path = write(
        tmp_path / "runs.tdms",
        [
            channel("X", [1.0, 2.0], "run1"),
            channel("X", [3.0, 4.0, 5.0], "run2"),
            channel("depth", [6.0, 7.0, 8.0], "run2"),
        ],
    )
    assert headers(path) == ("run1/X", "run2/X", "depth")
    assert headers(path, group="run2") == ("X", "depth")
    assert values(path, "X", group="run1")["X"].tolist() == [1.0, 2.0]
    with pytest.raises(CampaignError, match=r"run1/X has 2, depth has 3"):
        read(path, "run1/X", "depth")
    with pytest.raises(CampaignError, match=r"no group 'run3'; did you mean.*It has run1, run2"):
        headers(path, group="run3")


def test_channels_sampled_differently_have_no_common_time(tmp_path):
    path = write(
        tmp_path / "run.tdms",
        [
            channel("X", [1.0, 2.0], wf_increment=0.1, wf_start_offset=0.0),
            channel("Y", [1.0, 2.0], wf_increment=0.2, wf_start_offset=0.0),
        ],
    )
    assert values(path, "Y", "t [s]")["t [s]"].tolist() == [0.0, 0.2]
    with pytest.raises(CampaignError, match=r"X every 0\.1 s from 0 s, Y every 0\.2 s"):
        read(path, "X", "Y", "t [s]")


SCALE = {
    "NI_Scaling_Status": "unscaled",
    "NI_Number_Of_Scales": 1,
    "NI_Scale[0]_Scale_Type": "Linear",
    "NI_Scale[0]_Linear_Slope": 2.0,
    "NI_Scale[0]_Linear_Y_Intercept": 10.0,
    "NI_Scale[0]_Linear_Input_Source": 0xFFFFFFFF,
}


def test_scales_are_applied_and_unknown_ones_refused(tmp_path):
    path = tmp_path / "run.tdms"
    write(path, [channel("X", np.array([1, 2, 3], dtype=np.int16), **SCALE)])
    assert values(path)["X"].tolist() == [12.0, 14.0, 16.0]
    write(path, [channel("X", [1.0, 2.0], **{**SCALE, "NI_Scale[0]_Scale_Type": "Magic"})])
    with pytest.raises(CampaignError, match="a scaling Magic"):
        headers(path)
    write(path, [channel("X", [1.0, 2.0], **{**SCALE, "NI_Number_Of_Scales": 2**31 - 1})])
    with little_memory(), pytest.raises(CampaignError, match="2147483647 scalings"):
        headers(path)


def test_texts_stand_in_tables_and_are_told_where_a_channel_is_missed(tmp_path):
    path = write(
        tmp_path / "tests.tdms",
        [
            RootObject({"author": "tank"}),
            GroupObject("PMM"),
            channel("Run", ["SD1", "SD2"]),
            channel("Y", [1.0, 2.0]),
        ],
    )
    table = cells(path)
    assert table.headers == ("Run", "Y")
    assert table.rows == (("SD1", 1.0), ("SD2", 2.0))
    with pytest.raises(CampaignError, match=r"left out.*PMM/Run \(texts\)"):
        run_of(path)


@pytest.mark.slow
def test_cut_short_anywhere_it_is_refused(run):
    """npTDMS takes what is left for the whole; a cut between segments cannot be seen."""
    whole = run.read_bytes()
    ends = {0}
    while max(ends) < len(whole):
        (length,) = struct.unpack_from("<Q", whole, max(ends) + 12)
        ends.add(max(ends) + LEAD_IN + length)
    assert len(ends) == 5
    for cut in range(1, len(whole), 7):
        run.write_bytes(whole[:cut])
        if cut in ends:
            continue
        with pytest.raises(CampaignError, match=r"run\.tdms"):
            headers(run)


def unfinished(path: Path, lost: int) -> None:
    """The last segment as a logger leaves it that stopped: no length, some bytes not written."""
    data = bytearray(path.read_bytes())
    place = 0
    while place + LEAD_IN + struct.unpack_from("<Q", data, place + 12)[0] < len(data):
        place += LEAD_IN + struct.unpack_from("<Q", data, place + 12)[0]
    data[place + 12 : place + 20] = b"\xff" * 8
    path.write_bytes(data[: len(data) - lost])


def test_a_segment_never_finished_is_read_to_its_last_whole_sample(run):
    """Channels lie one after the other: 20 bytes lost are two and a half values of the last."""
    truth = series(COUNT)
    unfinished(run, 20)
    data = run_of(run)
    assert data.sizes["t"] == COUNT - 3
    for name in "XYN":
        assert np.array_equal(data[name].values, truth[name][: COUNT - 3] * 1000.0)
    assert "never finished" in data.attrs["conversions"]
    assert "3 less" in data.attrs["conversions"]


def test_a_segment_that_lost_a_whole_channel(run):
    unfinished(run, 10 * 8 + 8)
    assert run_of(run).sizes["t"] == COUNT - 10


def test_a_segment_without_its_length_that_is_complete(run):
    unfinished(run, 0)
    assert run_of(run).sizes["t"] == COUNT


def test_a_number_of_values_that_does_not_fit_the_segment(run):
    """Ten values of X become fourteen: npTDMS would share the bytes out anew."""
    data = bytearray(run.read_bytes())
    place = data.index(struct.pack("<IIQ", 10, 1, 10))
    data[place + 8] = 14
    run.write_bytes(data)
    with pytest.raises(CampaignError, match="does not hold what it declares"):
        headers(run)


@pytest.mark.parametrize("finished", [True, False])
def test_a_number_of_values_no_memory_can_hold(tmp_path, finished):
    path = write(tmp_path / "bomb.tdms", [channel("X", np.arange(10.0))])
    data = bytearray(path.read_bytes())
    place = data.index(struct.pack("<IIQ", 10, 1, 10))
    struct.pack_into("<Q", data, place + 8, 2**40)
    if not finished:
        data[12:20] = b"\xff" * 8
    path.write_bytes(data)
    with little_memory(), pytest.raises(CampaignError, match=r"declares|8,796,093,022,208 bytes"):
        headers(path)


def test_an_index_file_beside_it_is_not_believed(run):
    """LabVIEW writes run.tdms_index; npTDMS would take the sizes from it."""
    Path(f"{run}_index").write_bytes(b"TDSh" + bytes(200))
    assert run_of(run).sizes["t"] == COUNT


def test_raw_data_of_daqmx_are_refused(run):
    data = bytearray(run.read_bytes())
    data[4] |= 0x80
    run.write_bytes(data)
    with pytest.raises(CampaignError, match="DAQmx"):
        headers(run)


def test_damage(run):
    assert check_damage(run, ("X [kN]", "Y [kN]", "N [kNm]", "t [s]"), 150) > 50


@pytest.mark.parametrize("content", [b"", b"TDSm", b"TDSm" + bytes(24), b"TDSm" + b"\xff" * 60])
def test_files_that_are_none(tmp_path, content):
    path = tmp_path / "run.tdms"
    path.write_bytes(content)
    with pytest.raises(CampaignError, match=r"run\.tdms"):
        headers(path)
