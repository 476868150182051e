"""A window that the campaign file states counts everywhere alike, and its reason is told."""

from __future__ import annotations

import numpy as np
import pytest
from small_campaign import write_campaign

from pmmkit import open_campaign
from pmmkit.base import CampaignError
from pmmkit.intake import summarise
from pmmkit.reduction import PreparedRun, View, reduce_campaign

STATIC, SWAY = "SD_U1_b+08", "PS_U1_a0.3"


def stated(folder, run, start, end, action="window"):
    """The campaign with one more correction."""
    file = folder / "campaign.toml"
    more = (
        f'\n[[corrections]]\nruns = ["{run}"]\naction = "{action}"\nt_start = {start}\n'
        f't_end = {end}\nreason = "the carriage shook"\n'
    )
    other = folder / "other.toml"
    other.write_text(file.read_text("utf-8") + more, encoding="utf-8")
    return open_campaign(other)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return write_campaign(tmp_path_factory.mktemp("window") / "small")


def test_the_mean_of_a_static_record_is_that_of_the_window(folder):
    campaign = stated(folder, STATIC, 4.95, 12.05)
    run = campaign[STATIC]
    found = PreparedRun.of(run, campaign)
    inside = run.data.sel(t=slice(4.95, 12.05))
    assert found.t[0] == pytest.approx(5.0)
    assert found.t[-1] == pytest.approx(12.0)
    assert found.result.measured["Y"][0] == pytest.approx(float(inside["Y"].mean()))
    assert "the carriage shook" in found.result.window
    assert len(run.data["t"]) == 200, "the rest of the record stays to be seen"


def test_a_window_holds_whole_cycles_from_its_start(folder):
    """Of 12.5 s a cycle: from 6.25 s on, half a cycle in, two whole ones fit before 35 s."""
    campaign = stated(folder, SWAY, 6.25, 35.0)
    found = PreparedRun.of(campaign[SWAY], campaign)
    assert found.result.cycles == 2
    assert found.t[0] == pytest.approx(6.25)
    assert found.t[-1] == pytest.approx(31.25, abs=0.06)
    assert not found.result.ramp


def test_checks_and_diagnosis_take_the_same_samples(folder):
    campaign = stated(folder, STATIC, 4.95, 12.05)
    mean = PreparedRun.of(campaign[STATIC], campaign).result.measured["Y"][0]
    assert summarise(campaign[STATIC], campaign).means["Y"] == pytest.approx(mean)
    views = View.of(stated(folder, SWAY, 6.25, 35.0))
    (own,) = (view for view in views if view.run.id == SWAY)
    assert np.ptp(own.t) == pytest.approx(25.0, abs=0.06)


@pytest.mark.parametrize(
    ("start", "end", "said"), [(9.0, 4.0, "later than"), (500.0, 600.0, "holds 0 samples")]
)
def test_a_window_without_samples_is_refused_with_what_there_is(folder, start, end, said):
    def reduced():
        campaign = stated(folder, STATIC, start, end)
        return PreparedRun.of(campaign[STATIC], campaign)

    with pytest.raises(CampaignError, match=said):
        reduced()


def test_cycles_that_are_too_few_samples_to_compare_count_where_they_are_asked_for(folder):
    """Eight samples a cycle carry a first harmonic; which cycles are sound they do not tell."""
    campaign = open_campaign(folder)
    run = campaign[SWAY]
    coarse = campaign.with_(runs=(run.with_(loader=lambda: run.data.isel(t=slice(0, None, 31))),))
    with pytest.raises(CampaignError, match="only 8 samples"):
        reduce_campaign(coarse, structure="linear", executor=1)
    asked = reduce_campaign(coarse, structure="linear", cycles=(2, 3), executor=1)
    whole = reduce_campaign(campaign.with_(runs=(run,)), structure="linear", executor=1)
    assert asked.table["Yv"].item() == pytest.approx(whole.table["Yv"].item(), rel=0.1)
