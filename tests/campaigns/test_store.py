"""One HDF5 file for a campaign: what goes in comes out, for us and for other programs."""

from __future__ import annotations

import datetime
import gc
import hashlib
import json
import os
import pickle
import subprocess
import sys
import weakref
from concurrent.futures import ThreadPoolExecutor
from dataclasses import fields
from pathlib import Path
from types import MappingProxyType

import h5py
import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

from pmmkit import Campaign, Run, load_campaign, save_campaign
from pmmkit.base import CampaignError, PmmkitError, Problem
from pmmkit.campaigns import Correction, Settings, TypeB
from pmmkit.conventions import CHANNEL_UNITS, Ship, Water
from pmmkit.files import from_json, to_json
from pmmkit.readers.saved.file import described, read_run

SHIP = Ship(
    name="Modell ü", L=4.861111, B=0.705556, d=0.236111, volume=0.454861, mass=454.476,
    Izz=618.332, xG=-0.01, GM=0.05, balance_mass=460.0, block_stated=0.561,
)  # fmt: skip
DATA_V1 = Path(__file__).parents[1] / "data" / "campaign_v1.h5"


def history(seed: int = 0, n: int = 700) -> xr.Dataset:
    rng = np.random.default_rng(seed)
    data = xr.Dataset(
        {
            "X": ("t", rng.normal(-20, 1, n), {"units": "N", "long_name": "surge force"}),
            "Y": ("t", rng.normal(0, 1, n)),
            "N": ("t", rng.normal(0, 1, n).astype(np.float32)),
            "count": ("t", np.arange(n)),
            "good": ("t", rng.random(n) > 0.5),
            "remark": ("t", np.array(["", "läuft"] * (n // 2))),
            "K": ("t", np.full(n, np.nan)),
            "wire": (("t", "strut"), rng.normal(size=(n, 2))),
        },
        coords={"t": np.arange(n) * 0.05, "strut": ["fore", "aft"], "phase": ("t", np.ones(n))},
        attrs={"rate [Hz]": 20.0, "axes": ("x", "-y"), "filter": None, "gain": np.arange(3)},
    )
    data["Y"][3:9] = np.nan
    return data


def means() -> xr.Dataset:
    return xr.Dataset({"X": -12.5, "Y": 3.25, "N": np.nan, "T": np.float32(1.5), "valid": True})


def harmonics() -> xr.Dataset:
    return xr.Dataset(
        {
            "Y_cos": ("harmonic", [0.1, 2.0, 0.0, np.nan]),
            "Y_sin": ("harmonic", [0.0, -3.0, 0.1, 0.2]),
        },
        coords={"harmonic": [0, 1, 2, 3]},
    )


def run(run_id: str, data: xr.Dataset, **changes: object) -> Run:
    known = {
        "id": run_id,
        "test": "pure_sway",
        "kind": "history",
        "loader": lambda: data,
        "settings": Settings(speed=1.5, period=12.566370614359172, amplitude=0.2, phase=0.1),
    } | changes
    return Run(**known)


def campaign() -> Campaign:
    scale = Correction(
        runs=("PS_*", "PY?"),
        action="scale",
        reason="gauge factor 2 — see log",
        values=MappingProxyType(
            {"channels": ["X"], "factor": 2.0, "on": datetime.date(2012, 5, 3)}
        ),
    )
    return Campaign(
        title='Schlepptank "A" – S175',
        ship=SHIP,
        water=Water(rho=999.1, g=9.81, nu=1.1e-6, tank_width=14.0),
        runs=(
            run("PS_1", history(1), corrections=(scale, scale), source="runs/PS_1.csv"),
            run("PS/1", history(2), forces="balance", use_means=False),
            run(
                "SD β = 8°",
                means(),
                kind="means",
                test="static_drift",
                settings=Settings(speed=1.0, drift=0.14, repeat_of="PS_1"),
                stated=MappingProxyType({"Run No.": 376.0, "Froude": float("nan")}),
            ),
            run(".", harmonics(), kind="harmonics"),
            run(" a/b.c ", harmonics(), kind="harmonics"),
            run(
                "TC35",
                history(3),
                test="turning",
                settings=Settings(speed=9.0, rudder=0.61, propeller_rps=2.0, switch=0.2),
            ),
        ),
        excluded=((run("279b", means(), kind="means"), "copy of beta 12"),),
        forces="balance",
        moment_reference_x=0.25,
        moment_reference_z=-0.1,
        motion_reference_x=0.01,
        free=("heave", "pitch"),
        uncertainty=(TypeB(name="X_gauge", std=0.1, shared=True), TypeB(name="drift", std=5e-4)),
        cfd=MappingProxyType({"rho_inf": 998.2, "moment_centre": [0.0, 0.0, 0.1]}),
        propeller=MappingProxyType({"D": 0.2124, "J": [0.0, 0.5], "KT": [0.311, 0.1]}),
        rudder=MappingProxyType({"area": 0.0539, "box": {"span": 0.345, "known": True}}),
        numerical=MappingProxyType({"X": 0.1, "Y": 0.4}),
        provenance=MappingProxyType(
            {
                "files": {"runs/PS_1.csv": "9f" * 32},
                "conversions": ["X: kN to N, by 1000"],
                "pmmkit": "0.1.0",
                "rows": (1, 2),
            }
        ),
    )


@pytest.fixture(scope="module")
def content(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    path = tmp_path_factory.mktemp("store") / "campaign.h5"
    save_campaign(campaign(), path)
    return path.read_bytes()


@pytest.fixture
def saved(tmp_path: Path, content: bytes) -> Path:
    path = tmp_path / "campaign.h5"
    path.write_bytes(content)
    return path


def assert_same(one: Campaign, other: Campaign) -> None:
    for field in fields(Campaign):
        if field.name not in ("runs", "excluded", "folder"):
            assert repr(getattr(one, field.name)) == repr(getattr(other, field.name)), field.name
    assert [reason for _, reason in one.excluded] == [reason for _, reason in other.excluded]
    pairs = zip(
        [*one.runs, *(item for item, _ in one.excluded)],
        [*other.runs, *(item for item, _ in other.excluded)],
        strict=True,
    )
    for first, second in pairs:
        for field in fields(Run):
            if field.name != "loader":
                assert repr(getattr(first, field.name)) == repr(getattr(second, field.name))
        ours, theirs = first.data, second.data
        xr.testing.assert_identical(ours, theirs)
        for name, variable in ours.variables.items():
            assert variable.dtype == theirs[name].dtype, name


@pytest.mark.slow
def test_what_goes_in_comes_out(saved: Path) -> None:
    loaded = load_campaign(saved)
    assert_same(campaign(), loaded)
    assert loaded.folder == saved.parent
    assert isinstance(loaded.runs[0].settings, Settings)
    assert isinstance(loaded.runs[0].corrections[0].runs, tuple)


def test_saved_again_it_is_the_same_file(saved: Path, tmp_path: Path) -> None:
    save_campaign(load_campaign(saved), tmp_path / "again.h5")
    assert digest(tmp_path / "again.h5") == digest(saved)


def test_a_campaign_may_replace_the_file_it_was_loaded_from(saved: Path) -> None:
    before = digest(saved)
    save_campaign(load_campaign(saved), saved)
    assert digest(saved) == before
    assert os.listdir(saved.parent) == ["campaign.h5"]


def digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


@pytest.mark.slow
def test_same_input_same_bytes_in_another_process_and_second(saved: Path, tmp_path: Path) -> None:
    code = (
        "import sys; sys.path.insert(0, sys.argv[1]); import test_store as s; from pathlib "
        "import Path; import time; time.sleep(1.1); s.save_campaign(s.campaign(), sys.argv[2])"
    )
    other = tmp_path / "other" / "there.h5"
    arguments = [sys.executable, "-c", code, str(Path(__file__).parent), str(other)]
    subprocess.run(arguments, check=True, env={**os.environ, "PYTHONHASHSEED": "77"})
    assert digest(other) == digest(saved)


def test_xarray_opens_a_run_and_knows_its_coordinates(saved: Path) -> None:
    with xr.open_dataset(saved, group="runs/PS_1", engine="h5netcdf") as data:
        ours = campaign()["PS_1"].data
        assert data["t"].dtype == np.float64
        assert set(data.coords) == {"t", "strut", "phase"}
        for name in ours.variables:
            np.testing.assert_array_equal(data[name].values, ours[name].values)
        assert data["good"].dtype == bool


def test_h5py_sees_dimension_scales_units_and_compression(saved: Path) -> None:
    with h5py.File(saved) as file:
        assert file["runs/PS_1/Y"].dims[0].keys() == ["t"]
        assert file["runs/PS_1/t"].is_scale
        stored = file["runs/PS_1/Y"]
        assert (stored.compression, stored.compression_opts, stored.shuffle) == ("gzip", 4, True)
        assert stored.attrs["units"] == "N"
        assert file["runs/TC35/N"].attrs["units"] == "N m"
        assert file["runs/run_./Y_cos"].attrs["units"] == "N"
        groups = list(file["runs"].values())
        for group in groups:
            for variable in group.values():
                assert {"units", "long_name"} <= set(variable.attrs), variable.name
            assert json.loads(group.attrs["run"])["settings"]["speed"] > 0
        assert len(groups) == 7
        assert json.loads(file.attrs["index"])["campaign"]["ship"]["L"] == SHIP.L


def test_attributes_of_the_data_are_not_changed_by_the_units_of_the_file(saved: Path) -> None:
    data = load_campaign(saved)["PS_1"].data
    assert data["X"].attrs == {"units": "N", "long_name": "surge force"}
    assert data["Y"].attrs == {}


def test_run_ids_of_any_shape_find_their_own_data(saved: Path) -> None:
    for original in campaign():
        xr.testing.assert_identical(read_run(saved, original.id), original.data)
    xr.testing.assert_identical(read_run(saved, "279b"), means())
    with pytest.raises(CampaignError, match=r"no run 'PS_7'; it has PS_1, PS/1"):
        read_run(saved, "PS_7")


@pytest.mark.slow
@settings(max_examples=25, deadline=None)
@given(ids=st.lists(st.text(max_size=6), min_size=1, max_size=6, unique=True))
def test_ids_are_kept_whatever_they_are(ids: list[str], tmp_path_factory) -> None:
    path = tmp_path_factory.mktemp("ids") / "c.h5"
    data = [xr.Dataset({"Y": float(number)}) for number in range(len(ids))]
    runs = tuple(run(name, each, kind="means") for name, each in zip(ids, data, strict=True))
    save_campaign(Campaign(title="ids", ship=SHIP, water=Water(), runs=runs), path)
    loaded = load_campaign(path)
    assert [each.id for each in loaded] == ids
    for number, name in enumerate(ids):
        assert float(loaded[name].data["Y"]) == number
        assert float(read_run(path, name)["Y"]) == number


def test_an_id_counts_before_the_group_of_another_run(tmp_path: Path) -> None:
    """The run ':' lies in a group '_', which is also the id of the second."""
    runs = tuple(
        run(name, xr.Dataset({"Y": float(number)}), kind="means")
        for number, name in enumerate((":", "_"))
    )
    path = tmp_path / "c.h5"
    save_campaign(Campaign(title="ids", ship=SHIP, water=Water(), runs=runs), path)
    assert [float(read_run(path, name)["Y"]) for name in (":", "_")] == [0.0, 1.0]


def test_opening_reads_no_group(saved: Path) -> None:
    """With every run's samples gone the campaign still opens; only the data are missed."""
    with h5py.File(saved, "r+") as file:
        del file["runs"]
    loaded = load_campaign(saved)
    assert len(loaded) == 6
    with pytest.raises(CampaignError, match="damaged"):
        _ = loaded["PS_1"].data


@pytest.mark.slow
def test_runs_are_read_one_after_the_other(tmp_path: Path) -> None:
    handed_out: list[weakref.ref[xr.Dataset]] = []

    def load() -> xr.Dataset:
        gc.collect()
        assert not any(reference() is not None for reference in handed_out)
        data = xr.Dataset({"Y": ("t", np.zeros(10))})
        handed_out.append(weakref.ref(data))
        return data

    runs = tuple(run(f"R{number}", means(), loader=load) for number in range(5))
    save_campaign(Campaign(title="t", ship=SHIP, water=Water(), runs=runs), tmp_path / "c.h5")
    assert len(handed_out) == len(load_campaign(tmp_path / "c.h5")) == 5


def test_nothing_stays_open(saved: Path) -> None:
    loaded = load_campaign(saved)
    data = loaded["PS_1"].data
    with h5py.File(saved, "r+") as file:
        file.attrs["note"] = "writable"
    saved.rename(saved.with_name("moved.h5"))
    assert data["Y"].shape == (700,)


@pytest.mark.slow
def test_many_threads_read_the_right_runs(saved: Path) -> None:
    loaded = load_campaign(saved)
    expected = [float(each.data["Y"].sum()) for each in loaded.runs[:2]]

    def total(number: int) -> float:
        return float(loaded.runs[number % 2].data["Y"].sum())

    with ThreadPoolExecutor(8) as pool:
        assert list(pool.map(total, range(80))) == expected * 40


def test_a_loaded_campaign_goes_to_other_processes(saved: Path) -> None:
    again = pickle.loads(pickle.dumps(load_campaign(saved).runs[0].loader))
    xr.testing.assert_identical(again(), history(1))


def test_long_records_are_stored_in_several_chunks(tmp_path: Path) -> None:
    data = xr.Dataset({"Y": ("t", np.arange(300_000.0))}, {"t": np.arange(300_000) * 0.01})
    each = Campaign(title="t", ship=SHIP, water=Water(), runs=(run("long", data),))
    save_campaign(each, tmp_path / "c.h5")
    xr.testing.assert_identical(load_campaign(tmp_path / "c.h5")["long"].data, data)
    with h5py.File(tmp_path / "c.h5") as file:
        assert file["runs/long/Y"].chunks == (131072,)


@pytest.mark.slow
def test_an_index_beyond_64_kilobytes(tmp_path: Path) -> None:
    note = MappingProxyType({"conversions": [f"run {number}: X by 1000" for number in range(9000)]})
    each = campaign().with_(provenance=note)
    save_campaign(each, tmp_path / "c.h5")
    assert load_campaign(tmp_path / "c.h5").provenance == note


def failing(message: str):
    def load() -> xr.Dataset:
        raise CampaignError([Problem(message=message, file="a.csv"), f"{message} too"])

    return load


def test_all_runs_that_cannot_be_saved_are_named_and_nothing_is_written(tmp_path: Path) -> None:
    dates = xr.Dataset({"t": ("t", np.array(["2020-01-01"], "datetime64[ns]"))})
    empty = xr.Dataset({"Y": ("t", [])})
    runs = (
        run("A", means(), loader=failing("row 3 is torn")),
        run("B", dates),
        run("C", empty),
        run("D", means().assign_attrs(owner=object())),
    )
    with pytest.raises(CampaignError) as caught:
        save_campaign(Campaign(title="t", ship=SHIP, water=Water(), runs=runs), tmp_path / "c.h5")
    assert [problem.run for problem in caught.value.problems] == ["A", "A", "B", "C", "D"]
    assert "datetime64" in str(caught.value)
    assert os.listdir(tmp_path) == []


@pytest.mark.slow
def test_an_excluded_run_that_cannot_be_read_does_not_stop_the_others(tmp_path: Path) -> None:
    broken = run("E", means(), loader=failing("torn"))
    save_campaign(campaign().with_(excluded=((broken, "torn tape"),)), tmp_path / "c.h5")
    loaded = load_campaign(tmp_path / "c.h5")
    assert loaded.excluded[0][1] == "torn tape"
    for read in (lambda: loaded.excluded[0][0].data, lambda: read_run(tmp_path / "c.h5", "E")):
        with pytest.raises(CampaignError, match=r"(?s)when the campaign was saved: .*torn too"):
            read()


def test_a_fault_while_saving_leaves_the_old_file(saved: Path) -> None:
    before = digest(saved)
    with pytest.raises(CampaignError):
        save_campaign(campaign().with_(runs=(run("A", means(), loader=failing("x")),)), saved)
    with pytest.raises(CampaignError, match="cannot be kept"):
        save_campaign(campaign().with_(cfd={"solver": object()}), saved)
    assert digest(saved) == before
    assert os.listdir(saved.parent) == ["campaign.h5"]


def test_a_place_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(CampaignError, match="cannot be written"):
        save_campaign(campaign(), tmp_path / "file" / "c.h5")


def test_a_newer_schema_is_refused_by_its_version(saved: Path) -> None:
    with h5py.File(saved, "r+") as file:
        file.attrs["schema"] = 2
        file.attrs["pmmkit"] = "9.1"
    for read in (load_campaign, lambda path: read_run(path, "PS_1")):
        with pytest.raises(CampaignError, match=r"schema 2, written by pmmkit 9\.1"):
            read(saved)


def test_other_hdf5_files_and_other_files_are_refused(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["Y"] = [1.0]
    (tmp_path / "text.h5").write_text("t,X,Y\n0,1,2\n")
    (tmp_path / "empty.h5").write_bytes(b"")
    with pytest.raises(CampaignError, match="not a campaign"):
        load_campaign(tmp_path / "other.h5")
    for name in ("text.h5", "empty.h5"):
        with pytest.raises(CampaignError, match="cannot be read"):
            load_campaign(tmp_path / name)
    with pytest.raises(CampaignError, match="no such file"):
        load_campaign(tmp_path / "none.h5")
    with pytest.raises(CampaignError, match="no such file"):
        load_campaign(tmp_path)


def test_an_edited_sample_or_index_is_noticed(saved: Path) -> None:
    with h5py.File(saved, "r+") as file:
        file["runs/SD_____8_/Y"][...] = 3.5
    with pytest.raises(CampaignError, match="checksum"):
        _ = load_campaign(saved)["SD β = 8°"].data
    with h5py.File(saved, "r+") as file:
        file.attrs["index"] = file.attrs["index"].replace(b"454.476", b"455.476")
    with pytest.raises(CampaignError, match="index does not match"):
        load_campaign(saved)


def readable_or_refused(path: Path) -> bool:
    """Read all of a damaged file; True if it was refused. Wrong data are an error of the test."""
    try:
        assert_same(campaign(), load_campaign(path))
    except PmmkitError:
        return True
    return False


@pytest.mark.parametrize("share", [0.001, 0.05, 0.3, 0.6, 0.9, 0.999])
def test_a_file_cut_short_is_refused(saved: Path, share: float) -> None:
    content = saved.read_bytes()
    saved.write_bytes(content[: int(len(content) * share)])
    assert readable_or_refused(saved)


@pytest.mark.slow
@pytest.mark.parametrize("width", [1, 64])
def test_flipped_and_zeroed_bytes_give_an_error_or_the_right_data(saved: Path, width: int) -> None:
    """Damage is sown over the whole file; what no reader looks at may stay unnoticed."""
    content = saved.read_bytes()
    rng = np.random.default_rng(11)
    refused = 0
    for place in rng.integers(0, len(content) - width, 25):
        damaged = bytearray(content)
        flip = int(rng.integers(1, 256)) ^ damaged[place]
        damaged[place : place + width] = bytes([flip]) if width == 1 else bytes(width)
        saved.write_bytes(bytes(damaged))
        refused += readable_or_refused(saved)
    assert refused > 5


@pytest.mark.slow
@settings(max_examples=200, deadline=None)
@given(
    st.recursive(
        st.none()
        | st.booleans()
        | st.integers()
        | st.floats()
        | st.text()
        | st.dates()
        | st.times().map(lambda time: time.replace(fold=0))
        | st.datetimes().map(lambda time: time.replace(fold=0)),
        lambda inner: (
            st.lists(inner)
            | st.lists(inner).map(tuple)
            | st.dictionaries(st.text() | st.integers() | st.sampled_from(["$float", "$x"]), inner)
        ),
        max_leaves=12,
    )
)
def test_json_gives_back_every_value_and_type(value: object) -> None:
    text = to_json(value)
    assert text.isascii()
    assert repr(from_json(text)) == repr(value)


def test_numpy_values_become_plain_or_arrays_again() -> None:
    back = from_json(to_json({"a": np.float64(0.1), "b": np.int8(3), "c": np.arange(3.0)}))
    assert type(back["a"]) is float
    assert type(back["b"]) is int
    np.testing.assert_array_equal(back["c"], [0.0, 1.0, 2.0])


def test_a_campaign_saved_by_the_first_version_still_opens() -> None:
    """The file was written by pmmkit 0.1.0; what it holds is written out here by hand."""
    loaded = load_campaign(DATA_V1)
    assert loaded.title == "Two tests of a box"
    assert (loaded.ship.L, loaded.ship.mass, loaded.water.rho) == (4.0, 500.0, 999.1)
    assert loaded.free == ("heave", "pitch")
    assert loaded.uncertainty == (TypeB(name="X_gauge", std=0.1, shared=True),)
    assert loaded.provenance["files"] == {"runs/PS.csv": "00ff"}
    sway, drift = loaded.runs
    assert (sway.id, sway.test, sway.kind, sway.forces) == (
        "PS 1/2",
        "pure_sway",
        "history",
        "balance",
    )
    assert sway.settings == Settings(speed=1.5, period=12.5, amplitude=0.2)
    assert sway.corrections[0].values == {"channels": ["X"], "factor": 2.0}
    np.testing.assert_array_equal(sway.data["t"], np.arange(40) * 0.25)
    np.testing.assert_array_equal(sway.data["Y"], np.arange(40) - 20.0)
    assert sway.data["Y"].attrs == {"units": "N"}
    assert drift.settings.drift == 0.14
    assert float(drift.data["N"]) == -3.5
    assert np.isnan(drift.data["K"])
    ((excluded, reason),) = loaded.excluded
    assert (excluded.id, reason) == ("279b", "copy of beta 12")
    np.testing.assert_array_equal(excluded.data["Y_cos"], [0.0, 1.5, 0.25])


def test_every_channel_of_a_campaign_file_has_a_unit_and_a_meaning() -> None:
    for name in CHANNEL_UNITS:
        unit, label = described(name)
        assert unit == CHANNEL_UNITS[name]
        assert len(label) > len(name)
    assert described("Y_cos_std")[0] == "N"
    assert described("gauge_3") == ("unknown", "gauge_3")
