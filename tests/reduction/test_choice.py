"""The structure that the runs choose themselves."""

from __future__ import annotations

import pytest

from pmmkit.errors import CampaignError
from pmmkit.reduction import reduce_campaign
from tests.support import second_tank

ROOT_TESTS = ("static_drift", "pure_sway", "pure_yaw")


@pytest.fixture(scope="module")
def tanker():
    return second_tank.campaign("small", 1, 0.002, 0.001, lambda rng: rng.standard_normal())


def reduced(made, structure="auto"):
    return reduce_campaign(made, structure=structure, check=False, jobs=1)


def only(made, *tests):
    return made.with_(runs=tuple(run for run in made if run.test in tests))


def test_yaw_with_drift_shows_the_coupling(tanker):
    """The tank's hull is cubic with coupling, and nothing of it is lost by not asking for it."""
    found = reduced(tanker)
    assert found.table.provenance["structure"] == "abkowitz3"
    asked = reduced(tanker, "abkowitz3")
    assert found.table.names == asked.table.names
    assert found.table.value == pytest.approx(asked.table.value, rel=1e-10)
    assert found.table.std == pytest.approx(asked.table.std, rel=1e-10)


def test_drift_sway_and_yaw_alone_leave_the_coupling_out_and_say_so(tanker):
    found = reduced(only(tanker, *ROOT_TESTS))
    assert found.table.provenance["structure"] == "cubic"
    assert (
        "abkowitz3 has 4 terms that they do not show (Nvrr, Nvvr, Yvrr and Yvvr)" in found.notes[0]
    )


def test_drift_alone_determines_no_structure(tanker):
    with pytest.raises(CampaignError, match="nothing shows Nr and Yr"):
        reduced(only(tanker, "static_drift"))
