"""Roll damping by Ikeda's simple formulas: sizes, what each grows with, and their range."""

from __future__ import annotations

import math

import numpy as np
import pytest
from few_stations import thinned

from pmmkit.base import DataError
from pmmkit.seakeeping import Loading, RollDamping, hull_from_particulars, rao

HULL = thinned(
    hull_from_particulars(name="ship", L=175.0, B=25.4, d=9.5, block=0.57, midship=0.966)
)
LOADING = Loading.of(HULL, GM=1.0, kxx=8.33)
KEELS = {"keel_breadth": 0.45, "keel_length": 43.75}


def parts(found):
    return found.friction + found.eddies + found.keels + found.lift


def test_linear_and_quadratic_part_give_the_whole_at_the_amplitude():
    found = RollDamping.of(HULL, LOADING, speed=5.0, **KEELS)
    rate = found.omega * math.radians(10)
    equivalent = found.roll_damping + 8 / (3 * math.pi) * rate * found.roll_quadratic
    assert equivalent == pytest.approx(parts(found))


@pytest.mark.slow
def test_sizes_are_those_of_a_ship_like_s175():
    """Bare a hundredth or so of critical at rest, keels double it, speed lifts it."""
    bare, keeled = (RollDamping.of(HULL, LOADING, **keels) for keels in ({}, KEELS))
    fast = RollDamping.of(HULL, LOADING, speed=10.0)
    assert 0.003 < parts(bare) < 0.03
    assert 1.5 * parts(bare) < parts(keeled) < 0.1
    assert 0.01 < fast.lift < 0.1
    assert bare.lift == bare.keels == 0.0
    assert 2 * math.pi / bare.omega == pytest.approx(18.0, abs=1.5)


@pytest.mark.slow
def test_lift_grows_with_speed_and_eddies_with_the_amplitude():
    slow, fast = (RollDamping.of(HULL, LOADING, speed=speed).lift for speed in (4.0, 8.0))
    assert fast == pytest.approx(2 * slow)
    small, large = (RollDamping.of(HULL, LOADING, amplitude_deg=x).eddies for x in (5.0, 10.0))
    assert large == pytest.approx(2 * small)


def test_it_enters_the_motions():
    found = RollDamping.of(HULL, LOADING, speed=5.0, **KEELS)
    damped = Loading(
        KG=LOADING.KG,
        kxx=LOADING.kxx,
        kyy=LOADING.kyy,
        kzz=LOADING.kzz,
        roll_damping=found.roll_damping,
        roll_quadratic=found.roll_quadratic,
    )
    omega = np.linspace(0.25, 0.5, 26)
    beam = rao(HULL, speeds=5.0, headings_deg=90.0, omega=omega, loading=damped, waves=1.0)
    peak = float(np.degrees(np.abs(beam.mode("roll")).max()))
    assert 3.0 < peak < 30.0
    assert "roll_quadratic" in str(found)


def test_a_ship_out_of_range_is_refused_with_what_is_out():
    barge = hull_from_particulars(name="barge", L=100.0, B=30.0, d=4.0, block=0.9, midship=0.998)
    with pytest.raises(DataError, match=r"CB = 0\.\d+, not 0\.5 to 0\.85; B/d = 7\.\d+"):
        RollDamping.of(barge, Loading.of(barge, GM=5.0))
    with pytest.raises(DataError, match="bilge keel length"):
        RollDamping.of(HULL, LOADING, keel_breadth=0.45, keel_length=150.0)
