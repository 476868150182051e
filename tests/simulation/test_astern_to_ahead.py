"""From astern to ahead: closed forms of the surge, mirror symmetry, and what is refused."""

from __future__ import annotations

import math

import pytest

import pmmkit as pk
from pmmkit.base import DataError, ModelError
from pmmkit.conventions import Convention, Ship, Water
from pmmkit.equations import prepare
from pmmkit.models import Model, Part
from pmmkit.simulation.ensemble import batch_of
from pmmkit.simulation.straight import held_straight

L, MASS, RHO = 50.0, 4.0e5, 1025.0
SURGE, CXU, NOZZLE = 4.0e4, 3.0e3, 0.1
"""Added mass [kg], resistance over u|u| [kg/m] and area of a nozzle [m²]."""


def jet_ship(reverse: float) -> Model:
    """A ship of the surge alone: jets of 100 n m³/s from nozzles of 0.1 m², without wake."""
    unit = 0.5 * RHO * L**2
    hull = {"Xuu": -CXU / unit, "Yv": -0.01, "Yr": 0.002, "Nv": -0.003, "Nr": -0.002}
    mass = {"Xudot": -SURGE / (unit * L), "Yvdot": -0.005, "Nrdot": -0.0003}
    jets = {"nozzle": NOZZLE, "D": 1.0, "phi0": 1.0, "rate_deg_s": 5.0, "reverse": reverse}
    given = {"hull_polynomial": hull, "added_mass": mass, "waterjet": jets}
    return Model(
        name="jets",
        ship=Ship(name="jets", L=L, B=8.0, d=1.7, volume=MASS / RHO, mass=MASS, Izz=6e7),
        water=Water(rho=RHO),
        convention=Convention(system="prime", U="instantaneous", surge="u"),
        parts={name: Part(effect=name, values=values) for name, values in given.items()},
    )


def sailed(model: Model, manoeuvre: str, speed: float, **settings: float) -> dict[str, float]:
    track = pk.simulate(
        model, manoeuvre, speed=speed, compiled=False, rtol=1e-10, reversal_s=1e-6, **settings
    )
    return dict(track.metrics)


def test_the_surge_of_constant_jets_is_the_closed_form():
    """M du/dt = A - B u - C u|u| with the pump's flow Q: A = ρQ²/nozzle, B = ρQ; astern with
    half of A, against it."""
    speed, M = 12.0, MASS + SURGE
    model = jet_ship(0.5)
    Q = prepare(held_straight(model), speed).self_propulsion()
    assert RHO * Q * (Q / NOZZLE - speed) == pytest.approx(CXU * speed**2, rel=1e-8)
    A, B, C = RHO * Q**2 / NOZZLE, RHO * Q, CXU
    found = sailed(model, "astern_to_ahead", speed, astern=1.0, share=0.9)

    backing = (-B + math.sqrt(B**2 + 2.0 * A * C)) / (2.0 * C)
    assert found["astern_speed"] == pytest.approx(backing, rel=2e-4)
    s = found["astern_speed"]
    root = math.sqrt(4.0 * A * C - B**2)
    time = 2.0 * M / root * (math.atan(-B / root) - math.atan((-2.0 * C * s - B) / root))
    assert found["time_to_stop"] == pytest.approx(time, rel=1e-4)
    way = M / (2.0 * C) * math.log(A / (C * s**2 + B * s + A)) + B / (2.0 * C) * time
    assert found["astern_reach"] == pytest.approx(-way, rel=1e-4)

    u, wide = 0.9 * speed, math.sqrt(B**2 + 4.0 * A * C)
    ahead = 2.0 * M / wide * (math.atanh((2.0 * C * u + B) / wide) - math.atanh(B / wide))
    assert found["time_to_speed"] - found["time_to_stop"] == pytest.approx(ahead, rel=1e-5)
    far = M / (2.0 * C) * math.log(A / (A - B * u - C * u**2)) - B / (2.0 * C) * ahead
    assert found["way_ahead"] == pytest.approx(far, rel=1e-5)


def test_without_intake_it_is_the_hyperbolic_tangent():
    """M du/dt = T - C u²: u = √(T/C) tanh(t √(TC)/M) from rest; flow of intake next to none."""
    model = jet_ship(0.5).with_values("waterjet", w=0.99, nozzle=1e-4)
    found = sailed(model, "astern_to_ahead", 10.0, share=0.8)
    M = MASS + SURGE
    time = M / (CXU * 10.0) * math.atanh(0.8)
    way = -M / (2.0 * CXU) * math.log(1.0 - 0.8**2)
    assert found["time_to_speed"] - found["time_to_stop"] == pytest.approx(time, rel=1e-3)
    assert found["way_ahead"] == pytest.approx(way, rel=1e-3)


def test_it_mirrors_the_stop_of_a_ship_that_is_alike_ahead_and_astern():
    """Jets whose bucket turns all of them: the forces change sign with speed and bucket."""
    found = sailed(jet_ship(1.0), "astern_to_ahead", 12.0, astern=1.0)
    stop = sailed(jet_ship(1.0), "stopping", 12.0, turns=-1.0)
    assert found["astern_speed"] == pytest.approx(12.0, rel=2e-4)
    assert found["time_to_stop"] == pytest.approx(stop["time_to_stop"], rel=3e-4)
    assert found["astern_reach"] == pytest.approx(stop["head_reach"], rel=3e-4)


@pytest.mark.parametrize("name", ["kvlcc2", "s175"])
def test_ahead_the_straight_ship_is_the_ship(name):
    model, speed = pk.load_model(name), 8.0
    whole, straight = (prepare(x, speed) for x in (model, held_straight(model)))
    n = whole.self_propulsion()
    assert straight.self_propulsion() == pytest.approx(n, rel=1e-9)
    for u in (2.0, 5.0, 8.0):
        states = [[0.0] * len(x.structure.states) for x in (whole, straight)]
        for state in states:
            state[3] = u
        full, held = (x.rates(y, 0.0, n)[3] for x, y in zip((whole, straight), states, strict=True))
        assert held == pytest.approx(full, rel=1e-9, abs=1e-12)


def test_a_ship_with_a_propeller_gathers_way_and_says_what_was_assumed():
    track = pk.simulate("kvlcc2", "astern_to_ahead", speed=7.97, compiled=False)
    assert not track.y.any()
    assert track.u.min() == pytest.approx(-track.metrics["astern_speed"], rel=1e-3)
    assert track.u[-1] == pytest.approx(0.9 * 7.97, rel=1e-3)
    assert any("resists astern as it does ahead" in note for note in track.notes)
    assert any("B4-70" in note for note in track.notes)
    slow = pk.simulate("kvlcc2", "astern_to_ahead", speed=7.97, turns=0.5, compiled=False)
    assert math.isnan(slow.metrics["time_to_speed"])
    assert slow.metrics["time_to_stop"] > track.metrics["time_to_stop"]
    assert any("does not reach 7.173 m/s" in note for note in slow.notes)


def test_what_it_cannot_do_is_refused():
    for name, speed in (("mariner", 7.7), ("esso190k", 8.0)):
        with pytest.raises(ModelError, match="four_quadrant_propeller"):
            pk.simulate(name, "astern_to_ahead", speed=speed)
    with pytest.raises(DataError, match="leave out wind_speed"):
        pk.simulate("kvlcc2", "astern_to_ahead", speed=8.0, wind_speed=5.0)
    with pytest.raises(DataError, match=r"astern = -0\.7 must be positive"):
        pk.simulate("kvlcc2", "astern_to_ahead", speed=8.0, astern=-0.7)


def test_ships_that_are_drawn_are_held_as_well():
    batch = batch_of("kvlcc2", "astern_to_ahead", speed=7.97)
    assert list(batch.model.parts["hull_polynomial"].values) == ["Xu|u|"]
    assert batch.plan.phases[-1].level == pytest.approx(0.9 * 7.97)


def test_the_covariance_follows_the_names_that_stay():
    ship = pk.load_model("kcs").ship
    made = pk.estimated_model(ship, speed=12.35, propeller_diameter=7.9, rudder_area=45.3)
    held = held_straight(made)
    assert held.std["Xu|u|"] == made.std["Xuu"]
    assert "Yv" not in held.std


def test_a_ship_that_is_held_straight_is_not_called_linear():
    """Nothing goes sideways: there is no side force to be linear."""
    notes = pk.simulate("kvlcc2", "astern_to_ahead", speed=7.97).notes
    assert not any("linear in v and r" in text for text in notes)
