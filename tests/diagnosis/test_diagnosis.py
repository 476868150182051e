"""Effects hidden in a virtual tank that shares no formula with the diagnosis."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hidden_effects import BASE, hidden_campaign

from pmmkit.base import DataError
from pmmkit.conventions import STRUCTURES
from pmmkit.diagnosis import diagnose
from pmmkit.diagnosis.captive.diagnose import captive_system, diagnose_captive
from pmmkit.effects import CATALOGUE
from pmmkit.models import load_model, odds

HERE = Path(__file__).parent


def diagnosed(effects, seed=11, programme="full", **settings):
    return diagnose_captive(hidden_campaign(programme, effects, seed=seed, **settings), BASE)


def effects_of(found):
    return [names for names, _ in found.group]


# The rule of evidence


def test_odds_are_words_and_end_at_a_thousand():
    assert odds(math.log(20.0)) == "about 20 to 1"
    assert odds(300.0) == "over 1000 to 1"


# Nothing hidden


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("noise", ["standard", "hard"])
def test_a_campaign_without_an_effect_is_noise(seed, noise):
    found = diagnosed({}, seed=seed, noise=noise)
    assert found.verdict == "noise"
    assert found.group == ()
    assert found.findings == ()


@pytest.mark.slow
@pytest.mark.parametrize("effect", ["fault_gauge_gain", "fault_moment_point"])
def test_what_the_base_absorbs_is_noise_and_listed_as_not_testable(effect):
    found = diagnosed({effect: 1.0})
    assert found.verdict == "noise"
    listed = {item.name: item for item in found.not_testable}
    assert "absorbs" in listed[effect].why
    assert listed[effect].hides > 10.0


# One effect hidden


@pytest.mark.slow
@pytest.mark.parametrize(
    "effect",
    [
        "modulus_sway_drag",
        "crossflow_drag",
        "yaw_sway_coupling",
        "memory",
        "lagged_crossflow",
        "nonlinear_added_mass",
        "heel_coupling",
        "asymmetry",
        "froude_linear",
        "resistance_curve",
        "rudder_stall",
        "surge_yaw_coupling",
        "fault_misalignment",
        "current",
        "fault_gauge_zero",
        "fault_cross_talk",
        "fault_pmm_amplitude",
        "fault_transient",
    ],
)
def test_a_hidden_effect_is_named(effect):
    found = diagnosed({effect: 1.0})
    assert found.verdict == "missing_effect"
    assert effects_of(found) == [(effect,)]
    (finding,) = found.findings
    assert finding.effect == effect
    assert found.chance < 0.01
    # What is larger than usual shows even where its usual size would not.
    blind = replace(found, covered=tuple(replace(x, shown=False) for x in found.covered))
    assert effect not in {item.name for item in blind.not_testable}
    assert len(blind.not_testable) == len(found.covered) - 1


@pytest.mark.slow
def test_a_clock_that_is_late_cannot_be_told_from_a_filter():
    """A filter is a lag and a little attenuation: a lag may be either, both are named."""
    found = diagnosed({"fault_time_lag": 1.0})
    assert set(effects_of(found)) == {("fault_time_lag",), ("fault_filter_lag",)}
    assert "knock" in found.findings[0].separating_test


@pytest.mark.slow
def test_a_filter_is_found_with_its_corner():
    """2.07 Hz, between the points of the grid."""
    found = diagnosed({"fault_filter_lag": 1.0})
    assert effects_of(found)[0] == ("fault_filter_lag",)
    assert found.findings[0].parameter == "corner [Hz]"
    assert found.findings[0].value == pytest.approx(2.07, rel=0.1)


@pytest.mark.slow
def test_the_size_of_a_fault_is_found_with_its_uncertainty():
    """0.26° of misalignment; 3 % of PMM amplitude; 2.4 N and -3.5 N m of zero error."""
    for effect, expected in (
        ("fault_misalignment", [0.26]),
        ("fault_pmm_amplitude", [0.03]),
        ("fault_gauge_zero", [2.4, -3.5]),
    ):
        (finding,) = diagnosed({effect: 1.0}).findings
        values, std = (np.array(list(x.values())) for x in (finding.coefficients, finding.std))
        np.testing.assert_array_less(np.abs(np.abs(values) - np.abs(expected)), 4.0 * std)


@pytest.mark.slow
def test_two_effects_are_named_together():
    found = diagnosed({"yaw_sway_coupling": 1.0, "fault_gauge_zero": 1.0})
    assert effects_of(found)[0] == ("fault_gauge_zero", "yaw_sway_coupling")


@pytest.mark.slow
def test_the_same_data_give_the_same_answer():
    one, two = (diagnosed({"memory": 1.0}) for _ in range(2))
    assert one.entries == two.entries
    assert one.findings == two.findings


@pytest.mark.slow
def test_the_order_of_equals_does_not_hang_on_the_process():
    """Sets of one evidence, as of two faults that the base absorbs, stand in one order."""
    code = (
        f"import sys; sys.path[:0] = [{str(HERE)!r}, {str(HERE.parent / 'support')!r}]\n"
        "from test_diagnosis import diagnosed\n"
        "print([item.names for item in diagnosed({}, programme='small').entries])"
    )
    said = {
        subprocess.run(
            [sys.executable, "-c", code],
            capture_output=True,
            text=True,
            check=True,
            env={**os.environ, "PYTHONHASHSEED": seed},
        ).stdout
        for seed in ("1", "2", "3")
    }
    assert len(said) == 1


# What the runs can show


@pytest.mark.slow
def test_one_speed_cannot_show_what_changes_with_speed():
    found = diagnosed({}, programme="small")
    hidden = {item.name for item in found.not_testable}
    assert {"froude_linear", "froude_nonlinear", "resistance_curve"} <= hidden


@pytest.mark.slow
@pytest.mark.slow
@pytest.mark.parametrize("programme", ["small", "full"])
def test_each_entry_of_the_catalogue_is_asked_in_the_base_or_told_why_not(programme):
    found = diagnosed({}, programme=programme)
    told = {x["effect"] for x in found.to_dict()["not_testable"] if x["why"]}
    asked = {item.name for item in found.covered if item.shown}
    assert not told & asked
    rest = [CATALOGUE[name] for name in CATALOGUE.keys() - told - asked]
    assert {item.name for item in rest} == {
        "cubic_hull_terms",
        "surge_quadratic",
        "acceleration_cross_terms",
    }
    assert all(set(item.typical) <= set(BASE) for item in rest)


def test_coverage_grows_with_the_programme():
    small, full = (
        {item.name: item.signal for item in diagnosed({}, programme=name).covered}
        for name in ("small", "full")
    )
    for name in ("crossflow_drag", "yaw_sway_coupling", "memory", "fault_misalignment"):
        assert full[name] > small[name]


@pytest.mark.slow
def test_something_outside_the_catalogue_is_not_given_a_bare_name():
    for effect in ("outside_acceleration_drag", "outside_hysteresis", "outside_dead_zone"):
        found = diagnosed({effect: 1.0})
        assert found.verdict == "unexplained" or "not_the_whole_story" in found.flags, effect


@pytest.mark.slow
def test_a_model_a_structure_and_a_list_are_the_same_base():
    campaign = hidden_campaign("small", {"yaw_sway_coupling": 1.0}, seed=4)
    answers = [diagnose(base, campaign) for base in ("cubic", STRUCTURES["cubic"].derivatives)]
    made = load_model("s175-3dof")
    hull = {
        name: x
        for name, x in made.parts["hull_polynomial"].values.items()
        if name not in ("Yvvr", "Yvrr", "Nvvr", "Nvrr")
    }
    part = replace(made.parts["hull_polynomial"], values=hull)
    answers.append(diagnose(made.with_(parts={**made.parts, "hull_polynomial": part}), campaign))
    for found in answers:
        assert effects_of(found)[0] == ("yaw_sway_coupling",)


def test_free_running_campaigns_are_refused_for_now():
    campaign = hidden_campaign("small").with_(kind="free-running")
    with pytest.raises(DataError, match="captive"):
        diagnose_captive(campaign)


# Forces without noise


@pytest.mark.slow
def test_forces_without_noise_are_refused_until_their_uncertainty_is_stated():
    """CFD: every difference would be evidence."""
    computed = hidden_campaign("middle", {}, seed=1, noise="none")
    with pytest.raises(DataError, match="no noise of their own"):
        diagnose_captive(computed, BASE)
    with pytest.raises(DataError, match="U_SN"):
        diagnose_captive(replace(hidden_campaign("middle", {}), cfd={"rho_inf": 1000.0}), BASE)


@pytest.mark.slow
def test_the_numerical_uncertainty_is_the_floor():
    """1 % of the rms forces in newtons at the middle speed, as a grid study would state it."""
    computed = hidden_campaign("middle", {"memory": 1.0}, seed=1, noise="none")
    plain = diagnose_captive(computed, BASE, floor=0.01)
    scale = {c.name: c.scale * 1.5**2 for c in captive_system(computed, BASE, floor=0.01).channels}
    stated = replace(computed, numerical={name: 0.01 * size for name, size in scale.items()})
    found = diagnose_captive(stated, BASE)
    assert found.floor == pytest.approx(0.01)
    assert found.verdict == plain.verdict
    assert found.best == plain.best


@pytest.mark.slow
def test_a_clean_computation_of_the_base_names_nothing():
    found = diagnose_captive(hidden_campaign("full", {}, noise="none"), BASE, floor=0.005)
    assert found.best == ()
