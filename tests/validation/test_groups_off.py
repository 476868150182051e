"""A group of runs that disagrees with the others is told beside a model, also a wrong one."""

from __future__ import annotations

from dataclasses import replace

import pytest

import pmmkit as pk
from tests.support.free_tank.campaigns import Setup, write
from tests.support.hidden_effects import BASE, hidden_campaign


@pytest.fixture(scope="module")
def model():
    """Of another campaign; its rudder is that of the library, whose force is 40 % off."""
    other = hidden_campaign("small", seed=5000)
    table = pk.reduce(other, structure=(*BASE, "Xdd", "Yd", "Nd"))
    return pk.to_model(table, force=True, missing="zero")


def misread(campaign, chosen, **gains):
    """Some runs read channels too large by a share."""

    def run_of(run):
        if not chosen(run):
            return run
        data = run.data.assign({x: (1.0 + gain) * run.data[x] for x, gain in gains.items()})
        return replace(run, loader=lambda: data)

    return campaign.with_(runs=tuple(map(run_of, campaign.runs)))


@pytest.mark.slow
def test_the_later_half_of_a_day_that_reads_more_is_told_beside_a_wrong_model(model):
    campaign = hidden_campaign("small", seed=9703)
    later = {run.id for run in campaign.runs[6:]}
    found = pk.compare(model, misread(campaign, lambda run: run.id in later, Y=0.03))
    (told,) = found.disagreements
    assert (told.channel, set(told.runs)) == ("Y", later)
    assert told.gain == pytest.approx(0.03, abs=0.015)
    assert found.standouts()[0] == str(told)
    assert found.to_dict()["disagreements"][0]["group"] == told.group


@pytest.mark.slow
@pytest.mark.parametrize("seed", [2000, 2001, 2017])
def test_a_wrong_model_makes_no_group_of_sound_runs(model, seed):
    """Its rudder is 40 % off, which no run is to blame for."""
    found = pk.compare(model, hidden_campaign("small", seed=seed))
    assert found.disagreements == ()
    assert any("rudder" in text for text in found.standouts())


@pytest.mark.slow
def test_zigzags_of_a_lopsided_ship_among_turns_of_another_are_told(tmp_path):
    """Three zigzags are of a ship that a constant side force and moment push."""
    sound, pushed = (
        pk.open_campaign(write(Setup(case=case, seed=3, ship="kvlcc2-l7"), tmp_path))
        for case in ("none", "asymmetry")
    )
    mixed = sound.with_(runs=(*sound.runs[:3], *pushed.runs[3:]))
    (told,) = pk.compare("kvlcc2-l7", mixed).disagreements
    assert (told.channel, len(told.runs)) == ("Y", 3)
    assert pk.compare("kvlcc2-l7", sound).disagreements == ()
