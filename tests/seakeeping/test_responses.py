"""Responses in a sea: closed forms, published curves, limits; added resistance by each method."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from few_stations import thinned
from hypothesis import given
from hypothesis import strategies as st

from pmmkit.base import DataError, UnknownNameError
from pmmkit.plotting.layout import laid_out
from pmmkit.seakeeping import (
    Operability,
    Place,
    Sea,
    added_resistance,
    hull_from_particulars,
    rao,
    response,
    sea,
)
from pmmkit.seakeeping.figures import polar
from pmmkit.seakeeping.operating_limits import LIMITS
from pmmkit.seakeeping.responses import incidence_in_waves, moments
from pmmkit.seakeeping.second_order.added_resistance import ResistanceParticulars, snnm, stawave2
from pmmkit.seakeeping.second_order.mean_drift import (
    drift,
    drift_table,
    plate_reflection,
    scattering,
)
from pmmkit.seakeeping.sectional import solve

OMEGA = np.linspace(0.25, 2.2, 60)
SHIP = thinned(hull_from_particulars(name="ship", L=150.0, B=24.0, d=8.5, block=0.68))


@pytest.fixture(scope="module")
def moved():
    return rao(SHIP, speeds=[0.0, 8.0], headings_deg=np.arange(0, 181, 30), omega=OMEGA)


def test_following_waves_count_over_their_own_frequency():
    """With |H| = 1 the significant amplitude is that of the sea at any speed; m₂ is ∫ωₑ²S dω."""
    omega = np.linspace(0.2, 6.0, 6000)
    waves = Sea(Hs=4.0, Tp=9.0)
    encounter = omega - omega**2 * 10.0 / 9.81
    found = moments(np.ones_like(omega) + 0j, encounter, omega, waves)
    assert 2 * found.significant == pytest.approx(4.0, rel=2e-3)
    assert found.m2 == pytest.approx(
        np.trapezoid(encounter**2 * waves.spectrum(omega), omega), rel=1e-12
    )


def test_extremes_are_those_of_rayleigh():
    found = moments(np.ones_like(OMEGA) + 0j, OMEGA, OMEGA, Sea(Hs=4.0, Tp=9.0))
    count = 3 * 3600 / found.period
    assert found.extreme(3.0) == pytest.approx(math.sqrt(2 * found.m0 * math.log(count)))
    assert found.exceeded(found.significant) == pytest.approx(math.exp(-2.0))


def test_responses_grow_with_the_height_of_the_waves(moved):
    small, large = (
        response(moved, Sea(Hs=h, Tp=10.0), speed=8.0, heading_deg=180) for h in (1.0, 3.0)
    )
    for mode in ("heave", "pitch"):
        ratio = large.motions[mode].significant / small.motions[mode].significant
        assert ratio == pytest.approx(3.0)


def test_a_short_crested_sea_rolls_a_ship_in_head_seas(moved):
    long = response(moved, Sea(Hs=3.0, Tp=10.0), speed=8.0, heading_deg=180)
    short = response(moved, Sea(Hs=3.0, Tp=10.0, spreading=2), speed=8.0, heading_deg=180)
    assert long.motions["roll"].significant < 1e-6
    assert short.motions["roll"].significant > math.radians(0.1)


def test_at_the_bow_it_is_worse_than_amidships(moved):
    bow = Place(name="bow", x=70.0, freeboard=6.0, draught=8.5)
    found = response(
        moved,
        Sea(Hs=5.0, Tp=10.0),
        speed=8.0,
        heading_deg=180,
        places=[Place(name="midship", x=0.0), bow],
    )
    midship, ahead = found.places
    assert ahead.acceleration.significant > 1.5 * midship.acceleration.significant
    assert ahead.incidence > midship.incidence
    assert ahead.dose > midship.dose
    assert ahead.wet == pytest.approx(math.exp(-36 / (2 * ahead.relative.m0)))
    assert 0 < ahead.slam < ahead.relative.exceeded(8.5)
    assert midship.wet is None
    assert "bow" in str(found)


def test_sickness_is_worst_near_a_sixth_of_a_hertz_and_grows_with_time():
    def share(f, hours=2.0):
        return incidence_in_waves(1.0, (2 * math.pi * f) ** 2, hours)

    frequencies = np.linspace(0.08, 0.5, 85)
    worst = frequencies[np.argmax([share(f) for f in frequencies])]
    assert worst == pytest.approx(0.16, abs=0.02)
    assert share(0.17, 0.5) < share(0.17, 2.0) < share(0.17, 8.0)
    assert incidence_in_waves(0.0, 0.0, 2.0) == 0.0


def test_what_was_not_computed_is_refused(moved):
    waves = Sea(Hs=3.0, Tp=10.0)
    with pytest.raises(DataError, match="Say which speed"):
        response(moved, waves, heading_deg=180)
    with pytest.raises(DataError, match="was not computed"):
        response(moved, waves, speed=5.0, heading_deg=180)
    with pytest.raises(DataError, match="of the energy of the sea"):
        response(moved, Sea(Hs=3.0, Tp=25.0), speed=8.0, heading_deg=180)
    head = rao(SHIP, speeds=8.0, omega=OMEGA)
    with pytest.raises(DataError, match="both sides"):
        response(head, replace(waves, spreading=2))


def test_nothing_is_summed_over_a_sea_of_which_a_part_is_missing(moved):
    short = Sea(Hs=4.0, Tp=3.0)
    for summed in (
        lambda: drift_table(moved, short, speed=8.0),
        lambda: added_resistance(moved).mean(short, speed=8.0, heading_deg=180),
        lambda: response(moved, short, speed=8.0, heading_deg=180),
    ):
        with pytest.raises(DataError, match=r"% of the energy of the sea.*sea=\.\.\."):
            summed()
    found = rao(SHIP, speeds=8.0, sea=short)
    assert found.share_of(short) > 0.98


def test_what_lies_beyond_the_last_frequency_is_held():
    """The mean of a method that is known at all frequencies hardly depends on where they end."""
    sea = Sea(Hs=4.0, Tp=7.5)
    cut, whole = (
        added_resistance(rao(SHIP, speeds=8.0, omega=np.linspace(0.3, highest, 60))).mean(sea)
        for highest in (1.6, 3.2)
    )
    for method in ("SNNM", "with reflection"):
        assert cut[method] == pytest.approx(whole[method], rel=0.03)


def test_short_waves_are_reflected_in_full_by_a_wall(moved):
    """In beam seas ½ρgζ² over the length; waves run to starboard, y is to port."""
    wall = 0.5 * 1025 * 9.81 * (SHIP.x[-1] - SHIP.x[0])
    X, Y, _ = drift(moved)[:, 0, 3]
    assert -Y[-1] == pytest.approx(wall, rel=0.1)
    assert abs(X[-1]) < 0.02 * wall
    assert plate_reflection(np.array([5.0]))[0] == pytest.approx(1.0, abs=1e-6)


def test_long_waves_carry_the_ship_and_push_nothing(moved):
    """A ship that moves with the water scatters nothing; heave at resonance does."""
    Y = -drift(moved)[1, 0, 3] / (0.5 * 1025 * 9.81 * 150.0)
    assert np.abs(Y[OMEGA < 0.5]).max() < 0.02
    assert Y.min() > -0.02


@given(st.floats(-3.1, 3.1), st.floats(-3.1, 3.1), st.floats(0.01, 3.0))
def test_a_fixed_section_keeps_the_energy_of_the_waves(heave, sway, size):
    back, through = scattering(size * np.exp(1j * np.array([[heave], [sway]])))
    assert np.abs(back) ** 2 + np.abs(through) ** 2 == pytest.approx(1.0)


def test_a_half_circle_lets_long_waves_through_and_sends_short_ones_back():
    far = solve(np.array([[1.0, 0.0, 0.0]]), np.array([1e-3, 0.5, 5.0])).far[:, :, 0]
    back, through = scattering(far * np.array([[-1j], [-1], [-1]]))
    assert np.abs(back[0]) < 0.01
    assert np.abs(through[0] - 1) < 0.01
    assert np.abs(through[2]) < 0.05
    assert 0.2 < np.abs(back[1]) < 0.95


def test_drift_is_alike_on_both_sides():
    found = rao(SHIP, speeds=6.0, headings_deg=[130.0, 230.0], omega=[0.5, 0.9])
    X, Y, N = drift(found)
    np.testing.assert_allclose(X[:, 0], X[:, 1], rtol=1e-9)
    np.testing.assert_allclose(Y[:, 0], -Y[:, 1], rtol=1e-9)
    np.testing.assert_allclose(N[:, 0], -N[:, 1], rtol=1e-9)
    assert (Y[:, 0] < 0).all()


def test_methods_agree_on_the_size_of_the_peak_in_head_seas(moved):
    found = added_resistance(moved)
    at_speed = [x[1, -1] for x in found.methods.values() if np.isfinite(x[1, -1]).any()]
    peaks = [np.nanmax(values) for values in at_speed]
    assert len(peaks) == 5
    assert max(peaks) < 3.0 * min(peaks)
    assert np.isnan(found.methods["STAWAVE-2"][1, 2]).all()
    told = found.mean(sea("bretschneider", Hs=3.0, Tp=9.0), speed=8.0, heading_deg=180)
    assert 2e4 < told["SNNM"] < 1e6
    assert math.isfinite(told["STAWAVE-2"])


def test_formulas_read_as_their_sources_do():
    """STAWAVE-2 at its peak is 4 a₁ Fn^1.5 e^(-3.5 Fn); SNNM at the peak in head seas likewise."""
    form = ResistanceParticulars(
        L=200.0, B=32.0, d=12.0, block=0.8, kyy=0.25, entrance=50.0, run=55.0
    )
    g, fn = 9.81, 0.18
    U = np.array([fn * math.sqrt(g * form.L)])
    peak = 1.17 * fn**-0.143 / math.sqrt(form.L / g) / 0.25 ** (1 / 3)
    found = stawave2(form, U, np.array([math.pi]), np.array([peak]), 1025.0, g)[0, 0, 0]
    moving = 4 * 60.3 * 0.8**1.34 * fn**1.5 * math.exp(-3.5 * fn)
    unit = 1025 * g * 32**2 / 200
    assert moving < found / unit < 1.25 * moving
    long = snnm(form, U, np.array([math.pi]), np.array([0.15]), 1025.0, g)
    assert 0 <= long[0, 0, 0] / unit < 0.05


def test_a_ship_out_of_range_has_no_stawave2():
    form = ResistanceParticulars(
        L=50.0, B=10.0, d=3.0, block=0.6, kyy=0.25, entrance=15.0, run=15.0
    )
    U = np.array([0.2 * math.sqrt(9.81 * 50)])
    assert np.isnan(stawave2(form, U, np.array([math.pi]), OMEGA, 1025.0, 9.81)).all()


def test_added_resistance_of_a_short_crested_sea_is_the_mean_over_its_directions(moved):
    found, waves = added_resistance(moved), Sea(Hs=3.0, Tp=9.0)
    spread = replace(waves, spreading=2)
    short = found.mean(spread, speed=8.0, heading_deg=180)["SNNM"]
    each = [found.mean(waves, speed=8.0, heading_deg=x)["SNNM"] for x in (90, 120, 150, 180)]
    assert min(each) < short < max(each)
    narrow = found.mean(replace(waves, spreading=2000), speed=8.0, heading_deg=180)["SNNM"]
    assert narrow == pytest.approx(each[-1], rel=1e-6)


def test_a_table_of_drift_is_of_a_long_crested_sea_over_all_headings(moved):
    table = drift_table(moved, Sea(Hs=1.0, Tp=9.0), speed=8.0)
    assert table["angle_deg"] == pytest.approx(np.arange(0, 181, 30))
    assert table["DY"][0] == pytest.approx(0.0, abs=1e-9)
    twice = drift_table(moved, Sea(Hs=2.0, Tp=9.0), speed=8.0)
    assert twice["DX"] == pytest.approx(table["DX"])
    with pytest.raises(DataError, match="spreading"):
        drift_table(moved, Sea(Hs=1.0, Tp=9.0, spreading=2), speed=8.0)
    with pytest.raises(DataError, match="both ends"):
        drift_table(rao(SHIP, speeds=8.0, omega=OMEGA), Sea(Hs=1.0, Tp=9.0))


@pytest.mark.slow
def test_operability_is_each_value_over_its_limit(moved):
    bow, waves = Place(name="bow", x=70.0, freeboard=6.0, draught=8.5), Sea(Hs=4.0, Tp=9.0)
    found = Operability.of(moved, waves, places=[bow])
    assert set(found.ratios) == set(LIMITS)
    one = response(moved, waves, speed=8.0, heading_deg=180, places=[bow])
    wanted = math.sqrt(one.places[0].acceleration.m0) / LIMITS["acceleration"]
    assert found.ratios["acceleration"][1, -1] == pytest.approx(wanted)
    calm = Operability.of(moved, Sea(Hs=0.1, Tp=9.0), places=[bow])
    storm = Operability.of(moved, Sea(Hs=14.0, Tp=12.0), places=[bow])
    assert storm.share < found.share <= calm.share == 1.0
    assert found.plot().axes
    with pytest.raises(UnknownNameError, match="roll_deg"):
        Operability.of(moved, waves, limits={"heel": 3.0})
    with pytest.raises(DataError, match="nothing to judge"):
        Operability.of(moved, waves, limits={"wet": 0.05})


def test_the_picture_of_motions_shows_the_greatest_speed_and_head_seas():
    few = np.array([0.4, 0.6, 0.9])
    found = rao(SHIP, speeds=(0.0, 4.0, 8.0), headings_deg=np.arange(0, 181, 30), omega=few)
    figure = found.plot()
    shown = {line.label for line in figure.axes[0].points}
    ends = {(speed, heading) for speed in ("0.00", "8.00") for heading in ("0°", "180°")}
    assert len(shown) == 8
    assert ends <= {(text.split()[0], text.split()[-1]) for text in shown}
    assert not any(text.startswith("4.00") for text in shown)


def test_around_a_ship_the_bow_is_up_and_port_mirrors_starboard():
    figure = polar(
        np.array([0.0, 90.0, 180.0]),
        {"8.00 m/s": np.array([1.0, 2.0, 0.5])},
        limit=1.5,
        label="largest value over its limit",
    )
    (axis,) = figure.axes
    curves = {line.label: np.stack([line.x, line.y], axis=1) for line in axis.points if line.label}
    seas = [(0.0, 0.5), (2.0, 0.0), (0.0, -1.0)]
    mirrored = [(0.0, -1.0), (-2.0, 0.0), (0.0, 0.5)]
    assert curves["8.00 m/s"] == pytest.approx(np.array(seas + mirrored), abs=1e-12)
    assert np.hypot(*curves["limit"].T) == pytest.approx(1.5)
    for words in axis.words:
        if words.text.endswith("°"):
            bearing = np.degrees(np.arctan2(words.x, words.y)) % 360
            assert bearing == pytest.approx(float(words.text[:-1]), abs=1e-9)
        else:
            assert np.hypot(words.x, words.y) == pytest.approx(float(words.text))
    scene = laid_out(figure)
    (frame,) = scene.frames
    (left, right), (low, high) = frame.x, frame.y
    assert frame.box.width / (right - left) == pytest.approx(frame.box.height / (high - low))
    for one, other in combinations([own.box for own in scene.letters], 2):
        assert (
            one.right <= other.left
            or other.right <= one.left
            or one.bottom <= other.top
            or other.bottom <= one.top
        )
