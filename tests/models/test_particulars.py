"""Propeller and rudder from particulars, held against the ships of the library."""

from __future__ import annotations

import math

import numpy as np
import pytest

import pmmkit as pk
from pmmkit import hull_table
from pmmkit.models import from_values
from pmmkit.models.estimates import estimated_table
from pmmkit.models.model import HULL_TERMS
from pmmkit.models.particulars import STATED, parts_from_particulars
from pmmkit.models.wageningen import open_water_curve

MMG = ("kvlcc2-l7", "kcs", "esso-osaka-3m")


def whole(name):
    """The derivatives of a library ship with an uncertainty."""
    table = hull_table(name)
    return table.with_(
        covariance=np.diag((0.02 * table.value[0]) ** 2).reshape(
            1, len(table.names), 1, len(table.names)
        )
    )


@pytest.mark.parametrize("name", MMG)
def test_estimates_of_a_rudder_lie_about_as_far_from_library_ships_as_they_say(name):
    """Single published values lie up to three standard errors off, most within two."""
    ship, parts = pk.load_model(name).ship, pk.load_model(name).parts
    screw, blade = parts_from_particulars(
        ship, {"D": parts["propeller"].values["D"]}, {"area": parts["rudder_mmg"].values["area"]}
    )
    away = [
        abs(blade.values[own] - parts["rudder_mmg"].values[own]) / std
        for own, std in blade.std.items()
    ]
    assert np.median(away) < 1.5
    assert max(away) < 3.5
    assert abs(screw.values["t"] - parts["propeller"].values["t"]) < 2 * screw.std["t"]


def test_what_is_stated_stands_and_the_rest_says_that_it_is_an_estimate():
    ship = pk.load_model("kvlcc2-l7").ship
    screw, blade = parts_from_particulars(
        ship,
        {"D": 0.216, "wake": "mmg", "C1": 2.0, "C2_positive": 1.6, "C2_negative": 1.1, "wp": 0.4},
        {"area_lateral": 0.0539, "height": 0.345, "rate_deg_s": 15.8},
    )
    assert screw.options["wake"] == "mmg"
    assert screw.source_of("wp") == STATED
    assert screw.source_of("t").startswith("empirical")
    assert set(screw.std) == {"t", "kt0", "kt1"}
    assert blade.values["area"] == 0.0539
    assert "area" not in blade.std
    assert blade.values["eta"] == pytest.approx(0.216 / 0.345, rel=1e-9)
    assert blade.values["rate_deg_s"] == 15.8


def test_a_model_in_a_tank_steers_as_its_ship_by_froudes_law():
    """SOLAS: 35° to 30° in 28 s on the ship; √λ times that on the model."""
    ship = pk.load_model("kvlcc2-l7").ship
    _, blade = parts_from_particulars(ship, {}, {"full_length": 320.0})
    assert blade.values["rate_deg_s"] == pytest.approx(65 / 28 * math.sqrt(320 / 7), rel=0.01)


@pytest.mark.parametrize("name", ["s175-3dof", "kvlcc2-l7", "kcs"])
def test_estimated_derivatives_mean_what_those_of_the_table_mean(name):
    """Conventions differ (added mass apart or inside, L² or L d); errors of the method hold."""
    table = hull_table(name)
    guess = estimated_table(table)
    shared = [own for own in table.names if own in guess and own != "Xuu"]
    away = {
        own: abs(guess.at()[own] - table.at()[own]) / guess.std[0, guess.index(own)]
        for own in shared
    }
    assert np.median(list(away.values())) < 1.5
    assert away["Xvr"] < 2.5
    assert away["Yvdot"] < 3.0


@pytest.mark.slow
def test_drift_sway_and_yaw_alone_bring_the_hull_to_a_turn():
    """The commonest programme: no coupling, no propeller, no rudder. The turn of the whole ship
    lies in the interval."""
    ship = pk.load_model("kvlcc2-l7")
    given = whole("kvlcc2-l7")
    tested = given.select([x for x in given.names if len(x) < 3 or x[1] * 3 == x[1:] or "dot" in x])
    donor = ship.with_(
        parts={part.effect: part for part in parts_from_particulars(ship.ship, {}, {})}
    )
    made = pk.to_model(tested.with_(ship=ship.ship), donor, missing="estimate")
    hull = made.parts["hull_polynomial"]
    assert {"Xvr", "Xvv", "Xrr", "Yvdot"} & set(hull.std) >= {"Xvr", "Xvv", "Xrr"}
    assert hull.source_of("Xvr").startswith("empirical")
    many = pk.monte_carlo(made, "turning", speed=1.18, rudder_deg=35, n=200, seed=1)
    low, high = many.interval("tactical_diameter_L")
    true = pk.simulate(ship, speed=1.18, rudder_deg=35).metrics["tactical_diameter_L"]
    assert low < true < high
    assert high - low > 0.5


def test_without_its_own_damping_no_hull_is_made_up():
    table = hull_table("s175-3dof")
    bare = table.select([x for x in table.names if x not in HULL_TERMS])
    with pytest.raises(pk.PmmkitError, match="Yv is not in the table"):
        pk.to_model(bare, "s175-3dof", missing="estimate")


def test_values_of_other_froude_numbers_stand_where_one_has_none():
    table = hull_table("s175-3dof")
    values = {name: [x] * 3 for name, x in table.at().items()}
    values["Xvr"] = [math.nan, -0.003, math.nan]
    several = from_values(
        values, ship=table.ship, water=table.water, Fn=(0.1, 0.2, 0.3), convention=table.convention
    )
    made = pk.to_model(several, "s175-3dof", missing="estimate")
    assert made.parts["hull_polynomial"].values["Xvr"] == (-0.003,) * 3


def test_the_b_series_comes_near_a_tested_propeller_of_its_geometry(shared_data, datasets):
    """HP801 of HMRI (P/D 0.721, AE/A0 0.431, 4 blades) is no B propeller: 7 % at low J."""
    campaign = pk.open_campaign(datasets / "kvlcc2_hmri", data=shared_data)
    J, KT, KQ = campaign.open_water
    low = J <= 0.4
    thrust, torque = open_water_curve(J[low], pitch=0.721, area_ratio=0.431, blades=4)
    assert thrust == pytest.approx(KT[low], rel=0.07)
    assert torque == pytest.approx(KQ[low], rel=0.07)


def test_the_best_efficiency_of_b_propellers_is_as_in_their_charts():
    """B4-40 with P/D 0.8: about 0.65 near J = 0.65; and there is none with twenty blades."""
    J = np.linspace(0.3, 0.8, 51)
    KT, KQ = open_water_curve(J, pitch=0.8, area_ratio=0.4, blades=4)
    eta = J * KT / (2 * np.pi * KQ)
    assert eta.max() == pytest.approx(0.65, abs=0.02)
    assert J[eta.argmax()] == pytest.approx(0.66, abs=0.05)
    with pytest.raises(pk.PmmkitError, match="blades = 20"):
        open_water_curve(J, pitch=0.8, area_ratio=0.4, blades=20)


def test_the_geometry_of_a_propeller_gives_its_curve():
    ship = pk.load_model("kvlcc2-l7").ship
    screw, _ = parts_from_particulars(
        ship, {"D": 0.2124, "P_over_D": 0.721, "area_ratio": 0.431, "blades": 4}, {}
    )
    assert screw.values["kt0"] == pytest.approx(0.292, abs=0.005)
    assert "B series" in screw.source_of("kt0")
    assert screw.std["kt0"] < 0.1 * screw.values["kt0"]
