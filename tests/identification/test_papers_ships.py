"""The ships of the papers: what of their models is printed, what is estimated, and their trials."""

from __future__ import annotations

import json

import pytest

import pmmkit as pk
from pmmkit.cli import main
from pmmkit.conventions import Ship
from pmmkit.effects.cross_flow import hoerner_cd
from pmmkit.models import Standing, estimate
from pmmkit.models.empirical import rudder_values
from pmmkit.models.estimates import resistance_derivative
from pmmkit.models.particulars import (
    ASPECT,
    PROPELLER_ERRORS,
    RUDDER_ERRORS,
    propeller_diameter,
    propeller_values,
    rudder_area,
    steering_rate,
)
from scripts.studies import bulk_carrier as bulk
from scripts.studies import patrol_vessel as patrol

CARRIER, VESSEL = pk.load_model(bulk.NAME), pk.load_model(patrol.NAME)
FIVE_DIGITS = 5e-5
SURGE = ("Xvv", "Xvr", "Xrr", "Xvvvv")


def same(found, expected):
    """Whether values of a file are those of the formulas, as far as the file writes them."""
    kept = {name: found[name] for name in expected}
    assert kept == pytest.approx(dict(expected), rel=FIVE_DIGITS)


def test_the_bulk_carrier_has_the_nine_derivatives_of_the_paper_and_no_other_has_its_name():
    printed = {"Yv": -1369.8, "Yr": 299.4, "Nv": -725.0, "Nr": -229.0}
    moving = {"Xudot": -73.7, "Yvdot": -1219.0, "Yrdot": -92.8, "Nvdot": -40.2, "Nrdot": -64.8}
    hull, mass = CARRIER.parts["hull_polynomial"], CARRIER.parts["added_mass"]
    same(hull.values, {name: 1e-5 * x for name, x in printed.items()})
    same(mass.values, {name: 1e-5 * x for name, x in moving.items()})
    own = {
        name
        for part in CARRIER.parts.values()
        for name in part.values
        if "Sea Trial Data" in part.source_of(name)
    }
    assert own == {*printed, *moving}
    assert not own & {name for part in CARRIER.parts.values() for name in part.std}


def test_what_the_bulk_carrier_estimates_is_what_the_formulas_give():
    ship, speed = CARRIER.ship, bulk.TRIAL
    full = 38e6 / 1025.0
    design = Ship(
        name="full",
        L=170.0,
        B=28.0,
        d=full / (170.0 * 28.0 * 0.80),
        volume=full,
        mass=38e6,
        Izz=1.0,
        xG=0.0,
    )
    screw = propeller_values(ship, D=propeller_diameter(design))
    blade = rudder_values(ship, area=rudder_area(design), aspect=ASPECT, D=screw["D"])
    guess = estimate(ship, "yoshimura-masumoto")
    resistance, doubt = resistance_derivative(ship, CARRIER.water, speed, CARRIER.convention)
    hull = CARRIER.parts["hull_polynomial"]
    slender = ship.d / ship.L
    same(hull.values, {"Xuu": resistance} | {name: slender * guess.values[name] for name in SURGE})
    same(hull.std, {"Xuu": doubt} | {name: slender * guess.std[name] for name in SURGE})
    same(CARRIER.values("propeller"), screw)
    same(CARRIER.values("rudder_mmg"), blade | {"rate_deg_s": steering_rate(ship)})
    same(CARRIER.values("crossflow_drag"), {"CD": hoerner_cd(ship.B, ship.d)})
    errors = {name: error for name, error in RUDDER_ERRORS.items() if name in blade}
    same(CARRIER.parts["rudder_mmg"].std, {k: e.of(blade[k]) for k, e in errors.items()})
    errors = {name: error for name, error in PROPELLER_ERRORS.items() if name in screw}
    same(CARRIER.parts["propeller"].std, {k: e.of(screw[k]) for k, e in errors.items()})


def test_what_the_patrol_vessel_estimates_is_what_the_formulas_give():
    ship = VESSEL.ship
    over = ship.L / ship.d
    guess, cross = estimate(ship, "yoshimura-masumoto"), estimate(ship, "clarke")
    resistance, fast, flow = patrol.jet(patrol.PROPULSIVE, 0.05)
    unit = VESSEL.convention.force_unit("X", ship=ship, water=VESSEL.water, U=patrol.TURNING_SPEED)
    lent = ("Yrdot", "Nvdot")
    values = guess.values | {name: over * cross.values[name] for name in lent}
    doubts = guess.std | {name: over * cross.std[name] for name in lent}
    values["Xuu"], doubts["Xuu"] = -resistance / unit, 0.25 * resistance / unit
    for effect in ("hull_polynomial", "added_mass"):
        part = VESSEL.parts[effect]
        same(part.values, {name: values[name] for name in part.values})
        same(part.std, {name: doubts[name] for name in part.values})
    D = VESSEL.values("waterjet")["D"]
    same(VESSEL.values("waterjet"), {"nozzle": flow / fast, "phi0": flow / (patrol.ENGINE * D**3)})


@pytest.mark.parametrize(
    ("model", "speed", "hull", "estimated"),
    [
        (CARRIER, bulk.TRIAL, False, ("propulsion", "steering")),
        (VESSEL, patrol.TURNING_SPEED, True, ("propulsion", "steering")),
        (pk.load_model("tanker-320"), 7.97, True, ()),
    ],
)
def test_who_sails_them_is_told_what_is_estimated(model, speed, hull, estimated):
    found = Standing.of(model, speed)
    assert (found.hull, found.estimated) == (hull, estimated)
    told = pk.simulate(model, speed=speed, rudder_deg=30, compiled=False).standing.sentences
    assert set(found.sentences) <= set(told)
    driven = any(text.startswith("Propulsion and steering are estimates") for text in told)
    assert driven == bool(estimated)
    verdicts = pk.imo_verdicts(model, speed, n=0, compiled=False)
    assert {item.words for item in verdicts} == {"not settled"}


def test_the_turns_of_the_bulk_carrier_lie_beside_her_trial():
    """Advance within 17 and diameter within 10 of 100, from midship; from where a bridge stands the
    advance within 6. The trial's transfer is 0.6 of the model's, and nearer from there."""
    for angle in (-35.0, 35.0):
        track = bulk.turned(angle)
        trial = {name: x for (own, name), x in bulk.TURNS.items() if own == angle}
        found = track.metrics
        assert found["advance_L"] == pytest.approx(trial["advance_L"], rel=0.17)
        assert found["tactical_diameter_L"] == pytest.approx(trial["tactical_diameter_L"], rel=0.1)
        assert 1.5 < found["transfer_L"] / trial["transfer_L"] < 2.0
        advance, transfer, diameter = bulk.seen_from(track, bulk.BRIDGE)
        assert advance == pytest.approx(trial["advance_L"], rel=0.06)
        assert diameter == pytest.approx(found["tactical_diameter_L"], rel=1e-3)
        assert 1.1 < transfer / trial["transfer_L"] < 1.4


def test_a_turn_seen_from_midship_is_that_of_its_metrics():
    track = bulk.turned(-35.0)
    found = [track.metrics[name] for name in ("advance_L", "transfer_L", "tactical_diameter_L")]
    assert bulk.seen_from(track, 0.0) == pytest.approx(found, rel=1e-3)


@pytest.mark.parametrize(("model", "speed"), [(CARRIER, 7.25), (VESSEL, 14.9)])
def test_they_turn_alike_to_both_sides(model, speed):
    port, starboard = (
        pk.simulate(model, rudder_deg=angle, speed=speed, compiled=False).metrics
        for angle in (-30.0, 30.0)
    )
    for name in ("advance_L", "transfer_L", "tactical_diameter_L", "speed_ratio"):
        assert port[name] == pytest.approx(starboard[name], rel=1e-6)


def test_the_trial_lies_among_the_ships_that_the_spread_of_the_estimates_gives():
    drawn = pk.monte_carlo(CARRIER, "turning", rudder_deg=35, speed=bulk.TRIAL, n=100, seed=1)
    for name in ("advance_L", "tactical_diameter_L"):
        low, high = drawn.interval(name)
        assert low < bulk.TURNS[(35.0, name)] < high


def test_the_trials_stop_lies_in_the_band_of_engines_that_nobody_fitted_to_it():
    for name, (low, high) in bulk.band().items():
        assert low < bulk.STOP[name] < high


def test_the_library_lists_them(capsys):
    assert {bulk.NAME, patrol.NAME, "tanker-320"} <= set(pk.ships())
    assert main(["ships", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)["ships"]
    named = {item["name"]: item["parts"] for item in told}
    assert named[patrol.NAME] == ["hull_polynomial", "added_mass", "waterjet"]
    assert "shaft" not in named[bulk.NAME]
