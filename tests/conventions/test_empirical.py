"""Estimates from particulars: printed tables, their misprints, limits, library ships."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from pmmkit.empirical import METHODS, criterion, estimate, rudder_values, zhou_added_mass
from pmmkit.errors import MissingPartError, UnknownNameError
from pmmkit.models import estimated_model, load_model
from pmmkit.ship_library import load_ship
from pmmkit.simulation import simulate
from scripts.studies.paper_b_table import MASS, PRINTED, REASONS, TANKER

AGREE = [
    (method, name)
    for method, row in PRINTED.items()
    for name in row
    if (method, name) not in REASONS
]


@pytest.mark.parametrize(("method", "name"), AGREE)
def test_printed_table_of_a_tanker_where_it_is_right(method, name):
    """Table 11.1 for the 280 000 dwt tanker, to its printed digits."""
    assert estimate(TANKER, method).values[name] == pytest.approx(PRINTED[method][name], rel=3e-3)


@pytest.mark.parametrize(("method", "name"), sorted(REASONS))
def test_printed_table_of_a_tanker_where_it_is_wrong(method, name):
    ours, theirs = estimate(TANKER, method).values[name], PRINTED[method][name]
    assert abs(ours / theirs - 1) > 4e-3


def test_what_reproduces_the_misprints():
    """Norrbin's Nv with .04 T/L for .04 CB B/(πT); Clarke's Nr with .15 for 1/4."""
    S = math.pi * (20.8 / 320) ** 2
    assert pytest.approx(PRINTED["norrbin"]["Nv"], rel=2e-3) == -S * (0.64 - 0.04 * 20.8 / 320)
    clarke = -S * (0.15 + 0.039 * 58 / 20.8 - 0.56 * 58 / 320)
    assert clarke == pytest.approx(PRINTED["clarke"]["Nr"], rel=2e-3)


def test_the_tanker_is_not_stable_as_the_table_concludes():
    """With the centre of gravity from midship the levers are .232 < .390 and so on."""
    levers = {m: criterion(estimate(TANKER, m).values, MASS, 0.034) for m in PRINTED}
    assert pytest.approx(0.019086, abs=1e-6) == MASS
    assert levers["wagner-smitt"] == pytest.approx((0.2319, 0.3899), abs=5e-4)
    assert levers["clarke"] == pytest.approx((0.2746, 0.3447), abs=5e-4)
    assert levers["inoue"][0] == pytest.approx(levers["inoue"][1], rel=2e-3)
    assert levers["norrbin"] == pytest.approx((0.365, 0.350), abs=5e-4)


@pytest.mark.parametrize(
    ("method", "expected"),
    [
        ("wagner-smitt", (-0.01178, 0.00237, -0.00460, -0.00156)),
        ("norrbin", (-0.01284, 0.00328, -0.00459, -0.00277)),
        ("inoue", (-0.01296, 0.00371, -0.00472, -0.00200)),
        ("clarke", (-0.01239, 0.00311, -0.00457, -0.00211)),
    ],
)
def test_s175_by_the_four_formulas(method, expected):
    values = estimate(load_ship("s175"), method).values
    for name, value in zip(("Yv", "Yr", "Nv", "Nr"), expected, strict=True):
        assert values[name] == pytest.approx(value, abs=6e-6)
    for name, value in (("Yvdot", -0.00861), ("Yrdot", -5e-4), ("Nvdot", -2.8e-4)):
        assert values[name] == pytest.approx(value, abs=6e-6)


@pytest.mark.parametrize("method", METHODS)
def test_a_slender_hull_of_no_draught_has_no_side_force(method):
    flat = replace(load_ship("kcs"), d=1e-6, volume=0.65 * 230 * 32.2 * 1e-6)
    values = estimate(flat, method).values
    if METHODS[method].convention.system == "prime":
        assert abs(values["Yv"]) < 1e-6


def test_added_mass_of_kvlcc2_and_kcs_is_near_what_their_models_have():
    for name, my in (("kvlcc2", 0.223), ("kcs", 0.1552)):
        found = -zhou_added_mass(load_ship(name))["Yvdot"]
        assert found == pytest.approx(my, rel=0.25)


def test_rudder_values_of_kvlcc2_are_near_the_measured_ones():
    found = rudder_values(load_ship("kvlcc2"), area=112.5, aspect=1.827, D=9.86)
    published = load_model("kvlcc2").values("rudder_mmg")
    assert found["lift_slope"] == pytest.approx(published["lift_slope"], rel=1e-3)
    assert found["aH"] == pytest.approx(published["aH"], rel=0.2)
    assert found["gamma_positive"] == pytest.approx(0.44, abs=0.1)


@pytest.mark.parametrize("method", ["yoshimura-masumoto", "kijima"])
def test_an_estimated_model_turns_and_says_what_it_is(method):
    model = estimated_model(
        load_ship("kvlcc2"), method, speed=7.97, propeller_diameter=9.86, rudder_area=112.5
    )
    assert all(
        part.source_of(name).startswith("empirical")
        for part in model.parts.values()
        for name in part.values
    )
    found = simulate(model, speed=7.97, compiled=False).metrics
    assert found["tactical_diameter_L"] == pytest.approx(3.0, rel=0.35)


def test_linear_methods_do_not_carry_a_manoeuvre():
    with pytest.raises(MissingPartError, match="linear"):
        estimated_model(
            load_ship("kcs"), "clarke", speed=12.0, propeller_diameter=7.9, rudder_area=45.0
        )
    with pytest.raises(UnknownNameError, match="norrbin"):
        estimate(load_ship("kcs"), "guess")
