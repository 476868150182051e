"""What the page shows of free-running records before anything is added is what adding does."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

import pmmkit as pk
from pmmkit import Run
from pmmkit.campaigns import Settings
from pmmkit.identification import Prior
from pmmkit.simulation import Bands
from pmmkit.validation import FreeRun
from pmmkit.views import page_of
from pmmkit.views.pages.records import record_page
from tests.support.zigzags import ASYMMETRY, KNOWN, SENSORS, SHIP, SPEED, sailed

pytestmark = pytest.mark.slow
EVEN = pk.own_effect("even", "Y: 1; N: 1; Y0 ~ 0.002; N0 ~ 0.001")
"""The asymmetry that the model lacks, under another name."""
SINKS = pk.own_effect("sinks", "Y: b*sinkage*v; b ~ -0.002")
QUICK = pk.own_effect("quick", "Y: b*Fn*v; b ~ -0.002")


@pytest.fixture(scope="module")
def records():
    return sailed(ASYMMETRY, 5)


@pytest.fixture(scope="module")
def session(records):
    return pk.begin(
        SHIP,
        records,
        candidates=("asymmetry", "fault_rudder_zero", "even"),
        own=(EVEN, SINKS, QUICK),
        prior=Prior.of(SHIP, KNOWN, SPEED, spread=0.02),
        sensors=SENSORS,
        most=1,
    )


@pytest.fixture(scope="module")
def found(session):
    return session.diagnose()


@pytest.fixture(scope="module")
def page(session, found):
    return page_of(found, session)


def shares(page):
    return {item["effect"]: item["share"] for item in page["candidates"]}


def test_what_was_fitted_stands_before_what_the_linear_problem_promises(session, page):
    fitted = {x for item in session.evidence.contest(()).settled for x in item.names}
    shown = [item["effect"] for item in page["candidates"]]
    assert set(shown[: len(fitted)]) == fitted


def test_each_share_is_how_the_errors_of_records_left_out_fall(session, page):
    told = shares(page)
    assert set(told) == {"asymmetry", "fault_rudder_zero", "even"}
    fall = session.add("asymmetry").fall()
    for kind, share in told["asymmetry"]["channels"].items():
        before, after = fall.errors(kind)
        assert share == pytest.approx(1 - (after / before) ** 2, abs=0.03)
    assert 0.3 < told["asymmetry"]["all"] < 1.0


def test_an_overlay_goes_where_the_measured_record_goes(page, records):
    """Within a degree from begin to end, where the base is off by ten."""
    for record in records:
        base, own = page["base"][record.name], page["overlays"]["asymmetry"][record.name]
        measured = np.degrees(np.interp(base["t"], record.t, record.measured["psi"]))
        off = [np.sqrt(np.mean((np.array(x["psi"]) - measured) ** 2)) for x in (base, own)]
        assert off[1] < 1.0 < 8.0 < off[0]
        assert len(own["x"]) == len(base["t"])
    json.dumps(page, allow_nan=False)


def test_an_effect_of_ones_own_is_a_candidate_of_records(session, page):
    told = shares(page)
    assert told["even"]["all"] == pytest.approx(told["asymmetry"]["all"], abs=0.02)
    assert session.add("even").model().parts["hull_polynomial"].values["Y0"] > 0.0


def test_what_records_cannot_be_asked_for_is_said_with_the_reason(page):
    assert page["unasked"] == [
        {"effect": "sinks", "why": "these records lack measured sinkage"},
        {
            "effect": "quick",
            "why": "these records lack runs at two speeds or more: sail at a second speed",
        },
    ]


def test_the_ships_that_records_accept_are_the_sets_that_were_named(session, found):
    names, odds = found.group[0]
    ship = session.evidence.rival((), names)
    for part, own in found.model.parts.items():
        assert ship.parts[part].values == pytest.approx(own.values), part
    assert {"Y0", "N0"} <= set(ship.covariance_names)
    band = Bands.of(SHIP, rudder_deg=35, speed=SPEED, n=8, compiled=False, among=[(ship, odds)])
    there = pk.simulate(ship, rudder_deg=35, speed=SPEED, compiled=False)
    low, high = band.measures["tactical_diameter_L"]
    assert low < there.metrics["tactical_diameter_L"] < high


def test_a_motion_that_grows_without_bound_is_drawn_as_far_as_it_is_one():
    """A doubling a second from 1 m/s on: 5 times the greatest measured speed is passed at 2.3 s."""
    t = np.arange(0.0, 2000.0, 0.1)
    still = {name: np.zeros_like(t) for name in ("x", "y", "psi", "v", "r")}
    with np.errstate(over="ignore"):
        fast = np.exp2(t)
    record = FreeRun(
        name="lost", run=Run(id="lost", test="turning", settings=Settings(speed=1.0),
                             kind="history", loader=None),
        t=t, delta=still["y"], measured={**still, "u": np.ones_like(t)},
        predicted={**still, "u": fast}, std={**still, "u": np.ones_like(t)},
        predicted_std={**still, "u": still["y"]},
        force={}, Fn=0.1, force_std={}, force_predicted={}, window=math.nan, window_errors={},
    )  # fmt: skip
    shown = record_page(record, 1.0, 0.0)["motion"]
    for name, own in shown.items():
        told = [x for x in own["predicted"] if x is not None]
        assert len(told) == 1, f"{name}: samples are 4 s apart"
        assert None not in own["measured"]


def test_the_band_of_a_record_is_the_uncertainty_that_its_errors_are_judged_by():
    t = np.linspace(0.0, 10.0, 101)
    rng = np.random.default_rng(3)
    wave = {name: np.sin(t) for name in ("x", "y", "psi", "u", "v", "r")}
    size = {name: 0.01 + 0.1 * rng.random(t.size) for name in wave}
    record = FreeRun(
        name="zz", run=Run(id="zz", test="zigzag", settings=Settings(speed=1.0),
                           kind="history", loader=None),
        t=t, delta=0.1 * np.sin(t), measured=wave, predicted={k: 1.1 * x for k, x in wave.items()},
        std=size, predicted_std={k: 20.0 * x for k, x in size.items()},
        force={"Y": 3.0 * np.sin(t)}, force_predicted={"Y": 2.0 * np.sin(t)},
        force_std={"Y": 0.1 + rng.random(t.size)}, Fn=0.1, window=math.nan, window_errors={},
    )  # fmt: skip
    page, judged = record_page(record, 5.0, 0.3), record.errors(0.3)
    shown = {name: np.array(own["uncertainty"]) for name, own in page["motion"].items()}
    assert shown["psi"] == pytest.approx(judged["heading"].uncertainty, rel=1e-4)
    assert shown["r"] == pytest.approx(judged["yaw_rate"].uncertainty, rel=1e-4)
    assert shown["x"] == pytest.approx(judged["position"].uncertainty[0] / 5.0, rel=1e-4)
    # The speed has the slopes u/U and v/U over the velocities, here alike; at rest it has none.
    moves = np.abs(wave["u"]) > 0.0
    speed = np.hypot(shown["u"], shown["v"])[moves] / np.sqrt(2.0)
    assert speed == pytest.approx(judged["speed"].uncertainty[moves], rel=1e-4)
    force = np.array(page["forces"]["Y"]["uncertainty"])
    assert force == pytest.approx(judged["Y"].uncertainty, rel=1e-4)
