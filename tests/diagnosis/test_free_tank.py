"""The tank of free-running ships: the package's own ships in calm water, its sensors, its files."""

from __future__ import annotations

import ast
import json
import math
import sys
from argparse import Namespace
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

import pmmkit as pk
from scripts.studies import free_hidden
from tests.support import free_tank
from tests.support.free_tank import campaigns, cases
from tests.support.free_tank.campaigns import Setup, programme, records, sailed, write, write_all
from tests.support.free_tank.container import Container
from tests.support.free_tank.hidden import NOTHING, Hidden
from tests.support.free_tank.sailing import Order, sail
from tests.support.free_tank.sensors import recorded
from tests.support.free_tank.tanker import Tanker

SHIPS = {
    "s175": (Container(NOTHING), 8.0, 0.25),
    "s175-3dof": (Container(NOTHING, rolls=False), 8.0, 0.25),
    "kvlcc2-l7": (Tanker(NOTHING), 1.179, 0.05),
}
"""The ship of the tank, approach speed [m/s] and step [s], by the library's name."""
MOTION = ("x", "y", "psi", "u", "v", "r", "phi")


@pytest.fixture(scope="module", autouse=True)
def short():
    """Records of 300 samples."""
    with pytest.MonkeyPatch.context() as patch:
        for name, fleet in cases.FLEETS.items():
            length = 300.0 * fleet.interval
            patch.setitem(cases.FLEETS, name, replace(fleet, turn=length, zigzag=length))
        yield


def test_the_tank_knows_nothing_of_the_package():
    allowed = set(sys.stdlib_module_names) | {"numpy", "scipy"}
    for path in Path(free_tank.__file__).parent.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                assert {item.name.split(".")[0] for item in node.names} <= allowed, path.name
            elif isinstance(node, ast.ImportFrom):
                own = node.level == 1 and node.module is not None
                assert own or (node.module or "").split(".")[0] in allowed, path.name


MANOEUVRES = (("turning", 20.0, None), ("turning", -35.0, None), ("zigzag", -20.0, 10.0))
"""Kind, rudder, heading of reversal [deg]."""


@pytest.fixture(scope="module", params=SHIPS)
def apart(request):
    """Largest differences between tank and package in 12 ship lengths, for each of `MANOEUVRES`: of
    x and y over the length, of angles [rad], of u and v over the speed, of r times L over it."""
    ship, speed, step = SHIPS[request.param]
    L = ship.body.L
    count = round(12.0 * L / speed / step)
    orders = [
        Order(
            rudder=math.radians(rudder),
            switch=None if switch is None else math.radians(switch),
            speed=speed,
            seconds=count * step,
        )
        for _, rudder, switch in MANOEUVRES
    ]
    scale = {"x": L, "y": L, "psi": 1.0, "phi": 1.0, "u": speed, "v": speed, "r": speed / L}
    found = []
    for (kind, rudder, switch), run in zip(MANOEUVRES, sail(ship, orders, step), strict=True):
        more = {} if switch is None else {"switch_deg": switch, "executes": 7}
        track = pk.simulate(
            request.param, kind, rudder_deg=rudder, speed=speed, dt=step, compiled=False,
            rudder_rate_deg=math.degrees(ship.rate), **more,
        )  # fmt: skip
        assert track.n[0] == pytest.approx(run.n, rel=1e-9)
        assert track.t[-1] >= run.t[-1]
        far = [
            np.abs(getattr(track, name)[: count + 1] - run.motion[name]).max() / scale[name]
            for name in MOTION
        ]
        found.append(dict(zip(MOTION, far, strict=True)))
    return found


@pytest.mark.slow
def test_turns_are_those_of_the_library_ship(apart):
    """Two programs of one ship: what is left are the errors of two integrations."""
    for far in apart[:2]:
        assert max(far.values()) < 5e-6, far


@pytest.mark.slow
def test_zigzags_are_those_of_the_library_ship(apart):
    """The rudder reaches its order inside a step, which costs a few orders of the integration."""
    assert max(apart[2].values()) < 1e-4, apart[2]


HULL, PROPELLER, RUDDER = "hull_polynomial", "propeller", "rudder_mmg"
DRAG = SHIPS["s175"][0].body.d / SHIPS["s175"][0].body.L
BY_NAME = (
    ("s175", "asymmetry", HULL, {"Y0": 1e-4, "N0": -4.5e-5}),
    ("s175", "coupling", HULL, {"Yvvr": 0.0214, "Yvrr": -0.0405, "Nvvr": -0.0424, "Nvrr": 0.00156}),
    ("s175", "surge_coupling", HULL, {"Xvr": 0.0039}),
    ("s175", "sway_drag", HULL, {"Yv|v|": -0.41 * DRAG, "Nv|v|": 0.2 * 0.41 * DRAG}),
    ("s175", "resistance", HULL, {"Xuu": 0.15 * -0.0004226}),
    ("s175", "propulsion", PROPELLER, {"wp": 0.08, "t": 0.05}),
    ("s175", "drift_wake", PROPELLER, {"tau": 0.4}),
    ("s175", "straightening", RUDDER, {"gamma": 0.1, "cRr": -0.1}),
    ("s175", "hull_rudder", RUDDER, {"aH": 0.1, "xH": -0.15, "tR": 0.1}),
    ("kvlcc2-l7", "resistance", HULL, {"Xuu": 0.15 * -0.022}),
    ("kvlcc2-l7", "propulsion", PROPELLER, {"wp": 0.08, "t": 0.05}),
    ("kvlcc2-l7", "drift_wake", PROPELLER, {"C2_positive": 0.3, "C2_negative": 0.3}),
    ("kvlcc2-l7", "straightening", RUDDER,
     {"gamma_positive": 0.15, "gamma_negative": 0.15, "lR": -0.2}),
    ("kvlcc2-l7", "hull_rudder", RUDDER, {"aH": 0.1, "xH": -0.15, "tR": 0.1}),
)  # fmt: skip
"""Library ship, case, and what it adds to the values of which part."""


def turned(name, hidden, *models, **settings):
    """Largest differences of x and y over the length between models of the package and the ship of
    the tank in a turn of 30°, over three ship lengths."""
    _, speed, step = SHIPS[name]
    ship = cases.FLEETS[name].build(hidden)
    L = ship.body.L
    step, count = 2.0 * step, round(3.0 * L / speed / step)
    order = Order(rudder=math.radians(30.0), speed=speed, seconds=count * step)
    run = sail(ship, [order], step)[0]
    tracks = [
        pk.simulate(
            model, rudder_deg=30.0, speed=speed, dt=step, compiled=False,
            rudder_rate_deg=math.degrees(ship.rate), **settings,
        )
        for model in models
    ]  # fmt: skip
    return [
        max(np.abs(getattr(track, axis)[: count + 1] - run.motion[axis]).max() / L for axis in "xy")
        for track in tracks
    ]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "case", "part", "added"), BY_NAME)
def test_what_is_hidden_is_what_its_name_moves(name, case, part, added):
    """The library ship with the values of the effect sails as the ship of the tank."""
    model = pk.load_model(name)
    known = model.parts[part].values
    full = model.with_values(part, **{key: known.get(key, 0.0) + x for key, x in added.items()})
    there, without = turned(name, cases.CASES[case].make[name](1.0), full, model)
    assert there < 5e-6
    assert without > 1e-3


@pytest.mark.slow
def test_cross_flow_and_current_are_those_of_the_catalogue():
    """Forty strips by their middles leave a thousandth of what the drag does."""
    model, make = pk.load_model("s175"), cases.CASES
    strips = pk.with_effect(model, "crossflow_drag", coefficients={"CD": 0.55}, value=0.0)
    there, without = turned("s175", make["cross_flow"].make["s175"](1.0), strips, model)
    assert there < 2e-3 * without
    hidden = make["current"].make["s175"](1.0)
    flows = {
        "current_speed": math.hypot(*hidden.current),
        "current_direction_deg": math.degrees(math.atan2(*hidden.current[::-1])),
    }
    assert turned("s175", hidden, model, **flows)[0] < 5e-6


def test_half_the_step_changes_nothing_that_a_sensor_sees():
    order = [Order(rudder=math.radians(30.0), speed=10.0, seconds=80.0)]
    coarse, fine = (sail(Container(NOTHING), order, step)[0].motion for step in (0.25, 0.125))
    assert np.abs(coarse["x"] - fine["x"][::2]).max() < 1e-3
    assert np.abs(coarse["phi"] - fine["phi"][::2]).max() < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize("ship", campaigns.SHIPS)
def test_sensors_have_the_noise_that_is_stated(ship):
    setup = Setup(ship=ship, runs=3, seed=2)
    noise, every = setup.fleet.noise, round(setup.fleet.interval / setup.fleet.step)
    left = {}
    for run, columns in zip(sailed(setup), records(setup).values(), strict=True):
        true = run.motion | {"delta": run.delta}
        for name in set(columns) & set(noise):
            left.setdefault(name, []).append((columns[name] - true[name][::every]) / noise[name])
    assert {"x", "y", "psi", "u", "v", "r", "delta"} <= set(left)
    for name, parts in left.items():
        white = np.concatenate(parts)
        few = 4.0 / math.sqrt(len(white))
        assert abs(white.mean()) < few, name
        assert white.std() == pytest.approx(1.0, abs=few), name
        assert abs(np.mean(white[1:] * white[:-1])) < few, name


@pytest.mark.parametrize(("runs", "turns"), [(6, 3), (3, 1)])
def test_programmes_turn_and_weave_to_both_sides_at_two_speeds(runs, turns):
    for seed in range(30):
        plans = programme(Setup(seed=seed, runs=runs))
        assert len({plan.id for plan in plans}) == runs
        assert sum(plan.switch is None for plan in plans) == turns
        assert len({plan.speed for plan in plans}) == 2
        assert {np.sign(plan.rudder) for plan in plans} == {-1, 1}
        assert max(abs(plan.rudder) for plan in plans) >= 25
    drawn = {tuple(programme(Setup(seed=seed, runs=runs))) for seed in range(10)}
    assert len(drawn) > 5


@pytest.mark.parametrize("ship", campaigns.SHIPS)
def test_what_is_hidden_grows_with_its_size_and_is_nothing_at_zero(ship):
    """In the motion, or in what the instruments say of it."""
    for name, case in cases.CASES.items():
        if ship not in case.make or not case.expect or name == "roll":
            continue
        assert case.make[ship](0.0) == NOTHING, name
        small, usual = (case.make[ship](size) for size in (0.3, 1.0))
        moved = [x.name for x in fields(Hidden) if getattr(usual, x.name) != x.default]
        assert moved, name
        for part in moved:
            assert np.allclose(getattr(small, part), 0.3 * np.array(getattr(usual, part)))


SHOWN = Setup(runs=3, seed=1)


@pytest.fixture(scope="module")
def plain():
    """What instruments without noise would show of the ship that a user starts from, by whether
    she rolls."""
    orders = [run.order for run in sailed(SHOWN)]
    return {
        rolls: shown(sail(Container(NOTHING, rolls=rolls), orders, SHOWN.fleet.step), NOTHING)
        for rolls in (True, False)
    }


def shown(runs, hidden):
    quiet = dict.fromkeys(SHOWN.fleet.noise, 0.0)
    return [recorded(run, hidden, quiet, 2, np.random.default_rng(0)) for run in runs]


@pytest.mark.slow
@pytest.mark.parametrize("case", [x for x in cases.CASES if x != "none"])
def test_every_case_shows_in_the_records(case, plain):
    """The columns differ by more than the noise from those of the ship that a user starts from."""
    setup = replace(SHOWN, case=case)
    seen = shown(sailed(setup), campaigns.hidden_in(setup))
    chi = sum(
        float(np.sum(((a[name] - b[name]) / setup.fleet.noise[name]) ** 2))
        for a, b in zip(seen, plain[setup.known.start is None], strict=True)
        for name in ("x", "y", "psi", "u", "v", "r")
    )
    assert chi > 100.0


@pytest.mark.slow
def test_files_are_a_campaign_of_the_package(tmp_path):
    setups = [Setup(case=name, runs=3, seed=4) for name in ("none", "wind")]
    write_all(setups, tmp_path)
    truth = json.loads((tmp_path / "truth.json").read_text(encoding="utf-8"))
    assert [item["case"] for item in truth.values()] == ["none", "wind"]
    calm, windy = (pk.open_campaign(tmp_path / name) for name in truth)
    assert calm.kind == "free-running"
    assert [run.id for run in calm.runs] == [plan.id for plan in programme(setups[0])]
    assert pk.load_model(truth[setups[1].name]["model"]).ship.L == windy.ship.L
    heads = {
        name: next((tmp_path / name / "runs").glob("*.csv")).read_text().splitlines()[0]
        for name in truth
    }
    assert heads[setups[0].name] == "t,x,y,psi,u,v,r,phi,delta,n"
    assert heads[setups[1].name].endswith(",n,wind_speed,wind_direction")
    (job,) = free_hidden.jobs_of(Namespace(folder=tmp_path, cases=["wind"], follow=False))
    assert job.folder == tmp_path / setups[1].name
    assert job.truth == setups[1].truth


@pytest.mark.slow
def test_a_campaign_is_the_same_each_time(tmp_path):
    setup = Setup(case="current", runs=3, seed=7)
    first, again = (write(setup, tmp_path / name) for name in ("a", "b"))
    for path in (first / "runs").iterdir():
        assert path.read_bytes() == (again / "runs" / path.name).read_bytes()


@pytest.mark.slow
def test_a_third_program_agrees(shared_data):
    """Turns of S175 that another program made, with nothing hidden: the noise that its page states
    is all that is left of them."""
    folder = shared_data / "free_hidden"
    if not folder.is_dir():
        pytest.skip("the campaigns with hidden effects are not on this machine")
    truth = json.loads((folder / "truth.json").read_text(encoding="utf-8"))
    name = next(name for name, item in truth.items() if item["case"] == "none_a")
    orders = {
        f"turning_{speed:g}_{rudder:+d}": Order(
            rudder=math.radians(rudder), speed=speed, seconds=300.0
        )
        for speed, rudder in ((7.0, -35), (7.0, 25), (10.0, 20))
    }
    noise = cases.FLEETS["s175"].noise
    for run, made in zip(
        orders, sail(Container(NOTHING), list(orders.values()), 0.25), strict=True
    ):
        path = folder / name / "runs" / f"{run}.csv"
        columns = np.genfromtxt(path, delimiter=",", names=True)
        for channel in MOTION:
            left = columns[channel][:601] - made.motion[channel][::2]
            assert left.std() == pytest.approx(noise[channel], rel=0.08), (run, channel)


@pytest.mark.parametrize(
    ("sets", "expect", "outcome"),
    [
        ([("wind",)], [["wind"]], "alone"),
        ([("current",), ("wind",)], [["wind"]], "group"),
        ([("a",), ("b",), ("c",), ("wind",)], [["wind"]], "wide"),
        ([("wind", "current")], [["wind"]], "beside"),
        ([("current",)], [["wind"]], "wrong"),
        ([("asymmetry",)], [["asymmetry", "fault_rudder_zero"]], "alone"),
        ([("roll", "wind")], [["wind", "current"], ["heel_coupling", "roll"]], "alone"),
        ([("roll",)], [["wind"], ["roll"]], "wrong"),
        ([], [["wind"]], "silent"),
        ([("wind",)], [], "wrong"),
    ],
)
def test_answers_are_judged_by_the_names_that_the_truth_accepts(sets, expect, outcome):
    verdict = "missing_effect" if sets else "noise"
    truth = {"case": "x", "expect": expect, "verdict": ["missing_effect" if expect else "noise"]}
    answer = free_hidden.Answer(
        job=free_hidden.Job(truth=truth), verdict=verdict, sets=tuple(sets), odds=(1.0,) * len(sets)
    )
    assert answer.outcome == outcome
    assert answer.right == (outcome in ("alone", "group"))
    assert outcome in free_hidden.table([answer])
