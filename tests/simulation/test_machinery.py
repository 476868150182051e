"""The engine in a stop: what is stated, what is assumed, and one stop wherever it is asked for."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from types import MappingProxyType, SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import pmmkit as pk
from pmmkit.base import DataError
from pmmkit.conventions import METRICS
from pmmkit.effects.four_quadrant import b4_70
from pmmkit.imo import FullAstern, judged
from pmmkit.imo.verdict import reached
from pmmkit.models import Part, Standing
from pmmkit.simulation import machinery
from pmmkit.simulation.machinery import ENGINE, as_it_reverses, torque_of

SPEED = 7.97
PITCH = 0.721


def astern_tanker():
    """KVLCC2 with a propeller of the series B4-70, which turns astern too and has a torque."""
    model = pk.load_model("kvlcc2")
    own = model.part("propeller").values
    propeller = Part(
        effect="four_quadrant_propeller",
        values=MappingProxyType({"D": own["D"], "t": own["t"], "wp": own["wp"], "pitch": PITCH}),
        options=MappingProxyType({"characteristics": "b4-70"}),
    )
    parts = {name: part for name, part in model.parts.items() if name != "propeller"}
    return model.with_(parts=MappingProxyType({**parts, propeller.effect: propeller}))


def stop(model, **given):
    return pk.imo_verdicts(model, SPEED, n=0, compiled=False, **given)[-1]


# Time to reverse


@pytest.mark.parametrize("seconds", [5.0, 60.0, 300.0])
def test_revolutions_fall_on_a_line_to_those_ordered_in_the_time_that_is_stated(seconds):
    track = pk.simulate(
        astern_tanker(), "stopping", speed=SPEED, turns=-0.6, reversal_s=seconds, compiled=False
    )
    line = np.maximum(1.0 - 1.6 * track.t / seconds, -0.6)
    assert track.n / track.n[0] == pytest.approx(line, abs=1e-9)
    # 2 % of the approach's revolutions before the end of the ramp, to a sample
    found = FullAstern.of_a_stop(track.t, track.n, track.n[0])
    assert found.turns == pytest.approx(-0.6)
    assert found.reversal_s == pytest.approx(
        seconds * 1.58 / 1.6, abs=1.01 * np.diff(track.t).max()
    )


def test_who_reverses_later_stops_later():
    stops = [
        pk.simulate(astern_tanker(), "stopping", speed=SPEED, reversal_s=x, compiled=False)
        for x in (5.0, 60.0, 300.0)
    ]
    reach = [track.metrics["track_reach"] for track in stops]
    assert all(before < after for before, after in pairwise(reach))


def test_what_is_stated_of_the_engine_is_not_assumed():
    verdict = stop(astern_tanker(), astern=-0.8, reversal=60.0)
    engine = verdict.full_astern
    assert (engine.turns, engine.measured, engine.torque) == (-0.8, False, None)
    assert engine.assumed == "Assumed: thrust deduction astern 0.22 ± 0.2."
    assert verdict.value < verdict.limit
    assert "of the approach's revolutions, reached 60 s after the order" in str(verdict)
    told = astern_tanker().with_values("four_quadrant_propeller", t_astern=0.1)
    assert stop(told, astern=-0.8, reversal=60.0).full_astern.assumed == ""


@given(turns=st.floats(-1.0, -0.1), rate=st.floats(0.005, 0.2))
def test_a_recorded_reversal_is_found(turns, rate):
    t = np.arange(0.0, 900.0, 1.0)
    n = 1.2 * np.maximum(1.0 - rate * t, turns)
    found = FullAstern.of_a_stop(t, n, 1.2)
    assert found.measured
    assert found.turns == pytest.approx(turns, abs=0.02 + rate)
    assert found.reversal_s == pytest.approx((1.0 - turns) / rate, abs=0.04 / rate + 2.0)


def test_a_propeller_that_only_stands_was_never_astern():
    t = np.arange(50.0)
    assert FullAstern.of_a_stop(t, np.maximum(1.0 - 0.1 * t, 0.0), 1.0) is None
    assert np.isnan(reached(t, np.maximum(1.0 - 0.1 * t, 0.0), 1.0, -0.6))


# Torque


def test_the_torque_of_the_approach_is_that_of_the_propeller_series():
    """CQ over ½ρ(VA² + (0.7πnD)²)πD³/4 at the advance angle of self-propulsion."""
    model = astern_tanker()
    own = model.part("four_quadrant_propeller").values
    n = pk.simulate(model, "stopping", speed=SPEED, compiled=False).n[0]
    inflow, tip = (1.0 - own["wp"]) * SPEED, 0.7 * np.pi * n * own["D"]
    _, twist = b4_70(np.arctan2(inflow, tip), PITCH)
    square = inflow**2 + tip**2
    torque = 0.5 * model.water.rho * square * np.pi / 4.0 * own["D"] ** 3 * twist
    assert torque_of(model, SPEED) == pytest.approx(torque, rel=1e-9)


@pytest.mark.slow
def test_less_torque_never_stops_a_ship_sooner():
    free = stop(astern_tanker(), reversal=100.0)
    found = [stop(astern_tanker(), reversal=100.0, torque=x) for x in (5.0, 0.4, 0.2)]
    reach = [free.value, *(item.value for item in found)]
    assert all(before <= after for before, after in pairwise(reach))
    # with torque enough nothing is left but the lag of the governor, a fifth of a ship length
    assert reach[1] - reach[0] == pytest.approx(machinery.GOVERNOR, rel=0.3)
    assert np.isnan(found[-1].full_astern.reversal_s)
    assert -0.7 < found[-1].full_astern.most < -0.3
    assert "never reached" in str(found[-1])


def test_the_limited_torque_is_not_exceeded_along_the_stop():
    model = astern_tanker()
    own = model.part("four_quadrant_propeller").values
    track = pk.simulate(model, "stopping", speed=SPEED, torque=0.3, reversal_s=10.0, compiled=False)
    late = track.t > 100.0  # steady: what the engine gives is what the water takes
    wake = np.where(track.n < 0.0, 0.0, own["wp"])
    inflow, tip = (1.0 - wake) * track.u, 0.7 * np.pi * track.n * own["D"]
    twist = np.array([b4_70(x, PITCH)[1] for x in np.arctan2(inflow, tip)])
    torque = 0.5 * model.water.rho * (inflow**2 + tip**2) * np.pi / 4.0 * own["D"] ** 3 * twist
    # the friction takes the rest, and less of it while the shaft is slow
    least, most = (x * torque_of(model, SPEED) for x in (0.3 - ENGINE["friction"].mean, 0.3))
    assert least < -torque[late].min() < most


@pytest.mark.slow
@pytest.mark.parametrize("constant", ["SPIN", "GOVERNOR", "FADING"])
@pytest.mark.parametrize("times", [0.5, 2.0])
def test_what_is_fixed_of_an_assumed_engine_hardly_counts(monkeypatch, constant, times):
    def reach():
        machinery._with_engine.cache_clear()
        track = pk.simulate(astern_tanker(), "stopping", speed=SPEED, compiled=False)
        return track.metrics["track_reach_L"]

    usual = reach()
    monkeypatch.setattr(machinery, constant, times * getattr(machinery, constant))
    assert reach() == pytest.approx(usual, rel=0.04)
    machinery._with_engine.cache_clear()


def test_a_torque_that_is_not_known_cannot_be_limited():
    with pytest.raises(DataError, match=r"has a part shaft_lag, which says how its engine"):
        stop("esso190k", torque=0.8)
    with pytest.raises(DataError, match="does not know the torque"):
        machinery._with_engine(pk.load_model("kvlcc2"), SPEED, 0.8, False, False)


# An engine that nobody states


def test_the_engine_waits_until_the_water_drives_the_shaft_no_faster_than_starting_air_can_stop():
    """Before that it gives nothing: the water drives the shaft against the friction alone."""
    model = astern_tanker()
    track = pk.simulate(model, "stopping", speed=SPEED, dt=0.5, compiled=False)
    own, n0 = model.part("four_quadrant_propeller").values, track.n[0]
    begins = ENGINE["reverse_below"].mean * n0
    waits = int(np.argmax(track.n < begins))
    assert np.all(np.diff(track.n[:waits]) <= 0.0)
    at = waits - 2
    inflow, tip = (1.0 - own["wp"]) * track.u[at], 0.7 * np.pi * track.n[at] * own["D"]
    square = 0.5 * model.water.rho * (inflow**2 + tip**2) * np.pi / 4.0 * own["D"] ** 3
    torque = square * b4_70(np.arctan2(inflow, tip), PITCH)[1]
    drag = ENGINE["friction"].mean * np.tanh(track.n[at] / n0 / machinery.FADING)
    spin = machinery.SPIN * model.ship.L / SPEED / n0  # over the torque of the approach
    fall = (track.n[at + 1] - track.n[at - 1]) / (track.t[at + 1] - track.t[at - 1])
    assert -spin * fall == pytest.approx(torque / torque_of(model, SPEED) + drag, abs=0.005)


def test_a_ship_that_states_all_or_turns_ahead_stops_as_she_is():
    tanker = pk.load_model("esso190k")
    assert as_it_reverses(tanker, SPEED) is tanker
    model = astern_tanker()
    assert as_it_reverses(model, SPEED, turns=0.0) is model
    told = model.with_values("four_quadrant_propeller", t_astern=0.1)
    assert as_it_reverses(told, SPEED, reversal_s=60.0) is told


@pytest.mark.slow
@pytest.mark.parametrize("given", [{}, {"reversal_s": 90.0}, {"torque": 0.5}])
def test_there_is_one_stop_by_command_verdict_and_draws(given):
    model = pk.load_model("kvlcc2")
    track = pk.simulate(model, "stopping", speed=SPEED, compiled=False, **given)
    names = {"reversal_s": "reversal"}
    asked = {names.get(name, name): x for name, x in given.items()}
    verdict = pk.imo_verdicts(model, SPEED, n=20, **asked)[-1]
    many = pk.monte_carlo(model, "stopping", speed=SPEED, n=20, **given)
    reach = track.metrics["track_reach_L"]
    assert verdict.value == pytest.approx(reach, rel=1e-6)
    assert many.nominal["track_reach_L"] == pytest.approx(reach, rel=1e-6)
    low, high = many.interval("track_reach_L")
    assert (verdict.full_astern.low, verdict.full_astern.high) == (low, high)
    assert low < reach < high


def test_what_is_assumed_stands_beside_every_stop():
    track = pk.simulate("kvlcc2", "stopping", speed=SPEED, compiled=False)
    assert track.standing.reversed
    assert any("Nobody states what the engine does" in text for text in track.standing.remarks)
    verdict = stop("kvlcc2")
    words = verdict.full_astern.words
    assert "largest torque astern" in words
    assert "thrust deduction astern" in words
    turning = pk.simulate("kvlcc2", speed=SPEED, compiled=False)
    assert not turning.standing.reversed


def test_a_verdict_by_assumptions_is_settled_where_nearly_all_of_them_agree(monkeypatch):
    """The limit is moved through the band of one ship: met, not settled, not met."""
    (metric, item) = next(pair for pair in METRICS.criteria if pair[1].name == "track_reach")
    many = pk.monte_carlo("s175-3dof", "stopping", speed=9.0, n=200)
    low, high = many.interval("track_reach_L")
    found = []
    for limit in (high, 0.5 * (low + high), low):
        moved = SimpleNamespace(criteria=((metric, replace(item, limit=limit)),))
        monkeypatch.setattr(judged, "METRICS", moved)
        found.append(pk.imo_verdicts("s175-3dof", 9.0, n=200)[-1])
    assert [verdict.passed for verdict in found] == [True, None, False]
    assert [verdict.settled for verdict in found] == [True, False, True]
    assert "of such ships meet the limit" in " ".join(found[1].unsettled)
    assert found[1].probability == many.probability("track_reach_L", 0.5 * (low + high))


def test_a_ship_with_the_resistance_of_her_model_is_not_settled():
    """KVLCC2 at full scale has her model's; S175 has a ship's."""
    assert Standing.of(pk.load_model("s175-3dof"), 9.0).heavy == ""
    heavy = Standing.of(pk.load_model("kvlcc2"), SPEED).heavy
    assert "2.1 times" in heavy
    track = pk.simulate("kvlcc2", "stopping", speed=SPEED, compiled=False)
    assert heavy in track.notes
    verdict = pk.imo_verdicts("kvlcc2", SPEED, n=100)[-1]
    assert heavy in verdict.unsettled
    assert verdict.passed is None


def test_without_draws_a_stop_by_assumptions_is_not_settled():
    verdict = stop("kvlcc2")
    assert (verdict.passed, verdict.settled, verdict.probability) == (None, False, None)
