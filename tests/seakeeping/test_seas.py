"""Spectra have the height and the periods that were asked."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pmmkit.base import DataError, UnknownNameError
from pmmkit.seakeeping import Sea, sea, sea_states
from pmmkit.seakeeping.seas import state_of


def numerically(found: Sea, n: int) -> float:
    """m_n by quadrature alone, to 200 times the peak."""
    omega = np.geomspace(0.2 * found.peak, 200 * found.peak, 200_001)
    return float(np.trapezoid(omega ** (n + 1) * found.spectrum(omega), np.log(omega)))


@given(st.floats(0.1, 15), st.floats(3, 20), st.floats(1, 7), st.sampled_from(["Tp", "T1", "Tz"]))
def test_height_and_period_are_those_asked(height, period, gamma, which):
    found = sea("jonswap", Hs=height, gamma=gamma, **{which: period})
    assert 4 * math.sqrt(found.moment(0)) == pytest.approx(height, rel=1e-12)
    assert getattr(found, which) == pytest.approx(period, rel=1e-12)


@pytest.mark.parametrize("gamma", [1.0, 3.3, 7.0])
@pytest.mark.parametrize(("n", "tolerance"), [(0, 1e-8), (1, 1e-6), (2, 5e-5)])
def test_moments_are_the_integrals_of_the_spectrum(gamma, n, tolerance):
    """m₂ beyond 200 peaks holds 1/(2·200²) of ω⁻⁵ that the quadrature leaves out."""
    found = Sea(Hs=4.0, Tp=9.7, gamma=gamma)
    assert numerically(found, n) == pytest.approx(found.moment(n), rel=tolerance)


def test_form_of_ittc_is_that_with_173_and_691_to_their_rounding():
    """S = 173 H²/(T1⁴ω⁵) exp(-691/(T1⁴ω⁴)), ITTC; .772 and .920 are analytic."""
    found = sea("ittc", Hs=4.0, T1=8.0)
    omega = np.linspace(0.35, 2.0, 50)
    stated = 173 * 16 / (8.0**4 * omega**5) * np.exp(-691 / (8.0**4 * omega**4))
    assert found.spectrum(omega) == pytest.approx(stated, rel=5e-3)
    assert found.T1 / found.Tp == pytest.approx(0.7718, abs=1e-4)
    assert found.Tz / found.T1 == pytest.approx(0.9205, abs=1e-4)


def test_pierson_and_moskowitz_by_wind_is_their_formula():
    """S = 8.1e-3 g²/ω⁵ exp(-.74 (g/(Uω))⁴)."""
    omega, wind, g = np.linspace(0.2, 3.0, 60), 15.0, 9.81
    stated = 8.1e-3 * g**2 / omega**5 * np.exp(-0.74 * (g / (wind * omega)) ** 4)
    found = sea("pierson_moskowitz", wind=wind)
    assert found.spectrum(omega) == pytest.approx(stated, rel=1e-10)
    again = sea("pierson_moskowitz", Hs=found.Hs)
    assert again.Tp == pytest.approx(found.Tp, rel=1e-12)


def test_spectrum_is_nothing_at_no_frequency():
    assert (Sea(Hs=3.0, Tp=8.0).spectrum([0.0, 1e-9, 1e-3]) == 0.0).all()


@given(st.integers(3, 40), st.sampled_from([2, 4, 10]), st.floats(0, 360))
def test_spreading_has_weight_one_about_its_mean(count, power, mean):
    headings, weights = Sea(Hs=1.0, Tp=8.0, spreading=power).directions(mean, count)
    assert weights.sum() == pytest.approx(1.0)
    assert weights @ headings == pytest.approx(mean)
    assert (np.abs(headings - mean) < 90).all()


def test_states_of_the_sea_leave_no_gap():
    states = sea_states()
    assert [state.code for state in states] == list(range(10))
    assert all(a.highest == b.lowest for a, b in pairwise(states))
    assert state_of(4.0).code == 5
    assert state_of(30.0).code == 9


@pytest.mark.parametrize(
    ("given_", "says"),
    [
        ({"form": "jonswap", "Hs": 3.0}, "one of Tp, T1, Tz"),
        ({"form": "ittc", "Hs": 3.0, "T1": 8.0, "Tz": 7.0}, "2 are given"),
        ({"form": "ittc", "T1": 8.0}, "needs Hs"),
        ({"form": "pierson_moskowitz", "Hs": 3.0, "Tp": 8.0}, "bretschneider"),
        ({"form": "ittc", "Hs": 3.0, "T1": 8.0, "gamma": 2.0}, "jonswap"),
        ({"form": "bretschneider", "Hs": math.nan, "Tp": 8.0}, "Hs"),
        ({"form": "bretschneider", "Hs": 2.0, "Tp": -8.0}, "Tp"),
        ({"form": "bretschneider", "Hs": 2.0, "Tp": 8.0, "spreading": 3}, "even power"),
    ],
)
def test_a_sea_that_is_not_known_is_refused(given_, says):
    with pytest.raises(DataError, match=says):
        sea(**given_)


def test_an_unknown_form_lists_those_there_are():
    with pytest.raises(UnknownNameError, match="bretschneider"):
        sea("torsethaugen", Hs=1.0, Tp=8.0)
