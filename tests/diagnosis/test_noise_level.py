"""The noise level of left-out conditions, and sets that do not come down to it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hidden_effects import hidden_campaign
from test_diagnosis import BASE, diagnosed

from pmmkit.diagnosis.captive.adequacy import blocks_of
from pmmkit.diagnosis.captive.build import build
from pmmkit.diagnosis.captive.diagnose import captive_system
from pmmkit.diagnosis.captive.evidence import ranked_sets, sets_of
from pmmkit.diagnosis.captive.held_out import condition, held_out
from pmmkit.diagnosis.captive.verdict import _losses, chosen_anew


@pytest.fixture(scope="module")
def system():
    return captive_system(hidden_campaign("small", {"yaw_sway_coupling": 1.0}, seed=11), BASE)


def drawn(system, rng):
    """The system with forces of the base, and of noise, scatter and floor as it believes them."""
    channels = []
    for piece in system.pieces:
        c, p = piece.projection.channel, piece.projection
        white = rng.normal(size=len(c.y)) + p.floor @ rng.normal(size=p.floor.shape[1])
        y = c.design @ [system.base.values[name] for name in system.base.names[c.name]]
        for rows, root in zip(c.runs, p.roots, strict=True):
            y[rows] += root @ white[rows]
        channels.append(replace(c, y=y))
    return replace(system, channels=tuple(channels))


def test_noise_of_the_stated_covariance_gives_errors_at_the_noise_level(system):
    """Forces drawn from it: mean, spread and chances are those that are told without drawing."""
    rng = np.random.default_rng(7)
    found = [held_out(drawn(system, rng)) for _ in range(60)]
    sums = np.array(
        [[*np.nansum((x.error / x.level) ** 2, axis=0), np.nansum(x.distance)] for x in found]
    )
    first = found[0]
    means = np.array([*np.isfinite(first.error).sum(axis=0), np.nansum(first.rows)])
    z = (sums - means) / np.sqrt(first.spread)
    assert np.abs(z.mean(axis=0)).max() < 4.0 / np.sqrt(len(found))
    assert np.allclose(z.std(axis=0), 1.0, atol=0.35)
    shares = [(x.share(), x.share(kind="level")) for x in found]
    assert np.mean(np.square(shares), axis=0)[0] == pytest.approx(
        np.mean(np.square(shares), axis=0)[1], rel=0.1
    )
    assert sum(x.misfit.chance < 0.01 for x in found) <= 2


def test_one_run_that_is_off_does_not_keep_a_set_from_being_named(system):
    """The condition that stands out most is not counted; two of them are."""
    quiet = held_out(system, blocks_of(system, ranked_sets(sets_of(system))[0]))
    error = quiet.error.copy()
    error[3, 1] = 20.0 * quiet.level[3, 1]
    assert replace(quiet, error=error).misfit.chance > 0.01
    error[5, 1] = 20.0 * quiet.level[5, 1]
    worse = replace(quiet, error=error).misfit
    assert (worse.where, worse.chance < 1e-6) == (quiet.channels[1], True)


@pytest.mark.slow
def test_a_set_loses_what_a_system_without_the_condition_lacks(system):
    entry = ranked_sets(sets_of(system))[0]
    blocks = blocks_of(system, entry)
    (losses,) = _losses(system, [blocks], [])
    name = max(losses, key=lambda key: -losses[key])
    views = [view for view in system.views if condition(view.run) != name]
    rest = build(views, system.base, [b.candidate for b in blocks], scatter=system.scatter)
    whole, less = (
        x.normal.only(np.concatenate([b.places for b in own])).log_evidence
        for x, own in ((system, blocks), (rest, rest.blocks))
    )
    assert losses[name] == pytest.approx(less - whole, rel=0.05)


@pytest.mark.slow
def test_what_all_conditions_choose_each_of_them_is_predicted_with(system):
    """The best set leads by far: every fold elects it."""
    entries = ranked_sets(sets_of(system))
    predicted = held_out(system, blocks_of(system, entries[0]))
    again = chosen_anew(system, entries, entries[0], predicted)
    np.testing.assert_array_equal(again.error, predicted.error)


@pytest.mark.slow
@pytest.mark.parametrize("effect", ["beyond_vortex_burst", "outside_hysteresis"])
def test_what_no_effect_brings_down_to_the_noise_has_a_nearest_relative_and_no_name(effect):
    found = diagnosed({effect: 1.0}, seed=31)
    assert (found.verdict, found.best, found.findings) == ("unexplained", (), ())
    assert found.nearest.effects
    assert found.nearest.ratio > 1.05
    assert "nearest relative" in str(found)
    assert found.to_dict()["nearest"]["effects"] == found.nearest.effects


@pytest.mark.slow
def test_a_finding_stands_beside_the_noise_level():
    (finding,) = diagnosed({"memory": 1.0}, seed=31).findings
    assert finding.error_after == pytest.approx(finding.error_level, rel=0.25)
    assert finding.error_before > 1.3 * finding.error_level
    assert "where noise alone gives" in str(finding)


@pytest.mark.slow
def test_evidence_is_that_of_each_effect_and_not_of_the_set():
    """A weak effect beside a strong one: the set has the odds of both, each its own."""
    found = diagnosed({"yaw_sway_coupling": 1.0, "fault_misalignment": 0.4}, seed=31)
    own = {item.effect: item.log_odds for item in found.findings}
    assert set(own) == {"yaw_sway_coupling", "fault_misalignment"}
    (best,) = [item for item in found.entries if set(item.names) == set(own)]
    assert own["yaw_sway_coupling"] > 10 * own["fault_misalignment"] > 0.0
    single = next(item for item in found.entries if item.names == ("yaw_sway_coupling",))
    assert own["fault_misalignment"] == pytest.approx(best.log_evidence - single.log_evidence)
