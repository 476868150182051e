"""Runs that disagree with the others: a group reads otherwise, and a name must say so."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hidden_effects import BASE, hidden_campaign

from pmmkit.diagnosis.captive.diagnose import diagnose_captive


def misread(campaign, chosen, **gains):
    """A campaign in which some runs read channels too large by a share."""

    def run_of(run):
        if not chosen(run):
            return run
        data = run.data.copy()
        for name, gain in gains.items():
            data[name] = data[name] * (1.0 + gain)
        return replace(run, loader=lambda: data)

    return campaign.with_(runs=tuple(map(run_of, campaign.runs)))


@pytest.mark.slow
def test_a_second_balance_for_steady_tests_is_no_memory():
    """Harmonics alone ask for a memory of the flow; the means of steady and oscillating tests do
    not go together with it."""
    found = diagnose_captive(
        hidden_campaign("full", {"beyond_second_balance": 1.0}, seed=8320), BASE
    )
    (told,) = found.disagreements
    assert (told.channel, told.group, len(told.runs)) == ("N", "in steady runs", 22)
    assert found.flags[0] == "not_the_whole_story"
    assert str(told) in found.flags
    assert list(found.to_dict()["disagreements"][0]["runs"]) == list(told.runs)


@pytest.mark.slow
def test_a_gauge_that_is_changed_in_the_day_is_told_with_its_runs():
    """From the middle of the day on Y reads 4 % more."""
    campaign = hidden_campaign("full", seed=17)
    ids = [run.id for run in campaign.runs]
    later = set(ids[len(ids) // 2 :])
    found = diagnose_captive(misread(campaign, lambda run: run.id in later, Y=0.04), BASE)
    (told,) = found.disagreements
    assert told.channel == "Y"
    assert set(told.runs) == later
    assert told.gain == pytest.approx(0.04, abs=0.015)
    assert found.verdict != "missing_effect" or found.flags


@pytest.mark.slow
def test_a_name_that_tells_nothing_of_the_others_is_doubted():
    """A transient is of each run: without it conditions are predicted as well."""
    found = diagnose_captive(hidden_campaign("full", {"fault_transient": 0.3}, seed=9226), BASE)
    (named,) = found.findings
    assert named.error_after >= 0.999 * named.error_before
    assert found.flags == (
        "not_the_whole_story",
        "the error of left-out conditions does not fall with fault_transient",
    )


@pytest.mark.slow
@pytest.mark.parametrize("seed", [31, 32, 33])
def test_runs_that_agree_say_nothing(seed):
    found = diagnose_captive(hidden_campaign("full", seed=seed), BASE)
    assert found.verdict == "noise"
    assert not found.disagreements
    assert np.isfinite(found.chance)
