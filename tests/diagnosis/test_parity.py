"""Port and starboard: what is odd stays odd, and so does its error of form."""

from __future__ import annotations

import numpy as np
import pytest
from hidden_effects import hidden_campaign
from test_diagnosis import BASE, diagnosed

from pmmkit.diagnosis import candidate_of
from pmmkit.diagnosis.captive.adequacy import floor_places, mirrored, parities
from pmmkit.diagnosis.captive.diagnose import captive_system
from pmmkit.diagnosis.captive.system import FEATURES, floor_features
from pmmkit.effects import CATALOGUE


@pytest.fixture(scope="module")
def system():
    return captive_system(hidden_campaign("middle", {}, seed=3, sided="both"), BASE)


@pytest.mark.parametrize(
    ("effect", "symmetric"),
    [
        ("yaw_sway_coupling", True),
        ("crossflow_drag", True),
        ("froude_linear", True),
        ("resistance_curve", True),
        ("heel_coupling", True),
        ("memory", True),
        ("fault_time_lag", True),
        ("asymmetry", False),
        ("even_hull_terms", False),
        ("fault_misalignment", False),
        ("fault_gauge_zero", False),
        ("fault_cross_talk", False),
    ],
)
def test_an_effect_has_the_symmetry_of_its_formula(system, effect, symmetric):
    block = next(b for b in system.blocks if b.candidate.name == effect)
    assert parities(system, block) == {symmetric}


def test_the_smooth_floor_is_two_functions_of_opposite_symmetry(system):
    """In the mirror the first half of Y's features turns over, the second stays; X the reverse."""
    views = system.views
    for channel in system.channels:
        here = floor_features(channel, views, system.base)
        there = floor_features(channel, [mirrored(view) for view in views], system.base)
        sign = np.repeat([1.0, -1.0] if channel.name == "X" else [-1.0, 1.0], FEATURES // 2)
        np.testing.assert_allclose(there, sign * here, atol=1e-9 * np.abs(here).max())


def test_the_features_have_the_covariance_of_the_two_kernels():
    """½[k(x, x') ± k(x, P x')] of the Gaussian kernel, from many seeds."""
    runs = hidden_campaign("small", noise="none", roll_measured=False).select("static_drift")
    system = captive_system(runs, ("Yv", "Nv"), floor=0.01, noise=0.01)
    channel = next(c for c in system.channels if c.name == "Y")
    drift = np.array([view.motion.v[0] / view.motion.speed[0] for view in system.views])
    x = drift / np.abs(drift).max() / 0.8
    near, far = (np.exp(-0.5 * (x[:, None] + sign * x) ** 2) for sign in (-1.0, 1.0))
    unit = channel.scale * system.views[0].speed ** 2
    made = [floor_features(channel, system.views, system.base, seed) / unit for seed in range(400)]
    half = FEATURES // 2
    for own, sign in ((slice(0, half), -1.0), (slice(half, None), 1.0)):
        found = np.mean([f[:, own] @ f[:, own].T for f in made], axis=0)
        np.testing.assert_allclose(found, 0.5 * (near + sign * far), atol=0.02)


def test_floor_places_part_the_features_of_all_channels(system):
    own, other = (floor_places(system, frozenset((parity,))) for parity in (True, False))
    assert len(own) == len(other) == len(system.channels) * FEATURES // 2
    assert not set(own.tolist()) & set(other.tolist())


@pytest.mark.slow
def test_an_asymmetry_is_no_error_of_form_of_what_is_odd():
    """Asymmetry beside a small dependence on speed: the odd error of form of this is odd."""
    found = diagnosed({"asymmetry": 1.0, "froude_linear": 0.3}, seed=40)
    assert found.best == ("asymmetry", "froude_linear")
    assert found.flags == ()


def test_the_linear_terms_of_a_large_block_compete_alone():
    whole, part = candidate_of(CATALOGUE["heel_coupling"]).forms
    assert whole.size == 6
    assert part.coefficients == ("Yphi", "Nphi")
    assert (whole.partial, part.partial) == (False, True)
    assert candidate_of(CATALOGUE["yaw_sway_coupling"]).linear == ()
    assert candidate_of(CATALOGUE["even_hull_terms"]).linear == ()


@pytest.mark.slow
def test_two_terms_of_heel_are_named_where_six_are_not_needed():
    """Yphi and Nphi alone in the forces: two coefficients win, and what a base has stays whole."""
    campaign = hidden_campaign("small", {}, seed=8)
    q = 0.5 * campaign.water.rho * campaign.ship.L**2 * 1.5**2

    def heeled(run):
        data = run.data
        Y, N = (data[name] + q * x * data["phi"] for name, x in (("Y", -4e-4), ("N", -1.5e-3)))
        return run.with_(loader=lambda: data.assign(Y=Y, N=N))

    system = captive_system(campaign.with_(runs=tuple(map(heeled, campaign.runs))), BASE)
    forms = [b for b in system.blocks if b.candidate.name == "heel_coupling"]
    assert [b.candidate.size for b in forms] == [6, 2]
    assert [
        b.candidate.size
        for b in system.whole(["heel_coupling"]).blocks
        if b.candidate.name == "heel_coupling"
    ] == [6]
    six, two = (system.normal.only(b.places).log_evidence for b in forms)
    assert two > six
