"""What the documentation says of effects is generated: known ratios of harmonics, known twins."""

from __future__ import annotations

import pytest

from pmmkit.diagnosis.captive.refit import captive_candidates
from scripts.documentation.signatures import signatures


@pytest.fixture(scope="module")
def found():
    asked = [item for item in captive_candidates() if not item.each_run]
    return {item.name: item for item in signatures(asked)}


@pytest.mark.slow
def test_harmonics_have_their_ratios(found):
    """v|v|: C3/C1 = 0.2; v²v̇: S3 = S1; vvr, vrr: the mean is the second harmonic of v r²."""
    sway = found["modulus_sway_drag"].acts["pure_sway"]["Y"]
    assert sway["C3"] / sway["C1"] == pytest.approx(0.2, abs=0.01)
    added = found["nonlinear_added_mass"].acts["pure_sway"]["Y"]
    assert added["S3"] / added["S1"] == pytest.approx(1.0, abs=0.1)
    both = found["yaw_sway_coupling"].acts["yaw_drift"]["Y"]
    assert both["C2"] / both["C0"] == pytest.approx(1.0, abs=0.1)
    late = found["memory"].acts["pure_sway"]["Y"]
    assert late["C1"] * late["S1"] < 0


@pytest.mark.slow
def test_effects_act_where_their_variables_do(found):
    tests = {name: set(item.acts) for name, item in found.items()}
    assert tests["memory"] == {"pure_sway"}
    assert tests["surge_yaw_coupling"] == {"yaw_drift"}
    assert tests["rudder_stall"] == {"static_rudder", "drift_rudder"}
    assert tests["heel_coupling"] == {"static_heel"}
    assert tests["fault_pmm_phase"] == {"pure_yaw", "yaw_drift"}
    assert set(found["resistance_curve"].acts["static_drift"]) == {"X"}


@pytest.mark.slow
def test_twins_and_what_the_hull_takes_over(found):
    for name in ("fault_gauge_gain", "fault_moment_point", "fault_inertia"):
        assert found[name].absorbed
    assert not found["fault_misalignment"].absorbed
    assert "current" in found["fault_misalignment"].mimics
    assert "yaw_sway_coupling" in found["crossflow_drag"].mimics
    assert found["fault_time_lag"].mimics["fault_filter_lag"] > 0.99
