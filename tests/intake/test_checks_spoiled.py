"""Campaigns that somebody spoiled: what is wrong is found, and named, in one run and in all.

The whole list is the study `scripts/studies/spoiled.py`; here stand the ways that did most harm.
"""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from pmmkit import catalogue
from pmmkit.base import DataError
from pmmkit.campaigns import Correction
from pmmkit.intake import Untold, examine, summarise
from pmmkit.intake.checks import CHECKS
from pmmkit.intake.checks.agreement.asking import suspects
from pmmkit.intake.checks.agreement.posterior import agreement
from pmmkit.intake.checks.agreement.rows import MAIN, SPREAD, groups_of
from pmmkit.intake.checks.gauges import change_facts, hold_facts
from pmmkit.reduction import reduce_campaign
from tests.support import spoiled

CASES = {case.name: case for case in spoiled.cases("small")}


def said(campaign):
    """Errors and warnings."""
    return [item for item in examine(campaign) if item.severity != "info"]


@pytest.mark.parametrize("base", ["plain", "balance", "recorded"])
def test_a_clean_campaign_is_silent(base):
    assert [str(item) for item in said(spoiled.clean("small", 3, base))] == []


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        "Y dead (pure_yaw, small)",
        "N dead (all runs, small)",
        "X frozen (pure_sway, small)",
        "N stuck (pure_yaw, small)",
        "Y stepped (pure_sway, small)",
        "N drifting (yaw_drift, small)",
        "Y clipped hard (pure_sway, small)",
        "Y clipped softly (pure_sway, small)",
        "Y clipped softly (yaw_drift, small)",
        "X sign flipped (static_drift, small)",
        "Y in kgf (pure_yaw, small)",
        "half of the hull (yaw_drift, small)",
        "half a cycle off (pure_yaw, small)",
        "sway file under a yaw entry (pure_yaw, small)",
        "two drift angles exchanged (static_drift, small)",
        "copy x 1.001 (static_drift, small)",
        "Y and N exchanged (pure_yaw, small)",
        "yaw with drift as pure yaw (yaw_drift, small)",
        "drift 4° off (yaw_drift, small)",
        "amplitude peak to peak (pure_sway, small)",
        "amplitude peak to peak (all runs, small)",
        "forces in tank axes (yaw_drift, small)",
        "velocities in tank axes (all runs, small)",
        "phase 5° late (all runs, small)",
        "filter lag 0.1 s (all runs, small)",
        "Y 0.2 s late (all runs, small)",
    ],
)
def test_what_is_wrong_is_named(name):
    case = CASES[name]
    found = said(case.spoiled())
    texts = [f"{item} {item.remedy}" for item in found]
    assert any(re.search(case.way.cause, text) for text in texts), texts


def test_one_run_with_the_wrong_sign_is_refused_by_name():
    case = CASES["Y sign flipped (pure_sway, small)"]
    (finding,) = [item for item in said(case.spoiled()) if item.check == "agreement"]
    assert finding.severity == "error"
    assert finding.runs == ("SW_1.5_0.22",)
    assert finding.channels == ("Y",)
    assert "opposite sign" in finding.message


def test_a_dead_channel_is_not_blamed_on_anything_else():
    found = said(CASES["Y dead (yaw_drift, small)"].spoiled())
    assert [(item.check, item.runs, item.channels) for item in found] == [
        ("gauges", ("YD_1.5_0.4_8",), ("Y",))
    ]


def test_a_lag_is_not_blamed_on_the_moment_reference():
    checks = {item.check for item in said(CASES["Y 0.2 s late (all runs, small)"].spoiled())}
    assert "moment reference" not in checks


def test_what_the_campaign_file_accepts_is_a_remark_with_its_reason():
    campaign = CASES["Y sign flipped (pure_sway, small)"].spoiled()
    reason = "the gauge was mounted the other way round and the fit is for that alone"
    taken = Correction(
        runs=("SW_*",), action="accept", reason=reason, values={"check": "agreement"}
    )
    own = campaign.with_(
        runs=tuple(
            run.with_(corrections=(taken,)) if taken.applies_to(run.id) else run
            for run in campaign.runs
        )
    )
    (finding,) = [item for item in examine(own) if item.check == "agreement"]
    assert finding.severity == "info"
    assert reason in finding.message
    other = replace(taken, values={"check": "copies"})
    stays = campaign.with_(runs=tuple(run.with_(corrections=(other,)) for run in campaign.runs))
    assert any(item.severity == "error" for item in examine(stays))
    unknown = replace(taken, values={"check": "agrement"})
    with pytest.raises(DataError, match="The checks are inertia"):
        examine(campaign.with_(runs=(campaign.runs[0].with_(corrections=(unknown,)),)))


def test_the_runs_find_the_derivatives_behind_them():
    campaign = spoiled.clean("small", 1)
    (group,) = groups_of(campaign, [summarise(run, campaign) for run in campaign.runs])
    found = agreement(group)
    std = np.sqrt(np.diagonal(np.linalg.inv(found.precision))) * group.scale
    value = dict(zip(group.usual.names, found.value * group.scale, strict=True))
    error = dict(zip(group.usual.names, std, strict=True))
    truth = spoiled.truth()
    for name in ("Yv", "Yr", "Nv", "Nr", "Yvdot", "Nrdot", "Xudot", "Xvr"):
        assert abs(value[name] - truth[name]) < 4 * error[name], name
    assert found.weight.min() == 1.0


def test_the_known_inertia_of_a_balance_is_found_in_the_readings():
    campaign = spoiled.clean("small", 1, "balance")
    (group,) = groups_of(campaign, [summarise(run, campaign) for run in campaign.runs])
    design = group.design(group.histories())
    held = [group.usual.names.index(name) for name in ("mass", "gyration")]
    inside = (design[..., held] @ group.usual.mean[held])[group.known]
    assert np.abs(inside).max() > 0.2 * np.abs(group.rows[group.known]).max()


def test_suspects_are_what_the_faults_of_the_catalogue_declare():
    asked = suspects()
    assert {item.effect.name for item in asked} == {
        entry.name for entry in catalogue().values() if entry.suspects
    }
    assert all(item.effect.faulty for item in asked)
    assert {"fault_misalignment", "fault_time_lag", "slip_sign"} <= {x.effect.name for x in asked}
    assert set(MAIN) <= set(SPREAD)
    assert {"gauges", "agreement"} <= {check.name for check in CHECKS.values()}


def test_holds_are_told_from_few_digits():
    t = np.linspace(0, 60, 3000)
    noise = np.random.default_rng(0).normal(size=t.size)
    coarse = np.round(10 * np.sin(t) + 0.3 * noise)
    assert hold_facts(coarse)["frozen"] == 0.0
    assert hold_facts(coarse)["stuck"] == 0.0
    assert hold_facts(np.full(3000, 7.0))["constant"] == 1.0
    place = np.arange(t.size)
    sticking = (np.sin(t) + 0.1 * noise)[np.where(place % 50 < 10, place - place % 50, place)]
    assert hold_facts(sticking)["stuck"] == pytest.approx(0.2, abs=0.02)


def test_a_step_and_a_creep_are_told_from_each_other_beside_harmonics():
    t = np.linspace(0, 40, 1600)
    theta = 2 * np.pi * t / 10
    wave = 5 * np.sin(theta) + 2 * np.cos(3 * theta)
    noise = 0.2 * np.random.default_rng(1).normal(size=t.size)
    stepped, creeping, plain = change_facts(
        t, np.stack([wave + 1.0 * (t > 25), wave + 2.0 * t / 40, wave]) + noise, theta
    )
    assert stepped["step"] == pytest.approx(1.0, abs=0.1)
    assert stepped["step_at"] == pytest.approx(25, abs=1.0)
    assert stepped["step_f"] > 1.2 * stepped["creep_f"]
    assert creeping["creep"] == pytest.approx(2.0, abs=0.2)
    assert creeping["creep_f"] > creeping["step_f"]
    assert max(plain["creep_f"], plain["step_f"]) < 20


@pytest.mark.slow
def test_a_table_says_what_its_runs_cannot_check():
    campaign = spoiled.clean("small", 2)
    told = Untold.of(campaign, [summarise(run, campaign) for run in campaign.runs])
    notes = list(map(str, told))
    assert any("scale of the gauges" in note and "Known weights" in note for note in notes)
    assert any("length L" in note and "A tape" in note for note in notes)
    assert any("Izz" in note and "Swinging the dry model" in note for note in notes)
    assert any("one frequency" in note for note in notes)
    found = reduce_campaign(campaign)
    assert found.untold[0] == told[0]
    assert {str(item) for item in found.untold} <= set(found.table.notes)
    assert found.table.verdict.conditions == tuple(x.condition for x in found.untold if x.condition)


@pytest.mark.slow
def test_records_that_stand_still_do_not_stop_a_reduction():
    campaign = CASES["Y frozen (all runs, small)"].spoiled()
    table = reduce_campaign(campaign, structure="linear", check=False).table
    assert np.isfinite(table.value[:, [name[0] == "N" for name in table.names]]).any()
