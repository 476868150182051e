"""Effects fitted with the base, taken as given, and judged on conditions that were left out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hidden_effects import BASE, hidden_campaign

from pmmkit.base import UnknownNameError
from pmmkit.diagnosis.captive.build import build
from pmmkit.diagnosis.captive.diagnose import captive_system, diagnose_captive
from pmmkit.diagnosis.captive.evidence import best_blocks, condition_on
from pmmkit.diagnosis.captive.held_out import condition, held_out
from pmmkit.diagnosis.captive.least_squares import Stack, joint_fit, solved
from pmmkit.diagnosis.captive.verdict import answer, taken_as_given

HIDDEN = {"yaw_sway_coupling": 1.0, "fault_misalignment": 1.0}


@pytest.fixture(scope="module")
def system():
    return captive_system(hidden_campaign("middle", HIDDEN, seed=5, sided="both"), BASE)


def test_of_derivatives_that_cannot_be_told_apart_none_has_a_value():
    """One drift angle to either side: Yv and Yvvv are one, as `reduce` says of the same runs."""
    v = np.array([-0.1, -0.1, 0.1, 0.1])
    white = np.column_stack([v, v**3, np.ones(4), -2.0 * v + 0.3])
    stack = Stack(
        plain=white,
        white=white,
        places={"Y": slice(0, 4)},
        names=("Yv", "Yvvv", "Y0"),
        unit=np.ones(3),
        centre=np.zeros(0),
        begin=3,
    )
    found = solved(stack)
    assert found.determined.tolist() == [False, False, True]
    assert found.solution[2] == pytest.approx(0.3)


@pytest.mark.slow
def test_evidence_beside_a_known_effect_is_that_of_both_less_that_of_the_known(system):
    known, other = (best_blocks(system, name)[0] for name in ("fault_misalignment", "memory"))
    both = system.normal.only(np.concatenate([known.places, other.places])).log_evidence
    alone = system.normal.only(known.places).log_evidence
    beside = condition_on(system, [known]).normal.only(other.places)
    assert beside.log_evidence == pytest.approx(both - alone, rel=1e-8)


@pytest.mark.slow
def test_the_data_left_beside_a_known_effect_are_those_of_a_larger_covariance(system):
    """z'(I + S S')⁻¹z of the whitened data, from the products alone."""
    (known,) = best_blocks(system, "yaw_sway_coupling")
    own = known.places
    G, b = system.normal.information[np.ix_(own, own)], system.normal.score[own]
    expected = system.normal.square - b @ np.linalg.solve(G + np.eye(len(own)), b)
    assert condition_on(system, [known]).normal.square == pytest.approx(expected, rel=1e-12)


def test_a_condition_left_out_is_predicted_as_by_a_fit_without_its_runs(system):
    """One decomposition for all conditions, against a fit to a campaign that lacks the runs."""
    blocks = [best_blocks(system, name)[0] for name in HIDDEN]
    found = held_out(system, blocks)
    number = 4
    left = found.conditions[number]
    views = [view for view in system.views if condition(view.run) != left]
    rest = build(views, system.base, [block.candidate for block in blocks], scatter=system.scatter)
    # The fault acts on what the base of all runs expects.
    rest = replace(rest, base=system.base, views=tuple(views))
    own = [
        next(b for b in rest.blocks if b.candidate.name == x.candidate.name and b.value == x.value)
        for x in blocks
    ]
    own = [replace(block, made=None) for block in own]
    fit = joint_fit(rest, own, floor=0.0)
    values = dict(zip(fit.names, fit.values, strict=True))
    outside = [v for v in system.views if condition(v.run) == left and not v.early]
    for channel in ("Y", "N"):
        squares = []
        for view in outside:
            predicted = system.base.design(system.base.names[channel], [view]) @ [
                values[name] for name in system.base.names[channel]
            ]
            for block in own:
                (columns,) = block.candidate.columns([view], system.base, block.value)
                labels = [f"{block.candidate.name}: {x}" for x in block.candidate.coefficients]
                if channel in columns:
                    predicted = predicted + columns[channel] @ [values[x] for x in labels]
            error = view.force[channel] - predicted
            squares.append(error[0] ** 2 + 0.5 * np.sum(error[1:] ** 2))
        expected = np.sqrt(np.mean(squares))
        assert found.error[number, found.channels.index(channel)] == pytest.approx(
            expected, rel=0.01
        )


@pytest.mark.slow
def test_naming_what_was_hidden_brings_the_held_out_error_down_to_the_noise(system):
    blocks = [best_blocks(system, name)[0] for name in HIDDEN]
    before, half, after = (held_out(system, blocks[:n]) for n in range(3))
    assert after.share() < half.share() < before.share()
    quiet = held_out(captive_system(hidden_campaign("middle", {}, seed=5), BASE))
    assert after.share() == pytest.approx(quiet.share(), rel=0.15)
    assert after.better_than(before) > 0.6


def test_an_effect_that_is_not_there_does_not_lower_the_held_out_error(system):
    blocks = [best_blocks(system, name)[0] for name in HIDDEN]
    other = best_blocks(system, "modulus_yaw_drag")[0]
    assert held_out(system, [*blocks, other]).share() > 0.99 * held_out(system, blocks).share()


@pytest.mark.slow
def test_what_is_given_is_not_asked_again(system):
    first = answer(system, floor=0.005)
    assert set(first.best) == set(HIDDEN)
    second = answer(system, ["yaw_sway_coupling"], floor=0.005)
    assert second.best == ("fault_misalignment",)
    assert second.given == ("yaw_sway_coupling",)
    assert answer(system, list(HIDDEN), floor=0.005).verdict == "noise"


def test_an_effect_that_does_not_take_part_cannot_be_given(system):
    with pytest.raises(UnknownNameError, match="memory"):
        taken_as_given(system, ["ghost"])


@pytest.mark.slow
def test_findings_tell_the_error_without_and_with_each_effect():
    found = diagnose_captive(hidden_campaign("full", HIDDEN, seed=5), BASE)
    by_name = {item.effect: item for item in found.findings}
    assert set(by_name) == set(HIDDEN)
    coupling, turned = by_name["yaw_sway_coupling"], by_name["fault_misalignment"]
    assert coupling.channels == ("Y", "N")
    assert turned.channels == ("X", "Y", "N")
    assert coupling.error_after == turned.error_after < turned.error_before
    assert 0.5 < coupling.explained["N"] < 1.0


def test_the_fit_of_base_and_effect_finds_the_values_that_were_hidden(system):
    """Son and Nomoto's Nv; their vvr as hidden in the tank; within three standard deviations."""
    blocks = [best_blocks(system, name)[0] for name in HIDDEN]
    fit = joint_fit(system, blocks, floor=0.005)
    values, std = fit.of(["Nv", "yaw_sway_coupling: Nvvr", "fault_misalignment: turned [deg]"])
    np.testing.assert_array_less(np.abs(values - [-0.00385, -0.0424, 0.26]), 3.5 * std)
