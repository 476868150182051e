"""Records of a ship whose sway force comes late: her windows, and what is said of her."""

from __future__ import annotations

import math

import numpy as np
import pytest

import pmmkit as pk
from pmmkit.diagnosis.free_running.base import stated_base
from pmmkit.diagnosis.free_running.diagnose import diagnose_free
from pmmkit.diagnosis.free_running.fits import place_at
from pmmkit.diagnosis.free_running.hypotheses import candidates_for
from pmmkit.diagnosis.free_running.information import Forces
from pmmkit.diagnosis.free_running.question import question_of
from pmmkit.identification import Prior
from tests.support.free_tank.campaigns import Setup, write
from tests.support.zigzags import KNOWN, SENSORS, SHIP, SPEED, sailed

LAG = 1.5
LATE = {"Yv_late": -0.006, "Nv_late": -0.002}
LATE_SHIP = pk.with_effect(SHIP, "memory", coefficients=LATE, value=LAG)


def question_about(model, records):
    base = stated_base(Prior.of(SHIP, KNOWN, SPEED, spread=0.02))
    return question_of(
        model,
        records,
        (),
        base,
        floor=0.001,
        window=None,
        sensors=SENSORS,
        extrapolate=False,
        tell=lambda _: None,
    )


def left_of(question):
    """Squares over the noise that starts leave of an average, the true model given."""
    place = place_at(question, np.zeros(len(KNOWN)))
    rows = sum(len(x.errors) - x.starts.shape[1] for own in place.sheets for x in own)
    calm = Forces(shares=np.full(3, 1e-9), memory=1.0)
    return place.information.under(calm).normal.square / rows, rows


def test_what_the_flow_remembers_goes_on_from_window_to_window():
    """The true model leaves the noise of the sensors; with a flow that settles anew at the start of
    each window, which nobody measures, it would not."""
    records = sailed(LATE_SHIP, 3)
    question = question_about(LATE_SHIP, records)
    left, rows = left_of(question)
    assert left == pytest.approx(1.0, abs=4.0 * math.sqrt(2.0 / rows))
    one = question.stretches[0]
    late = one.states.index("late_sway")
    assert one.own == late == len(one.states) - 1
    assert question_about(SHIP, records).stretches[0].own == len(one.states) - 1
    assert one.starts[0, late] == pytest.approx(0.0, abs=0.05 * SPEED**2)


@pytest.mark.slow
def test_how_long_a_flow_remembers_is_told_with_how_much():
    records = sailed(LATE_SHIP, 3)
    few = ("memory", "acceleration_cross_terms", "rudder_hull_interaction", "modulus_sway_drag")
    found = diagnose_free(
        SHIP,
        records,
        prior=Prior.of(SHIP, KNOWN, SPEED, spread=0.02),
        candidates=[item for item in candidates_for(SHIP, records) if item.name in few],
        sensors=SENSORS,
        most=2,
    )
    assert found.group[0] == (("memory",), 1.0)
    (finding,) = found.findings
    assert finding.parameter == "lag"
    assert finding.value == pytest.approx(LAG, rel=0.15)
    for name, true in LATE.items():
        assert abs(finding.coefficients[name] - true) < 3.5 * finding.std[name]
    assert found.model.parts["memory"].values["lag"] == pytest.approx(finding.value)


@pytest.mark.slow
def test_a_flow_of_another_program_that_remembers_is_named(tmp_path):
    """It keeps v over the speed where the catalogue keeps v times the speed, which a drag in sway
    may make up for while she slows down; the lag is 1.5 L/U."""
    campaign = pk.open_campaign(write(Setup(case="memory", runs=3, seed=0), tmp_path))
    found = pk.diagnose(pk.load_model("s175"), campaign)
    assert all("memory" in names for names, _ in found.group)
    assert set(found.best) <= {"memory", "modulus_sway_drag"}
    (memory,) = (item for item in found.findings if item.effect == "memory")
    assert memory.value == pytest.approx(1.5, rel=0.15)
    assert memory.coefficients["Yv_late"] == pytest.approx(-0.00232, rel=0.15)
