"""Checks of particulars, propeller, frequencies and of the length that amplitudes imply."""

from __future__ import annotations

import math
from dataclasses import replace
from types import MappingProxyType

import numpy as np
import own_tank
import pytest
from checks_programme import SHIP, WATER, campaign_of, run_of

import pmmkit as pk
from pmmkit import open_campaign, save_campaign
from pmmkit.conventions import Structure
from pmmkit.files import datasets_folder
from pmmkit.intake import examine
from pmmkit.intake.checks.particulars import examine_ship
from pmmkit.models import ships
from pmmkit.reduction import reduce_campaign


def said(findings, check: str):
    return [finding for finding in findings if finding.check == check]


def test_consistent_particulars_are_silent():
    assert examine(campaign_of([], ship=replace(SHIP, block_stated=0.5617, GM=0.03))) == ()


@pytest.mark.parametrize("name", ships())
def test_no_ship_of_the_library_contradicts_herself(name):
    """KVLCC2 of 7 m: B and d of three and two digits (Yasukawa and Yoshimura 2015), C_B .810."""
    model = pk.load_model(name)
    found = examine(campaign_of([], ship=model.ship, water=model.water))
    assert said(found, "particulars") == []


@pytest.mark.parametrize(
    ("changes", "severity", "words"),
    [
        ({"mass": 0.454}, "error", "1000"),
        ({"mass": 420.0}, "warning", "rho times volume"),
        ({"block_stated": 0.5562}, "warning", "L = 4.909 m"),
        ({"block_stated": 5.617}, "error", "near 1/10"),
        ({"L": SHIP.L * 1000}, "error", "near 1/1000: kilo, or milli"),
        ({"d": SHIP.d / 100}, "error", "B/d 299"),
        ({"GM": 5.0}, "warning", "full-scale"),
        ({"Izz": 61.8}, "warning", "radius of gyration"),
        ({"Izz": 1.3 * SHIP.mass * (0.25 * SHIP.L) ** 2}, "warning", "radius of gyration"),
        ({"Izz": 0.7 * SHIP.mass * (0.25 * SHIP.L) ** 2}, "warning", "radius of gyration"),
        (
            {"xG": 0.51 * SHIP.L, "Izz": SHIP.mass * SHIP.L**2 * (0.0625 + 0.51**2)},
            "warning",
            "from the after perpendicular it is 0.0486 m forward",
        ),
    ],
)
def test_particulars_that_contradict_one_another(changes, severity, words):
    found, *rest = said(examine(campaign_of([], ship=replace(SHIP, **changes))), "particulars")
    assert found.severity == severity
    assert words in found.message
    assert any("Not examined" in item.message for item in rest) is (severity == "error")


def test_a_centre_of_gravity_that_nobody_states_is_uncertain_where_a_balance_holds_it(tmp_path):
    """Every derivative is within its interval then, and without it four of them are not."""
    folder = own_tank.write(tmp_path, own_tank.PROGRAMME)
    file = folder / "campaign.toml"
    text = file.read_text(encoding="utf-8")
    stated = pk.open_campaign(folder)
    file.write_text(text.replace(f"xG = {own_tank.XG}\n", ""), encoding="utf-8")
    silent = pk.open_campaign(folder)
    (only,) = silent.uncertainty
    assert (only.name, only.std, only.assumed) == ("xG", 0.02 * own_tank.L, True)
    (found,) = said(examine_ship(silent, ()), "particulars")
    assert "Nobody states xG" in found.message
    save_campaign(silent, tmp_path / "kept.h5")
    assert pk.open_campaign(tmp_path / "kept.h5").uncertainty == (only,)
    blind = silent.with_(uncertainty=())
    off = {name: outside(item) for name, item in (("silent", silent), ("blind", blind))}
    assert off["silent"] == set()
    assert {"Nvdot", "Yrdot", "Nr", "Xrr"} <= off["blind"]
    for words in ('forces = "hydrodynamic"', 'forces = "balance"\n'):
        other = text.replace('forces = "balance"', words)
        other = other if "balance" in words else other.replace(f"xG = {own_tank.XG}\n", "")
        file.write_text(other, encoding="utf-8")
        assert pk.open_campaign(folder).uncertainty == stated.uncertainty == ()


def outside(campaign):
    """Derivatives that lie outside of their 95 % interval."""
    structure = Structure(name="little hull", derivatives=tuple(own_tank.TRUTH))
    table = reduce_campaign(campaign, structure=structure, fn="pooled", check=False).table
    return {
        name
        for name, value, std in zip(table.names, table.value[0], table.std[0], strict=True)
        if abs(value - own_tank.TRUTH[name]) > 2.0 * std
    }


def test_particulars_that_cannot_be_silence_what_is_judged_by_them():
    """A density in t/m³ is one slip, and not five of inertia and units besides."""
    campaign = open_campaign(datasets_folder() / "s175")
    wrong = campaign.with_(water=replace(campaign.water, rho=campaign.water.rho / 1000))
    found = examine(wrong)
    assert {item.check for item in found if item.severity == "error"} == {"particulars"}
    assert "rho is 0.9991 kg/m³; water has about 1000" in found[0].message
    assert "inertia, " in found[-1].message


def test_a_movable_rudder_area_larger_than_the_whole():
    right = campaign_of([], rudder={"area_lateral": 0.0634, "area_movable": 0.0523})
    assert examine(right) == ()
    wrong = campaign_of([], rudder={"area_lateral": 0.0523, "area_movable": 0.0634})
    assert "exchanged" in said(examine(wrong), "particulars")[0].message


@pytest.mark.parametrize("factor", [1.0, 10.0, 100.0])
def test_the_factor_in_KQ_is_found_from_the_efficiency(factor):
    J = np.linspace(0, 0.9, 10)
    table = {"J": J, "KT": 0.35 * (1 - J), "KQ": factor * 0.05 * (1 - 0.85 * J)}
    found = said(examine(campaign_of([], propeller={"open_water": table})), "open water")
    if factor == 1.0:
        assert found == []
    else:
        assert found[0].numbers["factor"] == factor
        mended = campaign_of([], propeller={"open_water": table, "KQ_factor": 1 / factor})
        assert said(examine(mended), "open water") == []


def test_an_open_water_table_in_a_file(tmp_path):
    rows = ["J,Kt,Kq", *(f"{j / 10},{0.35 - 0.035 * j},{5 - 0.425 * j}" for j in range(10))]
    (tmp_path / "ow.csv").write_text("\n".join(rows))
    campaign = campaign_of([], propeller={"open_water": "ow.csv"}, folder=tmp_path)
    assert said(examine(campaign), "open water")[0].numbers["factor"] == 100.0


def oscillating(**settings):
    return campaign_of([run_of("PS", "pure_sway", amplitude=0.1, **settings)])


def test_frequency_against_a_quarter():
    quarter = 2 * math.pi * 1.5 / (0.25 * 9.81)
    assert said(examine(oscillating(period=12.5)), "frequency") == []
    high = said(examine(oscillating(period=0.95 * quarter)), "frequency")
    assert high[0].severity == "warning"
    assert high[0].numbers["tau"] == pytest.approx(0.25 / 0.95)
    near = said(examine(oscillating(period=1.1 * quarter)), "frequency")
    assert near[0].severity == "info"
    assert "near 0.25" in near[0].message


def test_waves_that_stand_across_the_tank():
    wave = math.pi / WATER.tank_width
    omega = math.sqrt(9.81 * wave * math.tanh(wave * WATER.tank_depth))
    found = said(examine(oscillating(period=2 * math.pi / (1.02 * omega))), "frequency")
    assert any("standing across a tank" in finding.message for finding in found)
    aside = said(examine(oscillating(period=2 * math.pi / (1.2 * omega))), "frequency")
    assert not any("standing" in finding.message for finding in aside)


def test_stated_amplitudes_give_the_length_that_made_them():
    def runs(length):
        for hertz, r in ((0.03, 0.2), (0.05, 0.3), (0.07, 0.4)):
            omega = 2 * math.pi * hertz
            stated = {"r_amplitude": r, "rdot_amplitude": -round(r * omega * length / 1.5, 5)}
            run = run_of(
                f"PY_{hertz}", "pure_yaw", period=1 / hertz, yaw_amplitude=r * 1.5 / SHIP.L / omega
            )
            yield run.with_(stated=MappingProxyType(stated))

    assert said(examine(campaign_of(runs(SHIP.L))), "length") == []
    (found,) = said(examine(campaign_of(runs(1.01 * SHIP.L))), "length")
    assert found.severity == "error"
    assert found.numbers["length"] == pytest.approx(1.01 * SHIP.L, rel=1e-4)


def test_speeds_of_a_model_beside_the_length_of_the_ship():
    """KVLCC2's model of 7 m was towed at 1.17 m/s; with the ship's 320 m that is Fn 0.021."""
    runs = [run_of(f"d{n}", "static_drift", speed=1.17, drift=0.05 * n) for n in (1, 2, 3)]
    ship, model = pk.load_model("kvlcc2"), pk.load_model("kvlcc2-l7")

    def told(ship, runs=runs):
        findings = examine(campaign_of(runs, ship=ship.ship, water=ship.water))
        return [x.message for x in findings if "speeds of a model" in x.message]

    (message,) = told(ship)
    assert "Fn 0.021 of a ship of 320 m" in message
    assert told(model) == []
    # computed for the ship, in a harbour and on the way to it
    assert told(ship, [*runs, run_of("fast", "static_drift", speed=3.0)]) == []
