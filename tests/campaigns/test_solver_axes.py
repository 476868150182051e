"""Forces of a CFD in earth axes, about a centre that stays behind, come back as the hull's own.

The truth is a handful of loads at points of the hull. In ship axes they sum to X, Y and N about
the moment reference; seen from the earth each acts at the place where its point is, and the
solver sums them along its axes and about its centre.
"""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from foam_texts import body_state, written
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from pmmkit import open_campaign
from pmmkit.base import CampaignError
from pmmkit.campaigns import Settings
from pmmkit.campaigns.samples.conversions import Solver, seen_from_hull, without_ramp
from pmmkit.campaigns.stated_run import StatedRun
from scripts.datasets.campaign_text import S175

SPEED, PERIOD, YAW, SWAY, CENTRE = 1.5, 8.0, 0.25, 0.4, 0.6
OMEGA = 2 * math.pi / PERIOD
T = np.arange(0.0, 2 * PERIOD + 0.01, 0.02)
POINTS = ((1.8, 0.2), (-0.4, -0.3), (-2.2, 0.1))
HEAD = (
    """[campaign]
kind = "captive"
"""
    + S175
    + """[cfd]
forces_in = "earth"
moment_centre = 0.6
moment_centre_moves = false
"""
)


def loads(t):
    """Force ahead and to starboard at each point of the hull [N]."""
    return [
        (-20.0 + 3 * k * np.sin(OMEGA * t + k), 40.0 * np.cos(OMEGA * t - k) + 5 * k)
        for k in range(len(POINTS))
    ]


def on_hull(t, about=CENTRE):
    """X, Y and N in ship axes."""
    found = loads(t)
    return {
        "X": sum(ahead for ahead, _ in found),
        "Y": sum(aside for _, aside in found),
        "N": sum(
            (px - about) * aside - py * ahead
            for (px, py), (ahead, aside) in zip(POINTS, found, strict=True)
        ),
    }


def in_solver(t, x, y, psi, *, centre=(CENTRE, 0.0)):
    """What a solver reports: along its own axes, about a centre that never moves."""
    cosine, sine = np.cos(psi), np.sin(psi)
    fx = fy = mz = 0.0
    for (px, py), (ahead, aside) in zip(POINTS, loads(t), strict=True):
        along, across = ahead * cosine - aside * sine, ahead * sine + aside * cosine
        rx = x + px * cosine - py * sine - centre[0]
        ry = y + px * sine + py * cosine - centre[1]
        fx, fy, mz = fx + along, fy + across, mz + rx * across - ry * along
    return {"X": fx, "Y": fy, "N": mz}


def swaying(t):
    return {
        "x": 0.1 * np.sin(2 * OMEGA * t),
        "y": SWAY * np.sin(OMEGA * t),
        "psi": YAW * np.sin(OMEGA * t + 0.7),
    }


def run_entry(test="sway_yaw", **more) -> str:
    keys = {
        "id": "R",
        "test": test,
        "file": "run.csv",
        "speed": SPEED,
        "period": PERIOD,
        "yaw_amplitude_deg": math.degrees(YAW),
        "amplitude_m": SWAY,
        **more,
    }
    lines = [f"{name} = {json.dumps(value)}" for name, value in keys.items() if name != "row"]
    lines += [f"row = {{ {name} = {value} }}" for name, value in keys.get("row", {}).items()]
    return "\n".join(["[[runs]]", *lines, ""])


def table(columns) -> str:
    rows = np.column_stack([np.broadcast_to(part, T.shape) for part in columns.values()])
    lines = [",".join(columns), *(",".join(f"{x:.16g}" for x in row) for row in rows)]
    return "\n".join(lines) + "\n"


def read(folder, files, *, head=HEAD, **entry):
    written(folder, files)
    (folder / "campaign.toml").write_text(head + run_entry(**entry), encoding="utf-8")
    return open_campaign(folder)["R"].data


def agrees(data, truth, rel=1e-9):
    for name, values in truth.items():
        scale = np.abs(values).max()
        assert np.abs(data[name].values - values).max() < rel * scale, name


def test_recorded_motion(tmp_path):
    path = swaying(T)
    data = read(tmp_path, {"run.csv": table({"t": T, **in_solver(T, **path), **path})})
    agrees(data, on_hull(T))
    assert "up to 0.5" in data.attrs["conversions"]


def test_axes_of_the_solver_with_z_up(tmp_path):
    """y to port and z up, as most meshes are built: signs of Y, N, y and psi turn first."""
    path = swaying(T)
    solver = {**in_solver(T, **path), **path}
    turned = {name: part if name in "Xx" else -part for name, part in solver.items()}
    head = HEAD + '[axes]\ny = "-y"\nz = "-z"\n'
    agrees(read(tmp_path, {"run.csv": table({"t": T, **turned})}, head=head), on_hull(T))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["path.csv", "sixDoFRigidBodyState.dat"])
def test_motion_from_a_file_of_its_own(name, tmp_path):
    path = swaying(T)
    own = np.arange(-0.01, T[-1] + 0.01, 0.0005)
    moved = swaying(own)
    start = {key: part[0] for key, part in moved.items()}
    if name.endswith("csv"):
        rows = np.column_stack([own, moved["x"], moved["y"], np.degrees(moved["psi"])])
        text = "t;x;y;psi [deg]\n" + "".join(
            ";".join(f"{x:.15g}" for x in row) + "\n" for row in rows
        )
    else:
        place = np.column_stack([7.0 + moved["x"], moved["y"], 0 * own])
        turn = np.column_stack([0 * own, 0 * own, np.degrees(moved["psi"])])
        text = body_state(own, place, turn)
        path = {**path, "x": path["x"] - start["x"], "y": path["y"] - start["y"]}
    forces = in_solver(T, **path)
    data = read(tmp_path, {"run.csv": table({"t": T, **forces}), name: text}, motion=name)
    agrees(data, on_hull(T), rel=1e-6)
    assert name in open_campaign(tmp_path).file_hashes()


def test_motion_from_velocities(tmp_path):
    """u, v, r of a hull that starts at rest's place, integrated; x counts from the carriage."""
    psi = YAW * np.sin(OMEGA * T)
    ahead, aside = np.full_like(T, SPEED), SWAY * OMEGA * np.cos(OMEGA * T)
    velocities = {
        "u": ahead * np.cos(psi) + aside * np.sin(psi),
        "v": -ahead * np.sin(psi) + aside * np.cos(psi),
        "r": YAW * OMEGA * np.cos(OMEGA * T),
    }
    forces = in_solver(T, 0.0, SWAY * np.sin(OMEGA * T), psi)
    files = {"run.csv": table({"t": T, **forces}), "m.csv": table({"t": T, **velocities})}
    agrees(read(tmp_path, files, motion="m.csv"), on_hull(T), rel=1e-4)


def nominal(test):
    """x, y, psi of a test, the sway of a yawing one by integrating dy/dt = Uc tan psi."""
    theta = OMEGA * T + 0.3
    if test == "pure_surge":
        return {"x": SWAY * np.sin(theta), "y": 0.0, "psi": 0.0 * T}
    if test == "pure_sway":
        return {"x": 0.0, "y": SWAY * np.sin(theta), "psi": 0.0 * T}
    if test == "sway_yaw":
        return {"x": 0.0, "y": SWAY * np.sin(theta), "psi": -YAW * np.cos(theta)}
    solved = solve_ivp(
        lambda t, _: [SPEED * math.tan(YAW * math.sin(OMEGA * t + 0.3))],
        (0.0, T[-1]),
        [0.0],
        t_eval=T,
        rtol=1e-11,
        atol=1e-12,
    )
    y = solved.y[0]
    period = round(PERIOD / 0.02)
    return {"x": 0.0, "y": y - y[:period].mean(), "psi": YAW * np.sin(theta)}


@pytest.mark.parametrize("test", ["pure_surge", "pure_sway", "sway_yaw", "pure_yaw"])
def test_the_motion_that_the_test_was_set_to(test, tmp_path):
    path = nominal(test)
    files = {"run.csv": table({"t": T, **in_solver(T, **path)})}
    data = read(tmp_path, files, test=test, phase_deg=math.degrees(0.3))
    agrees(data, on_hull(T), rel=1e-6)


def test_the_phase_of_the_set_motion_comes_from_a_recorded_rate(tmp_path):
    path = nominal("pure_yaw")
    rate = YAW * OMEGA * np.cos(OMEGA * T + 0.3)
    files = {"run.csv": table({"t": T, **in_solver(T, **path), "r": rate})}
    agrees(read(tmp_path, files, test="pure_yaw", phase_deg=0.0), on_hull(T), rel=1e-6)


def test_static_drift_turns_by_the_drift_angle(tmp_path):
    beta = math.radians(9.0)
    forces = in_solver(T, 0.0, 0.0, beta, centre=(CENTRE * math.cos(beta), CENTRE * math.sin(beta)))
    head = HEAD.replace("moment_centre_moves = false", "moment_centre_moves = true")
    files = {"run.csv": table({"t": T, **forces})}
    data = read(tmp_path, files, head=head, test="static_drift", drift_deg=9.0)
    agrees(data, on_hull(T))


def test_forces_in_ship_axes_are_left_alone(tmp_path):
    forces = on_hull(T)
    head = HEAD.partition("forces_in")[0] + "moment_centre = 0.6\n"
    data = read(tmp_path, {"run.csv": table({"t": T, **forces, "K": T})}, head=head)
    agrees(data, forces, rel=1e-15)
    assert "K" in data


def test_forces_in_ship_axes_about_a_centre_that_stays(tmp_path):
    path, forces = swaying(T), on_hull(T)
    forces["N"] = in_solver(T, **path)["N"]
    head = HEAD.replace('forces_in = "earth"', 'forces_in = "body"')
    agrees(read(tmp_path, {"run.csv": table({"t": T, **forces, **path})}, head=head), on_hull(T))


def test_heel_moment_is_left_out_with_a_word(tmp_path):
    path = swaying(T)
    files = {"run.csv": table({"t": T, **in_solver(T, **path), "K": T, **path})}
    data = read(tmp_path, files)
    assert "K" not in data
    assert "K left out" in data.attrs["conversions"]


@given(
    x=st.floats(-3, 3),
    y=st.floats(-3, 3),
    psi=st.floats(-3, 3),
    centre=st.floats(-2, 2),
    motion=st.floats(-2, 2),
)
@settings(max_examples=100, deadline=None)
def test_any_place_heading_centre_and_point_of_motion(x, y, psi, centre, motion):
    """The point whose path is stated may lie anywhere on the hull."""
    t = np.array([0.4])
    midship = (x + motion - motion * math.cos(psi), y - motion * math.sin(psi))
    reported = in_solver(t, *midship, psi, centre=(centre, 0.0))
    place = {name: np.array([value]) for name, value in (("x", x), ("y", y), ("psi", psi))}
    solver = Solver(axes="earth", centre_moves=False, centre_x=centre, motion_x=motion)
    run = StatedRun(id="R", test="pure_yaw", kind="history", settings=Settings(speed=SPEED))
    turned, _ = seen_from_hull({"t": t, **reported, **place}, solver, run)
    truth = on_hull(t, about=centre)
    for name in truth:
        assert turned[name] == pytest.approx(truth[name], abs=1e-9)


@pytest.mark.parametrize("test", ["circular_motion", "static_drift", "drift_rudder"])
@pytest.mark.parametrize("beta", [-0.2, 0.0, 0.3])
def test_a_balance_on_the_arm_measures_along_its_tangent(test, beta):
    """Ahead 20 N, to starboard 50 N on a hull whose bow is β to starboard of the way."""
    angle = beta + math.atan2(50.0, 20.0)
    felt = math.hypot(20.0, 50.0)
    along = {"X": np.array([felt * math.cos(angle)]), "Y": np.array([felt * math.sin(angle)])}
    run = StatedRun(
        id="R", test=test, kind="means", settings=Settings(speed=SPEED, drift=beta, radius=12.0)
    )
    turned, notes = seen_from_hull({**along, "N": np.array([7.0])}, Solver(axes="carriage"), run)
    assert [float(turned[name][0]) for name in "XYN"] == pytest.approx([20.0, 50.0, 7.0])
    assert "carriage axes" in " ".join(notes)


@pytest.mark.parametrize(
    ("files", "entry", "words"),
    [
        ({}, {"motion": "none.csv"}, "none.csv"),
        ({"m.csv": "t,x,y,psi\n0,0,0,0\n4,0,0,0\n"}, {"motion": "m.csv"}, "goes from t = 0 to 4"),
        ({"m.csv": "t,x,y,psi\n0,0,0,0\n0,0,0,0\n99,1,1,1\n"}, {"motion": "m.csv"}, "do not rise"),
        ({"m.csv": "t,x,y\n0,0,0\n99,0,0\n"}, {"motion": "m.csv"}, "neither psi nor r"),
        ({"m.csv": "t,psi\n0,0\n99,0\n"}, {"motion": "m.csv"}, "no x and no y"),
        ({"m.csv": "time,psi\n0,0\n99,0\n"}, {"motion": "m.csv"}, "no column t"),
        ({}, {"test": "circular_motion", "yaw_rate": 0.1}, "where the hull is"),
    ],
)
def test_a_path_that_is_not_known(files, entry, words, tmp_path):
    forces = {"run.csv": table({"t": T, **on_hull(T)})}
    with pytest.raises(CampaignError, match=words):
        read(tmp_path, forces | files, **entry)


def test_a_motion_beside_forces_along_the_hull_is_what_the_hull_did(tmp_path):
    """Forces need no turning: heading and place of the other file become channels of the run."""
    path = swaying(T)
    files = {"run.csv": table({"t": T, **on_hull(T)}), "m.csv": table({"t": T, **path})}
    head = HEAD.partition("forces_in")[0]
    data = read(tmp_path, files, head=head, motion="m.csv")
    agrees(data, on_hull(T) | path)


def test_a_row_of_a_table_has_no_motion(tmp_path):
    forces = table({"t": T, **on_hull(T)})
    with pytest.raises(CampaignError, match="a row of a table has no motion"):
        read(tmp_path, {"run.csv": forces}, motion="m.csv", row={"t": 1})


def test_a_force_alone_cannot_be_turned(tmp_path):
    files = {"run.csv": table({"t": T, "X": T, "N": T})}
    head = HEAD + "[columns]\nY = false\n"
    with pytest.raises(CampaignError, match="there is no Y"):
        read(tmp_path, files, head=head)


def test_harmonics_in_earth_axes_are_refused(tmp_path):
    files = {"run.csv": "no,X_mean,Y_sin1,Y_cos1,N_sin1,N_cos1\n1,1,2,3,4,5\n"}
    with pytest.raises(CampaignError, match="cannot be turned"):
        read(tmp_path, files, row={"no": 1})


def test_a_row_of_means_turns_by_the_drift_angle(tmp_path):
    head = HEAD.replace("moment_centre_moves = false\n", "")
    files = {"run.csv": "no,X,Y,N\n1,0,10,4\n"}
    data = read(tmp_path, files, head=head, test="static_drift", drift_deg=30.0, row={"no": 1})
    assert float(data["X"]) == pytest.approx(5.0)
    assert float(data["Y"]) == pytest.approx(10 * math.cos(math.pi / 6))
    assert float(data["N"]) == 4.0


def test_the_start_up_of_the_computation_is_cut(tmp_path):
    forces = on_hull(T)
    head = HEAD.partition("forces_in")[0] + "ramp_s = 2.0\n"
    data = read(tmp_path, {"run.csv": table({"t": T, **forces})}, head=head)
    kept = T >= 2.0
    assert data["t"].values == pytest.approx(T[kept], rel=1e-14)
    assert data["Y"].values == pytest.approx(forces["Y"][kept], rel=1e-14)
    assert f"first 2 s left out (ramp_s): 100 of {len(T)} samples" in data.attrs["conversions"]


def test_a_start_up_longer_than_the_record():
    with pytest.raises(CampaignError, match="leaves no samples"):
        without_ramp({"t": T}, 1000.0, file="f", run="R")


def test_unknown_axes_of_forces(tmp_path):
    head = HEAD.replace('"earth"', '"erth"')
    with pytest.raises(CampaignError, match="did you mean 'earth'"):
        read(tmp_path, {"run.csv": "t,X,Y,N\n0,0,0,0\n"}, head=head)
