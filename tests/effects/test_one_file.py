"""An effect in one new file takes part in everything; and eight effects written as text."""

from __future__ import annotations

import importlib
import sys
from unittest import mock

import numpy as np
import pytest
from hidden_effects import SHIP, hidden_campaign, tank
from hidden_effects.hull import add, prime

import pmmkit as pk
from pmmkit.diagnosis import begin, candidate_of
from pmmkit.diagnosis.captive.diagnose import diagnose_captive
from pmmkit.diagnosis.captive.refit import captive_candidates
from pmmkit.diagnosis.free_running.hypotheses import candidates_for
from pmmkit.effects import CATALOGUE
from pmmkit.equations import prepare
from pmmkit.identification import fit_to_forces
from pmmkit.identification.forces import ForceRecord
from pmmkit.models import load_model, scaled
from pmmkit.testing.effects import check_effect
from scripts.documentation.make_docs import effect_page
from scripts.documentation.signatures import signatures

FILE = '''"""A skeg that yawing in drift unloads, once the drift is large enough."""

from pmmkit.effects import Effect, Parameter
from pmmkit.effects.primitives import fabs, maximum


def force(v, r, U, L, rho, Y_skeg, N_skeg, edge):
    past = maximum(fabs(v / U) - edge, 0.0) * (r * L / U)
    unit = 0.5 * rho * L * L * U * U
    return unit * Y_skeg * past, unit * L * N_skeg * past


EFFECTS = (
    Effect(
        name="skeg_of_one_file",
        family="made_up",
        kind="force",
        summary="A skeg that yawing in drift unloads.",
        parameters=(
            Parameter(name="Y_skeg", text="over ½ρL²U²", typical=0.004),
            Parameter(name="N_skeg", text="over ½ρL³U²", typical=-0.003),
            Parameter(name="edge", text="drift v/U where it begins", grid=(0.02, 0.05, 0.1)),
        ),
        force=force,
        outputs=("Y", "N"),
        check="yaw with drift at three drift angles",
    ),
)
'''
NAME = "skeg_of_one_file"
TRUTH = {"Y_skeg": 0.006, "N_skeg": -0.005}
EDGE = 0.05


def by_hand(m):
    """The same written down anew, for the tank."""
    past = np.where(np.abs(m.vp) > EDGE, np.abs(m.vp) - EDGE, 0.0) * m.rp
    return prime(m, Y=TRUTH["Y_skeg"] * past, N=TRUTH["N_skeg"] * past)


@pytest.fixture(scope="module")
def skeg(tmp_path_factory):
    folder = tmp_path_factory.mktemp("effects")
    (folder / f"{NAME}.py").write_text(FILE, encoding="utf-8")
    package = importlib.import_module("pmmkit.effects")
    with mock.patch.object(package, "__path__", [*package.__path__, str(folder)]):
        CATALOGUE.reload()
        yield pk.catalogue()[NAME]
    sys.modules.pop(f"pmmkit.effects.{NAME}", None)
    CATALOGUE.reload()


@pytest.fixture(scope="module")
def campaign():
    """Tests of a tank in which the skeg was hidden by hand."""
    plain = tank.water_force

    def with_skeg(m, effects, truth):
        return add(plain(m, effects, truth), by_hand(m))

    with mock.patch.object(tank, "water_force", with_skeg):
        return hidden_campaign("middle", {}, seed=3)


def test_it_holds_the_contract(skeg):
    check_effect(skeg)


def test_it_is_simulated_saved_and_scaled(skeg, tmp_path):
    ship = load_model("s175-3dof")
    held = pk.with_effect(ship, NAME, coefficients={"Y_skeg": 0.02, "N_skeg": -0.02}, value=EDGE)
    pk.save_model(held, tmp_path / "held.toml")
    again = load_model(tmp_path / "held.toml")
    assert again.values(NAME) == {"Y_skeg": 0.02, "N_skeg": -0.02, "edge": EDGE}
    held_turn, plain = (
        pk.simulate(model, speed=8.0, rudder_deg=35, compiled=False).metrics["advance"]
        for model in (again, ship)
    )
    assert abs(plain - held_turn) > 1e-3 * held_turn
    small = pk.simulate(scaled(again, 175.0 / 16), speed=2.0, rudder_deg=35, compiled=False)
    assert 16 * small.metrics["advance"] == pytest.approx(held_turn, rel=1e-6)


def test_it_is_identified_from_forces_along_a_history(skeg):
    ship = load_model("s175-3dof")
    ready = prepare(ship, 8.0)
    t = np.linspace(0.0, 60.0, 121)
    motion = {"u": np.full(121, 8.0), "v": 1.5 * np.sin(0.3 * t), "r": 0.02 * np.cos(0.2 * t)}
    U, L = np.hypot(motion["u"], motion["v"]), ship.ship.L
    past = np.maximum(np.abs(motion["v"]) / U - EDGE, 0.0) * motion["r"] * L / U
    unit = 0.5 * ship.water.rho * L**2 * U**2
    forces = ready.water_forces(motion)
    forces["Y"] = forces["Y"] + 0.006 * unit * past
    forces["N"] = forces["N"] - 0.005 * unit * L * past
    record = ForceRecord(
        name="by hand",
        motion=motion,
        speed=8.0,
        std={"Y": 1.0, "N": 1.0},
        forces={name: forces[name] for name in "YN"},
    )
    start = pk.with_effect(ship, NAME, value=EDGE)
    found = fit_to_forces(start, [record], [f"{NAME}.Y_skeg", f"{NAME}.N_skeg"])
    np.testing.assert_allclose(found.values, list(TRUTH.values()), rtol=1e-6)


def test_captive_tests_name_it_and_the_loop_adds_it(skeg, campaign):
    found = diagnose_captive(campaign, "cubic")
    assert NAME in found.group[0][0]
    finding = next(item for item in found.findings if item.effect == NAME)
    assert finding.value == pytest.approx(EDGE, abs=0.03)
    for name, size in TRUTH.items():
        assert finding.coefficients[name] == pytest.approx(size, rel=0.4)
    ship = pk.without_effect(scaled(load_model("s175-3dof"), SHIP.L), "yaw_sway_coupling")
    made = begin(ship, campaign).add(finding).model()
    assert made.values(NAME)["N_skeg"] == pytest.approx(TRUTH["N_skeg"], rel=0.4)
    assert made.steps[-1].effect == NAME


def test_free_running_records_can_be_asked_for_it(skeg):
    (found,) = [x for x in candidates_for(load_model("kvlcc2-l7"), []) if x.name == NAME]
    assert found.values == (f"{NAME}.Y_skeg", f"{NAME}.N_skeg")


def test_it_has_a_page_and_a_signature(skeg):
    every = [x for x in captive_candidates((1.0,)) if x.name in (NAME, "yaw_sway_coupling")]
    (signature,) = [x for x in signatures(every) if x.name == NAME]
    assert "Y" in signature.acts["yaw_drift"]
    assert "drift v/U where it begins" in effect_page(skeg, signature)


TEXTS = {
    "saturation": "Y: a*sat(v, edge)*|v|; N: b*sat(v, edge)*|v|; a ~ -0.01; b ~ 0.003;"
    "edge ~ [0.05, 0.1]",
    "of_froude": "X: a*Fn^2*v*v; a ~ -0.05",
    "of_the_drift_angle": "N: a*|beta|*r; a ~ -0.005",
    "of_sinkage": "Y: a*sinkage*v; a ~ -0.02",
    "late": "Y: a*lag(v*|v|, 0.4); a ~ -0.01",
    "products": "Y: a*v*|v|*r; N: -0.4*a*v*|v|*r; a ~ -0.04",
    "rudder_beyond": "N: a*beyond(d, edge); a ~ 0.001; edge ~ [0.2, 0.35]",
    "of_roll": "Y: a*phi*|v|; K: b*p*|p|; a ~ 0.003; b ~ -0.001",
}


@pytest.mark.parametrize("name", TEXTS)
def test_effects_as_text_enter_a_captive_system(name):
    """What another effect of the same shape by hand gives is in the other tests of expressions."""
    own = pk.own_effect(f"own_{name}", TEXTS[name], check="a run")
    candidate = candidate_of(own)
    system = begin("cubic", hidden_campaign("small", {}, seed=1), own=(own,)).evidence.system
    names = [block.candidate.name for block in system.blocks]
    assert (own.name in names) == system.base.excited(system.views).issuperset(own.excites)
    assert candidate.coefficients == tuple(own.typical)
