"""The bands of estimates hold the ships that they were not made from, and drawings do not vary."""

from __future__ import annotations

import pytest

import pmmkit as pk
from pmmkit.models import estimated_model
from pmmkit.models.particulars import parts_from_particulars
from pmmkit.simulation import Spread
from scripts.studies.leave_one_ship_out import (
    PARTS,
    RULES,
    errors_without,
    hidden,
    of_others,
    stated,
    with_errors,
)

SHIP = pk.load_model("s175-3dof")
SQUARE_ROOT = list(RULES.values())[1]


def band(model, speed=9.0):
    many = pk.monte_carlo(model, "turning", rudder_deg=35, speed=speed, n=400)
    return many.interval("tactical_diameter_L")


def test_the_turn_of_s175_lies_in_the_band_of_her_hull_with_a_guessed_propeller_and_rudder():
    """Her own parts turn her in 4.36 to 4.8 L; the band began at 4.4 L before."""
    low, high = band(hidden("s175-3dof", PARTS))
    assert low < 4.36 < 4.8 < high


def test_it_does_where_the_ship_herself_has_no_say_in_the_errors():
    low, high = band(with_errors(hidden("s175-3dof", PARTS), errors_without("S175"), SQUARE_ROOT))
    assert low < 4.36 < 4.8 < high


def test_the_errors_of_a_propeller_and_a_rudder_are_how_far_library_ships_lie_off():
    """Root mean squares over the ships that each names, rounded up."""
    for place, error in stated().items():
        if error.ships:
            found = of_others(place, error)
            rms, said = (found.share, error.share) if error.share else (found.number, error.number)
            assert rms <= said <= 1.2 * rms + 0.05 * bool(error.share), place


def test_a_ship_that_is_judged_has_no_say():
    for place, error in errors_without("S175").items():
        assert "S175" not in error.ships
        known = stated()[place]
        assert len(error.ships) == len(known.ships) - ("S175" in known.ships)


def test_a_drawn_propeller_and_rudder_do_not_vary():
    screw, blade = parts_from_particulars(SHIP.ship, {"D": 6.5}, {"area": 33.0, "height": 7.7})
    assert not {"D"} & set(screw.std)
    assert not {"area", "eta", "xR"} & set(blade.std)
    whole = {"speed": 9.0, "propeller_diameter": 6.5, "rudder_area": 33.0}
    drawn = estimated_model(SHIP.ship, rudder_aspect=1.8, **whole)
    names = Spread.of(drawn, 9.0).names
    assert not {"propeller.D", "rudder_mmg.area", "rudder_mmg.eta"} & set(names)
    assert "rudder_mmg.eta" in Spread.of(estimated_model(SHIP.ship, **whole), 9.0).names


def test_what_nobody_measured_varies():
    names = set(Spread.of(hidden("s175-3dof", PARTS), 9.0).names)
    screw = {"D", "t", "wp", "kt0", "kt1", "C2_positive", "C2_negative"}
    blade = {"area", "lift_slope", "epsilon", "kappa", "gamma_positive", "lR", "tR", "aH", "xH"}
    assert {f"propeller.{name}" for name in screw} <= names
    assert {f"rudder_mmg.{name}" for name in blade} <= names


def test_the_share_of_the_slipstream_and_the_wake_at_the_rudder_make_up_for_each_other():
    found = Spread.of(hidden("s175-3dof", PARTS), 9.0)
    one, other = (found.names.index(f"rudder_mmg.{name}") for name in ("epsilon", "kappa"))
    C = found.covariance
    assert C[one, other] / (C[one, one] * C[other, other]) ** 0.5 == pytest.approx(-0.4)


def test_a_stated_propeller_without_the_growth_of_its_wake_is_no_estimate():
    curve = {"D": 6.5, "t": 0.17, "wp": 0.18, "kt0": 0.53, "kt1": -0.45, "kt2": 0.0}
    screw, _ = parts_from_particulars(SHIP.ship, curve, {})
    assert set(screw.std) == {"C2_positive", "C2_negative"}
    assert screw.source_of("C2_positive").startswith("not stated")
