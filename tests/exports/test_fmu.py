"""FMUs: FMPy finds them valid, compiles them, and the ship sails as it does here.

FMPy 0.3.32 (BSD-2-Clause) is the other program; for Model Exchange its CVode integrates.
"""

from __future__ import annotations

import json
import math
import os
import re
import subprocess
import sys
import xml.etree.ElementTree as ET
import zipfile
from dataclasses import replace
from functools import cache
from io import BytesIO

import numpy as np
import pytest
from fmus import exchanged, needs_compiler, needs_fmpy, sailing, steps_of

import pmmkit as pk
from pmmkit import Effect, Parameter, register_effect
from pmmkit.base import DataError, ModelError
from pmmkit.cli import main
from pmmkit.effects import CATALOGUE
from pmmkit.equations import prepare
from pmmkit.equations.layouts import Constant
from pmmkit.exports.fmu.unit import model_to_fmu
from pmmkit.exports.fmu.variables import LAG, table_of
from pmmkit.models import Part, ships

SPEEDS = {"s175": 8.0, "kvlcc2": 7.974, "kvlcc2-l7": 1.179, "mariner": 7.7175, "esso190k": 8.0}
STATES = ("x", "y", "psi", "u", "v", "r")


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """Compiled FMUs, each made once."""
    folder, done = tmp_path_factory.mktemp("fmus"), {}

    def build(model, fmi=3, speed=None):
        model = pk.load_model(model) if isinstance(model, str) else model
        at = speed or SPEEDS.get(model.name, model.ship.speed(0.15))
        key = model.name, fmi, at
        if key not in done:
            done[key] = folder / f"{model.name}-{fmi}-{at}.fmu"
            pk.export(model, done[key], speed=at, fmi=fmi, compile=True)
        return done[key]

    return build


@cache
def ours(model, manoeuvre, speed, **settings):
    """The same manoeuvre here, with the steering gear of the FMU."""
    law = {"rudder_law": "lag", "rudder_lag": LAG, "compiled": False, "rtol": 1e-12}
    return pk.simulate(model, manoeuvre, speed=speed, **law, **settings)


def orders_of(track, rudder_deg, manoeuvre):
    """Times and values of the orders of a manoeuvre [s], [rad]."""
    rudder = math.radians(rudder_deg)
    if manoeuvre == "turning":
        return [0.0], [rudder]
    times = list(track.orders)
    return times, [rudder * (-1) ** place for place in range(len(times))]


def gap(found, track, names=STATES):
    """Largest differences: positions over L, angles in degrees, velocities over the speed."""
    units = {"x": track.L, "y": track.L, "psi": math.radians(1), "phi": math.radians(1)}
    pace = track.speed / track.L
    units |= {"u": track.speed, "v": track.speed, "r": pace, "p": pace}
    return max(
        float(np.max(np.abs(np.asarray(found[name]) - getattr(track, name))) / units.get(name, 1.0))
        for name in names
    )


def carried(file, folder, track, orders, names, **start):
    """Co-Simulation to every sample of a track; orders change where they did there."""
    times, values = orders
    found = {name: [] for name in names}
    instants = sorted({*track.t.tolist(), *times})
    asked, waiting = set(track.t.tolist()), list(zip(times, values, strict=True))
    with sailing(file, folder, **start) as ship:
        for instant in instants:
            if instant > ship.time:
                ship.go(instant)
            if instant in asked:
                for name, value in zip(names, ship.get(*names), strict=True):
                    found[name].append(value)
            while waiting and waiting[0][0] <= instant:
                ship.set(delta_order=waiting.pop(0)[1])
    return found


# --- Valid ---------------------------------------------------------------------------------------


@needs_fmpy
@pytest.mark.slow
@pytest.mark.parametrize(("name", "fmi"), [*((name, 3) for name in SPEEDS), ("s175", 2)])
def test_fmpy_finds_nothing_wrong(name, fmi, tmp_path):
    from fmpy.validation import validate_fmu

    model = pk.load_model(name)
    (path,) = pk.export(model, tmp_path / "ship.fmu", speed=model.ship.speed(0.15), fmi=fmi)
    assert validate_fmu(str(path)) == []


@needs_compiler
@pytest.mark.slow
@pytest.mark.parametrize("fmi", [2, 3])
def test_fmpy_compiles_the_sources_and_runs_them(fmi, tmp_path):
    import fmpy
    from fmpy.build import build_platform_binary

    (path,) = pk.export("kvlcc2-l7", tmp_path / "ship.fmu", speed=1.179, fmi=fmi)
    where = fmpy.extract(str(path), str(tmp_path / "ship"))
    build_platform_binary(where, configuration="Release")
    found = fmpy.simulate_fmu(where, stop_time=30, start_values={"delta_order": 0.3})
    track = ours("kvlcc2-l7", "turning", 1.179, rudder_deg=math.degrees(0.3), dt=30.0)
    assert float(found["psi"][-1]) == pytest.approx(track.psi[track.t == 30.0][0], rel=1e-5)


# --- The same track ------------------------------------------------------------------------------

CASES = [
    pytest.param("s175", "turning", 2, {"rudder_deg": 35}, id="s175-turning"),
    pytest.param("s175", "zigzag", 3, {"rudder_deg": 20, "switch_deg": 20}, id="s175-zigzag"),
    pytest.param("kvlcc2", "turning", 3, {"rudder_deg": -35}, id="kvlcc2-turning"),
    pytest.param("kvlcc2", "zigzag", 2, {"rudder_deg": 10, "switch_deg": 10}, id="kvlcc2-zigzag"),
    pytest.param("esso190k", "turning", 3, {"rudder_deg": 20}, id="shaft"),
    pytest.param("mariner", "turning", 3, {"rudder_deg": 35}, id="loss-of-speed"),
]


def told(name):
    """The states that are compared; S175 rolls."""
    return (*STATES, "p", "phi") if name == "s175" else STATES


@needs_compiler
@pytest.mark.slow
@pytest.mark.parametrize(("name", "manoeuvre", "fmi", "settings"), CASES)
def test_model_exchange_sails_as_here(name, manoeuvre, fmi, settings, built):
    """With CVode at rtol 1e-9; measured: at most 6e-6 in the units of `gap`."""
    track = ours(name, manoeuvre, SPEEDS[name], **settings)
    end = float(track.t[-1])
    orders = orders_of(track, settings["rudder_deg"], manoeuvre)
    jumps = steps_of("delta_order", *orders, end)
    found = exchanged(built(name, fmi), end, input=jumps, interval=float(track.t[1]))
    _, first = np.unique(found["time"], return_index=True)
    places = first[np.isin(found["time"][first], track.t)]
    here = np.isin(track.t, found["time"][places])
    assert here.sum() > 0.9 * len(track)
    same = {item: found[item][places] for item in told(name)}
    wanted = replace(track, **{item: getattr(track, item)[here] for item in told(name)})
    assert gap(same, wanted, told(name)) < 2e-5


@needs_compiler
@pytest.mark.slow
@pytest.mark.parametrize(("name", "manoeuvre", "fmi", "settings"), CASES)
def test_co_simulation_sails_as_here(name, manoeuvre, fmi, settings, built, tmp_path):
    """With the integrator in the FMU at rtol 1e-11; measured: at most 1e-7."""
    track = ours(name, manoeuvre, SPEEDS[name], **settings)
    orders = orders_of(track, settings["rudder_deg"], manoeuvre)
    found = carried(built(name, fmi), tmp_path, track, orders, told(name))
    assert gap(found, track, told(name)) < 1e-6


@needs_compiler
@pytest.mark.slow
def test_an_autopilot_that_looks_at_the_ship_steers_the_same_zigzag(built, tmp_path):
    track = ours("kvlcc2-l7", "zigzag", 1.179, rudder_deg=10, switch_deg=10)
    order, farthest = math.radians(10), {}
    with sailing(built("kvlcc2-l7"), tmp_path) as ship:
        ship.set(delta_order=order)
        for step in range(1, 1800):
            ship.go(step * 0.02)
            (psi,) = ship.get("psi")
            if psi * math.copysign(1.0, order) > abs(order):
                order = -order
                ship.set(delta_order=order)
            farthest[order > 0] = max(farthest.get(order > 0, 0.0), abs(psi))
    overshoot = math.degrees(farthest[False]) - 10
    assert overshoot == pytest.approx(track.metrics["overshoot_1_deg"], abs=0.05)


# --- What is around the ship, and effects --------------------------------------------------------


@needs_compiler
@pytest.mark.slow
def test_current_and_wind_act_as_here(built, tmp_path):
    plain = pk.load_model("kvlcc2-l7")
    wind = Part(effect="wind", values={"AF": 0.5, "AL": 2.0})
    blown = plain.with_(name="blown", parts={**plain.parts, "wind": wind})
    around = {"wind_speed": 3.0, "current_speed": 0.3}
    angles = {"wind_direction": 60.0, "current_direction": 200.0}
    track = ours(
        blown,
        "turning",
        1.179,
        rudder_deg=35,
        **around,
        **{f"{name}_deg": angle for name, angle in angles.items()},
        revolutions=prepare(blown, 1.179).self_propulsion(),
    )
    calm = ours(blown, "turning", 1.179, rudder_deg=35)
    assert abs(calm.y.max() - track.y.max()) > 0.1 * track.L
    start = around | {name: math.radians(angle) for name, angle in angles.items()}
    found = carried(
        built(blown, speed=1.179), tmp_path, track, orders_of(track, 35, "turning"), STATES, **start
    )
    assert gap(found, track) < 1e-6


@needs_compiler
@pytest.mark.slow
def test_effects_with_states_and_words_of_a_user_sail_as_here(built, tmp_path):
    own = pk.own_effect("fins", "Y: a*lag(v, 0.5)*|r|; a ~ -0.04")
    model = pk.with_effect(pk.load_model("kcs"), ["memory", own], coefficients="typical")
    model = model.with_(name="late")
    assert len(prepare(model, model.ship.speed(0.2)).structure.brought) == 2
    speed = model.ship.speed(0.2)
    track = ours(model, "turning", speed, rudder_deg=30)
    orders = orders_of(track, 30, "turning")
    found = carried(built(model, speed=speed), tmp_path, track, orders, STATES)
    assert gap(found, track) < 1e-6


# --- Its variables -------------------------------------------------------------------------------


def shallow():
    """A ship in water of one and a half draughts."""
    plain = pk.load_model("kvlcc2")
    parts = {**plain.parts, "shallow_water": Part(effect="shallow_water")}
    depth = 1.5 * plain.ship.d
    return plain.with_(parts=parts, water=replace(plain.water, depth=depth))


def at_two_speeds():
    """A ship with values at two Froude numbers."""
    plain = pk.load_model("s175-3dof").with_(Fn=(0.1, 0.2), name="tested")
    hull = plain.part("hull_polynomial").values
    return plain.with_values("hull_polynomial", Yv=(hull["Yv"], 1.2 * hull["Yv"]))


MODELS = [*map(pk.load_model, ships()), shallow(), at_two_speeds()]


@pytest.mark.slow
@pytest.mark.parametrize("model", MODELS, ids=lambda model: model.name)
def test_the_parameters_make_the_constants_of_the_equations(model):
    speed = model.ship.speed(0.12)
    ready = prepare(model, speed)
    table = table_of(model, ready, speed)
    k = list(table.base)
    for item in table.variables:
        for place, size in item.slopes:
            k[place] += size * item.start
    assert k == pytest.approx(ready.k, rel=1e-15)
    named = {item.name for item in table.variables if item.slopes}
    derivatives = model.part("hull_polynomial").values
    assert len([name for name in named if "hull_polynomial" in name]) == len(derivatives)


@needs_compiler
@pytest.mark.slow
def test_a_changed_parameter_is_a_changed_model(built, tmp_path):
    plain = pk.load_model("kvlcc2-l7")
    hull = dict(plain.part("hull_polynomial").values)
    other = plain.with_values("hull_polynomial", Nr=1.1 * hull["Nr"], Xuu=1.2 * hull["Xuu"])
    track = ours(other, "turning", 1.1, rudder_deg=25)
    start = {
        "hull_polynomial__Nr": 1.1 * hull["Nr"],
        "hull_polynomial__Xuu": 1.2 * hull["Xuu"],
        "u_start": 1.1,
        "n_order": prepare(other, 1.1).self_propulsion(),
    }
    orders = orders_of(track, 25, "turning")
    found = carried(built("kvlcc2-l7"), tmp_path, track, orders, STATES, **start)
    assert gap(found, track) < 1e-6


@needs_compiler
@pytest.mark.parametrize("fmi", [2, 3])
def test_what_follows_from_parameters_and_states(fmi, built, tmp_path):
    ready = prepare(pk.load_model("s175"), 8.0)
    start = {"u_start": 7.0, "v_start": -0.6, "phi_start": 0.1, "psi_start": 2.0}
    with sailing(built("s175", fmi), tmp_path, steering_gear=False, **start) as ship:
        ship.set(delta_order=0.3, n_order=1.4)
        assert ship.get("delta", "n", "psi") == [0.3, 1.4, 2.0]
        assert ship.get("n_approach")[0] == pytest.approx(ready.self_propulsion(7.0), rel=1e-12)
        rates = ship.get("der(u)", "der(v)", "der(r)", "der(p)")
        wanted = ready.accelerations(7.0, -0.6, 0.0, phi=0.1, delta=0.3, n=1.4)
        assert rates == pytest.approx(wanted, rel=1e-12)
        force, side, thrust = ship.get("X", "rudder_force", "thrust")
        surge_mass = ready.k[Constant.mass] - ready.k[Constant.Xudot]
        assert force == pytest.approx(wanted[0] * surge_mass, rel=1e-12)
        assert side < 0 < thrust
        before = ship.fmu.getFMUState() if fmi == 3 else ship.fmu.getFMUstate()
        ship.go(10.0)
        first = ship.get("x", "y", "psi")
        ship.fmu.setFMUState(before) if fmi == 3 else ship.fmu.setFMUstate(before)
        ship.time = 0.0
        ship.go(10.0)
        assert ship.get("x", "y", "psi") == first


@needs_compiler
@pytest.mark.parametrize("fmi", [2, 3])
def test_what_makes_no_ship_is_refused(fmi, built, tmp_path):
    with (
        pytest.raises(Exception, match="fmi"),
        sailing(built("s175", fmi), tmp_path / "heavy", ship__mass=-1e9),
    ):
        pass
    with sailing(built("s175", fmi), tmp_path / "late") as ship:
        with pytest.raises(Exception, match="Set"):
            ship.set(ship__mass=1e7)
        with pytest.raises(Exception, match="Set"):
            ship.set(u=3.0)


# --- The archive and who asks for it -------------------------------------------------------------


@pytest.mark.slow
def test_the_archive_is_the_same_to_the_bit():
    program = (
        "import sys, pmmkit as pk; from pmmkit.exports.fmu.unit import model_to_fmu;"
        "sys.stdout.buffer.write(model_to_fmu(pk.load_model('kvlcc2-l7'), speed=1.179))"
    )
    other = {**os.environ, "PYTHONHASHSEED": "1"}
    call = [sys.executable, "-c", program]
    made = subprocess.run(call, capture_output=True, check=True, env=other).stdout
    assert made == model_to_fmu(pk.load_model("kvlcc2-l7"), speed=1.179)
    entries = zipfile.ZipFile(BytesIO(made)).infolist()
    assert {entry.date_time for entry in entries} == {(1980, 1, 1, 0, 0, 0)}
    faster = model_to_fmu(pk.load_model("kvlcc2-l7"), speed=1.2)
    tokens = {
        re.search(rb'instantiationToken="(.*?)"', part(content, "modelDescription.xml"))[1]
        for content in (made, faster)
    }
    assert len(tokens) == 2


def part(content: bytes, name: str) -> bytes:
    return zipfile.ZipFile(BytesIO(content)).read(name)


def test_names_and_titles_of_a_file_stay_text():
    evil = '*/ int main(void) { } // \\ "/> <!-- coding: utf-7 \n #include <evil>'
    model = pk.load_model("kvlcc2-l7").with_(name=evil, title=evil)
    content = model_to_fmu(model, speed=1.179)
    lines = part(content, "sources/equations.h").decode("ascii").splitlines()
    assert all(line.startswith("//") for line in lines if "evil" in line or "main" in line)
    assert not any(line.startswith("//") and line.endswith("\\") for line in lines)
    root = ET.fromstring(part(content, "modelDescription.xml"))
    assert root.find("CoSimulation").get("modelIdentifier").isidentifier()


def odd_drag(v: float, size: float) -> tuple[float]:
    """A drag by a list of its own."""
    return (size * sum([v, -v]),)


def test_what_cannot_be_written_is_named():
    size = Parameter(name="size", text="of nothing", typical=1.0)
    about = {"family": "own", "kind": "force", "summary": "None.", "outputs": ("Y",)}
    register_effect(Effect(name="odd_drag", force=odd_drag, parameters=(size,), **about))
    try:
        plain = pk.load_model("kvlcc2-l7")
        odd = Part(effect="odd_drag", values={"size": 1.0})
        with pytest.raises(ModelError, match="odd_drag: it is written with"):
            model_to_fmu(plain.with_(parts={**plain.parts, "odd_drag": odd}))
    finally:
        CATALOGUE.forget("odd_drag")


@pytest.mark.slow
def test_the_command(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["export", "s175", "--to", "fmu", "--json"]) == 0
    printed = capsys.readouterr()
    assert json.loads(printed.out)["files"] == ["s175.fmu"]
    assert "--speed" in printed.err
    assert "--compile" in printed.err
    assert main(["export", "s175", "-o", "two.fmu", "--fmi", "2", "--speed", "8"]) == 0
    assert b'fmiVersion="2.0"' in part((tmp_path / "two.fmu").read_bytes(), "modelDescription.xml")


@pytest.mark.parametrize(
    ("order", "status", "words"),
    [
        ("export s175 --to fmo", 2, "'fmu'"),
        ("export s175 --to fmu --fmi 1", 2, "'3', '2'"),
        ("export s175 --to mss --fmi 2", 1, "--to fmu"),
        ("export s175 --to csv --compile", 1, "not written as csv"),
        ("export mariner --to fmu", 1, "--speed 8"),
        ("export s175 --to fmu --compile", 1, "No C compiler"),
        ("export s175 --to fmu --speed -3", 1, "must be positive"),
    ],
)
def test_mistakes_of_the_user_are_told(order, status, words, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("CC", "no-such-compiler")
    assert main(order.split()) == status
    printed = capsys.readouterr().err
    assert words in printed
    assert "Traceback" not in printed
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_a_compiler_that_fails_is_told_in_its_words(monkeypatch, tmp_path):
    compiler = tmp_path / "compiler"
    compiler.write_text(f"#!{sys.executable}\nimport sys; sys.exit('no licence')\n")
    compiler.chmod(0o755)
    monkeypatch.setenv("CC", str(compiler))
    with pytest.raises(DataError, match="no licence"):
        model_to_fmu(pk.load_model("kvlcc2-l7"), speed=1.179, compile=True)


def test_versions_and_speeds_that_are_not_there():
    model = pk.load_model("kvlcc2-l7")
    with pytest.raises(DataError, match="versions 2 and 3"):
        model_to_fmu(model, fmi=1)
    with pytest.raises(DataError, match="positive"):
        model_to_fmu(model, speed=-1.0)
    wide = model.with_(Fn=(0.1, 0.2)).with_values("hull_polynomial", Yv=(-0.3, -0.32))
    with pytest.raises(ModelError, match="speed=8"):
        model_to_fmu(wide)
