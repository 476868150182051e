"""Depth of the water as a setting of a run."""

from __future__ import annotations

import pytest
from small_campaign import write_campaign, write_depths

import pmmkit as pk
from pmmkit.base import CampaignError
from pmmkit.campaigns import Run
from pmmkit.intake import examine


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return write_depths(tmp_path_factory.mktemp("depths") / "tests", {0.48: 1.0, 0.36: 1.6})


@pytest.fixture(scope="module")
def campaign(folder):
    return pk.open_campaign(folder)


def test_each_depth_has_its_runs_and_its_water(campaign):
    deep, shallow = campaign.by_depth()
    assert campaign.depths == (0.48, 0.36)
    assert (deep.water.depth, shallow.water.depth) == (0.48, 0.36)
    assert len(deep) == len(shallow) == len(campaign) / 2
    assert all(run.id.startswith("h0.36_") for run in shallow)
    assert shallow.at_one_depth() == shallow


def test_the_water_of_the_campaign_is_that_of_runs_that_state_none(tmp_path):
    folder = write_campaign(tmp_path / "tests")
    file = folder / "campaign.toml"
    text = file.read_text(encoding="utf-8").replace("g = 9.81", "g = 9.81\ndepth = 0.48")
    file.write_text(text.replace("[[runs]]\n", "[[runs]]\ndepth = 0.36\n", 3), encoding="utf-8")
    campaign = pk.open_campaign(folder)
    assert [len(part) for part in campaign.by_depth()] == [len(campaign) - 3, 3]


def test_a_test_over_another_bottom_is_no_repeat(campaign):
    assert all(len(group) == 1 for group in Run.repeats(campaign.runs))


def test_a_saved_campaign_keeps_the_depths(campaign, tmp_path):
    pk.save_campaign(campaign, tmp_path / "saved.h5")
    assert pk.open_campaign(tmp_path / "saved.h5").depths == (0.48, 0.36)


def test_a_depth_is_positive(folder, tmp_path):
    text = (folder / "campaign.toml").read_text(encoding="utf-8")
    file = tmp_path / "campaign.toml"
    file.write_text(text.replace("depth = 0.36", "depth = -0.36"), encoding="utf-8")
    with pytest.raises(CampaignError, match="depth"):
        pk.open_campaign(file)


def test_what_holds_at_one_depth_refuses_several(campaign):
    for asked in (pk.reduce, lambda it: pk.compare("s175-3dof", it)):
        with pytest.raises(CampaignError, match=r"0\.48 m and 0\.36 m"):
            asked(campaign)


def test_checks_look_at_each_depth_alone(campaign):
    """Together, runs of one setting would be at odds by a factor of 1.6."""
    assert [item for item in examine(campaign) if item.severity != "info"] == []
