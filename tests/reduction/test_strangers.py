"""Two programmes of hulls that no library has, brought to a turn: heel with K, and a rotating arm.

The files and the truth share no code with the package (`scripts.datasets.strangers`).
"""

from __future__ import annotations

import pytest

import pmmkit as pk
from pmmkit.api import roll_from_particulars
from pmmkit.cli import main
from pmmkit.conventions import Water
from scripts.datasets.strangers.hulls import turn
from scripts.datasets.strangers.laboratories import FOLDERS, HULLS, SPEEDS
from scripts.studies.strangers import EDITS, filled, held, particulars, steering

FEW = 2
"""Intervals of 95 % that may miss among 44."""


@pytest.fixture(scope="module", params=["heeled", "rotating_arm"])
def stranger(request, tmp_path_factory):
    """The name of a stranger and where its draft, filled in, and its reduction lie."""
    place = tmp_path_factory.mktemp(request.param)
    folder = place / "tests"
    FOLDERS[request.param](folder)
    assert main(["new-campaign", str(folder), "--quiet"]) == 0
    draft = (folder / "campaign.toml").read_text(encoding="utf-8")
    whole = filled(filled(draft, list(particulars(HULLS[request.param]))), EDITS[request.param])
    (folder / "campaign.toml").write_text(whole, encoding="utf-8")
    order = ["reduce", str(folder), "--structure", "auto", "--out", str(place / "reduced"), "-q"]
    assert main(order) == 0
    return request.param, place


@pytest.mark.slow
def test_every_derivative_lies_within_its_interval(stranger):
    name, place = stranger
    inside, missed, _ = held(HULLS[name], place / "reduced" / "derivatives.csv")
    assert len(missed) <= FEW
    assert inside >= 14


@pytest.mark.slow
def test_the_turn_is_that_of_the_true_ship(stranger):
    """With her own propeller and rudder; heel too where she rolls. On an arm nothing accelerates:
    the added mass is an estimate, which shows where the turn begins."""
    name, place = stranger
    hull, model = HULLS[name], str(place / "reduced" / "model.toml")
    own = str(place / "own.toml")
    order = ["model", "set", model, *steering(hull), "--because", "as built", "-o", own, "-q"]
    assert main(order) == 0
    found = pk.simulate(own, speed=SPEEDS[name], rudder_deg=35).metrics
    true = turn(hull, SPEEDS[name])
    assert found["tactical_diameter_L"] == pytest.approx(true.tactical_diameter, rel=0.01)
    assert found["advance_L"] == pytest.approx(true.advance, rel=0.01 if hull.rolls else 0.03)
    if hull.rolls:
        assert found["heel_steady_deg"] == pytest.approx(abs(true.heel_deg), rel=0.02)


@pytest.mark.slow
def test_a_moment_of_roll_that_is_not_used_is_said(stranger, capsys):
    name, place = stranger
    if not HULLS[name].rolls:
        pytest.skip("no K was measured on the rotating arm")
    order = ["reduce", str(place / "tests"), "--structure", "abkowitz3"]
    assert main([*order, "--out", str(place / "upright")]) == 0
    assert "the structure has no roll moment" in capsys.readouterr().out


def test_roll_is_damped_once():
    """What a forced roll test measured is not added to the usual damping."""
    ship, water = pk.load_model("s175").ship, Water(rho=1025.0)
    assert roll_from_particulars(ship, water, damped=True).values["damping"] == 0.0
    assert roll_from_particulars(pk.load_model("kvlcc2").ship, water) is None
