"""Whether an answer is the whole story: what is left is found, and nothing where nothing is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hidden_effects import BASE, hidden_campaign

from pmmkit.diagnosis.captive.adequacy import (
    LACK,
    NEEDED,
    SIZES,
    blocks_of,
    chosen,
    flags,
    gains,
    lack_of_fit,
    refused,
    remainder,
)
from pmmkit.diagnosis.captive.build import build
from pmmkit.diagnosis.captive.diagnose import captive_system, diagnose_captive
from pmmkit.diagnosis.captive.evidence import least_gains, ranked_sets, sets_of
from pmmkit.diagnosis.captive.system import channels_of
from pmmkit.diagnosis.captive.verdict import coverage
from pmmkit.reduction import View


def asked(effects, seed=11, programme="small", **settings):
    """A system and the blocks of its best set."""
    system = captive_system(hidden_campaign(programme, effects, seed=seed, **settings), BASE)
    return system, blocks_of(system, ranked_sets(sets_of(system))[0])


def worst(system, blocks):
    return lack_of_fit(system, blocks)[0]


# The rule of evidence


@pytest.mark.slow
def test_lack_of_fit_is_the_ratio_of_two_normal_densities():
    """N(0, I + s² E E') over N(0, I), mean over the sizes; E the sine of pure sway in Y."""
    system = captive_system(hidden_campaign("small", {}, seed=5), BASE)
    (piece,) = (p for p in system.pieces if p.projection.channel.name == "Y")
    channel = piece.projection.channel
    unit = {}
    for i, rows in zip(channel.views, channel.rows, strict=True):
        view = system.views[i]
        if view.run.test == "pure_sway":
            column = unit.setdefault(view.run.id, np.zeros(len(channel.y)))
            column[rows.start + 2] = channel.scale * view.speed**2
    E, z = piece.projection.left(np.stack([*unit.values()], axis=1)), piece.data
    densities = []
    for size in SIZES:
        V = np.eye(len(z)) + size**2 * E @ E.T
        densities.append(0.5 * (z @ z - z @ np.linalg.solve(V, z) - np.linalg.slogdet(V)[1]))
    (found,) = (item for item in lack_of_fit(system, []) if item[1:] == ("Y", "pure_sway", "S1"))
    assert found[0] == pytest.approx(np.log(np.mean(np.exp(densities))), abs=1e-8)


@pytest.mark.slow
def test_nothing_of_the_base_is_left_by_its_projection():
    system = captive_system(hidden_campaign("small", {}, seed=5), BASE)
    for piece in system.pieces:
        design = piece.projection.channel.design
        assert np.abs(piece.projection.left(design)).max() < 1e-6 * np.abs(design).max()


# What is left


@pytest.mark.slow
@pytest.mark.parametrize("noise", ["standard", "hard"])
def test_nothing_is_left_where_nothing_is_hidden(noise):
    system, _ = asked({}, seed=2, noise=noise)
    assert flags(system, []) == ()


@pytest.mark.slow
@pytest.mark.parametrize("effect", ["lagged_crossflow", "yaw_sway_coupling", "heel_coupling"])
def test_the_right_answer_is_the_whole_story(effect):
    system, blocks = asked({effect: 1.0})
    assert [b.candidate.name for b in blocks] == [effect]
    assert flags(system, blocks) == ()
    assert flags(system, []) != ()


@pytest.mark.slow
def test_what_goes_with_the_place_in_the_tank_is_not_smooth_in_the_motion():
    """A spring of the wall: named as delays, but first harmonics disagree between the tests."""
    system, blocks = asked({"outside_wall_spring": 1.0}, programme="full")
    assert remainder(system, blocks) < 0.0
    _, _, _, harmonic = worst(system, blocks)
    assert harmonic in ("C1", "S1", "all")
    assert flags(system, blocks)[0] == "not_the_whole_story"
    assert "is not explained" in "".join(flags(system, blocks))


@pytest.mark.slow
def test_a_loop_leaves_the_harmonics_of_sway():
    system, blocks = asked({"outside_hysteresis": 1.0})
    log_evidence, channel, _, _ = worst(system, blocks)
    assert (channel, log_evidence > LACK) == ("Y", True)


@pytest.mark.slow
def test_what_stands_for_an_error_of_form_is_not_named():
    """Drag of sections from a table is no catalogue's: what is added to it is not needed."""
    campaign = hidden_campaign("full", {"crossflow_drag": 1.0}, truth="foreign", seed=502)
    system = captive_system(campaign, BASE)
    entries = ranked_sets(sets_of(system))
    pair = next(e for e in entries if e.names == ("crossflow_drag", "yaw_sway_coupling"))
    strong, weak = gains(system, blocks_of(system, pair))
    assert weak < NEEDED < strong
    assert chosen(system, entries).names == ("crossflow_drag",)


@pytest.mark.slow
def test_two_true_effects_are_both_needed():
    system, blocks = asked({"yaw_sway_coupling": 1.0, "lagged_crossflow": 1.0})
    assert len(blocks) == 2
    assert min(gains(system, blocks)) > NEEDED


# One run


@pytest.mark.slow
def test_leaving_a_run_out_is_a_system_without_it(monkeypatch):
    """What a force is measured by, and what its base expects, are those of all runs in both."""
    campaign = hidden_campaign("small", {"yaw_sway_coupling": 1.0}, seed=11)
    system = captive_system(campaign, BASE)
    (block,) = (b for b in system.blocks if b.candidate.name == "yaw_sway_coupling")
    ((least, run),) = least_gains(system, [block])
    views = [view for view in system.views if view.run.id != run]
    scale = {c.name: c.scale for c in system.channels}
    monkeypatch.setattr("pmmkit.diagnosis.captive.build.fitted", lambda base, *_: base)
    monkeypatch.setattr(
        "pmmkit.diagnosis.captive.build.channels_of",
        lambda *x: tuple(replace(c, scale=scale[c.name]) for c in channels_of(*x)),
    )
    rest = build(views, system.base, [block.candidate], scatter=system.scatter)
    assert least == pytest.approx(rest.normal.only(rest.blocks[0].places).log_evidence, rel=1e-3)
    assert least < system.normal.only(block.places).log_evidence


@pytest.mark.slow
def test_one_bad_run_is_not_named():
    """A static run off by 15 N: the effects that it alone shows explain it, and are refused."""
    campaign = hidden_campaign("small", {}, seed=3)
    runs = tuple(_off(run, 15.0) if run.id == "DR_1.5_6_20" else run for run in campaign.runs)
    system = captive_system(campaign.with_(runs=runs), BASE)
    sets = sets_of(system)
    entries = ranked_sets(sets)
    assert entries[0].log_evidence > 5.0
    assert chosen(system, entries) is None
    left = refused(system, sets, entries[0], [])
    assert {item.run for item in left} == {"DR_1.5_6_20"}
    assert "DR_1.5_6_20 alone: repeat it" in "".join(flags(system, [], more=tuple(map(str, left))))
    listed = {item.name: item for item in coverage(system)}
    assert "DR_1.5_6_20" in listed["rudder_cross_terms"].why


@pytest.mark.slow
def test_a_sound_run_that_carries_most_of_an_effect_is_not_accused():
    """Drag of sway at .3 of its usual size: the steepest run shows most of it, the others some."""
    found = diagnose_captive(hidden_campaign("full", {"modulus_sway_drag": 0.3}, seed=8001), BASE)
    assert found.verdict == "suspected"
    (item,) = found.suspected
    assert (item.effect, item.agrees) == ("modulus_sway_drag", True)
    assert f"the run {item.run} carries most of it, and the other runs agree" in found.flags[1]


def _off(run, newtons):
    data = run.data
    moved = data.assign(Y=data["Y"] + newtons)
    return run.with_(loader=lambda: moved)


@pytest.mark.slow
def test_an_effect_that_is_given_is_not_left():
    system, blocks = asked({"memory": 1.0})
    assert flags(system, [], blocks) == ()


def test_all_pieces_of_a_run_have_one_frequency():
    """Two cycles of a noisy record give none of their own: the phase would slip with it."""
    campaign = hidden_campaign("full", {}, seed=10523)
    (run,) = (run for run in campaign.runs if run.id == "YD_1.0_0.4_8")
    early, late = View.of(campaign.with_(runs=(run,)))
    assert early.omega == late.omega
    noise = np.sqrt(np.diag(early.covariance["N"]) + np.diag(late.covariance["N"]))
    np.testing.assert_array_less(np.abs(early.force["N"] - late.force["N"])[1:], 5 * noise[1:])
