"""The next manoeuvre: closed forms, what is refused, and the tank, which shares no code."""

from __future__ import annotations

import json
import math
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pmmkit import FreeRecord, Limits, next_runs
from pmmkit.base import DataError, UnknownNameError
from pmmkit.campaigns.file.schema import RunEntry
from pmmkit.cli import main
from pmmkit.diagnosis.free_running.diagnose import free_system
from pmmkit.diagnosis.planning.free_offer import free_offer
from pmmkit.diagnosis.planning.manoeuvres import captive_tests
from pmmkit.diagnosis.planning.options import options_of
from pmmkit.diagnosis.planning.plan_file import entries_text
from pmmkit.diagnosis.planning.planned_records import COURSES, free_options, planned_record, sea_of
from pmmkit.diagnosis.planning.separation import Likely, expected_odds
from pmmkit.models import load_model
from pmmkit.simulation import simulate
from scripts.studies.next_manoeuvre import looped, made, ordered
from tests.support.free_tank import cases
from tests.support.free_tank.campaigns import Setup, hidden_in, write
from tests.support.free_tank.sailing import Order, sail
from tests.support.free_tank.sensors import recorded

SETUP = Setup(case="sway_drag", size=0.3, runs=3, seed=2, ship="kvlcc2-l7")
"""Three records of two ship lengths that leave two rivals."""
SAMPLES = 150
S175 = Path(__file__).parents[2] / "datasets" / "s175"
FEW = ("modulus_sway_drag", "crossflow_drag", "asymmetry", "current")
LIMITS = Limits(speeds=(1.1,), rudder=math.radians(20.0))


@pytest.fixture(scope="module")
def records():
    return made(SETUP, ordered(SETUP, SAMPLES), 0)


@pytest.fixture(scope="module")
def system(records):
    return free_system(load_model("kvlcc2-l7"), records, candidates=FEW)


def offered(system, options, **settings):
    return free_offer(system, (), options, wait=720.0, tell=lambda _: None, **settings)


@pytest.fixture(scope="module")
def offer(system):
    zigzags = [x for x in free_options(LIMITS, 7.0) if x.test in ("zigzag", "straight")]
    return offered(system, zigzags)


# The tank: what is promised comes


@pytest.mark.slow
def test_the_advised_manoeuvre_gains_about_what_it_promises_and_more_than_the_last():
    """One record of the tank scatters by the root of twice the expected gain."""
    loop = looped(SETUP, SAMPLES, FEW)
    assert {names for names, _ in loop.before.group} == {(name,) for name in FEW[:2]}
    best, last = loop.trials
    for trial in loop.trials:
        assert trial.came > 0.0
        assert abs(trial.came - trial.run.gain) < 3.0 * math.sqrt(2.0 * trial.run.gain)
    assert best.came > last.came
    assert best.run.resolves > 0.95
    assert [names for names, _ in best.after.group] == [("modulus_sway_drag",)]


FLOWING = Setup(case="current", size=0.02, runs=3, seed=1, ship="kvlcc2-l7")


def on_course(course):
    """A zigzag of the tank on another course: the current turned against it, then the record."""
    ahead, aside = math.cos(course), math.sin(course)
    fleet, hidden = FLOWING.fleet, hidden_in(FLOWING)
    north, east = hidden.current
    seen = replace(hidden, current=(north * ahead + east * aside, east * ahead - north * aside))
    angle = math.radians(20.0)
    order = Order(rudder=angle, switch=angle, speed=1.1, seconds=80.0)
    (run,) = sail(fleet.build(seen), [order], fleet.step)
    every = round(fleet.interval / fleet.step)
    found = recorded(run, seen, fleet.noise, every, np.random.default_rng(4))
    x, y = found["x"], found["y"]
    turned = {"x": x * ahead - y * aside, "y": x * aside + y * ahead, "psi": found["psi"] + course}
    return FreeRecord(
        name="turned", t=found["t"], delta=found["delta"], turns=found["n"], speed=1.1,
        measured=turned | {name: found[name] for name in ("u", "v", "r")},
    )  # fmt: skip


@pytest.mark.slow
def test_the_opposite_course_tells_a_current_from_a_crooked_hull_better():
    """As it promises; on the course of the records a zigzag gains less."""
    rivals = [("current",), ("asymmetry",)]
    records = made(FLOWING, ordered(FLOWING, SAMPLES), 0)
    model = load_model("kvlcc2-l7")

    def ahead(*more):
        asked = free_system(model, [*records, *more], candidates=FEW)
        own, other = (asked.fit(names).log_probability for names in rivals)
        return own - other

    options = [
        x
        for x in free_options(LIMITS, 7.0, courses=COURSES[:3:2])
        if x.test == "zigzag" and x.settings.rudder > 0.3
    ]
    plain, turned = options
    system = free_system(model, records, candidates=FEW)
    offer = offered(system, options, rivals=("current", "asymmetry"))
    sets = [offer.likely(names) for names in rivals]
    promised = {x.id: expected_odds(offer.added(x.id, 1), sets)[0, 1] for x in options}
    before = ahead()
    came = {x.id: ahead(on_course(x.course)) - before for x in options}
    assert promised[turned.id] > promised[plain.id]
    assert came[turned.id] > came[plain.id]
    for name, gain in promised.items():
        assert abs(came[name] - gain) < 3.0 * math.sqrt(2.0 * gain)


# Closed forms and properties


@pytest.mark.slow
def test_two_sharp_rivals_are_apart_by_the_information_between_them(offer):
    """Without any uncertainty left the gain is half the squared distance, in noise."""
    name = next(iter(offer.options))
    P = offer.products[name]
    rng = np.random.default_rng(3)
    places = np.arange(len(P))
    points = 1e-3 * rng.normal(size=(2, len(P)))
    none = np.zeros_like(P)
    sets = [(Likely(share=1.0, places=places, mean=z, covariance=none),) for z in points]
    gained = expected_odds(offer.added(name, 1), sets)
    away = points[0] - points[1]
    assert gained[0, 1] == pytest.approx(0.5 * away @ P @ away, rel=1e-6)
    assert expected_odds(offer.added(name, 3), sets)[0, 1] == pytest.approx(3 * gained[0, 1])


@pytest.mark.slow
def test_what_a_manoeuvre_tells_is_never_less_than_nothing(offer):
    before = offer.signals()
    for name in offer.options:
        assert np.linalg.eigvalsh(offer.products[name]).min() > -1e-6 * offer.products[name].max()
        once, thrice = offer.signals(name), offer.signals(name, 3)
        assert np.all(once >= before * (1.0 - 1e-9))
        assert np.all(thrice >= once * (1.0 - 1e-9))


@pytest.mark.slow
def test_shares_of_the_spreads_of_the_base_add_up(offer):
    for names in (("asymmetry",), ("modulus_sway_drag", "asymmetry"), ()):
        found = offer.likely(names)
        assert sum(item.share for item in found) == pytest.approx(1.0)
        for item in found:
            assert np.linalg.eigvalsh(item.covariance).min() > -1e-9


@pytest.mark.slow
def test_other_courses_are_offered_where_they_tell_more(system):
    """In a calm without current all courses tell the same; a current makes the difference."""
    turns = [
        x
        for x in free_options(LIMITS, 7.0, courses=COURSES[:3:2])
        if x.test == "zigzag" and x.settings.rudder > 0.3
    ]
    assert len(turns) == 2
    calm = offered(system, turns, rivals=("asymmetry", "modulus_sway_drag"))
    assert [x.course for x in calm.options.values()] == [0.0]
    flowing = offered(system, turns, rivals=("asymmetry", "current"))
    assert len(flowing.options) == 2


@pytest.mark.slow
def test_a_planned_record_is_the_track_that_the_model_sails(system, records):
    option = next(x for x in free_options(LIMITS, 7.0) if x.test == "zigzag")
    sea = sea_of(system, system.fit(()))
    found = planned_record(sea, option)
    used = system.question.stretches[0].record
    assert set(found.measured) == set(used.measured)
    assert np.diff(found.t).mean() == pytest.approx(np.median(np.diff(used.t)), rel=0.01)
    track = simulate(
        sea.model, "zigzag", speed=1.1, rudder_deg=20.0, switch_deg=20.0,
        dt=float(np.median(np.diff(used.t))), compiled=False, extrapolate=True,
    )  # fmt: skip
    first = sea.like(1.1).measured["psi"][0]
    np.testing.assert_allclose(found.measured["psi"] - first, track.psi, atol=1e-9)
    np.testing.assert_allclose(found.delta, track.delta, atol=1e-9)
    turned = planned_record(sea, replace(option, course=math.pi))
    np.testing.assert_allclose(turned.measured["x"], -found.measured["x"], atol=1e-6)


def test_options_go_to_both_sides_within_the_rudder_and_are_entries_of_a_campaign_file():
    every = free_options(LIMITS, 7.0, courses=COURSES)
    assert len({x.id for x in every}) == len(every)
    for option in every:
        assert abs(option.settings.rudder) <= LIMITS.rudder * 1.001
    sides = [math.copysign(1.0, x.settings.rudder) for x in every if x.test == "turning"]
    assert sum(sides) == 0
    for option, entry in zip(every, tomllib.loads(entries_text(every))["runs"], strict=True):
        read = RunEntry(**entry)
        assert math.radians(read.rudder_deg or 0.0) == pytest.approx(option.settings.rudder)
        assert (read.switch_deg is None) == (option.test != "zigzag")
    ready = every[0].lasting(100.0, 720.0, 0.1)
    assert ready.hours == pytest.approx((100.0 + 100.0 + 720.0) / 3600.0)


def test_speeds_are_those_of_the_records(records):
    model = load_model("kvlcc2-l7")
    assert Limits.of_records(model, records).speeds == tuple(sorted({x.speed for x in records}))
    one = [x.with_(speed=1.2) for x in records]
    assert Limits.of_records(model, one).speeds == (0.8, 1.2)
    drifting = [*one, one[0].with_(speed=0.05)]
    assert Limits.of_records(model, drifting).speeds == (0.8, 1.2)
    many = [records[0].with_(speed=x) for x in (0.8, 0.9, 1.0, 1.1, 1.2)]
    assert Limits.of_records(model, many).speeds == (0.8, 1.0, 1.2)


# Where the records leave nothing to tell apart, or no manoeuvre does


@pytest.mark.slow
def test_effects_that_are_named_are_told_apart_at_their_usual_sizes(records):
    limits = replace(LIMITS, speeds=(1.1, 1.179))
    found = next_runs(
        "kvlcc2-l7", records, effects=FEW[:2], limits=limits, candidates=FEW, most=1000
    )
    assert found.rivals == FEW[:2]
    assert all(item.gain >= 3.0 for item in found.runs)
    per_hour = [item.resolves / item.hours for item in found.runs]
    assert per_hour == sorted(per_hour, reverse=True)


@pytest.mark.slow
def test_where_no_manoeuvre_tells_rivals_apart_captive_tests_are_planned(records):
    """With the rudder amidships a ship that goes straight says nothing of drag in sway."""
    found = next_runs(
        "kvlcc2-l7", records, effects=FEW[:2], limits=replace(LIMITS, rudder=0.0), candidates=FEW
    )
    assert found.runs == ()
    assert found.captive is not None
    assert found.options == found.captive.options
    assert found.notes[-1] == "Captive tests are those of a model of 6 m."
    assert "captive tests that settle modulus_sway_drag and crossflow_drag" in found.words


@pytest.mark.slow
def test_captive_tests_of_a_large_ship_are_those_of_a_model_of_her():
    ship = load_model("s175")
    made = captive_tests(ship, ["asymmetry"], Limits(speeds=(7.0,), rudder=0.5))
    assert made is not None
    speeds = [step.option.settings.speed for step in made.steps]
    assert speeds == pytest.approx([7.0 * math.sqrt(6.0 / 175.0)] * len(speeds))
    assert captive_tests(ship, ["wind"], Limits(speeds=(7.0,))) is None


def test_what_cannot_be_planned_is_refused_with_a_way_out(records):
    ship = load_model("kvlcc2-l7")
    captive = options_of(Limits(speeds=(1.0,)), ship.ship, ship.water)
    with pytest.raises(DataError, match="at least two"):
        next_runs("kvlcc2-l7", records[:1], candidates=FEW)
    with pytest.raises(DataError, match="captive tests"):
        next_runs(ship, records, options=captive, candidates=FEW)
    with pytest.raises(UnknownNameError, match="wind"):
        next_runs("kvlcc2-l7", records, effects=["wind"], candidates=FEW)
    with pytest.raises(DataError, match="complete model"):
        next_runs("cubic", records)


# The command


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Records of thirteen ship lengths with a current hidden in them."""
    with pytest.MonkeyPatch.context() as patch:
        fleet = cases.FLEETS["kvlcc2-l7"]
        patch.setitem(cases.FLEETS, "kvlcc2-l7", replace(fleet, turn=95.0, zigzag=95.0))
        return write(
            Setup(case="current", runs=3, seed=1, ship="kvlcc2-l7"),
            tmp_path_factory.mktemp("records"),
        )


@pytest.mark.slow
def test_the_command_names_manoeuvres_of_records(folder, tmp_path, capsys):
    status = main(
        ["plan", "kvlcc2-l7", str(folder), "--for", "current,asymmetry", "--channels",
         "x,y,psi,u,v,r", "--speeds", "1.1", "--out", str(tmp_path / "out"), "--json"]
    )  # fmt: skip
    said = capsys.readouterr()
    found = json.loads(said.out)
    assert status == 0
    assert found["rivals"] == ["current", "asymmetry"]
    assert "What" in said.err
    assert found["notes"] == [
        "Hours are those of the record, of a run-up of 10 ship lengths, and 12 min to the next run."
    ]
    assert all(run["hours"] > 0.2 for run in found["runs"])
    entries = tomllib.loads((tmp_path / "out" / "plan.toml").read_text())["runs"]
    assert entries[0]["id"] == found["runs"][0]["id"]


def test_the_command_refuses_what_belongs_to_the_other_kind_of_tests(folder, capsys):
    assert main(["plan", "kvlcc2-l7", str(folder), "--runs", "4"]) == 1
    assert "Leave out --runs" in capsys.readouterr().err
    assert main(["plan", "cubic", str(folder)]) == 1
    assert "complete model" in capsys.readouterr().err
    assert main(["plan", "cubic", str(S175), "--channels", "x,y"]) == 1
    assert "no use for captive tests" in capsys.readouterr().err
