"""What a fit says comes into the model: values, how uncertain they are, where they come from."""

from __future__ import annotations

import numpy as np
import pytest
from hidden_effects import hidden_campaign

import pmmkit as pk
from pmmkit.diagnosis.captive.least_squares import joint_fit
from pmmkit.diagnosis.captive.verdict import about
from pmmkit.diagnosis.refit import put_back, stepped
from pmmkit.models import Step
from tests.support.uncoupled import uncoupled

HULL = "hull_polynomial"


def fitted(**changes):
    places = ((HULL, "Yv"), ("rudder_mmg", "aH"))
    given = {
        "values": dict(zip(places, (-0.3, 0.4), strict=True)),
        "known": places,
        "covariance": np.array([[4e-4, 1e-4], [1e-4, 9e-4]]),
        "sources": dict.fromkeys(places, "measured: tank"),
    }
    return given | changes


def test_values_come_with_their_covariance_and_source_and_leave_the_rest():
    ship = pk.load_model("kvlcc2")
    made = put_back(ship, **fitted())
    assert made.values(HULL)["Yv"] == -0.3
    assert made.values("rudder_mmg")["aH"] == 0.4
    assert made.std == {"Yv": (0.02,), "rudder_mmg.aH": (0.03,)}
    assert made.covariance[0, 1] == 1e-4
    assert made.parts[HULL].source_of("Yv") == "measured: tank"
    assert made.parts[HULL].source_of("Nv") == ship.parts[HULL].source_of("Nv")
    left = {x: value for x, value in ship.values(HULL).items() if x != "Yv"}
    assert {x: value for x, value in made.values(HULL).items() if x != "Yv"} == left


def test_what_is_alike_at_all_speeds_is_known_at_each():
    ship = pk.load_model("kvlcc2")
    values = {(HULL, "Yv"): (-0.3, -0.31), ("rudder_mmg", "aH"): 0.4}
    made = put_back(ship, **fitted(values=values, Fn=(0.1, 0.2)))
    assert made.Fn == (0.1, 0.2)
    assert made.std["Yv"] == (0.02, 0.02)
    np.testing.assert_array_equal(made.covariance[:2, 2:], made.covariance[:2, :2])


def test_a_fit_that_knows_nothing_leaves_no_covariance():
    one = put_back(pk.load_model("kvlcc2"), **fitted())
    none = fitted(values={}, known=(), covariance=np.zeros((0, 0)), sources={})
    assert put_back(one, **none).covariance is None


def test_each_step_brings_its_own_places_and_a_fault_none():
    ship = pk.load_model("kvlcc2")
    made = put_back(ship, **fitted())
    steps = [
        Step(action="effect_added", effect="asymmetry", log_odds=3.0, note="seen"),
        Step(action="effect_added", effect="wake"),
        Step(action="fault_corrected", effect="current"),
    ]
    found = [
        ({"Yv": -0.3, "lost": float("nan")}, (f"{HULL}.Yv",)),
        ({"aH": 0.4}, (f"{HULL}.Yv", "rudder_mmg.aH")),
        ({"current_x": 0.2}, ()),
    ]
    plain = Step(action="fitted", campaign="sea", count=5, faults=("current",))
    told = stepped(ship, made, plain, steps, found, (3.0, 2.0, 2.0, float("nan")), "heading")
    one, two, three = told.steps[-3:]
    assert (one.log_odds, one.note, one.count, one.campaign) == (3.0, "seen", 5, "sea")
    assert one.coefficients == {"Yv": -0.3}
    assert one.before.values == {f"{HULL}.Yv": ship.values(HULL)["Yv"]}
    assert list(two.before.values) == ["rudder_mmg.aH"], "what came before is not its own"
    assert three.before is None
    assert (three.error_before, three.error_after) == (2.0, None)
    assert str(one) == (
        "Added asymmetry (seen): error of heading 3° to 2° where records of sea are left out."
    )
    assert str(three) == (
        "Added current, current_x = 0.2: error of heading 2° to unknown where records of sea are "
        "left out."
    )
    assert stepped(ship, made, plain, (), (), ()).history[-1] == (
        "Fitted 5 coefficients to sea, current corrected."
    )


def test_an_effect_that_is_a_part_is_as_uncertain_as_its_fit_says():
    """CD of the cross flow: its variance, and its covariance with the hull's cubic terms, which
    share the force out with it; a ship drawn from the model draws both."""
    session = pk.begin(uncoupled(), hidden_campaign("small", {"crossflow_drag": 1.0}, seed=1))
    session = session.add("crossflow_drag")
    tests = session.evidence
    fit = joint_fit(*about(tests.system, ("crossflow_drag",)), floor=tests.floor)
    made = session.model()
    names = made.covariance_names
    own = ["crossflow_drag: CD", "Yvvv", "Nvvv", "Nv"]
    at = [fit.names.index(name) for name in own]
    there = [names.index(x) for x in ("crossflow_drag.CD", "Yvvv", "Nvvv", "Nv")]
    C = made.covariance[np.ix_(there, there)]
    np.testing.assert_allclose(C, fit.covariance[np.ix_(at, at)], rtol=1e-6, atol=1e-14)
    assert abs(C[0, 1]) > 0.3 * np.sqrt(C[0, 0] * C[1, 1])
    scale = np.sqrt(np.diagonal(made.covariance))
    assert np.linalg.eigvalsh(made.covariance / np.outer(scale, scale))[0] > -1e-9
    part = made.parts["crossflow_drag"]
    assert part.source_of("CD") == f"measured: {tests.campaign.title}"


@pytest.mark.slow
def test_parts_and_derivatives_over_speeds_are_known_together():
    """With derivatives that change with the speed the covariance holds at each of them."""
    hidden = {"froude_linear": 1.0, "memory": 1.0}
    session = pk.begin(uncoupled(), hidden_campaign("full", hidden, seed=2))
    made = session.add("froude_linear").add("memory").model()
    rows = len(made.Fn)
    assert rows > 1
    std = made.std["memory.Yv_late"]
    assert std == pytest.approx([std[0]] * rows, rel=1e-12)
    scale = np.sqrt(np.diagonal(made.covariance))
    assert np.linalg.eigvalsh(made.covariance / np.outer(scale, scale))[0] > -1e-9
