"""The library of reference ships: every file is sound, and says what its source says."""

from __future__ import annotations

import pytest

from pmmkit.base import ModelError, UnknownNameError
from pmmkit.equations import prepare
from pmmkit.files import read_toml
from pmmkit.models import load_model, load_ship, model_text, ships
from pmmkit.models.library import SHIPS
from pmmkit.simulation import simulate

RHO, L = 1025.0, 175.0


@pytest.mark.parametrize("name", ships())
def test_every_library_ship_is_a_model_and_can_be_simulated(name):
    model = load_model(name)
    assert model.name == name
    assert load_ship(name) == model.ship
    assert model.scale
    assert model.lacking == ()
    assert all(part.source for part in model.parts.values())
    assert SHIPS[name].file.read_text(encoding="utf-8").startswith("#")
    speed = model.ship.speed(0.15)
    c = prepare(model, speed)
    n = c.self_propulsion()
    udot = c.accelerations(speed, 0.0, 0.0, n=n)[0]
    assert udot == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("name", ["s175", "s175-3dof"])
def test_s175_has_the_masses_of_son_and_nomoto(name):
    """m' = .00792, Iz' = .000456; my' = .007049, not the old misprint .000238."""
    model = load_model(name)
    assert model.ship.mass / (0.5 * RHO * L**3) == pytest.approx(0.00792, rel=1e-12)
    assert model.ship.Izz / (0.5 * RHO * L**5) == pytest.approx(0.000456, rel=1e-12)
    assert model.ship.block == pytest.approx(0.5617, abs=5e-5)
    added = model.values("added_mass")
    assert added["Yvdot"] == -0.007049
    assert added["Yrdot"] == added["Nvdot"] == pytest.approx(-0.007049 * 0.05)


def test_s175_with_roll_has_the_roll_masses_of_son_and_nomoto():
    model = load_model("s175")
    assert model.ship.GM == 0.3
    assert model.ship.Ixx is not None
    assert model.ship.Ixx / (0.5 * RHO * L**5) == pytest.approx(0.0000176, rel=1e-12)
    added = model.values("added_mass")
    assert added["Ypdot"] == added["Kvdot"] == pytest.approx(0.007049 * 0.0313)


def test_the_two_s175_share_every_value_that_does_not_need_roll():
    four, three = load_model("s175"), load_model("s175-3dof")
    assert not three.rolls
    for effect in ("hull_polynomial", "added_mass", "propeller"):
        own = dict(three.parts[effect].values)
        assert own == {name: four.parts[effect].values[name] for name in own}
    assert len(three.parts["hull_polynomial"].values) == 16


@pytest.mark.parametrize(
    ("speed", "rpm"), [(6.0, 57.30), (7.0, 66.85), (9.0, 85.95), (12.0, 114.60)]
)
def test_s175_self_propulsion(speed, rpm):
    """Values computed from the public MSS model (J .785 at every speed)."""
    n = prepare(load_model("s175"), speed).self_propulsion()
    assert 60 * n == pytest.approx(rpm, abs=0.006)
    assert 0.816 * speed / (n * 6.533) == pytest.approx(0.785, abs=5e-4)


def test_s175_is_straight_line_stable():
    """C = Yv Nr - Nv (Yr - m - mx) = +3.63e-6."""
    values = load_model("s175").values("hull_polynomial")
    C = values["Yv"] * values["Nr"] - values["Nv"] * (values["Yr"] - 0.00792 - 0.000238)
    assert pytest.approx(3.63e-6, rel=2e-3) == C


def test_an_unknown_ship_is_answered_with_the_list():
    with pytest.raises(UnknownNameError, match="s175-3dof"):
        load_ship("s-175")
    with pytest.raises(UnknownNameError, match=r"path with the ending \.toml"):
        load_model("no such ship")


def test_a_missing_file_is_an_error_of_ours(tmp_path):
    with pytest.raises(ModelError, match="does not exist"):
        read_toml(tmp_path / "none.toml")
    with pytest.raises(ModelError, match="cannot be read"):
        read_toml(tmp_path)


def test_library_files_survive_a_round_trip(tmp_path):
    for name in ships():
        model = load_model(name)
        path = tmp_path / f"{name}.toml"
        path.write_text(model_text(model), encoding="utf-8")
        assert model_text(load_model(path)) == model_text(model)


def test_the_tanker_of_a_preliminary_design_has_the_row_it_prints_and_a_turn_of_a_full_ship():
    """Its xG is 0.534 L from the after perpendicular; KVLCC2, of the same size, turns in 3.0 L."""
    model = load_model("tanker-320")
    hull = model.values("hull_polynomial")
    printed = {"Yv": -0.02111, "Yr": 0.004249, "Nv": -0.00823, "Nr": -0.00279}
    assert {name: hull[name] for name in printed} == printed
    ship, like = model.ship, load_ship("kvlcc2")
    assert 0.5 + ship.xG / ship.L == pytest.approx(0.534)
    assert (ship.L, ship.B, ship.d) == (like.L, like.B, like.d)
    assert ship.volume == pytest.approx(like.volume, rel=5e-4)
    turned = {
        name: simulate(name, speed=7.97, rudder_deg=35.0, compiled=False).metrics
        for name in ("tanker-320", "kvlcc2")
    }
    wider = [turned[name]["tactical_diameter_L"] for name in turned]
    assert 1.0 < wider[0] / wider[1] < 1.4
