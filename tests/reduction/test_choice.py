"""The structure that the runs choose themselves."""

from __future__ import annotations

import numpy as np
import pytest

import pmmkit as pk
from pmmkit.api import model_of
from pmmkit.models import Standing
from pmmkit.models.estimates import COUPLINGS
from pmmkit.reduction import reduce_campaign
from tests.support import second_tank

ROOT_TESTS = ("static_drift", "pure_sway", "pure_yaw")


@pytest.fixture(scope="module")
def tanker():
    return second_tank.campaign("small", 1, 0.002, 0.001, lambda rng: rng.standard_normal())


def reduced(made, structure="auto"):
    return reduce_campaign(made, structure=structure, check=False, executor=1)


def only(made, *tests):
    return made.with_(runs=tuple(run for run in made if run.test in tests))


@pytest.mark.slow
def test_yaw_with_drift_shows_the_coupling(tanker):
    """The tank's hull is cubic with coupling, and nothing of it is lost by not asking for it."""
    found = reduced(tanker)
    assert found.table.provenance["structure"] == "abkowitz3"
    asked = reduced(tanker, "abkowitz3")
    assert found.table.names == asked.table.names
    assert found.table.value == pytest.approx(asked.table.value, rel=1e-10)
    assert found.table.std == pytest.approx(asked.table.std, rel=1e-10)


@pytest.mark.slow
def test_drift_sway_and_yaw_alone_leave_the_coupling_out_and_say_so(tanker):
    found = reduced(only(tanker, *ROOT_TESTS))
    assert found.table.provenance["structure"] == "cubic"
    assert (
        "abkowitz3 has 4 terms that they do not show (Nvrr, Nvvr, Yvrr and Yvvr)" in found.notes[0]
    )


@pytest.mark.slow
def test_what_the_runs_do_not_show_is_estimated_in_the_model_and_not_left_out(tanker):
    """Whichever structure is named: no name says that a coupling is zero."""
    made = only(tanker, *ROOT_TESTS)
    asked, *others = (model_of(reduced(made, name)) for name in ("abkowitz3", "auto", "cubic"))
    for name in COUPLINGS:
        for each in others:
            own, other = (each.part("hull_polynomial") for each in (each, asked))
            assert own.source_of(name).startswith("empirical")
            assert own.values[name] == pytest.approx(other.values[name], rel=0.01)
            assert own.std[name] > 0


@pytest.mark.slow
def test_couplings_that_runs_show_and_nobody_asked_for_are_open_in_bands(tanker):
    """They are zero, which the standing tells, and differ among ships by what estimates are."""
    model = model_of(reduced(tanker, "cubic"))
    assert not set(COUPLINGS) & set(model.part("hull_polynomial").values)
    speed = model.ship.speed(model.Fn[0], model.water.g)
    assert Standing.of(model, speed).uncoupled
    many = pk.monte_carlo(model, speed=speed, n=200, rudder_deg=35.0)
    assert set(COUPLINGS) <= set(many.names)
    assert many.standing.uncoupled
    full = model_of(reduced(tanker, "abkowitz3"))
    truth = pk.simulate(full, speed=speed, rudder_deg=35.0).metrics["tactical_diameter_L"]
    low, high = many.interval("tactical_diameter_L")
    assert low < truth < high
    found = pk.simulate(model, speed=speed, rudder_deg=35.0).metrics["tactical_diameter_L"]
    assert many.nominal["tactical_diameter_L"] == pytest.approx(found, rel=1e-6)


def test_drift_alone_determines_no_structure_and_gives_what_it_shows(tanker):
    """Yv and Nv as of all tests together; what only a turn shows is named, and is no number."""
    drift, whole = reduced(only(tanker, "static_drift")), reduced(tanker)
    (note,) = [text for text in drift.notes if text.startswith("Structure ")]
    assert "no structure is determined by these runs" in note
    assert "Nr" in note
    assert "Yr" in note
    assert np.isnan(drift.table.value[:, drift.table.names.index("Nr")]).all()
    for name in ("Yv", "Nv"):
        (value, std), (other, spread) = (
            (item.table.value[0, k], item.table.std[0, k])
            for item in (drift, whole)
            for k in [item.table.names.index(name)]
        )
        assert abs(value - other) < 3 * np.hypot(std, spread)
