"""The whole chain: from files to turning circles, on the S175 programme and on HMRI's KVLCC2."""

from __future__ import annotations

import json

import numpy as np
import pytest
import reduced

import pmmkit as pk
from pmmkit.reduction import reduce_campaign
from scripts.datasets.s175_truth import load_truth
from scripts.validation.derivatives import TRENDS


@pytest.fixture(scope="module")
def s175(kept, datasets):
    return reduced.s175(kept, datasets)


@pytest.fixture(scope="module")
def hmri(kept, shared_data, datasets):
    return reduced.hmri_usual(kept, datasets, shared_data)


@pytest.mark.slow
def test_the_checks_are_silent_on_the_clean_programme(s175):
    assert s175.findings == ()
    assert not any("misfit" in note for note in s175.notes)


@pytest.mark.slow
def test_derivatives_lie_within_their_uncertainty_of_the_truth(s175):
    truth = load_truth()
    right = np.array([[truth.at(Fn)[name] for name in s175.table.names] for Fn in s175.table.Fn])
    error = (s175.table.value - right) / s175.table.std
    assert np.abs(error).max() < 4.0
    assert 0.6 < np.sqrt(np.mean(error**2)) < 1.4
    low, high = s175.table.interval()
    assert 0.91 < np.mean((low <= right) & (right <= high)) < 1.0


@pytest.mark.slow
def test_trends_of_the_turning_circle_are_found_back(s175):
    """From Fn .145 to .290 within 1.5 percentage points of the true model's, and of paper C's."""
    truth = load_truth()
    changes = []
    for table in (s175.table, truth.table(s175.table.Fn)):
        model = pk.to_model(table, parts="s175-3dof")
        slow, fast = (
            pk.simulate(model, "turning", rudder_deg=35, speed=speed).metrics
            for speed in (6.0, 12.0)
        )
        changes.append({name: fast[name] / slow[name] - 1 for name in TRENDS})
    for name, published in TRENDS.items():
        assert changes[0][name] == pytest.approx(changes[1][name], abs=0.015)
        assert changes[1][name] == pytest.approx(published, abs=5e-4)


@pytest.mark.slow
def test_a_saved_campaign_reduces_to_the_same_table(s175, tmp_path):
    some = s175.campaign.with_(runs=s175.campaign.runs[::3])
    pk.save_campaign(some, tmp_path / "some.h5")
    saved = pk.load_campaign(tmp_path / "some.h5")
    one, again = (reduce_campaign(made, check=False).table for made in (some, saved))
    assert np.array_equal(again.value, one.value, equal_nan=True)
    assert np.array_equal(again.covariance, one.covariance, equal_nan=True)


@pytest.mark.slow
def test_hmri_as_published_is_refused_with_everything_at_once(shared_data, datasets):
    made = pk.open_campaign(datasets / "kvlcc2_hmri" / "as_published.toml", data=shared_data)
    with pytest.raises(pk.PmmkitError) as caught:
        pk.reduce(made)
    message = str(caught.value)
    for check in (
        "inertia",
        "signs",
        "moment reference",
        "means",
        "copies",
        "length",
        "open water",
    ):
        assert f"[{check}]" in message


@pytest.mark.slow
def test_hmri_static_drift_is_the_published_cubic(hmri):
    """Y' = -.0236 v' - .0393 v'³; moved from the LCG to midship, N' = -.0082 v' + .0022 v'³."""
    values = dict(
        zip(
            hmri.families["static drift"].names,
            hmri.families["static drift"].value[-1],
            strict=True,
        )
    )
    assert values["Yv"] == pytest.approx(-0.0236, abs=2e-4)
    assert values["Yvvv"] == pytest.approx(-0.0393, abs=5e-4)
    assert values["Nv"] == pytest.approx(-0.0073 + 0.035 * -0.0236, abs=2e-4)
    assert values["Nvvv"] == pytest.approx(0.0036 + 0.035 * -0.0393, abs=3e-4)


@pytest.mark.slow
def test_hmri_added_masses_come_out_apart(hmri):
    """my' about .0146 (MMG); Nvdot and Yrdot are equal by the symmetry of the mass matrix."""
    values = dict(zip(hmri.table.names, hmri.table.value[-1], strict=True))
    std = dict(zip(hmri.table.names, hmri.table.std[-1], strict=True))
    assert -values["Yvdot"] == pytest.approx(0.0146, rel=0.1)
    assert abs(values["Nvdot"] - values["Yrdot"]) < 2 * np.hypot(std["Nvdot"], std["Yrdot"])
    assert values["Xvr"] == pytest.approx(-values["Yvdot"], rel=0.1)


@pytest.mark.slow
def test_hmri_propulsion(hmri):
    assert hmri.propulsion.thrust_deduction == pytest.approx(0.20, abs=0.02)
    assert 0.3 < hmri.propulsion.wake[1.1702] < 0.45


@pytest.mark.slow
def test_provenance_names_what_was_left_out_and_why(hmri):
    excluded = hmri.table.provenance["excluded"]
    assert "copy" in excluded["YD_279_b16"]
    json.dumps(excluded)
