"""Groups of runs that read otherwise than the rest are told by the checks, before any reduction."""

from __future__ import annotations

import pytest

from pmmkit.intake import examine
from tests.support.hidden_effects import hidden_campaign


def told(campaign):
    return [item for item in examine(campaign) if item.cause == "odd_group"]


def later_reads(campaign, channel, share, part):
    """A channel reads more from some part of the day on."""
    later = [run.id for run in campaign.runs][int(part * len(campaign.runs)) :]

    def one(run):
        data = run.data.assign({channel: (1.0 + share) * run.data[channel]})
        return run if run.id not in later else run.with_(loader=lambda: data)

    return campaign.with_(runs=tuple(map(one, campaign.runs))), later


@pytest.mark.slow
def test_a_gauge_that_is_changed_for_the_last_third_of_the_day_is_told():
    campaign, later = later_reads(hidden_campaign("full", seed=9704), "N", -0.04, 2.0 / 3.0)
    (found,) = told(campaign)
    assert found.channels == ("N",)
    assert set(found.runs) == set(later)
    assert found.numbers["gain"] == pytest.approx(-0.04, abs=0.01)
    assert (found.severity, "diagnose" in found.remedy) == ("warning", True)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2000, 2006))
def test_sound_runs_have_no_group(seed):
    assert told(hidden_campaign("small", seed=seed)) == []
