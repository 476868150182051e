"""An effect in Python whose words LLVM is not told: Python runs it, with the same numbers."""

from __future__ import annotations

import pytest

import pmmkit as pk
from pmmkit.effects import CATALOGUE
from pmmkit.equations import compilation, run


def listed_keel(v, L, rho, size):
    """A keel that drags with the square of the sway velocity."""
    shares = [size * abs(v) * v, 0.0]
    return (0.5 * rho * L * L * sum([2.0 * share for share in shares]) / 2.0,)


@pytest.fixture
def ship():
    """The S175 with a keel whose force is written as no other effect's is."""
    compilation.compiled.cache_clear()
    known = pk.effect(
        family="hull",
        outputs=("Y",),
        parameters=(pk.Parameter(name="size", text="over ½ρL²", typical=-0.01),),
        check="static drift in steps of 1°",
    )(listed_keel)
    yield pk.with_effect(pk.load_model("s175-3dof"), known.name, coefficients={"size": -0.01})
    CATALOGUE.forget(known.name)


TURN = {"rudder_deg": 35, "speed": 9.0}


def test_it_is_said_and_the_numbers_are_those_of_python(ship):
    by_python = pk.simulate(ship, compiled=False, **TURN)
    with pytest.warns(UserWarning, match=r"interpreted.*in effect_listed_keel"):
        told = pk.simulate(ship, compiled=True, **TURN)
    assert told.metrics == by_python.metrics
    with pytest.warns(UserWarning, match="interpreted"):
        many = pk.monte_carlo(ship, n=2, spread=0.05, **TURN)
    diameter = by_python.metrics["tactical_diameter_L"]
    assert many.nominal["tactical_diameter_L"] == pytest.approx(diameter, rel=1e-9)


def test_a_ship_that_sails_often_goes_on_sailing(ship, monkeypatch):
    monkeypatch.setattr(run, "ENOUGH", 100)
    first = pk.simulate(ship, **TURN)
    with pytest.warns(UserWarning, match="interpreted"):
        second = pk.simulate(ship, **TURN)
    assert second.metrics == first.metrics
