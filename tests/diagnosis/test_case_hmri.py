"""HMRI's captive tests: what a linear and a cubic model lack; tables that state no noise."""

from __future__ import annotations

from itertools import pairwise

import pytest

from pmmkit import begin, open_campaign
from pmmkit.base import DataError
from pmmkit.diagnosis.captive.diagnose import diagnose_captive

NOISE, FLOOR = 0.03, 0.02


@pytest.fixture(scope="module")
def campaign(shared_data, datasets):
    return open_campaign(datasets / "kvlcc2_hmri", data=shared_data)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("base", "expected", "fall"),
    [
        ("linear", {"yaw_sway_coupling", "modulus_sway_drag", "cubic_hull_terms"}, 0.65),
        ("cubic", {"yaw_sway_coupling", "modulus_sway_drag"}, 0.85),
    ],
)
def test_what_is_named_lowers_the_error_step_by_step(campaign, base, expected, fall):
    """Yasukawa and Yoshimura (2015) need vvr and vrr for this hull; drift goes to 30°."""
    session = begin(base, campaign, noise=NOISE, floor=FLOOR)
    found = session.diagnose()
    assert found.verdict == "missing_effect"
    assert set(found.best) == expected
    for item in found.findings:
        session = session.add(item.effect)
    shares = session.fall().totals
    assert all(after < before for before, after in pairwise(shares))
    assert shares[-1] < fall * shares[0]
    assert session.diagnose().verdict == "unexplained"


def test_without_a_stated_noise_nothing_is_said(campaign):
    """Tables of means and harmonics hold no noise; the user's statement must come first."""
    with pytest.raises(DataError, match=r"noise = 0\.01"):
        diagnose_captive(campaign, "cubic")


@pytest.mark.slow
def test_a_larger_noise_names_no_more(campaign):
    """What is named or, where the rest is too much for any name, comes nearest."""
    loud, quiet = (
        begin("cubic", campaign, noise=noise, floor=0.02).diagnose() for noise in (0.06, 0.01)
    )
    assert not quiet.best
    assert quiet.nearest is not None
    assert len(loud.best) <= len(quiet.nearest.effects)
