"""Motions by strip theory: limits, symmetries, and beside VERES 4.02.3, a computation too."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from few_stations import thinned

from pmmkit.base import DataError
from pmmkit.seakeeping import (
    Loading,
    Rao,
    Sea,
    hull_from_particulars,
    load_hull,
    rao,
    read_hull,
    read_rao,
)
from pmmkit.seakeeping.strips import coefficients, strips_of

SHIP = thinned(
    hull_from_particulars(name="ship", L=100.0, B=18.0, d=6.0, block=0.65, xB=-0.5, xF=-2.0)
)


@pytest.fixture(scope="module")
def veres(shared_data) -> Rao:
    return read_rao(shared_data / "s175_seakeeping_veres" / "input.re1")


@pytest.fixture(scope="module")
def s175(shared_data, veres) -> Rao:
    hull = read_hull(shared_data / "s175_seakeeping_veres" / "shipx_geometry.mgf", draught=9.5)
    return rao(
        hull,
        speeds=veres.speed,
        headings_deg=np.degrees(veres.heading),
        omega=veres.omega,
        loading=Loading(KG=9.55, kxx=8.331, kyy=42.0, kzz=42.0),
    )


def apart(found, veres, mode, speed, heading_deg, *, over_slope=False):
    """Root mean square over frequencies of what |RAO| differ by."""
    a, b = _place(found.speed, speed), _place(np.degrees(found.heading), heading_deg)
    c, d = _place(veres.speed, speed), _place(np.degrees(veres.heading), heading_deg)
    theirs = veres.motion[mode, c, d]
    off = np.abs(found.motion[mode, a, b]) - np.abs(theirs)
    off = off / found.wavenumber if over_slope else off
    return float(np.sqrt(np.mean(np.square(off[~found.quasi_static[a, b]]))))


def _place(values, wanted):
    return int(np.argmin(np.abs(np.asarray(values) - wanted)))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("speed", "heave", "pitch"),
    [(0.0, 0.006, 0.018), (7.7167, 0.014, 0.022), (10.2889, 0.016, 0.021)],
)
def test_heave_and_pitch_of_s175_in_head_seas_are_those_of_veres(s175, veres, speed, heave, pitch):
    """VERES has no moment of the pressure on the ends: pitch is .016 of the slope of long waves
    apart, as far as theirs is beyond its limit."""
    assert apart(s175, veres, 2, speed, 180) < heave
    assert apart(s175, veres, 4, speed, 180, over_slope=True) < pitch


@pytest.mark.slow
@pytest.mark.parametrize("heading", [180, 150, 120, 90, 60, 30, 0])
def test_s175_is_within_three_percent_of_veres_at_all_headings(s175, veres, heading):
    for speed in veres.speed:
        assert apart(s175, veres, 2, speed, heading) < 0.03
        assert apart(s175, veres, 4, speed, heading, over_slope=True) < 0.022
        assert apart(s175, veres, 1, speed, heading) < 0.03
        assert apart(s175, veres, 5, speed, heading, over_slope=True) < 0.035


@pytest.mark.slow
def test_s175_by_its_particulars_costs_five_hundredths_of_heave(veres):
    """Lewis forms with the centres and coefficients of its lines; without xF three times that."""
    hull = load_hull("s175-design")
    given = {"GM": 0.996, "kxx": 8.331, "kyy": 42.0, "kzz": 42.0}
    off = {}
    bare = hull_from_particulars(
        name="S175", L=175.0, B=25.4, d=9.5, block=0.569, waterplane=0.709, midship=0.966, xB=-2.547
    )
    for one in (hull, bare):
        found = rao(
            one,
            speeds=veres.speed[[0, 3, 4]],
            headings_deg=180.0,
            omega=veres.omega,
            loading=Loading.of(one, **given),
        )
        off[one.name] = [apart(found, veres, 2, speed, 180) for speed in veres.speed[[0, 3, 4]]]
    assert max(off[hull.name]) < 0.06
    assert max(off["S175"]) > 3 * max(off[hull.name])
    assert any("give xF" in note for note in bare.notes)
    assert not any("give xF" in note for note in hull.notes)


@pytest.mark.slow
def test_roll_of_s175_above_its_resonance(s175, veres):
    """Near resonance it hangs on a damping that VERES does not state."""
    above = s175.omega > 0.6
    for a in range(veres.speed.size):
        ours, theirs = (np.abs(x[3, a, 9, above]) for x in (s175.motion, veres.motion))
        assert np.abs(ours - theirs).max() < 1.2e-3 * np.abs(theirs).max() + 4e-4


@pytest.mark.slow
@pytest.mark.parametrize(
    ("heading", "bounds"),
    [
        (180, {"surge": 0.04, "heave": 0.06, "pitch": 0.045}),
        (120, {"surge": 0.03, "sway": 0.02, "heave": 0.07, "pitch": 0.04, "yaw": 0.1}),
        (60, {"surge": 0.06, "sway": 0.07, "heave": 0.1, "pitch": 0.014, "yaw": 0.12}),
    ],
)
def test_motions_of_s175_have_the_phases_of_veres(s175, veres, heading, bounds):
    """As complex numbers, so that an axis, a side or a direction that is turned is seen."""
    b = _place(np.degrees(veres.heading), heading)
    for mode, most in bounds.items():
        over = s175.wavenumber if mode in ("pitch", "yaw") else 1.0
        off = (s175.mode(mode) - veres.mode(mode))[3, b] / over
        assert np.nanmax(np.abs(off)) < most


@pytest.mark.parametrize("heading", [180.0, 135.0, 60.0, 90.0])
def test_very_long_waves_carry_the_ship_at_rest(heading):
    """It goes with the water, -i cos β ahead and i sin β to port of the crest, lifts and leans with
    the surface: heave to 1e-4, pitch to 2e-4, surge and sway to the volume of panels, roll to its
    damping, 2ζω/ωₙ = .003."""
    found = rao(SHIP, speeds=0.0, headings_deg=heading, omega=[0.01])
    (k,), beta = found.wavenumber, np.radians(heading)
    ahead, port = np.cos(beta), np.sin(beta)
    surge, sway, heave, roll, pitch, _ = found.motion[:, 0, 0, 0]
    assert not found.quasi_static.any()
    assert heave == pytest.approx(1.0, abs=1e-4)
    assert pitch / k == pytest.approx(1j * ahead, abs=2e-4)
    assert surge == pytest.approx(-1j * ahead, abs=1e-3)
    assert sway == pytest.approx(1j * port, abs=1e-3)
    assert roll / k == pytest.approx(1j * port, abs=3e-3)


def test_coefficients_ahead_are_those_astern_turned_about():
    """Timman and Newman (1962): a_jk(U) = a_kj(-U) of a hull that ends in points.

    Forward, the coupling of heave and pitch is far from the same both ways.
    """
    strips = strips_of(SHIP, 2.0)
    pointed = strips.sections.added.copy()
    pointed[..., 0] = 0.0
    strips = replace(strips, sections=replace(strips.sections, added=pointed))
    omega = np.array([0.6, 1.0, 1.5])
    ahead, astern = (coefficients(strips, np.array(U), omega) for U in (6.0, -6.0))
    scale = np.abs(ahead).max()
    np.testing.assert_allclose(ahead, astern.swapaxes(0, 1), rtol=1e-12, atol=1e-12 * scale)
    assert (np.abs(ahead[2, 4] - ahead[4, 2]) > np.abs(ahead[2, 4])).all()


def test_port_and_starboard_are_alike():
    found = rao(SHIP, speeds=[0.0, 6.0], headings_deg=[120.0, 240.0], omega=[0.5, 0.8, 1.2])
    signs = np.array([1, -1, 1, -1, 1, -1])[:, None, None]
    np.testing.assert_allclose(
        found.motion[:, :, 0], signs * found.motion[:, :, 1], rtol=1e-9, atol=1e-12
    )


def test_one_case_at_a_time_is_the_whole_table():
    """The grid of frequencies differs between the two; so does what is read off it, a little."""
    whole = rao(SHIP, speeds=[0.0, 7.0], headings_deg=[180.0, 130.0], omega=[0.4, 0.7, 1.0])
    one = rao(SHIP, speeds=7.0, headings_deg=130.0, omega=[0.7])
    np.testing.assert_allclose(
        one.motion[[2, 4], 0, 0, 0], whole.motion[[2, 4], 1, 1, 1], rtol=2e-3
    )


def test_slow_encounter_is_quasi_static_and_said():
    """The ship runs with waves of ω = g/U: ωₑ = 0; it overtakes shorter ones."""
    omega = np.array([0.4, 9.81 / 12.0, 1.2])
    found = rao(SHIP, speeds=12.0, headings_deg=0.0, omega=omega)
    assert found.quasi_static[0, 0].tolist() == [False, True, False]
    assert np.isfinite(found.mode("heave")).all()
    assert np.isnan(found.mode("surge")[0, 0, 1])
    assert found.encounter[0, 0, 2] < 0
    told = " ".join(found.notes)
    assert "quasi-static" in told
    assert "surf-riding" in told


def test_overtaken_waves_move_the_ship_as_little_as_their_length_says():
    found = rao(SHIP, speeds=12.0, headings_deg=0.0, omega=np.linspace(1.6, 2.0, 5))
    assert (found.encounter < 0).all()
    assert np.abs(found.mode("heave")).max() < 0.1


def test_heave_at_a_point_is_heave_less_its_lever_times_pitch():
    found = rao(SHIP, speeds=5.0, headings_deg=150.0, omega=[0.6, 0.9])
    forward = 40.0 - SHIP.hydrostatics.xB
    wanted = found.mode("heave") - forward * found.mode("pitch") + 3.0 * found.mode("roll")
    np.testing.assert_allclose(found.at_point(40.0, 3.0)[2], wanted)


def test_what_is_assumed_is_said():
    told = " ".join(rao(SHIP, speeds=0.0, omega=[0.5]).notes)
    for word in ("GM is assumed", "pitch is assumed", "roll damping", "Lewis forms"):
        assert word in told


@pytest.mark.parametrize(
    ("asked", "says"),
    [
        ({"speeds": -1.0}, "Speeds"),
        ({"speeds": 0.0, "omega": [0.5, 0.4]}, "rising"),
        ({"speeds": 0.0, "headings_deg": np.nan}, "Headings"),
        ({"speeds": 0.0, "loading": Loading(KG=20.0, kxx=6, kyy=25, kzz=25)}, "upright"),
    ],
)
def test_what_cannot_be_is_refused(asked, says):
    with pytest.raises(DataError, match=says):
        rao(SHIP, **asked)


def test_loadings_that_contradict_are_refused():
    with pytest.raises(DataError, match="contradict"):
        Loading.of(SHIP, GM=1.0, KG=2.0)


BEAM = {"speeds": 0.0, "headings_deg": 90.0}
ROLLING = np.linspace(0.3, 0.7, 41)


def rolled(waves=None, sea=None, **damping):
    loading = Loading.of(SHIP, GM=1.2, **damping)
    return rao(SHIP, **BEAM, omega=ROLLING, loading=loading, waves=waves, sea=sea)


@pytest.mark.slow
def test_roll_at_resonance_falls_with_damping_and_far_above_it_does_not():
    little, much = (
        np.abs(rolled(roll_damping=damping).mode("roll")[0, 0]) for damping in (0.02, 0.1)
    )
    assert little.max() > 2.5 * much.max()
    assert little[-1] == pytest.approx(much[-1], rel=0.1)


@pytest.mark.slow
def test_quadratic_damping_takes_the_energy_of_its_cube():
    """Per cycle ∮B₂φ̇²|φ̇|dt = (8/3π)·π·B₂(ωφ)³/ω: its linear form is found again by hand."""
    found = rolled(waves=2.0, roll_damping=0.02, roll_quadratic=0.5)
    peak = int(np.argmax(np.abs(found.mode("roll"))))
    amplitude = 2.0 * np.abs(found.mode("roll")[0, 0, peak])
    t = np.linspace(0, 2 * np.pi / ROLLING[peak], 4001)
    rate = ROLLING[peak] * amplitude * np.cos(ROLLING[peak] * t)
    equivalent = 0.02 + np.trapezoid(0.5 * np.abs(rate) ** 3, t) / np.trapezoid(rate**2, t)
    linear = rolled(roll_damping=equivalent)
    assert np.abs(linear.mode("roll")[0, 0, peak]) == pytest.approx(amplitude / 2.0, rel=1e-4)


@pytest.mark.slow
def test_higher_waves_roll_less_for_their_height():
    low, high = (rolled(waves=a, roll_damping=0.02, roll_quadratic=0.5) for a in (0.2, 3.0))
    assert np.abs(low.mode("roll")).max() > 1.2 * np.abs(high.mode("roll")).max()


@pytest.mark.slow
def test_in_a_sea_the_damping_is_that_of_its_own_rate_of_roll():
    """B₁ + √(8/π) σ B₂, the same at all frequencies."""
    waves = Sea(Hs=4.0, Tp=12.0)
    found = rolled(sea=waves, roll_damping=0.02, roll_quadratic=0.5)
    rate = np.abs(ROLLING * found.mode("roll")[0, 0])
    sigma = np.sqrt(np.trapezoid(rate**2 * waves.spectrum(ROLLING), ROLLING))
    linear = rolled(roll_damping=0.02 + 0.5 * np.sqrt(8 / np.pi) * sigma)
    np.testing.assert_allclose(linear.motion, found.motion, rtol=1e-4, atol=1e-9)


def test_quadratic_damping_without_waves_is_refused():
    with pytest.raises(DataError, match="waves="):
        rolled(roll_quadratic=0.5)
