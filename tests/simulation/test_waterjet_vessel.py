"""A ship with waterjets: what drives her, how her buckets stop her, what is said of her model."""

from __future__ import annotations

import math

import pytest

import pmmkit as pk
from pmmkit.equations import prepare
from pmmkit.models.provenance import GUESSED
from scripts.studies.patrol_vessel import NAME, STOPPING_SPEED, TURNING_SPEED

VESSEL = pk.load_model(NAME)


def test_the_jets_of_the_approach_take_the_stated_power_at_the_stated_revolutions():
    """3 × 2720 kW through a gearing of 0.97 and pumps of 0.9, at 2050 rpm and 29 knots."""
    n = prepare(VESSEL, TURNING_SPEED).self_propulsion()
    assert 60.0 * n == pytest.approx(2050.0, rel=1e-3)
    own = VESSEL.values("waterjet")
    flow = own["phi0"] * n * own["D"] ** 3
    inflow, jet = 0.95 * TURNING_SPEED, flow / own["nozzle"]
    assert 0.5 * 1025.0 * flow * (jet**2 - 0.8 * inflow**2) == pytest.approx(
        0.97 * 0.9 * 2720e3, rel=1e-3
    )
    assert 3 * 1025.0 * flow * (jet - inflow) * TURNING_SPEED == pytest.approx(
        0.55 * 3 * 2720e3, rel=1e-3
    )


@pytest.mark.parametrize("seconds", [4.0, 12.0])
def test_a_stop_by_buckets_is_that_of_the_momentum_of_its_jets(seconds):
    """Without resistance and wake, with jets at the ship's speed U and buckets that go down in T:
    the speed lost e follows de/dt = k (1.5 U min(t/T, 1) - e), k the pumps' mass flow over m + mx.
    """
    U = 14.0
    jets = VESSEL.values("waterjet")
    n = U * jets["nozzle"] / (jets["phi0"] * jets["D"] ** 3)
    bare = VESSEL.with_values("hull_polynomial", Xuu=-1e-12).with_values("waterjet", w=0.0)
    track = pk.simulate(
        bare, "stopping", speed=U, turns=-1.0, reversal_s=seconds, revolutions=n, compiled=False
    )
    added = -VESSEL.values("added_mass")["Xudot"] * 0.5 * 1025.0 * 44.0**2 * 1.65
    k = 3 * 1025.0 * U * jets["nozzle"] / (330e3 + added)
    ramp = 1.5 * U / seconds * (seconds - (1.0 - math.exp(-k * seconds)) / k)
    assert ramp < U
    expected = seconds + math.log((1.5 * U - ramp) / (0.5 * U)) / k
    assert track.metrics["time_to_stop"] == pytest.approx(expected, rel=1e-5)


def test_pumps_do_not_turn_astern_where_a_bucket_does():
    track = pk.simulate(VESSEL, "stopping", speed=STOPPING_SPEED, compiled=False)
    assert track.n.min() == pytest.approx(0.7 * track.n[0])
    later = pk.simulate(VESSEL, "stopping", speed=STOPPING_SPEED, reversal_s=15.0, compiled=False)
    assert later.metrics["track_reach"] > track.metrics["track_reach"]


def test_who_sails_a_guessed_hull_is_told():
    turn = pk.simulate(VESSEL, speed=TURNING_SPEED, rudder_deg=30.0, compiled=False)
    assert GUESSED in turn.standing.sentences
    verdicts = pk.imo_verdicts(VESSEL, TURNING_SPEED, n=0, compiled=False, reversal=15.0)
    assert all(GUESSED in verdict.conditions for verdict in verdicts)
    engine = verdicts[-1].full_astern
    assert engine is not None
    assert (engine.bucket, engine.reversal_s) == (True, 15.0)
