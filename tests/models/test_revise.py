"""Values and parts changed by hand: what is kept of them, and what goes."""

from __future__ import annotations

import tomllib

import numpy as np
import pytest

import pmmkit as pk
from pmmkit.base import ModelError, UnknownNameError
from pmmkit.models import model_text, with_part_of, with_stated
from pmmkit.models.particulars import parts_from_particulars
from pmmkit.models.store import model_from
from pmmkit.presentation import WIDE
from pmmkit.simulation import Spread


def test_a_stated_derivative_leaves_the_covariance():
    ship = pk.load_model("kvlcc2").with_(
        covariance=np.diag([1e-4, 4e-4]), covariance_names=("Yv", "Nv")
    )
    made = with_stated(ship, {"Yv": -0.3}, "a newer test")
    assert made.covariance_names == ("Nv",)
    assert made.covariance.tolist() == [[4e-4]]
    assert made.part("hull_polynomial").source_of("Yv") == "stated: a newer test"
    assert "Stated: hull_polynomial.Yv = -0.3, because a newer test." in made.history


def test_a_value_over_froude_numbers_is_stated_at_all():
    ship = pk.load_model("kvlcc2")
    over_speed = ship.with_(Fn=(0.1, 0.2)).with_values("hull_polynomial", Yv=(-0.31, -0.32))
    made = with_stated(over_speed, {"Yv": -0.3}, "x")
    assert made.part("hull_polynomial").values["Yv"] == (-0.3, -0.3)


def test_a_lent_propeller_is_scaled_and_no_nearer_than_an_estimate():
    model = pk.load_model("kvlcc2-l7")
    made = with_part_of(model, "propeller", pk.load_model("kcs"), "stock propeller")
    part = made.part("propeller")
    assert part.values["D"] == pytest.approx(7.9 * 7.0 / 230.0, rel=1e-3)
    guess, _ = parts_from_particulars(model.ship, {}, {})
    assert part.std["wp"] > guess.std["wp"]
    assert 0.0 < part.std["D"] < guess.std["D"]
    before = model.part("rudder_mmg").values["eta"]
    grown = part.values["D"] / model.part("propeller").values["D"]
    assert made.part("rudder_mmg").values["eta"] == pytest.approx(before * grown)
    assert made.history[-1] == "Part propeller taken from kcs, because stock propeller."


def test_the_file_keeps_uncertainties_and_steps():
    made = with_part_of(pk.load_model("kvlcc2-l7"), "rudder", pk.load_model("kcs"))
    again = model_from(tomllib.loads(model_text(made)), "model.toml")
    assert dict(again.part("rudder_mmg").std) == dict(made.part("rudder_mmg").std)
    assert again.history == made.history


@pytest.mark.parametrize(
    ("place", "answer"),
    [
        ("rudder.aera", "did you mean 'area'"),
        ("ruder.area", "no part 'ruder'"),
        ("Yvvvv.", "no part"),
        ("Nonsense", "no value 'Nonsense'"),
    ],
)
def test_what_is_not_there_is_said(place, answer):
    with pytest.raises(UnknownNameError, match=answer):
        with_stated(pk.load_model("kvlcc2"), {place: 1.0}, "x")


def test_a_hull_is_not_lent():
    with pytest.raises((ModelError, UnknownNameError)):
        with_part_of(pk.load_model("kvlcc2"), "hull_polynomial", pk.load_model("kcs"))


def test_uncertainties_scale_with_their_values():
    part = with_part_of(pk.load_model("kvlcc2-l7"), "propeller", pk.load_model("kcs"))
    ship = pk.scaled(part, 320.0)
    ratio = ship.part("propeller").std["D"] / ship.part("propeller").values["D"]
    own = part.part("propeller").std["D"] / part.part("propeller").values["D"]
    assert ratio == pytest.approx(own)


def test_the_covariance_holds_values_of_any_part(tmp_path):
    """A derivative and a value of the rudder that hang together: kept, scaled, drawn, stated."""
    names = ("Yv", "rudder_mmg.aH", "rudder_mmg.area")
    ship = pk.load_model("kvlcc2-l7")
    model = ship.with_(
        covariance=np.array([[4e-4, 1e-3, 0.0], [1e-3, 1e-2, 0.0], [0.0, 0.0, 1e-6]]),
        covariance_names=names,
    )
    pk.save_model(model, tmp_path / "model.toml")
    assert pk.load_model(tmp_path / "model.toml").covariance_names == names
    assert f"{WIDE * 0.1:.1g}" in str(model)
    twice = pk.scaled(model, 2.0 * ship.ship.L)
    assert twice.std["rudder_mmg.area"] == (pytest.approx(4e-3),)
    assert twice.std["rudder_mmg.aH"] == (pytest.approx(0.1),)
    drawn = Spread.of(model, 1.179)
    assert drawn.names == names
    assert drawn.mean[1] == ship.parts["rudder_mmg"].values["aH"]
    np.testing.assert_allclose(drawn.covariance, model.covariance, atol=1e-12)
    stated = with_stated(model, {"rudder.aH": 0.3}, "measured")
    assert stated.covariance_names == ("Yv", "rudder_mmg.area")
    with pytest.raises(ModelError, match=r"rudder_mmg\.tail"):
        ship.with_(covariance=np.eye(1), covariance_names=("rudder_mmg.tail",))
