"""``pmmkit new-campaign``: a draft of a campaign file from the files that lie in a folder."""

from __future__ import annotations

import json
import math
import os
import shutil
import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pmmkit import open_campaign
from pmmkit.base import CampaignError
from pmmkit.cli import main
from pmmkit.intake.drafts.motion import motion_facts
from pmmkit.intake.drafts.names import facts_of
from pmmkit.intake.drafts.questions import questions_of
from pmmkit.intake.guessing import suggest
from pmmkit.intake.under_way import track_told
from pmmkit.models import read_table
from tests.support.free_tank.campaigns import Setup, records
from tests.support.small_campaign import SHIP


@pytest.fixture(scope="module")
def s175(datasets):
    return open_campaign(datasets / "s175")


@pytest.fixture(scope="module")
def fast(s175):
    """Its 21 runs at the middle speed."""
    return s175.with_(runs=tuple(run for run in s175 if run.settings.speed == 1.5))


def drafted(capsys, *arguments):
    """Status, JSON and words of the command."""
    status = main(["new-campaign", *map(str, arguments), "--json"])
    output = capsys.readouterr()
    return status, json.loads(output.out), output.err


def exported(campaign, folder: Path, *, motion: bool, name=lambda run: run.id) -> Path:
    """The runs of a campaign as text files of a tank: time, forces and, if asked, the motion."""
    folder.mkdir(parents=True)
    for run in campaign:
        data = run.data
        t = data["t"].values
        columns = {
            "Time [s]": t,
            "Fx [N]": data["X"].values,
            "Fy [N]": data["Y"].values,
            "Mz [Nm]": data["N"].values,
        }
        if motion:
            state = run.nominal_motion(t)
            columns |= {
                "u [m/s]": state.u,
                "v [m/s]": state.v,
                "yaw rate [deg/s]": np.degrees(state.r),
            }
        np.savetxt(
            folder / f"{name(run)}.csv",
            np.column_stack(list(columns.values())),
            fmt="%.6g",
            delimiter=";",
            header=";".join(columns),
            comments="",
        )
    return folder


def filled_in(folder: Path, *, ship: str = SHIP) -> None:
    """What a person would type: the ship."""
    path = folder / "campaign.toml"
    text = path.read_text(encoding="utf-8")
    head, _, rest = text.partition("[ship]")
    rest = rest[rest.index("[water]") :]
    path.write_text(head + ship + rest, encoding="utf-8")


def as_the_real_one(found, real, *, period: float = 1e-3) -> list[str]:
    """Runs whose test and settings agree with the real campaign."""
    right = []
    for run in found:
        true, had = real[run.id].settings, run.settings
        same = run.test == real[run.id].test and math.isclose(had.speed, true.speed, rel_tol=0.005)
        same &= abs(had.drift - true.drift) < math.radians(0.05)
        for name, close in (("period", period), ("amplitude", 0.01), ("yaw_amplitude", 0.01)):
            mine, theirs = getattr(had, name), getattr(true, name)
            same &= (mine is None) == (theirs is None) and (
                mine is None or math.isclose(mine, theirs, rel_tol=close)
            )
        if same:
            right.append(run.id)
    return right


def test_a_saved_campaign_gives_all_its_runs_back(datasets, s175, tmp_path, capsys):
    shutil.copy(datasets / "s175" / "runs.h5", tmp_path)
    status, content, _ = drafted(capsys, tmp_path)
    assert status == 0
    assert content["complete"] == 63
    found = open_campaign(tmp_path)
    assert len(as_the_real_one(found, s175)) == 63
    assert found.ship.L == s175.ship.L
    np.testing.assert_array_equal(found["PY_U1.0_r0.4"].data["Y"], s175["PY_U1.0_r0.4"].data["Y"])


@pytest.mark.slow
def test_names_and_recorded_motion_give_all_runs(fast, tmp_path, capsys):
    folder = exported(fast, tmp_path / "tank", motion=True)
    status, content, words = drafted(capsys, folder)
    assert (status, content["complete"]) == (0, 21)
    assert "21 of 21 entries need nothing more" in words
    filled_in(folder)
    found = open_campaign(folder)
    assert len(as_the_real_one(found, fast)) == 21
    run = found["YD_U1.5_b-08_r0.5"]
    np.testing.assert_allclose(run.data["Y"], fast[run.id].data["Y"], rtol=1e-5, atol=1e-4)


@pytest.mark.slow
def test_recorded_motion_alone_gives_all_runs(fast, tmp_path, capsys):
    """Files that are only numbered: kind, speed, drift, period and amplitudes by the record."""
    numbers = {run.id: f"run_{place:03d}" for place, run in enumerate(fast)}
    folder = exported(fast, tmp_path / "tank", motion=True, name=lambda run: numbers[run.id])
    assert drafted(capsys, folder)[0] == 0
    filled_in(folder)
    names = {number: run_id for run_id, number in numbers.items()}
    found = [run.with_(id=names[run.id]) for run in open_campaign(folder)]
    assert len(as_the_real_one(found, fast)) == 21


@pytest.mark.slow
def test_without_motion_the_amplitudes_are_left_to_a_person(fast, tmp_path, capsys):
    """Names and forces: static runs whole, of oscillating ones all but the amplitude."""
    folder = exported(fast, tmp_path / "tank", motion=False)
    _, content, words = drafted(capsys, folder)
    assert content["complete"] == 9
    assert "v_amplitude, a number in the name: is it that?: PS_" in words
    filled_in(folder)
    with pytest.raises(CampaignError, match="amplitude_m") as caught:
        open_campaign(folder)
    assert len(caught.value.problems) == 12
    path = folder / "campaign.toml"
    text = path.read_text(encoding="utf-8")
    assert "# v_amplitude = 0.08" in text
    assert "# TODO v0.08, if it is the sway velocity over U; else amplitude_m = ..." in text
    path.write_text(
        text.replace("# v_amplitude", "v_amplitude").replace("# r_amplitude", "r_amplitude"),
        encoding="utf-8",
    )
    right = as_the_real_one(open_campaign(folder), fast, period=4e-3)
    assert len(right) == 21


@pytest.mark.slow
def test_what_is_unknown_is_asked_for_by_open_campaign(s175, tmp_path, capsys):
    exported(s175.select("pure_sway"), tmp_path / "tank", motion=True)
    assert drafted(capsys, tmp_path / "tank")[0] == 0
    with pytest.raises(CampaignError) as caught:
        open_campaign(tmp_path / "tank")
    said = str(caught.value)
    assert "[ship]: L, B, d, Izz, mass or volume are missing" in said
    assert len(caught.value.problems) == 1


@pytest.mark.slow
def test_a_library_ship_is_named(s175, tmp_path, capsys):
    folder = exported(s175.select("pure_sway"), tmp_path / "tank", motion=True)
    status, _, words = drafted(capsys, folder, "--ship", "s175")
    assert status == 0
    assert "one scale" in words
    assert open_campaign(folder).ship.L == 175.0
    assert main(["new-campaign", str(folder), "--force", "--ship", "s177"]) == 1
    assert "has no ship 's177'" in capsys.readouterr().err


@pytest.mark.slow
def test_a_file_is_not_replaced_unless_told(s175, tmp_path, capsys):
    folder = exported(s175.select("pure_sway"), tmp_path / "tank", motion=True)
    (folder / "campaign.toml").write_text("mine", encoding="utf-8")
    assert main(["new-campaign", str(folder)]) == 1
    assert "was not replaced" in capsys.readouterr().err
    assert (folder / "campaign.toml").read_text(encoding="utf-8") == "mine"
    assert main(["new-campaign", str(folder), "-o", str(tmp_path / "else.toml")]) == 0
    assert 'file = "tank/PS_U1.0_v0.08.csv"' in (tmp_path / "else.toml").read_text("utf-8")
    assert main(["new-campaign", str(folder), "--force"]) == 0
    assert (folder / "campaign.toml").read_text(encoding="utf-8") != "mine"


def test_two_layouts_and_names_that_toml_must_escape(tmp_path, capsys):
    """Two tanks, two layouts: each run is read by its own columns, whatever the headers hold."""
    t = np.arange(0.0, 30.0, 0.1)
    rng = np.random.default_rng(3)
    one = np.column_stack([t, *rng.normal(size=(3, len(t)))])
    (tmp_path / "a b").mkdir()
    for beta in (4, 8):
        np.savetxt(
            tmp_path / f"drift_U1.2_beta{beta}deg.dat",
            one,
            fmt="%.4f",
            header='Tank 2, \\ "test"\nTime\tF"x [N]\tSide force [N]\tYaw moment [Nm]',
            comments="",
            delimiter="\t",
        )
    np.savetxt(
        tmp_path / "a b" / "beta=-6_U1.2.csv",
        one * [1, 1e-3, 1e-3, 1e-3],
        fmt="%.6f",
        header="t,X [kN],Y [kN],N [kN m]",
        comments="",
        delimiter=",",
    )
    assert drafted(capsys, tmp_path)[0] == 0
    text = (tmp_path / "campaign.toml").read_text(encoding="utf-8")
    raw = tomllib.loads(text)
    assert raw["source"]["skip_rows"] == 1
    assert {run["id"] for run in raw["runs"]} == {
        "drift_U1.2_beta4deg",
        "drift_U1.2_beta8deg",
        "beta=-6_U1.2",
    }
    assert 'X = "F\\"x [N]"' in text
    text = text.replace("# test = ...", 'test = "static_drift" #')
    (tmp_path / "campaign.toml").write_text(text, encoding="utf-8")
    filled_in(tmp_path)
    campaign = open_campaign(tmp_path)
    for run in campaign:
        np.testing.assert_allclose(run.data["N"], one[:, 3], atol=1e-3)
        np.testing.assert_allclose(run.data["X"], one[:, 1], atol=1e-3)
    assert campaign["drift_U1.2_beta8deg"].settings.drift == pytest.approx(math.radians(8))


def test_a_broken_file_among_good_ones_is_named(s175, tmp_path, capsys):
    folder = exported(s175.select("pure_sway"), tmp_path / "tank", motion=True)
    good = (folder / "PS_U1.0_v0.16.csv").read_bytes()
    (folder / "PS_U1.0_v0.16.csv").write_bytes(good[:20000] + b";;;;;;;;;\n" + good[20100:])
    (folder / "PS_U1.5_v0.08.csv").write_bytes(b"")
    status, content, words = drafted(capsys, folder)
    assert status == 0
    assert len(content["runs"]) == 8
    assert "PS_U1.0_v0.16" in "".join(line for line in words.splitlines() if "damaged" in line)
    text = (folder / "campaign.toml").read_text(encoding="utf-8")
    assert "PS_U1.5_v0.08.csv: the file is empty (0 bytes)." in text
    (damaged,) = [run for run in content["runs"] if run["id"] == "PS_U1.0_v0.16"]
    assert damaged["settings"]["amplitude_m"] == pytest.approx(0.4861, rel=0.01)


def test_name_and_record_that_disagree_are_shown(tmp_path, capsys):
    t = np.arange(0.0, 20.0, 0.1)
    beta = math.radians(-8.0)
    rows = np.column_stack(
        [t, 0 * t - 3, 0 * t + 9, 0 * t + 5, 0 * t + math.cos(beta), 0 * t - math.sin(beta)]
    )
    np.savetxt(
        tmp_path / "SD_U1.0_b+08.csv", rows, header="t,X,Y,N,u,v", comments="", delimiter=","
    )
    _, content, _ = drafted(capsys, tmp_path)
    text = (tmp_path / "campaign.toml").read_text(encoding="utf-8")
    assert "TODO the name says 8, the record (recorded u and v) -8: which is right?" in text
    assert content["complete"] == 0


def test_a_table_with_a_line_of_units(tmp_path, capsys):
    """Rows are runs; the line of units is none of them, and its units count."""
    (tmp_path / "oblique towing.txt").write_text(
        "Run;Speed;Beta;Fx;Fy;Mz\n-;mm/s;deg;N;N;kNm\n"
        "7;1200;-4;-3,1;-9,5;-0,02\n8;1200;0;-2,9;0,1;0\n9;1200;4;-3,1;9,4;0,021\n",
        encoding="utf-8",
    )
    status, content, _ = drafted(capsys, tmp_path)
    assert (status, content["complete"]) == (0, 1)
    filled_in(tmp_path)
    campaign = open_campaign(tmp_path)
    assert [run.id for run in campaign] == [f"oblique towing_{n}" for n in (7, 8, 9)]
    last = campaign["oblique towing_9"]
    assert (last.test, last.settings.speed) == ("static_drift", pytest.approx(1.2))
    assert last.settings.drift == pytest.approx(math.radians(4))
    assert float(last.data["N"]) == pytest.approx(21.0)


def test_a_saved_campaign_beside_new_files(datasets, s175, tmp_path, capsys):
    """Runs of both are read, each by its own columns."""
    exported(s175.select("static_drift"), tmp_path / "again", motion=False)
    shutil.copy(datasets / "s175" / "runs.h5", tmp_path)
    _, content, _ = drafted(capsys, tmp_path)
    assert content["complete"] == 63 + 27
    campaign = open_campaign(tmp_path)
    one, two = campaign["again_SD_U1.0_b-12"].data, campaign["SD_U1.0_b-12"].data
    np.testing.assert_allclose(one["Y"], two["Y"], rtol=1e-5, atol=1e-4)


def test_cases_of_openfoam_are_runs(tmp_path, capsys):
    """Folders are files of runs, named with a point in the speed; forces are where they stand."""
    t = np.arange(1, 60) * 0.5
    for beta in (0, 6):
        folder = tmp_path / f"drift_U1.2_b+{beta:02d}" / "postProcessing" / "forces" / "0"
        folder.mkdir(parents=True)
        for name in ("force", "moment"):
            head = (
                f"# {name.title()}\n# CofR        : (0 0 0)\n#\n# Time        \ttotal_x total_y "
                "total_z\tpressure_x pressure_y pressure_z\tviscous_x viscous_y viscous_z\n"
            )
            rows = "".join(f"{x:g} 1 {beta} 3 1 {beta} 3 0 0 0\n" for x in t)
            (folder / f"{name}.dat").write_text(head + rows, encoding="utf-8")
    status, content, words = drafted(capsys, tmp_path)
    assert (status, content["complete"]) == (0, 2)
    assert "half or whole ship" in words
    filled_in(tmp_path)
    campaign = open_campaign(tmp_path)
    run = campaign["drift_U1.2_b+06"]
    assert (run.settings.speed, math.degrees(run.settings.drift)) == pytest.approx((1.2, 6.0))
    np.testing.assert_array_equal(run.data["Y"], np.full(len(t), 6.0))


def cases(folder: Path, densities: dict[str, float]) -> None:
    """Cases of OpenFOAM, each with the density of its controlDict."""
    for name, density in densities.items():
        results = folder / name / "postProcessing" / "forces" / "0"
        results.mkdir(parents=True)
        head = "# Time\t" + "\t".join(
            f"{part}_x {part}_y {part}_z" for part in ("total", "pressure", "viscous")
        )
        rows = "".join(f"{0.5 * k:g} 1 2 3 1 2 3 0 0 0\n" for k in range(1, 60))
        for part in ("Force", "Moment"):
            text = f"# {part}\n# CofR : (0 0 0)\n#\n{head}\n{rows}"
            (results / f"{part.lower()}.dat").write_text(text, encoding="utf-8")
        (folder / name / "system").mkdir()
        (folder / name / "system" / "controlDict").write_text(
            f"functions {{ forces {{ type forces; rho rhoInf; rhoInf {density}; }} }}\n",
            encoding="utf-8",
        )


def test_the_density_of_a_computation_is_read(tmp_path, capsys):
    cases(tmp_path, {"drift_U1.2_b+00": 1.0, "drift_U1.2_b+06": 1.0})
    _, content, _ = drafted(capsys, tmp_path)
    assert any("rho_inf = 1" in item for item in content["todo"]), "a person is asked"
    filled_in(tmp_path)
    run = open_campaign(tmp_path)["drift_U1.2_b+06"]
    np.testing.assert_allclose(run.data["Y"], 2.0 * 999.1)


def test_densities_that_differ_stand_with_their_runs(tmp_path, capsys):
    cases(tmp_path, {"drift_U1.2_b+00": 1.0, "drift_U1.2_b+06": 998.0})
    drafted(capsys, tmp_path)
    filled_in(tmp_path)
    found = open_campaign(tmp_path)
    np.testing.assert_allclose(found["drift_U1.2_b+00"].data["Y"], 2.0 * 999.1)
    np.testing.assert_allclose(found["drift_U1.2_b+06"].data["Y"], 2.0 * 999.1 / 998.0)


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="names that Windows does not allow")
@settings(max_examples=40)
@given(
    name=st.text(
        alphabet=st.characters(exclude_characters="/\0\\", exclude_categories=("Cs",)),
        min_size=1,
        max_size=40,
    )
)
def test_any_name_of_a_file_gives_a_file_that_opens(name, tmp_path_factory):
    folder = tmp_path_factory.mktemp("names")
    file = folder / f"x{name}.csv"
    file.write_text("t,X,Y,N\n" + "".join(f"{n / 10},1,2,{n % 3}\n" for n in range(40)), "utf-8")
    assert main(["new-campaign", str(folder)]) == 0
    (run,) = tomllib.loads((folder / "campaign.toml").read_text("utf-8"))["runs"]
    assert (folder / run["file"]).samefile(file)
    shutil.rmtree(folder)


@pytest.mark.parametrize(
    ("name", "test", "stated"),
    [
        ("SD_U1.5_b+08", "static_drift", {"speed": 1.5, "drift_deg": 8.0}),
        ("static drift/U1.0/beta12deg", "static_drift", {"speed": 1.0, "drift_deg": 12.0}),
        ("PMM_sway_T12.5_a0.2", "pure_sway", {"period": 12.5, "amplitude_m": 0.2}),
        ("ZZ10-10", "zigzag", {"rudder_deg": 10.0, "switch_deg": 10.0}),
        ("HSVA_CPMC_KVLCC2_Z_10_05", "zigzag", {"rudder_deg": 10.0, "switch_deg": 5.0}),
        ("zigzag_31-Jul-2020_13_04_24", "zigzag", {}),
        ("FREE_KVLCC2_tc_-35_m", "turning", {"rudder_deg": -35.0}),
        ("TC35S", "turning", {"rudder_deg": 35.0}),
        ("turning_circle_port_35", "turning", {"rudder_deg": 35.0}),
        ("turn_12", "turning", {}),
        ("turning_10_+15", "turning", {}),
        ("turn_14-Oct-2020_14_29_49", "turning", {}),
        ("STC_12", None, {}),
        ("FREE_KVLCC2_zz_-10_m", "zigzag", {"rudder_deg": -10.0, "switch_deg": 10.0}),
        ("zigzag2010", "zigzag", {"rudder_deg": 20.0, "switch_deg": 10.0}),
        ("zz1010_S", "zigzag", {"rudder_deg": 10.0, "switch_deg": 10.0}),
        ("HSVA_Z20", "zigzag", {"rudder_deg": 20.0, "switch_deg": 20.0}),
        ("T0Z05A01", None, {}),
        ("results/sheet Z05A", None, {}),
        ("s175_mss_turn_U12_d+35", "turning", {"speed": 12.0, "rudder_deg": 35.0}),
        ("delta35_turning", "turning", {"rudder_deg": 35.0}),
        ("Fn0.26/drift/beta_12", "static_drift", {"froude": 0.26, "drift_deg": 12.0}),
        ("pure_yaw_Fn026_T10s", "pure_yaw", {"froude": 0.26, "period": 10.0}),
        ("PY_U1_b+4", "yaw_drift", {"speed": 1.0, "drift_deg": 4.0}),
        ("StaticDrift_Beta-12", "static_drift", {"drift_deg": -12.0}),
        ("sway_a50mm_0.1Hz", "pure_sway", {"amplitude_m": 0.05, "frequency_hz": 0.1}),
        ("rotating_arm_R+12.0m_b-04", "circular_motion", {"radius": 12.0, "drift_deg": -4.0}),
        ("R12_drift_b4", "static_drift", {"drift_deg": 4.0}),
        ("heel_phi+05_b+06", "static_heel", {"heel_deg": 5.0, "drift_deg": 6.0}),
        ("drift_8_5kn", "static_drift", {"drift_deg": 8.0, "speed": 5 * 1852 / 3600}),
        ("V424 sway a=0,25 m T=9,0 s", "pure_sway", {"amplitude_m": 0.25, "period": 9.0}),
        ("V424-PS-A0.25-T9.0", "pure_sway", {"amplitude_m": 0.25, "period": 9.0}),
        ("sway_a025_T9_V1.2", "pure_sway", {"amplitude_m": 0.25, "period": 9.0, "speed": 1.2}),
        ("sway_w0.5_A.25", "pure_sway", {"frequency_hz": 0.5 / (2 * math.pi), "amplitude_m": 0.25}),
        ("yaw_A15_T9", "pure_yaw", {"yaw_amplitude_deg": 15.0, "period": 9.0}),
        ("yaw_A15deg_T9", "pure_yaw", {"yaw_amplitude_deg": 15.0, "period": 9.0}),
        ("yaw_A0.25m_T9", "pure_yaw", {"path_amplitude_m": 0.25, "period": 9.0}),
        ("beta = -8 deg, drift", "static_drift", {"drift_deg": -8.0}),
        ("V424_drift", "static_drift", {}),
        ("run_001", None, {}),
        ("KVLCC2_2012", None, {}),
    ],
)
def test_what_names_say(name, test, stated):
    found = facts_of(name)
    assert found.test == test
    assert {key: value for key, (value, _) in found.settings.items()} == pytest.approx(stated)


@pytest.mark.parametrize(
    ("name", "alone"),
    [
        ("V424_sway_0.25m_9.0s_1.2mps", {"amplitude_m": 0.25, "period": 9.0}),
        ("V424_yaw_15deg_9s", {"yaw_amplitude_deg": 15.0, "period": 9.0}),
        ("V424_yaw_15deg_4deg_9s", {"period": 9.0}),
        ("V424_8deg", {}),
    ],
)
def test_a_number_with_a_unit_alone_is_what_it_can_only_be(name, alone):
    found = facts_of(name)
    assert {key: value for key, (value, _) in found.alone.items()} == pytest.approx(alone)
    assert not {*alone} & {*found.settings}


@pytest.mark.parametrize("phase", [0.0, 90.0, -120.0])
def test_the_phase_of_the_motion_is_read(phase):
    t = np.arange(0.0, 60.0, 0.05)
    omega, shift = 0.6, math.radians(phase)
    v = 0.1 * omega * np.cos(omega * t + shift)
    found = motion_facts(t, {"u": np.full_like(t, 1.0), "v": v}, "pure_sway").settings
    assert found.get("phase_deg", (0.0, ""))[0] == pytest.approx(phase, abs=0.1)
    assert found["amplitude_m"][0] == pytest.approx(0.1, rel=1e-3)
    y = 0.1 * np.sin(omega * t + shift)
    again = motion_facts(t, {"y": y}, "pure_sway").settings
    assert again.get("phase_deg", (0.0, ""))[0] == pytest.approx(phase, abs=0.1)


def test_noise_is_no_oscillation():
    rng = np.random.default_rng(5)
    t = np.arange(0.0, 60.0, 0.05)
    noise = {"u": 1.0 + 0.03 * rng.normal(size=len(t)), "v": 0.03 * rng.normal(size=len(t))}
    assert "period" not in motion_facts(t, noise, None).settings
    forces = {"Y": rng.normal(size=len(t)), "N": rng.normal(size=len(t))}
    assert "period" not in motion_facts(t, forces, "pure_sway").settings


def test_zigzags_of_hsva_are_told_by_their_names_and_columns_without_one_by_their_motion(
    shared_data, tmp_path, capsys
):
    """Columns as its README found them by differentiating; a rudder to port is positive."""
    folder = shared_data / "kvlcc2_hsva_free"
    status, content, _ = drafted(capsys, folder, "-o", tmp_path / "campaign.toml")
    assert (status, content["kind"]) == (0, "free-running")
    orders = {
        run["id"][17:]: (run["settings"]["rudder_deg"], run["settings"]["switch_deg"])
        for run in content["runs"]
    }
    assert orders["Z_35_05"] == (-35.0, 5.0)
    assert (orders["Z_10_10_P"], orders["Z_10_10_S"]) == ((10.0, 10.0), (-10.0, 10.0))
    assert len(orders) == 13
    written = (tmp_path / "campaign.toml").read_text("utf-8")
    told = tomllib.loads(written)
    places = {name: own["column"] for name, own in told["columns"].items()}
    assert places == {"t": 1, "x": 2, "y": 3, "psi": 4, "xdot": 5, "ydot": 6, "r": 7, "delta": 9}
    assert told["columns"]["r"]["unit"] == "deg/s"
    assert told["campaign"]["rudder_positive"] == "port"
    ship = {"L": 7.0, "B": 1.269, "d": 0.455, "volume": 3.27, "mass": 3272.0, "Izz": 9909.0}
    assert told["ship"] == {**ship, "xG": 0.2436}
    assert told["water"] == {"rho": 1000.0}
    assert told["propeller"]["open_water"].endswith("open_water_INSEAN_propeller.csv")
    assert [item.key for item in questions_of(written)] == ["campaign.rudder_positive", "columns.n"]
    assert '# n = { column = 10, unit = "rps" } # TODO perhaps: held throughout' in written


def test_a_track_without_rudder_and_revolutions_is_asked_for_them(tmp_path, capsys):
    """No model can be compared with it; a trial can be measured."""
    record = next(iter(records(Setup(ship="kvlcc2-l7", runs=3, seed=1)).values()))
    rows = np.column_stack([record[name] for name in ("t", "x", "y", "psi")])
    np.savetxt(tmp_path / "zz_10_10.csv", rows, delimiter=",", header="t,x,y,psi", comments="")
    status, *_ = drafted(capsys, tmp_path, "-o", tmp_path / "campaign.toml")
    written = (tmp_path / "campaign.toml").read_text("utf-8")
    assert status == 0
    for name, means in (("delta", "the rudder angle"), ("n", "the revolutions of the propeller")):
        assert f"# {name} = ...   # TODO which column is {means}" in written


def without_names(table, title=""):
    """What columns are taken for by their numbers alone."""
    headers = ["", *(title and f"{title} {k}" for k in range(1, len(table)))]
    values = dict(enumerate(table))
    return track_told(suggest(headers, [None] * len(table), values), headers, values)


@pytest.mark.parametrize("unit", ["deg", "rad"])
@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("seed", range(4))
def test_the_track_of_a_ship_is_told_without_names_in_any_order(unit, side, seed):
    """Records of a tank that shares no code with the package, noise of its instruments in them."""
    factor = {"deg": 180.0 / math.pi, "rad": 1.0}[unit]
    rng = np.random.default_rng(seed)
    for record in records(Setup(ship="kvlcc2-l7", runs=3, seed=seed)).values():
        angles = {name: factor * record[name] for name in ("psi", "delta", "r")}
        kept = {"x": record["x"], "y": side * record["y"], "n": record["n"], **angles}
        names = list(rng.permutation(list(kept)))
        table = [record["t"], *(kept[name] for name in names)]
        found = without_names(table, title="Kanal" if seed % 2 else "")
        told = {names[k - 1]: item for k, item in enumerate(found) if item and k}
        assert {name: item.name for name, item in told.items()} == {
            name: name for name in ("x", "y", "psi", "delta", "r", "n") if name in told
        }
        assert {"x", "y", "psi", "delta", "n"} <= set(told)
        assert (told["n"].certainty, told["n"].unit) == ("perhaps", "rps")
        assert (told["psi"].unit, told["delta"].unit, told["y"].scale) == (unit, unit, side)


def test_columns_that_wander_are_no_track():
    rng = np.random.default_rng(3)
    t = np.arange(0.0, 100.0, 0.1)
    for _ in range(100):
        walks = np.cumsum(rng.standard_normal((6, len(t))), axis=1) * rng.uniform(0.01, 1.0, (6, 1))
        assert [item.name for item in without_names([t, *walks]) if item] == ["t"]


def test_a_towed_hull_that_goes_to_and_fro_is_no_ship_under_way():
    """Pure sway with the carriage's place and its sway, and gauges: no heading follows a course."""
    t = np.arange(0.0, 60.0, 0.05)
    sway = 0.25 * np.sin(0.6 * t)
    gauges = [20.0 * np.cos(0.6 * t), 8.0 * np.sin(0.6 * t), -3.0 * np.cos(0.6 * t + 0.3)]
    told = without_names([t, 1.2 * t, sway, *gauges])
    assert [item and item.name for item in told] == ["t", *[None] * 5]


def test_a_table_of_static_tests_in_prime_units_goes_through_as_it_lies(tmp_path, capsys):
    """Run numbers that are used twice, a rate of turn that is nought, a system told by the primes
    of its headers, a rudder that is positive to port: the derivatives are those that the table was
    made of."""
    rng = np.random.default_rng(1)
    rows = ["Run No.,beta(deg),delta(deg),r,Speed(m/s),rps,X',Y',N',test type"]
    cases = [(b, 0, "drift angle") for b in range(-12, 13, 2)]
    cases += [(0, d, "rudder angle") for d in range(-20, 21, 5)]
    cases += [(b, d, "drift + rudder angle") for b in (-8, 8) for d in (-10, 10)]
    for beta, delta, kind in cases:
        v, d = -math.sin(math.radians(beta)), math.radians(delta)
        X = -0.0003 - 0.004 * v**2 - 0.0012 * d**2
        Y = -0.0235 * v - 0.040 * v**3 + 0.0044 * d
        N = -0.0073 * v + 0.003 * v**3 - 0.0021 * d
        told = [f"{x + 2e-6 * rng.standard_normal():.4E}" for x in (X, Y, N)]
        rows.append(f"{300 + abs(beta)},{beta},{delta},0,1.17,9.9,{','.join(told)},{kind}")
    (tmp_path / "tests").mkdir()
    (tmp_path / "tests" / "captive.csv").write_text("\n".join(rows) + "\n")
    (tmp_path / "tests" / "ship.yml").write_text(
        "L: 7.0\nB: 1.27\nT: 0.46\nm: 3270\nvolume: 3.27\nI_z: 10014\n"
    )
    out = tmp_path / "first"
    status = main(["demo", "--my-data", str(tmp_path / "tests"), "--out", str(out), "--json"])
    told = json.loads(capsys.readouterr().out)
    assert (status, told["result"]["structure"]) in ((0, "abkowitz3"), (3, "abkowitz3"))
    found = read_table(out / "results" / "derivatives.csv")
    for name, value in {"Yv": -0.0235, "Nv": -0.0073, "Yd": -0.0044, "Nd": 0.0021}.items():
        own = found.names.index(name)
        assert abs(found.value[0, own] - value) < max(4 * found.std[0, own], 0.02 * abs(value))


@pytest.mark.parametrize(
    ("curves", "taken"),
    [
        ({"ow.csv": "J,KT,10KQ\n0,0.33,0.37\n0.5,0.19,0.25\n0.9,0.01,0.06\n"}, True),
        # A column a hundred times KQ, two propellers: neither is taken for hers.
        ({"ow.csv": "J,Kt,Kq\n0,0.31,3.18\n0.5,0.17,2.1\n0.8,0.01,0.5\n"}, False),
        (dict.fromkeys(("a.csv", "b.csv"), "J,KT,KQ\n0,0.33,0.04\n0.5,0.2,0.03\n"), False),
    ],
)
def test_the_curve_of_her_propeller_is_taken_where_it_is_the_only_one(
    curves, taken, tmp_path, capsys
):
    for name, text in curves.items():
        (tmp_path / name).write_text(text)
    track = "".join(f"{k / 10},{k / 10},0,0,{0.1 * (k > 5)}\n" for k in range(60))
    (tmp_path / "turn.csv").write_text("t,x,y,psi,delta\n" + track)
    drafted(capsys, tmp_path)
    told = tomllib.loads((tmp_path / "campaign.toml").read_text("utf-8"))
    assert told.get("propeller", {}) == ({"open_water": "ow.csv"} if taken else {})


@pytest.mark.parametrize(("start", "asked"), [(1.0, False), (0.3, True)])
def test_an_approach_below_her_speed_is_asked_for(start, asked, tmp_path, capsys):
    """A turn whose record begins at her speed, and one that begins while she gathers way."""
    t = np.arange(0.0, 60.0, 0.1)
    speed = 1.0 - (1.0 - start) * np.exp(-t / 5.0)
    delta = np.minimum(0.3 * np.maximum(t - 1.0, 0.0), 0.6)
    psi = np.cumsum(0.05 * delta / 0.6) * 0.1
    x, y = (np.cumsum(speed * along) * 0.1 for along in (np.cos(psi), np.sin(psi)))
    table = np.column_stack([t, x, y, psi, delta])
    head = "t,x,y,psi,delta"
    np.savetxt(tmp_path / "turn.csv", table, delimiter=",", header=head, comments="")
    drafted(capsys, tmp_path)
    lines = (tmp_path / "campaign.toml").read_text("utf-8").splitlines()
    (line,) = [text for text in lines if text.startswith("speed = ")]
    assert ("TODO" in line) == asked
    assert start - 0.01 < float(line.split("=")[1].split()[0]) < start + 0.2


PAIRS = {
    "ship.yml": "rho: 998.6\nL: 3.0  # m\nB: 0.489\nT: 0.2\n#m: 99\nm: 244.6\nI_z: 145.0\nD: 0.1",
    "ship.json": json.dumps(
        {"L": 3.0, "B": 0.489, "T": 0.2, "m": 244.6, "I_z": 145.0, "rho": 998.6, "name": "S"},
        indent=2,
    ),
    "ship.ini": "[ship]\nL = 3.0 m\nB = 489 mm\nT = 20 cm ; even keel\nm = 244.6 kg\n"
    "I_z = 145 kg m2\n[water]\ndensity = 998.6 kg/m3\n",
    "readme.txt": "The tank has 8 m x 2 m x 1 m.\n"
    "A model of 3.0 m x 0.489 m x 0.2 m, mass 244.6 kg, Izz 145 kg m2.\n"
    "The density of the water was 998.6 kg/m3.\n",
}


@pytest.mark.parametrize("name", PAIRS)
def test_particulars_stand_in_pairs_of_name_and_number(name, tmp_path, capsys):
    (tmp_path / name).write_text(PAIRS[name])
    (tmp_path / "turn.csv").write_text(
        "t,x,y,psi,delta\n" + "".join(f"{k / 10},{k / 10},0,0,0\n" for k in range(60))
    )
    drafted(capsys, tmp_path)
    told = tomllib.loads((tmp_path / "campaign.toml").read_text("utf-8"))
    assert told["ship"] == {"L": 3.0, "B": 0.489, "d": 0.2, "mass": 244.6, "Izz": 145.0}
    assert told["water"] == {"rho": 998.6}


def test_turns_and_zigzags_of_the_esso_osaka_are_told_by_their_records(
    shared_data, datasets, tmp_path, capsys
):
    """Rudder, switching heading and approach speed within what a person would correct."""
    real = open_campaign(datasets / "esso_osaka", data=shared_data)
    by_file = {run.source: run.settings for run in real}
    folder = shared_data / "esso_osaka_free"
    _, content, _ = drafted(capsys, folder, "-o", tmp_path / "campaign.toml")
    for run in content["runs"]:
        if run["test"] == "random":
            continue
        true = by_file[Path(run["file"]).name]
        assert run["settings"]["rudder_deg"] == pytest.approx(math.degrees(true.rudder), abs=1)
        assert run["settings"]["speed"] == pytest.approx(true.speed, rel=0.25)
        if true.switch:
            found = run["settings"]["switch_deg"]
            assert found == pytest.approx(math.degrees(true.switch), abs=3)


def test_the_bare_records_of_the_esso_osaka_open_without_an_answer(shared_data, tmp_path, capsys):
    """Her water and yaw inertia are guessed and told; the empty rows at the end of a record are
    no damage."""
    folder = shared_data / "esso_osaka_free"
    _, content, _ = drafted(capsys, folder, "-o", tmp_path / "campaign.toml")
    text = (tmp_path / "campaign.toml").read_text("utf-8")
    assert "rho = 999.1                      # fresh water of 15 °C; TODO" in text
    assert "Izz = 139.7                      # radius of gyration 0.25 L" in text
    campaign = open_campaign(tmp_path)
    assert len(campaign) == len(content["runs"]) == 12
    (short,) = [run for run in campaign if "13_50_28" in run.id]
    assert short.data.sizes["t"] == 1701


def course_kept_in_waves(path: Path, *, stops: bool = False) -> Path:
    """A free-running model without forces; heading and sway follow the waves."""
    t = np.arange(0.025, 90.0, 0.025)
    speed = 0.9 * np.clip((60.0 - t) / 50.0, 0.0, 1.0) if stops else 0.9 * np.clip(t / 8.0, 0, 1)
    psi = 0.6 * np.sin(2.3 * t)
    names = ["time", "x0", "y0", "psi", "u", "v", "n", "T_p", "Qp", "drud", "Xrud", "Yrud"]
    units = ["s", "m", "m", "deg", "m/s", "m/s", "rps", "N", "Nmm", "deg", "N", "N"]
    x = np.cumsum(speed) * 0.025
    columns = [t, x, 0.01 * np.sin(0.2 * t), psi, speed, 0.01 * np.sin(2.3 * t), 9.0 + 0 * t]
    columns += [6.0 + 0 * t, -105.0 + 0 * t, -4.0 * psi, 0.1 * psi, 0.3 * psi]
    rows = "".join("\t".join(f"{x:.4f}" for x in row) + "\n" for row in np.column_stack(columns))
    path.write_text("\t".join(names) + "\n" + "\t".join(units) + "\n" + rows, "utf-8")
    return path


def test_a_course_kept_in_waves_is_no_yaw_test(tmp_path, capsys):
    """Heading swings by half a degree, the rudder follows; without forces the model runs free."""
    course_kept_in_waves(tmp_path / "FW1.dat")
    course_kept_in_waves(tmp_path / "FW2.dat", stops=True)
    _, content, _ = drafted(capsys, tmp_path)
    assert content["kind"] == "free-running"
    assert [run["test"] for run in content["runs"]] == ["straight", None]
    columns = tomllib.loads((tmp_path / "campaign.toml").read_text("utf-8"))["columns"]
    assert columns["delta"]["name"] == "drud"
    assert (columns["T"]["name"], columns["Q"]["name"]) == ("T_p", "Qp")
    assert (columns["FX_rudder"]["name"], columns["FY_rudder"]["name"]) == ("Xrud", "Yrud")


def test_a_captive_run_in_waves_is_no_oscillating_test(tmp_path, capsys):
    """Forces swing with the waves, the last digit of the speed with every sample."""
    t = 0.025 * np.arange(1, 4001)
    u = 0.872 * np.clip(t / 10.0, 0.0, 1.0) + 0.007 * np.cos(np.pi * np.arange(4000))
    force = 8.0 * np.sin(4.1 * t) - 5.6 * np.clip(t / 10.0, 0.0, 1.0) ** 2
    zero = np.zeros_like(t)
    columns = np.column_stack([t, np.cumsum(u) * 0.025, zero, zero, u, force, zero, zero])
    names = "\t".join(["time", "x0", "y0", "psi", "u", "X", "Y", "N"])
    np.savetxt(tmp_path / "CW2.dat", columns, "%.4f", "\t", header=names, comments="")
    columns[:, [1, 4]] = 0.0
    np.savetxt(tmp_path / "CW1.dat", columns, "%.4f", "\t", header=names, comments="")
    _, content, _ = drafted(capsys, tmp_path)
    (run,) = content["runs"]
    assert content["kind"] == "captive"
    assert (run["id"], run["test"]) == ("CW2", "resistance")
    assert "CW1.dat: the carriage stands still" in (tmp_path / "campaign.toml").read_text("utf-8")


def test_tables_of_hmri_open_once_their_conventions_are_said(
    shared_data, datasets, tmp_path, capsys
):
    """Rows of tables: the derived settings are those of the campaign file written by hand."""
    folder = tmp_path / "hmri"
    folder.mkdir()
    for name in ("static_drift.csv", "pure_sway.csv", "pure_yaw.csv", "open_water_HMRI.csv"):
        shutil.copy(shared_data / "kvlcc2_hmri_pmm" / name, folder)
    status, content, _ = drafted(capsys, folder, "--ship", "kvlcc2-l7")
    assert status == 0
    assert {entry["test"] for entry in content["tables"]} == {
        "static_drift",
        "pure_sway",
        "pure_yaw",
    }
    path = folder / "campaign.toml"
    text = path.read_text(encoding="utf-8")
    assert 'forces = "balance" ' in text, "as published: the inertia is inside"
    assert 'in_phase_with = "displacement" } # as is usual; TODO' in text
    path.write_text(text.replace("rho = 999.1", "rho = 998.5 #"), encoding="utf-8")
    campaign = open_campaign(folder)
    by_hand = open_campaign(datasets / "kvlcc2_hmri", data=shared_data)
    assert len(campaign) == 18 + 4 + 6
    found = campaign["pure_sway_377"]
    assert found.settings.period == pytest.approx(by_hand["PS_377"].settings.period)
    assert campaign["static_drift_356"].settings.drift == pytest.approx(math.radians(30))


def from_rest_to_rest(path: Path, speed: float, *, drag: float) -> Path:
    """A record of a bare towing carriage at 20 Hz; its names and units end in a tab."""
    t = np.arange(0.05, 120.0, 0.05)
    u = speed * np.clip(np.minimum((t - 5.0) / 20.0, (115.0 - t) / 5.0), 0.0, 1.0)
    rng = np.random.default_rng(3)
    accelerated = 60.0 * np.gradient(u, t)
    table = [t, u, -drag * (u / speed) ** 2 - accelerated + 0.3 * rng.normal(size=t.size)]
    table += [0.2 * rng.normal(size=t.size) for _ in "YNr"]
    lines = ["time \tu \tX \tY \tN \troll \t", "s \tm/s \tN \tN \tNm \tNm \t"]
    lines += ["\t".join(f"{value:.4f}" for value in row) for row in zip(*table, strict=True)]
    path.write_text("\r\n".join(lines) + "\r\n", encoding="latin-1")
    return path


def test_the_speed_of_a_record_from_rest_to_rest_is_that_of_its_steady_part(tmp_path, capsys):
    """A mean over ramp and stop would be .67 m/s; no unit is taken for a name."""
    from_rest_to_rest(tmp_path / "C1.dat", 0.8, drag=2.0)
    status, content, _ = drafted(capsys, tmp_path)
    assert status == 0
    (run,) = content["runs"]
    assert run["settings"]["speed"] == pytest.approx(0.8, abs=0.002)
    text = (tmp_path / "campaign.toml").read_text(encoding="utf-8")
    columns = tomllib.loads(text)["columns"]
    assert columns["X"] == {"name": "X", "unit": "N"}
    assert columns["N"] == {"name": "N", "unit": "Nm"}
    assert "phi" not in columns
    assert "not used: roll ('roll' is a usual name of phi, which is not measured in Nm" in text
