"""Exports of tables, campaigns and tracks come back as they were; the word and the command."""

from __future__ import annotations

import json
import math
import re
import shutil
import subprocess

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from small_campaign import write_campaign

import pmmkit as pk
from pmmkit import Campaign, Run
from pmmkit.base import CampaignError, DataError, FileExists
from pmmkit.campaigns import Correction, Settings, TypeB
from pmmkit.cli import main
from pmmkit.exports.matlab.hull import table_to_mss
from pmmkit.exports.write import FORMATS
from pmmkit.models import from_values
from pmmkit.models.tables.compare import identical

OCTAVE = shutil.which("octave-cli")
EVIL = "x'); system('rm"


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    return write_campaign(tmp_path_factory.mktemp("tests") / "small")


# --- Tables ------------------------------------------------------------------------------------


@pytest.fixture
def table():
    model = pk.load_model("s175-3dof")
    return from_values(
        {"Yv": [-0.0116, -0.0118], "Nvvr": [-0.0424, math.nan], "Yv|v|": [0.1 + 0.2, -1e-300]},
        std={"Yv": 1e-4},
        Fn=[0.15, 0.29],
        ship=model.ship,
        water=model.water,
        notes=("Yv and Yv|v| move together",),
    )


def read_structure(text: str) -> dict[str, object]:
    """Fields of the structure that a table's function gives."""
    fields: dict[str, object] = {}
    for name, value in re.findall(r"^table\.(\S+) = (.*?);(?:  %.*)?$", text, re.MULTILINE):
        if value.startswith("["):
            fields[name] = [float(item) for item in value.strip("[]").split(", ")]
        else:
            fields[name] = value.strip("'") if value.startswith("'") else float(value)
    return fields


def test_a_table_becomes_a_structure_over_the_froude_number(table):
    found = read_structure(table_to_mss(table))
    assert found["Fn"] == [0.15, 0.29]
    np.testing.assert_array_equal(found["Yv"], table["Yv"])
    np.testing.assert_array_equal(found["Nvvr"], table["Nvvr"])
    np.testing.assert_array_equal(found["Yvabsv"], table["Yv|v|"])
    np.testing.assert_array_equal(found["std.Yv"], [1e-4, 1e-4])
    assert found["ship.L"] == 175.0
    assert found["convention.system"] == "prime"


@pytest.mark.skipif(OCTAVE is None, reason="there is no octave-cli")
def test_octave_reads_the_structure(table, tmp_path):
    named = table.with_(ship=pk.load_model("s175").ship, notes=(EVIL, "\nquit(3)"))
    pk.export(named, tmp_path / "derivatives.m")
    call = "t = derivatives(); printf('%.17g ', t.Fn, t.Yv, t.Yvabsv, t.std.Yv)"
    done = subprocess.run(
        [OCTAVE, "--norc", "--quiet", "--eval", call],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    )
    expected = np.concatenate([table.Fn, table["Yv"], table["Yv|v|"], [1e-4, 1e-4]])
    np.testing.assert_array_equal(np.array(done.stdout.split(), float), expected)


@pytest.mark.parametrize(("to", "ending"), [("csv", "csv"), ("excel", "xlsx"), ("netcdf", "nc")])
def test_tables_come_back_from_every_format_that_is_read(table, to, ending, tmp_path):
    file, *beside = pk.export(table, tmp_path / f"again.{ending}", to)
    assert {path.name for path in tmp_path.iterdir()} == {file.name, *(x.name for x in beside)}
    assert identical(pk.read_table(file), table)
    second, sidecar = pk.export(file, tmp_path / "second.csv")
    assert identical(pk.read_table(second), table)
    assert sidecar.name == "second.json"


def test_latex_is_written_by_the_room_of_the_tables(table, tmp_path):
    (file,) = pk.export(table, tmp_path / "table.tex")
    assert "toprule" in file.read_text(encoding="utf-8")


# --- Campaigns ---------------------------------------------------------------------------------


def same_data(one: Campaign, other: Campaign) -> None:
    """Every sample the same to the bit, every setting equal."""
    pairs = zip(
        [*one.runs, *(run for run, _ in one.excluded)],
        [*other.runs, *(run for run, _ in other.excluded)],
        strict=True,
    )
    for mine, back in pairs:
        assert (mine.id, mine.test, mine.kind) == (back.id, back.test, back.kind)
        assert mine.settings == back.settings
        assert (mine.forces, mine.use_means) == (back.forces, back.use_means)
        data, again = mine.data, back.data
        assert set(data.variables) == set(again.variables)
        for name in data.variables:
            first = np.asarray(data[name].values, float)
            second = np.asarray(again[name].values, float)
            assert first.tobytes() == second.tobytes(), (mine.id, name)
    for field in (
        "ship",
        "water",
        "kind",
        "forces",
        "free",
        "moment_reference_x",
        "moment_reference_z",
        "motion_reference_x",
        "propeller",
        "rudder",
        "numerical",
        "title",
    ):
        assert getattr(one, field) == getattr(other, field), field
    assert sorted(map(repr, one.uncertainty)) == sorted(map(repr, other.uncertainty))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["campaign.nc", "campaign.h5", "folder"])
def test_a_campaign_comes_back_the_same_to_the_bit(small, name, tmp_path):
    campaign = pk.open_campaign(small)
    files = pk.export(small, tmp_path / name)
    assert len(files) == (len(campaign) + 1 if name == "folder" else 1)
    same_data(campaign, pk.open_campaign(tmp_path / name))


def history(seed: int = 0) -> xr.Dataset:
    rng = np.random.default_rng(seed)
    t = np.arange(40) * 0.1
    names = ("X", "Y", "N", "v", "delta")
    return xr.Dataset({name: ("t", rng.normal(size=40)) for name in names}, coords={"t": t})


def run_of(run_id: str, data: xr.Dataset, kind: str = "history", **changes) -> Run:
    known = {
        "id": run_id,
        "test": "static_drift",
        "kind": kind,
        "loader": lambda: data,
        "settings": Settings(speed=1.1, drift=math.radians(7.3)),
    } | changes
    return Run(**known)


def mixed() -> Campaign:
    """Histories, means and harmonics; ids that file systems and patterns trip over."""
    means = xr.Dataset({"X": -1.5, "Y": 3.25, "N": 0.1 + 0.2, "Y_std": 0.01, "v": -0.14})
    means["X"].attrs["units"] = "N"
    waves = xr.Dataset(
        {
            "Y_cos": ("harmonic", [0.1, 2.0, math.nan, 1 / 3]),
            "Y_sin": ("harmonic", [0.0, -3.0, 0.1, 0.2]),
        },
        coords={"harmonic": [0, 1, 2, 3]},
    )
    ship = pk.load_model("kvlcc2-l7").ship
    sway = Settings(speed=1.5, period=9.7, amplitude=0.2, phase=math.radians(33.0))
    return Campaign(
        title='Tank "A", Ü',
        ship=ship,
        water=pk.Water(rho=999.1, tank_width=14.0),
        runs=(
            run_of("SD*", history(1)),
            run_of("sd/*", history(2), forces="balance"),
            run_of("CON", means, "means"),
            run_of('a,\n"b"', means, "means"),
            run_of("001", means.drop_vars("v"), "means"),
            run_of("1", means, "means"),
            run_of("PS", waves, "harmonics", test="pure_sway", settings=sway, use_means=False),
        ),
        excluded=((run_of("[x]", history(3)), "gauge broken"),),
        uncertainty=(
            TypeB(name="X_gauge", std=0.003, relative=True),
            TypeB(name="drift", std=5e-4),
            TypeB(name="drift", std=math.radians(0.02), shared=True),
        ),
        propeller={"D": 0.2, "J": [0.0, 0.5], "open_water": "wake \\ 1.csv"},
        numerical={"Y": 0.4},
        cfd={"rho_inf": 998.0, "symmetry_factor": 2.0},
        free=("heave",),
        moment_reference_x=0.25,
    )


@pytest.mark.parametrize("name", ["there", "there.nc"])
def test_the_open_water_curve_goes_along_with_its_factors(name, tmp_path):
    (tmp_path / "curve.csv").write_text("J,Kt,10Kq\n0,0.3,0.35\n0.5,0.15,0.2\n")
    propeller = {"D": 0.2, "open_water": "curve.csv", "KT_factor": 1.1, "KQ_factor": 0.5}
    one = mixed().with_(propeller=propeller, folder=tmp_path)
    (tmp_path / "elsewhere").mkdir()
    pk.export(one, tmp_path / "elsewhere" / name)
    found = pk.open_campaign(tmp_path / "elsewhere" / name).open_water
    assert np.array_equal(found, one.open_water)
    assert found[1].tolist() == pytest.approx([0.33, 0.165])


@pytest.mark.parametrize("name", ["campaign.nc", "folder"])
def test_every_kind_of_run_comes_back(name, tmp_path, monkeypatch):
    monkeypatch.setenv("PMMKIT_DATA", str(tmp_path))
    one = mixed()
    files = pk.export(one, tmp_path / name)
    again = pk.open_campaign(tmp_path / name)
    same_data(one, again)
    assert [reason for _, reason in again.excluded] == ["gauge broken"]
    if name == "folder":
        assert {file.name for file in files} == {
            "campaign.toml",
            "1_SD_.csv",
            "2_sd__.csv",
            "8__x_.csv",
            "means.csv",
            "means_2.csv",
            "harmonics.csv",
        }
        head = (tmp_path / name / "1_SD_.csv").read_text(encoding="utf-8").splitlines()[0]
        assert head == "t [s],X [N],Y [N],N [N m],v [m/s],delta [rad]"


@pytest.mark.slow
@settings(deadline=None, max_examples=60)
@given(
    degrees=st.floats(-180, 180), samples=st.lists(st.floats(-1e20, 1e20), min_size=3, max_size=9)
)
def test_any_angle_and_any_number_survive_csv(tmp_path_factory, degrees, samples):
    data = xr.Dataset(
        {name: ("t", np.array(samples)) for name in ("X", "Y", "N")},
        coords={"t": np.arange(len(samples)) * 0.1},
    )
    settings = Settings(speed=1.0, drift=math.radians(degrees))
    one = mixed().with_(
        runs=(run_of("a", data, settings=settings),), excluded=(), uncertainty=(), cfd={}
    )
    folder = tmp_path_factory.mktemp("csv") / "out"
    pk.export(one, folder)
    same_data(one, pk.open_campaign(folder))


def test_what_csv_cannot_keep_is_refused_and_leaves_nothing(tmp_path):
    gap = history()
    gap["Y"][3] = math.nan
    strange = history().assign(wire=("t", np.zeros(40)))
    one = mixed().with_(runs=(run_of("gap", gap), run_of("strange", strange)), excluded=())
    with pytest.raises(CampaignError, match=r"(?s)run gap, column Y.*run strange, column wire"):
        pk.export(one, tmp_path / "folder")
    assert list(tmp_path.iterdir()) == []
    pk.export(one, tmp_path / "kept.nc")
    again = pk.open_campaign(tmp_path / "kept.nc")
    np.testing.assert_array_equal(again["gap"].data["Y"].values, gap["Y"].values)


def test_what_would_come_back_differently_is_not_left_there(small, tmp_path, monkeypatch):
    import pandas as pd

    whole = pd.DataFrame.to_csv
    monkeypatch.setattr(
        pd.DataFrame, "to_csv", lambda self, *a, **k: whole(self, *a, float_format="%.3g", **k)
    )
    with pytest.raises(CampaignError, match="not what was written"):
        pk.export(small, tmp_path / "rounded")
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_holds_a_campaign_is_left_alone(small, tmp_path):
    before = {file: file.read_bytes() for file in small.iterdir() if file.is_file()}
    for target in (small, small / "campaign.toml"):
        with pytest.raises(FileExists):
            pk.export(small, target, "csv")
    with pytest.raises(FileExists, match=r"holds a campaign\.toml"):
        pk.export(pk.open_campaign(small), small, "csv")
    assert before == {file: file.read_bytes() for file in small.iterdir() if file.is_file()}


@pytest.mark.slow
def test_corrections_of_samples_are_not_done_twice(tmp_path):
    folder = write_campaign(tmp_path / "small")
    text = (folder / "campaign.toml").read_text(encoding="utf-8")
    scale = '[[corrections]]\nruns = ["*"]\naction = "scale"\nchannels = ["X"]\nfactor = 2.0\n'
    (folder / "campaign.toml").write_text(f'{text}\n{scale}reason = "gauge"\n', encoding="utf-8")
    one = pk.open_campaign(folder)
    assert isinstance(one.runs[0].corrections[0], Correction)
    pk.export(one, tmp_path / "out")
    again = pk.open_campaign(tmp_path / "out")
    told = (tmp_path / "out" / "campaign.toml").read_text(encoding="utf-8")
    assert told.count("# Correction applied to *: scale (gauge)") == 1
    assert again.runs[0].corrections == ()
    same_data(one, again)


# --- Tracks ------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def turn(tmp_path_factory):
    out = tmp_path_factory.mktemp("turn")
    arguments = ["--speed", "1.179", "--no-figures", "--out", str(out)]
    assert main(["simulate", "kvlcc2-l7", *arguments]) == 0
    return out


def test_a_track_becomes_netcdf_with_units_and_metrics(turn, tmp_path):
    (file,) = pk.export(turn / "track.csv", tmp_path / "track.nc")
    track = pk.simulate("kvlcc2-l7", "turning", speed=1.179, compiled=False)
    with xr.open_dataset(file, engine="h5netcdf") as found:
        for name in ("t", "x", "y", "psi", "delta", "n"):
            np.testing.assert_array_equal(found[name].values, getattr(track, name))
        assert found["psi"].attrs["units"] == "rad"
        assert found.attrs["tactical_diameter_L"] == track.metrics["tactical_diameter_L"]
        assert found.attrs["name"] == "kvlcc2-l7"
    (twice,) = pk.export(turn / "track.csv", tmp_path / "twice.nc")
    assert twice.read_bytes() == file.read_bytes()
    (again,) = pk.export(track, tmp_path / "same.nc")
    with xr.open_dataset(again, engine="h5netcdf") as found:
        np.testing.assert_array_equal(found["y"].values, track.y)


def test_a_track_as_csv_has_units_and_is_a_run_of_a_campaign(turn, tmp_path):
    (file,) = pk.export(turn / "track.csv", tmp_path / "turn.csv")
    head, first = file.read_text(encoding="utf-8").splitlines()[:2]
    assert head.startswith("t [s],x [m],y [m],psi [rad],u [m/s]")
    assert first.startswith("0.0,0.0,")
    (tmp_path / "campaign.toml").write_text(
        '[campaign]\nkind = "free-running"\n[ship]\nname = "kvlcc2-l7"\n[[runs]]\nid = "T"\n'
        'test = "turning"\nfile = "turn.csv"\nspeed = 1.179\nrudder_deg = 35.0\n',
        encoding="utf-8",
    )
    track = pk.simulate("kvlcc2-l7", "turning", speed=1.179, compiled=False)
    data = pk.open_campaign(tmp_path)["T"].data
    np.testing.assert_array_equal(data["psi"].values, track.psi)
    (third,) = pk.export(file, tmp_path / "third.csv")
    assert third.read_bytes() == file.read_bytes()


def test_a_column_of_a_track_that_is_no_channel_is_named(turn, tmp_path):
    lines = (turn / "track.csv").read_text(encoding="utf-8").splitlines()
    more = [f"{line},{'helm' if index == 0 else index}" for index, line in enumerate(lines)]
    (tmp_path / "track.csv").write_text("\n".join(more) + "\n", encoding="utf-8")
    (file,) = pk.export(tmp_path / "track.csv", tmp_path / "out.nc")
    with xr.open_dataset(file, engine="h5netcdf") as found:
        assert found.attrs["left_out"] == "helm"
        assert "helm" not in found


def test_a_damaged_track_is_told_with_its_rows(turn, tmp_path):
    lines = (turn / "track.csv").read_text(encoding="utf-8").splitlines()
    lines[3] = lines[3].replace(",", ",x", 1)
    (tmp_path / "track.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    with pytest.raises(CampaignError, match=r"track\.csv.*row 4"):
        pk.export(tmp_path / "track.csv", tmp_path / "out.nc")
    assert not (tmp_path / "out.nc").exists()


# --- The word and the command ------------------------------------------------------------------


def test_what_does_not_suit_is_refused_with_what_does(table, tmp_path):
    with pytest.raises(DataError, match="A model is not written as csv: mss, shipmmg"):
        pk.export("mariner", tmp_path / "m.csv")
    with pytest.raises(DataError, match="no such file, folder or library ship"):
        pk.export("marinner", tmp_path / "m.m")
    with pytest.raises(DataError, match="Which format"):
        pk.export(table, tmp_path / "table.docx")
    with pytest.raises(DataError, match="is not known"):
        pk.export(table, tmp_path / "table", "word")
    with pytest.raises(FileExists, match="cannot be written"):
        pk.export("mariner", tmp_path, "mss", speed=7.0)
    with pytest.raises(DataError, match="needs the ending"):
        pk.export(table, tmp_path / "table.dat", "csv")
    with pytest.raises(DataError, match="cannot be exported"):
        pk.export(3, tmp_path / "table.m")
    (tmp_path / "notes.txt").write_text("hello", encoding="utf-8")
    with pytest.raises(DataError, match="nothing that can be exported"):
        pk.export(tmp_path / "notes.txt", tmp_path / "m.m")
    assert set(FORMATS) == {"model", "table", "campaign", "track"}


def test_the_command_writes_and_says_what(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["export", "kvlcc2-l7", "--to", "mss", "--speed", "1.179", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said == {"files": ["kvlcc2_l7.m"]}
    first = (tmp_path / "kvlcc2_l7.m").read_bytes()
    assert main(["export", "kvlcc2-l7", "-o", "kvlcc2_l7.m", "--speed", "1.179"]) == 0
    assert (tmp_path / "kvlcc2_l7.m").read_bytes() == first
    assert "Written: kvlcc2_l7.m" in capsys.readouterr().out


@pytest.mark.slow
def test_the_command_exports_a_campaign_and_back(small, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["export", str(small), "--to", "csv"]) == 0
    assert "small-csv: 25 files" in capsys.readouterr().out
    assert main(["export", "small-csv", "--to", "netcdf"]) == 0
    same_data(pk.open_campaign(small), pk.open_campaign(tmp_path / "small-csv.nc"))


def test_the_command_ends_as_others_do(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["export", "mariner", "--to", "mss"]) == 1
    assert "--speed" in capsys.readouterr().err
    assert main(["export", "mariner", "--to", "word"]) == 2
    assert main(["export", "mariner"]) == 2
    assert main(["export", "nowhere.nc", "--to", "csv", "--json"]) == 1
    assert list(tmp_path.iterdir()) == []
