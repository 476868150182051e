"""HDF5 and NetCDF of any origin: what h5py, xarray and scipy wrote comes out."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray as xr
from container_files import (
    CHANNELS,
    cells,
    check_damage,
    damaged_versions,
    headers,
    little_memory,
    read,
    request_of,
    run_of,
    series,
    values,
)
from scipy.io import netcdf_file

from pmmkit import open_campaign, save_campaign
from pmmkit.base import CampaignError, PmmkitError
from pmmkit.readers import READERS, reader_for
from pmmkit.readers.hdf5 import datasets as hdf5_guard

COUNT = 40
UNITS = {"t": "s", "X": "kN", "Y": "kN", "N": "kNm"}


def plain(path: Path, **how) -> Path:
    with h5py.File(path, "w") as file:
        for name, vector in series(COUNT).items():
            file.create_dataset(name, data=vector, **how).attrs["units"] = UNITS[name]
    return path


def netcdf4(path: Path) -> Path:
    data = series(COUNT)
    dataset = xr.Dataset(
        {name: ("t", data[name], {"units": UNITS[name], "long_name": "a force"}) for name in "XYN"},
        coords={"t": ("t", data["t"], {"units": "seconds since 2024-05-01 10:00:00"})},
    )
    dataset.to_netcdf(path, engine="h5netcdf", encoding={"X": {"zlib": True, "shuffle": True}})
    return path


def classic(path: Path, version: int = 1, *, records: bool = False) -> Path:
    data = series(COUNT)
    with netcdf_file(path, "w", version=version) as file:
        file.title = "a run"
        file.createDimension("t", None if records else COUNT)
        for name, vector in data.items():
            variable = file.createVariable(name, "d", ("t",))
            variable[:] = vector
            variable.units = UNITS[name]
    return path


MAKERS = {
    "plain": lambda folder: plain(folder / "run.h5"),
    "packed": lambda folder: plain(
        folder / "run.hdf5", chunks=(16,), compression="gzip", shuffle=True
    ),
    "other filters": lambda folder: plain(
        folder / "run.hdf5", chunks=(16,), compression="lzf", fletcher32=True
    ),
    "NetCDF 4": lambda folder: netcdf4(folder / "run.nc"),
    "NetCDF 1": lambda folder: classic(folder / "run.nc"),
    "NetCDF 2": lambda folder: classic(folder / "run.nc", 2),
    "records": lambda folder: classic(folder / "run.nc", records=True),
}


@pytest.fixture(params=MAKERS)
def every_kind(request, tmp_path) -> Path:
    return MAKERS[request.param](tmp_path)


def test_every_kind_reads_with_its_units(every_kind):
    assert set(headers(every_kind)) == {f"{name} [{unit}]" for name, unit in UNITS.items()}
    data, truth = run_of(every_kind), series(COUNT)
    assert np.array_equal(data["t"].values, truth["t"])
    for name in "XYN":
        assert np.array_equal(data[name].values, truth[name] * 1000.0)


def test_every_kind_is_recognised_by_content(every_kind, tmp_path):
    head = every_kind.read_bytes()[:65536]
    assert READERS["hdf5"].recognises(every_kind, head)
    assert not READERS["pmmkit"].recognises(every_kind, head)
    for other in (b"", b"CDF text", b"t,X\n", head[4:]):
        assert not READERS["hdf5"].recognises(tmp_path / "other", other)


def test_saved_campaigns_keep_their_own_reader(tmp_path):
    plain(tmp_path / "run.h5")
    run_of(tmp_path / "run.h5")
    whole = tmp_path / "all.h5"
    save_campaign(open_campaign(tmp_path), whole)
    assert reader_for(request_of(whole)).name == "pmmkit"
    assert READERS["pmmkit"].recognises(whole, whole.read_bytes()[:65536])
    assert np.array_equal(values(whole, "X", group="SD")["X"], series(COUNT)["X"] * 1000.0)
    assert reader_for(request_of(tmp_path / "run.h5")).name == "hdf5"


def test_groups_have_paths_only_where_names_are_not_unique(tmp_path):
    path = tmp_path / "runs.h5"
    with h5py.File(path, "w") as file:
        for run in ("run1", "run2"):
            for seed, (name, vector) in enumerate(series(COUNT, len(run)).items()):
                file[f"{run}/{name}"] = vector + seed * (run == "run2")
        file["run2/raw/depth"] = np.ones(COUNT)
    assert set(headers(path)) == {
        *(f"{run}/{name}" for run in ("run1", "run2") for name in CHANNELS),
        "depth",
    }
    assert set(headers(path, group="run2")) == {*CHANNELS, "depth"}
    assert headers(path, group="run2/raw") == ("depth",)
    with pytest.raises(CampaignError, match=r"no group 'run3'; did you mean.*It has run1, run2"):
        headers(path, group="run3")


def test_matrices_and_records_are_several_columns(tmp_path):
    path = tmp_path / "run.h5"
    data = series(COUNT)
    record = np.zeros(COUNT, dtype=[("t", "f8"), ("X", "f4"), ("mark", "S4"), ("n", "i2")])
    record["t"], record["n"] = data["t"], np.arange(COUNT)
    with h5py.File(path, "w") as file:
        file.create_dataset("forces", data=np.stack([data["X"], data["Y"]]))
        file["forces"].attrs["units"] = "N"
        file.create_dataset("log", data=record, chunks=(16,), compression="gzip")
    found = values(path)
    assert set(found) == {"forces(1) [N]", "forces(2) [N]", "t", "X", "n"}
    assert np.array_equal(found["forces(2) [N]"], data["Y"])
    assert np.array_equal(found["n"], np.arange(COUNT))


def test_fill_values_are_missing_and_packed_numbers_unpacked(tmp_path):
    """Packing after the CF conventions, section 8.1: value = number * scale_factor + add_offset."""
    path = tmp_path / "run.nc"
    data = series(COUNT)
    data["Y"][3] = np.nan
    packing = {"dtype": "i2", "scale_factor": 0.001, "add_offset": 0.5, "_FillValue": -9999}
    dataset = xr.Dataset({name: ("t", data[name]) for name in "XYN"}, coords={"t": data["t"]})
    dataset.to_netcdf(path, engine="h5netcdf", encoding={"Y": packing})
    with pytest.raises(CampaignError, match="column Y, row 4"):
        run_of(path)
    found = run_of(path, '[source]\nmissing = "drop"\n')
    assert found.sizes["t"] == COUNT - 1
    assert np.allclose(found["Y"], np.delete(data["Y"], 3), rtol=0, atol=0.0005)
    assert "number * 0.001 + 0.5" in found.attrs["conversions"]


def test_texts_stand_in_tables(tmp_path):
    path = tmp_path / "tests.h5"
    with h5py.File(path, "w") as file:
        file["Run"] = ["SD1", "SD2", "SD3"]
        file["Y"] = [1.0, 2.0, 3.0]
        file["rho"] = 999.1
    table = cells(path)
    assert sorted(table.headers) == ["Run", "Y"]
    assert sorted(table.rows[1], key=str) == [2.0, "SD2"]
    assert headers(path) == ("Y",)


def test_links_to_elsewhere_are_not_followed(tmp_path):
    secret = plain(tmp_path / "secret.h5")
    (tmp_path / "raw.bin").write_bytes(np.arange(COUNT, dtype="f8").tobytes())
    path = tmp_path / "run.h5"
    layout = h5py.VirtualLayout(shape=(COUNT,), dtype="f8")
    layout[:] = h5py.VirtualSource(secret, "X", shape=(COUNT,))
    with h5py.File(path, "w") as file:
        file["Y"] = np.arange(float(COUNT))
        file["X"] = h5py.ExternalLink(str(secret), "/X")
        file["Z"] = h5py.SoftLink("/Y")
        file.create_virtual_dataset("V", layout)
        file.create_dataset(
            "R", shape=(COUNT,), dtype="f8", external=[(str(tmp_path / "raw.bin"), 0, COUNT * 8)]
        )
    assert set(headers(path)) == {"Y", "V", "R"}
    for name in ("V", "R"):
        with pytest.raises(CampaignError, match="lies in another file"):
            read(path, name)


def test_groups_that_hold_one_another_are_gone_into_once(tmp_path):
    """Thirty groups, each twice in the one before: a thousand million ways to the last."""
    path = tmp_path / "run.h5"
    with h5py.File(path, "w") as file:
        group = file
        for _ in range(30):
            inner = group.create_group("a")
            group["b"] = inner
            group = inner
        group["X"] = np.arange(float(COUNT))
        group["home"] = file["/"]
    assert headers(path) == ("X",)


def test_datasets_larger_than_what_is_stored_are_refused_before_they_are_read(tmp_path):
    path = tmp_path / "bomb.h5"
    with h5py.File(path, "w") as file:
        file.create_dataset("declared", shape=(10**10,), dtype="f8")
        file.create_dataset("contiguous", shape=(1000,), dtype="f8")
        grown = file.create_dataset("grown", data=np.ones(50), chunks=(10,), maxshape=(None,))
        grown.resize((1000,))
    for name, word in {
        "declared": "80,000,000,000 bytes",
        "contiguous": "should have 8000 bytes, 0 are there",
        "grown": "should have 100 chunks, 5 are there",
    }.items():
        with little_memory(), pytest.raises(CampaignError, match=word):
            read(path, next(header for header in headers(path) if header.startswith(name)))


def test_a_chunk_of_another_size_never_reaches_the_library(tmp_path):
    """Damage that hides the filters of a dataset made libhdf5 write over its own memory."""
    path = tmp_path / "run.h5"
    rng = np.random.default_rng(0)
    with h5py.File(path, "w", libver="earliest") as file:
        file.create_dataset("X", data=rng.random(60), chunks=(60,), compression="gzip")
    data = bytearray(path.read_bytes())
    message = data.index(b"deflate") - 24
    assert data[message : message + 2] == b"\x0b\x00"
    data[message] = 0
    path.write_bytes(data)
    with pytest.raises(CampaignError, match="chunks should have 480 bytes each"):
        read(path, "X")


def test_a_chunk_that_expands_beyond_its_size_is_refused(tmp_path):
    """64 MB of zeros in a chunk of 800 bytes: libhdf5 would expand all of them."""
    path = tmp_path / "bomb.h5"
    with h5py.File(path, "w") as file:
        item = file.create_dataset("X", shape=(100,), dtype="f8", chunks=(100,), compression="gzip")
        item.id.write_direct_chunk((0,), zlib.compress(bytes(64_000_000)))
    with little_memory(), pytest.raises(CampaignError, match="does not end where it should"):
        read(path, "X")


@pytest.mark.slow
def test_a_chunk_that_the_tree_hides_is_still_read(tmp_path):
    """libhdf5 finds no chunk behind a damaged key and gives zeros; all that are listed are read."""
    path = tmp_path / "run.h5"
    with h5py.File(path, "w", libver="earliest") as file:
        file.create_dataset("X", data=np.arange(1.0, 31.0), chunks=(10,), compression="gzip")
    whole = path.read_bytes()
    tree = whole.index(b"TREE\x01")
    key = 8 + 8 + 8
    found_lost = 0
    for place in range(tree + 24, tree + 24 + 4 * (key + 8)):
        damaged = bytearray(whole)
        damaged[place] ^= 0x7F
        path.write_bytes(damaged)
        try:
            with h5py.File(path) as file:
                found_lost += int(np.any(file["X"][()] == 0.0))
        except (OSError, RuntimeError):
            pass
        try:
            assert np.array_equal(values(path)["X"], np.arange(1.0, 31.0))
        except CampaignError:
            continue
    assert found_lost


def test_a_damaged_heap_is_an_error_and_not_a_hang(tmp_path):
    """An object of the global heap with neither index nor size: libhdf5 2.0.0 never returns."""
    path = netcdf4(tmp_path / "run.nc")
    data = bytearray(path.read_bytes())
    heap = data.index(b"GCOL\x01\0\0\0")
    (held,) = struct.unpack_from("<Q", data, heap + 24)
    following = heap + 16 + 16 + held + -held % 8
    hdf5_guard.check_heaps(bytes(data))
    data[following : following + 16] = bytes(16)
    path.write_bytes(data)
    with pytest.raises(CampaignError, match="heap at byte"):
        headers(path)


def test_numbers_in_no_usual_format_are_refused(tmp_path):
    path = tmp_path / "run.h5"
    kind = h5py.h5t.IEEE_F64LE.copy()
    kind.set_ebias(1000)
    with h5py.File(path, "w") as file:
        space = h5py.h5s.create_simple((COUNT,))
        item = h5py.h5d.create(file.id, b"X", kind, space)
        item.write(h5py.h5s.ALL, h5py.h5s.ALL, np.ones(COUNT))
    with pytest.raises(CampaignError, match="no usual format"):
        read(path, "X")


def test_a_classic_file_with_more_records_than_it_says(tmp_path):
    """The number of records stands in bytes 4 to 8."""
    path = classic(tmp_path / "run.nc", records=True)
    data = bytearray(path.read_bytes())
    assert struct.unpack_from(">I", data, 4) == (COUNT,)
    struct.pack_into(">I", data, 4, 28)
    path.write_bytes(data)
    with pytest.raises(CampaignError, match="28 records are declared, 40 are there"):
        headers(path)
    struct.pack_into(">I", data, 4, 0xFFFFFFFF)
    path.write_bytes(data)
    assert np.array_equal(values(path)["X [kN]"], series(COUNT)["X"])
    struct.pack_into(">I", data, 4, 2**31)
    path.write_bytes(data)
    with little_memory(), pytest.raises(CampaignError, match="behind the end of the file"):
        headers(path)


def test_a_classic_record_of_odd_length(tmp_path):
    """Records are padded to four bytes, but not where there is only one variable of them."""
    for names in (("X",), ("X", "Y")):
        path = tmp_path / "run.nc"
        with netcdf_file(path, "w") as file:
            file.createDimension("t", None)
            for name in names:
                file.createVariable(name, "h", ("t",))[:] = np.arange(9, dtype="i2")
        assert values(path)["X"].tolist() == list(range(9))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_damage(every_kind):
    wanted = tuple(f"{name} [{unit}]" for name, unit in UNITS.items())
    assert check_damage(every_kind, wanted, 80) > 10


@pytest.mark.slow
def test_damage_to_records_and_groups(tmp_path):
    path = tmp_path / "run.h5"
    record = np.zeros(COUNT, dtype=[("t", "f8"), ("X", "f4")])
    with h5py.File(path, "w") as file:
        file["a/log"] = record
        file["a/ids"] = ["one", "two"]
    whole = path.read_bytes()
    for data in damaged_versions(whole, 150, 5):
        path.write_bytes(data)
        for look in (lambda: values(path, group="a"), lambda: cells(path)):
            try:
                look()
            except PmmkitError:
                continue


@pytest.mark.parametrize("content", [b"", b"\x89HDF\r\n\x1a\n", b"CDF\x01", b"CDF\x07" + bytes(50)])
def test_files_that_are_none(tmp_path, content):
    path = tmp_path / "run.h5"
    path.write_bytes(content)
    with pytest.raises(CampaignError, match=r"run\.h5"):
        headers(path)
