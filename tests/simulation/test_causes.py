"""What decides a metric: derivatives with a covariance, and values of other parts beside them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pmmkit.models import load_model
from pmmkit.simulation import Bands, Spread, monte_carlo, sensitivities, simulate

SHIP = load_model("s175-3dof")
RUDDER = SHIP.parts["rudder_mmg"]
MEASURED = SHIP.with_(
    parts={**SHIP.parts, "rudder_mmg": replace(RUDDER, std={"aH": 0.05})},
    covariance=np.diag([1e-4, 4e-4]) ** 2,
    covariance_names=("Nr", "Nv"),
)


def test_an_estimate_of_a_part_has_its_slope_and_share_beside_the_measured_derivatives():
    found = sensitivities(MEASURED, speed=9.0)
    assert found.names == ("Nr", "Nv", "rudder_mmg.aH")
    aH, step = RUDDER.values["aH"], 1e-4
    ends = [
        simulate(
            MEASURED.with_values("rudder_mmg", aH=aH + side * step), speed=9.0, rtol=1e-11
        ).metrics["advance"]
        for side in (-1, 1)
    ]
    slope = found.slopes["advance"][2]
    assert slope == pytest.approx((ends[1] - ends[0]) / (2 * step), rel=1e-5)
    own = (found.slopes["advance"] * np.array([1e-4, 4e-4, 0.05])) ** 2
    shares = found.table("advance")["share_of_variance"]
    assert shares["rudder_mmg.aH"] == pytest.approx(own[2] / own.sum())


def test_estimates_alone_have_shares_as_the_ships_that_are_drawn_differ_by_them():
    """A model that states nothing of its derivatives: `monte_carlo` draws its rudder, and both say
    the same of a circle."""
    made = MEASURED.with_(covariance=None, covariance_names=())
    found = sensitivities(made, speed=9.0)
    assert found.names == ("rudder_mmg.aH",)
    assert found.shares("advance").tolist() == [1.0]
    drawn = monte_carlo(made, speed=9.0, n=400, seed=2).metrics["advance"].std(ddof=1)
    assert found.std("advance") == pytest.approx(drawn, rel=0.1)


STOP = {"speed": 8.0, "spread": 0.05}


def test_revolutions_astern_that_nobody_states_are_a_cause_of_a_stop():
    found = sensitivities("kvlcc2", "stopping", **STOP)
    assert found.settings == found.names[-1:] == ("turns",)
    turns, step = found.values[-1], 1e-3
    ends = [
        simulate("kvlcc2", "stopping", speed=8.0, turns=turns + side * step, rtol=1e-11)
        for side in (-1, 1)
    ]
    slope = (ends[1].metrics["head_reach"] - ends[0].metrics["head_reach"]) / (2 * step)
    assert found.slopes["head_reach"][-1] == pytest.approx(slope, rel=1e-4)
    stated = sensitivities("kvlcc2", "stopping", turns=turns, **STOP)
    assert stated.settings == ()
    more = found.std("head_reach") ** 2 - stated.std("head_reach") ** 2
    assert found.shares("head_reach")[-1] == pytest.approx(more / found.std("head_reach") ** 2)


def test_the_ships_of_a_band_are_those_of_monte_carlo_in_a_stop_too():
    """Same seed, same ships: they differ in the revolutions astern as well as in what is drawn."""
    n = {"n": 20, "seed": 3, **STOP}
    band, many = Bands.of("kvlcc2", "stopping", **n), monte_carlo("kvlcc2", "stopping", **n)
    for name, ends in band.measures.items():
        assert ends == pytest.approx(many.interval(name), rel=1e-5, abs=1e-9), name


def test_a_derivative_is_drawn_where_it_is_known_whatever_is_not_known_at_other_speeds():
    two = SHIP.with_(
        Fn=(0.15, 0.25),
        covariance=np.diag([1e-4, 4e-4, 1e-4, np.nan]) ** 2,
        covariance_names=("Nr", "Nv"),
    )
    names = {Fn: Spread.of(two, two.ship.speed(Fn, two.water.g)).names for Fn in (0.15, 0.2)}
    assert names == {0.15: ("Nr", "Nv"), 0.2: ("Nr",)}


def test_values_of_parts_keep_their_sign_in_all_that_is_drawn():
    wide = MEASURED.with_(
        parts={**SHIP.parts, "rudder_mmg": replace(RUDDER, std={"aH": 0.8 * RUDDER.values["aH"]})}
    )
    drawn = Spread.of(wide, 9.0)
    for law in (drawn, drawn.independent):
        values = law.of_normal(np.linspace(-4, 4, 9)[:, None] * np.ones(3))
        assert (values[:, 2] > 0.0).all()
        np.testing.assert_allclose(values[4], law.mean)
