"""Free-running records of another program, free of faults: the checks have nothing to warn of."""

from __future__ import annotations

import pytest

import pmmkit as pk

CAMPAIGNS = {"nothing hidden": "f558770", "rudder zero": "f876284", "current": "f281321"}


@pytest.mark.parametrize("case", CAMPAIGNS)
def test_heel_noise_of_the_fixes_and_a_current_are_no_faults(case, shared_data):
    folder = shared_data / "free_hidden" / CAMPAIGNS[case]
    if not folder.is_dir():
        pytest.skip("the free-running records of another program are not on this machine")
    found = pk.examine(pk.open_campaign(folder))
    assert [item.severity for item in found] == ["info"] * (case == "current")
    if found:
        assert "velocities through the water" in found[0].message


@pytest.mark.slow
def test_manoeuvres_agree_with_the_ship_they_were_made_from(shared_data):
    """The truth is the library's S175 with another steering gear, simulated by another program.

    That program turns the rudder at its next step of 0.5 s, so that its executes get later.
    """
    folder = shared_data / "free_hidden" / CAMPAIGNS["nothing hidden"]
    if not folder.is_dir():
        pytest.skip("the free-running records of another program are not on this machine")
    found = pk.compare("s175", pk.open_campaign(folder))
    assert any("moves at 3 deg/s in the records and at 5 deg/s" in note for note in found.notes)
    rows = [row for item in found.manoeuvres for row in item.rows()]
    known = [
        row["ratio"]
        for row in rows
        if row["ratio"] == row["ratio"] and not row["measure"].startswith("time_execute")
    ]
    assert len(known) > 20
    assert sum(ratio < 1.0 for ratio in known) >= 0.9 * len(known)
    assert max(known) < 2.0
