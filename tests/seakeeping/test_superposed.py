"""Motions at the frequency of waves along a path: spectra, mirror images, what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from few_stations import thinned

from pmmkit.base import DataError
from pmmkit.models import load_model
from pmmkit.seakeeping import Loading, Sea, rao, response, superposed
from pmmkit.seakeeping.hull_forms.particulars import hull_of
from pmmkit.simulation import simulate

SEA = Sea(Hs=3.0, Tp=10.0)
SHIP = load_model("s175-3dof")
SPEED = 8.0


@pytest.fixture(scope="module")
def found():
    return rao(
        thinned(hull_of(SHIP.ship)),
        speeds=[0.0, SPEED],
        headings_deg=np.arange(0, 181, 20),
        omega=np.linspace(0.3, 1.6, 40),
    )


@pytest.fixture(scope="module")
def straight():
    return simulate(SHIP, "straight", speed=SPEED, duration=3000.0, compiled=False)


@pytest.mark.slow
@pytest.mark.parametrize(("from_deg", "heading"), [(0.0, 180.0), (60.0, 120.0), (-60.0, 120.0)])
def test_a_straight_course_has_the_spectrum_of_the_response(found, straight, from_deg, heading):
    """2σ is the significant amplitude, and crossings come with the period of encounter."""
    moved = superposed(straight, found, SEA, from_deg=from_deg, seed=2)
    rows = response(found, SEA, speed=SPEED, heading_deg=heading).rows()
    wanted = {row["response"]: row for row in rows}
    for name in ("heave", "pitch"):
        values = moved.values[name]
        assert 2 * np.std(values) == pytest.approx(wanted[name]["significant"], rel=0.06)
        up = np.flatnonzero((values[:-1] < 0) & (values[1:] >= 0))
        period = (moved.t[up[-1]] - moved.t[up[0]]) / (up.size - 1)
        assert period == pytest.approx(wanted[name]["period"], rel=0.06)
    assert 4 * np.std(moved.values["elevation"]) == pytest.approx(3.0, rel=0.05)


@pytest.mark.slow
def test_waves_from_port_are_the_mirror_image(found, straight):
    port, starboard = (
        superposed(straight, found, SEA, from_deg=side * 50.0, seed=1).waves for side in (-1, 1)
    )
    for name, sign in {"x": 1, "y": -1, "psi": -1, "phi": -1, "heave": 1, "pitch": 1}.items():
        np.testing.assert_allclose(port[name], sign * starboard[name], atol=1e-9)


@pytest.mark.slow
def test_in_long_waves_the_ship_rides_the_crest_and_leans_with_the_slope():
    """At rest, waves from starboard: while the water rises its crest is to starboard, and the
    ship, stiff enough to follow the slope, leans to port."""
    hull = thinned(hull_of(SHIP.ship))
    stiff = rao(
        hull,
        speeds=0.0,
        headings_deg=[0.0, 90.0, 180.0],
        omega=np.linspace(0.2, 0.4, 20),
        loading=Loading.of(hull, GM=8.0, roll_damping=0.2),
    )
    still = simulate(SHIP, "straight", speed=0.01, duration=1500.0, compiled=False)
    waves = superposed(still, stiff, Sea(Hs=2.0, Tp=24.0, gamma=20.0), from_deg=90.0).waves
    assert np.corrcoef(waves["heave"], waves["elevation"])[0, 1] > 0.99
    assert np.corrcoef(waves["phi"], -np.gradient(waves["elevation"]))[0, 1] > 0.8


def test_a_seed_is_a_sea_and_the_path_stays_below_it(found):
    track = simulate(SHIP, rudder_deg=20, speed=SPEED, duration=500.0, compiled=False)
    one, same, other = (superposed(track, found, SEA, seed=seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(one.values["heave"], same.values["heave"])
    assert np.abs(one.values["heave"] - other.values["heave"]).max() > 0.3
    assert np.abs(one.values["x"] - np.interp(one.t, track.t, track.x)).max() < 3.0
    assert "seed 1" in str(one)


def test_what_cannot_be_superposed_is_refused(found, straight):
    with pytest.raises(DataError, match="long-crested"):
        superposed(straight, found, Sea(Hs=3.0, Tp=10.0, spreading=2))
    ahead = rao(thinned(hull_of(SHIP.ship)), speeds=SPEED, omega=[0.5, 0.8])
    with pytest.raises(DataError, match="headings"):
        superposed(straight, ahead, SEA)
