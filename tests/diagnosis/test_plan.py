"""The next run and whole programmes: against the virtual tank, simulated noise and closed forms."""

from __future__ import annotations

import json
import math
import tomllib
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hidden_effects import BASE, SHIP, WATER, hidden_campaign
from hidden_effects.programmes import asked, options, plans

from pmmkit import Limits, next_runs, plan
from pmmkit.base import CampaignError, DataError, UnknownNameError
from pmmkit.campaigns import Settings
from pmmkit.campaigns.file.schema import RunEntry
from pmmkit.cli import main
from pmmkit.conventions import Convention
from pmmkit.diagnosis import read_plan_file
from pmmkit.diagnosis.captive.base import CaptiveBase
from pmmkit.diagnosis.captive.build import build
from pmmkit.diagnosis.captive.diagnose import diagnose_captive
from pmmkit.diagnosis.captive.evidence import best_blocks, condition_on
from pmmkit.diagnosis.captive.refit import captive_candidates
from pmmkit.diagnosis.planning.ground import ground_of
from pmmkit.diagnosis.planning.information import known, rows_of
from pmmkit.diagnosis.planning.options import USUAL, options_of, timed
from pmmkit.diagnosis.planning.plan_file import entries_text
from pmmkit.diagnosis.planning.planned import (
    PlannedPiece,
    measured_noise,
    planned_views,
    stated_noise,
)
from pmmkit.diagnosis.planning.programme import sights
from pmmkit.diagnosis.planning.separation import Likely, expected_odds
from pmmkit.models import load_model
from pmmkit.reduction import View

NAMES = {c: tuple(name for name in (*BASE, "Xdd", "Yd", "Nd") if name[0] == c) for c in "XYN"}
LIMITS = Limits(
    speeds=(1.0, 1.5, 2.0),
    drift=math.radians(12),
    rudder=math.radians(25),
    sway=0.8,
    yaw=math.radians(20),
    sway_velocity=0.25,
    yaw_rate=0.5,
    tests=(*USUAL, "sway_yaw"),
)
RULER = LIMITS.with_(speeds=(1.5,), frequencies=(2.0,))


def base(**values):
    zero = {name: 0.0 for own in NAMES.values() for name in own}
    return CaptiveBase(
        names=NAMES,
        values=zero | values,
        ship=SHIP,
        water=WATER,
        convention=Convention(),
        reference=1.5,
    )


def cubic_model():
    made = load_model("s175-3dof")
    part = made.parts["hull_polynomial"]
    hull = replace(part, values={name: x for name, x in part.values.items() if name in BASE})
    return made.with_(ship=SHIP, water=WATER, parts={**made.parts, "hull_polynomial": hull})


# A run that is not made is seen as one that is


def test_a_planned_run_moves_as_the_one_that_is_made():
    """Harmonics of what the base multiplies, from the tank's records and from the settings."""
    campaign = hidden_campaign("small", noise="none", seed=3, roll_measured=False)
    measured = View.of(campaign)
    noise = stated_noise(dict.fromkeys("XYN", 1.0))
    every = options("small", LIMITS)
    planned = [v for option in every for v in planned_views(option, base(), noise)]
    assert len(planned) == len(measured)
    for ours, theirs in zip(planned, measured, strict=True):
        assert ours.early == theirs.early
        for channel in "XYN":
            one, other = (base().design(base().names[channel], [view]) for view in (ours, theirs))
            np.testing.assert_allclose(one, other, rtol=1e-6, atol=1e-6 * np.abs(other).max())


def test_stated_noise_is_that_of_simulated_records():
    """Means and first harmonics of 3000 records whose noise forgets itself in a second."""
    step, count, tau, sigma = 0.05, 800, 1.0, 0.02
    rng = np.random.default_rng(5)
    noise = np.empty((3000, count))
    noise[:, 0] = rng.normal(size=3000)
    keep = math.exp(-step / tau)
    for i in range(1, count):
        kick = rng.normal(size=3000)
        noise[:, i] = keep * noise[:, i - 1] + math.sqrt(1 - keep**2) * kick
    noise *= sigma * 50.0
    omega = 2 * math.pi * 4 / (count * step)
    C1 = 2 * noise @ np.cos(omega * step * np.arange(count)) / count
    piece = PlannedPiece(dynamic=True, early=False, speed=1.5, omega=omega, duration=count * step)
    told = stated_noise({"Y": 50.0}, sigma, tau)(piece)["Y"]
    assert told[0, 0] == pytest.approx(noise.mean(axis=1).var(), rel=0.12)
    assert told[1, 1] == pytest.approx(C1.var(), rel=0.12)


def test_noise_of_a_campaign_goes_to_longer_and_to_other_records():
    views = View.of(hidden_campaign("small", seed=1))
    noise = measured_noise(views)
    late = next(v for v in views if v.run.dynamic and not v.early)
    piece = PlannedPiece(dynamic=True, early=False, speed=1.5, omega=late.omega, duration=20.0)
    own = late.covariance["Y"]
    duration = (late.t[-1] - late.t[0]) * len(late.t) / (len(late.t) - 1)
    np.testing.assert_allclose(noise(piece)["Y"], own * duration / 20.0, rtol=1e-9)
    np.testing.assert_allclose(noise(replace(piece, duration=40.0))["Y"], noise(piece)["Y"] / 2)
    assert noise(replace(piece, speed=1.0))["Y"][0, 0] == noise(piece)["Y"][0, 0]
    assert noise(replace(piece, speed=3.0))["Y"][0, 0] == pytest.approx(
        16 * noise(piece)["Y"][0, 0]
    )


# What runs tell adds up


@pytest.mark.slow
@pytest.mark.parametrize("given", [(), ("memory", "even_hull_terms")])
def test_information_is_that_of_the_diagnosis_and_adds_up(given):
    """The Gram matrix of `build`, by other algebra; and one run after another."""
    views = View.of(hidden_campaign("small", {"asymmetry": 1.0}, seed=1))
    every = [item for item in captive_candidates() if not item.each_run]
    system = build(views, base(), every)
    scale = {c.name: c.scale for c in system.channels}
    forms = [form for item in every for form in item.forms]
    rows = rows_of(views, system.base, forms, floor=0.005, scatter=system.scatter, scale=scale)
    blocks = [block for name in given for block in best_blocks(system, name, 2)]
    rows = rows.condition_on(
        {name: [b.value for b in blocks if b.candidate.name == name] for name in given}
    )
    system = condition_on(system, blocks)
    ids = list(rows.of_run)
    whole, part = known(rows, ids).reduced(), known(rows, ids[:-1]).reduced()
    k = rows.width
    np.testing.assert_allclose(
        whole.normal.information, system.normal.information[:k, :k], rtol=1e-6, atol=1e-3
    )
    np.testing.assert_allclose(whole.normal.score, system.normal.score[:k], rtol=1e-5, atol=1e-3)
    columns = part.added(ids[-1])
    np.testing.assert_allclose(
        part.normal.information + columns.T @ columns,
        whole.normal.information,
        rtol=1e-6,
        atol=1e-6,
    )
    for channel, ours in part.precision(ids[-1]).items():
        np.testing.assert_allclose(ours, whole.precision()[channel], rtol=1e-4)


@pytest.mark.slow
def test_what_is_given_is_part_of_the_base_as_in_the_model_that_is_written_with_it():
    """Derivatives of an effect that was added are free: plan and diagnosis ask alike."""
    tests, coupling = hidden_campaign("small", seed=1), "yaw_sway_coupling"
    written = [*BASE, "Yvvr", "Yvrr", "Nvvr", "Nvrr"]
    added = ground_of(BASE, tests, given=(coupling,), limits=LIMITS)
    model = ground_of(written, tests, limits=LIMITS)
    assert coupling not in added.candidates
    assert set(added.candidates) == set(model.candidates) - {coupling}
    ours, theirs = (item.known().reduced() for item in (added, model))
    np.testing.assert_allclose(
        ours.normal.information, theirs.normal.information, rtol=1e-6, atol=1e-6
    )
    np.testing.assert_allclose(ours.normal.score, theirs.normal.score, rtol=1e-6, atol=1e-6)


def test_expected_odds_are_the_mean_of_the_log_of_the_ratio():
    """Rows drawn from what one rival predicts, weighed by both predictions."""
    from scipy.stats import multivariate_normal

    rng = np.random.default_rng(2)
    columns = rng.normal(size=(4, 3))
    one = Likely(
        share=1.0, places=np.array([0]), mean=np.array([1.5]), covariance=np.array([[0.3]])
    )
    two = Likely(
        share=1.0,
        places=np.array([1, 2]),
        mean=np.array([0.5, -1.0]),
        covariance=np.diag([0.5, 0.1]),
    )
    p, q = (multivariate_normal(*rival.predicted(columns)) for rival in (one, two))
    drawn = p.rvs(size=40000, random_state=rng)
    expected = np.mean(p.logpdf(drawn) - q.logpdf(drawn))
    found = expected_odds(columns, [[one], [two]])
    assert found[0, 1] == pytest.approx(expected, rel=0.03)
    assert np.isinf(found[0, 0])


# The next run, made in the tank


def slow_runs():
    """Two dozen options, so that a test is short."""
    shorter = LIMITS.with_(frequencies=(2.0, 5.0), tests=("static_drift", "pure_sway"))
    return [
        x
        for x in options_of(shorter.with_(speeds=(1.0, 1.5)), SHIP, WATER)
        if abs(x.settings.drift) != 0.25 * shorter.drift
    ]


def made(effect, seed, advice):
    best = advice.runs[0]
    added = [asked(best.option, number) for number in range(best.repeats)]
    campaign = hidden_campaign((*plans("small"), *added), {effect: 1.0}, seed=seed)
    return diagnose_captive(campaign, BASE)


@pytest.mark.slow
def test_the_advised_run_leaves_the_truth_alone():
    """Zero error or asymmetry, memory or amplitude: groups with one speed, one frequency."""
    resolved, gains = [], []
    for effect, seed in (("fault_gauge_zero", 21), ("asymmetry", 22), ("memory", 23)):
        campaign = hidden_campaign("small", {effect: 1.0}, seed=seed)
        before = diagnose_captive(campaign, BASE)
        if len(before.group) < 2:
            continue
        advice = next_runs(BASE, campaign, before, options=slow_runs())
        assert set(advice.wanted) >= {effect}
        after = made(effect, seed, advice)
        resolved.append([names for names, _ in after.group] == [(effect,)])
        lead = [{x.names: x.log_evidence for x in found.entries} for found in (before, after)]
        other = next(names for names, _ in before.group if names != (effect,))
        first, last = (x[effect,] - x[other] for x in lead)
        gains.append((advice.runs[0].gains[effect], last - first))
    assert len(resolved) >= 2
    assert sum(resolved) >= len(resolved) - 1
    expected, observed = np.array(gains).T
    assert (np.abs(observed - expected) < 6 * np.sqrt(2 * expected) + 0.7 * expected).all()
    assert observed.min() > 0


@pytest.mark.slow
def test_rivals_that_no_run_separates_get_a_check():
    """A turned model and a current at one speed, with drift runs at that speed alone."""
    campaign = hidden_campaign("small", {"fault_misalignment": 1.0}, seed=5)
    drift = options_of(RULER.with_(tests=("static_drift",)), SHIP, WATER)
    advice = next_runs(BASE, campaign, options=drift, effects=("fault_misalignment", "current"))
    assert not advice.runs or advice.runs[0].repeats > 1
    assert "180°" in advice.checks["fault_misalignment"]
    assert "180°" in advice.words


@pytest.mark.slow
def test_an_invisible_effect_is_shown_by_another_speed():
    campaign = hidden_campaign("small", seed=6)
    offered = [
        x
        for x in options_of(LIMITS.with_(frequencies=(2.0,)), SHIP, WATER)
        if x.test in ("resistance", "pure_sway")
    ]
    advice = next_runs(BASE, campaign, options=offered, effects=("froude_linear",))
    assert advice.wanted == ("froude_linear",)
    assert advice.runs
    assert {run.option.test for run in advice.runs} == {"pure_sway"}
    assert all(run.option.settings.speed != 1.5 for run in advice.runs)
    assert all(run.repeats == 2 for run in advice.runs)
    assert len(advice.options) == 2
    assert "at a new speed one run would decide alone" in advice.words


@pytest.mark.slow
def test_a_run_that_alone_decides_is_to_be_repeated():
    """A static run off by 15 N looks like products of drift and rudder; so would they."""
    campaign = hidden_campaign("small", {}, seed=3)
    data = campaign["DR_1.5_6_20"].data
    wrong = campaign["DR_1.5_6_20"].with_(loader=lambda: data.assign(Y=data["Y"] + 15.0))
    runs = tuple(wrong if run.id == wrong.id else run for run in campaign.runs)
    found = diagnose_captive(campaign.with_(runs=runs), BASE)
    assert found.verdict == "suspected"
    (suspect,) = found.suspected
    assert suspect.run == "DR_1.5_6_20"
    assert f"{suspect.effect} (run DR_1.5_6_20)" in repr(found)
    advice = next_runs(BASE, campaign.with_(runs=runs), found)
    best = advice.runs[0]
    assert best.option.settings.repeat_of == "DR_1.5_6_20"
    assert best.option.entry["repeat_of"] == "DR_1.5_6_20"
    assert best.option.id.endswith("_again")
    assert best.gain > 3.0
    assert "DR_1.5_6_20 again" in advice.words


@pytest.mark.slow
def test_what_is_asked_for_must_be_there():
    campaign = hidden_campaign("small", seed=6)
    with pytest.raises(UnknownNameError, match="nonsense"):
        next_runs(BASE, campaign, effects=("nonsense",), options=slow_runs()[:2])
    with pytest.raises(DataError, match="complete model"):
        next_runs(BASE, campaign.with_(kind="free-running"))
    with pytest.raises(DataError, match="model with values"):
        plan("cubic", limits=LIMITS)
    with pytest.raises(DataError, match="speeds"):
        plan("s175-3dof")


# Programmes


@pytest.mark.slow
def test_a_plan_shows_at_least_what_the_usual_programmes_show():
    """13 runs against `small`, 27 against `middle`: one plan, whose first runs are the shorter."""
    model = cubic_model()
    offered = options_of(LIMITS.with_(speeds=(1.5, 2.0), frequencies=(2.0, 5.0)), SHIP, WATER)
    programmes = {name: options(name, LIMITS) for name in ("small", "middle")}
    ground = ground_of(
        model, limits=LIMITS, options=[*offered, *programmes["small"], *programmes["middle"]]
    )
    made = plan(model, limits=LIMITS, runs=27, options=offered)
    for theirs in programmes.values():
        seen = sum(item.shown for item in sights(ground, [x.run().id for x in theirs]))
        assert made.steps[len(theirs) - 1].visible >= seen
    assert made.hours == pytest.approx(sum(option.hours for option in made.options))
    hidden = {item.name: item.why for item in made.invisible}
    assert {"fault_gauge_gain", "fault_moment_point", "fault_inertia"} <= set(hidden)
    assert "weight" in hidden["fault_moment_point"]
    assert max(np.unique([x.id for x in made.options], return_counts=True)[1]) <= 2


@pytest.mark.slow
def test_a_plan_keeps_to_its_hours_and_begins_with_what_is_made():
    campaign = hidden_campaign("small", seed=7)
    few = [x for x in slow_runs() if x.settings.speed == 1.0]
    made = plan(BASE, campaign, hours=0.5, options=few, effects=("froude_linear",))
    assert made.made == 13
    assert 0 < made.hours <= 0.5
    assert "crossflow_drag" in made.before
    assert "froude_linear" not in made.before
    assert "froude_linear" in {name for step in made.steps for name in step.shown}


# Limits and files


def test_limits_come_from_what_the_campaign_has_done():
    limits = Limits.of(hidden_campaign("small"))
    assert limits.speeds == (1.0, 1.5, 2.0)
    assert math.degrees(limits.rudder) == pytest.approx(20.0)
    assert limits.heel == 0.0
    campaign = hidden_campaign("small")
    runs = [
        run.with_(settings=replace(run.settings, speed=1.0 + 0.1 * i))
        for i, run in enumerate(campaign.runs)
    ]
    many = Limits.of(campaign.with_(runs=tuple(runs)))
    assert many.speeds == (1.0, 1.3, 1.6, 1.9, 2.2)
    assert limits.yaw == pytest.approx(0.25)
    for option in options_of(limits, SHIP, WATER):
        s = option.settings
        assert abs(s.yaw_amplitude or 0.0) <= limits.yaw * 1.001
        assert (s.amplitude or 0.0) <= limits.sway * 1.001
        assert (s.omega or 0.0) * s.speed / WATER.g <= 0.25


def test_a_short_tank_has_room_for_few_cycles_and_a_narrow_one_for_small_amplitudes():
    settings = Settings(speed=1.5, period=10.0, amplitude=0.3)
    long, short = (LIMITS.with_(tank_length=length) for length in (100.0, 50.0))
    assert timed("pure_sway", settings, long, SHIP).cycles == 4
    assert timed("pure_sway", settings, short, SHIP).cycles == 3
    assert timed("pure_sway", settings, LIMITS.with_(tank_length=40.0), SHIP) is None
    narrow = options_of(LIMITS.with_(tank_width=3.0), SHIP, WATER)
    assert max(x.settings.amplitude or 0.0 for x in narrow) <= 1.5 - 1.5 * SHIP.B
    four = timed("pure_sway", settings, long, SHIP)
    assert four.hours == pytest.approx((40.0 + 720.0) / 3600.0)


def test_planned_runs_are_entries_of_a_campaign_file():
    every = options_of(LIMITS, SHIP, WATER)
    text = entries_text([*every, every[0]])
    entries = tomllib.loads(text)["runs"]
    assert len(entries) == len(every) + 1
    for option, entry in zip(every, entries, strict=False):
        read = RunEntry(**entry)
        assert read.speed == pytest.approx(option.settings.speed)
        assert math.radians(read.drift_deg or 0.0) == pytest.approx(option.settings.drift, abs=1e-5)
    assert entries[-1]["repeat_of"] == entries[0]["id"]
    assert len({entry["id"] for entry in entries}) == len(entries)


def test_a_rudder_that_swings_can_be_planned(tmp_path):
    file = tmp_path / "plan.toml"
    text = (
        '[[runs]]\ntest = "harmonic_rudder"\nspeed = 1.0\nperiod = 10.0\ndrift_deg = 4.0\n'
        "rudder_amplitude_deg = 30.0\n"
    )
    file.write_text(text, encoding="utf-8")
    _, (option,) = read_plan_file(file, SHIP, LIMITS)
    assert "rudder amplitude 30°" in option.words
    assert option.entry["rudder_amplitude_deg"] == pytest.approx(30.0)
    file.write_text(text.replace("rudder_", "yaw_"), encoding="utf-8")
    with pytest.raises(CampaignError, match="needs the setting rudder_amplitude"):
        read_plan_file(file, SHIP, LIMITS)


def test_runs_on_a_circle_can_be_planned_and_are_told_apart(tmp_path):
    file = tmp_path / "plan.toml"
    head = '[[runs]]\ntest = "circular_motion"\nspeed = 1.0\n'
    file.write_text(
        "".join(head + x for x in ("yaw_rate = 0.1\n", "yaw_rate = -0.2\n", "radius = 5.0\n"))
    )
    _, found = read_plan_file(file, SHIP, LIMITS)
    entries = tomllib.loads(entries_text(found))["runs"]
    assert [(x.get("yaw_rate"), x.get("radius")) for x in entries] == [
        (0.1, None),
        (-0.2, None),
        (None, 5.0),
    ]
    assert len({option.id for option in found}) == len({option.words for option in found}) == 3
    file.write_text(entries_text(found), encoding="utf-8")
    assert read_plan_file(file, SHIP, LIMITS)[1] == found


def test_a_damaged_plan_file_names_everything_at_once(tmp_path):
    file = tmp_path / "plan.toml"
    file.write_text(
        '[limits]\nspeeds = "fast"\ndepth = 3\n[[runs]]\ntest = "swim"\nspeed = 1.0\n'
        '[[runs]]\ntest = "pure_sway"\nspeed = 1.0\n[[runs]]\ntest = "static_drift"\nspeed = true\n'
    )
    with pytest.raises(CampaignError) as caught:
        read_plan_file(file, SHIP, LIMITS)
    text = str(caught.value)
    for word in ("'fast'", "'depth'", "'swim'", "period", "amplitude", "True"):
        assert word in text
    with pytest.raises(CampaignError, match="negative"):
        LIMITS.with_(drift=-1.0)
    with pytest.raises(CampaignError, match="no limit"):
        LIMITS.with_(colour=1.0)


# The command


def test_the_command_plans_before_any_test(tmp_path, capsys):
    """A campaign file without runs gives ship and water, a plan file limits and runs."""
    (tmp_path / "campaign.toml").write_text(
        "[campaign]\ntitle = 'Soon'\n[ship]\nname = 'S175 model'\nL = 4.861111\nB = 0.705556\n"
        "d = 0.236111\nmass = 454.476\nIzz = 618.332\nvolume = 0.454861\n[water]\nrho = 999.1\n"
    )
    listed = [option for option in options("small", LIMITS) if option.test != "sway_yaw"]
    (tmp_path / "limits.toml").write_text("[limits]\nwait_min = 6\n" + entries_text(listed))
    status = main(
        [
            "plan",
            "s175-3dof",
            str(tmp_path),
            "--limits",
            str(tmp_path / "limits.toml"),
            "--runs",
            "4",
            "--out",
            str(tmp_path / "out"),
            "--json",
        ]
    )
    said = SimpleNamespace(**json.loads(capsys.readouterr().out))
    assert status == 0
    assert said.made == 0
    assert 1 <= len(said.steps) <= 4
    assert said.steps[0]["duration_h"] < 0.12
    assert sorted(said.files) == ["plan.csv", "plan.toml"]
    entries = tomllib.loads((tmp_path / "out" / "plan.toml").read_text())["runs"]
    assert [entry["id"] for entry in entries] == [step["id"] for step in said.steps]
    wanted = {option.id for option in listed}
    assert {entry["id"] for entry in entries} <= wanted


def test_runs_without_a_force_say_nothing_of_the_noise():
    settings = Settings(speed=1.5, rudder=math.radians(20))
    option = timed("static_rudder", settings, LIMITS, SHIP)
    with pytest.raises(DataError, match=r"no Y and no N in any of these runs"):
        plan(cubic_model(), limits=LIMITS, options=[option])
