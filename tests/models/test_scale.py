"""From model scale to ship scale: Froude's law, ITTC friction and wake, in newtons."""

from __future__ import annotations

import math

import pytest

from pmmkit.base import MissingPartError, ModelError
from pmmkit.conventions import Water
from pmmkit.imo import imo_verdicts
from pmmkit.models import full_scale, load_model, save_model, scaled
from pmmkit.models.empirical import form_factor, wetted_surface
from pmmkit.simulation import simulate

MODEL = load_model("kvlcc2-l7")
SPEED, LENGTH, WETTED, K = 7.97, 320.0, 27194.0, 0.2
SHIP = full_scale(MODEL, LENGTH, speed=SPEED, form=K, wetted=WETTED, water=Water(rho=1025.0))


def resistance(model, speed):
    value = model.values("hull_polynomial")["Xuu"]
    return -value * 0.5 * model.water.rho * model.ship.L * model.ship.d * speed**2


def test_the_resistance_of_the_ship_in_newtons():
    """ITTC 1978 by hand: total coefficient of the model, less its excess of friction."""
    speed = SPEED / math.sqrt(LENGTH / 7.0)
    surface = WETTED * (7.0 / LENGTH) ** 2
    total = resistance(MODEL, speed) / (0.5 * 1000.0 * surface * speed**2)
    friction = 0.075 / (math.log10(speed * 7.0 / 1.1386e-6) - 2) ** 2
    of_ship = 0.075 / (math.log10(SPEED * LENGTH / 1.1883e-6) - 2) ** 2
    rough = (105 * (150e-6 / LENGTH) ** (1 / 3) - 0.64) * 1e-3
    expected = total - (1 + K) * (friction - of_ship) + rough
    found = resistance(SHIP, SPEED) / (0.5 * 1025.0 * WETTED * SPEED**2)
    assert found == pytest.approx(expected, rel=1e-9)


def test_the_wake_of_the_ship_by_hand():
    """ITTC 1978: ws = t + .04 + (wm - t - .04) [(1+k) CFs + dCF]/[(1+k) CFm]; KVLCC2 .40, t .22."""
    share = (1.2 * 1.39526e-3 + 1.7565e-4) / (1.2 * 3.17512e-3)
    assert SHIP.values("propeller")["wp"] == pytest.approx(0.26 + 0.14 * share, abs=1e-6)


def test_the_propeller_of_the_ship_is_less_loaded_than_that_of_the_model():
    small, large = scaled(MODEL, LENGTH), SHIP
    slow, fast = (simulate(item, speed=SPEED, compiled=False).n[0] for item in (large, small))
    assert slow < fast
    friction_only = full_scale(MODEL, LENGTH, speed=SPEED, form=K, wake=False)
    widest, middle, narrow = (
        simulate(item, speed=SPEED, compiled=False).metrics["tactical_diameter_L"]
        for item in (friction_only, large, small)
    )
    # Less thrust over the rudder widens the turn; the thinner wake gives part of it back.
    assert narrow < middle < widest


def test_everything_but_resistance_and_wake_goes_by_froude():
    carried = scaled(MODEL, LENGTH)
    for effect in MODEL.parts:
        for name, value in carried.values(effect).items():
            if (effect, name) not in {("hull_polynomial", "Xuu"), ("propeller", "wp")}:
                assert SHIP.values(effect)[name] == value, (effect, name)


def test_the_ship_floats_in_its_own_water():
    assert SHIP.ship.mass == pytest.approx(1025.0 * SHIP.ship.volume, rel=1e-12)
    assert SHIP.ship.Izz / SHIP.ship.mass == pytest.approx(
        MODEL.ship.Izz / MODEL.ship.mass * (LENGTH / 7.0) ** 2
    )


def test_every_froude_number_of_a_model_is_corrected_at_its_own_speed():
    numbers = (0.1, 0.2)
    tested = MODEL.with_(Fn=numbers)
    ship = full_scale(tested, LENGTH, form=K)
    found = ship.parts["hull_polynomial"].values["Xuu"]
    for Fn, value in zip(numbers, found, strict=True):
        alone = full_scale(MODEL, LENGTH, speed=SHIP.ship.speed(Fn), form=K)
        assert value == pytest.approx(alone.values("hull_polynomial")["Xuu"], rel=1e-12)
    with pytest.raises(ModelError, match="give no speed"):
        full_scale(tested, LENGTH, speed=SPEED)


def test_the_steps_are_told_by_the_model_its_file_its_tracks_and_its_verdicts(tmp_path):
    save_model(SHIP, tmp_path / "ship.toml")
    loaded = load_model(tmp_path / "ship.toml")
    assert loaded.history == SHIP.history
    assert "ITTC 1957" in loaded.history[-2]
    assert "0.400 of the model" in loaded.history[-1]
    assert "corrected to the scale" in loaded.parts["propeller"].source_of("wp")
    track = simulate(loaded, speed=SPEED)
    assert "propulsion point of the ship" in track.scale
    assert {item.scale for item in imo_verdicts(loaded, SPEED)} == {track.scale}


def test_what_cannot_be_corrected_is_refused():
    with pytest.raises(ModelError, match="say the speed"):
        full_scale(MODEL, LENGTH)
    with pytest.raises(ModelError, match="longer"):
        full_scale(MODEL, 3.0, speed=1.0)
    with pytest.raises(ModelError, match="positive"):
        full_scale(MODEL, LENGTH, speed=-1.0)
    with pytest.raises(MissingPartError, match="resistance of its hull"):
        full_scale(load_model("mariner"), 200.0, speed=8.0)


def test_estimates_of_wetted_surface_and_form_factor_are_near_the_known_ones():
    """KVLCC2: 27 194 m² with the rudder left out (SIMMAN)."""
    assert wetted_surface(load_model("kvlcc2").ship) == pytest.approx(27194.0, rel=0.05)
    assert 0.0 < form_factor(load_model("s175").ship) < form_factor(load_model("kvlcc2").ship) < 0.4
