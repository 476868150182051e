"""The full astern stop: how fast the engine is reversed, what torque it has, and what is said."""

from __future__ import annotations

from itertools import pairwise
from types import MappingProxyType

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import pmmkit as pk
from pmmkit.effects.four_quadrant import b4_70
from pmmkit.errors import DataError
from pmmkit.models import Part
from pmmkit.simulation.imo import full_astern
from pmmkit.simulation.imo.full_astern import measured_astern, reached, torque_of, with_torque_limit

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
    found = measured_astern(track.t, track.n, track.n[0])
    assert found.turns == pytest.approx(-0.6)
    assert found.reversal_s == pytest.approx(
        seconds * 1.58 / 1.6, abs=1.01 * np.diff(track.t).max()
    )


def test_without_a_stated_time_the_propeller_stands_after_two_ship_lengths_at_the_approach_speed():
    model = astern_tanker()
    track = pk.simulate(model, "stopping", speed=SPEED, compiled=False, dt=0.5)
    stands = np.interp(0.0, -track.n, track.t)
    assert stands == pytest.approx(2.0 * model.ship.L / SPEED, rel=1e-3)


def test_who_reverses_later_stops_later():
    stops = [
        pk.simulate(astern_tanker(), "stopping", speed=SPEED, reversal_s=x, compiled=False)
        for x in (5.0, 60.0, 300.0)
    ]
    reach = [track.metrics["track_reach"] for track in stops]
    assert all(before < after for before, after in pairwise(reach))


def test_what_is_assumed_stands_beside_the_verdict():
    verdict = stop(astern_tanker(), astern=-0.8, reversal=60.0)
    engine = verdict.full_astern
    assert (engine.turns, engine.measured, engine.torque) == (-0.8, False, None)
    assert [own for own, _ in engine.others] == [-0.6, -0.7, -0.9, -1.0]
    for own, value in engine.others:
        settings = {"turns": own, "reversal_s": 60.0}
        track = pk.simulate(astern_tanker(), "stopping", speed=SPEED, compiled=False, **settings)
        assert value == pytest.approx(track.metrics["track_reach_L"])
    assert "of the approach's revolutions, reached 60 s after the order" in str(verdict)
    assert "with all the torque that this needs" in str(verdict)


@given(turns=st.floats(-1.0, -0.1), rate=st.floats(0.005, 0.2))
def test_a_recorded_reversal_is_found(turns, rate):
    t = np.arange(0.0, 900.0, 1.0)
    n = 1.2 * np.maximum(1.0 - rate * t, turns)
    found = measured_astern(t, n, 1.2)
    assert found.measured
    assert found.turns == pytest.approx(turns, abs=0.02 + rate)
    assert found.reversal_s == pytest.approx((1.0 - turns) / rate, abs=0.04 / rate + 2.0)


def test_a_propeller_that_only_stands_was_never_astern():
    t = np.arange(50.0)
    assert measured_astern(t, np.maximum(1.0 - 0.1 * t, 0.0), 1.0) is None
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
    # with torque enough nothing is left but the lag of the governor: five seconds at 8 m/s
    assert reach[1] - reach[0] == pytest.approx(5.0 * SPEED / 320.0, rel=0.3)
    assert "a torque of at most 0.2 of the approach's" in str(found[-1])
    assert np.isnan(found[-1].full_astern.reversal_s)
    assert -0.7 < found[-1].full_astern.most < -0.3
    assert "never reached" in str(found[-1])


def test_the_limited_torque_is_not_exceeded_along_the_stop():
    model = astern_tanker()
    own = model.part("four_quadrant_propeller").values
    limited = with_torque_limit(model, SPEED, 0.3)
    track = pk.simulate(limited, "stopping", speed=SPEED, compiled=False)
    late = track.t > 100.0  # steady: what the engine gives is what the water takes
    wake = np.where(track.n < 0.0, 0.0, own["wp"])
    inflow, tip = (1.0 - wake) * track.u, 0.7 * np.pi * track.n * own["D"]
    twist = np.array([b4_70(x, PITCH)[1] for x in np.arctan2(inflow, tip)])
    torque = 0.5 * model.water.rho * (inflow**2 + tip**2) * np.pi / 4.0 * own["D"] ** 3 * twist
    assert -torque[late].min() == pytest.approx(0.3 * torque_of(model, SPEED), rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("spin", [0.5, 2.0])
def test_the_assumed_inertia_of_the_shaft_hardly_counts(monkeypatch, spin):
    def reach():
        limited = with_torque_limit(astern_tanker(), SPEED, 0.4)
        track = pk.simulate(limited, "stopping", speed=SPEED, compiled=False)
        return track.metrics["track_reach_L"]

    usual = reach()
    monkeypatch.setattr(full_astern, "SPIN", spin)
    assert reach() == pytest.approx(usual, rel=0.004)


def test_a_torque_that_is_not_known_cannot_be_limited():
    with pytest.raises(DataError, match=r"has a part shaft_lag, which says how its engine"):
        stop("esso190k", torque=0.8)
    with pytest.raises(DataError, match="does not know the torque"):
        torque_of(pk.load_model("kvlcc2"), SPEED)
    with pytest.raises(DataError, match="positive share"):
        stop(astern_tanker(), torque=-0.5)
