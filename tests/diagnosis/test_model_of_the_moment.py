"""A fault of the motion changes the force of the whole ship: of what is missing of the base too."""

from __future__ import annotations

import pytest
from hidden_effects import BASE, SIZES, hidden_campaign
from hidden_effects.catalogue import RIG_EFFECTS

import pmmkit as pk
from pmmkit.diagnosis.captive.diagnose import diagnose_captive
from pmmkit.effects import CATALOGUE
from tests.support.uncoupled import uncoupled

COUPLING = "yaw_sway_coupling"


def tank(fault, seed=901):
    """A rig that errs, and a ship with a coupling that the base has not: both at full size."""
    return hidden_campaign("full", {fault: 1.0, COUPLING: 1.0}, seed=seed)


@pytest.mark.slow
@pytest.mark.parametrize("fault", RIG_EFFECTS)
def test_a_ship_written_in_two_ways_gets_one_answer(fault):
    """As cubic terms with a coupling that is given, and as a structure that contains it."""
    campaign = tank(fault)
    given = diagnose_captive(campaign, BASE, given=[COUPLING])
    inside = diagnose_captive(campaign, (*BASE, *CATALOGUE[COUPLING].sizes({})))
    assert given.verdict == inside.verdict
    assert [names for names, _ in given.group] == [names for names, _ in inside.group]
    assert given.flags == inside.flags
    for one, other in zip(given.findings, inside.findings, strict=True):
        assert one.coefficients == pytest.approx(other.coefficients, rel=0.03)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [901, 902, 903])
@pytest.mark.parametrize("fault", ["fault_misalignment", "current"])
def test_a_fault_beside_a_missing_coupling_is_named_without_doubt(fault, seed):
    """The force that a turned model misses is that of the coupling too: a column of the base alone
    leaves second harmonics behind, which asked for even terms."""
    found = diagnose_captive(tank(fault, seed), BASE)
    assert [set(names) for names, _ in found.group] == [{fault, COUPLING}]
    assert not found.flags


@pytest.mark.slow
def test_a_fault_alone_does_not_borrow_the_force_of_the_effect_that_is_found():
    """A gain, or a moment about another point, is taken over by the base: alone it explains nothing
    of what a coupling leaves, though it would act on the force of the coupling too."""
    found = diagnose_captive(hidden_campaign("full", {COUPLING: 1.0}, seed=904), BASE)
    assert [names for names, _ in found.group] == [(COUPLING,)]
    alone = {item.names[0]: item.log_evidence for item in found.entries if len(item.names) == 1}
    assert alone["fault_gauge_gain"] < 0.0
    assert alone["fault_moment_point"] < 0.0


@pytest.mark.slow
def test_the_model_that_is_written_knows_how_far_the_model_was_turned():
    campaign = tank("fault_misalignment")
    session = pk.begin(uncoupled(), campaign).add(COUPLING).add("fault_misalignment")
    (step,) = [x for x in session.model().steps if x.effect == "fault_misalignment"]
    assert step.coefficients["turned"] == pytest.approx(
        SIZES["fault_misalignment"]["deg"], rel=0.05
    )
