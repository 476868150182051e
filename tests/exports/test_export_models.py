"""Models for MSS and shipmmg: their numbers are ours, and no text of a file becomes code."""

from __future__ import annotations

import importlib.util
import itertools
import math
import random
import re
import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import RegularGridInterpolator
from small_campaign import write_campaign

import pmmkit as pk
from pmmkit.base import ModelError, PmmkitError
from pmmkit.equations import prepare
from pmmkit.exports.matlab.model import model_to_mss
from pmmkit.exports.shipmmg import model_to_shipmmg
from pmmkit.models import Part, Step
from pmmkit.syntax import is_matlab_name, matlab_name, plain

SPEEDS = {
    "kvlcc2-l7": 1.179,
    "mariner": 7.7175,
    "s175-3dof": 8.0,
    "s175": 8.0,
    "kcs": 10.0,
    "esso190k": 8.0,
    "esso-osaka-3m": 0.8,
}
OCTAVE = shutil.which("octave-cli")
EVIL = "x'); system('rm"


@pytest.fixture(scope="module")
def reduced(tmp_path_factory):
    """A model whose values depend on the Froude number, from tests."""
    campaign = write_campaign(tmp_path_factory.mktemp("tests") / "small")
    return pk.to_model(pk.reduce(pk.open_campaign(campaign)), "s175-3dof", name="reduced")


# --- A function of MSS, its arithmetic done in Python -------------------------------------------

_FUNCTIONS = {
    "abs": abs,
    "max": max,
    "min": min,
    "sqrt": math.sqrt,
    "exp": math.exp,
    "sin": math.sin,
    "cos": math.cos,
    "tanh": math.tanh,
    "atan2": math.atan2,
    "where": lambda condition, yes, no: yes if condition else no,
    "interpolate": lambda x, xs, ys: float(np.interp(x, xs, ys)),
    "interpolate_rows": lambda x, xs, y, ys, rows: float(
        RegularGridInterpolator((xs, ys), np.reshape(rows, (len(xs), len(ys))))(
            (np.clip(x, xs[0], xs[-1]), np.clip(y, ys[0], ys[-1]))
        )
    ),
}
_ASSIGNMENT = re.compile(r"([A-Za-z]\w*) = ([\w\s.,+*/^()\[\]<>=~-]+);(?:\s+%.*)?")


def statements(text: str) -> list[str]:
    """The lines of the function itself that are no comments, continued lines joined."""
    body = text.split("\nend\n")[0].replace(" ...\n", " ")
    return [line.strip() for line in body.splitlines() if line.strip() and line[0] != "%"]


def evaluate(text: str, x: list[float], ui: list[float]) -> tuple[list[float], float]:
    """xdot and U of an exported function, by its own arithmetic."""
    known: dict[str, float] = {"pi": math.pi, "Inf": math.inf}
    for line in statements(text)[1:]:
        if line.startswith("if "):
            default = re.search(r"U0 = (\S+);", line)
            known |= {"U0": float(default[1])} if default else {}
            more = re.search(r"ui = \[ui; (\S+)\];", line)
            ui = [*ui, float(more[1])] if more and len(ui) == 1 else ui
            continue
        found = _ASSIGNMENT.fullmatch(line)
        if line.startswith("xdot = "):
            return [known[name] for name in re.findall(r"\w+_dot", line)], known["U"]
        assert found, f"not an assignment of plain arithmetic: {line}"
        code = re.sub(
            r"\b(x|ui|\w+_deg)\((\d+)\)", lambda at: f"{at[1]}[{int(at[2]) - 1}]", found[2]
        )
        scope = {**_FUNCTIONS, **known, "x": x, "ui": ui, "__builtins__": {}}
        known[found[1]] = eval(code.replace("^", "**").replace("~=", "!="), scope)
    raise AssertionError("the function gives no xdot")


def states_of(text: str) -> list[str]:
    heading = text.replace("\n% ", " ")
    return re.search(r"state vector x = \[ (.*?) \]'", heading)[1].split()


def random_states(model: pk.Model, speed: float, names: list[str], count: int):
    """States as MSS takes them, with inputs; every second time without revolutions."""
    rng = random.Random(7)
    about = model.convention.surge == "delta-u"
    for index in range(count):
        known = {
            "u": rng.uniform(0.3, 1.1) * speed - (speed if about else 0.0),
            "v": rng.uniform(-0.4, 0.4) * speed,
            "r": rng.uniform(-0.8, 0.8) * speed / model.ship.L,
            "p": rng.uniform(-0.05, 0.05),
            "phi": rng.uniform(-0.3, 0.3),
            "x": rng.uniform(-9, 9),
            "y": rng.uniform(-9, 9),
            "psi": rng.uniform(-3, 3),
            "delta": rng.uniform(-0.6, 0.6),
            "n": rng.uniform(40, 200),
        }
        turns = [] if "rudder_abkowitz" in model.parts or index % 2 else [rng.uniform(40, 600)]
        yield [known[name] for name in names], [rng.uniform(-0.8, 0.8), *turns]


def rates(model: pk.Model, speed: float, names: list[str], x: list[float], ui: list[float]):
    """The same from pmmkit's own right-hand side and steering gear."""
    ready = prepare(model, speed)
    given = dict(zip(names, x, strict=True))
    given["u"] += speed if model.convention.surge == "delta-u" else 0.0
    given["n"] = given.get("n", 0.0) / 60
    turns = 0.0
    if ready.structure.revolutions:
        turns = ui[1] / 60 if len(ui) > 1 else ready.self_propulsion()
    y = [given.get(name, 0.0) for name in ready.structure.states]
    out = dict(zip(ready.structure.states, ready.rates(y, given["delta"], turns), strict=True))
    steering = next(
        model.values(effect, model.ship.froude(speed, model.water.g) if model.Fn else None)
        for effect in ("rudder_mmg", "rudder_abkowitz", "tanker_bis")
        if effect in model.parts
    )
    most, rate = math.radians(steering["max_deg"]), math.radians(steering["rate_deg_s"])
    order = min(max(ui[0], -most), most) - given["delta"]
    out |= {"delta": min(max(order, -rate), rate), "n": 60 * out.get("n", 0.0)}
    return [out[name] for name in names]


def library(name: str, reduced: pk.Model) -> tuple[pk.Model, float]:
    return (reduced, 8.0) if name == "reduced" else (pk.load_model(name), SPEEDS[name])


@pytest.mark.slow
@pytest.mark.parametrize("name", [*SPEEDS, "reduced"])
def test_the_function_of_mss_has_our_right_hand_side(name, reduced):
    assert_same_rates(*library(name, reduced), 40)


@pytest.mark.skipif(OCTAVE is None, reason="there is no octave-cli")
@pytest.mark.parametrize("name", ["kvlcc2-l7", "mariner", "s175", "s175-3dof", "reduced"])
def test_octave_gives_our_right_hand_side(name, reduced, tmp_path):
    model, speed = library(name, reduced)
    (file,) = pk.export(model, tmp_path / "ship.m", speed=speed)
    names = states_of(file.read_text(encoding="ascii"))
    cases = list(random_states(model, speed, names, 25))
    calls = [
        f"printf('%.17g ', ship([{'; '.join(map(repr, x))}], [{'; '.join(map(repr, ui))}]));"
        for x, ui in cases
    ]
    (tmp_path / "cases.m").write_text("\n".join(calls), encoding="ascii")
    done = subprocess.run(
        [OCTAVE, "--norc", "--quiet", "cases.m"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    )
    theirs = np.array(done.stdout.split(), float).reshape(len(cases), len(names))
    ours = [rates(model, speed, names, x, ui) for x, ui in cases]
    np.testing.assert_allclose(theirs, ours, rtol=1e-9, atol=1e-13)


def test_mariner_has_the_states_and_inputs_of_mss_mariner():
    text = model_to_mss(pk.load_model("mariner"), speed=7.7175)
    assert text.startswith("function [xdot,U] = mariner(x,ui,U0)\n")
    assert states_of(text) == ["u", "v", "r", "x", "y", "psi", "delta"]
    assert "if nargin < 3, U0 = 7.7175; end" in text
    ahead, _ = evaluate(text, [0.0] * 7, [0.0])
    assert ahead[0] == 0.0
    assert ahead[3] == 7.7175
    turned, _ = evaluate(text, [0.0] * 6 + [0.2], [0.2])
    assert turned[2] > 0.0


def assert_same_rates(model: pk.Model, speed: float, count: int) -> None:
    text = model_to_mss(model, speed=speed)
    names = states_of(text)
    for x, ui in random_states(model, speed, names, count):
        xdot, U = evaluate(text, x, ui)
        np.testing.assert_allclose(xdot, rates(model, speed, names, x, ui), rtol=1e-9, atol=1e-13)
        u = x[0] + (speed if model.convention.surge == "delta-u" else 0.0)
        np.testing.assert_allclose(U, math.hypot(u, x[1]), rtol=1e-12)


CONVENTIONS = [
    dict(zip(("system", "U", "surge", "coriolis", "sway", "rudder_positive"), words, strict=True))
    for words in itertools.product(
        ("prime", "prime-d", "bis"),
        ("instantaneous", "carriage"),
        ("u", "constant", "delta-u"),
        ("in-derivatives", "separate"),
        ("v", "beta"),
        ("starboard", "port"),
    )
]


@pytest.mark.slow
def test_every_convention_is_written_as_it_is_meant():
    known = pk.load_model("s175-3dof")
    known = known.with_values(
        "hull_polynomial", **{"Yv|v|": -0.02, "Nr|r|": 0.001, "X0": -1e-4, "Yuv": -0.003}
    )
    polynomial = {"Yd": 0.002, "Yvdd": 0.01, "Nddd": -0.001, "rate_deg_s": 3.0, "max_deg": 35.0}
    parts = {name: part for name, part in known.parts.items() if name != "rudder_mmg"}
    parts["rudder_abkowitz"] = Part(effect="rudder_abkowitz", values=polynomial)
    driven = {**parts, "propeller": Part(effect="propeller", values=_WAKE | {"kt0": 90.0})}
    del parts["propeller"]
    for words in CONVENTIONS:
        model = known.with_(
            parts=parts if words["surge"] == "delta-u" else driven,
            convention=known.convention.with_(**words),
        )
        assert_same_rates(model, 8.0, 2)


_WAKE = {"D": 6.5, "t": 0.17, "wp": 0.18, "kt0": 0.527, "kt1": -0.455}
_TABLE = {"J": (0.0, 0.5, 1.0), "KT": (0.5, 0.3, 0.05), "KQ": (0.06, 0.04, 0.01)}
_QUADRANTS = {
    "D": 6.5, "t": 0.17, "wp": 0.18, "beta_deg": (-180.0, -90.0, 0.0, 45.0, 90.0, 180.0),
    "CT": (-0.4, -1.1, 0.3, 0.1, -0.9, -0.3), "CQ": (0.0, -0.1, 0.04, 0.02, -0.1, 0.0),
}  # fmt: skip
_BLADE = dict(pk.load_model("s175").parts["rudder_mmg"].values)
_SEA = {"Hs": 4.0, "from_deg": 50.0, "angle_deg": (0.0, 90.0, 180.0)} | {
    "speeds": (0.0, 5.0, 9.0),
    "DX": (-0.01, 0.0, 0.01, -0.03, 0.0, 0.01, -0.04, 0.0, 0.0),
    "DY": (0.0, -0.05, 0.0, 0.0, -0.06, 0.0, 0.0, -0.07, 0.0),
    "DN": (0.0, 0.001, 0.0, 0.0, -0.004, 0.0, 0.0, -0.005, 0.0),
}
_ENGINE = {"inertia": 2e5, "torque_max": 2e6}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("effect", "values", "options"),
    [
        ("propeller", _WAKE, {"wake": "constant"}),
        ("propeller", _WAKE | {"tau": 0.4, "cp": -0.2}, {"wake": "kose"}),
        (
            "propeller",
            {"D": 6.5, "t": 0.17, "wp": 0.18, **_TABLE},
            {"wake": "constant", "open_water": "table"},
        ),
        ("rudder_mmg", _BLADE | {"stall_deg": 15.0, "stall_loss": 0.5}, {"stall": "smooth"}),
        ("crossflow_drag", {"CD": 0.6, "CrY": 1.1}, {}),
        ("crossflow_drag", {"CD": 0.6, "growth": 0.8}, {"shape": "ends", "form": "without-sway"}),
        ("resistance_curve", {"X_F": -4e-5, "X_FF": 1e-5, "Fn0": 0.2}, {}),
        ("nonlinear_added_mass", {"Yvvvdot": -0.02, "Nvvvdot": -0.004}, {}),
        ("roll", {"damping": 1e8, "damping_quadratic": 1e9}, {"restoring": "sine"}),
        ("shaft_lag", {"time_constant": 9.0, "n_step": 0.2}, {}),
        ("shaft_lag", {}, {"law": "by-turns"}),
        ("shaft", _ENGINE, {}),
        ("shaft", _ENGINE | {"n_rated": 2.0}, {"limit": "falling"}),
        ("shaft", _ENGINE | {"power_max": 2e7, "friction": 1e4}, {"limit": "power"}),
        ("four_quadrant_propeller", _QUADRANTS, {"wake": "constant", "characteristics": "table"}),
        ("wave_drift", _SEA, {"coefficients": "speeds"}),
    ],
)
@pytest.mark.parametrize("ship", ["s175", "s175-3dof"])
def test_effects_keep_their_numbers_with_every_option(ship, effect, values, options):
    model = pk.load_model("s175" if effect == "roll" else ship)
    parts = {**model.parts, effect: Part(effect=effect, values=values, options=options)}
    if effect == "four_quadrant_propeller":
        del parts["propeller"]
    if effect == "rudder_mmg":
        parts[effect] = Part(
            effect=effect, values=values, options={**model.parts[effect].options, **options}
        )
    assert_same_rates(model.with_(parts=parts), 8.0, 20)


@pytest.mark.slow
def test_values_that_depend_on_speed_need_one(reduced):
    with pytest.raises(ModelError, match=r"2 Froude numbers.*speed=8"):
        model_to_mss(reduced)
    slow, fast = (statements(model_to_mss(reduced, speed=speed)) for speed in (6.1, 11.9))
    assert slow != fast
    with pytest.raises(PmmkitError, match="outside the range"):
        model_to_mss(reduced, speed=30.0)


def test_every_number_of_a_model_stands_in_the_function_as_it_is():
    model = pk.load_model("kvlcc2-l7")
    text = model_to_mss(model)
    for name, value in model.parts["hull_polynomial"].values.items():
        assert f"{name} = {value!r};" in text
    for name in ("D", "t", "C1", "kt2"):
        assert f"propeller_{name} = {model.parts['propeller'].values[name]!r};" in text
    assert "library: Yasukawa and Yoshimura 2015" in text
    assert f"pmmkit {pk.__version__}" in text


@pytest.mark.parametrize(
    ("effect", "values", "options", "why"),
    [
        ("memory", {"Yv_late": -0.002, "Nv_late": 0.0, "lag": 0.5}, {}, "late_sway"),
        ("wind", {"AF": 10.0, "AL": 50.0}, {}, "the wind"),
        (
            "crossflow_drag",
            {"CD": 0.5, "station": (-0.5, 0.5), "CD_station": (1.0, 2.0)},
            {"shape": "table"},
            "a loop",
        ),
    ],
)
def test_an_effect_that_mss_cannot_express_is_named(effect, values, options, why, tmp_path):
    model = pk.load_model("s175-3dof")
    model = model.with_(
        parts={**model.parts, effect: Part(effect=effect, values=values, options=options)}
    )
    target = tmp_path / "ship.m"
    target.write_text("as it was", encoding="ascii")
    with pytest.raises(ModelError, match=rf"{effect}: .*{why}"):
        pk.export(model, target)
    assert target.read_text(encoding="ascii") == "as it was"
    assert [file.name for file in tmp_path.iterdir()] == ["ship.m"]


def test_all_effects_without_a_place_are_named_at_once():
    model = pk.load_model("s175-3dof")
    parts = {
        "wind": Part(effect="wind", values={"AF": 10.0, "AL": 50.0}),
        "lagged_crossflow": Part(
            effect="lagged_crossflow", values={"Yvvv_late": -0.1, "Nvvv_late": 0.0, "lag": 0.5}
        ),
    }
    with pytest.raises(ModelError) as caught:
        model_to_mss(model.with_(parts={**model.parts, **parts}))
    assert len(caught.value.problems) == 2


# --- shipmmg -----------------------------------------------------------------------------------


def shipmmg_module(model: pk.Model, folder, speed: float):
    pytest.importorskip("shipmmg")
    (file,) = pk.export(model, folder / "ship.py", "shipmmg", speed=speed)
    spec = importlib.util.spec_from_file_location("exported_ship", file)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_shipmmg_has_our_right_hand_side_where_its_wake_is_ours(tmp_path, monkeypatch):
    """With β = xP r' neither wake changes; with xG = 0 both refer to midship."""
    known = pk.load_model("kvlcc2-l7")
    model = known.with_(ship=replace(known.ship, xG=0.0))
    module = shipmmg_module(model, tmp_path, 1.179)
    monkeypatch.setattr("shipmmg.mmg_3dof.solve_ivp", lambda function, *_, **__: function)
    from shipmmg.mmg_3dof import simulate_mmg_3dof

    theirs = simulate_mmg_3dof(
        module.basic_params,
        module.maneuvering_params,
        [0.0, 1.0],
        [0.0, 0.0],
        [10.0, 10.0],
        ρ=module.rho,
    )
    ready, rng = prepare(model, 1.179), np.random.default_rng(3)
    for _ in range(50):
        U, r, delta, n = rng.uniform((0.4, -0.15, -0.6, 5.0), (1.2, 0.15, 0.6, 14.0))
        beta = model.parts["propeller"].values["xp"] * r * model.ship.L / U
        u, v = U * math.cos(beta), -U * math.sin(beta)
        ours = ready.accelerations(u, v, r, delta=delta, n=n)[:3]
        found = theirs(0.0, [u, v, r, 0.0, 0.0, 0.0, delta, n])[:3]
        np.testing.assert_allclose(found, ours, rtol=1e-9)


def test_a_turn_by_shipmmg_differs_by_its_wake_and_its_point_of_reference(tmp_path):
    """Both differences are stated in the file; without them the turns agree to 1e-6."""
    model = pk.load_model("kvlcc2-l7")
    module = shipmmg_module(model, tmp_path, 1.179)
    from shipmmg.mmg_3dof import simulate_mmg_3dof

    t = np.linspace(0.0, 100.0, 4001)
    delta = np.minimum(np.radians(module.rudder_rate) * t, np.radians(35.0))
    run = simulate_mmg_3dof(
        module.basic_params,
        module.maneuvering_params,
        t,
        delta,
        np.full(len(t), module.nps),
        u0=module.u0,
        ρ=module.rho,
        rtol=1e-7,
    )
    _, _, _, x, y, psi, *_ = run.sol(t)
    L = model.ship.L
    theirs = np.interp(np.pi / 2, psi, x) / L, np.interp(np.pi, psi, y) / L
    ours = pk.simulate(model, "turning", rudder_deg=35, speed=1.179, compiled=False).metrics
    assert theirs[0] / ours["advance_L"] - 1 == pytest.approx(0.0118, abs=5e-4)
    assert theirs[1] / ours["tactical_diameter_L"] - 1 == pytest.approx(-0.0115, abs=5e-4)


def test_the_constants_of_nomoto_are_those_of_the_linear_ship(tmp_path):
    module = shipmmg_module(pk.load_model("kcs"), tmp_path, 10.0)
    found = pk.stability("kcs", 10.0)
    stated = module.kt_params.K, module.kt_params.T
    assert stated == pytest.approx((found.K * 10.0 / 230.0, found.T * 230.0 / 10.0))


def test_shipmmg_is_refused_with_what_is_missing():
    with pytest.raises(ModelError, match=r"(?s)lacks propeller, rudder_mmg.*rudder_abkowitz"):
        model_to_shipmmg(pk.load_model("mariner"), speed=7.0)
    with pytest.raises(ModelError, match="inflow of rudder_mmg is 'son-nomoto'"):
        model_to_shipmmg(pk.load_model("s175-3dof"))
    model = pk.load_model("kvlcc2-l7")
    strange = model.with_values("hull_polynomial", Yvv=0.01)
    with pytest.raises(ModelError, match="no place for Yvv"):
        model_to_shipmmg(strange)


# --- Texts of files stay texts ---------------------------------------------------------------


def code_lines(text: str, sign: str) -> list[str]:
    return [line for line in text.splitlines() if line and not line.startswith(sign)]


@pytest.mark.slow
@settings(deadline=None, max_examples=40)
@given(texts=st.lists(st.text(max_size=60), min_size=5, max_size=5))
def test_no_text_of_a_model_becomes_code(texts):
    known = pk.load_model("kvlcc2-l7")
    name, title, scale, note, source = texts
    screw = known.parts["propeller"]
    named = Part(effect="propeller", values=screw.values, options=screw.options, source=source)
    model = known.with_(
        name=name or "x",
        title=title,
        scale=scale,
        notes=(note,),
        steps=(Step(action="noted", note=source),),
        parts={**known.parts, "propeller": named},
    )
    for make, sign in ((model_to_mss, "%"), (model_to_shipmmg, "#")):
        written = make(model)
        assert written.isascii()
        assert written == make(model)
        ours, plainly = code_lines(written, sign), code_lines(make(known), sign)
        assert ours[1:] == plainly[1:]
    assert is_matlab_name(matlab_name(name))


def test_a_model_with_an_evil_name_does_nothing_but_compute(tmp_path):
    model = pk.load_model("kvlcc2-l7").with_(
        name=EVIL, title="\nsystem('touch gone');\r%{", notes=("\u2028delete gone",)
    )
    text = model_to_mss(model, speed=1.179)
    assert text.startswith("function [xdot,U] = x_system_rm(x,ui)\n")
    for line in statements(text)[1:]:
        allowed = (_ASSIGNMENT.fullmatch(line), re.match(r"if (nargin|length)", line), "xdot = [")
        assert allowed[0] or allowed[1] or line.startswith(allowed[2]), line
    assert not [line for line in text.splitlines() if line.strip() == "%{"]
    if OCTAVE is not None:
        (file,) = pk.export(model, tmp_path / "ship.m", speed=1.179)
        call = f"addpath('{tmp_path}'); disp(size(ship([1;0;0;0;0;0;0], 0)))"
        subprocess.run([OCTAVE, "--norc", "--quiet", "--eval", call], cwd=tmp_path, check=True)
        assert [item.name for item in tmp_path.iterdir()] == [file.name]


@settings(deadline=None, max_examples=50)
@given(text=st.text(max_size=80))
def test_names_and_comments_are_harmless_whatever_the_text(text):
    assert is_matlab_name(matlab_name(text))
    line = plain(text)
    assert line.isascii()
    assert line.isprintable() or not line
    assert plain(line) == line


@pytest.mark.parametrize("name", ["end", "where", "x", "7m", "a b", "kvlcc2-l7", "a" * 64])
def test_file_names_must_be_names_of_functions(name, tmp_path):
    with pytest.raises(ModelError, match="no name of a function"):
        pk.export("mariner", tmp_path / f"{name}.m", speed=7.0)
