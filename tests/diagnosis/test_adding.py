"""What a diagnosis names enters the simulator with the same force, whatever the model's words."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hidden_effects import SHIP, SIZES, WATER, hidden_campaign
from hidden_effects import catalogue as tank
from hidden_effects.hull import TRUTH
from hidden_effects.programmes import plans
from hidden_effects.tank import motions

import pmmkit as pk
from pmmkit import catalogue
from pmmkit.base import MissingPartError, ModelError, TableError, UnknownNameError
from pmmkit.conventions import Convention
from pmmkit.diagnosis.captive.diagnose import diagnose_captive
from pmmkit.diagnosis.captive.refit import captive_candidates
from pmmkit.effects import BY_SPEED, Regressors, State
from pmmkit.equations import prepare
from pmmkit.models import load_model, model_text

FROUDE = tuple(speed / (WATER.g * SHIP.L) ** 0.5 for speed in (1.0, 1.5, 2.0))
PHYSICS = [item for item in captive_candidates((1.0,)) if item.kind == "physics"]
FAULTS = [item for item in captive_candidates((1.0,)) if item.kind == "fault"]
TERMS = [item for item in catalogue().values() if item.kind == "terms"]


def bare(name):
    """A library ship without the effects of the diagnosis."""
    model = load_model(name)
    for candidate in PHYSICS:
        try:
            model = pk.without_effect(model, candidate.name)
        except ModelError:
            continue
    return model


def in_the_tank():
    """The S175 with roll at the size of the tank's model, all Coriolis terms in the derivatives."""
    model = bare("s175")
    return model.with_(
        ship=replace(model.ship, L=SHIP.L, B=SHIP.B, d=SHIP.d, volume=SHIP.volume),
        water=WATER,
        convention=model.convention.with_(coriolis="in-derivatives"),
    )


NEAR = {
    "memory": 0.06,
    "lagged_crossflow": 0.04,
    "froude_linear": 6e-3,
    "froude_nonlinear": 6e-3,
    "resistance_curve": 8e-3,
}
"""Share of the largest force by which tank and model may differ, where more than 0.1 %: the tank
lags v' at the carriage's speed and the model the force at the speed of the instant, a difference of
v'²; the tank's F is zero at Fn 0.217, the model's at the middle speed, Fn 0.2172."""


def sizes_of(effect):
    """The tank's sizes as coefficients of the diagnosis, and the nonlinear parameter."""
    given = SIZES[effect]
    if effect == "crossflow_drag":
        return {"CD": given["CD"] / (1 + given["shape"] / 3)}, given["shape"]
    if effect in ("memory", "lagged_crossflow"):
        name = "v" if effect == "memory" else "vvv"
        found = {f"{a}{name}_late": given["share"] * TRUTH[f"{a}{name}"] for a in "YN"}
        return found, given["lag_LU"]
    mark = BY_SPEED if effect.startswith("froude") else ""
    return {f"{name}{mark}": value for name, value in given.items()}, None


def force_of(model, m):
    """Force of the water along a motion of the tank."""
    names = ("u", "v", "r", "udot", "vdot", "rdot", "phi", "psi", "t")
    size = len(m.t)
    history = {name: np.broadcast_to(getattr(m, name), (size,)) for name in names}
    history |= {"delta": np.full(size, m.delta)}
    ready = prepare(model, m.carriage)
    return ready.water_forces(history)


@pytest.mark.slow
@pytest.mark.parametrize("effect", [item.name for item in PHYSICS if item.name in SIZES])
def test_an_effect_in_a_model_has_the_force_of_the_virtual_tank(effect):
    """The tank's truth is written by hand; resistance is compared where the speed is steady."""
    model = in_the_tank()
    sizes, value = sizes_of(effect)
    better = pk.with_effect(model, effect, coefficients=sizes, value=value, Fn=FROUDE)
    found, expected = {"X": [], "Y": [], "N": []}, {"X": [], "Y": [], "N": []}
    for plan in plans("full"):
        if effect == "resistance_curve" and plan.dynamic:
            continue
        _, m = motions(plan, {}, "catalogue")
        m = replace(m, phi=np.broadcast_to(m.phi, m.u.shape))
        with_it, without = force_of(better, m), force_of(model, m)
        truth = tank.FORCES[effect](m)
        for channel in found:
            found[channel].append(with_it[channel] - without[channel])
            expected[channel].append(
                np.broadcast_to(truth.get(channel, 0.0), m.u.shape) * np.ones_like(m.u)
            )
    for channel in found:
        one, other = np.concatenate(found[channel]), np.concatenate(expected[channel])
        scale = np.abs(other).max()
        np.testing.assert_allclose(one, other, atol=NEAR.get(effect, 1e-3) * scale + 1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("ship", ["s175", "kvlcc2-l7", "kcs", "mariner", "esso190k"])
@pytest.mark.parametrize("effect", TERMS, ids=lambda effect: effect.name)
def test_derivatives_keep_their_force_in_the_convention_of_any_model(ship, effect):
    """The regressors in the convention of the diagnosis are the truth."""
    model = bare(ship)
    if effect.name == "heel_coupling" and not model.rolls:
        pytest.skip("the ship does not roll")
    rows = (0.12, 0.15, 0.18)
    model = model.with_(Fn=rows)
    sizes = {item.name: item.typical for item in effect.parameters}
    plain = {name: x for name, x in sizes.items() if not name.endswith(BY_SPEED)}
    try:
        better = pk.with_effect(model, effect.name, coefficients=sizes)
    except ModelError:
        assert "d" in effect.name or ship in ("mariner", "esso190k")
        pytest.skip("the ship has these derivatives from its source")
    before = {name for part in model.parts.values() for name in part.values}
    used = {name: x for name, x in plain.items() if name not in before}
    used |= {
        name.removesuffix(BY_SPEED): x * ((0.18 / 0.15) ** 2 - 1)
        for name, x in sizes.items()
        if name.endswith(BY_SPEED)
    }
    L, g = model.ship.L, model.water.g
    U = 0.18 * np.sqrt(g * L)
    rng = np.random.default_rng(1)
    beta, r = rng.uniform(-0.3, 0.3, 20), rng.uniform(-0.5, 0.5, 20) * U / L
    motion = {
        "u": U * np.cos(beta),
        "v": -U * np.sin(beta),
        "r": r,
        "phi": rng.uniform(-0.2, 0.2, 20),
        "delta": rng.uniform(-0.5, 0.5, 20),
        "n": np.full(20, 0.5),
    }
    truth = Regressors.at(
        list(used),
        State.of(**{k: x for k, x in motion.items() if k != "n"}),
        ship=model.ship,
        water=model.water,
        convention=Convention(),
        approach_speed=U,
    ).columns
    with_it, without = (
        ready.water_forces(motion) for ready in (prepare(x, U) for x in (better, model))
    )
    for channel in "XYN":
        own = [i for i, name in enumerate(used) if name[0] == channel]
        expected = truth[:, own] @ [list(used.values())[i] for i in own]
        if "Xvr" in plain and channel == "X" and model.convention.coriolis == "separate":
            ready = prepare(model, U)
            expected = expected - ready.k[23] * motion["v"] * motion["r"]
        found = with_it[channel] - without[channel]
        scale = np.abs(with_it[channel]).max()
        np.testing.assert_allclose(found, expected, atol=1e-10 * scale)


@pytest.mark.slow
@pytest.mark.parametrize("candidate", PHYSICS, ids=lambda candidate: candidate.name)
def test_an_effect_taken_out_leaves_the_model_as_it_was(candidate, tmp_path):
    model = bare("s175").with_(Fn=(0.15, 0.2, 0.25))
    better = pk.with_effect(model, candidate.name, coefficients="typical")
    pk.save_model(better, tmp_path / "better.toml")
    again = load_model(tmp_path / "better.toml")
    assert model_text(again) == model_text(better)
    assert len(better.history) == len(model.history) + 1
    assert candidate.name in better.history[-1]
    back = pk.without_effect(again, candidate.name)
    ready = [prepare(x, model.ship.speed(0.17)) for x in (model, back)]
    assert ready[0].structure.used == ready[1].structure.used
    assert ready[1].k == pytest.approx(ready[0].k, rel=1e-12, abs=1e-9)


def test_a_name_alone_enters_with_zeros_and_changes_nothing():
    model = bare("s175-3dof")
    better = model
    for candidate in sorted(PHYSICS, key=lambda item: "several speeds" in item.excites):
        if "roll" not in candidate.excites and "sinkage" not in candidate.excites:
            better = pk.with_effect(better, candidate.name, Fn=(0.1, 0.2, 0.3))
    motion = {"u": 8.0, "v": 1.0, "r": 0.01, "delta": 0.2, "n": 1.4}
    one, other = (prepare(x, 9.0).accelerations(**motion) for x in (model, better))
    assert other == pytest.approx(one, rel=1e-9)
    assert "assumed: zero" in better.parts["memory"].source


@pytest.mark.slow
def test_a_finding_of_the_diagnosis_enters_as_it_is():
    """Memory of the tank: the fitted part of Yv, in the hull of a model that does not have it."""
    found = diagnose_captive(hidden_campaign("full", {"memory": 1.0}, seed=11), "cubic")
    (finding,) = found.findings
    better = pk.with_effect(load_model("s175-3dof"), finding)
    part = better.parts["memory"]
    assert {name: part.values[name] for name in finding.coefficients} == finding.coefficients
    assert part.values["lag"] == finding.value
    assert part.source == "diagnosis (memory)"
    track = pk.simulate(better, "zigzag", rudder_deg=20, speed=9.0, compiled=False)
    plain = pk.simulate(load_model("s175-3dof"), "zigzag", rudder_deg=20, speed=9.0, compiled=False)
    assert track.metrics["overshoot_1_deg"] != pytest.approx(plain.metrics["overshoot_1_deg"])


def test_several_effects_enter_at_once():
    better = pk.with_effect(load_model("s175-3dof"), ("asymmetry", "memory"))
    assert better.values("hull_polynomial")["Y0"] == 0.0
    assert "memory" in better.parts
    with pytest.raises(ModelError, match="named none"):
        pk.with_effect(better, ())
    with pytest.raises(ModelError, match="one effect at a time"):
        pk.with_effect(better, ("asymmetry", "memory"), coefficients={"Y0": 1e-4})


def test_terms_of_the_rudder_go_where_the_rudder_is():
    assert (
        "Yvdd"
        in pk.with_effect(bare("mariner"), "rudder_cross_terms").parts["rudder_abkowitz"].values
    )
    assert (
        "Yvdd"
        in pk.with_effect(bare("kvlcc2"), "rudder_cross_terms").parts["hull_polynomial"].values
    )


def test_what_is_there_already_keeps_its_value():
    model = load_model("mariner")
    better = pk.with_effect(model, "yaw_sway_coupling", coefficients="typical")
    for name in ("Yvvr", "Nvvr"):
        assert better.values("hull_polynomial")[name] == model.values("hull_polynomial")[name]
    assert better.values("hull_polynomial")["Yvrr"] == -0.0405
    assert "Yvvr" in better.history[-1]


def test_a_pooled_model_gets_a_value_per_froude_number_and_keeps_its_covariance():
    model = bare("s175-3dof")
    names = ("Yv", "Nv")
    C = np.array([[1e-8, 2e-9], [2e-9, 4e-9]])
    model = model.with_(covariance=C, covariance_names=names)
    better = pk.with_effect(
        model, "froude_linear", coefficients={"Yv F": -0.001}, Fn=(0.3, 0.1, 0.2)
    )
    assert better.Fn == (0.1, 0.2, 0.3)
    F = np.array([-0.75, 0.0, 1.25])
    assert better.parts["hull_polynomial"].values["Yv"] == pytest.approx(-0.0116 - 0.001 * F)
    assert better.covariance.shape == (6, 6)
    weights = np.kron(better.weights(0.13), np.eye(2))
    np.testing.assert_allclose(weights @ better.covariance @ weights.T, C)
    with pytest.raises(ModelError, match="change with the Froude number already"):
        pk.with_effect(
            better.with_values(
                "hull_polynomial", **dict.fromkeys(("Nv", "Yr", "Nr"), (1.0, 2.0, 3.0))
            ),
            "froude_linear",
        )


def test_a_derivative_taken_out_leaves_the_covariance():
    model = load_model("s175-3dof").with_(
        covariance=np.diag([1.0, 2.0, 3.0]), covariance_names=("Yv", "Nvvr", "Yr")
    )
    plain = pk.without_effect(model, "yaw_sway_coupling")
    assert plain.covariance_names == ("Yv", "Yr")
    np.testing.assert_array_equal(plain.covariance, np.diag([1.0, 3.0]))


@pytest.mark.parametrize("fault", FAULTS, ids=lambda item: item.name)
def test_a_fault_never_enters_a_model(fault, tmp_path):
    model = load_model("s175-3dof")
    with pytest.raises(ModelError, match="it corrects the data, it does not enter"):
        pk.with_effect(model, fault.name)
    pk.save_model(model, tmp_path / "faulty.toml")
    with (tmp_path / "faulty.toml").open("a") as file:
        file.write(f"\n[effects.{fault.name}.values]\n")
    with pytest.raises(ModelError, match="fault of a measurement"):
        load_model(tmp_path / "faulty.toml")


def test_what_cannot_be_added_is_refused_with_the_reason():
    model = load_model("s175-3dof")
    with pytest.raises(ModelError, match="Yvvr, Yvrr, Nvvr, Nvrr of yaw_sway_coupling already"):
        pk.with_effect(model, "yaw_sway_coupling")
    slow = pk.with_effect(model, "memory")
    with pytest.raises(ModelError, match="has the effect memory already"):
        pk.with_effect(slow, "memory")
    with pytest.raises(ModelError, match="needs roll"):
        pk.with_effect(model, "heel_coupling")
    with pytest.raises(ModelError, match="Fn = "):
        pk.with_effect(model, "resistance_curve")
    with pytest.raises(ModelError, match="two Froude numbers"):
        pk.with_effect(model, "froude_linear", Fn=(0.2, 0.2))
    with pytest.raises(ModelError, match="particulars of its own"):
        pk.with_effect(model, "waterjet")
    with pytest.raises(UnknownNameError, match="hull_polynomial"):
        pk.with_effect(model, "memmory")
    with pytest.raises(
        UnknownNameError,
        match=r"no coefficient Yv_lat; did you mean 'Yv_late'\? It has Yv_late, Nv_late",
    ):
        pk.with_effect(model, "memory", coefficients={"Yv_lat": 1.0})
    with pytest.raises(ModelError, match="nothing of asymmetry"):
        pk.without_effect(model, "asymmetry")
    with pytest.raises(ModelError, match="no part 'memory'"):
        pk.without_effect(model, "memory")
    with pytest.raises(TableError, match="another fit"):
        pk.with_effect(
            model.with_(convention=Convention(U="carriage")), "asymmetry", coefficients="typical"
        )
    hull = {name: part for name, part in model.parts.items() if name != "hull_polynomial"}
    with pytest.raises(MissingPartError, match="hull_polynomial"):
        pk.with_effect(model.with_(parts=hull), "asymmetry")
    with pytest.raises(ModelError, match="give Yv\\|v\\|, Nv\\|v\\| to the polynomial of the hull"):
        model.with_(
            parts={
                **model.parts,
                "modulus_sway_drag": replace(
                    model.parts["hull_polynomial"], effect="modulus_sway_drag"
                ),
            }
        )
