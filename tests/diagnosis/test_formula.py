"""A formula after "unexplained": truths of the test's own code, which no catalogue holds."""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np
import pytest
from added_force import with_force
from hidden_effects import BASE, hidden_campaign

import pmmkit as pk
from pmmkit.conventions import parse_derivative
from pmmkit.diagnosis.captive.diagnose import captive_system, diagnose_captive
from pmmkit.diagnosis.captive.formula import MonomialSets, monomials
from pmmkit.diagnosis.captive.refit import DerivativePlaces
from pmmkit.diagnosis.captive.system import CandidateColumns, candidate_columns
from pmmkit.diagnosis.empirical import EmpiricalFormula, EmpiricalTerm, is_symmetric
from tests.support.uncoupled import uncoupled

TRUTHS = {
    "Yv|r|": (-0.012, lambda m: {"Y": -0.012 * m.vp * abs(m.rp)}),
    "Yvvvrr": (-0.30, lambda m: {"Y": -0.30 * m.vp**3 * m.rp**2}),
    "Nv|v|r": (0.012, lambda m: {"N": 0.012 * m.vp * abs(m.vp) * m.rp}),
    "Y|v|vdot": (-0.004, lambda m: {"Y": -0.004 * abs(m.vp) * m.vd}),
    "N|r|rdot": (-4e-4, lambda m: {"N": -4e-4 * abs(m.rp) * m.rd}),
    "X|v|rr": (0.03, lambda m: {"X": 0.03 * abs(m.vp) * m.rp**2}),
}
"""Coefficients, and forces over ½ρL²U² (½ρL³U²) along the motion."""


def asked(truth, programme="full", seed=3):
    """The diagnosis of a campaign with a force of one's own."""
    tests = with_force(hidden_campaign(programme, seed=seed), programme, TRUTHS[truth][1])
    return diagnose_captive(tests, BASE)


def of_names(system, names):
    """Some monomials with their columns, coefficients of the size .01."""
    blocks = []
    for item in monomials(system, DerivativePlaces.of(BASE)):
        if item.name not in names:
            continue
        made = candidate_columns(item, 0.0, system.channels, system.views, system.base)
        whole = {name: 0.01 * own for name, own in made.items()}
        blocks.append(CandidateColumns(candidate=item, value=0.0, columns=slice(0, 1), made=whole))
    return tuple(blocks)


@pytest.mark.slow
@pytest.mark.parametrize("truth", TRUTHS)
def test_a_force_of_ones_own_is_found_with_its_sign_and_size(truth):
    """Alone, within three standard deviations; what is left is noise, and that is of the size which
    the tank has, whatever the force was taken for before (scatter of the gain of 15 % and more)."""
    found = asked(truth).formula
    (term,) = found.terms
    assert term.name == truth
    assert abs(term.value - TRUTHS[truth][0]) < 3.0 * term.std
    assert term.std < 0.12 * abs(term.value)
    assert term.share > 0.9
    assert found.error_after < found.error_level < 0.015
    assert found.error_after < 0.95 * found.error_before


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_what_the_runs_cannot_tell_from_it_is_said(seed):
    """Of 27 runs with one drift in yaw several products of sway and yaw fit: the truth is in the
    list, and the probabilities of the list are those of one term."""
    truth = lambda m: {"N": -0.02 * m.vp * abs(m.vp) * abs(m.rp)}  # noqa: E731
    tests = with_force(hidden_campaign("middle", seed=seed), "middle", truth)
    found = diagnose_captive(tests, BASE).formula
    (term,) = found.terms
    shares = {term.name: term.share, **term.like}
    assert len(shares) > 1
    assert "Nv|v||r|" in shares
    assert sum(shares.values()) == pytest.approx(1.0, abs=0.1)
    said = next(text for text in found.remarks() if text.startswith("These runs cannot tell"))
    assert all(name in said for name in shares)


@pytest.mark.slow
def test_two_forces_make_a_formula_of_two_terms():
    """A term in surge and one in sway, put in by the tank itself (v r³ and v |r|³)."""
    found = diagnose_captive(hidden_campaign("full", {"outside_vr3": 1.0}, seed=7000), BASE)
    assert found.verdict == "unexplained"
    values = {item.name: (item.value, item.std) for item in found.formula.terms}
    truth = {"Xvrrr": 0.012, "Yvrr|r|": -0.055}
    assert values.keys() == truth.keys()
    for name, (value, std) in values.items():
        assert abs(value - truth[name]) < 3.0 * std
    assert found.formula.error_after < found.formula.error_level
    errors = [item.error for item in found.formula.lengths]
    assert [len(item.terms) for item in found.formula.lengths] == [0, 1, 2]
    assert errors == sorted(errors, reverse=True)
    assert "numbers, no cause" in " ".join(found.remarks())


@pytest.mark.slow
def test_a_formula_takes_the_place_of_a_relative():
    """|v| r is no product of third order: the coupling that is named for it stays behind."""
    found = diagnose_captive(hidden_campaign("full", {"outside_even_vr": 1.0}, seed=7000), BASE)
    assert found.best == ("yaw_sway_coupling",)
    assert found.flags
    assert found.formula.instead == ("yaw_sway_coupling",)
    assert not found.formula.beside
    assert {item.name for item in found.formula.terms} == {"Y|v|r", "N|v|r"}


@pytest.mark.slow
def test_a_formula_stands_beside_names_that_are_needed():
    """Side force by Fn² v² on top of the sway: three entries hold most of it, N v³ F is left."""
    found = diagnose_captive(hidden_campaign("full", {"outside_sinkage": 1.0}, seed=7000), BASE)
    assert len(found.best) == 3
    assert found.formula.beside == found.best
    assert not found.formula.instead
    (term,) = found.formula.terms
    assert term.name == "Nvvv F"
    prime = 55 * 0.217**2 * -0.0039  # of the tank: 55 Fn² (v² + …) of Nv' v = -0.0039 v
    assert abs(term.value - prime) < 4.0 * term.std


def test_what_one_run_alone_asks_for_is_not_offered():
    """A force in one run of sway and yaw: odds for it there are, and none without that run."""
    only = "SY_1.5_0.15_0.35"

    def truth(m):
        return {"Y": -0.05 * m.vp * abs(m.rp) * (m.plan.id == only)}

    tests = with_force(hidden_campaign("small", seed=2), "small", truth)
    system = captive_system(tests, BASE)
    sets = MonomialSets.of(system, (), of_names(system, ["Yv|r|"]))
    assert sets.value[(0,)] > 10.0
    assert sets.best == ()


@pytest.mark.slow
@pytest.mark.parametrize("hidden", ["outside_hysteresis", "beyond_transported_drag"])
def test_what_is_no_function_of_the_motion_has_no_formula(hidden):
    found = diagnose_captive(hidden_campaign("full", {hidden: 1.0}, seed=7000), BASE)
    assert found.verdict == "unexplained"
    assert not found.formula.terms
    assert found.formula.error_after == found.formula.error_before
    assert "No formula" in " ".join(found.remarks())


@pytest.mark.slow
@pytest.mark.parametrize("seed", [31, 32, 33])
def test_a_clean_campaign_is_offered_nothing(seed):
    found = diagnose_captive(hidden_campaign("full", seed=seed), BASE)
    assert found.verdict == "noise"
    assert found.formula is None
    assert found.to_dict()["formula"] is None


@pytest.mark.slow
@pytest.mark.parametrize("truth", ["Yv|r|", "Y|v|vdot"])
def test_it_is_taken_in_one_step_and_known_to_the_next_diagnosis(truth, tmp_path):
    """A derivative of the hull, and added mass that changes with the motion as a part of its
    own."""
    tests = with_force(hidden_campaign("full", seed=3), "full", TRUTHS[truth][1])
    formula = pk.begin(uncoupled(), tests).diagnose().formula
    path = tmp_path / "empirical.toml"
    path.write_text(formula.text(), encoding="utf-8")
    effects = pk.own_effects(path)
    assert [item.name for item in effects] == [item.name for item in formula.effects]
    session = pk.begin(uncoupled(), tests, own=effects).add(effects[0].name)
    before, after = session.fall().totals
    assert after < 0.9 * before
    made = session.model()
    assert made.steps[-1].note == "empirical term, no physical cause is named"
    assert "no physical cause" in made.history[-1]
    pk.save_model(made, tmp_path / "model.toml")
    ship = pk.load_model(tmp_path / "model.toml")
    values = [item for part in ship.parts.values() for item in part.values.items()]
    (value,) = [x for name, x in values if name in (truth, "a")]
    assert value == pytest.approx(TRUTHS[truth][0], rel=0.1)
    turns = [
        pk.simulate(x, rudder_deg=35, speed=9.0).metrics["advance_L"] for x in (ship, uncoupled())
    ]
    assert all(map(math.isfinite, turns))
    again = pk.begin(ship, tests).diagnose()  # without the file of effects
    assert again.verdict == "noise"


def test_the_odds_of_a_set_are_those_of_a_normal_distribution():
    """ln N(y; 0, 1 + A A') - ln N(y; 0, 1) by the covariance written out, less a price for each
    term; posterior shares are sums over the sets."""
    tests = with_force(hidden_campaign("small", seed=2), "small", TRUTHS["Yv|r|"][1])
    system = captive_system(tests, BASE)
    blocks = of_names(system, ["Yv|r|", "Yvvr", "Nvvr", "Yvr"])
    sets = MonomialSets.of(system, (), blocks)

    def odds(places):
        total = 0.0
        for piece in system.pieces:
            channel = piece.projection.channel
            raw = [blocks[k].made[channel.name] for k in places if channel.name in blocks[k].made]
            every = np.concatenate([np.zeros((len(channel.y), 0)), *raw], axis=1)
            columns = piece.projection.left(every)
            covariance = np.eye(len(columns)) + columns @ columns.T
            y = piece.data
            total += 0.5 * (y @ y - y @ np.linalg.solve(covariance, y))
            total -= 0.5 * np.linalg.slogdet(covariance)[1]
        for k in places:
            name = blocks[k].candidate.name
            total -= math.log(len(blocks)) + (math.log(20.0) if name == "Yvr" else 0.0)
        return total

    every = [x for n in range(len(blocks) + 1) for x in combinations(range(len(blocks)), n)]
    expected = {places: odds(places) for places in every}
    assert set(sets.value) >= {places for places in every if len(places) < 2}
    for places, value in sets.value.items():
        assert value == pytest.approx(expected[places], abs=1e-6 * (1.0 + abs(value)))
    top = max(expected.values())
    weights = {places: math.exp(value - top) for places, value in expected.items()}
    for k in range(len(blocks)):
        share = sum(w for places, w in weights.items() if k in places) / sum(weights.values())
        assert sets.shares[k] == pytest.approx(share, abs=1e-5)


def term(name, **more):
    about = {"value": 2.0, "std": 0.5, "typical": 0.04, "share": 1.0, "like": {}, "Fn0": 0.2}
    return EmpiricalTerm(name=name, **{**about, **more})


@pytest.mark.parametrize(
    ("name", "product", "text"),
    [
        ("Yv|r|", "v'|r'|", "Y: v*|r|"),
        ("Nvvv|r|", "v'³|r'|", "N: v^3*|r|"),
        ("X0", "1", "X: 1"),
        ("Yvdd", "v'δ²", "Y: v*d^2"),
        ("Yvvv F", "v'³ F", "Y: a*Fn^2*v^3; a ~ 1"),
        ("N|v|rdot", "|v'|ṙ'", "Nrdot: a*|v|; a ~ 0.04"),
    ],
)
def test_a_term_is_an_effect_of_the_user(name, product, text):
    made = term(name)
    assert made.product == product
    assert made.effect.text == text
    assert made.effect.family == "empirical"
    assert made.effect.name.startswith("empirical_")


def test_no_product_is_asked_for_that_the_model_has_no_place_for():
    """Rudder beside a polynomial of the rudder, heel where she rolls."""
    system = captive_system(hidden_campaign("full", seed=2), BASE)

    def asked(source):
        return {x.name for x in monomials(system, DerivativePlaces.of(source))}

    plain, steered, rolls = asked("cubic"), asked("mariner"), asked([*BASE, "Yphi"])
    made = [parse_derivative(name.removesuffix(" F")) for name in plain]
    assert not any(item.count("d") or item.rolls for item in made)
    assert {"Yvdd", "Nvvd", "Yd F"} <= steered
    assert "Yv F" in plain
    assert "Yd F" not in plain
    assert {"Yvphiphi", "Nvvphi"} <= rolls - plain
    assert {"Yv|r|", "Nvvrrr", "Yvvvdot", "Y0"} <= plain & steered & rolls
    assert {"Yv", "Yvvvr", "Yvvvvvv"}.isdisjoint(plain)  # of the base; of no such ship; too high
    assert asked(pk.load_model("s175-3dof")) == plain


def test_terms_stand_beside_effects_that_the_user_has_already(tmp_path):
    mine = pk.own_effect("keel", "Y: v*|v|*r; Yv|v|r ~ -0.03", check="yaw with drift")
    formula = EmpiricalFormula(
        terms=(term("Yv|r|"), term("Xvv F")),
        beside=(),
        instead=(),
        asked=9,
        log_odds=9.0,
        error_before=0.03,
        error_after=0.01,
        error_level=0.012,
        lengths=(),
    )
    path = tmp_path / "effects.toml"
    path.write_text(formula.text([mine]), encoding="utf-8")
    keel, *terms = pk.own_effects(path)
    assert (keel.name, keel.check, keel.typical) == (mine.name, mine.check, mine.typical)
    assert [item.name for item in terms] == ["empirical_yv_absr", "empirical_xvv_speed"]
    assert formula.equations == ("X' = 2 v'² F", "Y' = 2 v'|r'|")


def test_a_symmetric_ship_has_odd_sway_and_even_surge():
    """Abkowitz (1964): Y, N and K change sign in a mirrored motion, X does not."""
    of_ship = [
        "Yv",
        "Yvvr",
        "Yv|r|",
        "Yvdd",
        "Nr|r|",
        "Xvv",
        "Xvr",
        "X|v|",
        "Yphi",
        "Kv",
        "Yvvvdot",
    ]
    of_none = ["Y0", "Yvv", "Yvr", "N|v||r|", "Xv", "Xr|v|", "Yvd", "Kphiphi", "Yvvdot"]
    assert all(is_symmetric(parse_derivative(name)) for name in of_ship)
    assert not any(is_symmetric(parse_derivative(name)) for name in of_none)


@pytest.mark.slow
def test_a_plan_is_made_for_a_model_that_holds_a_formula():
    """A term of added mass is a part of the model's own; what it does is known to the plan."""
    tests = with_force(hidden_campaign("full", seed=3), "full", TRUTHS["Y|v|vdot"][1])
    (term,) = diagnose_captive(tests, BASE).formula.terms
    effect = term.effect
    model = pk.begin(uncoupled(), tests, own=(effect,)).add(effect.name).model()
    advice = pk.next_runs(model, tests, effects=("memory", "fault_pmm_amplitude"))
    assert effect.name in model.parts
    assert advice.runs


@pytest.mark.slow
@pytest.mark.parametrize("seed", [9200, 9371])
def test_a_product_that_is_called_a_coupling_is_told_beside_the_name(seed):
    """|v| r, even in drift, where the catalogue has v²r and v r²: two terms do better than four."""
    found = diagnose_captive(hidden_campaign("full", {"outside_even_vr": 1.0}, seed=seed), BASE)
    assert found.best == ("yaw_sway_coupling",)
    assert any("Y|v|r and N|v|r fit better in the place of" in text for text in found.flags)
    assert {term.name for term in found.formula.terms} == {"Y|v|r", "N|v|r"}
    assert found.formula.instead == ("yaw_sway_coupling",)
