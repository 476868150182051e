"""``pmmkit seakeeping``: a library ship, a hull from a file, and wrong requests."""

from __future__ import annotations

import csv

import numpy as np
import pytest
import xarray as xr
from commands import said

import pmmkit as pk
from pmmkit.base import DataError
from pmmkit.cli import main
from pmmkit.models.library import SHIPS
from pmmkit.seakeeping import motions
from pmmkit.seakeeping.strips import strips_of
from pmmkit.validation import joint

SEA = ["--hs", "4", "--tp", "9.7"]


@pytest.mark.slow
def test_a_library_ship_has_motions_responses_and_added_resistance(tmp_path, capsys):
    order = ["seakeeping", "kvlcc2", "--speeds", "15.5 kn", "--headings", "180,45", *SEA]
    status, content, _ = said(
        capsys, *order, "--place", "bow,150,8,20.8", "--no-figures", "--out", tmp_path / "out"
    )
    assert status == 0
    assert content["files"] == [
        "added_resistance.csv",
        "hull.gdf",
        "mean_added_resistance.csv",
        "rao.csv",
        "rao.nc",
        "responses.csv",
    ]
    assert any("Lewis forms" in note for note in content["notes"])
    assert {row["place"] for row in content["responses"]} == {"ship", "bow"}
    head, quartering = content["mean_added_resistance"]
    assert 2e5 < head["SNNM"] < 1e6
    assert quartering["STAWAVE-2"] is None
    with xr.open_dataset(tmp_path / "out" / "rao.nc") as data:
        assert data["heave_amplitude"].dims == ("speed", "heading", "omega")
        assert data["pitch_amplitude"].attrs["units"] == "rad m-1"
        assert data["speed"].attrs["standard_name"] == "platform_speed_wrt_sea_water"
        stored = data["heave_amplitude"].to_numpy().ravel()
    with (tmp_path / "out" / "rao.csv").open(newline="") as file:
        rows = [*csv.DictReader(file)]
    np.testing.assert_allclose([float(row["heave"]) for row in rows], stored, rtol=1e-12)


@pytest.mark.slow
def test_a_hull_from_offsets(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    lines = ["x,breadth,draught,area"]
    for x in np.linspace(-48, 48, 21):
        breadth = 16 * (1 - abs(x / 50) ** 3)
        lines.append(f"{x},{breadth},6,{0.8 * 6 * breadth}")
    (tmp_path / "boat.csv").write_text("\n".join(lines))
    order = ["seakeeping", "boat.csv", "--draught", "6", "--length", "100", "--speeds", "Fn 0.2"]
    assert main([*order, "--gyration", "6,25,25", "--gm", "1"]) == 0
    assert "Fn 0.200" in capsys.readouterr().out
    assert (tmp_path / "boat-seakeeping" / "rao.svg").exists()
    page = (tmp_path / "boat-seakeeping" / "report.html").read_text(encoding="utf-8")
    assert "boat in waves" in page
    assert "What each leaves out" in page


@pytest.mark.slow
def test_the_drift_of_a_sea_goes_into_a_model_file(tmp_path, capsys):
    order = ["seakeeping", "s175", "--speeds", "8", "--headings", "0,30,60,90,120,150,180"]
    out = tmp_path / "out"
    assert main([*order, "--hs", "4", "--tp", "8", "--no-figures", "--out", str(out)]) == 0
    plain = SHIPS["s175-3dof"].file.read_text(encoding="utf-8")
    (tmp_path / "rough.toml").write_text(plain + (out / "drift.toml").read_text(encoding="utf-8"))
    rough = pk.load_model(tmp_path / "rough.toml")
    calm, moved = (
        pk.simulate(model, rudder_deg=20, speed=8.0, compiled=False).metrics["advance_L"]
        for model in ("s175-3dof", rough)
    )
    assert moved < calm - 0.05


@pytest.mark.parametrize(
    ("options", "status", "says"),
    [
        (["boat.csv"], 2, "--draught"),
        (["kvlcc2", "--tp", "9"], 2, "--hs"),
        (["kvlcc2", "--gyration", "1,2"], 2, "roll,pitch,yaw"),
        (["kvlcc2", *SEA, "--place", "bow"], 2, "name,x"),
        (["kvlcc9"], 1, "kvlcc2"),
        (["kvlcc2", "--spreading", "2"], 2, "--hs"),
        (["kvlcc2", "--hs", "-3", "--tp", "8"], 1, "Hs = -3 must be 0 or more"),
        (["kvlcc2", "--sea-state", "12"], 2, "there are 0, 1"),
        (["kvlcc2", *SEA, "--sea-state", "5"], 2, "in place of"),
        (["kvlcc2", "--bilge-keels", "0,0"], 2, "state a sea"),
        (["kvlcc2", *SEA, "--bilge-keels", "0.4"], 2, "breadth,length"),
        (["kvlcc2", *SEA, "--bilge-keels", "0,0", "--roll-damping", "0.1"], 2, "leave"),
        (["kvlcc2", "--record", "none.csv"], 1, "none.csv"),
    ],
)
def test_a_wrong_request_says_what_to_write(options, status, says, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["seakeeping", *options]) == status
    assert says in capsys.readouterr().err
    assert not [*tmp_path.iterdir()]


@pytest.mark.slow
def test_a_turn_in_a_sea_drifts_and_rolls(tmp_path, capsys):
    order = ["simulate", "s175-3dof", "--rudder-deg", "20", "--speed", "8", "--no-figures"]
    waves = ["--wave-height", "4", "--wave-period", "8", "--waves-from-deg", "0", "--wave-motion"]
    _, calm, _ = said(capsys, *order, "--out", tmp_path / "calm")
    status, rough, _ = said(capsys, *order, *waves, "--seed", "3", "--out", tmp_path / "rough")
    assert status == 0
    assert rough["advance_L"] < calm["advance_L"] - 0.1
    with (tmp_path / "rough" / "wave_motion.csv").open(newline="") as file:
        rows = [*csv.DictReader(file)]
    elevation = np.array([float(row["elevation"]) for row in rows])
    assert 4 * np.std(elevation) == pytest.approx(4.0, rel=0.2)
    assert set(rows[0]) == {"t", "x", "y", "psi", "phi", "heave", "pitch", "elevation"}


@pytest.fixture
def computed(monkeypatch):
    """How often sections were solved."""
    hulls = []

    def counted(hull, *given, **options):
        hulls.append(hull)
        return strips_of(hull, *given, **options)

    monkeypatch.setattr(motions, "strips_of", counted)
    return hulls


@pytest.mark.slow
def test_drift_and_motion_come_from_one_strip_theory(computed, tmp_path, capsys):
    """At the speeds that are asked for; a model with a table of its own needs it for motions."""
    order = ["simulate", "s175-3dof", "--speed", "8", "--rudder-deg", "20", "--duration", "60"]
    waves = ["--wave-height", "4", "--wave-period", "8", "--no-figures"]
    speeds = ["--wave-speeds", "0,5,8"]
    assert main([*order, *waves, *speeds, "--wave-motion", "--out", str(tmp_path / "a")]) == 0
    assert len(computed) == 1
    assert "at 0, 5, 8 m/s" in capsys.readouterr().out
    plain = SHIPS["s175-3dof"].file.read_text(encoding="utf-8")
    own = tmp_path / "own.toml"
    own.write_text(f"{plain}\n{TABLE}", encoding="utf-8")
    order[1] = str(own)
    assert main([*order, *waves, "--out", str(tmp_path / "b")]) == 0
    assert len(computed) == 1
    assert "peak period of 12 s, this sea has 8 s" in capsys.readouterr().out
    assert main([*order, *waves, *speeds]) == 2
    assert "leave --wave-speeds out" in capsys.readouterr().err


TABLE = """[effects.wave_drift.options]
coefficients = "table"
[effects.wave_drift.values]
Hs = 3.0
Tp = 12.0
angle_deg = [0.0, 180.0]
DX = [-0.03, 0.01]
DY = [0.0, 0.0]
DN = [0.0, 0.0]
"""


@pytest.mark.parametrize(
    "half", [["--wave-period", "8"], ["--wave-height", "2"], ["--wave-motion"]]
)
def test_half_a_sea_is_refused(half, capsys):
    assert main(["simulate", "kcs", "--speed", "8", *half]) != 0
    assert "--wave-height 3 --wave-period 8" in capsys.readouterr().err


@pytest.mark.slow
def test_records_of_a_model_are_compared_in_the_sea_that_is_typed(tmp_path, monkeypatch, capsys):
    """The ship of 320 m is made the 7 m model of the records before it feels their waves."""
    model = pk.load_model("kvlcc2-l7")
    ship = [f"{key} = {getattr(model.ship, key)}" for key in ("L", "B", "d", "volume", "mass")]
    ship += [f"Izz = {model.ship.Izz}", f"xG = {model.ship.xG}"]
    run = ['id = "zz"', 'test = "zigzag"', 'file = "zz.csv"', "speed = 1.179", "rudder_deg = 20"]
    lines = ["[campaign]", 'kind = "free-running"', "[ship]", 'name = "model"', *ship]
    lines += ["[water]", "rho = 1000.0", "[[runs]]", *run, "switch_deg = 20"]
    (tmp_path / "campaign.toml").write_text("\n".join(lines), encoding="utf-8")
    track = pk.simulate(model, "zigzag", rudder_deg=20, speed=1.179, dt=0.5, compiled=False)
    columns = {name: getattr(track, name) for name in ("t", "x", "y", "psi", "r", "delta", "n")}
    table, head = np.column_stack([*columns.values()]), ",".join(columns)
    np.savetxt(tmp_path / "zz.csv", table, delimiter=",", header=head, comments="")
    seen = []

    def looked_at(sailed, campaign, **_):
        seen.append(sailed)
        raise DataError("Seen.")

    monkeypatch.setattr(joint, "compare", looked_at)
    waves = ["--wave-height", "0.12", "--wave-period", "1.5", "--waves-from-deg", "70"]
    assert main(["compare", "kvlcc2", str(tmp_path), *waves, "--out", str(tmp_path / "out")]) != 0
    assert "Seen." in capsys.readouterr().err
    (rough,) = seen
    assert rough.ship.L == 7.0
    drift = rough.values("wave_drift")
    assert (drift["Hs"], drift["Tp"], drift["from_deg"]) == (0.12, 1.5, 70.0)
    assert drift["speeds"] == (0.0, 1.179)


@pytest.mark.slow
def test_no_tank_has_waves_while_a_model_is_towed(tmp_path, capsys):
    order = ["compare", "s175-3dof", "datasets/s175", "--wave-height", "1", "--wave-period", "3"]
    assert main([*order, "--out", str(tmp_path)]) != 0
    assert "calm" in capsys.readouterr().err


@pytest.mark.slow
def test_a_spread_sea_by_its_state_and_where_the_ship_can_sail(tmp_path, capsys):
    """In head seas a ship rolls only where they are spread; of those no drift is written."""
    headings = "0,30,60,90,120,150,180"
    order = ["seakeeping", "s175-design", "--speeds", "0,8", "--headings", headings, "--no-figures"]
    sea = ["--sea-state", "5", "--place", "bow,80,8,9.5"]
    long, spread = (
        said(capsys, *order, *sea, *more, "--out", tmp_path / name)[1]
        for name, more in (("long", []), ("spread", ["--spreading", "2"]))
    )
    assert "drift.toml" in long["files"]
    assert "drift.toml" not in spread["files"]
    assert "operability.csv" in spread["files"]
    assert 0.0 < spread["operable_share"] <= 1.0
    roll = [
        next(
            row["significant"]
            for row in content["responses"]
            if (row["heading_deg"], row["speed"], row["response"]) == (180.0, 8.0, "roll")
        )
        for content in (long, spread)
    ]
    assert roll[0] < 1e-9 < 1e-3 < roll[1]


@pytest.mark.slow
def test_records_of_a_tank_stand_beside_the_computed_motions(tmp_path, monkeypatch, capsys):
    """A model of 1:40 in head waves of three lengths, which only follows them."""
    monkeypatch.chdir(tmp_path)
    t = np.arange(0.0, 40.0, 0.05)
    for number, omega in enumerate((3.6, 4.0, 4.5)):
        wave = 20.0 * np.cos(omega * t)
        table = np.column_stack([t, wave, 0.9 * wave])
        np.savetxt(f"run{number}.csv", table, delimiter=",", header="t,wave [mm],heave [mm]",
                   comments="")  # fmt: skip
    order = ["seakeeping", "s175-design", "--record", "run*.csv", "--record-scale", "40"]
    status, content, _ = said(capsys, *order, "--no-figures", "--out", tmp_path / "out")
    assert status == 0
    assert set(content["records"]["kinds"].values()) == {"regular"}
    with (tmp_path / "out" / "measured.csv").open(newline="") as file:
        rows = [*csv.DictReader(file)]
    assert [float(row["measured"]) for row in rows] == pytest.approx([0.9] * 3, abs=1e-3)
    assert main([*order, "--headings", "180,90"]) == 2
    assert "one heading" in capsys.readouterr().err


@pytest.mark.slow
def test_bilge_keels_damp_the_roll_at_its_resonance(tmp_path, capsys):
    """Waves from abeam with the period of roll: half a metre of keel takes a fifth of it."""
    order = [
        "seakeeping",
        "s175-design",
        "--gm",
        "1",
        "--headings",
        "90",
        "--hs",
        "4",
        "--tp",
        "20",
    ]
    roll = {
        keels: next(
            row["significant"]
            for row in said(
                capsys, *order, "--bilge-keels", keels, "--no-figures", "--out", tmp_path / keels
            )[1]["responses"]
            if row["response"] == "roll"
        )
        for keels in ("0,0", "0.5,44")
    }
    assert 0.4 < roll["0.5,44"] / roll["0,0"] < 0.8


@pytest.mark.slow
def test_transfer_functions_of_another_program_in_a_sea(tmp_path, shared_data, capsys):
    file = shared_data / "s175_seakeeping_veres" / "input.re1"
    status, content, _ = said(
        capsys, "seakeeping", file, *SEA, "--no-figures", "--out", tmp_path / "out"
    )
    assert status == 0
    assert {"drift.toml", "operability.csv", "responses.csv"} <= set(content["files"])
    assert "VERES 4.02.3" in (tmp_path / "out" / "drift.toml").read_text()
    assert len(content["mean_added_resistance"]) == 5 * 19
    assert {*content["mean_added_resistance"][0]} == {"speed", "heading_deg", "VERES 4.02.3"}


def test_what_is_computed_is_not_asked_of_what_is_read(tmp_path, capsys):
    (tmp_path / "a.re1").write_text("")
    assert main(["seakeeping", str(tmp_path / "a.re1"), "--speeds", "5", "--omega", "1"]) != 0
    assert "--speeds, --omega" in capsys.readouterr().err
